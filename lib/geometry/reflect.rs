//! Surfaces as they are seen in a flat mirror.

use super::{Cone, Facing, LightShape, Polygon, Ring, SPHERE_BOX, Shape, Sphere};
use crate::vector::Vec3;

/// The plane `normal · p = offset` of a flat surface, as a mirror.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Unit normal.
    pub normal: Vec3,
    /// Its distance from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// How far a point is in front of it.
    pub fn height(&self, point: Vec3) -> f64 {
        point.dot(self.normal) - self.offset
    }

    /// Where a point is seen.
    pub fn point(&self, point: Vec3) -> Vec3 {
        point - self.normal * (2.0 * self.height(point))
    }

    /// How a direction is seen.
    pub fn vector(&self, vector: Vec3) -> Vec3 {
        vector - self.normal * (2.0 * vector.dot(self.normal))
    }
}

impl Shape {
    /// The plane of a flat surface.
    pub fn plane(&self) -> Option<Plane> {
        match self {
            Self::Polygon(p) => Some(Plane { normal: p.normal, offset: p.offset }),
            Self::Ring(r) => Some(Plane { normal: r.normal, offset: r.normal.dot(r.center) }),
            _ => None,
        }
    }

    /// The surface as it is seen in a mirror; its front stays its front.
    pub fn reflected(&self, mirror: &Plane) -> Option<Self> {
        Some(match self {
            Self::Polygon(p) => Self::Polygon(Polygon::new(p.vertices.iter().rev().map(|&v| mirror.point(v)).collect())?),
            Self::Sphere(s) => Self::Sphere(Sphere { center: mirror.point(s.center), ..*s }),
            Self::Cone(c) => Self::Cone(Cone { base: mirror.point(c.base), axis: mirror.vector(c.axis), ..*c }),
            Self::Ring(r) => Self::Ring(Ring { center: mirror.point(r.center), normal: mirror.vector(r.normal), ..*r }),
        })
    }
}

impl LightShape {
    /// The light as it is seen in a mirror; of a distant one, the centre is a direction.
    pub fn reflected(&self, mirror: &Plane, distant: bool) -> Self {
        Self {
            center: if distant { mirror.vector(self.center) } else { mirror.point(self.center) },
            facing: match self.facing {
                Facing::Front(normal) => Facing::Front(mirror.vector(normal)),
                Facing::Across(axis) => Facing::Across(mirror.vector(axis)),
                Facing::All => Facing::All,
            },
            half_edges: self.half_edges.map(|e| mirror.vector(e)),
            ..*self
        }
    }

    /// Whether any part of it is in front of a mirror.
    pub fn in_front_of(&self, mirror: &Plane, distant: bool) -> bool {
        // The box of something round is smaller than what it stands for.
        let reach = if self.round { 1.0 / SPHERE_BOX } else { 1.0 };
        let extent: f64 = self.half_edges.iter().map(|e| e.dot(mirror.normal).abs() * reach).sum();
        let height = if distant { self.center.dot(mirror.normal) } else { mirror.height(self.center) };
        height + extent > super::TINY
    }
}
