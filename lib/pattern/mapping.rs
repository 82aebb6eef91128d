//! Which place of a picture a ray sees, without evaluating expressions where a standard mapping of directions is recognised.

use crate::cal::{Failed, Program, Ray};
use crate::vector::Vec3;
use crate::vector::angle::{acos, atan2, polar};
use std::f64::consts::{FRAC_PI_2, PI};

/// From a ray to (u, v).
#[derive(Debug)]
pub enum Mapping {
    /// The same place for all rays.
    Constant([f64; 2]),
    /// The azimuth goes right, the height up.
    LatLong(LatLong),
    /// A disk whose centre is one direction and whose rim the opposite one; the radius goes with the angle.
    Angular(Angular),
    /// Anything else: the program of u and v.
    Program(Program),
}

/// u = u₀ + u₁·azimuth, v = v₀ + v₁·angle from the pole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatLong {
    /// The azimuth is atan2 of these components of the direction: axis and sign.
    pub sine: (usize, f64),
    /// See `sine`.
    pub cosine: (usize, f64),
    /// The azimuth of the pole is 0, instead of atan2's.
    pub guarded: bool,
    /// The axis of the poles.
    pub pole: usize,
    /// The angle comes from atan2 instead of acos, and so is exact close to the poles too.
    pub arctangent: bool,
    /// u₀ and u₁, per radian.
    pub u: [f64; 2],
    /// v₀ and v₁, per radian.
    pub v: [f64; 2],
}

/// u = u₀ + u₁·r·d, v = v₀ + v₁·r·e with r = acos(±f)/√(d²+e²), where d, e, f are components of the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angular {
    /// The axes d and e.
    pub across: [usize; 2],
    /// The axis f, and the sign that makes it point to the centre.
    pub forward: (usize, f64),
    /// u₀ and u₁.
    pub u: [f64; 2],
    /// v₀ and v₁.
    pub v: [f64; 2],
}

impl Mapping {
    /// The mapping of a program of u and v. A standard mapping stands in for it only if they agree to 1e-12 for thousands of directions,
    /// the poles, the seams and their surroundings among them.
    pub fn recognize(program: Program) -> Self {
        if let Some(uv) = program.constant().and_then(|_| program.eval_all(&Default::default()).ok()) {
            return Self::Constant(uv);
        }
        if program.reads_only(Ray::DIRECTION..Ray::DIRECTION + 3) {
            let value = |d: Vec3| program.eval_all::<2>(&Ray::new(d, -d, Vec3::ZERO).context());
            if let Some(found) = lat_longs(&value).into_iter().find(|m| agrees(&value, |d| m.place(d))) {
                return Self::LatLong(found);
            }
            if let Some(found) = angulars(&value).into_iter().find(|m| agrees(&value, |d| m.place(d))) {
                return Self::Angular(found);
            }
        }
        Self::Program(program)
    }

    /// The place that a unit direction sees, in the frame of the pattern; `ray` gives the other ray variables if they are needed.
    ///
    /// # Errors
    /// The expressions have no value.
    pub fn place(&self, direction: Vec3, ray: impl FnOnce() -> Ray) -> Result<[f64; 2], Failed> {
        match self {
            Self::Constant(uv) => Ok(*uv),
            Self::LatLong(mapping) => Ok(mapping.place(direction)),
            Self::Angular(mapping) => Ok(mapping.place(direction)),
            Self::Program(program) => program.eval_all(&ray().context()),
        }
    }
}

impl LatLong {
    /// (u, v) of a unit direction.
    #[inline]
    pub fn place(&self, direction: Vec3) -> [f64; 2] {
        let d = direction.to_array();
        let (y, x, z) = (self.sine.1 * d[self.sine.0], self.cosine.1 * d[self.cosine.0], d[self.pole]);
        let across = x * x + y * y;
        let [azimuth, angle] = if self.arctangent { atan2([y, across.sqrt()], [x, z]) } else { polar([y, x], z) };
        let azimuth = if self.guarded && across <= 0.0 { 0.0 } else { azimuth };
        [self.u[0] + self.u[1] * azimuth, self.v[0] + self.v[1] * angle]
    }
}

impl Angular {
    /// (u, v) of a unit direction.
    #[inline]
    pub fn place(&self, direction: Vec3) -> [f64; 2] {
        let d = direction.to_array();
        let (a, b, f) = (d[self.across[0]], d[self.across[1]], self.forward.1 * d[self.forward.0]);
        let distance = (a * a + b * b).sqrt();
        let r = if distance > 0.0 { acos(f) / distance } else { 0.0 };
        [self.u[0] + self.u[1] * a * r, self.v[0] + self.v[1] * b * r]
    }
}

/// What a program gives for a direction.
type Value<'a> = &'a dyn Fn(Vec3) -> Result<[f64; 2], Failed>;

fn axis((axis, sign): (usize, f64)) -> Vec3 {
    let mut d = [0.0; 3];
    d[axis] = sign;
    Vec3::from_array(d)
}

/// All lat-long mappings whose coefficients fit the program at a few directions.
fn lat_longs(value: Value) -> Vec<LatLong> {
    let mut found = Vec::new();
    for pole in 0..3 {
        let level = [(pole + 1) % 3, (pole + 2) % 3];
        let (Ok(top), Ok(bottom)) = (value(axis((pole, 1.0))), value(axis((pole, -1.0)))) else { continue };
        let v = [top[1], (bottom[1] - top[1]) / PI];
        for i in 0..16 {
            let sign = |bit: usize| if i >> bit & 1 == 0 { 1.0 } else { -1.0 };
            let (sine, cosine) = ((level[i & 1], sign(1)), (level[1 - (i & 1)], sign(2)));
            let (Ok(zero), Ok(quarter)) = (value(axis(cosine)), value(axis(sine))) else { continue };
            let u = [zero[0], (quarter[0] - zero[0]) / FRAC_PI_2];
            let candidate = LatLong { sine, cosine, guarded: i >> 3 == 1, pole, arctangent: false, u, v };
            found.extend([candidate, LatLong { arctangent: true, ..candidate }]);
        }
    }
    found
}

/// All angular mappings whose coefficients fit the program at a few directions.
fn angulars(value: Value) -> Vec<Angular> {
    let mut found = Vec::new();
    for forward in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
        for swap in [1, 2] {
            let across = [(forward.0 + swap) % 3, (forward.0 + 3 - swap) % 3];
            let places = [axis(forward), axis((across[0], 1.0)), axis((across[1], 1.0))].map(value);
            if let [Ok(centre), Ok(right), Ok(up)] = places {
                let u = [centre[0], (right[0] - centre[0]) / FRAC_PI_2];
                let v = [centre[1], (up[1] - centre[1]) / FRAC_PI_2];
                found.push(Angular { across, forward, u, v });
            }
        }
    }
    found
}

/// Whether two mappings are the same for all that matters.
fn agrees(value: Value, mapping: impl Fn(Vec3) -> [f64; 2]) -> bool {
    directions().all(|d| match value(d) {
        Ok(uv) => mapping(d).iter().zip(uv).all(|(a, b)| (a - b).abs() <= 1e-12),
        Err(Failed) => false,
    })
}

/// Unit directions that a mapping is tried on: first the axes and their surroundings, then an even spread over the sphere.
fn directions() -> impl Iterator<Item = Vec3> {
    const SPREAD: usize = 2000;
    const NEAR: [f64; 9] = [0.0, -0.0, 1e-300, -1e-300, 1e-16, 1e-9, -1e-9, 1e-4, -1e-4];
    let special = (0..6).flat_map(|i| {
        let (main, sign) = (i >> 1, if i & 1 == 0 { 1.0 } else { -1.0 });
        NEAR.iter().flat_map(move |&a| NEAR.iter().map(move |&b| (a, b))).map(move |(a, b)| {
            let mut d = [a, a, a];
            d[(main + 1) % 3] = b;
            d[main] = sign;
            Vec3::from_array(d).normalize()
        })
    });
    // Great circles through the axes, where seams lie.
    let circles = (0..3).flat_map(|flat| {
        (0..48).flat_map(move |i| {
            [0.0, -0.0, 1e-12, -1e-12].into_iter().map(move |off| {
                let (sin, cos) = (f64::from(i) * 0.1309).sin_cos();
                let mut d = [sin, cos, off];
                d.rotate_right(flat);
                Vec3::from_array(d).normalize()
            })
        })
    });
    // A spiral of equal steps in height (Fibonacci sphere).
    let spread = (0..SPREAD).map(|i| {
        let z = 1.0 - (2 * i + 1) as f64 / SPREAD as f64;
        let (sin, cos) = (i as f64 * 2.399963229728653).sin_cos();
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * cos, r * sin, z).normalize()
    });
    special.chain(circles).chain(spread)
}
