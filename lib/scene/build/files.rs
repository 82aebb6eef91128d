//! What files that primitives name bring into a scene: meshes, and groups of surfaces for instances.

use super::{Builder, Resolved, Unresolved};
use crate::error::Result;
use crate::expand::expand;
use crate::geometry::{LEVELS, Mesh};
use crate::import::{self, MeshFile, MeshMaterial};
use crate::rad::{Document, Primitive};
use crate::scene::{ChainId, Surface};
use std::cell::OnceCell;
use std::rc::Rc;
use std::sync::Arc;

/// A mesh of a file.
pub(super) struct Model {
    pub mesh: Arc<Mesh>,
    materials: Vec<MeshMaterial>,
    scene: Document,
    /// The chains of its materials, if they are the same wherever it stands, once something needs them.
    chains: OnceCell<Vec<ChainId>>,
}

impl Builder<'_> {
    /// The bytes of the file that a primitive names, and its name.
    fn file(&self, primitive: &Primitive) -> Result<(String, Vec<u8>)> {
        let Some(name) = primitive.strings.first() else {
            return Err(primitive.error(format!("{} needs the name of its file", primitive.kind)));
        };
        Ok((name.clone(), self.resolve.library(name).map_err(|e| primitive.at_string(0, e))?))
    }

    /// The mesh file that a primitive names.
    pub(super) fn model(&mut self, primitive: &Primitive) -> Resolved<Rc<Model>> {
        if let Some(known) = primitive.strings.first().and_then(|name| self.models.get(name)) {
            return Ok(known.clone());
        }
        let (name, bytes) = self.file(primitive)?;
        let MeshFile { mesh, materials, scene } = import::mesh(bytes, &name).map_err(|e| primitive.at_string(0, e))?;
        let model = Rc::new(Model { mesh: Arc::new(mesh), materials, scene, chains: OnceCell::new() });
        self.models.insert(name, model.clone());
        Ok(model)
    }

    /// The chains of the materials that a mesh file brings along or names: for a mesh that has no modifier of its own.
    pub(super) fn embedded(&mut self, primitive: &Primitive, model: &Model) -> Resolved<Vec<ChainId>> {
        if let Some(known) = model.chains.get() {
            return Ok(known.clone());
        }
        let first = self.definitions.len();
        let outer = self.inside();
        let defined = model.scene.primitives().try_for_each(|p| self.define(p));
        let named = |builder: &Self, name: &str| {
            let found = outer.get(name).and_then(|d| d.last()).copied();
            found.or_else(|| builder.find(name, usize::MAX)).ok_or_else(|| {
                let remedy = "define it above, or give the mesh a modifier of its own";
                primitive.string_error(0, format!("it uses the material `{name}`, which is not defined before this; {remedy}"))
            })
        };
        let chain = |material: &MeshMaterial| match material {
            MeshMaterial::Void => self.chain(None),
            MeshMaterial::Embedded(i) => self.chain(Some(first + i)),
            MeshMaterial::Named(name) => {
                let found = named(self, name)?;
                self.chain(Some(found))
            }
        };
        let chains = match defined {
            Ok(()) => model.materials.iter().map(chain).collect::<Resolved<Vec<_>>>(),
            Err(error) => Err(Unresolved::Wrong(error)),
        };
        self.outside(outer);
        let chains = chains?;
        // A name means what it means where the mesh stands.
        if model.materials.iter().any(|m| matches!(m, MeshMaterial::Named(_))) {
            return Ok(chains);
        }
        Ok(model.chains.get_or_init(|| chains).clone())
    }

    /// The surfaces of the octree that a primitive names. Its sources and lights light nothing.
    pub(super) fn group(&mut self, primitive: &Primitive) -> Resolved<Arc<Vec<Surface>>> {
        let (name, bytes) = match primitive.strings.first().and_then(|name| self.groups.get(name)) {
            Some(known) => return Ok(known.clone()),
            None => self.file(primitive)?,
        };
        if self.within.contains(&name) {
            return Err(primitive.string_error(0, format!("{name} contains an instance of itself")).into());
        }
        if self.within.len() == LEVELS {
            return Err(primitive.string_error(0, format!("instances stand more than {LEVELS} deep within each other")).into());
        }
        let documents = import::octree(&bytes, &name).and_then(|octree| octree.documents(&name, self.resolve));
        let flat = documents.and_then(|documents| expand(documents, self.resolve)).map_err(|e| primitive.at_string(0, e))?;
        self.scene.warnings.extend_from_slice(&flat.warnings);
        self.within.push(name.clone());
        let outer = self.inside();
        let surfaces = self.surfaces(&flat.primitives);
        self.within.pop();
        self.outside(outer);
        let group = Arc::new(surfaces?);
        self.groups.insert(name, group.clone());
        Ok(group)
    }

    /// The surfaces among the primitives of an octree.
    fn surfaces(&mut self, primitives: &[Primitive]) -> Resolved<Vec<Surface>> {
        let mut surfaces = Vec::new();
        // A distant source is none of what is put into a scene.
        for primitive in primitives.iter().filter(|primitive| primitive.kind != "source") {
            surfaces.extend(self.add(primitive)?);
        }
        Ok(surfaces)
    }
}
