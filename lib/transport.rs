//! The basis: the picture as a function of one unknown material, without tracing again.
//!
//! Where one material is unknown, a picture is a sum of pictures that do not depend on its colours, each times a number that does. Those
//! pictures are the columns of a basis. What cannot be split off like that (roughness, transmissivity) is sampled at a few nodes, all of them on
//! the same paths; the index of refraction bends the paths, and has a basis for each node. Choices on a path never depend on what is unknown.

mod clear;
mod rough;

pub use clear::Clear;
pub use rough::{Alpha, Monomials, ORDER, Rough};

use crate::geometry::Ray;
use crate::integrator::{Integrator, Transport};
use crate::render::Lens;
use crate::rules::Rules;
use crate::sampling::Sampler;
use crate::world::World;
use rayon::prelude::*;
use wide::f32x8;

/// The number of nodes is a multiple of this.
pub const LANES: usize = 8;

/// Numbers at 8·`L` nodes.
type Nodes<const L: usize> = [f32x8; L];

/// What is unknown, and how it is explored.
pub enum Unknown {
    /// Rough, reflecting and perhaps transmitting.
    Rough(Rough),
    /// Smooth and transparent.
    Clear(Clear),
}

impl Unknown {
    /// The columns of a channel.
    pub fn columns(&self) -> usize {
        match self {
            Self::Rough(rough) => rough.monomials.columns(),
            Self::Clear(clear) => clear.columns(),
        }
    }
}

/// Pixels as functions of the unknown: estimates of the pictures that the products of coefficients multiply.
pub struct Basis {
    /// Independent estimates of each pixel.
    pub sets: usize,
    /// Columns of a channel: [`Monomials::columns`].
    pub columns: usize,
    /// Pixel by pixel, in each set by set, in each channel by channel, in each column by column: the mean over the samples of the set.
    pub values: Vec<f32>,
}

impl Basis {
    /// The columns of the three channels of a pixel in one set.
    pub fn pixel(&self, pixel: usize, set: usize) -> &[f32] {
        let width = 3 * self.columns;
        &self.values[(pixel * self.sets + set) * width..][..width]
    }
}

/// What to trace a basis of: pixels by their numbers, and what the lens makes of these.
pub struct Pixels<'a> {
    /// The numbers.
    pub numbers: &'a [usize],
    /// The rays of a pixel.
    pub lens: Lens<'a>,
}

/// Traces the basis of some pixels: `sets` independent estimates of `samples` samples each. `seed` makes one tracing independent of another.
pub fn trace(world: &World, rules: &Rules, unknown: &Unknown, pixels: &Pixels, sets: usize, samples: u32, seed: u64) -> Basis {
    let columns = unknown.columns();
    let mut values = vec![0f32; pixels.numbers.len() * sets * 3 * columns];
    let pixel_width = sets * 3 * columns;
    values.par_chunks_mut(pixel_width * 8).zip(pixels.numbers.par_chunks(8)).for_each(|(values, numbers)| {
        let pieces = numbers
            .iter()
            .zip(values.chunks_exact_mut(pixel_width))
            .flat_map(|(&n, v)| v.chunks_exact_mut(3 * columns).enumerate().map(move |(set, v)| (n, set, v)));
        let sample = Samples { lens: pixels.lens, count: samples, seed };
        match unknown {
            Unknown::Rough(rough) if rough.nodes.len() == LANES => {
                sample.trace(world, rules, pieces, |columns| rough::Tagging::<1> { rules, unknown: rough, columns });
            }
            Unknown::Rough(rough) => sample.trace(world, rules, pieces, |columns| rough::Tagging::<2> { rules, unknown: rough, columns }),
            Unknown::Clear(clear) => sample.trace(world, rules, pieces, |columns| clear::Dimming { rules, unknown: clear, columns }),
        }
    });
    Basis { sets, columns, values }
}

/// The samples of each pixel.
struct Samples<'a> {
    lens: Lens<'a>,
    count: u32,
    seed: u64,
}

impl Samples<'_> {
    /// Traces the pieces (number of a pixel, set, columns), with the transport that `transport` makes of the columns.
    fn trace<'c, T>(
        &self,
        world: &World,
        rules: &Rules,
        pieces: impl Iterator<Item = (usize, usize, &'c mut [f32])>,
        transport: impl Fn(&'c mut [f32]) -> T,
    ) where
        T: Finish<'c>,
    {
        let mut integrator = Integrator::<T::Beta>::new(world, rules);
        for (number, set, columns) in pieces {
            let mut transport = transport(columns);
            for index in 0..self.count {
                let mut sampler = Sampler::new(self.seed, number as u64, set as u32, index);
                let at = sampler.pair();
                if let Some((origin, direction, limit)) = (self.lens)(number, at) {
                    integrator.trace(&mut transport, Ray { origin, direction }, limit, sampler);
                }
            }
            transport.columns().iter_mut().for_each(|v| *v /= self.count as f32);
        }
    }
}

/// A transport that adds up columns.
trait Finish<'c>: Transport {
    /// The columns.
    fn columns(self) -> &'c mut [f32];
}

impl<'c, const L: usize> Finish<'c> for rough::Tagging<'c, L> {
    fn columns(self) -> &'c mut [f32] {
        self.columns
    }
}

impl<'c> Finish<'c> for clear::Dimming<'c> {
    fn columns(self) -> &'c mut [f32] {
        self.columns
    }
}
