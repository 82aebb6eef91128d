//! How much each pixel can be trusted.

use super::Evidence;
use super::dead::black;
use crate::metric::EPSILON;
use crate::render::Film;
use crate::transport::Basis;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// Three numbers for each pixel that counts.
pub type Channels = Vec<[f32; 3]>;
/// The same of an estimate.
pub type Half = Vec<[f64; 3]>;
/// How much one pixel counts for another, by how far to the right of that and how far below it is.
type Share<'s> = dyn Fn(isize, isize) -> f64 + Sync + 's;

/// How much pixels count.
#[derive(Clone)]
pub struct Weights {
    /// In each half.
    pub halves: [Channels; 2],
    /// The part of its pull that each pixel keeps: one that is held back pulls no harder when it is farther off.
    pub kept: Vec<f32>,
    /// The values of the target that its file rounds, those together that it rounds alike.
    pub rounded: Arc<[Alike]>,
}

/// Values that are the same: their pixels, their channels, and the standard deviation of what rounding does to all of them together.
pub type Alike = Vec<(usize, usize, f32)>;

impl Weights {
    /// Weights of pixels none of which is held back.
    pub fn new(halves: [Channels; 2]) -> Self {
        let kept = vec![1.0; halves[0].len()];
        Self { halves, kept, rounded: Arc::new([]) }
    }

    /// The weights of those that are not held back.
    pub fn free(&self) -> [Channels; 2] {
        self.halves.each_ref().map(|half| half.iter().zip(&self.kept).map(|(w, kept)| if *kept < 1.0 { [0.0; 3] } else { *w }).collect())
    }
}

/// The pixels that count, where they lie, and what was photographed there.
pub struct Sheet<'a> {
    evidence: &'a Evidence<'a>,
    /// Their numbers on the film.
    pub numbers: &'a [usize],
    /// The target's values there.
    pub target: Channels,
    /// The place in `numbers` of each pixel of the film.
    places: Vec<u32>,
    /// The mean of the target's values.
    pub level: f64,
    /// Weights that make errors relative, from the target blurred: what a first look can go by.
    pub relative: Channels,
}

impl<'a> Sheet<'a> {
    /// The sheet of some pixels.
    pub fn new(evidence: &'a Evidence<'a>, numbers: &'a [usize]) -> Self {
        Self::of(evidence, numbers, numbers.iter().map(|&n| evidence.target.pixels[n]).collect())
    }

    /// The same, had the photograph shown other values there.
    pub fn of(evidence: &'a Evidence<'a>, numbers: &'a [usize], target: Channels) -> Self {
        let level = target.iter().flatten().map(|&v| v as f64).sum::<f64>() / (3 * target.len()) as f64;
        let mut places = vec![u32::MAX; evidence.film.width * evidence.film.height];
        numbers.iter().enumerate().for_each(|(i, &n)| places[n] = i as u32);
        let mut sheet = Self { evidence, numbers, target, places, level, relative: Vec::new() };
        sheet.relative = sheet.relatively();
        sheet
    }

    /// Column and row of a pixel of the film.
    pub fn place(&self, number: usize) -> (usize, usize) {
        (number % self.evidence.film.width, number / self.evidence.film.width)
    }

    /// The number of the area of each pixel, where as many as `count` lie beside each other, and below each other, in the rectangle that holds all.
    pub fn areas(&self, count: usize) -> Vec<usize> {
        let places: Vec<[usize; 2]> = self.numbers.iter().map(|&number| self.place(number).into()).collect();
        let [columns, rows] = [0, 1].map(|axis| {
            let of = |place: &[usize; 2]| place[axis];
            let (first, last) = (places.iter().map(of).min().unwrap_or(0), places.iter().map(of).max().unwrap_or(0));
            places.iter().map(|place| (place[axis] - first) * count / (last - first + 1)).collect::<Vec<_>>()
        });
        rows.iter().zip(columns).map(|(row, column)| row * count + column).collect()
    }

    /// So far apart pixels hold hardly any of the same light, and so of the same noise.
    pub fn spacing(&self) -> usize {
        self.evidence.film.filter.spacing()
    }

    /// The pixels to the right of one and below it that share no light with it, as near as such are, if they are in the sheet.
    pub fn next(&self, i: usize) -> impl Iterator<Item = usize> {
        let ((x, y), apart) = (self.place(self.numbers[i]), self.spacing());
        let &Film { width, height, .. } = self.evidence.film;
        let inside = [(x + apart, y), (x, y + apart)].into_iter().filter(move |(x, y)| *x < width && *y < height);
        inside.map(move |(x, y)| self.places[y * width + x]).filter(|place| *place != u32::MAX).map(|place| place as usize)
    }

    /// How bright the brightest is of a pixel and those beside it in the photograph: the sum of its channels.
    pub fn brightest(&self, i: usize) -> f64 {
        let Evidence { film, target, .. } = self.evidence;
        let bright = |n: usize| target.pixels[n].iter().copied().map(f64::from).sum();
        film.around(self.numbers[i], 1).map(bright).fold(0.0, f64::max)
    }

    /// The variance of a channel of the photograph in a pixel and those about it.
    fn scatter(&self, i: usize, c: usize) -> f64 {
        let Evidence { film, target, .. } = self.evidence;
        let sums = film.around(self.numbers[i], 2).fold([0.0; 3], |[count, sum, squares], n| {
            let value = f64::from(target.pixels[n][c]);
            [count + 1.0, sum + value, squares + value * value]
        });
        let [mean, square] = [sums[1], sums[2]].map(|sum| sum / sums[0]);
        (square - mean * mean).max(0.0)
    }

    /// How much a pixel counts.
    pub fn weight(&self, i: usize) -> f64 {
        self.evidence.mask.map_or(1.0, |mask| mask[self.numbers[i]] as f64)
    }

    /// How far apart the values are that the target's file can hold there; 0 where it rounds none.
    pub fn step(&self, i: usize, c: usize) -> f64 {
        self.evidence.steps.map_or(0.0, |steps| steps[self.numbers[i]][c] as f64)
    }

    /// The product of what both halves are off by at a place, which the noise of the rendering adds nothing to on the average.
    pub fn cross(&self, halves: &[Half], p: usize, c: usize) -> f64 {
        halves.iter().map(|half| self.target[p][c] as f64 - half[p][c]).product()
    }

    /// χ² of equation 11, without what the noise of the rendering adds to it.
    pub fn chi2(&self, halves: &[Half]) -> f64 {
        (0..self.numbers.len()).map(|p| self.weight(p) * (0..3).map(|c| self.cross(halves, p, c)).sum::<f64>()).sum()
    }

    /// For each pixel, the mean of `values` over the pixels at most `reach` away that count.
    pub fn blurred(&self, values: &[[f64; 3]], reach: isize) -> Vec<[f64; 3]> {
        self.mean(values, reach, &|_, _| 1.0)
    }

    /// The same without the pixel itself, unless it is alone.
    pub fn around(&self, values: &[[f64; 3]], reach: isize) -> Vec<[f64; 3]> {
        self.mean(values, reach, &|u, v| f64::from((u, v) != (0, 0)))
    }

    /// The same without those that share a side with it either.
    pub fn apart(&self, values: &[[f64; 3]], reach: isize) -> Vec<[f64; 3]> {
        self.mean(values, reach, &|u, v| f64::from(u.abs() + v.abs() > 1))
    }

    /// For each pixel, the sum of `values` over all that count, times the correlation of their noise with its own: exp(−d²/4`variance`).
    pub fn correlated(&self, values: &[[f64; 3]], variance: f64) -> Vec<[f64; 3]> {
        let reach = (4.0 * variance.sqrt()).ceil();
        let falls: Vec<f64> = (0..=reach as i32).map(|d| (-f64::from(d).powi(2) / (4.0 * variance)).exp()).collect();
        let share = |u: isize, v: isize| falls[u.unsigned_abs()] * falls[v.unsigned_abs()];
        self.sums(values, reach as isize, &share).into_iter().map(|(sum, _)| sum).collect()
    }

    /// The values of the pixels on the four sides of one; the target's where they are not in the sheet. None of what is masked, cut off, or no number.
    pub fn beside(&self, i: usize, values: &Half) -> Vec<[f64; 3]> {
        let (x, y) = self.place(self.numbers[i]);
        let (width, height) = (self.evidence.film.width, self.evidence.film.height);
        let sides = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        let inside = sides.into_iter().filter(|(u, v)| *u < width && *v < height).map(|(u, v)| v * width + u);
        let cut = |n: usize| self.evidence.alone && black(self.evidence, n);
        let seen = inside.filter(|&n| self.evidence.counts(n) && !cut(n) && self.evidence.target.pixels[n].iter().all(|v| v.is_finite()));
        seen.map(|n| match self.places[n] {
            u32::MAX => self.evidence.target.pixels[n].map(f64::from),
            place => values[place as usize],
        })
        .collect()
    }

    fn mean(&self, values: &[[f64; 3]], reach: isize, share: &Share) -> Vec<[f64; 3]> {
        let sums = self.sums(values, reach, share).into_iter().zip(values);
        sums.map(|((sum, shares), own)| if shares > 0.0 { sum.map(|s| s / shares) } else { *own }).collect()
    }

    /// For each pixel, the sum of `values` over the pixels at most `reach` away that count, each times its share by how far to the right and how far
    /// below it is; and the sum of those shares.
    fn sums(&self, values: &[[f64; 3]], reach: isize, share: &Share) -> Vec<([f64; 3], f64)> {
        let (width, height) = (self.evidence.film.width as isize, self.evidence.film.height as isize);
        let of = |&n: &usize| {
            let (x, y) = (n as isize % width, n as isize / width);
            let (mut sum, mut shares) = ([0.0; 3], 0.0);
            for v in (y - reach).max(0)..=(y + reach).min(height - 1) {
                for u in (x - reach).max(0)..=(x + reach).min(width - 1) {
                    let (place, share) = (self.places[(v * width + u) as usize], share(u - x, v - y));
                    if place != u32::MAX && share > 0.0 {
                        (0..3).for_each(|c| sum[c] += share * values[place as usize][c]);
                        shares += share;
                    }
                }
            }
            (sum, shares)
        };
        self.numbers.par_iter().map(of).collect()
    }

    fn masked(&self, i: usize, weight: [f64; 3]) -> [f32; 3] {
        let counts = self.weight(i);
        weight.map(|w| (w * counts) as f32)
    }

    fn relatively(&self) -> Channels {
        let target: Vec<[f64; 3]> = self.target.iter().map(|t| t.map(f64::from)).collect();
        // Before what is all black, all differences count alike.
        let floor = if self.level > 0.0 { EPSILON.sqrt() * self.level } else { 1.0 };
        self.blurred(&target, 2).into_iter().enumerate().map(|(i, t)| self.masked(i, t.map(|v| (v.max(0.0) + floor).powi(-2)))).collect()
    }

    /// The variance of one sample of each pixel, as each half has it: by how the samples of that half differ, and by those of its neighbours, for
    /// few samples may all have missed what glints now and then.
    pub fn variances(&self, halves: &[Half], basis: &Basis) -> [Vec<[f64; 3]>; 2] {
        let own = |half: usize, i: usize| basis.variances[2 * i + half].map(f64::from);
        let count = self.numbers.len();
        let mean: Vec<[f64; 3]> = (0..count).map(|i| std::array::from_fn(|c| 0.5 * (own(0, i)[c] + own(1, i)[c]))).collect();
        let around = self.around(&mean, 1);
        // Samples that fill a pixel evenly err less than chance would have it.
        let (mut by_chance, mut seen) = (0.0, 0.0);
        for (i, w) in self.relative.iter().enumerate() {
            for c in 0..3 {
                by_chance += w[c] as f64 * mean[i][c];
                seen += w[c] as f64 * (halves[0][i][c] - halves[1][i][c]).powi(2) / inverses(&basis.samples, i);
            }
        }
        let even = if by_chance > 0.0 { seen / by_chance } else { 1.0 };
        let blend = |half: usize, i: usize| -> [f64; 3] {
            let share = NEIGHBOURS / (NEIGHBOURS + basis.samples[2 * i + half] as f64);
            std::array::from_fn(|c| even * (own(half, i)[c] + share * (around[i][c] - own(half, i)[c])))
        };
        [0, 1].map(|half| (0..count).map(|i| blend(half, i)).collect())
    }

    /// What both halves together show around each pixel.
    pub fn light(&self, halves: &[Half]) -> Vec<[f64; 3]> {
        self.around(&joined(halves, |a, b| 0.5 * (a + b)), 2)
    }

    /// Weights for each half that go by its own variance of a sample, so that they are independent of the other half, whose residuals
    /// they weigh: a weight that went by the noise of what it weighs would favour what is too dark by chance.
    pub fn by_variance(&self, halves: &[Half], variances: &[Vec<[f64; 3]>; 2], samples: &[f32]) -> Weights {
        let mean = self.light(halves);
        let floor = (0.01 * self.level).powi(2);
        let photographed = self.samples(halves, variances);
        let weights = |i: usize| -> ([[f32; 3]; 2], f32) {
            if glints([0, 1].map(|half: usize| variances[half][i].iter().sum())) {
                return ([[0.0; 3]; 2], 1.0);
            }
            let own = |half: usize| 0.5 / samples[2 * i + half] as f64;
            let weights: [[f64; 3]; 2] = [0, 1].map(|half| {
                let share = 1.0 / photographed + own(1 - half);
                std::array::from_fn(|c| 1.0 / (variances[half][i][c] * share + (COMMON * mean[i][c]).powi(2) + floor))
            });
            let off = (0..3).map(|c| 0.5 * (weights[0][c] + weights[1][c]) * self.cross(halves, i, c)).sum::<f64>() / 3.0;
            let limit = (OUTLIER * (1.0 + OWN * 0.25 * inverses(samples, i) * photographed)).powi(2);
            let kept = (off / limit).max(1.0).sqrt().recip();
            (weights.map(|weight| self.masked(i, weight.map(|w| w * kept))), kept as f32)
        };
        let (both, kept): (Vec<_>, _) = (0..self.numbers.len()).map(weights).unzip();
        let halves = [0, 1].map(|half| both.iter().map(|w| w[half]).collect());
        Weights { halves, kept, rounded: self.rounded(variances, photographed) }
    }

    /// The values that the target's file rounds alike, where the noise of so many samples a pixel, which holds what rounding makes, does not make
    /// them err to both sides (Schuchman 1964, "Dither signals and their effect on quantization noise").
    fn rounded(&self, variances: &[Vec<[f64; 3]>; 2], photographed: f64) -> Arc<[Alike]> {
        if self.evidence.steps.is_none() {
            return Arc::new([]);
        }
        let deviation = |i: usize, c: usize| {
            let step = self.step(i, c);
            // Noise that does so makes values beside each other differ.
            let noise = (mean(variances, i, c) / photographed).min(self.scatter(i, c));
            let square = step * step / 12.0;
            let both_sides = -2.0 * (PI / step).powi(2) * (noise - square).max(0.0);
            if step > 0.0 { (square.sqrt() * both_sides.exp()) as f32 } else { 0.0 }
        };
        let of_channel = |c: usize| {
            let mut values: Alike = (0..self.numbers.len()).map(|i| (i, c, deviation(i, c))).filter(|value| value.2 > 0.0).collect();
            // What is less than a step may be nothing, in all pixels.
            let least = |i: usize| f64::from(self.target[i][c]) < self.step(i, c);
            let key = |value: &(usize, usize, f32)| if least(value.0) { 0 } else { self.target[value.0][c].to_bits() };
            values.sort_by_key(key);
            let alike = values.chunk_by(|a, b| key(a) == key(b));
            alike.filter(|alike| alike.len() > 1).map(<[_]>::to_vec).collect::<Vec<_>>()
        };
        (0..3).flat_map(of_channel).collect()
    }

    /// How many samples a pixel of the target seems to hold, from what is left of it: what a photograph lacks in noise it has in misfit.
    pub fn samples(&self, halves: &[Half], variances: &[Vec<[f64; 3]>; 2]) -> f64 {
        let (mut noise, mut rest) = (0.0, 0.0);
        for (i, w) in self.relative.iter().enumerate() {
            for c in 0..3 {
                noise += w[c] as f64 * mean(variances, i, c);
                rest += w[c] as f64 * self.cross(halves, i, c);
            }
        }
        (noise / rest.max(f64::MIN_POSITIVE)).clamp(TARGET_SAMPLES.0, TARGET_SAMPLES.1)
    }
}

/// How much a channel of a pixel counts in both halves together.
pub fn weight(weights: &[Channels; 2], p: usize, c: usize) -> f64 {
    0.5 * (weights[0][p][c] + weights[1][p][c]) as f64
}

/// The mean of both halves at a channel of a pixel.
pub fn mean(halves: &[Half], p: usize, c: usize) -> f64 {
    0.5 * (halves[0][p][c] + halves[1][p][c])
}

/// The variance of the difference of a pixel's halves, in terms of that of one sample.
fn inverses(samples: &[f32], pixel: usize) -> f64 {
    1.0 / samples[2 * pixel] as f64 + 1.0 / samples[2 * pixel + 1] as f64
}

/// How many samples the neighbours of a pixel stand for where its variance is asked.
const NEIGHBOURS: f64 = 40.0;
/// Between how many samples a pixel of the target is taken to hold.
const TARGET_SAMPLES: (f64, f64) = (4.0, 1000.0);
/// How many standard errors a pixel may be off and count fully. Where few samples have missed what glints now and then, its variance is
/// underrated; beyond this its pull does not grow (Huber 1964). Photographs that hold few samples a pixel are dark but for a few that are
/// far too bright: a limit of 4 makes a diffuse surface seen so 14 % too dark, glass of ordinary noise 1 %.
const OUTLIER: f64 = 10.0;
/// How much further off it may be per unit of the rendering's variance in terms of the photograph's: what both halves missed is no outlier.
const OWN: f64 = 1.0;
/// Where the variances of two halves have this ratio, one has caught a glint, of the sun perhaps, that the other and the photograph have missed:
/// there is no saying how much such a pixel tells.
const GLINT: f64 = 1e4;

/// Whether halves of these variances are so.
pub fn glints([a, b]: [f64; 2]) -> bool {
    a.max(b) > GLINT * a.min(b)
}

/// The part of its value by which a pixel may be off besides its noise, and many at once: by the light, the shape, the formula of a lobe.
pub const COMMON: f64 = 0.015;

/// A picture of what both halves say, channel by channel.
pub fn joined(halves: &[Half], say: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
    halves[0].iter().zip(&halves[1]).map(|(a, b)| std::array::from_fn(|c| say(a[c], b[c]))).collect()
}
