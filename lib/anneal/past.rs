//! What a search has seen, for those who want to look back.

use super::Annealer;
use super::linear::Symmetric;
use super::rugged::Lines;

impl Annealer {
    /// Every vector that was tried, in order, with its chi-squared (the mean of those told again); `None` for what is impossible, and for what
    /// was measured by other means than those of the last stage.
    pub fn past(&self) -> impl Iterator<Item = (&[f64], Option<f64>)> {
        self.trials.iter().map(|t| (&t.values[..], Some(t.chi2).filter(|&c| c < f64::MAX && t.stage == self.stage)))
    }

    /// Whether all that was told is the same number: then nothing was learnt.
    pub fn is_flat(&self) -> bool {
        self.trials.windows(2).all(|pair| pair[0].chi2 == pair[1].chi2)
    }

    /// By how much chi-squared jumps from one vector to the next, where it is the same again for the same; 0 where it does not, and before that is known.
    pub fn jumps(&self) -> f64 {
        self.lines.as_ref().map_or(0.0, Lines::jumps)
    }

    /// The correlations of the errors that noise in the picture makes, by the curvature of chi-squared; `None` before the polish knows it.
    pub fn correlations(&self) -> Option<Symmetric> {
        Some(self.fit()?.hessian.inverse()?.correlations())
    }

    /// The covariance of the errors, infinite where nothing determines a parameter; `None` before they are known.
    pub fn covariance(&self) -> Option<Symmetric> {
        let errors = self.standard_errors()?;
        let correlations = self.correlations();
        Some(Symmetric::of(errors.len(), |i, j| match &correlations {
            _ if i == j => errors[i].powi(2),
            Some(r) if errors[i].is_finite() && errors[j].is_finite() => r.at(i, j) * errors[i] * errors[j],
            _ => 0.0,
        }))
    }
}
