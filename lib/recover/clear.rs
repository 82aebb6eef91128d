//! Recovery of dielectric and glass: an index of refraction and a transmissivity.
//!
//! The index bends all paths, and the picture changes with it as a kaleidoscope does: pixel by pixel the right index is a needle that no descent
//! finds. The means of blocks of pixels fall toward it from afar. So first their logarithms are compared at indices all over the range, then
//! around the best; at last the pixels themselves say the rest (`look`).

use super::fit::Point;
use super::look::{Look, Model};
use super::model::{cubic, exposed};
use super::scores::anywhere;
use super::sheet::Sheet;
use super::{Effort, Evidence, Recovery, Seeds};
use crate::anneal::{Annealer, Options};
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::MaterialId;
use crate::transport::{self, Basis, Clear, Pixels};
use crate::unknown::Unknown;
use rayon::prelude::*;

/// The smallest index that is looked at: less bends light no further.
const LEAST_INDEX: f64 = 0.2;
/// The index of glass that does not say its own (semantics 3.7).
const GLASS_INDEX: f64 = 1.52;

/// Width of the blocks of pixels, look by look, and samples in each half of a pixel: more where pixels are few, so that there are at least
/// so many times as many in all.
const BLOCKS: [(usize, u32); 3] = [(8, 1), (8, 2), (1, 3)];
const ENOUGH: u32 = 2000;
/// A quarter of the pixels is sampled, unless that leaves fewer than this.
const FEW: usize = 1000;
/// Distance of the indices of the first look, and how much nearer those of the next stand.
const FIRST: f64 = 0.1;
const NEARER: f64 = 4.0;
/// Evaluations of the annealing at each look.
const STEPS: usize = 300;

/// The least that roulette takes a transmissivity for.
const DARKEST: f64 = 1e-3;

/// How much of a standard error one pixel may make. Few samples of what is seen through glass are bright, most are dark: whoever holds back
/// those that are too bright finds it darker than it is (by 1 % of a transmissivity of .9, where this is as small as for rough materials).
const PULLS: [f64; 2] = [3.0, 1.0];

/// Samples of a pixel in the first round: with 24, errors are a third larger in as much time.
const LEAST: f64 = 64.0;

/// How far the two indices that the pixels are looked at with lie to either side.
const SPREAD: f64 = 0.003;

/// Indices, and the bases there.
struct Stage<'a> {
    evidence: &'a Evidence<'a>,
    unknown: &'a Unknown,
    indices: Vec<f64>,
    parts: Vec<transport::Unknown>,
    /// Roots of the transmissivities of the columns.
    roots: Vec<f64>,
    /// What the transmissivities are, as far as is known: the weights of the columns of each channel.
    guess: Option<[Vec<f64>; 3]>,
}

impl<'a> Stage<'a> {
    fn new(evidence: &'a Evidence<'a>, unknown: &'a Unknown, material: MaterialId, indices: Vec<f64>) -> Self {
        let glass = unknown.material().kind == "glass";
        let clear: Vec<Clear> = indices.iter().map(|&index| Clear::new(material, glass, index)).collect();
        let roots = clear[0].nodes.iter().map(|t| t.sqrt()).collect();
        let parts = clear.into_iter().map(|c| transport::Unknown::Clear(Box::new(c))).collect();
        Self { evidence, unknown, indices, parts, roots, guess: None }
    }

    /// The weights of the columns of each channel in the basis of one index.
    fn columns(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let a = self.unknown.reals(values);
        exposed(std::array::from_fn(|c| cubic(&self.roots, a[c].clamp(0.0, 1.0).sqrt())), self.unknown.exposures(values))
    }

    fn index(&self, values: &[f64]) -> f64 {
        let a = self.unknown.reals(values);
        a.get(3).map_or(GLASS_INDEX, |n| n + a.get(4).map_or(0.0, |h| h / 500.0))
    }
}

impl Model for Stage<'_> {
    fn tune(&mut self, values: &[f64], _: Option<&[f64]>) {
        self.guess = Some(self.columns(values));
        let a = self.unknown.reals(values);
        let extinction = Rgb::from(std::array::from_fn(|c| -a[c].clamp(DARKEST, 1.0).ln()));
        for part in &mut self.parts {
            let transport::Unknown::Clear(clear) = part else { unreachable!() };
            clear.guess = extinction;
        }
    }

    fn trace(&self, pixels: &[usize], samples: &[u32], seed: u64) -> Basis {
        let pixels = Pixels { numbers: pixels, samples, lens: &self.evidence.film.lens(), picture: self.guess.as_ref() };
        let at = |unknown| transport::trace(self.evidence.world, self.evidence.rules, unknown, &pixels, 2, seed);
        Basis::beside(&self.parts.iter().map(at).collect::<Vec<_>>())
    }

    fn coefficients(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let columns = self.columns(values);
        let indices = if self.indices.len() > 1 { cubic(&self.indices, self.index(values)) } else { vec![1.0] };
        columns.map(|columns| indices.iter().flat_map(|n| columns.iter().map(move |c| n * c)).collect())
    }

    fn trusted(&self, values: &[f64]) -> Vec<f64> {
        let mut values = values.to_vec();
        if let Some(i) = slot(self.unknown) {
            values[i] = values[i].clamp(self.indices[0], self.indices[self.indices.len() - 1]);
        }
        values
    }

    fn pulls(&self) -> [f64; 2] {
        PULLS
    }

    fn least(&self) -> f64 {
        LEAST
    }

    fn holds(&self, values: &[f64]) -> bool {
        slot(self.unknown).is_none_or(|i| values[i] > self.indices[0] && values[i] < self.indices[self.indices.len() - 1])
    }
}

/// A model near the starting values.
pub fn near_start<'a>(evidence: &'a Evidence<'a>, unknown: &'a Unknown, material: MaterialId) -> impl Model + 'a {
    let index = unknown.reals(&unknown.start()).get(3).copied().unwrap_or(GLASS_INDEX);
    Stage::new(evidence, unknown, material, if slot(unknown).is_some() { close(index) } else { vec![index] })
}

/// The place of the index among the parameters, if it is one.
fn slot(unknown: &Unknown) -> Option<usize> {
    unknown.slots().get(3).copied().flatten()
}

/// Indices to look at the pixels with.
fn close(index: f64) -> Vec<f64> {
    [-SPREAD, SPREAD].map(|aside| index + aside).to_vec()
}

/// Recovers the numbers.
pub fn recover(
    evidence: &Evidence,
    unknown: &Unknown,
    material: MaterialId,
    pixels: &[usize],
    effort: Effort,
    tell: &dyn Fn(&str),
) -> Result<Recovery> {
    let parameters = unknown.parameters();
    let sheet = Sheet::new(evidence, pixels);
    let mut seeds = Seeds::new(effort.seed);
    let slot = slot(unknown);
    let start = unknown.start();
    let fixed = unknown.reals(&start).get(3).copied().unwrap_or(GLASS_INDEX);
    let (low, high) = slot.map_or((fixed, fixed), |i| (parameters[i].low.max(LEAST_INDEX), parameters[i].high.max(LEAST_INDEX)));
    let bounds: Vec<(f64, f64)> =
        parameters.iter().enumerate().map(|(i, p)| if Some(i) == slot { (low, high) } else { (p.low, p.high) }).collect();

    // The valley, by blocks of pixels.
    let mut best = Point { values: start, chi2: f64::INFINITY };
    let (mut from, mut to, mut step) = (low, high, FIRST);
    for (width, samples) in BLOCKS {
        let blocks = Blocks::new(&sheet, width);
        let count = ((to - from) / step).round().max(1.0) as usize;
        let indices: Vec<f64> = (0..=count).map(|i| from + (to - from) * i as f64 / count as f64).collect();
        tell(&format!("indices {:.3} to {:.3}", from, to));
        let sampled: Vec<usize> = blocks.sample();
        let numbers: Vec<usize> = sampled.iter().map(|&i| pixels[i]).collect();
        let samples = (samples * ENOUGH).div_ceil(numbers.len() as u32).max(samples);
        // The logarithms of pixels that are dark by chance would spoil the colours; those of blocks do not.
        let free: Vec<usize> = (0..parameters.len()).filter(|&p| Some(p) != slot && width > 1).collect();
        let tried = if slot.is_some() { &indices[..] } else { &indices[..1] };
        let tried: Vec<(f64, u64)> = tried.iter().map(|&index| (index, seeds.next())).collect();
        let fit = |&(index, seed): &(f64, u64)| {
            let stage = Stage::new(evidence, unknown, material, vec![index]);
            let basis = stage.trace(&numbers, &vec![samples; 2 * numbers.len()], seed);
            let mut values = best.values.clone();
            slot.into_iter().for_each(|i| values[i] = index);
            blocks.fit(&stage, &basis, &sampled, values, &free, effort.seed)
        };
        let found = tried.par_iter().map(fit).collect::<Result<Vec<Point>>>()?;
        let Some(lowest) = found.iter().min_by(|a, b| a.chi2.total_cmp(&b.chi2)) else { continue };
        best = lowest.clone();
        let Some(i) = slot else { break };
        if step < FIRST {
            best.values[i] = meeting(&indices, &found.iter().map(|point| point.chi2).collect::<Vec<_>>());
        }
        (from, to) = ((best.values[i] - step).max(low), (best.values[i] + step).min(high));
        step /= NEARER;
    }

    // Its bottom, by pixels. Each look that finds it farther on in the same direction is followed by one twice as far; one that went too far, by
    // one just beside the lowest place so far.
    let (mut lowest, mut stride): (Option<Recovery>, f64) = (None, 0.0);
    for look in 1.. {
        tell(&format!("look {look}: {:.4?}", best.values));
        let indices = match slot {
            Some(i) => close(best.values[i]),
            None => vec![fixed],
        };
        let mut stage = Stage::new(evidence, unknown, material, indices);
        let found = Look { evidence, pixels, parameters: unknown.parameters(), bounds: &bounds, effort: &effort }.at(
            &mut stage,
            &best.values,
            &mut seeds,
        );
        let Some(i) = slot.filter(|_| !stage.holds(&found.values)) else { return Ok(found) };
        let (mut here, next) = match lowest.take_if(|lowest| lowest.excess(&found) <= 0.0) {
            Some(lower) => {
                stride = 0.0;
                let beside = lower.values[i];
                (lower, beside)
            }
            None => {
                let way = found.values[i] - best.values[i];
                stride = if stride * way > 0.0 { 2.0 * stride } else { way };
                (found, best.values[i] + stride)
            }
        };
        if effort.late() || look == MOST_LOOKS {
            // It was not got hold of: the index may be anywhere.
            here.covariance.set(i, i, anywhere((low, high)));
            return Ok(here);
        }
        best.values.clone_from(&here.values);
        best.values[i] = next.clamp(low, high);
        lowest = Some(here);
    }
    unreachable!()
}

/// Where two lines meet that rise alike to both sides and come nearest to misfits at rising indices (least squares).
fn meeting(indices: &[f64], misfits: &[f64]) -> f64 {
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / indices.len() as f64;
    let level = mean(&mut misfits.iter().copied());
    // What lines that meet at `at` explain.
    let explained = |at: f64| {
        let middle = mean(&mut indices.iter().map(|i| (i - at).abs()));
        let (mut together, mut spread) = (0.0, 0.0);
        for (index, misfit) in indices.iter().zip(misfits) {
            let aside = (index - at).abs() - middle;
            together += aside * (misfit - level);
            spread += aside * aside;
        }
        together.max(0.0).powi(2) / spread.max(f64::MIN_POSITIVE)
    };
    let (first, last) = (indices[0], indices[indices.len() - 1]);
    let places = (0..=PLACES).map(|k| first + (last - first) * k as f64 / PLACES as f64);
    places.max_by(|a, b| explained(*a).total_cmp(&explained(*b))).unwrap_or(first)
}

/// How finely that is told.
const PLACES: usize = 256;

/// Looks before the search gives up to keep the answer inside the indices.
const MOST_LOOKS: usize = 8;

/// Means of square blocks of pixels.
struct Blocks<'a> {
    sheet: &'a Sheet<'a>,
    /// The block of each pixel.
    of: Vec<usize>,
    count: usize,
}

impl<'a> Blocks<'a> {
    fn new(sheet: &'a Sheet<'a>, width: usize) -> Self {
        let place = |&n: &usize| {
            let (x, y) = sheet.place(n);
            ((y / width) << 32) | (x / width)
        };
        let mut names: Vec<usize> = sheet.numbers.iter().map(place).collect();
        names.sort_unstable();
        names.dedup();
        let of = sheet.numbers.iter().map(|n| names.binary_search(&place(n)).unwrap_or(0)).collect();
        Self { sheet, of, count: names.len() }
    }

    /// A quarter of the pixels, or all.
    fn sample(&self) -> Vec<usize> {
        let counts = |i: &usize| {
            let (x, y) = self.sheet.place(self.sheet.numbers[*i]);
            x % 2 == 0 && y % 2 == 0
        };
        let some: Vec<usize> = (0..self.sheet.numbers.len()).filter(counts).collect();
        if some.len() < FEW { (0..self.sheet.numbers.len()).collect() } else { some }
    }

    /// The values of the `free` parameters that bring the logarithms of the blocks nearest, the others being as in `values`, and how near.
    fn fit(&self, stage: &Stage, basis: &Basis, sampled: &[usize], values: Vec<f64>, free: &[usize], seed: u64) -> Result<Point> {
        let columns = basis.columns;
        let mut sums = vec![vec![0.0; 3 * columns]; self.count];
        let mut target = vec![([0.0; 3], 0.0); self.count];
        for (place, &pixel) in sampled.iter().enumerate() {
            let block = self.of[pixel];
            let weight = self.sheet.weight(pixel);
            for (sum, (a, b)) in sums[block].iter_mut().zip(basis.pixel(place, 0).iter().zip(basis.pixel(place, 1))) {
                *sum += weight * 0.5 * (a + b) as f64;
            }
            (0..3).for_each(|c| target[block].0[c] += weight * self.sheet.target[pixel][c] as f64);
            target[block].1 += weight;
        }
        let floor = 0.02 * self.sheet.level;
        let misfit = |values: &[f64]| -> f64 {
            let x = stage.columns(values);
            let block = |(sums, (target, weight)): (&Vec<f64>, &([f64; 3], f64))| {
                let channel = |c: usize| {
                    let model: f64 = x[c].iter().zip(&sums[c * columns..]).map(|(x, s)| x * s).sum();
                    ((target[c] + weight * floor) / (model.max(0.0) + weight * floor)).ln().powi(2)
                };
                weight * (0..3).map(channel).sum::<f64>()
            };
            sums.iter().zip(&target).filter(|(_, t)| t.1 > 0.0).map(block).sum()
        };
        let whole = |part: &[f64]| {
            let mut values = values.clone();
            free.iter().zip(part).for_each(|(&i, &v)| values[i] = v);
            values
        };
        if free.is_empty() {
            return Ok(Point { chi2: misfit(&values), values });
        }
        let options = Options {
            seed,
            steps: STEPS,
            groups: (0..free.len()).map(|i| vec![i]).collect(),
            stages: vec![1.0],
            polish: true,
            tolerance: None,
            residuals: None,
        };
        let mut annealer = Annealer::new(free.iter().map(|&i| stage.unknown.parameters()[i].clone()).collect(), options)?;
        while let Some(part) = annealer.propose() {
            let chi2 = misfit(&whole(part));
            annealer.tell(chi2);
        }
        let best = annealer.best().map_or_else(Vec::new, |b| b.values);
        let values = whole(&best);
        Ok(Point { chi2: misfit(&values), values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_lines_meet_where_they_do() {
        let indices: Vec<f64> = (0..9).map(|i| 1.4 + 0.025 * i as f64).collect();
        for at in [1.4, 1.43, 1.5, 1.5875, 1.6] {
            // A ragged valley: what is added has no slope to either side.
            let misfits: Vec<f64> =
                indices.iter().zip([3.0, -3.0].iter().cycle()).map(|(i, rough)| 300.0 + 4000.0 * (i - at).abs() + rough).collect();
            let met = meeting(&indices, &misfits);
            assert!((met - at).abs() < 0.002, "{at}: {met}");
        }
        assert!((1.4..=1.6).contains(&meeting(&indices, &[1.0; 9])));
    }
}
