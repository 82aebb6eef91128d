//! A scene in the making: names are looked up as RADIANCE looks them up, each modifier is resolved once.

mod files;

use super::{Chain, ChainId, Distant, End, Error, Form, Link, MaterialId, Named, Result, Scene, Source, Surface};
use crate::cal::FileId;
use crate::expand::Annotation;
use crate::geometry::Shape;
use crate::material::Material;
use crate::pattern::{Mixture, Pattern, Sources, Texture};
use crate::rad::{Class, Primitive, Undefined, WEIGHT_LIMIT, real};
use crate::resolve::Resolve;
use crate::support::{Feature, unsupported};
use crate::transform::Transform;
use crate::vector::{Vec3, one_minus_cos};
use files::Model;
use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

/// Modifiers that others name as their argument, mixtures and mirrors among them, may stand this deep within each other.
const DEPTH_LIMIT: usize = 32;

/// Why something could not be resolved.
#[derive(Clone)]
pub(super) enum Unresolved {
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

impl From<Unresolved> for Error {
    fn from(unresolved: Unresolved) -> Self {
        match unresolved {
            Unresolved::Unsupported(error) => {
                Self { message: format!("{}; replace it, or leave its surfaces out with --skip-unsupported", error.message), ..error }
            }
            Unresolved::Wrong(error) => error,
        }
    }
}

type Resolved<T> = std::result::Result<T, Unresolved>;

/// The place of a definition.
type DefinitionId = usize;

/// A modifier that was defined: what it is, and what is behind it.
#[derive(Clone)]
struct Definition {
    name: String,
    primitive: Rc<Primitive>,
    behind: Option<DefinitionId>,
    /// How many definitions stood before it: names in its strings mean the latest of those.
    order: u32,
}

/// Every definition of each name, in order: what names mean in one scene, mesh or octree.
type Names = HashMap<String, Vec<DefinitionId>>;

/// A scene in the making.
pub(super) struct Builder<'a> {
    pub scene: Scene,
    /// What else is wrong with chains of modifiers, beside the error that resolving them came to.
    pub further: Vec<Error>,
    /// The name of the material that stands for those of its name in octrees and meshes too.
    pub unknown: Option<String>,
    /// And its definition, in such a file.
    standing: Option<Definition>,
    resolve: &'a dyn Resolve,
    skip_unsupported: bool,
    sources: Sources<'a>,
    definitions: Vec<Definition>,
    names: Names,
    /// What each modifier was resolved to, or why it was not.
    chains: HashMap<Option<DefinitionId>, Resolved<ChainId>>,
    /// For each chain of the scene, how many patterns, textures and mixtures it leads through.
    weights: Vec<usize>,
    materials: HashMap<*const Primitive, MaterialId>,
    links: HashMap<*const Primitive, Link>,
    models: HashMap<String, Rc<Model>>,
    groups: HashMap<String, Arc<Vec<Surface>>>,
    undefined: Undefined,
    /// The octrees that are being read, one within another.
    within: Vec<String>,
    /// Chains that are being resolved, one within another.
    depth: usize,
}

impl<'a> Builder<'a> {
    pub fn new(resolve: &'a dyn Resolve, skip_unsupported: bool) -> Self {
        Self {
            scene: Scene::default(),
            further: Vec::new(),
            unknown: None,
            standing: None,
            resolve,
            skip_unsupported,
            sources: Sources::new(resolve),
            definitions: Vec::new(),
            names: HashMap::new(),
            chains: HashMap::new(),
            weights: Vec::new(),
            materials: HashMap::new(),
            links: HashMap::new(),
            models: HashMap::new(),
            groups: HashMap::new(),
            undefined: Undefined::default(),
            within: Vec::new(),
            depth: 0,
        }
    }

    /// Takes definitions in that all expressions may use.
    pub fn define_names(&mut self, text: Arc<Source>) -> Result<()> {
        self.sources.library.define(text, FileId::GLOBAL)
    }

    /// Turns what cannot be rendered into a warning, if that was asked for.
    fn forgive(&mut self, added: Resolved<()>) -> Result<()> {
        match added {
            Err(Unresolved::Unsupported(error)) if self.skip_unsupported => {
                self.scene.warnings.push(format!("left out: {}", error.remark()));
                Ok(())
            }
            other => other.map_err(Error::from),
        }
    }

    /// The latest definition of `name` before the definition `before`.
    fn find(&self, name: &str, before: usize) -> Option<DefinitionId> {
        let rising = self.names.get(name)?;
        rising[..rising.partition_point(|&d| d < before)].last().copied()
    }

    /// The modifier of a primitive.
    fn modifier(&self, primitive: &Primitive) -> Result<Option<DefinitionId>> {
        match primitive.modifier.as_str() {
            "void" => Ok(None),
            name => match self.find(name, self.definitions.len()) {
                Some(definition) => Ok(Some(definition)),
                None => Err(primitive.modifier_error(format!("{}; define it above, or write void", self.undefined(name)))),
            },
        }
    }

    /// Begins with the names of a file of its own; what they were before.
    fn inside(&mut self) -> Names {
        let standing = self.unknown.as_ref().and_then(|name| self.find(name, self.definitions.len()));
        self.standing = standing.map(|definition| self.definitions[definition].clone()).or(self.standing.take());
        std::mem::take(&mut self.names)
    }

    /// Goes on with the names of before.
    fn outside(&mut self, names: Names) {
        self.names = names;
        if self.within.is_empty() {
            self.standing = None;
        }
    }

    /// What is wrong with a name that no modifier has so far.
    fn undefined(&self, name: &str) -> String {
        self.undefined.said(name, self.names.keys().map(|known| &**known))
    }

    /// Takes a modifier in. Even one that is wrong is known by its name from then on, so that its users are not wrong too.
    pub fn define(&mut self, primitive: &Primitive) -> Result<()> {
        let name = || primitive.name.clone();
        let (definition, wrong) = match self.definition(primitive) {
            Ok(definition) => (Definition { name: name(), ..definition }, Ok(())),
            Err(error) => (self.written(primitive, None), Err(error)),
        };
        self.names.entry(name()).or_default().push(self.definitions.len());
        self.definitions.push(definition);
        wrong
    }

    /// What a modifier is. An alias stands for what it names, or for that with another modifier.
    fn definition(&self, primitive: &Primitive) -> Result<Definition> {
        let is_material = primitive.type_of().is_some_and(|t| t.class == Class::Material);
        if let Some(standing) = self.standing.as_ref().filter(|standing| is_material && standing.name == primitive.name) {
            return Ok(standing.clone());
        }
        if primitive.kind != "alias" {
            return Ok(self.written(primitive, self.modifier(primitive)?));
        }
        let target = primitive.strings.first().map_or("", String::as_str);
        let Some(found) = self.find(target, self.definitions.len()) else {
            return Err(primitive.string_error(0, self.undefined(target)));
        };
        let named = self.definitions[found].clone();
        let behind = if primitive.modifier == "inherit" { named.behind } else { self.modifier(primitive)? };
        Ok(Definition { behind, ..named })
    }

    /// The next definition, as it is written, with this behind it.
    fn written(&self, primitive: &Primitive, behind: Option<DefinitionId>) -> Definition {
        let order = self.definitions.len() as u32;
        Definition { name: primitive.name.clone(), primitive: Rc::new(primitive.clone()), behind, order }
    }

    /// Takes a primitive in; what it gives if it is a surface.
    pub fn add(&mut self, primitive: &Primitive) -> Result<Option<Surface>> {
        let Some(class) = primitive.type_of().map(|t| t.class) else {
            return Err(primitive.error(format!("{} is not a type of RADIANCE's", primitive.kind)));
        };
        let mut surface = None;
        let added = match (class, primitive.kind.as_str()) {
            (Class::Surface, "source") => self.source(primitive),
            (Class::Surface, _) => self.surface(primitive).map(|found| surface = found),
            _ => self.define(primitive).map_err(Unresolved::Wrong),
        };
        self.forgive(added)?;
        Ok(surface)
    }

    /// Takes a distant source in.
    fn source(&mut self, primitive: &Primitive) -> Resolved<()> {
        let modifier = self.modifier(primitive)?;
        let chain = self.chain(modifier)?;
        primitive.complete_reals()?;
        let (direction, angle) = (Vec3::from_slice(&primitive.reals[..3]), primitive.reals[3]);
        let Some(direction) = direction.try_normalize() else {
            return Err(primitive
                .real_error(0, "a source must have a direction, not of the length 0, nor out of the range of numbers")
                .into());
        };
        if !(angle > 0.0) {
            return Err(primitive.real_error(3, "the angle of a source must be above 0").into());
        }
        self.scene.sources.push(Distant {
            name: primitive.name.clone(),
            direction,
            spread: one_minus_cos(angle.to_radians() / 2.0),
            chain,
        });
        Ok(())
    }

    /// The surface that a primitive describes; `None` if it is none, as a ring without width.
    fn surface(&mut self, primitive: &Primitive) -> Resolved<Option<Surface>> {
        let modifier = self.modifier(primitive)?;
        let own = match modifier {
            Some(_) => Some(self.chain(modifier)?),
            None => None,
        };
        let placed = || Transform::of(primitive, 1);
        let (form, chains) = match primitive.kind.as_str() {
            "mesh" => {
                let transform = placed()?;
                let model = self.model(primitive)?;
                let chains = if let Some(chain) = own { vec![chain] } else { self.embedded(primitive, &model)? };
                (Form::Mesh(model.mesh.clone(), transform), chains)
            }
            "instance" => (Form::Group(self.group(primitive)?, placed()?), own.into_iter().collect()),
            kind => {
                let mut warnings = Vec::new();
                let shape = Shape::new(kind, &primitive.reals, &mut warnings).map_err(|e| primitive.error(e))?;
                self.scene.warnings.extend(warnings.into_iter().map(|warning| primitive.error(warning).remark()));
                let Some(shape) = shape else { return Ok(None) };
                (Form::Shape(shape), vec![self.chain(modifier)?])
            }
        };
        let (name, modifier, place) = (primitive.name.clone(), primitive.modifier.clone(), primitive.word_span(1));
        Ok(Some(Surface { name, modifier, place, form, chains }))
    }

    /// The resolved form of a modifier and all behind it.
    fn chain(&mut self, modifier: Option<DefinitionId>) -> Resolved<ChainId> {
        if let Some(known) = self.chains.get(&modifier) {
            return known.clone();
        }
        if let Some(id) = modifier.filter(|_| self.depth == DEPTH_LIMIT) {
            let message = format!("modifiers name each other as arguments more than {DEPTH_LIMIT} deep");
            return Err(self.definitions[id].primitive.error(message).into());
        }
        self.depth += 1;
        let built = self.new_chain(modifier);
        self.depth -= 1;
        self.chains.insert(modifier, built.clone());
        built
    }

    fn new_chain(&mut self, modifier: Option<DefinitionId>) -> Resolved<ChainId> {
        let mut chain = Chain::default();
        if let Some(id) = modifier {
            (chain.name, chain.order) = (self.definitions[id].name.clone(), id as u32);
        }
        let (mut at, mut weight, mut wrong) = (modifier, 0, None);
        while let Some(id) = at {
            let definition = self.definitions[id].clone();
            at = definition.behind;
            let joined = self.join(&mut chain, &definition);
            weight += self.first(&mut wrong, joined).unwrap_or(0);
            if weight > WEIGHT_LIMIT {
                let message = format!("more than {WEIGHT_LIMIT} patterns, textures, mixtures and alternates in one chain");
                return Err(definition.primitive.error(message).into());
            }
        }
        wrong.map_or(Ok(()), Err)?;
        self.scene.chains.push(chain);
        self.weights.push(weight);
        Ok(self.scene.chains.len() - 1)
    }

    /// What was found; if it is wrong, the first such error is kept there, and others are noted.
    fn first<T>(&mut self, wrong: &mut Option<Unresolved>, found: Resolved<T>) -> Option<T> {
        match (found, &wrong) {
            (Ok(value), _) => return Some(value),
            (Err(error), None) => *wrong = Some(error),
            (Err(Unresolved::Wrong(error)), _) => self.further.push(error),
            _ => {}
        }
        None
    }

    /// Adds a modifier to a chain, and tells through how many patterns, textures, mixtures and alternates it leads.
    fn join(&mut self, chain: &mut Chain, definition: &Definition) -> Resolved<usize> {
        let Definition { primitive, behind, order, .. } = definition;
        match primitive.type_of().map(|t| t.class) {
            Some(Class::Pattern | Class::Texture) => {
                chain.links.push(self.link(primitive)?);
                Ok(1)
            }
            Some(Class::Mixture) => self.mixture(chain, primitive, *behind, *order),
            _ if matches!(chain.end, End::Void) => {
                chain.before = chain.links.len();
                let material = self.material(primitive, *order)?;
                chain.end = End::Material(material);
                Ok(self.scene.materials[material].alternate.map_or(0, |chain| 1 + self.weights[chain]))
            }
            _ => Err(conflict(primitive).into()),
        }
    }

    /// Adds a mixture to a chain, of materials as its end, of patterns and textures as a link; and tells through how many of them it leads.
    fn mixture(&mut self, chain: &mut Chain, primitive: &Rc<Primitive>, behind: Option<DefinitionId>, order: u32) -> Resolved<usize> {
        let coefficient = Mixture::compile(primitive, &mut self.sources)?.ok_or_else(|| Unresolved::Unsupported(unsupported(primitive)))?;
        let (fore, back) = match [0, 1].map(|string| self.side(primitive, string, order)) {
            [Ok(fore), Ok(back)] => (fore, back),
            [Err(error), other] | [other, Err(error)] => {
                self.first(&mut Some(error.clone()), other);
                return Err(error);
            }
        };
        let weight = 1 + self.weights[fore] + self.weights[back];
        let [a, b] = [fore, back].map(|side| &self.scene.chains[side]);
        if let (End::Void, End::Void) = (&a.end, &b.end) {
            chain.links.push(Link::Mixture(Arc::new((coefficient, a.links.clone(), b.links.clone()))));
            return Ok(weight);
        }
        if !matches!(chain.end, End::Void) {
            return Err(conflict(primitive).into());
        }
        if behind.is_some() {
            return Err(primitive.modifier_error("a mixture of materials must have the modifier void").into());
        }
        chain.before = chain.links.len();
        chain.end = End::Mixture(Arc::new(coefficient), fore, back);
        Ok(weight)
    }

    /// The chain that a mixture's string argument names.
    fn side(&mut self, primitive: &Primitive, string: usize, order: u32) -> Resolved<ChainId> {
        let void = primitive.strings[string] == "void";
        let found = if void { None } else { Some(self.late(primitive, string, order)?) };
        self.chain(found)
    }

    /// A modifier that a string argument names: the latest before the primitive.
    fn late(&self, primitive: &Primitive, string: usize, order: u32) -> Result<DefinitionId> {
        let name = &primitive.strings[string];
        self.find(name, order as usize).ok_or_else(|| primitive.string_error(string, self.undefined(name)))
    }

    /// The compiled pattern or texture of a primitive.
    fn link(&mut self, primitive: &Rc<Primitive>) -> Resolved<Link> {
        if let Some(known) = self.links.get(&Rc::as_ptr(primitive)) {
            return Ok(known.clone());
        }
        let link = if let Some(pattern) = Pattern::compile(primitive, &mut self.sources)? {
            Link::Pattern(Arc::new(pattern))
        } else if let Some(texture) = Texture::compile(primitive, &mut self.sources)? {
            Link::Texture(Arc::new(texture))
        } else {
            return Err(Unresolved::Unsupported(unsupported(primitive)));
        };
        self.links.insert(Rc::as_ptr(primitive), link.clone());
        Ok(link)
    }

    /// The place of the material that a primitive defines.
    fn material(&mut self, primitive: &Rc<Primitive>, order: u32) -> Resolved<MaterialId> {
        if let Some(&known) = self.materials.get(&Rc::as_ptr(primitive)) {
            return Ok(known);
        }
        let unsupported = || Unresolved::Unsupported(unsupported(primitive));
        if Feature::of(&primitive.kind).is_some_and(|feature| !feature.rendered) {
            return Err(unsupported());
        }
        let material = Material::of(primitive, &mut self.sources)?.ok_or_else(unsupported)?;
        let alternate = match (&material, primitive.strings.first().map(String::as_str)) {
            // An unknown name removes nothing, and shades nothing.
            (Material::Antimatter, Some(name)) => match self.find(name, order as usize) {
                Some(found) => Some(self.chain(Some(found))?),
                None => None,
            },
            (Material::Illum(_) | Material::Mirror(_), Some(name)) => {
                let found = if name == "void" { None } else { Some(self.late(primitive, 0, order)?) };
                Some(self.chain(found)?)
            }
            _ => None,
        };
        let mut removes = Vec::new();
        if let Material::Antimatter = material {
            for (i, name) in primitive.strings.iter().enumerate().filter(|(_, name)| *name != "void") {
                match self.find(name, order as usize) {
                    Some(found) => removes.push(self.chain(Some(found))?),
                    None => self.scene.warnings.push(primitive.string_error(i, self.undefined(name)).remark()),
                }
            }
        }
        let orientation = Texture::orientation(primitive, &mut self.sources)?;
        let (name, place) = (primitive.name.clone(), primitive.span.clone());
        self.scene.materials.push(Named { name, place, material, orientation, alternate, removes });
        self.materials.insert(Rc::as_ptr(primitive), self.scene.materials.len() - 1);
        Ok(self.scene.materials.len() - 1)
    }

    /// A measured place of an environment map: `#@probe X Y Z GLOW_ID`.
    pub fn probe(&mut self, annotation: &Annotation) -> Result<()> {
        let wrong = || annotation.span.error("a probe is written #@probe X Y Z GLOW_ID");
        let [x, y, z, name] = &annotation.arguments[..] else { return Err(wrong()) };
        let number = |word: &String| real(word).ok_or_else(wrong);
        let place = Vec3::new(number(x)?, number(y)?, number(z)?);
        let material = self.find(name, self.definitions.len()).map(|glow| self.chain(Some(glow))).transpose()?;
        let source = self.scene.sources.iter().find(|s| s.name == *name).map(|s| s.chain);
        let glows = |chain: &ChainId| match self.scene.chains[*chain].end {
            End::Material(m) => matches!(self.scene.materials[m].material, Material::Glow(..)),
            _ => false,
        };
        let Some(chain) = material.into_iter().chain(source).find(glows) else {
            return Err(annotation.span.error(format!("`{name}` is no glow: a probe names the glow of the environment measured there")));
        };
        self.scene.probes.push((place, chain));
        Ok(())
    }
}

/// Two materials in one chain.
fn conflict(primitive: &Primitive) -> Error {
    primitive.error(format!("conflicting material: there is another one before `{}` in the chain of modifiers", primitive.name))
}
