//! The one door to the outside: who reads a file or runs a command for the library.
//!
//! The library opens nothing by name and spawns nothing. Programs implement [`Resolve`] on the file system;
//! tests implement it with [`Files`].

use crate::error::{Error, Result};
use std::collections::HashMap;

/// Reads files and runs commands on behalf of the library.
pub trait Resolve: Sync {
    /// The bytes of the scene file `path`, a plain path.
    fn scene(&self, path: &str) -> Result<Vec<u8>>;

    /// The bytes of a library file (function, data, picture, mesh, octree of an instance, operand of `xform`), searched for
    /// as RADIANCE does: as it stands if it begins with `/`, `.` or `~`, else along `RAYPATH`, then among the function files
    /// that ship with this project.
    fn library(&self, name: &str) -> Result<Vec<u8>>;

    /// What the shell command `command` prints, if the user has allowed commands.
    fn command(&self, command: &str) -> Result<Vec<u8>>;

    /// Whether the user wants no command carried out, not even those that run inside the process.
    fn denies(&self) -> bool {
        false
    }
}

/// Files held in memory; every command is refused.
#[derive(Default)]
pub struct Files(pub HashMap<String, Vec<u8>>);

impl Files {
    /// Files from names and contents.
    pub fn of<'a>(files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Self {
        Self(files.into_iter().map(|(name, bytes)| (name.to_string(), bytes.to_vec())).collect())
    }
}

impl Resolve for Files {
    fn scene(&self, path: &str) -> Result<Vec<u8>> {
        self.library(path)
    }

    fn library(&self, name: &str) -> Result<Vec<u8>> {
        self.0.get(name).cloned().ok_or_else(|| Error::new(format!("{name}: no such file")))
    }

    fn command(&self, command: &str) -> Result<Vec<u8>> {
        Err(Error::new(format!("command not run: {command}")))
    }
}
