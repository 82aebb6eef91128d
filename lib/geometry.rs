//! What surfaces are and where a ray meets them: rays, bounds, RADIANCE's surface types, triangle meshes.
//!
//! Everything here is `f64` and in world units. A [`Shape`] follows RADIANCE's rules for its type (reference manual, "Surfaces"):
//! where it is hit, which side is the front, what is degenerate.

mod light;
mod mesh;
mod polygon;
mod quadric;
mod reflect;
mod sample;
mod shape;

pub use light::{CYLINDER_BOX, Facing, LightShape, SPHERE_BOX};
pub use mesh::Mesh;
pub use polygon::Polygon;
pub use quadric::{Cone, Ring, Sphere};
pub use reflect::Plane;
pub use sample::AreaSampler;
pub use shape::Shape;

use crate::vector::Vec3;

/// RADIANCE's FTINY. What is no larger is nothing to it: a distance in scenes of ordinary size, a share of the light, a cosine.
pub const TINY: f64 = 1e-6;

/// RADIANCE's infinity: how far what is beyond all surfaces is.
pub const FAR: f64 = 1e10;

/// How many levels deep instances may be nested.
pub const LEVELS: usize = 8;

/// [`TINY`] for a scene (or object) of that size: RADIANCE's number between 1e-3 and 1e3, proportional to the size beyond, so that
/// a scene may be scaled by any factor.
pub fn tolerance(size: f64) -> f64 {
    TINY * (size / 1e3).max(1.0) * (size / 1e-3).min(1.0)
}

/// A half line.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes; unit.
    pub direction: Vec3,
}

impl Ray {
    /// The ray from `origin` along the unit vector `direction`.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction }
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f64) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// An axis-aligned box, its faces included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The box that holds nothing; the neutral element of [`Bounds::join`].
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box round these points.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box round both.
    pub fn join(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box grown by `margin` on every side.
    pub fn grow(self, margin: f64) -> Self {
        Self { min: self.min - Vec3::splat(margin), max: self.max + Vec3::splat(margin) }
    }

    /// Whether it holds nothing.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether the point is inside or on a face.
    #[cfg(test)]
    pub fn contains(&self, p: Vec3) -> bool {
        self.min.cmple(p).all() && p.cmple(self.max).all()
    }

    /// The middle; meaningless when empty.
    pub fn center(&self) -> Vec3 {
        self.min * 0.5 + self.max * 0.5
    }

    /// The ball through its corners: middle and radius; meaningless when empty.
    pub fn ball(&self) -> (Vec3, f64) {
        (self.center(), 0.5 * (self.max - self.min).length())
    }

    /// The longest side; 0 when empty.
    pub fn size(&self) -> f64 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).max_element() }
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { self.min[axis] } else { self.max[axis] };
            Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        })
    }
}

#[cfg(test)]
mod tests;
