//! Document → Scene: modifiers, aliases, types and patterns resolved; everything a surface is made of, ready to be built into a world.
//!
//! Only what a surface uses is resolved: an unused material may be anything.

mod build;

use crate::error::{Error, Result, Source, Span};
use crate::expand::{Annotation, Flat};
use crate::geometry::{Mesh, Shape};
use crate::material::Material;
use crate::pattern::{Mixture, Pattern, Texture};
use crate::rad::{Primitive, likely};
use crate::resolve::Resolve;
use crate::transform::Transform;
use crate::vector::Vec3;
use build::Builder;
use std::sync::Arc;

/// What a scene is made of.
#[derive(Default)]
pub struct Scene {
    /// Surfaces that can be hit, in file order.
    pub surfaces: Vec<Surface>,
    /// Distant sources, in file order.
    pub sources: Vec<Distant>,
    /// Resolved modifiers. Each definition has one chain, so that equal places mean the same modifier.
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
    /// Where it is defined.
    pub place: Span,
    /// Its type and numbers.
    pub material: Material,
    /// The tangent of an anisotropic lobe.
    pub orientation: Option<Texture>,
    /// The modifier a mirror or illum names as its alternate; what shades the cuts of antimatter.
    pub alternate: Option<ChainId>,
    /// Antimatter: the modifiers of what is not there inside of it.
    pub removes: Vec<ChainId>,
}

/// A surface.
pub struct Surface {
    /// Its identifier.
    pub name: String,
    /// The name of its modifier.
    pub modifier: String,
    /// Where it is described.
    pub place: Span,
    /// Where it is.
    pub form: Form,
    /// What it is made of: one chain, or one for each material of a mesh; none for an instance whose parts have their own.
    pub chains: Vec<ChainId>,
}

/// Where a surface is.
pub enum Form {
    /// Given by its numbers.
    Shape(Shape),
    /// A mesh, placed.
    Mesh(Arc<Mesh>, Transform),
    /// The surfaces of another scene, placed.
    Group(Arc<Vec<Surface>>, Transform),
}

/// A `source`: a cone of directions.
pub struct Distant {
    /// Its identifier.
    pub name: String,
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
    /// The name of the modifier; empty for none.
    pub name: String,
    /// The place of its definition among all: later ones win where surfaces coincide.
    pub order: u32,
    /// Patterns and textures, outermost first.
    pub links: Vec<Link>,
    /// How many of them stand before the material.
    pub before: usize,
    /// What they act on.
    pub end: End,
}

impl Chain {
    /// Whether its textures only smooth a surface, so that light passes straight through: RADIANCE takes that from the name that genrev and
    /// gensurf give the modifier (measured with 6.0a: glass, trans and trans2 by the name of the surface's own modifier; dielectric bends).
    pub fn smooths(&self) -> bool {
        self.name == "Phong"
    }
}

/// A pattern or texture.
#[derive(Clone)]
pub enum Link {
    /// Multiplies the colour.
    Pattern(Arc<Pattern>),
    /// Perturbs the normal.
    Texture(Arc<Texture>),
    /// A mixture of patterns and textures: the links of the foreground and of the background.
    Mixture(Arc<(Mixture, Vec<Link>, Vec<Link>)>),
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

/// How a description is read.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Whether surfaces whose material is not rendered are left out, with a warning, instead of refused.
    pub skip_unsupported: bool,
    /// Definitions that the expressions in it may use: texts in the language of function files.
    pub definitions: Vec<Arc<Source>>,
    /// The material that stands for those of its name in octrees and meshes too.
    pub unknown: Option<String>,
}

impl Scene {
    /// The scene that `flat` describes.
    pub fn new(flat: &Flat, resolve: &dyn Resolve, reading: &Reading) -> Result<Self> {
        let mut builder = Builder::new(resolve, reading.skip_unsupported);
        builder.unknown.clone_from(&reading.unknown);
        for text in &reading.definitions {
            builder.define_names(text.clone())?;
        }
        builder.scene.warnings.clone_from(&flat.warnings);
        let mut surfaces = Vec::new();
        for primitive in &flat.primitives {
            surfaces.extend(builder.add(primitive)?);
        }
        probes(&flat.annotations).try_for_each(|probe| builder.probe(probe))?;
        builder.scene.warnings.extend(misspelt(&flat.annotations).map(|error| error.remark()));
        Ok(Self { surfaces, ..builder.scene })
    }

    /// All that [`Scene::new`] would refuse in these primitives, without what is only not supported.
    pub fn problems<'a>(primitives: impl Iterator<Item = &'a Primitive>, annotations: &[Annotation], resolve: &dyn Resolve) -> Vec<Error> {
        let mut builder = Builder::new(resolve, true);
        let mut errors = Vec::new();
        for primitive in primitives {
            errors.extend(builder.add(primitive).err());
            errors.append(&mut builder.further);
        }
        errors.extend(probes(annotations).filter_map(|probe| builder.probe(probe).err()));
        errors
    }

    /// The material that a primitive defines, if a surface uses it. Others, in meshes and octrees, may have its name.
    pub fn material(&self, primitive: &Primitive) -> Option<MaterialId> {
        self.materials.iter().rposition(|m| m.place.is(&primitive.span))
    }
}

/// The word of the annotations that say where environment maps were measured.
const PROBE: &str = "probe";

/// The places where environment maps were measured, among annotations.
fn probes(annotations: &[Annotation]) -> impl Iterator<Item = &Annotation> {
    annotations.iter().filter(|a| a.word == PROBE)
}

/// What is wrong with annotations that are hardly meant to be comments.
pub fn misspelt(annotations: &[Annotation]) -> impl Iterator<Item = Error> {
    let meant = |a: &&Annotation| a.word != PROBE && likely(&a.word, std::iter::once(PROBE)).is_some();
    annotations.iter().filter(meant).map(|a| a.span.error(format!("#@{} says nothing; write #@{PROBE} for a measured place", a.word)))
}
