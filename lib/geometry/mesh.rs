//! Triangles that share vertices.

use super::Bounds;
use crate::error::{Error, Result};
use crate::vector::Vec3;

/// A triangle mesh. The front of a triangle is where its vertices are seen counter-clockwise.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Shading normals: none at all, or one per vertex; a vertex without one has 0 0 0.
    pub normals: Vec<[f32; 3]>,
    /// Surface coordinates: none at all, or one pair per vertex; a vertex without has NaN.
    pub uvs: Vec<[f32; 2]>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// The material of each triangle, an index into the list that comes with the mesh. Empty: all 0.
    pub materials: Vec<u32>,
}

impl Mesh {
    /// The corners of a triangle.
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// The material of a triangle, an index into the list that comes with the mesh.
    pub fn material(&self, triangle: u32) -> u32 {
        self.materials.get(triangle as usize).copied().unwrap_or(0)
    }

    /// The interpolated shading normal at barycentric coordinates `b` (weights of the second and third vertex), unit;
    /// `None` unless all three vertices have one.
    pub fn normal(&self, triangle: u32, b: [f64; 2]) -> Option<Vec3> {
        if self.normals.is_empty() {
            return None;
        }
        let n = self.triangles[triangle as usize].map(|v| Vec3::from(self.normals[v as usize].map(f64::from)));
        if n.contains(&Vec3::ZERO) {
            return None;
        }
        (n[0] * (1.0 - b[0] - b[1]) + n[1] * b[0] + n[2] * b[1]).try_normalize()
    }

    /// The interpolated surface coordinates at barycentric coordinates `b`; `None` unless all three vertices have them.
    pub fn uv(&self, triangle: u32, b: [f64; 2]) -> Option<[f64; 2]> {
        if self.uvs.is_empty() {
            return None;
        }
        let uv = self.triangles[triangle as usize].map(|v| self.uvs[v as usize].map(f64::from));
        let at = |i: usize| uv[0][i] * (1.0 - b[0] - b[1]) + uv[1][i] * b[0] + uv[2][i] * b[1];
        let (u, v) = (at(0), at(1));
        (!u.is_nan() && !v.is_nan()).then_some([u, v])
    }

    /// The box round the vertices.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.positions.iter().copied())
    }

    /// Refuses a mesh whose parts do not fit together. `name` is what the user knows it by.
    pub fn check(&self, name: &str) -> Result<()> {
        let vertices = self.positions.len();
        let wrong = |what: &str| Err(Error::new(format!("{name}: {what}")));
        if self.triangles.len() >= u32::MAX as usize || vertices >= u32::MAX as usize {
            return wrong("mesh has more than 4294967294 triangles or vertices; split it");
        }
        if !self.normals.is_empty() && self.normals.len() != vertices {
            return wrong("mesh has not as many normals as vertices");
        }
        if !self.uvs.is_empty() && self.uvs.len() != vertices {
            return wrong("mesh has not as many surface coordinates as vertices");
        }
        if !self.materials.is_empty() && self.materials.len() != self.triangles.len() {
            return wrong("mesh has not as many materials as triangles");
        }
        match self.triangles.iter().flatten().find(|&&v| v as usize >= vertices) {
            Some(v) => wrong(&format!("mesh has a triangle with vertex {v}, but only {vertices} vertices")),
            None => Ok(()),
        }
    }
}
