//! A triangle met in double precision: how far, where, which way it faces.

use super::probe::Probe;
use super::tree::Tree;
use super::{Hit, Path};
use crate::vector::Vec3;
use bytemuck::{Pod, Zeroable};

/// What a leaf block has no room for.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
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
    /// The point, seen from the first corner.
    place: Vec3,
    /// The second and the third corner, seen from the first.
    sides: [Vec3; 2],
    /// Their cross product.
    normal: Vec3,
}

impl Tree<'_> {
    /// The detail of the triangle in a slot: block · 8 + lane.
    #[inline(always)]
    pub fn detail(&self, slot: u32) -> &Detail {
        &self.details[self.blocks[(slot >> 3) as usize].first as usize + (slot & 7) as usize]
    }

    /// Asks memory for the detail of the triangle in a slot, which may be the one: it comes while the search goes on.
    #[inline(always)]
    pub fn ask(&self, slot: u32) {
        std::hint::black_box(self.detail(slot).surface);
    }

    /// The corners of the triangle in a slot.
    #[inline(always)]
    fn corners(&self, slot: u32) -> [Vec3; 3] {
        let (block, lane) = (&self.blocks[(slot >> 3) as usize], (slot & 7) as usize);
        let detail = self.detail(slot);
        let exact = |v: usize, axis: usize| f64::from(block.corners[v][axis].as_array()[lane]) + f64::from(detail.residue[v][axis]);
        let corner = |v: usize| Vec3::new(exact(v, 0), exact(v, 1), exact(v, 2));
        [corner(0), corner(1), corner(2)]
    }

    /// How the probe meets the plane of the triangle in a slot, which it is known to hit at the distance `near`, give or take
    /// `blur`.
    #[inline(always)]
    pub fn meet(&self, probe: &Probe, slot: u32, near: f32, blur: f32) -> Meeting {
        let [a, b, c] = self.corners(slot);
        let (near, direction) = (f64::from(near), probe.ray.direction);
        // Seen from a point of the ray near the triangle no digits are lost, however far the ray has come.
        let from = probe.at(near);
        let (first, sides) = (a - from, [b - a, c - a]);
        let normal = sides[0].cross(sides[1]);
        // More is the plane of a triangle that is seen edge on, far outside of it.
        let further = first.dot(normal) / direction.dot(normal);
        let further = if further.abs() <= 2.0 * f64::from(blur) { further } else { 0.0 };
        let step = direction * further;
        Meeting { t: near + further, point: from + step, place: step - first, sides, normal }
    }

    /// Whether the exact distance of a triangle, met at about the distance `near`, is in the range.
    #[inline(never)]
    pub fn within(&self, probe: &Probe, slot: u32, [near, blur]: [f32; 2], [t_min, t_max]: [f64; 2]) -> bool {
        let t = probe.world(self.meet(probe, slot, near, blur).t);
        t > t_min && t < t_max
    }
}

impl Meeting {
    /// The hit in the world. `mirrored`: the front is where the corners are seen clockwise.
    #[inline]
    pub fn hit(&self, probe: &Probe, detail: &Detail, mirrored: bool) -> Hit {
        let [b, c] = self.sides;
        let square = self.normal.length_squared();
        let inverse = if square > 0.0 { 1.0 / square } else { 0.0 };
        let weights = [self.place.cross(c), b.cross(self.place)].map(|part| part.dot(self.normal) * inverse);
        let unit = inverse.sqrt();
        Hit {
            t: probe.world(self.t),
            point: probe.world_point(self.point),
            normal: self.normal * if mirrored { -unit } else { unit },
            surface: detail.surface,
            path: Path::default(),
            triangle: detail.triangle,
            barycentric: weights.map(|w| w.clamp(0.0, 1.0)),
        }
    }
}
