//! A material that is described by expressions (BRTDfunc): what it reflects and transmits straight, and how it scatters light sources.

use super::compile::{self, Sources};
use super::frame::{At, Frame};
use crate::cal::{Program, Ray};
use crate::color::Rgb;
use crate::error::Result;
use crate::rad::Primitive;
use crate::vector::{Mat3, Vec3};

/// The compiled expressions and functions of a BRTDfunc.
#[derive(Debug)]
pub struct Functions {
    frame: Frame,
    /// The coefficients of the mirror direction, and of the straight one; `None` where all are 0.
    straight: [Option<Program>; 2],
    /// For red, green and blue, the scattering of a light source as a function of its direction and solid angle; `None` where it is 0.
    sources: [Option<Program>; 3],
}

/// What the expressions see of a hit.
#[derive(Clone, Debug)]
pub struct Seen {
    ray: Ray,
    /// From the world's directions to those of the expressions.
    turn: Mat3,
}

impl Functions {
    /// The functions that a primitive describes; `None` for other types.
    ///
    /// # Errors
    /// A file is missing, an expression or function is wrong, arguments are missing.
    pub fn compile(primitive: &Primitive, sources: &mut Sources) -> Result<Option<Self>> {
        if primitive.kind != "BRTDfunc" {
            return Ok(None);
        }
        let (frame, straight, sources) = compile::functions(primitive, sources)?;
        Ok(Some(Self { frame, straight, sources }))
    }

    /// Whether light goes straight through.
    pub fn transmits(&self) -> bool {
        self.straight[1].is_some()
    }

    /// Whether light sources are scattered by a function.
    pub fn scatters(&self) -> bool {
        self.sources.iter().any(Option::is_some)
    }

    /// What the expressions see: the hit, the perturbed normal on the viewer's side and its cosine, the colour of the patterns.
    pub fn seen(&self, at: &At, normal: Vec3, cos: f64, pattern: Rgb) -> Seen {
        let (mut ray, turn) = (self.frame.ray(at), self.frame.turn(at));
        ray.set(Ray::PERTURBED_NORMAL, turn * normal);
        ray.put(Ray::PERTURBED_RDOT, cos.clamp(-1.0, 1.0));
        ray.set(Ray::PATTERN_COLOR, pattern);
        Seen { ray, turn }
    }

    /// The coefficients of the mirror direction and of the straight one; none where they have no value.
    pub fn straight(&self, seen: &Seen) -> [Rgb; 2] {
        let value = |program: &Program| program.eval_all(&seen.ray.context()).map_or(Rgb::ZERO, Rgb::from_array);
        [0, 1].map(|way| self.straight[way].as_ref().map_or(Rgb::ZERO, value))
    }

    /// The scattering, per solid angle and without the cosine, of a light source in the direction `to_light` with the solid angle `omega`;
    /// none where it has no value.
    pub fn source(&self, seen: &Seen, to_light: Vec3, omega: f64) -> Rgb {
        let to_light = seen.turn * to_light;
        let arguments = [to_light.x, to_light.y, to_light.z, omega];
        let mut value = [0.0; 3];
        for (value, program) in value.iter_mut().zip(&self.sources) {
            if let Some(program) = program {
                match program.call::<1>(&seen.ray.context(), &arguments) {
                    Ok([found]) => *value = found,
                    Err(_) => return Rgb::ZERO,
                }
            }
        }
        value.into()
    }
}
