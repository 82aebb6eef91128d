//! The basis: the picture as a function of one unknown material, without tracing again.
//!
//! Where one material is unknown, a picture is a sum of pictures that do not depend on its colours, each times a number that does. Those
//! pictures are the columns of a basis. What cannot be split off like that (roughness, transmissivity) is sampled at a few nodes, all of them on
//! the same paths; the index of refraction bends the paths, and has a basis for each node. Choices on a path never depend on what is unknown.

mod clear;
mod lobes;
mod monomials;
mod rough;
#[cfg(test)]
mod tests;

pub use clear::{Clear, depth};
pub use lobes::Alpha;
pub use monomials::{Monomials, ORDER, POLISHED_ORDER};
pub use rough::{MOST_NODES, Rough};

use crate::color::Rgb;
use crate::geometry::Ray;
use crate::integrator::{Integrator, Radiance, Transport};
use crate::render::Lens;
use crate::rules::Rules;
use crate::sampling::Sampler;
use crate::world::World;
use rayon::prelude::*;
use std::ops::Range;
use wide::f32x8;

/// Nodes that are computed with at a time.
pub const LANES: usize = 8;

/// Numbers at 8·`L` nodes.
type Nodes<const L: usize> = [f32x8; L];

/// Numbers in lanes, the last of them filled up with zeros.
fn lanes(numbers: &[f64]) -> Vec<f32x8> {
    let lane = |chunk: &[f64]| f32x8::from(std::array::from_fn(|i| chunk.get(i).map_or(0.0, |&number| number as f32)));
    numbers.chunks(LANES).map(lane).collect()
}

/// What is unknown, and how it is explored.
#[derive(Clone, Copy)]
pub enum Explored<'a> {
    /// Rough, reflecting and perhaps transmitting.
    Rough(&'a Rough),
    /// Smooth and transparent.
    Clear(&'a Clear),
}

impl Explored<'_> {
    /// The columns of a channel.
    pub fn columns(self) -> usize {
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
    /// Columns of a channel: [`Explored::columns`].
    pub columns: usize,
    /// Samples, pixel by pixel, in each set by set.
    pub samples: Vec<f32>,
    /// Pixel by pixel, in each set by set, in each channel by channel, in each column by column: the mean over the samples of the set.
    pub values: Vec<f32>,
    /// Pixel by pixel, in each set by set: the variance of red, green and blue of a sample, in the picture that was asked for ([`Pixels::picture`]).
    pub variances: Vec<[f32; 3]>,
}

/// A picture: what its red, green and blue take of the columns of a basis.
pub struct Mixture([Vec<f32>; 3]);

impl Mixture {
    /// The mixture with these coefficients of the columns of each channel.
    pub fn new(x: &[Vec<f64>; 3]) -> Self {
        Self(x.each_ref().map(|x| x.iter().map(|&x| x as f32).collect()))
    }

    /// The pixel with these columns of all channels.
    pub fn of(&self, columns: &[f32]) -> [f64; 3] {
        let width = self.0[0].len();
        let pairs = [0, 1, 2].map(|c| (self.0[c].as_chunks::<LANES>(), columns[c * width..][..width].as_chunks::<LANES>()));
        // All channels at a time: each sum waits for its last addition.
        let mut sums = [f32x8::ZERO; 3];
        for i in 0..width / LANES {
            for (sum, ((x, _), (columns, _))) in sums.iter_mut().zip(&pairs) {
                *sum = f32x8::from(x[i]).mul_add(f32x8::from(columns[i]), *sum);
            }
        }
        std::array::from_fn(|c| {
            let ((_, x), (_, columns)) = pairs[c];
            let rest: f32 = x.iter().zip(columns).map(|(a, b)| a * b).sum();
            (sums[c].reduce_add() + rest) as f64
        })
    }
}

/// e^x as [`f32x8::exp`] has it, for x that are not above 0; where that is no normal number it is 0.
#[inline]
fn decay(x: f32x8) -> f32x8 {
    const LEAST: f32 = -87.0;
    let counts = x.simd_ge(f32x8::splat(LEAST));
    // Take out the powers of 2, by the two parts of ln 2 (fdlibm, e_exp.c).
    let n = x.fast_max(f32x8::splat(LEAST)) * f32x8::LOG2_E;
    let n = n.round_ties_even();
    let x = n.mul_neg_add(f32x8::splat(-2.121_944_4e-4), n.mul_neg_add(f32x8::splat(0.693_359_4), x));
    // Sum the power series.
    let [a, b, c, d, e, f] = [2.0, 6.0, 24.0, 120.0, 720.0, 5040.0].map(|factorial: f32| f32x8::splat(1.0 / factorial));
    let x2 = x * x;
    let rest = d.mul_add(x, c).mul_add(x2, f.mul_add(x, e).mul_add(x2 * x2, b.mul_add(x, a)));
    let power = n.fast_round_int().to_array().map(|n| f32::from_bits(((n + 127) as u32) << 23));
    counts & ((rest.mul_add(x2, x) + f32x8::ONE) * f32x8::from(power))
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
        // The picture is the mean of those of the parts, which have their random numbers in common.
        let variance = |i: usize| std::array::from_fn(|c| parts.iter().map(|p| p.variances[i][c]).sum::<f32>() / parts.len() as f32);
        let variances = (0..parts[0].variances.len()).map(variance).collect();
        Self { sets, columns, samples: parts[0].samples.clone(), values: (0..rows).flat_map(row).copied().collect(), variances }
    }

    /// Takes in the same basis of further pixels.
    pub fn append(&mut self, other: Self) {
        self.samples.extend(other.samples);
        self.values.extend(other.values);
        self.variances.extend(other.variances);
    }

    /// Takes in the samples of another tracing of the same pixels. How many a set of a pixel was given must not depend on what samples of its own
    /// found before: one that counts less of them because they were bright would end up too dark.
    pub fn join(&mut self, other: &Self) {
        let width = 3 * self.columns;
        let rows = self.values.par_chunks_mut(width).zip(&mut self.variances).zip(&mut self.samples);
        rows.zip(other.values.par_chunks(width)).zip(&other.variances).zip(&other.samples).for_each(
            |(((((values, variance), samples), others), other_variance), other_samples)| {
                let part = |mine: f32, other: f32| other / (mine + other).max(1.0);
                // One sample tells no variance.
                let degrees = |samples: f32| (samples - 1.0).max(0.0);
                let (taken, told) = (part(*samples, *other_samples), part(degrees(*samples), degrees(*other_samples)));
                values.iter_mut().zip(others).for_each(|(mine, other)| *mine += taken * (other - *mine));
                variance.iter_mut().zip(other_variance).for_each(|(mine, other)| *mine += told * (other - *mine));
                *samples += other_samples;
            },
        );
    }
}

/// What to trace a basis of.
pub struct Pixels<'a> {
    /// The numbers of the pixels, as the lens knows them.
    pub numbers: &'a [usize],
    /// Which samples each gets, pixel by pixel, in each set by set: those that follow others of the same seed fill it evenly together with them.
    pub samples: &'a [Range<u32>],
    /// The rays of a pixel.
    pub lens: Lens<'a>,
    /// The picture whose variance is asked for: coefficients of the columns of each channel.
    pub picture: Option<&'a [Vec<f64>; 3]>,
}

/// Traces the basis of some pixels, `sets` independent estimates of it. `seed` makes one tracing independent of another.
pub fn trace(world: &World, rules: &Rules, unknown: Explored, pixels: &Pixels, sets: usize, seed: u64) -> Basis {
    let columns = unknown.columns();
    let width = sets * 3 * columns;
    let mut values = vec![0f32; pixels.numbers.len() * width];
    let mut variances = vec![[0.0; 3]; pixels.numbers.len() * sets];
    let mixture = pixels.picture.map(Mixture::new);
    // Few pixels at a time, and each few for themselves: some take much longer than others.
    let work = values.par_chunks_mut(width * 8).zip(variances.par_chunks_mut(sets * 8));
    let work = work.zip(pixels.numbers.par_chunks(8)).zip(pixels.samples.par_chunks(sets * 8));
    work.with_max_len(1).for_each(|(((values, variances), numbers), samples)| {
        let sums = values.chunks_exact_mut(3 * columns).zip(variances).enumerate();
        let pieces = sums.map(|(i, (columns, variance))| Piece {
            number: numbers[i / sets],
            set: (i % sets) as u32,
            samples: samples[i].clone(),
            columns,
            variance,
        });
        let mixture = mixture.as_ref();
        match unknown {
            Explored::Rough(rough) if rough.nodes.len() <= LANES => {
                follow(world, rules, pixels.lens, seed, pieces, mixture, |columns| rough::Tagging::<1> { rules, unknown: rough, columns });
            }
            Explored::Rough(rough) if rough.nodes.len() <= 2 * LANES => {
                follow(world, rules, pixels.lens, seed, pieces, mixture, |columns| rough::Tagging::<2> { rules, unknown: rough, columns });
            }
            Explored::Rough(rough) => {
                follow(world, rules, pixels.lens, seed, pieces, mixture, |columns| rough::Tagging::<{ MOST_NODES / LANES }> {
                    rules,
                    unknown: rough,
                    columns,
                });
            }
            Explored::Clear(clear) => {
                follow(world, rules, pixels.lens, seed, pieces, mixture, |columns| clear::Dimming {
                    colors: Radiance { rules, sum: Rgb::ZERO },
                    unknown: clear,
                    columns,
                });
            }
        }
    });
    Basis { sets, columns, samples: pixels.samples.iter().map(|samples| samples.len() as f32).collect(), values, variances }
}

/// One set of a pixel.
struct Piece<'c> {
    number: usize,
    set: u32,
    samples: Range<u32>,
    columns: &'c mut [f32],
    variance: &'c mut [f32; 3],
}

/// Traces pieces, with the transport that `transport` makes of their columns.
fn follow<'c, T: Columns>(
    world: &World,
    rules: &Rules,
    lens: Lens,
    seed: u64,
    pieces: impl Iterator<Item = Piece<'c>>,
    mixture: Option<&Mixture>,
    transport: impl Fn(&'c mut [f32]) -> T,
) {
    let mut integrator = Integrator::<T::Beta>::new(world, rules);
    for piece in pieces {
        let mut transport = transport(piece.columns);
        // The pixel so far, and the squares of what each sample added to it.
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        let n = piece.samples.len().max(1) as f64;
        let sights: Vec<_> = piece
            .samples
            .filter_map(|index| {
                let mut sampler = Sampler::new(seed, piece.number as u64, piece.set, index);
                let (origin, direction, limit) = lens(piece.number, sampler.pair())?;
                Some((Ray { origin, direction }, limit, sampler))
            })
            .collect();
        world.nearest_each(sights.iter().map(|(ray, limit, _)| (ray, *limit)), |n, hit| {
            let (ray, limit, sampler) = sights[n];
            integrator.trace_on(&mut transport, ray, limit, hit.as_ref(), sampler);
            if let Some(mixture) = mixture {
                let now = mixture.of(transport.columns());
                (0..3).for_each(|c| squares[c] += (now[c] - sum[c]).powi(2));
                sum = now;
            }
        });
        *piece.variance = std::array::from_fn(|c| ((squares[c] - sum[c] * sum[c] / n) / (n - 1.0).max(1.0)).max(0.0) as f32);
        transport.columns().iter_mut().for_each(|v| *v /= n as f32);
    }
}

/// A transport that adds up columns.
trait Columns: Transport {
    /// The columns.
    fn columns(&mut self) -> &mut [f32];
}

impl<const L: usize> Columns for rough::Tagging<'_, L> {
    fn columns(&mut self) -> &mut [f32] {
        self.columns
    }
}

impl Columns for clear::Dimming<'_> {
    fn columns(&mut self) -> &mut [f32] {
        self.columns
    }
}
