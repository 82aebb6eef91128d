//! The basis: the picture as a function of one unknown material, without tracing again.
//!
//! Where one material is unknown, a picture is a sum of pictures that do not depend on its colours, each times a number that does. Those
//! pictures are the columns of a basis. What cannot be split off like that (roughness, transmissivity) is sampled at a few nodes, all of them on
//! the same paths; the index of refraction bends the paths, and has a basis for each node. Choices on a path never depend on what is unknown.

mod clear;
mod rough;
#[cfg(test)]
mod tests;

pub use clear::Clear;
pub use rough::{Alpha, MOST_NODES, Monomials, ORDER, Rough};

use crate::geometry::Ray;
use crate::integrator::{Integrator, Transport};
use crate::render::Lens;
use crate::rules::Rules;
use crate::sampling::Sampler;
use crate::world::World;
use rayon::prelude::*;
use wide::f32x8;

/// Nodes that are computed with at a time.
pub const LANES: usize = 8;

/// Numbers at 8·`L` nodes.
type Nodes<const L: usize> = [f32x8; L];

/// What is unknown, and how it is explored.
pub enum Unknown {
    /// Rough, reflecting and perhaps transmitting.
    Rough(Box<Rough>),
    /// Smooth and transparent.
    Clear(Box<Clear>),
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
#[derive(Clone)]
pub struct Basis {
    /// Independent estimates of each pixel.
    pub sets: usize,
    /// Columns of a channel: [`Unknown::columns`].
    pub columns: usize,
    /// Samples of each pixel in each set; of several tracings, the number of equal worth.
    pub samples: Vec<f32>,
    /// Pixel by pixel, in each set by set, in each channel by channel, in each column by column: the mean over the samples of the set.
    pub values: Vec<f32>,
}

impl Basis {
    /// The columns of the three channels of a pixel in one set.
    pub fn pixel(&self, pixel: usize, set: usize) -> &[f32] {
        let width = 3 * self.columns;
        &self.values[(pixel * self.sets + set) * width..][..width]
    }

    /// Bases of the same pixels and samples with their columns side by side, in each channel the first basis' first.
    pub fn beside(parts: &[Self]) -> Self {
        let (sets, columns) = (parts[0].sets, parts.iter().map(|p| p.columns).sum());
        let rows = parts[0].values.len() / parts[0].columns;
        let row = |row: usize| parts.iter().flat_map(move |p| &p.values[row * p.columns..(row + 1) * p.columns]);
        Self { sets, columns, samples: parts[0].samples.clone(), values: (0..rows).flat_map(row).copied().collect() }
    }

    /// Takes in the same basis of further pixels.
    pub fn append(&mut self, other: Self) {
        self.samples.extend(other.samples);
        self.values.extend(other.values);
    }

    /// Takes in another tracing of the same pixels, with a part `weight` of the whole. The part is the same for all: a
    /// pixel that counts less of the first tracing because that was bright there would end up too dark.
    pub fn join(&mut self, other: &Self, weight: f32) {
        let (kept, taken) = (1.0 - weight, weight);
        self.values.par_chunks_mut(4096).zip(other.values.par_chunks(4096)).for_each(|(mine, others)| {
            mine.iter_mut().zip(others).for_each(|(m, o)| *m = kept * *m + taken * *o);
        });
        for (mine, other) in self.samples.iter_mut().zip(&other.samples) {
            *mine = 1.0 / (kept * kept / *mine + taken * taken / other);
        }
    }
}

/// What to trace a basis of.
pub struct Pixels<'a> {
    /// The numbers of the pixels, as the lens knows them.
    pub numbers: &'a [usize],
    /// How many samples each gets in each set.
    pub samples: &'a [u32],
    /// The rays of a pixel.
    pub lens: Lens<'a>,
}

/// Traces the basis of some pixels, `sets` independent estimates of it. `seed` makes one tracing independent of another.
pub fn trace(world: &World, rules: &Rules, unknown: &Unknown, pixels: &Pixels, sets: usize, seed: u64) -> Basis {
    let columns = unknown.columns();
    let width = sets * 3 * columns;
    let mut values = vec![0f32; pixels.numbers.len() * width];
    // Few pixels at a time: some take much longer than others.
    let work = values.par_chunks_mut(width * 8).zip(pixels.numbers.par_chunks(8)).zip(pixels.samples.par_chunks(8));
    work.for_each(|((values, numbers), samples)| {
        let pieces = numbers.iter().zip(samples).zip(values.chunks_exact_mut(width)).flat_map(|((&number, &samples), values)| {
            values.chunks_exact_mut(3 * columns).enumerate().map(move |(set, columns)| Piece { number, set: set as u32, samples, columns })
        });
        match unknown {
            Unknown::Rough(rough) if rough.nodes.len() <= LANES => {
                follow(world, rules, pixels.lens, seed, pieces, |columns| rough::Tagging::<1> { rules, unknown: rough, columns });
            }
            Unknown::Rough(rough) if rough.nodes.len() <= 2 * LANES => {
                follow(world, rules, pixels.lens, seed, pieces, |columns| rough::Tagging::<2> { rules, unknown: rough, columns });
            }
            Unknown::Rough(rough) => {
                follow(world, rules, pixels.lens, seed, pieces, |columns| rough::Tagging::<{ MOST_NODES / LANES }> {
                    rules,
                    unknown: rough,
                    columns,
                });
            }
            Unknown::Clear(clear) => {
                follow(world, rules, pixels.lens, seed, pieces, |columns| clear::Dimming { rules, unknown: clear, columns });
            }
        }
    });
    Basis { sets, columns, samples: pixels.samples.iter().map(|&n| n as f32).collect(), values }
}

/// One set of a pixel.
struct Piece<'c> {
    number: usize,
    set: u32,
    samples: u32,
    columns: &'c mut [f32],
}

/// Traces pieces, with the transport that `transport` makes of their columns.
fn follow<'c, T: Columns<'c>>(
    world: &World,
    rules: &Rules,
    lens: Lens,
    seed: u64,
    pieces: impl Iterator<Item = Piece<'c>>,
    transport: impl Fn(&'c mut [f32]) -> T,
) {
    let mut integrator = Integrator::<T::Beta>::new(world, rules);
    for piece in pieces {
        let mut transport = transport(piece.columns);
        for index in 0..piece.samples {
            let mut sampler = Sampler::new(seed, piece.number as u64, piece.set, index);
            let at = sampler.pair();
            if let Some((origin, direction, limit)) = lens(piece.number, at) {
                integrator.trace(&mut transport, Ray { origin, direction }, limit, sampler);
            }
        }
        let scale = 1.0 / piece.samples.max(1) as f32;
        transport.columns().iter_mut().for_each(|v| *v *= scale);
    }
}

/// A transport that adds up columns.
trait Columns<'c>: Transport {
    /// The columns.
    fn columns(self) -> &'c mut [f32];
}

impl<'c, const L: usize> Columns<'c> for rough::Tagging<'c, L> {
    fn columns(self) -> &'c mut [f32] {
        self.columns
    }
}

impl<'c> Columns<'c> for clear::Dimming<'c> {
    fn columns(self) -> &'c mut [f32] {
        self.columns
    }
}
