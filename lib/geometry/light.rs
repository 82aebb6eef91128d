//! A surface as RADIANCE's direct calculation sees a light source: one point, one size, two or three edges to divide.

use super::Shape;
use crate::vector::Vec3;
use std::f64::consts::PI;

/// What RADIANCE samples of a surface that is a light source.
#[derive(Clone, Copy, Debug)]
pub struct LightShape {
    /// Where the one undivided sample is: the vertex average of a polygon, the middle of the others. Of a distant source: the unit vector to it.
    pub center: Vec3,
    /// Solid angle at distance d is `size` × cosine / d², the cosine given by `facing`: area of a polygon or ring, πr² of a sphere,
    /// 2rL of a cylinder. Of a distant source: its solid angle.
    pub size: f64,
    /// Which cosine foreshortens it.
    pub facing: Facing,
    /// Half the edges of the box or rectangle round the centre that is divided and jittered over: of the parallelogram v0, v1−v0, v3−v0 of a
    /// polygon with four vertices, of the square inside a triangle, of the square of equal area of another polygon, a ring or a distant
    /// source (third one zero), along the axis first for a cylinder.
    pub half_edges: [Vec3; 3],
    /// Whether the box stands for something round: then points are drawn in to where that is.
    pub round: bool,
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

/// How far the edges of the box of a sphere and of a cylinder reach, in radii (measured: `rtrace -oT`).
pub const SPHERE_BOX: f64 = 0.7236;
/// See [`SPHERE_BOX`].
pub const CYLINDER_BOX: f64 = 0.8559;

impl LightShape {
    /// A `source` in the direction `axis` with the solid angle `size`.
    pub fn distant(axis: Vec3, size: f64) -> Self {
        Self { facing: Facing::All, ..Self::square(axis, axis, size, true) }
    }

    /// A flat light that is divided as the square of equal area.
    fn square(center: Vec3, normal: Vec3, area: f64, round: bool) -> Self {
        let u = perpendicular(normal) * (area.sqrt() / 2.0);
        Self { center, size: area, facing: Facing::Front(normal), half_edges: [u, normal.cross(u), Vec3::ZERO], round }
    }
}

/// The unit vector across `v` that RADIANCE takes: at right angles to the last axis that is not near `v`.
fn perpendicular(v: Vec3) -> Vec3 {
    let axis = [Vec3::Z, Vec3::Y, Vec3::X].into_iter().find(|axis| v.dot(*axis).abs() < 0.6).unwrap_or(Vec3::X);
    axis.cross(v).normalize()
}

impl Shape {
    /// The surface as a light source; an error for one that RADIANCE refuses.
    pub fn light(&self) -> Result<LightShape, &'static str> {
        match self {
            Self::Polygon(p) => {
                let center = p.vertex_average();
                if !p.contains(center) {
                    return Err("the average of its vertices lies outside this polygon, so it cannot be a light; divide it");
                }
                if p.vertices.len() > 4 && p.trapezoids().is_none() {
                    return Err("this polygon's outline has too many sides beside one another for a light; divide it");
                }
                let mut light = LightShape::square(center, p.normal, p.area, false);
                match *p.vertices {
                    [v0, v1, _, v3] => light.half_edges = [(v1 - v0) / 2.0, (v3 - v0) / 2.0, Vec3::ZERO],
                    [v0, v1, v2] => {
                        // A square round the centre that reaches to the nearest edge, along that edge.
                        let edges = [(v0, v1), (v1, v2), (v2, v0)];
                        let distance = |(a, b): (Vec3, Vec3)| (center - a).cross(b - a).length() / (b - a).length();
                        let nearest = edges.into_iter().min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap_or(edges[0]);
                        let u = (nearest.1 - nearest.0).normalize() * distance(nearest);
                        light.half_edges = [u, p.normal.cross(u), Vec3::ZERO];
                    }
                    _ => {}
                }
                Ok(light)
            }
            Self::Ring(r) if r.inner > 0.0 => Err("a ring with a hole cannot be a light; use a polygon or a disk"),
            Self::Ring(r) => Ok(LightShape::square(r.center, r.normal, r.area(), true)),
            Self::Sphere(s) if !s.inward => {
                let half_edges = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * (SPHERE_BOX * s.radius));
                Ok(LightShape { center: s.center, size: PI * s.radius * s.radius, facing: Facing::All, half_edges, round: true })
            }
            Self::Cone(c) if !c.inward && c.radii[0] == c.radii[1] => {
                let across = perpendicular(c.axis);
                let half = CYLINDER_BOX * c.radii[0];
                Ok(LightShape {
                    center: c.base + c.axis * (c.length / 2.0),
                    size: 2.0 * c.radii[0] * c.length,
                    facing: Facing::Across(c.axis),
                    half_edges: [c.axis * (c.length / 2.0), across.cross(c.axis) * half, across * half],
                    round: false,
                })
            }
            _ => Err("a light must be a polygon, sphere, cylinder, ring or source"),
        }
    }
}
