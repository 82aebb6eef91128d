//! What other programs made: RADIANCE's compiled meshes (`.rtm`) and octrees (`.oct`), and Wavefront's `.obj`.
//!
//! Nothing is allocated before the bytes that fill it are known to be there, and no input makes a reader panic.

mod binary;
mod obj;
mod oct;
mod rtm;
mod triangulate;

use crate::error::{Error, Result, Source};
use crate::geometry::Mesh;
use crate::rad::Document;
use crate::resolve::Resolve;

/// A mesh as a file holds it.
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// Its triangles; their materials are indices into `materials`.
    pub mesh: Mesh,
    /// What each material index means.
    pub materials: Vec<MeshMaterial>,
    /// The modifiers that a `.rtm` brings along, as if they stood in a scene file; without statements for an `.obj`.
    pub scene: Document,
}

/// What a material index of a mesh means.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MeshMaterial {
    /// No material.
    Void,
    /// The primitive of that number, from 0, in the scene that the file brings along.
    Embedded(usize),
    /// A modifier known by this name.
    Named(String),
}

/// What an octree file stands for.
#[derive(Clone, Debug)]
pub enum Octree {
    /// The scene files it was made from, in order; one that begins with `!` is a command.
    Files(Vec<String>),
    /// The scene itself, frozen.
    Scene(Document),
}

impl Octree {
    /// The descriptions that it stands for; `name` is its own. A command is a description of one line.
    pub fn documents(self, name: &str, resolve: &dyn Resolve) -> Result<Vec<Document>> {
        let read = |file: String| match file.starts_with('!') {
            true => Document::parse(Source::new(name, file + "\n")),
            false => Document::read(&file, resolve.scene(&file).map_err(|e| lacking(name, &e))?),
        };
        match self {
            Self::Files(files) => files.into_iter().map(read).collect(),
            Self::Scene(document) => Ok(vec![document]),
        }
    }
}

/// That an octree was made from a file that cannot be read.
fn lacking(octree: &str, file: &Error) -> Error {
    Error::new(format!(
        "{octree}: it was made from a scene file that it does not hold: {}; give it the file, or freeze it by oconv -f",
        file.message
    ))
}

/// The mesh in these bytes: a `.rtm` if it begins like one, otherwise an `.obj`. `name` is what the user knows it by.
pub fn mesh(bytes: Vec<u8>, name: &str) -> Result<MeshFile> {
    let file = if bytes.starts_with(binary::SIGNATURE) { rtm::read(&bytes, name)? } else { obj::read(bytes, name)? };
    file.mesh.check(name)?;
    Ok(file)
}

/// What the octree in these bytes stands for. `name` is what the user knows it by.
pub fn octree(bytes: &[u8], name: &str) -> Result<Octree> {
    oct::read(bytes, name)
}

/// Whether the bytes are an octree, by their header.
pub fn is_octree(bytes: &[u8]) -> bool {
    binary::Reader::new(bytes, "").header(oct::FORMAT).is_ok()
}

/// A document without statements.
fn nothing(name: &str) -> Result<Document> {
    Document::parse(Source::new(name, ""))
}

/// An error in the file as a whole.
fn error(name: &str, message: impl std::fmt::Display) -> Error {
    Error::new(format!("{name}: {message}"))
}
