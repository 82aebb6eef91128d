//! Octrees that `oconv` made (filefmts): either the names of their scene files, or the scene itself.

use super::Octree;
use super::binary::Reader;
use crate::error::Result;

/// The FORMAT of their header.
pub const FORMAT: &str = "Radiance_octree";
/// What their magic number exceeds the width of object numbers by.
const MAGIC: i64 = 283;

/// What the octree in these bytes stands for.
pub fn read(bytes: &[u8], name: &str) -> Result<Octree> {
    let mut reader = Reader::new(bytes, name);
    reader.header(FORMAT)?;
    reader.magic(MAGIC)?;
    for _ in 0..4 {
        reader.decimal()?;
    }
    let mut files = Vec::new();
    loop {
        let file = reader.string()?;
        if file.is_empty() {
            break;
        }
        files.push(file);
    }
    // The cells of files that are read again do not matter.
    if !files.is_empty() {
        return Ok(Octree::Files(files));
    }
    reader.object()?;
    reader.skip_cells()?;
    Ok(Octree::Scene(reader.scene()?))
}
