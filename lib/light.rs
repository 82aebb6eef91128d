//! What lights a point directly: every lamp is sampled, weighted and found per solid angle.
//!
//! A lamp is a surface or a distant source whose material is a light, a spotlight, an illum, or a glow with a radius. Directions
//! point from the lit point to the lamp. How bright it is there is the world's to say.

use crate::geometry::{AreaSampler, Facing, LightShape, Ray, Shape};
use crate::sampling::cone;
use crate::vector::{Frame, Vec3};
use std::f64::consts::PI;

/// A lamp's shape and reach.
#[derive(Clone, Debug)]
pub struct Lamp {
    /// Where it is.
    pub form: Form,
    /// Its brightness for choosing among lamps: the radiance it emits, without patterns.
    pub brightness: f64,
    /// The distance within which it lights: infinite but for a glow.
    pub radius: f64,
    /// Spotlights: the length of the aim vector, a focal distance behind the lamp.
    pub focus: f64,
    /// Whether it is also found by sampling surfaces: not a spotlight, whose distance law is its own, nor an illum, which only what is aimed at it sees.
    pub shared: bool,
}

/// Where a lamp is.
#[derive(Clone, Debug)]
pub enum Form {
    /// A distant cone of directions around an axis, and 1 − cos of its half angle.
    Distant(Vec3, f64),
    /// A surface, ready to be sampled, and as RADIANCE's one sample sees it.
    Shape(Box<(Shape, AreaSampler, LightShape)>),
}

impl Form {
    /// A surface as a lamp; an error for one that RADIANCE refuses.
    pub fn of(shape: &Shape) -> Result<Self, &'static str> {
        Ok(Self::Shape(Box::new((shape.clone(), AreaSampler::new(shape), shape.light()?))))
    }
}

/// A direction to a lamp.
#[derive(Clone, Copy, Debug)]
pub struct ToLamp {
    /// Unit vector to it.
    pub direction: Vec3,
    /// How far it is; infinite for a distant one.
    pub distance: f64,
    /// The solid angle the sample stands for, in sr: the inverse of its density.
    pub omega: f64,
}

impl Lamp {
    /// A direction to a point of the lamp, uniform over its solid angle (distant lamps and spheres) or over its area, as seen from `from`.
    pub fn sample(&self, from: Vec3, u: [f64; 2]) -> Option<ToLamp> {
        let sample = match &self.form {
            Form::Distant(axis, spread) => {
                ToLamp { direction: Frame::around(*axis).to_world(cone(u, *spread)), distance: f64::INFINITY, omega: 2.0 * PI * spread }
            }
            Form::Shape(surface) => {
                let (shape, area, _) = &**surface;
                if let Some((center, spread)) = cap(shape, from) {
                    let direction = Frame::around((center - from).normalize()).to_world(cone(u, spread));
                    // A direction at the very rim may miss the sphere by rounding.
                    let distance = shape.intersect(&Ray { origin: from, direction }, 0.0, f64::INFINITY)?;
                    ToLamp { direction, distance, omega: 2.0 * PI * spread }
                } else {
                    let point = area.sample(u);
                    let to = point - from;
                    let (distance, direction) = (to.length(), to.normalize());
                    let cos = -direction.dot(shape.normal_at(point));
                    if !(cos > 0.0) {
                        return None;
                    }
                    ToLamp { direction, distance, omega: area.area() * cos / (distance * distance) }
                }
            }
        };
        (sample.distance <= self.radius).then_some(self.focused(sample))
    }

    /// The density per solid angle with which [`Lamp::sample`] finds `direction` from `from`.
    pub fn pdf(&self, from: Vec3, direction: Vec3) -> f64 {
        match &self.form {
            Form::Distant(axis, spread) => {
                if (*axis - direction).length_squared() <= 2.0 * spread * (1.0 + 1e-9) {
                    1.0 / (2.0 * PI * spread)
                } else {
                    0.0
                }
            }
            Form::Shape(surface) => {
                let (shape, area, _) = &**surface;
                let ray = Ray { origin: from, direction };
                let Some(t) = shape.intersect(&ray, 0.0, f64::INFINITY).filter(|&t| t <= self.radius) else { return 0.0 };
                if let Some((_, spread)) = cap(shape, from) {
                    return 1.0 / (2.0 * PI * spread);
                }
                let cos = -direction.dot(shape.normal_at(from + direction * t));
                if cos > 0.0 { t * t / (cos * area.area()) } else { 0.0 }
            }
        }
    }

    /// RADIANCE's one sample (semantics 3.11): the centre, moved at random over the fraction `jitter` of the extent, and the solid angle it takes the lamp to have.
    pub fn centre(&self, from: Vec3, jitter: f64, u: [f64; 3]) -> Option<ToLamp> {
        let sample = match &self.form {
            Form::Distant(axis, spread) => {
                let direction = Frame::around(*axis).to_world(cone([u[0] * jitter * jitter, u[1]], *spread));
                ToLamp { direction, distance: f64::INFINITY, omega: 2.0 * PI * spread }
            }
            Form::Shape(surface) => {
                let light = &surface.2;
                let [a, b, c] = light.half_edges;
                let to = light.center + (a * (2.0 * u[0] - 1.0) + b * (2.0 * u[1] - 1.0) + c * (2.0 * u[2] - 1.0)) * jitter - from;
                let distance = to.length();
                let direction = to / distance;
                let cos = match light.facing {
                    Facing::Front(normal) => -direction.dot(normal),
                    Facing::Across(axis) => direction.cross(axis).length(),
                    Facing::All => 1.0,
                };
                if cos <= 1e-4 {
                    return None;
                }
                ToLamp { direction, distance, omega: light.size * cos / (distance * distance) }
            }
        };
        (sample.distance <= self.radius).then_some(self.focused(sample))
    }

    /// How much it may light a point at `from`, for choosing among lamps: never 0 where it does.
    pub fn importance(&self, from: Vec3) -> f64 {
        self.brightness
            * match &self.form {
                Form::Distant(_, spread) => 2.0 * PI * spread,
                Form::Shape(surface) => {
                    let (shape, area, light) = &**surface;
                    let size = (shape.bounds().max - shape.bounds().min).length_squared() / 4.0;
                    let distance = light.center.distance_squared(from);
                    // Beyond its radius a glow lights nothing, whatever point of it is taken.
                    if self.radius.is_finite() && distance.sqrt() > self.radius + size.sqrt() {
                        0.0
                    } else {
                        area.area() / distance.max(size)
                    }
                }
            }
    }

    /// A spotlight's light falls off from its focus, behind the lamp.
    fn focused(&self, sample: ToLamp) -> ToLamp {
        if self.focus == 0.0 || sample.distance == f64::INFINITY {
            return sample;
        }
        ToLamp { omega: sample.omega * (sample.distance / (sample.distance + self.focus)).powi(2), ..sample }
    }
}

/// For a sphere seen from outside: its centre, and 1 − cos of the half angle it subtends.
fn cap(shape: &Shape, from: Vec3) -> Option<(Vec3, f64)> {
    let Shape::Sphere(sphere) = shape else { return None };
    let sin2 = sphere.radius * sphere.radius / sphere.center.distance_squared(from);
    // 1 − cos without cancellation for a small sphere.
    (sin2 < 1.0 && !sphere.inward).then(|| (sphere.center, sin2 / (1.0 + (1.0 - sin2).sqrt())))
}
