//! Meshes that `obj2mesh` made (filefmts): patches of at most 256 vertices, and triangles that join them.

use super::binary::Reader;
use super::{MeshFile, MeshMaterial};
use crate::error::Result;
use crate::geometry::Mesh;
use crate::vector::Vec3;
use std::collections::HashMap;

/// The FORMAT of their header.
const FORMAT: &str = "Radiance_tmesh";
/// What their magic number exceeds the width of object numbers by.
const MAGIC: i64 = 319;
/// Coordinates are counted in this many steps.
const STEPS: f64 = 4294967296.0;

/// The mesh in these bytes.
pub fn read(bytes: &[u8], name: &str) -> Result<MeshFile> {
    let mut reader = Reader::new(bytes, name);
    reader.header(FORMAT)?;
    reader.magic(MAGIC)?;
    let [x, y, z, size] = [reader.decimal()?, reader.decimal()?, reader.decimal()?, reader.decimal()?];
    let [u0, u1, v0, v1] = [reader.float()?, reader.float()?, reader.float()?, reader.float()?];
    reader.skip_cells()?;
    let scene = reader.scene()?;
    let modifiers = scene.primitives().count();
    let mut patches = Patches {
        step: size / STEPS,
        origin: Vec3::new(x, y, z),
        uv: [[u0, (u1 - u0) / STEPS], [v0, (v1 - v0) / STEPS]],
        ..Default::default()
    };
    for _ in 0..reader.count(4)? {
        patches.read(&mut reader)?;
    }
    // Number the materials that occur in the order of their first use.
    let (mut numbers, mut materials) = (HashMap::new(), Vec::new());
    for material in &mut patches.materials {
        let next = materials.len() as u32;
        let number = *numbers.entry(*material).or_insert(next);
        if number == next {
            materials.push(match usize::try_from(*material) {
                Ok(i) if i >= modifiers => {
                    return Err(super::error(name, format!("a triangle has material {i}, but there are only {modifiers}")));
                }
                Ok(i) => MeshMaterial::Embedded(i),
                Err(_) => MeshMaterial::Void,
            });
        }
        *material = number as i32;
    }
    let triangles = patches.triangles.iter().map(|t| patches.resolve(t)).collect::<Option<Vec<_>>>();
    let triangles = triangles.ok_or_else(|| super::error(name, "a triangle has a vertex of a patch that is not there"))?;
    let single = materials.len() <= 1;
    let mesh = Mesh {
        positions: patches.positions,
        normals: if patches.has_normals { patches.normals } else { Vec::new() },
        uvs: if patches.has_uvs { patches.uvs } else { Vec::new() },
        triangles,
        materials: if single { Vec::new() } else { patches.materials.into_iter().map(|m| m as u32).collect() },
    };
    if materials.is_empty() {
        materials.push(MeshMaterial::Void);
    }
    Ok(MeshFile { mesh, materials, scene })
}

/// Patches read so far.
#[derive(Default)]
struct Patches {
    origin: Vec3,
    step: f64,
    /// Smallest value and step, of u and v.
    uv: [[f64; 2]; 2],
    /// The first vertex of each patch, and one past the last.
    starts: Vec<(u32, u32)>,
    positions: Vec<Vec3>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    has_normals: bool,
    has_uvs: bool,
    /// Vertices as patch << 8 | place.
    triangles: Vec<[u32; 3]>,
    materials: Vec<i32>,
}

impl Patches {
    /// Reads the next patch.
    fn read(&mut self, reader: &mut Reader) -> Result<()> {
        let flags = reader.byte()?;
        let vertices = reader.count(2)?;
        if flags & 1 == 0 || flags > 7 || vertices > 256 {
            return Err(reader.error("a patch has unknown parts or more than 256 vertices"));
        }
        let patch = self.starts.len() as u32;
        let start = self.positions.len() as u32;
        if patch >= 1 << 24 {
            return Err(reader.error("more than 16777216 patches"));
        }
        self.starts.push((start, start + vertices as u32));
        let number = |b: &[u8]| f64::from(u32::from_be_bytes([b[0], b[1], b[2], b[3]])) + 0.5;
        let (step, origin) = (self.step, self.origin);
        let rows = reader.take(12 * vertices)?.chunks_exact(12);
        self.positions.extend(rows.map(|b| origin + Vec3::new(number(b), number(&b[4..]), number(&b[8..])) * step));
        let total = self.positions.len();
        if flags & 2 != 0 {
            self.has_normals = true;
            let rows = reader.take(4 * vertices)?.chunks_exact(4);
            self.normals.extend(rows.map(|b| direction(i32::from_be_bytes([b[0], b[1], b[2], b[3]]))));
        }
        self.normals.resize(total, [0.0; 3]);
        if flags & 4 != 0 {
            self.has_uvs = true;
            let [u, v] = self.uv;
            self.uvs.extend(reader.take(8 * vertices)?.chunks_exact(8).map(|b| {
                let none = b[..4] == [0; 4];
                if none { [f32::NAN; 2] } else { [(u[0] + u[1] * number(b)) as f32, (v[0] + v[1] * number(&b[4..])) as f32] }
            }));
        }
        self.uvs.resize(total, [f32::NAN; 2]);

        let local = |place: u8| patch << 8 | u32::from(place);
        let count = reader.count(2)?;
        self.triangles.extend(reader.take(3 * count)?.chunks_exact(3).map(|b| [local(b[0]), local(b[1]), local(b[2])]));
        let single = reader.count(2)? <= 1;
        let codes = reader.take(if single { 2 } else { 2 * count })?;
        let material = |b: &[u8]| i32::from(i16::from_be_bytes([b[0], b[1]]));
        self.materials.extend((0..count).map(|i| material(&codes[if single { 0 } else { 2 * i }..])));
        let id = |b: &[u8]| u32::from_be_bytes([b[0], b[1], b[2], b[3]]);
        let count = reader.count(2)?;
        for b in reader.take(8 * count)?.chunks_exact(8) {
            self.triangles.push([id(b), local(b[4]), local(b[5])]);
            self.materials.push(material(&b[6..]));
        }
        let count = reader.count(2)?;
        for b in reader.take(11 * count)?.chunks_exact(11) {
            self.triangles.push([id(b), id(&b[4..]), local(b[8])]);
            self.materials.push(material(&b[9..]));
        }
        Ok(())
    }

    /// A triangle with its vertices counted from the first of all; `None` when one does not exist.
    fn resolve(&self, triangle: &[u32; 3]) -> Option<[u32; 3]> {
        let mut out = [0; 3];
        for (to, vertex) in out.iter_mut().zip(triangle) {
            let (start, end) = *self.starts.get((vertex >> 8) as usize)?;
            *to = Some(start + (vertex & 255)).filter(|v| *v < end)?;
        }
        Some(out)
    }
}

/// The direction a code stands for; 0 0 0 for none.
fn direction(code: i32) -> [f32; 3] {
    if code == 0 {
        return [0.0; 3];
    }
    let [a, b] = [code >> 5 & 0x1fff, code >> 18 & 0x1fff].map(|d| f64::from(d) / 11584.5);
    let c = (1.0 - a * a - b * b).max(0.0).sqrt();
    let (x_smaller, z_given) = (code & 8 != 0, code & 16 != 0);
    let mut d = match (x_smaller, z_given) {
        (true, true) => [a, c, b],
        (true, false) => [a, b, c],
        (false, true) => [c, a, b],
        (false, false) => [b, a, c],
    };
    for (axis, x) in d.iter_mut().enumerate() {
        if code >> axis & 1 == 1 {
            *x = -*x;
        }
    }
    d.map(|x| x as f32)
}
