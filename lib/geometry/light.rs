//! A surface as RADIANCE's direct calculation sees a light source: one point, one size, two or three edges to divide.

use super::Shape;
use crate::vector::{Frame, Vec3};
use std::f64::consts::PI;

/// What RADIANCE samples of a surface that is a light source.
#[derive(Clone, Copy, Debug)]
pub struct LightShape {
    /// Where the one undivided sample is: the vertex average of a polygon, the middle of the others.
    pub center: Vec3,
    /// Solid angle at distance d is `size` × cosine / d², the cosine given by `facing`: area of a polygon or ring, πr² of a sphere,
    /// 2rL of a cylinder.
    pub size: f64,
    /// Which cosine foreshortens it.
    pub facing: Facing,
    /// Half the edges of the box or rectangle round the centre that is divided: of the parallelogram v0, v1−v0, v3−v0 of a polygon
    /// with four vertices, of the square of equal area of another polygon or a ring (third one zero), along the axis first for a cylinder.
    pub half_edges: [Vec3; 3],
}

/// How the size of a light depends on the direction it is seen from.
#[derive(Clone, Copy, Debug)]
pub enum Facing {
    /// The cosine to this normal; nothing from behind.
    Front(Vec3),
    /// The sine to this axis.
    Across(Vec3),
    /// None: the same from everywhere.
    All,
}

impl Shape {
    /// The surface as a light source; an error for one that RADIANCE refuses.
    pub fn light(&self) -> Result<LightShape, &'static str> {
        let square = |center: Vec3, normal: Vec3, area: f64| {
            let frame = Frame::around(normal);
            let half = area.sqrt() / 2.0;
            LightShape { center, size: area, facing: Facing::Front(normal), half_edges: [frame.s * half, frame.t * half, Vec3::ZERO] }
        };
        match self {
            Self::Polygon(p) => {
                let center = p.vertex_average();
                if !p.contains(center) {
                    return Err("the average of its vertices lies outside this polygon, so it cannot be a light; divide it");
                }
                let mut light = square(center, p.normal, p.area);
                if let [v0, v1, _, v3] = *p.vertices {
                    light.half_edges = [(v1 - v0) / 2.0, (v3 - v0) / 2.0, Vec3::ZERO];
                }
                Ok(light)
            }
            Self::Ring(r) if r.inner > 0.0 => Err("a ring with a hole cannot be a light; use a polygon or a disk"),
            Self::Ring(r) => Ok(square(r.center, r.normal, r.area())),
            Self::Sphere(s) if !s.inward => {
                let r = s.radius;
                let half_edges = [Vec3::X * r, Vec3::Y * r, Vec3::Z * r];
                Ok(LightShape { center: s.center, size: PI * r * r, facing: Facing::All, half_edges })
            }
            Self::Cone(c) if !c.inward && c.radii[0] == c.radii[1] => {
                let frame = Frame::around(c.axis);
                Ok(LightShape {
                    center: c.base + c.axis * (c.length / 2.0),
                    size: 2.0 * c.radii[0] * c.length,
                    facing: Facing::Across(c.axis),
                    half_edges: [c.axis * (c.length / 2.0), frame.s * c.radii[0], frame.t * c.radii[0]],
                })
            }
            _ => Err("a light must be a polygon, sphere, cylinder, ring or source"),
        }
    }
}
