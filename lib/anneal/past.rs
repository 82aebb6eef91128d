//! What a search has seen, for those who want to look back.

use super::Annealer;
use super::linear::Symmetric;

impl Annealer {
    /// Every vector that was tried, in order, with its chi-squared (the mean of those told again); `None` for what is impossible, and for what
    /// was measured by other means than those of the last stage.
    pub fn past(&self) -> impl Iterator<Item = (&[f64], Option<f64>)> {
        self.trials.iter().map(|t| (&t.values[..], Some(t.chi2).filter(|&c| c < f64::MAX && t.stage == self.stage)))
    }

    /// The correlations of the errors that noise in the picture makes, by the curvature of chi-squared; `None` before the polish knows it.
    pub fn correlations(&self) -> Option<Symmetric> {
        Some(self.fit()?.hessian.inverse()?.correlations())
    }
}
