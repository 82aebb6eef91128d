//! The index of refraction all over its range: whose picture comes nearest, by the logarithms of pixels.
//!
//! The index bends all paths, and the picture changes with it as a kaleidoscope does: where pixels are compared by squares, the right index is
//! a needle that no descent finds. Their logarithms fall toward it from afar. The colours, which pixels that are dark by chance would spoil,
//! come from the means of blocks of pixels.

use super::stage::Stage;
use super::through::Through;
use crate::anneal::{Annealer, Options};
use crate::error::Result;
use crate::recover::fit::Point;
use crate::recover::look::Model;
use crate::recover::sheet::Sheet;
use crate::recover::{Effort, Seeds};
use crate::sampling::mix64;
use crate::transport::Basis;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Pixels that are looked at, and samples of them all in each half, search by search. Rather few pixels that are known well than many that are not:
/// noise makes the valley shallow. But its floor is ragged by what few pixels show: where it is not clear, there are more of them.
const PIXELS: usize = 200;
const SAMPLES: [u32; 3] = [1200, 1600, 3200];
/// About how many of them there are in a block.
const TOGETHER: f64 = 4.0;
/// By how much the logarithms of a pixel must be off for it to say little more when it is farther off: what is rough within a pixel is never near.
const FAR_OFF: f64 = 0.2;
/// Distance of the indices of the first search, and how much nearer those of the next stand.
const FIRST: f64 = 0.1;
const NEARER: f64 = 4.0;
/// How many indices on either side of the best tell where between them it is.
const BESIDE: usize = 3;
/// Where two lines explain less than this part of the misfits' variance, what is seen is noise: then as many times as many pixels are looked at, with as
/// many samples of each, and at most so many times. (With more samples of the same, an index of 1.83, seen through thin legs, was as likely anywhere
/// from 1.78 to 1.86, and came out as 1.786 ± .002.)
const CLEAR: f64 = 0.6;
const MORE: u32 = 4;
const MOST_MORE: u32 = 16;
/// In terms of their distance, how near to the last index tried the best is followed beyond it; and how many times.
const MARGIN: f64 = 1.5;
const MOST_SHIFTS: usize = 6;
/// Evaluations of the annealing at each index.
const STEPS: usize = 300;

/// A search for the index of an unknown.
pub struct Search<'a> {
    /// What is looked at.
    pub through: &'a Through<'a>,
    /// Where the index can be: one place if it is known.
    pub range: (f64, f64),
    /// What fixes the choices of the annealing, and when to end.
    pub effort: &'a Effort<'a>,
}

impl Search<'_> {
    /// The values that come nearest, and where the index is by them: sought at indices all over the range first, then at nearer and nearer ones
    /// around the best.
    pub fn best(&self, sheet: &Sheet, seeds: &mut Seeds, tell: &dyn Fn(&str)) -> Result<(Vec<f64>, (f64, f64))> {
        let (slot, (low, high)) = (self.through.slot(), self.range);
        let mut best = self.through.unknown.start();
        let (mut from, mut to, mut step) = (low, high, FIRST);
        let mut searches = SAMPLES.into_iter().peekable();
        let (mut shifts, mut more, mut known) = (0, 1, self.range);
        while let Some(samples) = searches.peek().map(|samples| samples * more) {
            tell(&format!("indices {from:.3} to {to:.3}"));
            let count = if slot.is_some() { ((to - from) / step).round().max(1.0) as usize } else { 0 };
            let indices: Vec<f64> = (0..=count).map(|i| from + (to - from) * i as f64 / count.max(1) as f64).collect();
            // What is left to chance is the same for all.
            let seed = seeds.next();
            let places = some(sheet, PIXELS * more as usize);
            let at = |&index: &f64| self.at(index, &best, sheet, &places, samples, seed);
            let found = indices.par_iter().with_max_len(1).map(at).collect::<Result<Vec<Point>>>()?;
            let misfits: Vec<f64> = found.iter().map(|point| point.chi2).collect();
            let lowest = lowest(&misfits);
            best.clone_from(&found[lowest].values);
            let Some(i) = slot else { break };
            let near = lowest.saturating_sub(BESIDE)..(lowest + BESIDE + 1).min(indices.len());
            let clear;
            (best[i], clear) = meeting(&indices[near.clone()], &misfits[near]);
            let time = self.effort.quick || !self.effort.late();
            if clear < CLEAR && more < MOST_MORE && !self.effort.quick && time {
                more *= MORE;
                continue;
            }
            let aside = BESIDE as f64 * step;
            known = if clear < CLEAR { self.range } else { ((best[i] - aside).max(low), (best[i] + aside).min(high)) };
            let beyond = |bound: f64, end: f64| end != bound && (best[i] - end).abs() < MARGIN * step;
            let reach = if shifts < MOST_SHIFTS && time && (beyond(low, from) || beyond(high, to)) {
                shifts += 1;
                0.5 * (to - from)
            } else {
                searches.next();
                more = 1;
                step /= NEARER;
                NEARER * step
            };
            (from, to) = ((best[i] - reach).max(low), (best[i] + reach).min(high));
        }
        Ok((best, known))
    }

    /// The colours at an index, the values being else as given, and the misfit of pixels there.
    fn at(&self, index: f64, values: &[f64], sheet: &Sheet, places: &[usize], samples: u32, seed: u64) -> Result<Point> {
        let numbers: Vec<usize> = places.iter().map(|&i| sheet.numbers[i]).collect();
        let samples = samples.div_ceil(numbers.len() as u32);
        let stage = Stage::new(self.through, vec![index]);
        let basis = stage.trace_all(&numbers, samples, seed);
        let mut values = values.to_vec();
        self.through.slot().into_iter().for_each(|i| values[i] = index);
        let means = |width| Means::new(&stage, sheet, places, &basis, width);
        let block = (TOGETHER * sheet.numbers.len() as f64 / places.len() as f64).sqrt().ceil() as usize;
        let values = means(block).fit(values, self.effort.seed)?;
        Ok(Point { chi2: means(1).misfit(&values), values })
    }
}

/// Where two lines meet that rise alike to both sides and come nearest to misfits at rising indices (least squares), and which part of their variance
/// these explain.
fn meeting(indices: &[f64], misfits: &[f64]) -> (f64, f64) {
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
    let at = places.max_by(|a, b| explained(*a).total_cmp(&explained(*b))).unwrap_or(first);
    let all: f64 = misfits.iter().map(|misfit| (misfit - level).powi(2)).sum();
    (at, if all > 0.0 { explained(at) / all } else { 1.0 })
}

/// How finely that is told.
const PLACES: usize = 256;

/// The place of the lowest of some numbers, each taken together with those beside it.
fn lowest(numbers: &[f64]) -> usize {
    let beside = |i: usize, way: isize| numbers.get(i.wrapping_add_signed(way)).unwrap_or(&numbers[i]);
    let mean = |i: usize| beside(i, -1) + 2.0 * numbers[i] + beside(i, 1);
    (0..numbers.len()).min_by(|&a, &b| mean(a).total_cmp(&mean(b))).unwrap_or(0)
}

/// The places in a sheet of so many of its pixels, from all over it, or of all.
fn some(sheet: &Sheet, count: usize) -> Vec<usize> {
    let mut places: Vec<usize> = (0..sheet.numbers.len()).collect();
    places.sort_by_key(|i| mix64(*i as u64));
    places.truncate(count);
    places
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
    fn squares(&self, values: &[f64]) -> f64 {
        self.off(values).map(|(weight, square)| weight * square).sum()
    }

    /// The same where what is far off says little more than that it is: the logarithm of a Cauchy distribution.
    fn misfit(&self, values: &[f64]) -> f64 {
        self.off(values).map(|(weight, square)| weight * (square / FAR_OFF.powi(2)).ln_1p()).sum()
    }

    /// The weight of each block, and the sum over channels of the squares by which the logarithms of its means are off.
    fn off(&self, values: &[f64]) -> impl Iterator<Item = (f64, f64)> {
        let x = self.stage.columns(values);
        self.blocks.iter().map(move |(weight, target, sums)| {
            let floor = weight * self.floor;
            let channel = |(x, (target, sums)): (&Vec<f64>, (&f64, &[f64]))| {
                let model: f64 = x.iter().zip(sums).map(|(x, s)| x * s).sum();
                ((target.max(0.0) + floor) / (model.max(0.0) + floor)).ln().powi(2)
            };
            (*weight, x.iter().zip(target.iter().zip(sums.chunks(sums.len() / 3))).map(channel).sum())
        })
    }

    /// The values that bring the means nearest, the index being as in `values`.
    fn fit(&self, values: Vec<f64>, seed: u64) -> Result<Vec<f64>> {
        let through = self.stage.through;
        let free: Vec<usize> = (0..values.len()).filter(|&i| Some(i) != through.slot()).collect();
        if free.is_empty() {
            return Ok(values);
        }
        let whole = |part: &[f64]| {
            let mut values = values.clone();
            free.iter().zip(part).for_each(|(&i, &v)| values[i] = v);
            values
        };
        let options = Options { seed, steps: STEPS, groups: (0..free.len()).map(|i| vec![i]).collect(), ..Options::default() };
        let mut annealer = Annealer::new(free.iter().map(|&i| through.unknown.parameters()[i].clone()).collect(), options)?;
        annealer.drive(|part, _| self.squares(&whole(part)));
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
            let (met, clear) = meeting(&indices, &misfits);
            assert!((met - at).abs() < 0.002 && clear > 0.98, "{at}: {met}, {clear}");
        }
        assert!((1.4..=1.6).contains(&meeting(&indices, &[1.0; 9]).0));
        // What is ragged only says nothing.
        assert!(meeting(&indices, &[3.0, -3.0, 3.0, -3.0, 3.0, -3.0, 3.0, -3.0, 3.0]).1 < 0.2);
    }

    #[test]
    fn the_lowest_is_so_with_those_beside_it() {
        // One that is low by chance is not.
        assert_eq!(lowest(&[9.0, 8.0, 2.0, 9.0, 4.0, 3.0, 4.0, 8.0]), 5);
        assert_eq!(lowest(&[1.0, 2.0, 3.0]), 0);
        assert_eq!(lowest(&[3.0, 2.0, 1.0]), 2);
        assert_eq!(lowest(&[7.0]), 0);
    }
}
