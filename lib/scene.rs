//! Document → Scene: modifiers, aliases, types and patterns resolved; everything a surface is made of, ready to be built into a world.
//!
//! Only what a surface uses is resolved: an unused material may be anything (semantics 1.2).

use crate::error::{Error, Result};
use crate::expand::{Annotation, Flat};
use crate::geometry::{Mesh, Shape};
use crate::import::{self, MeshFile, MeshMaterial};
use crate::material::Material;
use crate::pattern::{Mixture, Pattern, Sources, Texture};
use crate::rad::{Class, Document, Primitive};
use crate::resolve::Resolve;
use crate::support::unsupported;
use crate::transform::Transform;
use crate::vector::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// What a scene is made of.
#[derive(Default)]
pub struct Scene {
    /// Surfaces that can be hit, in file order.
    pub surfaces: Vec<Surface>,
    /// Distant sources, in file order.
    pub sources: Vec<Distant>,
    /// Resolved modifiers.
    pub chains: Vec<Chain>,
    /// Materials that surfaces use.
    pub materials: Vec<Named>,
    /// Where environment maps were measured: a place, and the chain of its glow.
    pub probes: Vec<(Vec3, ChainId)>,
    /// What was left out or is doubtful, for a person to read.
    pub warnings: Vec<String>,
}

/// The place of a chain in [`Scene::chains`].
pub type ChainId = usize;

/// The place of a material in [`Scene::materials`].
pub type MaterialId = usize;

/// A material by name.
pub struct Named {
    /// Its identifier.
    pub name: String,
    /// Its type and numbers.
    pub material: Material,
    /// The tangent of an anisotropic lobe.
    pub orientation: Option<Texture>,
    /// The modifier a mirror or illum names as its alternate.
    pub alternate: Option<ChainId>,
    /// The place of its definition among the primitives: later ones win ties.
    pub order: u32,
}

/// A surface.
pub struct Surface {
    /// Its identifier.
    pub name: String,
    /// The name of its modifier.
    pub modifier: String,
    /// Where it is.
    pub form: Form,
    /// What it is made of: one chain, or one for each material of a mesh.
    pub chains: Vec<ChainId>,
}

/// Where a surface is.
pub enum Form {
    /// Given by its numbers.
    Shape(Shape),
    /// A mesh, placed.
    Mesh(Arc<Mesh>, Transform),
}

/// A `source`: a cone of directions.
pub struct Distant {
    /// Its identifier.
    pub name: String,
    /// The name of its modifier.
    pub modifier: String,
    /// Unit vector to it.
    pub direction: Vec3,
    /// 1 − cos of half its angle.
    pub spread: f64,
    /// What it is made of.
    pub chain: ChainId,
}

/// A modifier with all that is behind it.
#[derive(Default)]
pub struct Chain {
    /// Patterns and textures, outermost first.
    pub links: Vec<Link>,
    /// What they act on.
    pub end: End,
}

/// A pattern or texture.
#[derive(Clone)]
pub enum Link {
    /// Multiplies the colour.
    Pattern(Arc<Pattern>),
    /// Perturbs the normal.
    Texture(Arc<Texture>),
}

/// Where a chain ends.
#[derive(Default)]
pub enum End {
    /// Nothing: the surface is not there.
    #[default]
    Void,
    /// A material.
    Material(MaterialId),
    /// The share of the first chain; the rest is of the second.
    Mixture(Arc<Mixture>, ChainId, ChainId),
}

impl Scene {
    /// The scene that `flat` describes. With `skip_unsupported`, surfaces whose material is not rendered are left out, with a warning.
    pub fn new<'a>(flat: &'a Flat, resolve: &'a dyn Resolve, skip_unsupported: bool) -> Result<Self> {
        let mut builder = Builder {
            resolve,
            sources: Sources::new(resolve),
            definitions: Vec::new(),
            names: HashMap::new(),
            chains: HashMap::new(),
            materials: HashMap::new(),
            links: HashMap::new(),
            meshes: HashMap::new(),
            scene: Self::default(),
        };
        builder.scene.warnings.clone_from(&flat.warnings);
        for primitive in &flat.primitives {
            let Some(class) = primitive.type_of().map(|t| t.class) else {
                return Err(primitive.error(format!("{} is not a type of RADIANCE's", primitive.kind)));
            };
            let added = if class == Class::Surface { builder.surface(primitive) } else { builder.define(primitive).map(|_| ()) };
            match added {
                Err(Unresolved::Unsupported(error)) if skip_unsupported => {
                    builder.scene.warnings.push(format!("left out: {}", error.message))
                }
                Err(Unresolved::Unsupported(error) | Unresolved::Wrong(error)) => return Err(error),
                Ok(()) => {}
            }
        }
        for annotation in flat.annotations.iter().filter(|a| a.word == "probe") {
            builder.probe(annotation)?;
        }
        Ok(builder.scene)
    }

    /// The material called `name`, if a surface uses it.
    pub fn material(&self, name: &str) -> Option<MaterialId> {
        self.materials.iter().rposition(|m| m.name == name)
    }
}

/// Why something could not be resolved.
enum Unresolved {
    /// RADIANCE can render it, this program cannot.
    Unsupported(Error),
    /// It is wrong.
    Wrong(Error),
}

impl From<Error> for Unresolved {
    fn from(error: Error) -> Self {
        Self::Wrong(error)
    }
}

/// The place of a definition.
type DefinitionId = usize;

/// A modifier that was defined: what it is, and what is behind it.
#[derive(Clone)]
struct Definition {
    primitive: Arc<Primitive>,
    behind: Option<DefinitionId>,
    /// How many definitions stood before it: names in its strings mean the latest of those (semantics 1.3).
    order: u32,
}

/// A mesh that was read, and the chains of its own materials.
struct Model {
    mesh: Arc<Mesh>,
    materials: Vec<MeshMaterial>,
    /// For each primitive that the file brought along: its chain, if it is a modifier that a triangle uses.
    embedded: HashMap<usize, ChainId>,
}

/// A scene in the making.
struct Builder<'a> {
    resolve: &'a dyn Resolve,
    sources: Sources<'a>,
    definitions: Vec<Definition>,
    /// Every definition of each name, in order.
    names: HashMap<String, Vec<DefinitionId>>,
    chains: HashMap<Option<DefinitionId>, ChainId>,
    materials: HashMap<*const Primitive, MaterialId>,
    links: HashMap<*const Primitive, Link>,
    meshes: HashMap<String, Arc<Model>>,
    scene: Scene,
}

impl<'a> Builder<'a> {
    /// The latest definition of `name` before the definition `before`.
    fn find(&self, name: &str, before: usize) -> Option<DefinitionId> {
        self.names.get(name)?.iter().rev().copied().find(|&d| d < before)
    }

    /// The modifier of a primitive.
    fn modifier(&self, primitive: &Primitive) -> Result<Option<DefinitionId>> {
        match primitive.modifier.as_str() {
            "void" => Ok(None),
            name => match self.find(name, self.definitions.len()) {
                Some(definition) => Ok(Some(definition)),
                None => {
                    Err(primitive.modifier_error(format!("no modifier `{name}` is defined before this; define it above, or write void")))
                }
            },
        }
    }

    /// Takes a modifier in. An alias stands for what it names, or for that with another modifier (semantics 1.4).
    fn define(&mut self, primitive: &Primitive) -> std::result::Result<DefinitionId, Unresolved> {
        let order = self.definitions.len() as u32;
        let definition = if primitive.kind == "alias" {
            let target = primitive.strings.first().map_or("", String::as_str);
            let Some(found) = self.find(target, self.definitions.len()) else {
                return Err(primitive.string_error(0, format!("no modifier `{target}` is defined before this alias")).into());
            };
            let named = self.definitions[found].clone();
            let behind = if primitive.modifier == "inherit" { named.behind } else { self.modifier(primitive)? };
            Definition { behind, ..named }
        } else {
            Definition { primitive: Arc::new(primitive.clone()), behind: self.modifier(primitive)?, order }
        };
        self.names.entry(primitive.name.clone()).or_default().push(self.definitions.len());
        self.definitions.push(definition);
        Ok(self.definitions.len() - 1)
    }

    /// Takes a surface in.
    fn surface(&mut self, primitive: &Primitive) -> std::result::Result<(), Unresolved> {
        let modifier = self.modifier(primitive)?;
        let chain = self.chain(modifier)?;
        let (name, modifier_name) = (primitive.name.clone(), primitive.modifier.clone());
        match primitive.kind.as_str() {
            "source" => {
                let [x, y, z, angle] = primitive.reals[..] else { return Err(primitive.error("a source needs 4 real arguments").into()) };
                let direction = Vec3::new(x, y, z);
                if !(direction.length() > 0.0) {
                    return Err(primitive.real_error(0, "the direction of a source must not be zero").into());
                }
                if !(angle > 0.0) {
                    return Err(primitive.real_error(3, "the angle of a source must be above 0").into());
                }
                let spread = 1.0 - (angle.to_radians() / 2.0).cos();
                self.scene.sources.push(Distant { name, modifier: modifier_name, direction: direction.normalize(), spread, chain });
            }
            "mesh" => {
                let model = self.model(primitive)?;
                let (transform, _) = Transform::parse(&primitive.strings[1..]).map_err(|e| primitive.string_error(1, e.message))?;
                let chains = match modifier {
                    Some(_) => vec![chain],
                    None => self.own(primitive, &model)?,
                };
                self.scene.surfaces.push(Surface {
                    name,
                    modifier: modifier_name,
                    form: Form::Mesh(model.mesh.clone(), transform),
                    chains,
                });
            }
            "instance" => return Err(Unresolved::Unsupported(unsupported(primitive))),
            _ => {
                let shape = Shape::new(&primitive.kind, &primitive.reals, &mut self.scene.warnings).map_err(|e| primitive.error(e))?;
                if let Some(shape) = shape {
                    self.scene.surfaces.push(Surface { name, modifier: modifier_name, form: Form::Shape(shape), chains: vec![chain] });
                }
            }
        }
        Ok(())
    }

    /// The resolved form of a modifier and all behind it.
    fn chain(&mut self, modifier: Option<DefinitionId>) -> std::result::Result<ChainId, Unresolved> {
        if let Some(&known) = self.chains.get(&modifier) {
            return Ok(known);
        }
        let mut chain = Chain::default();
        let mut at = modifier;
        while let Some(id) = at {
            let Definition { primitive, behind, order } = self.definitions[id].clone();
            at = behind;
            match primitive.type_of().map(|t| t.class) {
                Some(Class::Pattern | Class::Texture) => chain.links.push(self.link(&primitive)?),
                Some(Class::Mixture) => {
                    if let End::Material(_) = chain.end {
                        continue;
                    }
                    let coefficient =
                        Mixture::compile(&primitive, &mut self.sources)?.ok_or_else(|| Unresolved::Unsupported(unsupported(&primitive)))?;
                    let mut side = |i: usize| {
                        let name = primitive.strings[i].as_str();
                        let found = if name == "void" { None } else { Some(self.late(&primitive, i, order)?) };
                        self.chain(found)
                    };
                    let (fore, back) = (side(0)?, side(1)?);
                    chain.end = End::Mixture(Arc::new(coefficient), fore, back);
                    if behind.is_some() {
                        return Err(primitive.modifier_error("a mixture of materials must have the modifier void").into());
                    }
                }
                _ => match chain.end {
                    End::Void => chain.end = End::Material(self.material(&primitive, order)?),
                    _ => {
                        return Err(primitive
                            .error(format!(
                                "conflicting material: there is another one before `{}` in the chain of modifiers",
                                primitive.name
                            ))
                            .into());
                    }
                },
            }
        }
        self.scene.chains.push(chain);
        self.chains.insert(modifier, self.scene.chains.len() - 1);
        Ok(self.scene.chains.len() - 1)
    }

    /// A modifier that a string argument names: the latest before the primitive.
    fn late(&self, primitive: &Primitive, string: usize, order: u32) -> Result<DefinitionId> {
        let name = &primitive.strings[string];
        self.find(name, order as usize)
            .ok_or_else(|| primitive.string_error(string, format!("no modifier `{name}` is defined before this")))
    }

    /// The compiled pattern or texture of a primitive.
    fn link(&mut self, primitive: &Arc<Primitive>) -> std::result::Result<Link, Unresolved> {
        if let Some(known) = self.links.get(&Arc::as_ptr(primitive)) {
            return Ok(known.clone());
        }
        let link = if let Some(pattern) = Pattern::compile(primitive, &mut self.sources)? {
            Link::Pattern(Arc::new(pattern))
        } else if let Some(texture) = Texture::compile(primitive, &mut self.sources)? {
            Link::Texture(Arc::new(texture))
        } else {
            return Err(Unresolved::Unsupported(unsupported(primitive)));
        };
        self.links.insert(Arc::as_ptr(primitive), link.clone());
        Ok(link)
    }

    /// The place of the material that a primitive defines.
    fn material(&mut self, primitive: &Arc<Primitive>, order: u32) -> std::result::Result<MaterialId, Unresolved> {
        if let Some(&known) = self.materials.get(&Arc::as_ptr(primitive)) {
            return Ok(known);
        }
        let Some(material) = Material::of(primitive)? else { return Err(Unresolved::Unsupported(unsupported(primitive))) };
        let alternate = match (&material, primitive.strings.first().map(String::as_str)) {
            (Material::Illum(_) | Material::Mirror(_), Some(name)) => {
                let found = if name == "void" { None } else { Some(self.late(primitive, 0, order)?) };
                Some(self.chain(found)?)
            }
            _ => None,
        };
        let orientation = Texture::orientation(primitive, &mut self.sources)?;
        self.scene.materials.push(Named { name: primitive.name.clone(), material, orientation, alternate, order });
        self.materials.insert(Arc::as_ptr(primitive), self.scene.materials.len() - 1);
        Ok(self.scene.materials.len() - 1)
    }

    /// The mesh file that a primitive names.
    fn model(&mut self, primitive: &Primitive) -> std::result::Result<Arc<Model>, Unresolved> {
        let Some(name) = primitive.strings.first() else { return Err(primitive.error("a mesh needs the name of its file").into()) };
        if let Some(known) = self.meshes.get(name) {
            return Ok(known.clone());
        }
        let bytes = self.resolve.library(name).map_err(|e| primitive.string_error(0, e.message))?;
        let MeshFile { mesh, materials, scene } = import::mesh(bytes, name)?;
        // What the file brings along has names of its own.
        let outside = std::mem::take(&mut self.names);
        let embedded = self.embedded(&materials, &scene);
        self.names = outside;
        let model = Arc::new(Model { mesh: Arc::new(mesh), materials, embedded: embedded? });
        self.meshes.insert(name.clone(), model.clone());
        Ok(model)
    }

    /// The chains of the materials that a mesh file brings along, as far as its triangles use them.
    fn embedded(&mut self, materials: &[MeshMaterial], scene: &Document) -> std::result::Result<HashMap<usize, ChainId>, Unresolved> {
        let mut chains = HashMap::new();
        for (number, primitive) in scene.primitives().enumerate() {
            let definition = self.define(primitive)?;
            if materials.contains(&MeshMaterial::Embedded(number)) {
                chains.insert(number, self.chain(Some(definition))?);
            }
        }
        Ok(chains)
    }

    /// The chains of a mesh's materials where it has no modifier of its own.
    fn own(&mut self, primitive: &Primitive, model: &Model) -> std::result::Result<Vec<ChainId>, Unresolved> {
        let mut chains = Vec::new();
        for material in &model.materials {
            chains.push(match material {
                MeshMaterial::Void => self.chain(None)?,
                MeshMaterial::Embedded(number) => model.embedded[number],
                MeshMaterial::Named(name) => match self.find(name, self.definitions.len()) {
                    Some(definition) => self.chain(Some(definition))?,
                    None => {
                        return Err(primitive
                            .string_error(0, format!("the mesh uses a modifier `{name}`, which is not defined before this"))
                            .into());
                    }
                },
            });
        }
        Ok(if chains.is_empty() { vec![self.chain(None)?] } else { chains })
    }

    /// A measured place of an environment map: `#@probe X Y Z GLOW_ID`.
    fn probe(&mut self, annotation: &Annotation) -> Result<()> {
        let wrong = || annotation.span.error("a probe is written #@probe X Y Z GLOW_ID");
        let [x, y, z, name] = &annotation.arguments[..] else { return Err(wrong()) };
        let number = |word: &String| word.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(wrong);
        let place = Vec3::new(number(x)?, number(y)?, number(z)?);
        let Some(glow) = self.find(name, self.definitions.len()) else {
            return Err(annotation.span.error(format!("no glow `{name}` is defined")));
        };
        let chain = self.chain(Some(glow)).map_err(|e| match e {
            Unresolved::Unsupported(error) | Unresolved::Wrong(error) => error,
        })?;
        self.scene.probes.push((place, chain));
        Ok(())
    }
}
