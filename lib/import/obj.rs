//! Wavefront's `.obj`, as `obj2mesh` reads it: vertices, faces, `usemtl` and groups; other statements are passed over.

use super::triangulate::triangulate;
use super::{MeshFile, MeshMaterial, nothing};
use crate::error::{Error, Result, Source, Span};
use crate::geometry::Mesh;
use crate::rad::decode;
use crate::vector::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// How many vertices of one position are looked through for one that is the same.
const FEW: usize = 32;
/// Corners of a face at most.
const CORNERS: usize = 512;

/// The mesh in these bytes. The material of a face is the `usemtl` before it; where there has been none, the first word of its group;
/// without either there is none.
pub fn read(bytes: Vec<u8>, name: &str) -> Result<MeshFile> {
    let source = Source::new(name, decode(bytes));
    let mut state = State::empty(&source);
    // A line that ends with a backslash goes on.
    let text = source.text.as_str();
    let mut start = 0;
    let mut words = Vec::new();
    while start < text.len() {
        let mut end = start;
        words.clear();
        loop {
            let stop = text[end..].find('\n').map_or(text.len(), |i| end + i);
            let line = text[end..stop].trim_end_matches('\r');
            let (line, more) = line.strip_suffix('\\').map_or((line, false), |line| (line, true));
            words.extend(line.split_ascii_whitespace());
            end = (stop + 1).min(text.len());
            if !more || end == text.len() {
                break;
            }
        }
        state.statement(&words)?;
        start = end;
    }
    if state.triangles.is_empty() {
        return Err(super::error(name, "no face in it; is it a Wavefront .obj?"));
    }
    state.finish(name)
}

/// What has been read so far.
struct State {
    source: Arc<Source>,
    positions: Vec<Vec3>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// The vertices of the mesh: position, uv, normal; `NONE` for none.
    vertices: Vec<[u32; 3]>,
    /// For each position the first vertex made of it, and for each vertex the next one of the same position.
    first: Vec<u32>,
    next: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
    names: Vec<String>,
    numbers: HashMap<String, u32>,
    material: Option<String>,
    group: String,
    /// The number of the material that applies now, once known.
    current: Option<u32>,
}

const NONE: u32 = u32::MAX;

impl State {
    fn empty(source: &Arc<Source>) -> Self {
        Self {
            source: source.clone(),
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            vertices: Vec::new(),
            first: Vec::new(),
            next: Vec::new(),
            triangles: Vec::new(),
            materials: Vec::new(),
            names: Vec::new(),
            numbers: HashMap::new(),
            material: None,
            group: String::new(),
            current: None,
        }
    }

    /// An error at a word of the text.
    fn error(&self, word: &str, message: impl Into<String>) -> Error {
        let start = word.as_ptr() as usize - self.source.text.as_ptr() as usize;
        Span::new(&self.source, start, start + word.len()).error(message)
    }

    fn statement(&mut self, words: &[&str]) -> Result<()> {
        let [kind, arguments @ ..] = words else { return Ok(()) };
        match *kind {
            "v" => {
                let p = Vec3::from(self.numbers::<3>(kind, arguments)?);
                self.positions.push(p);
                self.first.push(NONE);
            }
            "vt" => {
                let [u, v] = self.numbers::<2>(kind, arguments)?;
                self.uvs.push([u as f32, v as f32]);
            }
            "vn" => {
                let n = Vec3::from(self.numbers::<3>(kind, arguments)?).normalize_or_zero();
                self.normals.push(n.to_array().map(|x| x as f32));
            }
            "f" | "fo" => self.face(kind, arguments)?,
            "usemtl" => {
                self.material = arguments.first().map(|word| word.to_string());
                self.current = None;
            }
            "g" => {
                self.group = arguments.first().map_or(String::new(), |word| word.to_string());
                self.current = None;
            }
            _ => {}
        }
        Ok(())
    }

    /// The first N arguments as finite numbers.
    fn numbers<const N: usize>(&self, kind: &str, arguments: &[&str]) -> Result<[f64; N]> {
        let mut out = [0.0; N];
        for (i, out) in out.iter_mut().enumerate() {
            let word = arguments.get(i).ok_or_else(|| self.error(kind, format!("`{kind}` needs {N} numbers")))?;
            let number = word.parse().ok().filter(|x: &f64| x.is_finite());
            *out = number.ok_or_else(|| self.error(word, "not a number"))?;
        }
        Ok(out)
    }

    fn face(&mut self, kind: &str, arguments: &[&str]) -> Result<()> {
        if !(3..=CORNERS).contains(&arguments.len()) {
            return Err(self.error(kind, format!("a face needs 3 to {CORNERS} corners, not {}", arguments.len())));
        }
        let mut corners = [0; 4];
        let many: Vec<u32>;
        let corners = if arguments.len() <= 4 {
            for (corner, word) in corners.iter_mut().zip(arguments) {
                *corner = self.corner(word)?;
            }
            &corners[..arguments.len()]
        } else {
            many = arguments.iter().map(|word| self.corner(word)).collect::<Result<_>>()?;
            &many
        };
        let material = match self.current {
            Some(material) => material,
            None => self.material_number(),
        };
        if let [a, b, c] = *corners {
            self.triangles.push([a, b, c]);
            self.materials.push(material);
            return Ok(());
        }
        let points: Vec<Vec3> = corners.iter().map(|&v| self.positions[self.vertices[v as usize][0] as usize]).collect();
        for triangle in triangulate(&points) {
            self.triangles.push(triangle.map(|i| corners[i]));
            self.materials.push(material);
        }
        Ok(())
    }

    /// The number of the material of the faces that follow.
    fn material_number(&mut self) -> u32 {
        let name = self.material.as_ref().unwrap_or(&self.group);
        let number = *self.numbers.entry(name.clone()).or_insert_with(|| {
            self.names.push(name.clone());
            self.names.len() as u32 - 1
        });
        self.current = Some(number);
        number
    }

    /// The vertex that a corner of a face names: position/uv/normal, the last two optional, counted from 1 or, negative, from the end.
    fn corner(&mut self, word: &str) -> Result<u32> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let mut key = [NONE; 3];
        for (i, part) in word.split('/').enumerate() {
            if i >= 3 {
                return Err(self.error(word, "a corner is position/uv/normal"));
            }
            if part.is_empty() && i > 0 {
                continue;
            }
            let number: i64 = part.parse().map_err(|_| self.error(word, "not a vertex number"))?;
            let index = if number < 0 { counts[i] as i64 + number } else { number - 1 };
            if index < 0 || index >= counts[i] as i64 {
                let what = ["positions", "surface coordinates", "normals"][i];
                return Err(self.error(word, format!("there are {} {what} so far", counts[i])));
            }
            key[i] = index as u32;
        }
        // Vertices of one position are few: look through them, but not through more.
        let mut vertex = self.first[key[0] as usize];
        for _ in 0..FEW {
            match self.vertices.get(vertex as usize) {
                None => break,
                Some(found) if *found == key => return Ok(vertex),
                Some(_) => vertex = self.next[vertex as usize],
            }
        }
        let new = self.vertices.len() as u32;
        self.vertices.push(key);
        self.next.push(std::mem::replace(&mut self.first[key[0] as usize], new));
        Ok(new)
    }

    fn finish(self, name: &str) -> Result<MeshFile> {
        let used = |part: usize| self.vertices.iter().any(|v| v[part] != NONE);
        let pick = |part: usize, i: &[u32; 3]| if i[part] == NONE { None } else { Some(i[part] as usize) };
        let mesh = Mesh {
            positions: self.vertices.iter().map(|v| self.positions[v[0] as usize]).collect(),
            uvs: if used(1) {
                self.vertices.iter().map(|v| pick(1, v).map_or([f32::NAN; 2], |i| self.uvs[i])).collect()
            } else {
                Vec::new()
            },
            normals: if used(2) {
                self.vertices.iter().map(|v| pick(2, v).map_or([0.0; 3], |i| self.normals[i])).collect()
            } else {
                Vec::new()
            },
            triangles: self.triangles,
            materials: if self.names.len() > 1 { self.materials } else { Vec::new() },
        };
        let named = |name: String| if name.is_empty() { MeshMaterial::Void } else { MeshMaterial::Named(name) };
        let mut materials: Vec<_> = self.names.into_iter().map(named).collect();
        if materials.is_empty() {
            materials.push(MeshMaterial::Void);
        }
        Ok(MeshFile { mesh, materials, scene: nothing(name)? })
    }
}
