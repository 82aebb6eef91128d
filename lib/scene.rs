//! Document → Scene: modifiers, aliases, types and patterns resolved; everything a surface is made of, ready to be built into a world.
//!
//! Only what a surface uses is resolved: an unused material may be anything (semantics 1.2).

use crate::cal::Library;
use crate::error::{Error, Result};
use crate::expand::{Annotation, Flat};
use crate::geometry::{Mesh, Shape};
use crate::import;
use crate::material::{Material, unsupported};
use crate::pattern::{Orientation, Pattern, Scalar, Texture};
use crate::rad::{Class, Primitive};
use crate::resolve::Resolve;
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
    pub orientation: Option<Orientation>,
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
    Mixture(Arc<Scalar>, ChainId, ChainId),
}

impl Scene {
    /// The scene that `flat` describes. With `skip_unsupported`, surfaces whose material is not rendered are left out, with a warning.
    pub fn new(flat: &Flat, resolve: &dyn Resolve, skip_unsupported: bool) -> Result<Self> {
        let mut builder = Builder { resolve, library: Library::new(), definitions: Vec::new(), names: HashMap::new(), chains: HashMap::new(), materials: HashMap::new(), links: HashMap::new(), meshes: HashMap::new(), scene: Self::default() };
        builder.scene.warnings.clone_from(&flat.warnings);
        for primitive in &flat.primitives {
            let Some(class) = primitive.type_of().map(|t| t.class) else { return Err(primitive.error(format!("{} is not a type of RADIANCE's", primitive.kind))) };
            let added = if class == Class::Surface { builder.surface(primitive) } else { builder.define(primitive) };
            match added {
                Err(Unresolved::Unsupported(error)) if skip_unsupported => builder.scene.warnings.push(format!("left out: {}", error.message)),
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
#[derive(Clone, Copy)]
struct Definition<'a> {
    primitive: &'a Primitive,
    behind: Option<DefinitionId>,
    /// How many definitions stood before it: names in its strings mean the latest of those (semantics 1.3).
    order: u32,
}

/// A scene in the making.
struct Builder<'a> {
    resolve: &'a dyn Resolve,
    library: Library,
    definitions: Vec<Definition<'a>>,
    /// Every definition of each name, in order.
    names: HashMap<&'a str, Vec<DefinitionId>>,
    chains: HashMap<Option<DefinitionId>, ChainId>,
    materials: HashMap<*const Primitive, MaterialId>,
    links: HashMap<*const Primitive, Link>,
    meshes: HashMap<String, Arc<import::Model>>,
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
                None => Err(primitive.modifier_error(format!("no modifier `{name}` is defined before this; define it above, or write void"))),
            },
        }
    }

    /// Takes a modifier in. An alias stands for what it names, or for that with another modifier (semantics 1.4).
    fn define(&mut self, primitive: &'a Primitive) -> std::result::Result<(), Unresolved> {
        let order = self.definitions.len() as u32;
        let definition = if primitive.kind == "alias" {
            let target = primitive.strings.first().map_or("", String::as_str);
            let Some(found) = self.find(target, self.definitions.len()) else {
                return Err(primitive.string_error(0, format!("no modifier `{target}` is defined before this alias")).into());
            };
            let named = self.definitions[found];
            let behind = if primitive.modifier == "inherit" { named.behind } else { self.modifier(primitive)? };
            Definition { behind, ..named }
        } else {
            Definition { primitive, behind: self.modifier(primitive)?, order }
        };
        self.names.entry(&primitive.name).or_default().push(self.definitions.len());
        self.definitions.push(definition);
        Ok(())
    }

    /// Takes a surface in.
    fn surface(&mut self, primitive: &'a Primitive) -> std::result::Result<(), Unresolved> {
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
                    None => self.embedded(primitive, &model)?,
                };
                self.scene.surfaces.push(Surface { name, modifier: modifier_name, form: Form::Mesh(model.mesh.clone(), transform), chains });
            }
            "instance" => return Err(Unresolved::Unsupported(unsupported(primitive))),
            _ => {
                if let Some(shape) = Shape::of(primitive, &mut self.scene.warnings)? {
                    self.scene.surfaces.push(Surface { name, modifier: modifier_name, form: Form::Shape(shape), chains: vec![chain] });
                }
            }
        }
        Ok(())
    }
}
