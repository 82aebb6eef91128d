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
        let mut library = Library::new();
        let mut builder = Builder { definitions: Vec::new(), names: HashMap::new(), chains: HashMap::new(), meshes: HashMap::new(), scene: Self::default() };
        builder.scene.warnings.clone_from(&flat.warnings);
        for primitive in &flat.primitives {
            let added = if primitive.class() == Class::Surface {
                builder.surface(primitive, resolve, &mut library)
            } else {
                builder.define(primitive);
                Ok(())
            };
            match added {
                Err(Unresolved::Unsupported(error)) if skip_unsupported => builder.scene.warnings.push(format!("left out: {}", error.message)),
                Err(Unresolved::Unsupported(error) | Unresolved::Wrong(error)) => return Err(error),
                Ok(()) => {}
            }
        }
        for annotation in flat.annotations.iter().filter(|a| a.word == "probe") {
            let probe = builder.probe(annotation, resolve, &mut library)?;
            builder.scene.probes.push(probe);
        }
        Ok(builder.scene)
    }
}
