//! What to answer where the pixels hardly tell some of the values: the average over all that they may be.
//!
//! A lobe that is narrow beside what the light does within it changes the picture with the square of its roughness: the derivative vanishes with
//! it, and what is left is noise. Standard errors are of derivatives. There, a roughness of .02 came out as .0013 ± .005, and colours, which go
//! with it, five standard errors off. So all other values are found for each that these may have, and count by how sure it is that the pixels are
//! farther off there (a profile, integrated numerically: Venzon and Moolgavkar 1988; Hoeting et al. 1999, "Bayesian model averaging"). Where the
//! rendering is far noisier than at what was found, pixels tell nothing, and what seems to be nearer there is chance: a roughness of .03, seen
//! through a body, came out as .09 and colours of .7 as .97.

use super::Recovery;
use super::look::{Look, Traced};
use super::scores::{Scores, Way};
use super::settle::STEADY;
use crate::anneal::linear::Symmetric;
use rayon::prelude::*;

/// Steps of the other values to where they are best.
const STEPS: usize = 4;
/// By how many standard errors pixels must be nearer elsewhere for what was found not to be the best.
const SURE: f64 = 2.0;
/// How many times the rendering's noise where the values were found it may be elsewhere for pixels to tell how far off they are there.
const NOISY: f64 = 30.0;

/// All that the values in doubt may be together, in a row: the last of them changes fastest.
struct Range {
    /// The place of each among the parameters, and all that it may be, rising.
    axes: Vec<(usize, Vec<f64>)>,
}

impl Range {
    fn len(&self) -> usize {
        self.axes.iter().map(|(_, all)| all.len()).product()
    }

    /// Where each value in doubt is: its place among the parameters, all that it may be, which of these, and how far in the row the next is.
    fn places(&self, i: usize) -> impl Iterator<Item = (usize, &[f64], usize, usize)> {
        let mut stride = self.len();
        self.axes.iter().map(move |(slot, axis)| {
            stride /= axis.len();
            (*slot, &axis[..], i / stride % axis.len(), stride)
        })
    }

    /// The parameters in doubt and their values.
    fn values(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        self.places(i).map(|(slot, axis, at, _)| (slot, axis[at]))
    }

    /// The part of all that they may be that this stands for.
    fn size(&self, i: usize) -> f64 {
        self.places(i).map(|(_, axis, at, _)| width(axis, at)).product()
    }

    /// The variance of a value in doubt within that part; at an end of its axis also within all that lies beyond, where was not looked.
    fn variance(&self, i: usize, parameter: usize, (low, high): (f64, f64)) -> f64 {
        let own = |(_, axis, at, _): (usize, &[f64], usize, usize)| {
            let below = if at == 0 { axis[0] - low } else { 0.0 };
            let above = if at + 1 == axis.len() { high - axis[at] } else { 0.0 };
            width(axis, at).powi(2) / 12.0 + below.max(above).max(0.0).powi(2) / 3.0
        };
        self.places(i).filter(|(slot, ..)| *slot == parameter).map(own).sum()
    }

    /// The most of `off` that must be crossed from `start` to each other place, by steps along one axis, on the best way.
    fn crossed(&self, off: &[f64], start: usize) -> Vec<f64> {
        let mut levels = vec![f64::INFINITY; off.len()];
        levels[start] = off[start].max(0.0);
        for _ in 0..off.len() {
            for i in 0..off.len() {
                let beside = self
                    .places(i)
                    .flat_map(|(_, axis, at, stride)| [(at > 0).then(|| i - stride), (at + 1 < axis.len()).then(|| i + stride)]);
                let nearest = beside.flatten().map(|i| levels[i]).fold(f64::INFINITY, f64::min);
                levels[i] = levels[i].min(nearest.max(off[i]));
            }
        }
        levels
    }
}

/// The part of an axis that a value on it stands for.
fn width(axis: &[f64], at: usize) -> f64 {
    0.5 * (axis[(at + 1).min(axis.len() - 1)] - axis[at.saturating_sub(1)])
}

impl Look<'_> {
    /// What was found, and moved `aside` since; averaged, if some of its values are in doubt.
    pub fn averaged(&self, mut found: Recovery, aside: &Way, traced: Traced) -> Recovery {
        // What surely would go beyond a bound is not in doubt: within the bounds there is nothing to average it over.
        let range = Range { axes: traced.model.doubtful(&found).into_iter().filter(|(slot, _)| !found.pressed[*slot]).collect() };
        if range.axes.is_empty() {
            return found;
        }
        let near: Vec<f64> = found.values.iter().zip(&aside.0).map(|(value, way)| value - way).collect();
        let valley = self.valley(&range, &near, traced);
        let candidates: Vec<Scores> =
            (0..range.len()).into_par_iter().with_max_len(1).map(|i| valley(&range.values(i).collect::<Vec<_>>())).collect();
        let (best, off) = compared(&range, &candidates, &near);
        let shares: Vec<f64> = (0..range.len()).map(|i| range.size(i) * (-0.5 * off[i].powi(2)).exp()).collect();
        let whole: f64 = shares.iter().sum();
        let mean = |of: &dyn Fn(usize) -> f64| shares.iter().enumerate().map(|(i, share)| share / whole * of(i)).sum::<f64>();
        let value = |i: usize, parameter: usize| candidates[i].here.values[parameter];
        // The values in doubt are what they are on the average, and the others what they are best with those.
        let middle: Vec<(usize, f64)> = range.axes.iter().map(|(slot, _)| (*slot, mean(&|i| value(i, *slot)))).collect();
        let values = valley(&middle).here.values;
        let doubtful = |parameter: usize| range.axes.iter().any(|(slot, _)| *slot == parameter);
        let within = |p: usize, q: usize| match (doubtful(p), doubtful(q)) {
            (false, false) => candidates[best].covariance.at(p, q),
            _ if p == q => mean(&|i| range.variance(i, p, self.bounds[p])),
            _ => 0.0,
        };
        let between = |p: usize, q: usize| mean(&|i| (value(i, p) - values[p]) * (value(i, q) - values[q]));
        // What is left open between them, the noise of the rendering makes as large a part of as of the residuals.
        let own = candidates[best].own_part();
        found.own = Symmetric::of(values.len(), |p, q| own * (within(p, q) + between(p, q)));
        found.covariance = Symmetric::of(values.len(), |p, q| within(p, q) + between(p, q) + aside.1.at(p, q));
        let moved = values.iter().zip(&aside.0).map(|(value, way)| value + way);
        found.values = moved.zip(self.bounds).map(|(value, (low, high))| value.clamp(*low, *high)).collect();
        found
    }

    /// What is best of all other values where those in doubt are what they are said to be, from `near`.
    fn valley<'s>(&'s self, range: &'s Range, near: &'s [f64], traced: Traced<'s>) -> impl Fn(&[(usize, f64)]) -> Scores<'s> + Sync + 's {
        let Traced { sheet, basis, .. } = traced;
        let halves = traced.halves(near);
        let weights = sheet.by_variance(&halves, &sheet.variances(&halves, basis), &basis.samples);
        let scores = move |values: &[f64]| {
            let mut here = traced.evaluation(values, self.bounds);
            // A value that no pixel tells stays where it is.
            for (slot, _) in &range.axes {
                here.derivatives[*slot].iter_mut().for_each(|half| half.fill([0.0; 3]));
            }
            Scores::new(sheet, weights.clone(), here, self.bounds)
        };
        move |said| {
            let mut values = near.to_vec();
            said.iter().for_each(|&(slot, value)| values[slot] = value);
            let mut best = scores(&values);
            for _ in 0..STEPS {
                let Some(step) = best.step_within(self.bounds).filter(|step| best.length(step) > STEADY) else { break };
                values.iter_mut().zip(&step).zip(self.bounds).for_each(|((v, s), b)| *v = (*v + s).clamp(b.0, b.1));
                best = scores(&values);
            }
            best
        }
    }
}

/// The best of all candidates, which is the one beside what was found unless another is surely better, and by how many standard errors pixels are
/// farther from each of them. What lies beyond a value that is worse is no better, but less well known.
fn compared(range: &Range, candidates: &[Scores], found: &[f64]) -> (usize, Vec<f64>) {
    let smallest = |of: &dyn Fn(usize) -> f64| (0..range.len()).min_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap_or(0);
    let beside = smallest(&|i| range.values(i).map(|(slot, value)| (value - found[slot]).abs()).sum());
    let noise: Vec<f64> = candidates.iter().map(|c| c.squares(-1.0)).collect();
    let most = NOISY * noise[beside];
    let excess = |from: usize| -> Vec<f64> {
        let off = |(other, noise): (&Scores, &f64)| if *noise > most { f64::INFINITY } else { candidates[from].excess(&other.here.halves) };
        candidates.iter().zip(&noise).map(off).collect()
    };
    let off = excess(beside);
    let elsewhere = smallest(&|i| off[i]);
    let (best, off) = if off[elsewhere] < -SURE { (elsewhere, excess(elsewhere)) } else { (beside, off) };
    (best, range.crossed(&off, best))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_beyond_something_worse_is_as_bad_unless_there_is_a_way_around() {
        let range = Range { axes: vec![(4, vec![1.0, 2.0, 4.0]), (5, vec![1.0, 2.0, 4.0])] };
        let off = [0.0, 9.0, 1.0, -1.0, 5.0, 2.0, 7.0, 3.0, 2.0];
        assert_eq!(range.crossed(&off, 0), [0.0, 9.0, 5.0, 0.0, 5.0, 5.0, 7.0, 5.0, 5.0]);
        assert_eq!(range.values(5).collect::<Vec<_>>(), [(4, 2.0), (5, 4.0)]);
        assert_eq!(range.size(4), 1.5 * 1.5);
        // At an end of an axis it may lie anywhere up to the bound.
        assert_eq!(range.variance(3, 4, (0.0, 4.0)), 1.5 * 1.5 / 12.0);
        assert_eq!(range.variance(6, 4, (0.0, 10.0)), 1.0 / 12.0 + 36.0 / 3.0);
    }
}
