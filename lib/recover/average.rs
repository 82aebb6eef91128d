//! What to answer where the pixels hardly tell one of the values: the average over all that it may be.
//!
//! A lobe that is narrow beside what the light does within it changes the picture with the square of its roughness: the derivative vanishes with
//! it, and what is left is noise. Standard errors are of derivatives. There, a roughness of .02 came out as .0013 ± .005, and colours, which go
//! with it, five standard errors off. So all other values are found for each that this one may have, and count by how sure it is that the pixels
//! are farther off there (a profile, integrated numerically: Venzon and Moolgavkar 1988; Hoeting et al. 1999, "Bayesian model averaging").

use super::Recovery;
use super::look::{Look, Model};
use super::scores::{Place, Scores, pictures};
use super::sheet::Sheet;
use crate::anneal::linear::Symmetric;
use crate::transport::Basis;
use rayon::prelude::*;

/// Steps of the other values to where they are best.
const STEPS: usize = 4;
/// By how many standard errors pixels must be nearer elsewhere for what was found not to be the best.
const SURE: f64 = 2.0;

impl Look<'_> {
    /// What was found; averaged, if one of its values is in doubt.
    pub fn averaged(&self, mut found: Recovery, sheet: &Sheet, model: &dyn Model, basis: &Basis) -> Recovery {
        let Some((slot, all)) = model.doubtful(&found.clarity) else { return found };
        let halves = pictures(basis, &[model.coefficients(&found.values)]).swap_remove(0);
        let weights = sheet.by_variance(&halves, &sheet.variances(&halves, basis), &basis.samples);
        let scores = |values: &[f64]| {
            let mut place = Place::new(model, basis, values, self.bounds);
            // A value that no pixel tells stays where it is.
            place.derivatives[slot].iter_mut().for_each(|half| half.fill([0.0; 3]));
            Scores::new(sheet, weights.clone(), place, self.bounds)
        };
        let best_with = |value: &f64| {
            let mut values = found.values.clone();
            values[slot] = *value;
            let mut best = scores(&values);
            for _ in 0..STEPS {
                let Some(step) = best.step() else { break };
                values.iter_mut().zip(&step).zip(self.bounds).for_each(|((v, s), b)| *v = (*v + s).clamp(b.0, b.1));
                best = scores(&values);
            }
            best
        };
        let candidates: Vec<Scores> = all.par_iter().map(best_with).collect();
        let smallest = |of: &dyn Fn(usize) -> f64| (0..all.len()).min_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap_or(0);
        let excess = |from: usize| -> Vec<f64> { candidates.iter().map(|other| candidates[from].excess(&other.place)).collect() };
        let mut best = smallest(&|i| (all[i] - found.values[slot]).abs());
        let mut off = excess(best);
        let elsewhere = smallest(&|i| off[i]);
        if off[elsewhere] < -SURE {
            (best, off) = (elsewhere, excess(elsewhere));
        }
        // What lies beyond a value that is worse is no better, but less well known.
        let farther = |i: usize| off[i.min(best)..=i.max(best)].iter().copied().fold(0.0, f64::max);
        let width = |i: usize| 0.5 * (all[(i + 1).min(all.len() - 1)] - all[i.saturating_sub(1)]);
        let shares: Vec<f64> = (0..all.len()).map(|i| width(i) * (-0.5 * farther(i).powi(2)).exp()).collect();
        let whole: f64 = shares.iter().sum();
        let mean = |of: &dyn Fn(usize) -> f64| shares.iter().enumerate().map(|(i, share)| share / whole * of(i)).sum::<f64>();
        let value = |i: usize, parameter: usize| candidates[i].place.values[parameter];
        let values: Vec<f64> = (0..found.values.len()).map(|p| mean(&|i| value(i, p))).collect();
        let within = |p: usize, q: usize| match (p == slot, q == slot) {
            (false, false) => candidates[best].covariance.at(p, q),
            (true, true) => mean(&|i| width(i).powi(2) / 12.0),
            _ => 0.0,
        };
        let between = |p: usize, q: usize| mean(&|i| (value(i, p) - values[p]) * (value(i, q) - values[q]));
        // What is left open between them, the noise of the rendering makes as large a part of as of the residuals.
        let own = candidates[best].own_part();
        found.own = Symmetric::of(values.len(), |p, q| own * (within(p, q) + between(p, q)));
        found.covariance = Symmetric::of(values.len(), |p, q| within(p, q) + between(p, q));
        found.values = values;
        found
    }
}
