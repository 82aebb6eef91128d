//! A flat mirror as a window: what is not seen through it, its virtual lamps do not light.

use crate::geometry::{Plane, Shape};
use crate::vector::Vec3;

/// The outline of a flat mirror.
#[derive(Clone, Debug)]
pub struct Window {
    /// The corners of a convex polygon, in order; none of another outline.
    corners: Vec<Vec3>,
    /// The middle of a ball round it.
    pub center: Vec3,
    /// Its radius.
    pub radius: f64,
}

/// Something round that is seen: the unit vector to its middle, and the sine of the angle from there to its rim; 1 from within.
pub(super) struct Seen {
    pub to: Vec3,
    pub sin: f64,
}

/// What is rounded.
const SLACK: f64 = 1e-6;

impl Seen {
    /// A ball, seen from a place.
    pub fn ball((center, radius): (Vec3, f64), from: Vec3) -> Self {
        let (to, distance) = (center - from).normalize_and_length();
        Self { to, sin: if radius < distance { radius / distance } else { 1.0 } }
    }

    /// Whether some direction may lie in both.
    pub fn meets(&self, other: &Self) -> bool {
        let cos = |sin: f64| (1.0 - sin * sin).sqrt();
        let (a, b) = (self.sin, other.sin);
        a.max(b) >= 1.0 || self.to.dot(other.to) >= cos(a) * cos(b) - a * b - SLACK
    }
}

impl Window {
    /// That of a flat surface.
    pub fn new(shape: &Shape) -> Self {
        let (center, radius) = shape.bounds().ball();
        let corners = match shape {
            Shape::Polygon(polygon) => {
                let n = polygon.vertices.len();
                let side = |i: usize| polygon.vertices[(i + 1) % n] - polygon.vertices[i % n];
                let convex = (0..n).all(|i| side(i).cross(side(i + 1)).dot(polygon.normal) >= 0.0);
                if convex { polygon.vertices.to_vec() } else { Vec::new() }
            }
            _ => Vec::new(),
        };
        Self { corners, center, radius }
    }

    /// Where it is seen in another mirror.
    pub fn reflected(&self, mirror: &Plane) -> Self {
        Self { corners: self.corners.iter().map(|&p| mirror.point(p)).collect(), center: mirror.point(self.center), ..*self }
    }

    /// Whether something may be seen through it from a place: whether nothing shows that it is not.
    pub(super) fn may_show(&self, seen: &Seen, from: Vec3) -> bool {
        let own = Seen::ball((self.center, self.radius), from);
        // Beyond the plane through the place and a side is nothing of the window.
        let beyond = |(a, b): (&Vec3, &Vec3)| {
            let normal = (*a - from).cross(*b - from).normalize_or_zero();
            let inward = if normal.dot(own.to) < 0.0 { -normal } else { normal };
            inward.dot(seen.to) < -seen.sin - SLACK
        };
        own.meets(seen) && !self.corners.iter().zip(self.corners.iter().cycle().skip(1)).any(beyond)
    }
}
