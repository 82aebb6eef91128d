//! RADIANCE's round surfaces: `sphere`, `cone` (and `cylinder`), `ring`, and their inside-out twins.

use super::polygon::plane;
use super::{Bounds, Ray};
use crate::vector::{Frame, Vec3};
use std::f64::consts::PI;

/// `sphere`, or `bubble` when its normals point inward.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Its middle.
    pub center: Vec3,
    /// Positive.
    pub radius: f64,
    /// Whether the front is inside.
    pub inward: bool,
}

/// `cone`, `cup`, `cylinder`, `tube`: a frustum without end caps.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// The middle of the end with radius `radii[0]`.
    pub base: Vec3,
    /// Unit vector to the other end.
    pub axis: Vec3,
    /// Distance between the ends.
    pub length: f64,
    /// Radii at the two ends; not negative, not both zero.
    pub radii: [f64; 2],
    /// Whether the front is inside.
    pub inward: bool,
}

/// `ring`: a disk, with a hole when the inner radius is not zero.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Its middle.
    pub center: Vec3,
    /// Unit; the front is where it points.
    pub normal: Vec3,
    /// Radius of the hole; not negative.
    pub inner: f64,
    /// Radius of the rim; larger than `inner`.
    pub outer: f64,
}

impl Sphere {
    /// The distance of the nearest hit with `t_min < t < t_max`.
    pub fn intersect(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<f64> {
        // Solve from the point of the ray nearest to the centre, which keeps the small root exact (Haines et al. 2019, "Precision
        // Improvements for Ray/Sphere Intersection").
        let m = self.center - ray.origin;
        let b = m.dot(ray.direction);
        let miss = (m - ray.direction * b).length_squared();
        let square = self.radius * self.radius - miss;
        if square < 0.0 {
            return None;
        }
        let q = b + square.sqrt().copysign(b);
        let product = m.length_squared() - self.radius * self.radius;
        let (t, u) = if q == 0.0 { (0.0, 0.0) } else { (q, product / q) };
        nearest([t.min(u), t.max(u)], t_min, t_max, |_| true)
    }

    /// The unit normal at a point of the surface, on the front.
    pub fn normal_at(&self, point: Vec3) -> Vec3 {
        let n = (point - self.center).try_normalize().unwrap_or(Vec3::Z);
        if self.inward { -n } else { n }
    }

    /// The box round it.
    pub fn bounds(&self) -> Bounds {
        Bounds { min: self.center, max: self.center }.grow(self.radius)
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        4.0 * PI * self.radius * self.radius
    }

    /// A point, uniform in area over `u` in the unit square.
    pub fn sample(&self, u: [f64; 2]) -> Vec3 {
        let z = 1.0 - 2.0 * u[0];
        let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        self.center + Vec3::new(r * cos, r * sin, z) * self.radius
    }
}

impl Cone {
    /// How much the radius grows per unit of the axis.
    fn slope(&self) -> f64 {
        (self.radii[1] - self.radii[0]) / self.length
    }

    /// The distance of the nearest hit with `t_min < t < t_max`.
    pub fn intersect(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<f64> {
        // Along the ray the distance from the axis is |p + t d| and the radius there r + t s: equate the squares.
        let from = ray.origin - self.base;
        let (height, climb) = (from.dot(self.axis), ray.direction.dot(self.axis));
        let (p, d) = (from - self.axis * height, ray.direction - self.axis * climb);
        let (r, s) = (self.radii[0] + self.slope() * height, self.slope() * climb);
        // From where the ray is nearest to the axis, lest large squares cancel.
        let across = d.length_squared();
        let start = if across > 0.0 { -p.dot(d) / across } else { 0.0 };
        let (p, r) = (p + d * start, r + s * start);
        let (a, b, c) = (across - s * s, p.dot(d) - r * s, p.length_squared() - r * r);
        let roots = quadratic(a, b, c)?.map(|t| start + t);
        nearest(roots, t_min, t_max, |t| (0.0..=self.length).contains(&(height + t * climb)))
    }

    /// The unit normal at a point of the surface, on the front.
    pub fn normal_at(&self, point: Vec3) -> Vec3 {
        let from = point - self.base;
        let out = from - self.axis * from.dot(self.axis);
        let n = out.try_normalize().map_or(-self.axis * self.slope().signum(), |out| (out - self.axis * self.slope()).normalize());
        if self.inward { -n } else { n }
    }

    /// The box round it.
    pub fn bounds(&self) -> Bounds {
        let reach = Vec3::ONE - self.axis * self.axis;
        let reach = Vec3::new(reach.x.max(0.0).sqrt(), reach.y.max(0.0).sqrt(), reach.z.max(0.0).sqrt());
        let disk = |center: Vec3, r: f64| Bounds { min: center - reach * r, max: center + reach * r };
        disk(self.base, self.radii[0]).join(disk(self.base + self.axis * self.length, self.radii[1]))
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        PI * (self.radii[0] + self.radii[1]) * self.length.hypot(self.radii[1] - self.radii[0])
    }

    /// A point, uniform in area over `u` in the unit square.
    pub fn sample(&self, u: [f64; 2]) -> Vec3 {
        // The area up to a height grows as the difference of squared radii; solved for the height in a form that holds for cylinders.
        let [r0, r1] = self.radii;
        let root = (r0 * r0 + u[0] * (r1 * r1 - r0 * r0)).max(0.0).sqrt();
        let h = if root + r0 > 0.0 { u[0] * (r0 + r1) / (root + r0) } else { 0.0 };
        let frame = Frame::around(self.axis);
        let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
        self.base + self.axis * (h * self.length) + (frame.s * cos + frame.t * sin) * root
    }
}

impl Ring {
    /// The distance of the hit with `t_min < t < t_max`.
    pub fn intersect(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<f64> {
        let from = Ray::new(ray.origin - self.center, ray.direction);
        let t = plane(&from, self.normal, 0.0)?;
        let r2 = from.at(t).length_squared();
        (t > t_min && t < t_max && r2 >= self.inner * self.inner && r2 <= self.outer * self.outer).then_some(t)
    }

    /// The box round it.
    pub fn bounds(&self) -> Bounds {
        Cone { base: self.center, axis: self.normal, length: 0.0, radii: [self.outer; 2], inward: false }.bounds()
    }

    /// Its area.
    pub fn area(&self) -> f64 {
        PI * (self.outer * self.outer - self.inner * self.inner)
    }

    /// A point, uniform in area over `u` in the unit square.
    pub fn sample(&self, u: [f64; 2]) -> Vec3 {
        let (a, b) = (self.inner * self.inner, self.outer * self.outer);
        let frame = Frame::around(self.normal);
        let (sin, cos) = (2.0 * PI * u[1]).sin_cos();
        self.center + (frame.s * cos + frame.t * sin) * (a + u[0] * (b - a)).sqrt()
    }
}

/// The real roots of a t² + 2 b t + c, ascending, without cancellation (Press et al. 1992, eq. 5.6.4).
fn quadratic(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let square = b * b - a * c;
    if square < 0.0 {
        return None;
    }
    let q = -(b + square.sqrt().copysign(b));
    let (t, u) = (q / a, c / q);
    match (t.is_finite(), u.is_finite()) {
        (true, true) => Some([t.min(u), t.max(u)]),
        (true, false) => Some([t; 2]),
        (false, true) => Some([u; 2]),
        (false, false) => None,
    }
}

/// The first of two ascending roots that is in the open range and accepted.
fn nearest(roots: [f64; 2], t_min: f64, t_max: f64, accept: impl Fn(f64) -> bool) -> Option<f64> {
    roots.into_iter().find(|&t| t > t_min && t < t_max && accept(t))
}
