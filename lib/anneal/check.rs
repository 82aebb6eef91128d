//! Whether a search that was read back can be gone on with: a file may be damaged, or made by hand. And whether a chi-squared can be reckoned with.

use super::{Annealer, Purpose};

/// The largest chi-squared that can be reckoned with: sums and differences of two are finite.
const LARGEST: f64 = 1e307;

/// Whether a chi-squared can be reckoned with: it is a number, and none beyond 1e307. What has another is impossible.
pub fn is_possible(chi2: f64) -> bool {
    chi2.abs() <= LARGEST
}

impl Annealer {
    /// Whether all parts fit together, so that going on cannot fail.
    pub fn is_consistent(&self) -> bool {
        let (count, trials) = (self.parameters.len(), self.trials.len());
        let within =
            |values: &[f64]| values.len() == count && self.parameters.iter().zip(values).all(|(p, v)| (p.low..=p.high).contains(v));
        // What a new search is made of must pass the same checks.
        Self::new(self.parameters.clone(), self.options.clone()).is_ok()
            && self.stage < self.options.stages.len()
            && self.trials.iter().all(|trial| {
                within(&trial.values) && (is_possible(trial.chi2) || trial.chi2 == f64::MAX) && trial.times > 0 && trial.stage <= self.stage
            })
            && self.trials.iter().map(|trial| trial.times as usize).sum::<usize>() == self.told
            && self.walk.as_ref().is_none_or(|walk| walk.is_consistent(count, trials))
            && self.lines.as_ref().is_none_or(|lines| lines.is_consistent(count))
            && self.polish.as_ref().is_none_or(|polish| polish.is_consistent(count))
            && self.answer.is_none_or(|answer| answer < trials)
            && self.next.is_some() == self.end.is_none()
            && self.next.as_ref().is_none_or(|next| {
                within(&next.values)
                    && match &next.purpose {
                        Purpose::Survey | Purpose::Line | Purpose::Polish => true,
                        Purpose::Step(step) => self.walk.as_ref().is_some_and(|walk| walk.has(step, count)),
                        Purpose::Again(trial) | Purpose::Carry(trial) => *trial < trials,
                    }
            })
    }
}
