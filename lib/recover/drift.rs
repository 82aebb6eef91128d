//! How far a fit leads astray that holds back what is far too bright: what it finds in pictures whose values are known.
//!
//! Few samples of a pixel see what glints behind glass, so a photograph of few samples is too dark nearly everywhere, and far too bright here and
//! there. Both make its mean; without the bright ones a transmissivity of .9 comes out by .007 too low. But as much is missing from pictures that
//! the model makes of what was found, with as many samples (parametric bootstrap: Efron 1979, "Bootstrap methods: another look at the jackknife").

use super::Seeds;
use super::look::{Fit, Look, Traced};
use super::scores::{Way, pictures};
use super::sheet::Sheet;
use crate::anneal::linear::Symmetric;

/// How many samples such pictures may hold together, in terms of all that the values were found with, and about how much time they take.
pub const PICTURES: f64 = 0.5;
/// The least share that is worth beginning with.
pub const LATE: f64 = 0.2;

/// The most pairs of pictures.
const PAIRS: f64 = 4.0;

impl Look<'_> {
    /// How far values that were found with this basis must go back, as the same fit finds others where they are the true ones. Takes `share` as
    /// many samples as the basis, at the most.
    pub fn drift(&self, traced: Traced, values: &[f64], share: f64, seeds: &mut Seeds) -> Way {
        let Traced { sheet, model, basis } = traced;
        let (coefficients, halves) = ([model.coefficients(values)], traced.halves(values));
        let pixels = sheet.numbers.len();
        let most = share * basis.samples.iter().map(|n| *n as f64).sum::<f64>() / (2 * pixels) as f64;
        let samples = sheet.samples(&halves, &sheet.variances(&halves, basis)).min(most).round().max(1.0);
        let pairs = (most / samples).clamp(1.0, PAIRS) as usize;
        let again = |picture: &[[f64; 3]]| -> Vec<f64> {
            let sheet = Sheet::of(self.evidence, sheet.numbers, picture.iter().map(|p| p.map(|v| v as f32)).collect());
            let Fit { found, withheld, .. } = self.fit(Traced { sheet: &sheet, ..traced }, values);
            let found = self.moved(found, withheld, model);
            values.iter().zip(&found.values).map(|(true_value, found)| true_value - found).collect()
        };
        let ways: Vec<Vec<f64>> = (0..pairs)
            .flat_map(|_| {
                let photographs = model.trace_all(sheet.numbers, samples as u32, seeds.next());
                pictures(&photographs, &coefficients).swap_remove(0)
            })
            .map(|picture| again(&picture))
            .collect();
        let n = ways.len() as f64;
        let mean: Vec<f64> = (0..values.len()).map(|i| ways.iter().map(|way| way[i]).sum::<f64>() / n).collect();
        let product = |i: usize, j: usize| ways.iter().map(|way| (way[i] - mean[i]) * (way[j] - mean[j])).sum::<f64>();
        let covariance = Symmetric::of(mean.len(), |i, j| product(i, j) / (n * (n - 1.0)));
        (mean, covariance)
    }
}
