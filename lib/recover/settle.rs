//! Where the pixels lead, from values near that.

use super::fit::{Valley, derivatives};
use super::look::{Look, Model, Traced};
use super::scores::{BOUNDINGS, Evaluation, STEPS, Scores, pictures, products};
use super::sheet::{Channels, Half, mean, weight};
use super::total::total;
use crate::anneal::linear::Symmetric;
use crate::transport::Basis;

/// A place where the scores vanish.
pub struct Settled<'a> {
    /// What the pixels say there.
    pub scores: Scores<'a>,
    /// The variance of one sample of each pixel, as each half has it.
    pub variances: [Half; 2],
}

impl Look<'_> {
    /// Where the scores vanish, by weights that go by what the model says at values near that.
    pub fn settled<'s>(&self, traced: Traced<'s>, near: &[f64]) -> Settled<'s> {
        let (Traced { sheet, model, basis }, halves) = (traced, traced.halves(near));
        let variances = sheet.variances(&halves, basis);
        let weights = sheet.by_variance(&halves, &variances, &basis.samples);
        // The bottom of the whole χ², which is safe to find though its place is biased by the noise of the rendering.
        let whole = Whole { traced, weights: &weights.halves, bounds: self.bounds };
        let begin = whole.polish(near, &vec![true; near.len()]).values;
        let at = |place, weights| Scores::new(sheet, weights, place, self.bounds);
        let mut now = at(traced.evaluation(&begin, self.bounds), weights);
        let pulls = model.pulls();
        // What is far too bright by chance must not lead astray; what pulls hard because the values are not there yet, may.
        for _ in 0..BOUNDINGS {
            let Some(lighter) = now.bounded(pulls[0]) else { break };
            now = at(now.here, lighter);
        }
        // By steps that get shorter and shorter, each without what single pixels make of it if there is a `pull`.
        let stepped = |mut now: Scores<'s>, most: usize, pull: Option<f64>| {
            let mut size = f64::INFINITY;
            for _ in 0..most {
                if let Some(pull) = pull {
                    let Some(lighter) = now.bounded(pull) else { break };
                    now = at(now.here, lighter);
                }
                let Some((next, taken)) = self.step(&now, traced).filter(|(_, taken)| *taken < size) else { break };
                (now, size) = (at(next, now.weights), taken);
                if taken < STEADY {
                    break;
                }
            }
            now
        };
        // From there to where the scores vanish, which has no such bias.
        now = stepped(now, STEPS, None);
        // And on without what single pixels make of it, until that is the same: where the scores hardly tell, it leads on and on.
        now = stepped(now, BOUNDINGS, Some(pulls[1]));
        // Where few samples say little, all that may lead to a place that is far worse.
        if now.excess(&halves) < -worse(basis) {
            now = at(traced.evaluation(near, self.bounds), now.weights);
        }
        Settled { scores: now, variances }
    }

    /// Where the scores ask values to move, and how far that is in standard errors: as far as the model can be trusted, and half as far, and so on,
    /// while pixels are surely farther off there. `None` if there is no saying.
    fn step(&self, now: &Scores, traced: Traced) -> Option<(Evaluation, f64)> {
        let (step, here) = (now.step_within(self.bounds)?, &now.here.values);
        let part = |part: f64| {
            let asked: Vec<f64> = here.iter().zip(&step).zip(self.bounds).map(|((v, s), b)| (v + part * s).clamp(b.0, b.1)).collect();
            traced.evaluation(&traced.model.trusted(&asked), self.bounds)
        };
        let borne = (0..HALVINGS).map(|n| part(0.5f64.powi(n))).find(|place| now.excess(&place.halves) < worse(traced.basis))?;
        let taken = now.length(&borne.values.iter().zip(here).map(|(there, here)| there - here).collect::<Vec<_>>());
        Some((borne, taken))
    }
}

/// By how many standard errors pixels may be farther off after a step, of few pixels in terms of the most that they can be, which is the root of
/// their number; and how often a step is halved for that.
const WORSE: f64 = 5.0;
const MOST_EXCESS: f64 = 0.3;
const HALVINGS: i32 = 6;

/// By how many standard errors the pixels of a basis are surely farther off.
fn worse(basis: &Basis) -> f64 {
    WORSE.min(MOST_EXCESS * (basis.samples.len() as f64 / basis.sets as f64).sqrt())
}

/// A step that is not worth another, in standard errors.
pub const STEADY: f64 = 0.05;

/// χ² of the mean of both halves, pixel by pixel.
struct Whole<'a> {
    traced: Traced<'a>,
    weights: &'a [Channels; 2],
    bounds: &'a [(f64, f64)],
}

impl Valley for Whole<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        self.bounds
    }

    fn enough(&self) -> f64 {
        1e-6
    }

    fn chi2(&self, values: &[f64]) -> f64 {
        let (target, halves) = (&self.traced.sheet.target, self.traced.halves(values));
        let rest = |p: usize, c: usize| target[p][c] as f64 - mean(&halves, p, c);
        total(target.len(), 1, &|p, sum| sum[0] += (0..3).map(|c| weight(self.weights, p, c) * rest(p, c).powi(2)).sum::<f64>())[0]
    }

    fn normal_equations(&self, values: &[f64]) -> (Vec<f64>, Symmetric) {
        let Evaluation { halves, derivatives, .. } = self.traced.evaluation(values, self.bounds);
        products(self.weights, &derivatives, |p, c| mean(&halves, p, c) - self.traced.sheet.target[p][c] as f64)
    }
}

impl Evaluation {
    /// What a model says at values inside bounds.
    pub fn new(model: &dyn Model, basis: &Basis, values: &[f64], bounds: &[(f64, f64)]) -> Self {
        let coefficients = |v: &[f64]| model.coefficients(v);
        let mut all = derivatives(&coefficients, bounds, values);
        all.push(model.coefficients(values));
        let mut derivatives = pictures(basis, &all);
        Self { values: values.to_vec(), halves: derivatives.swap_remove(derivatives.len() - 1), derivatives }
    }
}
