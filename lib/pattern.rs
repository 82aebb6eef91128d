//! What patterns and textures do at a hit: a factor for the colour, a nudge of the normal, the share of one material in a mixture.
//!
//! A [`Pattern`], [`Texture`] or [`Mixture`] is compiled from a primitive; the [`Sources`] keep what several share: function files, data
//! files, pictures. Where an expression turns out to have no value, the pattern or texture leaves everything as it is.

mod compile;
mod frame;
mod functions;
mod mapping;
mod raster;
mod table;

pub use compile::Sources;
pub use frame::At;
pub use functions::{Functions, Seen};
pub use mapping::{Angular, LatLong, Mapping};
pub use raster::Raster;
pub use table::Table;

use crate::cal::{Context, Failed, Program, Ray};
use crate::color::Rgb;
use crate::error::{Result, Span};
use crate::rad::Primitive;
use crate::vector::Vec3;
use frame::Frame;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use table::MAX_DIMENSIONS;

/// A compiled colorpict, colorfunc, brightfunc, colordata or brightdata.
#[derive(Debug)]
pub struct Pattern(Expressions);

/// A compiled texfunc or texdata.
#[derive(Debug)]
pub struct Texture(Expressions);

/// The coefficient of a compiled mixfunc, mixpict or mixdata.
#[derive(Debug)]
pub struct Mixture(Expressions);

/// What a primitive says of a hit, compiled.
#[derive(Debug)]
pub struct Expressions {
    frame: Frame,
    kind: Kind,
    place: Span,
    name: String,
    /// Whether they had no value for some hit.
    failed: AtomicBool,
}

/// Where three values come from.
#[derive(Debug)]
enum Kind {
    Constant(Vec3),
    /// A program of one value, for all three.
    One(Program),
    /// A program of three values.
    Three(Program),
    Picture(Arc<Raster>, Mapping, Apply),
    /// A data file, its coordinates, what becomes of the value, for all three.
    OneTable(Arc<Table>, Program, Apply),
    /// A data file for each, their coordinates, what becomes of the values.
    ThreeTables([Arc<Table>; 3], Program, Apply),
}

/// What functions make of values that were looked up.
#[derive(Debug)]
enum Apply {
    /// Each stays as it is, as with `noop`.
    Keep,
    /// Each is at least 0, as with `red green blue`.
    AtLeastZero,
    /// Three functions of three values.
    Three(Program),
    /// One function of three values.
    OneOfThree(Program),
    /// One function of the first value.
    One(Program),
}

impl Pattern {
    /// Its expressions.
    pub fn expressions(&self) -> &Expressions {
        &self.0
    }

    /// The pattern that a primitive describes; `None` for other types.
    ///
    /// # Errors
    /// A file is missing, an expression or function is wrong, arguments are missing.
    pub fn compile(primitive: &Primitive, sources: &mut Sources) -> Result<Option<Self>> {
        const TYPES: [&str; 5] = ["colorpict", "colorfunc", "brightfunc", "colordata", "brightdata"];
        Ok(compile::compile(primitive, sources, &TYPES)?.map(Self))
    }

    /// The factor for red, green and blue. Negative values and values above 1 are allowed.
    #[inline]
    pub fn color(&self, at: &At) -> Rgb {
        self.evaluate(at).unwrap_or(Rgb::ONE)
    }

    /// [`Pattern::color`], or that it has no value.
    ///
    /// # Errors
    /// The expressions have no value for this hit.
    #[inline]
    pub fn evaluate(&self, at: &At) -> std::result::Result<Rgb, Failed> {
        self.0.values(at)
    }
}

impl Texture {
    /// Its expressions.
    pub fn expressions(&self) -> &Expressions {
        &self.0
    }

    /// The texture that a primitive describes; `None` for other types.
    ///
    /// # Errors
    /// A file is missing, an expression or function is wrong, arguments are missing.
    pub fn compile(primitive: &Primitive, sources: &mut Sources) -> Result<Option<Self>> {
        Ok(compile::compile(primitive, sources, &["texfunc", "texdata"])?.map(Self))
    }

    /// The direction of the first tangent of an anisotropic material, given like a texture; `None` for other types.
    ///
    /// # Errors
    /// An expression is wrong or missing.
    pub fn orientation(primitive: &Primitive, sources: &mut Sources) -> Result<Option<Self>> {
        Ok(compile::compile(primitive, sources, &["plastic2", "metal2", "trans2", "ashik2"])?.map(Self))
    }

    /// What is added to the unit normal, in world coordinates; zero where the expressions have no value.
    pub fn perturbation(&self, at: &At) -> Vec3 {
        self.evaluate(at).unwrap_or(Vec3::ZERO)
    }

    /// [`Texture::perturbation`], or that it has no value.
    ///
    /// # Errors
    /// The expressions have no value for this hit.
    pub fn evaluate(&self, at: &At) -> std::result::Result<Vec3, Failed> {
        Ok(self.0.frame.to_world(at, self.0.values(at)?))
    }
}

impl Mixture {
    /// Its expressions.
    pub fn expressions(&self) -> &Expressions {
        &self.0
    }

    /// The coefficient of the mixture that a primitive describes; `None` for other types.
    ///
    /// # Errors
    /// A file is missing, an expression or function is wrong, arguments are missing.
    pub fn compile(primitive: &Primitive, sources: &mut Sources) -> Result<Option<Self>> {
        Ok(compile::compile(primitive, sources, &["mixfunc", "mixpict", "mixdata"])?.map(Self))
    }

    /// The share of the foreground, from 0 to 1.
    ///
    /// # Errors
    /// The expressions have no value for this hit: the mixture then is no material at all.
    pub fn coefficient(&self, at: &At) -> std::result::Result<f64, Failed> {
        Ok(self.0.values(at)?.x.clamp(0.0, 1.0))
    }
}

impl Expressions {
    fn values(&self, at: &At) -> std::result::Result<Vec3, Failed> {
        self.kind.values(&self.frame, at).inspect_err(|_| {
            if !self.failed.load(Relaxed) {
                self.failed.store(true, Relaxed);
            }
        })
    }

    /// What is to be said if they had no value for some hit.
    pub fn failure(&self) -> Option<String> {
        let why = "it divides by 0, leaves what a function is defined for, calls itself too deep, or uses what only other types know";
        let message = || format!("`{}` has no value for some rays, which do as without it: {why}", self.name);
        self.failed.load(Relaxed).then(|| self.place.error(message()).remark())
    }
}

impl Kind {
    /// The values at a hit. What most environments are, a picture by the direction of a ray, is looked up without further ado.
    #[inline]
    fn values(&self, frame: &Frame, at: &At) -> std::result::Result<Vec3, Failed> {
        if let Self::Picture(raster, Mapping::LatLong(mapping), Apply::AtLeastZero) = self {
            return Ok(Vec3::from_array(raster.value(mapping.place(frame.direction(at)))).max(Vec3::ZERO));
        }
        self.general(frame, at)
    }

    #[inline(never)]
    fn general(&self, frame: &Frame, at: &At) -> std::result::Result<Vec3, Failed> {
        match self {
            Self::Constant(values) => Ok(*values),
            Self::Picture(raster, mapping, apply) => {
                let place = mapping.place(frame.direction(at), || frame.ray(at))?;
                apply.to(raster.value(place), || frame.ray(at))
            }
            Self::One(program) => Ok(Vec3::splat(program.eval(&frame.ray(at).context())?)),
            Self::Three(program) => Ok(Vec3::from_array(program.eval_all(&frame.ray(at).context())?)),
            Self::OneTable(table, coordinates, apply) => {
                let ray = frame.ray(at);
                let place = place(coordinates, &ray.context(), table.dimensions())?;
                apply.to([table.value(&place); 3], || ray)
            }
            Self::ThreeTables(tables, coordinates, apply) => {
                let ray = frame.ray(at);
                let dimensions = tables.iter().map(|table| table.dimensions()).max().unwrap_or(0);
                let place = place(coordinates, &ray.context(), dimensions)?;
                apply.to([0, 1, 2].map(|i| tables[i].value(&place)), || ray)
            }
        }
    }
}

fn place(coordinates: &Program, context: &Context, dimensions: usize) -> std::result::Result<[f64; MAX_DIMENSIONS], Failed> {
    let mut place = [0.0; MAX_DIMENSIONS];
    coordinates.eval_into(context, &[], &mut place[..dimensions])?;
    Ok(place)
}

impl Apply {
    fn to(&self, values: [f64; 3], ray: impl FnOnce() -> Ray) -> std::result::Result<Vec3, Failed> {
        match self {
            Self::Keep => Ok(Vec3::from_array(values)),
            Self::AtLeastZero => Ok(Vec3::from_array(values).max(Vec3::ZERO)),
            Self::Three(program) => Ok(Vec3::from_array(program.call(&ray().context(), &values)?)),
            Self::OneOfThree(program) => Ok(Vec3::splat(program.call::<1>(&ray().context(), &values)?[0])),
            Self::One(program) => Ok(Vec3::splat(program.call::<1>(&ray().context(), &values[..1])?[0])),
        }
    }
}

#[cfg(test)]
mod tests;
