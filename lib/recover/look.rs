//! A look at the picture: samples where they tell most, the values that explain it best near some others, and how sure they are.

use super::fit::Problem;
use super::gram::{Form, Gram};
use super::statistics::{Scores, Sheet, pictures, shares};
use super::{Effort, Recovery, Seeds};
use crate::transport::Basis;

/// A model of the picture near some values of the parameters.
pub trait Model: Sync {
    /// Traces two independent estimates of the basis of some pixels.
    fn trace(&self, pixels: &[usize], samples: &[u32], seed: u64) -> Basis;

    /// The coefficients of the columns of each channel for values of the parameters.
    fn coefficients(&self, values: &[f64]) -> [Vec<f64>; 3];

    /// The nearest values at which the model can be trusted.
    fn trusted(&self, values: &[f64]) -> Vec<f64>;
}

/// The fewest and the most samples of a pixel in each half of a round, whatever its share.
const SAMPLES: (f64, f64) = (4.0, 1024.0);

/// Steps toward the values that the scores ask for.
const STEPS: usize = 12;

/// What is looked at, and with what in mind.
pub struct Look<'a> {
    /// The pixels.
    pub sheet: &'a Sheet<'a>,
    /// Bounds of the parameters.
    pub bounds: &'a [(f64, f64)],
    /// Mean samples of a pixel in each half, round by round; it ends before the last when the noise of the rendering hardly matters.
    pub rounds: &'a [f64],
    /// Which part of the samples each pixel gets; 1 is the mean.
    pub shares: &'a [f64],
    /// Who is told what each round finds.
    pub effort: &'a Effort<'a>,
}

impl Look<'_> {
    /// Traces and fits, round by round, until what was found is enough, given what was found the round before. Also says which shares would
    /// have been best.
    pub fn at(
        &self,
        model: &dyn Model,
        near: &[f64],
        seeds: &mut Seeds,
        enough: &dyn Fn(&Recovery, Option<&Recovery>) -> bool,
    ) -> (Recovery, Vec<f64>) {
        let mut best = near.to_vec();
        let mut basis: Option<Basis> = None;
        let mut before: Option<Recovery> = None;
        for (round, mean) in self.rounds.iter().enumerate() {
            let samples: Vec<u32> = self.shares.iter().map(|share| (mean * share).clamp(SAMPLES.0, SAMPLES.1) as u32).collect();
            let mut all = model.trace(self.sheet.numbers, &samples, seeds.next());
            if let Some(basis) = &basis {
                all.join(basis);
            }
            let (found, shares) = self.fit(model, &all, &best);
            (self.effort.told)(&found);
            if round + 1 == self.rounds.len() || enough(&found, before.as_ref()) {
                return (found, shares);
            }
            best = found.values.clone();
            (basis, before) = (Some(all), Some(found));
        }
        unreachable!("a look has rounds")
    }

    /// The values that explain the picture best, near some.
    fn fit(&self, model: &dyn Model, basis: &Basis, near: &[f64]) -> (Recovery, Vec<f64>) {
        let sheet = self.sheet;
        let halves = pictures(basis, &model.coefficients(near));
        let variance = sheet.variance(&halves, &basis.samples);
        let weights = sheet.by_variance(&halves, &variance, &basis.samples);
        let gram = Gram::new(basis, &sheet.target, &weights, Form::Whole);
        let problem = Problem { gram: &gram, coefficients: &|v| model.coefficients(v), bounds: self.bounds };
        // The bottom of the whole χ², which is safe to find though its place is biased by the noise of the rendering.
        let mut values = problem.polish(near, &vec![true; near.len()]).values;
        let scores = |values: &[f64]| {
            let halves = pictures(basis, &model.coefficients(values));
            let derivatives = problem.jacobian(values).iter().map(|j| pictures(basis, j)).collect();
            Scores::new(sheet, &weights, halves, derivatives, self.bounds)
        };
        // From there to where the scores vanish, which has no such bias.
        let mut now = scores(&values);
        let mut size = f64::INFINITY;
        for _ in 0..STEPS {
            let Some(step) = now.step() else { break };
            let moved: Vec<f64> = values.iter().zip(&step).zip(self.bounds).map(|((v, s), b)| (v + s).clamp(b.0, b.1)).collect();
            let moved = model.trusted(&moved);
            let taken = now.length(&moved.iter().zip(&values).map(|(a, b)| a - b).collect::<Vec<_>>());
            if !(taken < size) {
                break;
            }
            size = taken;
            values = moved;
            now = scores(&values);
            if taken < 0.02 {
                break;
            }
        }
        let next = shares(&now, &weights, &variance);
        let (covariance, own) = now.covariances();
        let losses = now.losses(&sheet.relative());
        (Recovery { values, covariance, own, chi2: now.chi2(), pixels: sheet.numbers.len(), losses }, next)
    }
}
