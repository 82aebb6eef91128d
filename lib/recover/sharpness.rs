//! Whether the picture is as sharp as its pixels are taken to be.
//!
//! A picture that was filtered, or is a camera's, mixes the light of neighbouring pixels. A mirror seems rough by that: pixels of radius .6
//! (`pfilt -r .6`) make a roughness of .01 one of .02, and the pixels inside the object hardly tell. Its outline and that of what it mirrors do.

use super::Recovery;
use super::look::{Look, Traced};
use super::scores::{Evaluation, Scores, Way};
use super::sheet::{Half, Sheet};
use super::words::digits;
use crate::anneal::linear::Symmetric;
use crate::render::Filter;
use serde::{Deserialize, Serialize};

/// How a picture's pixels are blurred: variances along each axis, in pixels².
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Blur {
    /// What they are taken for.
    pub taken: f64,
    /// Whether that was found, and the values reckon with what is still to be added.
    pub sought: bool,
    /// By how much more they seem to be blurred; below 0 where they are sharper.
    pub more: f64,
    /// The standard error of that.
    pub error: f64,
}

/// From how many standard errors, and from how much, a blur is told.
const SURE: f64 = 5.0;
const LEAST: f64 = 0.01;
/// The part of itself that it may be wrong by, to first order: a third where it is .1.
const WRONG: f64 = 0.2;

/// The bounds of what may be found at once.
const BOUNDS: (f64, f64) = (-4.0, 4.0);
/// Steps to it: weights go by what is left of the picture.
const STEPS: usize = 3;

impl Blur {
    /// Whether the pixels are surely not what they are taken for.
    pub fn is_sure(&self) -> bool {
        self.more.abs() > SURE * self.error && self.more.abs() > LEAST
    }

    /// The variance that the pixels seem to have.
    pub fn variance(&self) -> f64 {
        self.taken + self.more
    }

    /// The radius of the Gaussian (`pfilt -r`) that blurs as much as the picture is blurred, and its standard error, in pixels.
    pub fn radius(&self) -> (f64, f64) {
        let radius = Filter::radius(self.variance());
        let error = self.error.hypot(WRONG * self.more);
        (radius, error / radius.max(error.sqrt()))
    }

    /// What is to be said of it where it was sought.
    pub fn title(&self) -> String {
        let (radius, error) = self.radius();
        let (radius, error) = digits(radius, error);
        format!("filter {radius} ± {error}")
    }
}

impl Look<'_> {
    /// What was found, with how the picture is blurred; where that was to be found too, moved on by it.
    pub fn blurred(&self, mut found: Recovery, traced: Traced) -> Recovery {
        let (blur, way) = self.blur(traced, &found.values).unzip();
        found.blur = blur;
        // What strayed goes on from where it is.
        let reckoned = self.evidence.blurred && traced.model.holds(&found, traced.basis);
        self.moved(found, way.filter(|_| reckoned), traced.model)
    }

    /// How the picture seems to be blurred where the values are about as given, and where those go with what it is more blurred than it is taken to
    /// be. `None` if there is no saying.
    ///
    /// To first order the variance of a blur changes a picture by half its Laplacian, times that: it is one more value to fit, beside the others.
    fn blur(&self, traced: Traced, values: &[f64]) -> Option<(Blur, Way)> {
        let Traced { sheet, basis, .. } = traced;
        let Evaluation { mut values, mut halves, mut derivatives } = traced.evaluation(values, self.bounds);
        let variances = sheet.variances(&halves, basis);
        let (n, mut bounds) = (values.len(), self.bounds.to_vec());
        values.push(0.0);
        bounds.push(BOUNDS);
        derivatives.push(halves.iter().map(|half| laplacian(sheet, half)).collect());
        let mut covariance = None;
        for _ in 0..STEPS {
            let weights = sheet.by_variance(&halves, &variances, &basis.samples);
            let scores = Scores::new(sheet, weights, Evaluation { values, halves, derivatives }, &bounds);
            let step = scores.step()?;
            covariance = Some(scores.covariance);
            Evaluation { values, halves, derivatives } = scores.here;
            values.iter_mut().zip(&step).for_each(|(value, step)| *value += step);
            for (derivative, step) in derivatives.iter().zip(&step) {
                for (value, slope) in halves.iter_mut().flatten().flatten().zip(derivative.iter().flatten().flatten()) {
                    *value += step * slope;
                }
            }
        }
        let (covariance, more) = (covariance?, values[n]);
        let variance = covariance.at(n, n);
        let goes = |i: usize| covariance.at(i, n) / variance;
        let unsure = variance + (WRONG * more).powi(2);
        let way = ((0..n).map(|i| more * goes(i)).collect(), Symmetric::of(n, |i, j| unsure * goes(i) * goes(j)));
        Some((Blur { taken: self.evidence.film.filter.variance(), sought: self.evidence.blurred, more, error: variance.sqrt() }, way))
    }
}

/// Half the Laplacian of a picture: what the four neighbours of each pixel have more than it.
fn laplacian(sheet: &Sheet, half: &Half) -> Half {
    let at = |i: usize| std::array::from_fn(|c| 0.5 * sheet.beside(i, half).iter().map(|beside| beside[c] - half[i][c]).sum::<f64>());
    (0..half.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recover::misfit::Misfit;

    #[test]
    fn a_filter_that_was_found_where_nothing_explains_the_picture_is_doubted() {
        let told = |areas: f64, sought: bool| {
            let blur = Some(Blur { taken: 0.16, sought, more: 0.0, error: 0.01 });
            Recovery { blur, misfit: Misfit { areas, ..Misfit::default() }, ..Recovery::plain(&[0.5], &[0.1]) }.filter()
        };
        let told_so = told(0.0, true).unwrap();
        assert!(told_so.starts_with("filter 0.") && told_so.contains(" ± 0.0"), "{told_so}");
        assert_eq!(told(0.05, true).unwrap(), told_so + ", or something else is not as in the picture");
        assert_eq!(told(0.05, false), None);
    }
}
