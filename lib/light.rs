//! What lights a point directly: every lamp is sampled, weighted and found per solid angle.
//!
//! A lamp is a surface or a distant source whose material is a light, a spotlight, an illum, or a glow with a radius. Directions
//! point from the lit point to the lamp. How bright it is there is the world's to say.

mod window;

pub use window::Window;

use crate::geometry::{AreaSampler, CYLINDER_BOX, Facing, LightShape, Plane, Ray, SPHERE_BOX, Shape, TINY};
use crate::sampling::cone;
use crate::vector::{Frame, Vec3};
use std::f64::consts::PI;
use window::Seen;

/// A lamp's shape and reach.
#[derive(Clone, Debug)]
pub struct Lamp {
    /// Where it is; of a virtual one, where it is seen.
    pub form: Form,
    /// As RADIANCE's direct calculation sees it.
    pub extent: LightShape,
    /// Its brightness for choosing among lamps: the radiance it emits, in W/(sr·m²), without patterns.
    pub brightness: f64,
    /// What that is multiplied with where it is known how much of a view it lights (see `World::survey`), else 1.
    pub chance: f64,
    /// The distance within which it lights: infinite but for a glow.
    pub radius: f64,
    /// Spotlights: the length of the aim vector, a focal distance behind the lamp.
    pub focus: f64,
    /// Whether it is also found by sampling surfaces: not a spotlight, whose distance law is its own, nor a distant illum, which only what is
    /// aimed at it sees, nor what is seen in a mirror.
    pub shared: bool,
    /// Whether an illum stands in the way of its light: it does before an illum or a glow, which would be counted twice.
    pub weak: bool,
    /// The mirror it is seen in, if it is virtual.
    pub relay: Option<Relay>,
    /// The mirrors it is seen through, where they are seen: what does not see it through all of them it does not light.
    pub windows: Vec<Window>,
}

/// How a virtual lamp is reached: by way of a mirror.
#[derive(Clone, Copy, Debug)]
pub struct Relay {
    /// The surface that is the mirror.
    pub mirror: u32,
    /// Its plane.
    pub plane: Plane,
    /// The lamp that is seen in it, perhaps virtual itself.
    pub lamp: usize,
}

/// Where a lamp is.
#[derive(Clone, Debug)]
pub enum Form {
    /// A distant cone of directions around an axis, and 1 − cos of its half angle.
    Distant(Vec3, f64),
    /// A surface, ready to be sampled.
    Shape(Box<(Shape, AreaSampler)>),
}

impl Form {
    /// A surface as a lamp.
    pub fn of(shape: Shape) -> Self {
        let sampler = AreaSampler::new(&shape);
        Self::Shape(Box::new((shape, sampler)))
    }

    /// As it is seen in a mirror; `None` for what degenerates there.
    fn reflected(&self, mirror: &Plane) -> Option<Self> {
        Some(match self {
            Self::Distant(axis, spread) => Self::Distant(mirror.vector(*axis), *spread),
            Self::Shape(surface) => Self::of(surface.0.reflected(mirror)?),
        })
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
                let (shape, area) = &**surface;
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
        // RADIANCE's law of distance of a spotlight reckons from where its samples are, too.
        self.lights(from, sample.distance).then_some(self.focused(sample, self.measured(from, sample.distance)))
    }

    /// How far RADIANCE takes a point of it to be that is so far away from `from`: as far as its samples are, which for a sphere is its centre;
    /// for a distant lamp infinitely far.
    fn measured(&self, from: Vec3, distance: f64) -> f64 {
        match self.extent.facing {
            Facing::All if distance < f64::INFINITY => self.extent.center.distance(from),
            _ => distance,
        }
    }

    /// Whether a point of it, so far away, lights the place `from`: a glow does within its radius.
    pub fn lights(&self, from: Vec3, distance: f64) -> bool {
        self.radius == f64::INFINITY || self.measured(from, distance) <= self.radius
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
                let (shape, area) = &**surface;
                let ray = Ray { origin: from, direction };
                let Some(t) = shape.intersect(&ray, 0.0, f64::INFINITY).filter(|&t| self.lights(from, t)) else { return 0.0 };
                if let Some((_, spread)) = cap(shape, from) {
                    return 1.0 / (2.0 * PI * spread);
                }
                let cos = -direction.dot(shape.normal_at(from + direction * t));
                if cos > 0.0 { t * t / (cos * area.area()) } else { 0.0 }
            }
        }
    }

    /// Shows `out` the samples that RADIANCE's direct calculation takes: the centre of each part, moved at random over the
    /// fraction `jitter` of its extent, and the solid angle it stands for. A surface is divided until its parts are smaller than
    /// `fraction` of their distance; 0 leaves it whole.
    pub fn parts(&self, from: Vec3, jitter: f64, fraction: f64, draw: &mut dyn FnMut() -> [f64; 2], out: &mut dyn FnMut(ToLamp)) {
        let distant = matches!(self.form, Form::Distant(..));
        self.extent.divided(distant, from, fraction, &mut |Part { middle, size }| {
            let mut at = middle;
            if jitter > 0.0 {
                let ([u, v], w) = (draw(), if matches!(self.extent.facing, Facing::Front(_)) { 0.5 } else { draw()[0] });
                at = std::array::from_fn(|i| middle[i] + jitter * (1.0 - 2.0 * [u, v, w][i]) * size[i]);
            }
            // RADIANCE (srcsamp.c) draws what is undivided in only if it is jittered by more than this.
            if self.extent.round && (size != WHOLE.size || jitter > 0.7) {
                at = self.rounded(at);
            }
            let sample = self.toward(from, at, size);
            sample.filter(|s| s.distance <= self.radius).map(|s| self.focused(s, s.distance)).into_iter().for_each(&mut *out);
        });
    }

    /// A point of the box, in half edges, drawn in to where the round light is that it stands for.
    fn rounded(&self, [u, v, w]: [f64; 3]) -> [f64; 3] {
        if self.extent.half_edges[2] == Vec3::ZERO {
            // The square of equal area becomes the disk.
            let reach = 2.0 / PI.sqrt();
            return [u * reach * (1.0 - 0.5 * v * v).sqrt(), v * reach * (1.0 - 0.5 * u * u).sqrt(), 0.0];
        }
        let (largest, sum) = ((u * u).max(v * v).max(w * w), u * u + v * v + w * w);
        let reach = if sum > 1e-12 { (largest / sum).sqrt() / SPHERE_BOX } else { 0.0 };
        [u * reach, v * reach, w * reach]
    }

    /// The direction to a point of the box, in half edges, that stands for a part of the size `size` of it.
    fn toward(&self, from: Vec3, at: [f64; 3], size: [f64; 3]) -> Option<ToLamp> {
        let LightShape { center, half_edges: [a, b, c], .. } = self.extent;
        let place = center + a * at[0] + b * at[1] + c * at[2];
        if let Form::Distant(..) = self.form {
            return Some(ToLamp { direction: place.normalize(), distance: f64::INFINITY, omega: self.extent.size });
        }
        let (distance, direction) = ((place - from).length(), (place - from).try_normalize()?);
        let seen = match self.extent.facing {
            Facing::Front(normal) => -direction.dot(normal) * size[0] * size[1],
            Facing::Across(axis) => direction.cross(axis).length() * size[0],
            Facing::All => 1.0,
        };
        (seen > 1e-4).then(|| ToLamp { direction, distance, omega: self.extent.size * seen / (distance * distance) })
    }

    /// The lamp as it is seen in a mirror, which has this outline and reflects this part of the light; `None` if no light of it gets there.
    pub fn reflected(&self, relay: Relay, outline: &Window, reflectance: f64) -> Option<Self> {
        let distant = matches!(self.form, Form::Distant(..));
        if !self.extent.in_front_of(&relay.plane, distant) || !self.windows.iter().all(|window| self.passes(window, outline)) {
            return None;
        }
        let before = self.windows.iter().map(|window| window.reflected(&relay.plane));
        Some(Self {
            form: self.form.reflected(&relay.plane)?,
            extent: self.extent.reflected(&relay.plane, distant),
            brightness: self.brightness * reflectance,
            shared: false,
            weak: false,
            relay: Some(relay),
            windows: before.chain([outline.clone()]).collect(),
            ..*self
        })
    }

    /// Whether its light may pass a window and reach another: whether nothing shows that it does not.
    fn passes(&self, window: &Window, next: &Window) -> bool {
        match &self.form {
            Form::Distant(axis, spread) => {
                let apart = next.center - window.center;
                let wider = apart.length() * sine(*spread) / (1.0 - spread);
                *spread >= 0.5 || apart.reject_from_normalized(*axis).length() <= window.radius + next.radius + wider
            }
            Form::Shape(surface) => {
                // All that passes is moved so that it comes from the middle.
                let (center, radius) = surface.0.bounds().ball();
                let seen = |window: &Window| Seen::ball((window.center, window.radius + radius), center);
                seen(window).meets(&seen(next))
            }
        }
    }

    /// Whether it may be seen from a place through all its mirrors.
    fn may_be_seen(&self, from: Vec3) -> bool {
        self.windows.is_empty() || {
            let seen = match &self.form {
                Form::Distant(axis, spread) => Seen { to: *axis, sin: sine(*spread) },
                Form::Shape(surface) => Seen::ball(surface.0.bounds().ball(), from),
            };
            self.windows.iter().all(|window| window.may_show(&seen, from))
        }
    }

    /// How much it may light a point at `from`, for choosing among lamps: never 0 where it does.
    pub fn importance(&self, from: Vec3) -> f64 {
        if self.relay.is_some_and(|r| r.plane.height(from) <= 0.0) || !self.may_be_seen(from) {
            return 0.0;
        }
        self.brightness
            * self.chance
            * match &self.form {
                Form::Distant(_, spread) => 2.0 * PI * spread,
                Form::Shape(surface) => {
                    let (shape, area) = &**surface;
                    let bounds = shape.bounds();
                    // Beyond its radius a glow lights nothing, whatever point of it is taken.
                    if from.distance(from.clamp(bounds.min, bounds.max)) > self.radius {
                        0.0
                    } else {
                        area.area() / self.extent.center.distance_squared(from).max(bounds.ball().1.powi(2))
                    }
                }
            }
    }

    /// A spotlight's light falls off from its focus, behind the lamp, which is at this distance.
    fn focused(&self, sample: ToLamp, distance: f64) -> ToLamp {
        if self.focus == 0.0 || distance == f64::INFINITY {
            return sample;
        }
        ToLamp { omega: sample.omega * (distance / (distance + self.focus)).powi(2), ..sample }
    }
}

/// The sine of the half angle whose 1 − cos this is.
fn sine(spread: f64) -> f64 {
    (spread * (2.0 - spread)).sqrt()
}

/// For a sphere seen from outside: its centre, and 1 − cos of the half angle it subtends.
fn cap(shape: &Shape, from: Vec3) -> Option<(Vec3, f64)> {
    let Shape::Sphere(sphere) = shape else { return None };
    let spread = subtended(sphere.center, sphere.radius, from)?;
    (!sphere.inward).then_some((sphere.center, spread))
}

/// 1 − cos of the half angle that a ball subtends; `None` from within.
pub fn subtended(center: Vec3, radius: f64, from: Vec3) -> Option<f64> {
    let sin2 = radius * radius / center.distance_squared(from);
    // 1 − cos without cancellation for a small ball.
    (sin2 < 1.0).then(|| sin2 / (1.0 + (1.0 - sin2).sqrt()))
}

/// The most parts that a light is divided into.
const MOST_PARTS: usize = 64;

/// A part of a light's box.
#[derive(Clone, Copy)]
struct Part {
    /// Its middle, in half edges of the box.
    middle: [f64; 3],
    /// Its size, as fractions of the box's.
    size: [f64; 3],
}

/// All of it.
const WHOLE: Part = Part { middle: [0.0; 3], size: [1.0; 3] };

impl LightShape {
    /// Shows `out` the parts that a light is divided into for a point, by RADIANCE's rule: the longer side is halved until both are shorter than
    /// `fraction` of the distance to the part's middle.
    fn divided(&self, distant: bool, from: Vec3, fraction: f64, out: &mut dyn FnMut(Part)) {
        if distant || !(fraction > TINY) {
            return out(WHOLE);
        }
        let [u, v, _] = self.half_edges;
        let to = from - self.center;
        match self.facing {
            Facing::All => out(WHOLE),
            Facing::Front(normal) => {
                let far = |e: Vec3| e.length_squared() * 4.0 / (fraction * fraction);
                if to.dot(normal) > 0.0 {
                    self.divide(WHOLE, from, [far(u), far(v)], MOST_PARTS, out);
                }
            }
            Facing::Across(axis) => {
                let (across, far) = (to.cross(axis).length_squared(), u.length_squared() * 4.0 / (fraction * fraction));
                // The square of its radius.
                let near = v.length_squared() / CYLINDER_BOX.powi(2);
                if across > 4.0 * near && to.length_squared() < far {
                    self.divide(WHOLE, from, [far, 0.0], MOST_PARTS, out);
                } else if across > near {
                    out(WHOLE);
                }
            }
        }
    }

    /// Divides a part while it is nearer than the square roots of `far`, into at most `most`.
    fn divide(&self, part: Part, from: Vec3, far: [f64; 2], most: usize, out: &mut dyn FnMut(Part)) {
        let middle = self.center + self.half_edges[0] * part.middle[0] + self.half_edges[1] * part.middle[1];
        let distance = middle.distance_squared(from);
        if most < 2 || distance >= far[0] && distance >= far[1] {
            return out(part);
        }
        let side = (far[0] <= far[1]) as usize;
        let (mut half, mut nearer) = (part, far);
        half.size[side] /= 2.0;
        nearer[side] /= 4.0;
        for sign in [-1.0, 1.0] {
            let mut half = half;
            half.middle[side] += sign * half.size[side];
            self.divide(half, from, nearer, most / 2, out);
        }
    }
}
