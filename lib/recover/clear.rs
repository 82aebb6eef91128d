//! Recovery of dielectric and glass: an index of refraction and a transmissivity.
//!
//! The index bends all paths, and the picture changes with it as a kaleidoscope does: where pixels are compared by squares, the right index is
//! a needle that no descent finds. Their logarithms fall toward it from afar; the colours, which pixels that are dark by chance would spoil, come
//! from the means of blocks of pixels. So indices all over the range are tried first, then nearer and nearer ones around the best; at last
//! the pixels themselves say the rest (`look`).

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
use std::collections::BTreeMap;

/// The smallest index that is looked at: less bends light no further.
const LEAST_INDEX: f64 = 0.2;
/// The index of glass that does not say its own (semantics 3.7).
const GLASS_INDEX: f64 = 1.52;

/// Samples in each half of a pixel, search by search: more where pixels are few, so that there are at least so many times as many in all.
const SAMPLES: [u32; 3] = [1, 2, 3];
const ENOUGH: u32 = 2000;
/// Width of a block, in pixels.
const BLOCK: usize = 8;
/// A quarter of the pixels is sampled, unless that leaves fewer than this.
const FEW: usize = 1000;
/// Distance of the indices of the first search, and how much nearer those of the next stand.
const FIRST: f64 = 0.1;
const NEARER: f64 = 4.0;
/// How many indices on either side of the best tell where between them it is.
const BESIDE: usize = 3;
/// In terms of their distance, how near to the last index tried the best is followed beyond it; and how many times.
const MARGIN: f64 = 1.5;
const MOST_SHIFTS: usize = 6;
/// Evaluations of the annealing at each index.
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

    // The valley.
    let mut best = Point { values: start, chi2: f64::INFINITY };
    let (mut from, mut to, mut step) = (low, high, FIRST);
    let sampled = quarter(&sheet);
    let numbers: Vec<usize> = sampled.iter().map(|&i| pixels[i]).collect();
    let free: Vec<usize> = (0..parameters.len()).filter(|&p| Some(p) != slot).collect();
    let mut searches = SAMPLES.into_iter().peekable();
    let mut shifts = 0;
    while let Some(&samples) = searches.peek() {
        let count = ((to - from) / step).round().max(1.0) as usize;
        let indices: Vec<f64> = (0..=count).map(|i| from + (to - from) * i as f64 / count as f64).collect();
        tell(&format!("indices {:.3} to {:.3}", from, to));
        let samples = (samples * ENOUGH).div_ceil(numbers.len() as u32).max(samples);
        let tried = if slot.is_some() { &indices[..] } else { &indices[..1] };
        // What is left to chance is the same for all.
        let seed = seeds.next();
        let fit = |&index: &f64| {
            let stage = Stage::new(evidence, unknown, material, vec![index]);
            let basis = stage.trace(&numbers, &vec![samples; 2 * numbers.len()], seed);
            let mut values = best.values.clone();
            slot.into_iter().for_each(|i| values[i] = index);
            let means = |width| Means::new(&stage, &sheet, &sampled, &basis, width);
            let values = means(BLOCK).fit(values, &free, effort.seed)?;
            Ok(Point { chi2: means(1).misfit(&values), values })
        };
        let found = tried.par_iter().map(fit).collect::<Result<Vec<Point>>>()?;
        let misfits: Vec<f64> = found.iter().map(|point| point.chi2).collect();
        let lowest = lowest(&misfits);
        best = found[lowest].clone();
        let Some(i) = slot else { break };
        let near = lowest.saturating_sub(BESIDE)..(lowest + BESIDE + 1).min(indices.len());
        best.values[i] = meeting(&indices[near.clone()], &misfits[near]);
        let beyond = |bound: f64, end: f64| end != bound && (best.values[i] - end).abs() < MARGIN * step;
        if shifts < MOST_SHIFTS && (beyond(low, from) || beyond(high, to)) {
            shifts += 1;
            let half = 0.5 * (to - from);
            (from, to) = ((best.values[i] - half).max(low), (best.values[i] + half).min(high));
            continue;
        }
        searches.next();
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
        let (mut here, next) = match lowest.take_if(|lowest| found.excess(lowest) > SURE) {
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

/// The place of the lowest of some numbers, each taken together with those beside it.
fn lowest(numbers: &[f64]) -> usize {
    let beside = |i: usize, way: isize| numbers.get(i.wrapping_add_signed(way)).unwrap_or(&numbers[i]);
    let mean = |i: usize| beside(i, -1) + 2.0 * numbers[i] + beside(i, 1);
    (0..numbers.len()).min_by(|&a, &b| mean(a).total_cmp(&mean(b))).unwrap_or(0)
}

/// How finely that is told.
const PLACES: usize = 256;

/// By how many standard errors a look must find the pixels farther off than another to have gone too far.
const SURE: f64 = 1.0;

/// Looks before the search gives up to keep the answer inside the indices.
const MOST_LOOKS: usize = 8;

/// The places in a sheet of a quarter of its pixels, or of all.
fn quarter(sheet: &Sheet) -> Vec<usize> {
    let counts = |i: &usize| {
        let (x, y) = sheet.place(sheet.numbers[*i]);
        x % 2 == 0 && y % 2 == 0
    };
    let some: Vec<usize> = (0..sheet.numbers.len()).filter(counts).collect();
    if some.len() < FEW { (0..sheet.numbers.len()).collect() } else { some }
}

/// Means over square blocks of pixels: of the picture, and of what a model says.
struct Means<'a> {
    stage: &'a Stage<'a>,
    /// Block by block: the weight, the sums of the picture's channels, and those of the columns of each channel.
    blocks: Vec<(f64, [f64; 3], Vec<f64>)>,
    /// What is added to both sides of a comparison.
    floor: f64,
}

impl<'a> Means<'a> {
    /// Means of the pixels at some places of a sheet, which a basis holds in this order.
    fn new(stage: &'a Stage<'a>, sheet: &Sheet, places: &[usize], basis: &Basis, width: usize) -> Self {
        let mut blocks = BTreeMap::new();
        for (n, &i) in places.iter().enumerate() {
            let (x, y) = sheet.place(sheet.numbers[i]);
            let empty = || (0.0, [0.0; 3], vec![0.0; 3 * basis.columns]);
            let (whole, target, sums) = blocks.entry((y / width, x / width)).or_insert_with(empty);
            let weight = sheet.weight(i);
            for (sum, (a, b)) in sums.iter_mut().zip(basis.pixel(n, 0).iter().zip(basis.pixel(n, 1))) {
                *sum += weight * 0.5 * (a + b) as f64;
            }
            (0..3).for_each(|c| target[c] += weight * sheet.target[i][c] as f64);
            *whole += weight;
        }
        Self { stage, blocks: blocks.into_values().filter(|block| block.0 > 0.0).collect(), floor: 0.02 * sheet.level }
    }

    /// How far the logarithms of the means are off: the sum of squares.
    fn misfit(&self, values: &[f64]) -> f64 {
        let x = self.stage.columns(values);
        let block = |(weight, target, sums): &(f64, [f64; 3], Vec<f64>)| {
            let floor = weight * self.floor;
            let channel = |(x, (target, sums)): (&Vec<f64>, (&f64, &[f64]))| {
                let model: f64 = x.iter().zip(sums).map(|(x, s)| x * s).sum();
                ((target + floor) / (model.max(0.0) + floor)).ln().powi(2)
            };
            weight * x.iter().zip(target.iter().zip(sums.chunks(sums.len() / 3))).map(channel).sum::<f64>()
        };
        self.blocks.iter().map(block).sum()
    }

    /// The values of the `free` parameters that bring the means nearest, the others being as in `values`.
    fn fit(&self, values: Vec<f64>, free: &[usize], seed: u64) -> Result<Vec<f64>> {
        if free.is_empty() {
            return Ok(values);
        }
        let whole = |part: &[f64]| {
            let mut values = values.clone();
            free.iter().zip(part).for_each(|(&i, &v)| values[i] = v);
            values
        };
        let options = Options {
            seed,
            steps: STEPS,
            groups: (0..free.len()).map(|i| vec![i]).collect(),
            stages: vec![1.0],
            polish: true,
            tolerance: None,
            residuals: None,
        };
        let mut annealer = Annealer::new(free.iter().map(|&i| self.stage.unknown.parameters()[i].clone()).collect(), options)?;
        while let Some(part) = annealer.propose() {
            let chi2 = self.misfit(&whole(part));
            annealer.tell(chi2);
        }
        Ok(whole(&annealer.best().map_or_else(Vec::new, |b| b.values)))
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
