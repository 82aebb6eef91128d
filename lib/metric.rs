//! How far two pictures are from each other: chi-squared (equation 11 of the method this project follows) and its kin.
//!
//! Pictures are compared in radiance, W/(sr·m²), value by value: red, green and blue of each pixel. The first picture is the
//! reference (the photograph), the second what shall resemble it (the rendering).

use crate::error::{Error, Result};
use crate::picture::{Picture, place};
use serde::{Deserialize, Serialize};

pub mod heat;

/// What keeps the relative measures finite where the reference is black: .01, where the reference's average is 1 (Rousselle et
/// al. 2011, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", section 5, made independent of units).
pub const EPSILON: f64 = 0.01;

/// What a search makes small, so that a rendering resembles a photograph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Loss {
    /// Chi-squared, which goes by what is bright: it tells a roughness, and leaves colour against specularity open.
    #[default]
    Chi2,
    /// Squares relative to the reference, as [`Measures::relmse`] has them: it tells these, and leaves the roughness open.
    Relative,
    /// Squares of logarithms: the one that falls toward an index of refraction from afar.
    Log,
}

impl Loss {
    /// What it is called beside its number.
    pub fn name(self) -> &'static str {
        if self == Self::Chi2 { "chi2" } else { "loss" }
    }

    /// What a value of a rendering adds to it where the reference, whose average is `average`, has `reference`; without what the variance of
    /// that value adds on the average (to the logarithm's square to first order).
    pub fn of(self, reference: f64, value: f64, variance: f64, average: f64) -> f64 {
        let rest = self.rest(reference, value, average);
        let added = match self {
            Self::Chi2 => variance,
            Self::Relative => variance / relative_to(reference, average),
            // E[ln²(v + ε)/r] = ln² v/r + (1 - ln v/r) var ε / v² + …
            Self::Log => (1.0 - rest) * variance / above_nothing(value, average).powi(2),
        };
        rest * rest - added
    }

    /// What it is the square of: by how much the value of a rendering is above the reference, as it reckons that.
    pub fn rest(self, reference: f64, value: f64, average: f64) -> f64 {
        match self {
            Self::Chi2 => value - reference,
            Self::Relative => (value - reference) / relative_to(reference, average).sqrt(),
            Self::Log => (above_nothing(value, average) / above_nothing(reference, average)).ln(),
        }
    }
}

/// A value as logarithms are taken of it, where the average of the reference is this.
fn above_nothing(value: f64, average: f64) -> f64 {
    value.max(0.0) + EPSILON.sqrt() * average
}

/// What a square is relative to where the reference, whose average is `average`, has `reference`.
fn relative_to(reference: f64, average: f64) -> f64 {
    reference * reference + EPSILON * average * average
}

/// Two pictures to be compared. [`Comparison::new`] checks that they can be.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'a> {
    reference: &'a Picture,
    image: &'a Picture,
    /// A second rendering, independent of the first in its noise only: the square of a difference becomes the product of two
    /// differences, whose expectation is free of the noise's variance.
    second: Option<&'a Picture>,
    /// For each pixel how much it counts, 0 to 1.
    weights: Option<&'a [f32]>,
    /// For each value by what its squared difference is divided in chi-squared; values without variance are left out.
    variance: Option<&'a [[f32; 3]]>,
    /// Multiplies the image, and the second.
    scale: f64,
}

/// A picture in radiance, and the name the user knows it by.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// For messages.
    pub name: &'a str,
    /// In radiance ([`Picture::into_radiance`]).
    pub picture: &'a Picture,
}

/// All measures of one comparison. Sums and means are over the red, green and blue of all pixels, each with its weight.
#[derive(Clone, Copy, Debug)]
pub struct Measures {
    /// Σ (A − B)², or Σ (A − B)² / variance; with a second rendering Σ (A − B)(A − C).
    pub chi2: f64,
    /// What chi-squared is on average if the pictures differ by noise of the given variance alone.
    pub degrees_of_freedom: f64,
    /// Values left out of chi-squared because they have no variance.
    pub without_variance: usize,
    /// Mean squared difference; with a second rendering the mean of the products.
    pub mse: f64,
    /// Mean of the squared difference over the square of the reference, to which a hundredth of its mean's square is added.
    pub relmse: f64,
    /// Mean of the difference over the reference (mean absolute percentage error, as a fraction), to which a hundredth of its mean is added.
    pub mape: f64,
    /// The largest difference.
    pub max: f64,
    /// Column, row from the top, and channel of the largest difference.
    pub max_at: (usize, usize, usize),
    /// The largest value of the reference.
    pub peak: f64,
    /// Pixels that count, in full or in part.
    pub pixels: usize,
}

impl Measures {
    /// Root of the mean squared difference.
    pub fn rmse(&self) -> f64 {
        self.mse.sqrt()
    }

    /// Peak signal to noise ratio in decibels: the peak is the reference's largest value. Infinite if there is no difference.
    pub fn psnr(&self) -> f64 {
        if self.mse == 0.0 {
            return f64::INFINITY;
        }
        10.0 * (self.peak * self.peak / self.mse).log10()
    }
}

/// One value of the pictures: a channel of a pixel that counts.
struct Value {
    pixel: usize,
    channel: usize,
    weight: f64,
    a: f64,
    b: f64,
    /// From the second rendering, or `b` again.
    c: f64,
    variance: Option<f64>,
}

impl<'a> Comparison<'a> {
    /// A comparison of pictures of one size, all of whose counted values are finite. Errors name the pictures.
    pub fn new(reference: Named<'a>, image: Named<'a>, second: Option<Named<'a>>, weights: Option<&'a [f32]>) -> Result<Self> {
        for other in std::iter::once(image).chain(second) {
            same_size(reference, other)?;
        }
        if weights.is_some_and(|weights| weights.iter().all(|&w| w <= 0.0)) {
            return Err(Error::new("the mask leaves no pixel to compare"));
        }
        for Named { name, picture } in [reference, image].into_iter().chain(second) {
            let counted = (0..picture.pixels.len()).filter(|&i| weights.is_none_or(|w| w[i] > 0.0));
            if let Some(wrong) = picture.infinite(counted) {
                return Err(Error::new(format!("{name}: the {wrong}; leave such out with a mask")));
            }
        }
        Ok(Self {
            reference: reference.picture,
            image: image.picture,
            second: second.map(|s| s.picture),
            weights,
            variance: None,
            scale: 1.0,
        })
    }

    /// Divides by these variances, one for each value, in chi-squared. Errors if one that counts is negative or not a number.
    pub fn with_variance(self, variance: Named<'a>) -> Result<Self> {
        same_size(Named { name: "the reference", picture: self.reference }, variance)?;
        let compared = Self { variance: Some(&variance.picture.pixels), ..self };
        let wrong = compared.values().find(|value| value.variance.is_some_and(|variance| variance.is_nan() || variance < 0.0));
        wrong.map_or(Ok(compared), |Value { pixel, .. }| {
            let at = place(pixel, variance.picture.width);
            Err(Error::new(format!("{}: the variance in {at} is negative or not a number; leave such out with a mask", variance.name)))
        })
    }

    /// Scales the image so that chi-squared is least, and gives the factor.
    pub fn fit_exposure(self) -> Result<(Self, f64)> {
        // The least of Σ w (a − s b)(a − s c), by its derivative: s = Σ w a (b + c) / 2 Σ w b c.
        let (mut with_reference, mut with_itself) = (0.0, 0.0);
        for v in self.values() {
            let weight = v.weight / v.variance.unwrap_or(1.0);
            if weight.is_finite() {
                with_reference += weight * v.a * (v.b + v.c) / 2.0;
                with_itself += weight * v.b * v.c;
            }
        }
        let factor = with_reference / with_itself;
        if !(factor.is_finite() && factor > 0.0) {
            return Err(Error::new("no exposure fits: the second picture is black, or nothing like the first"));
        }
        Ok((Self { scale: self.scale * factor, ..self }, factor))
    }

    /// All measures.
    pub fn measure(&self) -> Measures {
        let mut m = Measures {
            chi2: 0.0,
            degrees_of_freedom: 0.0,
            without_variance: 0,
            mse: 0.0,
            relmse: 0.0,
            mape: 0.0,
            max: 0.0,
            max_at: (0, 0, 0),
            peak: 0.0,
            pixels: self.weights.map_or(self.reference.pixels.len(), |w| w.iter().filter(|&&w| w > 0.0).count()),
        };
        let (mut weights, mut sum) = (0.0, 0.0);
        for v in self.values() {
            weights += v.weight;
            sum += v.weight * v.a;
        }
        let average = sum / weights;
        for v in self.values() {
            let (difference, square) = ((v.a - v.b).abs(), (v.a - v.b) * (v.a - v.c));
            match v.variance {
                None => m.chi2 += v.weight * square,
                Some(variance) if variance > 0.0 && variance.is_finite() => {
                    m.chi2 += v.weight * square / variance;
                    m.degrees_of_freedom += v.weight;
                }
                Some(_) => m.without_variance += 1,
            }
            m.mse += v.weight * square;
            if average > 0.0 {
                m.relmse += v.weight * square / relative_to(v.a, average);
                m.mape += v.weight * difference / (v.a.abs() + EPSILON * average);
            } else if difference > 0.0 {
                // Where all is black anything is infinitely more.
                (m.relmse, m.mape) = (f64::INFINITY, f64::INFINITY);
            }
            m.peak = m.peak.max(v.a);
            if difference > m.max {
                m.max = difference;
                m.max_at = (v.pixel % self.reference.width, v.pixel / self.reference.width, v.channel);
            }
        }
        for mean in [&mut m.mse, &mut m.relmse, &mut m.mape] {
            *mean /= weights;
        }
        m
    }

    /// Every value that counts, in the order of the pictures.
    fn values(&self) -> impl Iterator<Item = Value> {
        let counted = (0..self.reference.pixels.len()).filter_map(|pixel| {
            let weight = self.weights.map_or(1.0, |w| f64::from(w[pixel]));
            (weight > 0.0).then_some((pixel, weight))
        });
        counted.flat_map(move |(pixel, weight)| {
            (0..3).map(move |channel| {
                let b = self.scale * f64::from(self.image.pixels[pixel][channel]);
                Value {
                    pixel,
                    channel,
                    weight,
                    a: f64::from(self.reference.pixels[pixel][channel]),
                    b,
                    c: self.second.map_or(b, |second| self.scale * f64::from(second.pixels[pixel][channel])),
                    variance: self.variance.map(|variance| f64::from(variance[pixel][channel])),
                }
            })
        })
    }
}

/// How much each pixel counts by a mask: 1 or more wholly, 0 or less not at all, what is between in part. Grey is expected; of
/// colours the largest channel counts. Errors if the mask is not as large as the picture, or not finite.
pub fn weights(mask: Named, picture: Named) -> Result<Vec<f32>> {
    same_size(picture, mask)?;
    let weight = |pixel: &[f32; 3]| pixel.iter().fold(0f32, |w, &v| w.max(v)).min(1.0);
    if mask.picture.pixels.iter().flatten().any(|v| !v.is_finite()) {
        return Err(Error::new(format!("{}: a mask must be finite everywhere", mask.name)));
    }
    Ok(mask.picture.pixels.iter().map(weight).collect())
}

fn same_size(a: Named, b: Named) -> Result<()> {
    let size = |p: &Picture| (p.width, p.height);
    if size(a.picture) == size(b.picture) {
        return Ok(());
    }
    let shown = |n: Named| format!("{} is {} × {} pixels", n.name, n.picture.width, n.picture.height);
    Err(Error::new(format!(
        "{}, {}; they must be the same (pfilt -x {} -y {} -p 1 changes the size)",
        shown(a),
        shown(b),
        a.picture.width,
        a.picture.height
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Header;

    fn picture(pixels: &[[f32; 3]]) -> Picture {
        Picture { width: pixels.len(), height: 1, header: Header::default(), pixels: pixels.to_vec() }
    }

    fn named(picture: &Picture) -> Named<'_> {
        Named { name: "a.hdr", picture }
    }

    /// Sines that look like noise: equal on average to nothing, variance ½, the same in every run.
    fn noise(i: usize) -> f32 {
        ((i * i % 100_003) as f32 * 12.9898).sin()
    }

    #[test]
    fn chi_squared_is_the_sum_of_squares() {
        let (a, b) = (picture(&[[1.0, 2.0, 3.0], [0.0, 0.0, 4.0]]), picture(&[[1.5, 2.0, 1.0], [0.0, 1.0, 4.0]]));
        let m = Comparison::new(named(&a), named(&b), None, None).unwrap().measure();
        assert_eq!((m.chi2, m.mse, m.max, m.max_at, m.peak, m.pixels), (0.25 + 4.0 + 1.0, 5.25 / 6.0, 2.0, (0, 0, 2), 4.0, 2));
        assert_eq!((m.rmse(), m.psnr()), ((5.25f64 / 6.0).sqrt(), 10.0 * (16.0 * 6.0 / 5.25f64).log10()));
        let black = picture(&[[0.0; 3]]);
        assert_eq!(Comparison::new(named(&black), named(&black), None, None).unwrap().measure().psnr(), f64::INFINITY);
        let relative = |b: &Picture| {
            let m = Comparison::new(named(&black), named(b), None, None).unwrap().measure();
            [m.relmse, m.mape]
        };
        assert_eq!((relative(&black), relative(&picture(&[[1.0; 3]]))), ([0.0; 2], [f64::INFINITY; 2]));
    }

    #[test]
    fn losses_are_free_of_what_noise_adds() {
        let (a, b) = (picture(&[[1.0, 2.0, 3.0], [0.0, 8.0, 4.0]]), picture(&[[2.0, 2.0, 2.0], [1.0, 8.0, 4.0]]));
        let m = Comparison::new(named(&a), named(&b), None, None).unwrap().measure();
        let values = || a.pixels.iter().flatten().zip(b.pixels.iter().flatten()).map(|(a, b)| [*a, *b].map(f64::from));
        let sum = |loss: Loss| values().map(|[a, b]| loss.of(a, b, 0.0, 3.0)).sum::<f64>();
        assert!((sum(Loss::Chi2) - m.chi2).abs() < 1e-14 && (sum(Loss::Relative) - 6.0 * m.relmse).abs() < 1e-13);
        assert!((Loss::Log.of(2.7, 5.7, 0.0, 3.0) - 2f64.ln().powi(2)).abs() < 1e-14);
        // A value of variance .02.
        for loss in [Loss::Chi2, Loss::Relative, Loss::Log] {
            let noisy: f64 = (0..100_000).map(|i| loss.of(3.0, 4.0 + 0.2 * f64::from(noise(i)), 0.02, 3.0)).sum();
            let clean = loss.of(3.0, 4.0, 0.0, 3.0);
            assert!((noisy / 1e5 / clean - 1.0).abs() < 0.01, "{loss:?}: {} {clean}", noisy / 1e5);
        }
        // However far the logarithm is off.
        for reference in [0.5, 4.0, 32.0] {
            let [low, clean, high] =
                [(3.98, 0.0004), (4.0, 0.0), (4.02, 0.0004)].map(|(v, variance)| Loss::Log.of(reference, v, variance, 1e-9));
            assert!((0.5 * (low + high) - clean).abs() < 0.01 * 0.0004 / 16.0, "{reference}: {low} {clean} {high}");
        }
    }

    #[test]
    fn relative_measures_do_not_depend_on_the_unit() {
        let (a, b) = (picture(&[[1.0, 2.0, 3.0], [0.0, 8.0, 4.0]]), picture(&[[2.0, 2.0, 2.0], [1.0, 8.0, 4.0]]));
        let m = Comparison::new(named(&a), named(&b), None, None).unwrap().measure();
        // The average of the reference is 3.
        let relmse = 1.0 / 1.09 + 1.0 / 9.09 + 1.0 / 0.09;
        let mape = 1.0 / 1.03 + 1.0 / 3.03 + 1.0 / 0.03;
        assert!((m.relmse - relmse / 6.0).abs() < 1e-14 && (m.mape - mape / 6.0).abs() < 1e-14);
        let scaled = |p: &Picture| picture(&p.pixels.iter().map(|c| c.map(|v| v * 1024.0)).collect::<Vec<_>>());
        let (a, b) = (scaled(&a), scaled(&b));
        let large = Comparison::new(named(&a), named(&b), None, None).unwrap().measure();
        assert!((large.relmse - m.relmse).abs() < 1e-14 && (large.mape - m.mape).abs() < 1e-14);
    }

    #[test]
    fn a_second_rendering_takes_the_noise_out() {
        let n = 30_000;
        let a = picture(&vec![[1.0; 3]; n]);
        let noisy = |first: usize| picture(&(0..n).map(|i| std::array::from_fn(|c| 1.5 + noise(first + 3 * i + c))).collect::<Vec<_>>());
        let (b, c) = (noisy(0), noisy(1_000_000));
        let biased = Comparison::new(named(&a), named(&b), None, None).unwrap().measure().mse;
        let unbiased = Comparison::new(named(&a), named(&b), Some(named(&c)), None).unwrap().measure().mse;
        // The true squared difference is ¼, the variance ½; the bounds are four standard errors.
        assert!((biased - 0.75).abs() < 0.01 && (unbiased - 0.25).abs() < 0.01, "{biased} {unbiased}");
    }

    #[test]
    fn divided_by_its_variance_noise_gives_as_much_as_its_degrees_of_freedom() {
        let n = 10_000;
        let a = picture(&vec![[1.0; 3]; n]);
        let mut b = picture(&(0..n).map(|i| std::array::from_fn(|c| 1.0 + noise(3 * i + c))).collect::<Vec<_>>());
        let mut variance = picture(&vec![[0.5; 3]; n]);
        variance.pixels[7] = [0.0; 3];
        variance.pixels[8] = [f32::INFINITY; 3];
        b.pixels[7] = [1e6; 3];
        let m = Comparison::new(named(&a), named(&b), None, None).unwrap().with_variance(named(&variance)).unwrap().measure();
        assert_eq!((m.degrees_of_freedom, m.without_variance), (29_994.0, 6));
        assert!((m.chi2 / m.degrees_of_freedom - 1.0).abs() < 0.02, "{}", m.chi2 / m.degrees_of_freedom);
        variance.pixels[3][1] = f32::NAN;
        assert!(Comparison::new(named(&a), named(&b), None, None).unwrap().with_variance(named(&variance)).is_err());
        // What is masked may be anything.
        let weights: Vec<f32> = (0..n).map(|i| if i == 3 { 0.0 } else { 1.0 }).collect();
        assert!(Comparison::new(named(&a), named(&b), None, Some(&weights)).unwrap().with_variance(named(&variance)).is_ok());
    }

    #[test]
    fn the_fitted_exposure_is_the_least_of_chi_squared() {
        let (a, b) = (picture(&[[1.0, 2.0, 3.0], [0.0, 8.0, 4.0]]), picture(&[[2.0, 5.0, 5.0], [0.5, 15.0, 9.0]]));
        let comparison = Comparison::new(named(&a), named(&b), None, None).unwrap();
        let (fitted, factor) = comparison.fit_exposure().unwrap();
        let chi2 = |scale: f64| Comparison { scale, ..comparison }.measure().chi2;
        assert_eq!(fitted.measure().chi2, chi2(factor));
        assert!(chi2(factor) < chi2(factor * 1.001) && chi2(factor) < chi2(factor * 0.999));
        let (_, one) = Comparison::new(named(&a), named(&a), None, None).unwrap().fit_exposure().unwrap();
        assert_eq!(one, 1.0);
        let black = picture(&[[0.0; 3]; 2]);
        assert!(Comparison::new(named(&a), named(&black), None, None).unwrap().fit_exposure().is_err());
    }

    #[test]
    fn a_mask_counts_pixels_in_full_in_part_or_not_at_all() {
        let (a, b) = (picture(&[[0.0; 3]; 4]), picture(&[[1.0; 3], [2.0; 3], [3.0; 3], [f32::NAN; 3]]));
        let mask = picture(&[[255.0; 3], [0.5, 0.5, 0.5], [0.0; 3], [-1.0; 3]]);
        let weights = weights(named(&mask), named(&a)).unwrap();
        assert_eq!(weights, [1.0, 0.5, 0.0, 0.0]);
        let m = Comparison::new(named(&a), named(&b), None, Some(&weights)).unwrap().measure();
        assert_eq!((m.chi2, m.mse, m.pixels), (3.0 + 6.0, 9.0 / 4.5, 2));
        assert!(Comparison::new(named(&a), named(&b), None, Some(&[0.0; 4])).is_err());
    }

    #[test]
    fn what_cannot_be_compared_is_said() {
        let (a, b) = (picture(&[[0.0; 3]; 4]), picture(&[[1.0; 3], [f32::NAN; 3], [3.0; 3], [f32::INFINITY; 3]]));
        let message = Comparison::new(named(&a), named(&b), None, None).unwrap_err().message;
        assert!(
            message.starts_with("a.hdr: the pixel in column 1 and row 0") && message.contains("and 1 more are not finite"),
            "{message}"
        );
        let short = picture(&[[0.0; 3]; 3]);
        let message = Comparison::new(named(&a), named(&short), None, None).unwrap_err().message;
        assert!(message.starts_with("a.hdr is 4 × 1 pixels, a.hdr is 3 × 1 pixels"), "{message}");
    }
}
