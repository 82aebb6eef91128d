//! Points on a surface, uniform in area. The density is 1 / area.

use super::Shape;
use crate::vector::Vec3;

/// A surface made ready to be sampled: the square [0,1)² onto it, keeping areas in proportion.
#[derive(Clone, Debug)]
pub struct AreaSampler {
    kind: Kind,
    area: f64,
}

#[derive(Clone, Debug)]
enum Kind {
    /// A corner and two edges.
    Parallelogram([Vec3; 3]),
    /// A corner and two edges.
    Triangle([Vec3; 3]),
    /// Trapezoids with the running sum of their areas.
    Trapezoids(Vec<([Vec3; 4], f64)>),
    /// A surface with its own formula.
    Round(Shape),
}

impl AreaSampler {
    /// The sampler of a surface.
    pub fn new(shape: &Shape) -> Self {
        let Shape::Polygon(polygon) = shape else { return Self { kind: Kind::Round(shape.clone()), area: shape.area() } };
        let v = &polygon.vertices;
        let opposite = |v: &[Vec3]| ((v[0] - v[1]) + (v[2] - v[3])).length() <= 1e-9 * (v[2] - v[0]).length();
        let kind = match v.len() {
            3 => Kind::Triangle([v[0], v[1] - v[0], v[2] - v[0]]),
            4 if opposite(v) => Kind::Parallelogram([v[0], v[1] - v[0], v[3] - v[0]]),
            _ => {
                let mut sum = 0.0;
                let parts = polygon.trapezoids().unwrap_or_default().into_iter().map(|corners| {
                    let [a, b, c, d] = corners;
                    sum += ((b - a).cross(c - a).length() + (c - a).cross(d - a).length()) / 2.0;
                    (corners, sum)
                });
                Kind::Trapezoids(parts.collect())
            }
        };
        let area = if let Kind::Trapezoids(parts) = &kind { parts.last().map_or(0.0, |p| p.1) } else { polygon.area };
        Self { kind, area }
    }

    /// The area that is sampled; the density of a point is its inverse. For a polygon whose outline crosses itself this is the area
    /// inside by the even-odd rule.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The point for `u` in the unit square.
    pub fn sample(&self, u: [f64; 2]) -> Vec3 {
        match &self.kind {
            Kind::Parallelogram([p, a, b]) => *p + *a * u[0] + *b * u[1],
            Kind::Triangle([p, a, b]) => {
                // Pharr et al. 2023, eq. A.16 in its square-root form.
                let s = u[0].sqrt();
                *p + *a * (s * (1.0 - u[1])) + *b * (s * u[1])
            }
            Kind::Trapezoids(parts) => {
                let at = u[0] * self.area;
                let i = parts.partition_point(|p| p.1 <= at).min(parts.len() - 1);
                let before = if i == 0 { 0.0 } else { parts[i - 1].1 };
                let ([a, b, c, d], sum) = parts[i];
                // Within the trapezoid the width changes linearly with height: invert its quadratic sum.
                let (low, high) = ((b - a).length(), (c - d).length());
                let x = ((at - before) / (sum - before)).clamp(0.0, 1.0);
                let root = (low * low + x * (high * high - low * low)).max(0.0).sqrt();
                let h = if root + low > 0.0 { x * (low + high) / (root + low) } else { 0.0 };
                let (left, right) = (a + (d - a) * h, b + (c - b) * h);
                left + (right - left) * u[1]
            }
            Kind::Round(Shape::Sphere(s)) => s.sample(u),
            Kind::Round(Shape::Cone(s)) => s.sample(u),
            Kind::Round(Shape::Ring(s)) => s.sample(u),
            Kind::Round(Shape::Polygon(s)) => s.vertices[0],
        }
    }
}
