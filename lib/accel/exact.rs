//! A triangle met in double precision: how far, where, which way it faces.

use super::probe::Probe;
use super::tree::Tree;
use super::{Hit, Path};
use crate::vector::Vec3;

/// What a leaf block has no room for.
#[derive(Clone, Debug)]
pub(super) struct Detail {
    /// Which surface of the list it is of, or is.
    pub surface: u32,
    /// Which triangle of the mesh.
    pub triangle: u32,
    /// What is to be added to the block's corners to make them exact.
    pub residue: [[f32; 3]; 3],
}

/// Where a ray meets the plane of a triangle, in the tree's coordinates.
pub(super) struct Meeting {
    /// Distance along the probe.
    pub t: f64,
    /// The point.
    point: Vec3,
    /// Weights of the corners.
    weights: Vec3,
    corners: [Vec3; 3],
}

impl Tree {
    /// The number in the order of the leaves of the triangle in a slot: block · 8 + lane.
    #[inline(always)]
    pub fn place(&self, slot: u32) -> usize {
        self.blocks[(slot >> 3) as usize].first as usize + (slot & 7) as usize
    }

    /// The distance along the probe to the plane of the triangle in a slot.
    #[inline(always)]
    pub fn plane(&self, probe: &Probe, slot: u32) -> f64 {
        let [a, b, c] = self.corners(slot);
        let normal = (b - a).cross(c - a);
        (a - probe.exact_origin).dot(normal) / probe.direction.dot(normal)
    }

    /// The corners of the triangle in a slot.
    #[inline(always)]
    fn corners(&self, slot: u32) -> [Vec3; 3] {
        let (block, lane) = (&self.blocks[(slot >> 3) as usize], (slot & 7) as usize);
        let detail = &self.details[block.first as usize + lane];
        let exact = |v: usize, axis: usize| f64::from(block.corners[v][axis].as_array()[lane]) + f64::from(detail.residue[v][axis]);
        let corner = |v: usize| Vec3::new(exact(v, 0), exact(v, 1), exact(v, 2));
        [corner(0), corner(1), corner(2)]
    }

    /// How the probe meets the triangle in a slot, which it is known to hit at about the distance `near`; at a point of the triangle in any
    /// case, give or take what single precision is wrong by.
    #[inline(always)]
    pub fn meet(&self, probe: &Probe, slot: u32, near: f32) -> Meeting {
        let corners = self.corners(slot);
        // Seen from a point of the ray near the triangle no digits are lost, however far the ray has come.
        let near = f64::from(near);
        let from = probe.exact_origin + probe.direction * near;
        let (a, b, c) = (corners[0] - from, corners[1] - from, corners[2] - from);
        let d = probe.direction;
        // The ray against the three edges (Plücker).
        let volumes = Vec3::new(d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a)));
        let mut weights = volumes / volumes.element_sum();
        // A little outside is single precision's doing and still on the plane. More is a triangle seen edge on: take a point in it.
        if weights.is_nan() || weights.min_element() < -1e-2 {
            let positive = weights.max(Vec3::ZERO);
            weights = Some(positive / positive.element_sum()).filter(|w| w.is_finite()).unwrap_or(Vec3::splat(1.0 / 3.0));
        }
        let offset = a * weights.x + b * weights.y + c * weights.z;
        Meeting { t: near + offset.dot(d), point: from + offset, weights, corners }
    }
}

impl Meeting {
    /// The hit in the world. `mirrored`: the front is where the corners are seen clockwise.
    #[inline]
    pub fn hit(&self, probe: &Probe, detail: &Detail, mirrored: bool) -> Hit {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        Hit {
            t: probe.world(self.t),
            point: probe.world_point(self.point),
            normal: if mirrored { -normal } else { normal },
            surface: detail.surface,
            path: Path::default(),
            triangle: detail.triangle,
            barycentric: [self.weights.y, self.weights.z].map(|w| w.clamp(0.0, 1.0)),
        }
    }
}
