//! Candidates judged by rendering each anew.

use super::Photo;
use crate::anneal::Parameter;
use crate::anneal::linear::Symmetric;
use crate::cli::search::Objective;
use crate::color::Rgb;
use crate::error::Result;
use crate::metric::Loss;

/// How far to either side derivatives are taken over, in terms of a parameter's range.
const STEP: f64 = 0.01;

/// Renders the pixels that count anew for every candidate.
pub struct Direct<'p, 'a> {
    photo: &'p Photo<'a>,
    pixels: Vec<usize>,
    /// The picture's average over them.
    average: f64,
    loss: Loss,
}

impl<'p, 'a> Direct<'p, 'a> {
    /// Over the pixels that show the unknown, or enough of them.
    pub fn new(photo: &'p Photo<'a>, loss: Loss) -> Result<Self> {
        let pixels = photo.evidence().telling_pixels(&photo.unknown, photo.material)?;
        let sum: f64 = pixels.iter().flat_map(|&number| photo.shot.target.pixels[number]).map(f64::from).sum();
        let average = sum / (3 * pixels.len()) as f64;
        Ok(Self { photo, pixels, average, loss })
    }

    /// What `of` makes of each channel of each pixel of a rendering with these values: of how much the pixel counts, of what it is in the picture and in
    /// the rendering, and of the variance of that.
    fn compared(&self, values: &[f64], seed: u64, of: impl Fn(f64, f64, f64, f64) -> f64) -> Result<Vec<f64>> {
        let photo = self.photo;
        let exposure = Rgb::from(photo.unknown.exposures(values));
        let world = photo.setting().world(&photo.unknown.reals(values))?;
        let rendering = photo.evidence().rendered(&world, &self.pixels, seed);
        let each = rendering.pixels.iter().zip(&self.pixels).flat_map(|(pixel, &number)| {
            let (target, seen) = (photo.shot.target.pixels[number], exposure * pixel.mean());
            let variance = exposure * exposure * pixel.variance().0;
            let weight = photo.shot.mask.as_ref().map_or(1.0, |mask| mask[number] as f64);
            std::array::from_fn::<f64, 3, _>(|c| of(weight, target[c] as f64, seen[c], variance[c]))
        });
        Ok(each.collect())
    }

    /// How far a rendering with these values is from the picture.
    fn judged(&self, values: &[f64], loss: Loss) -> Result<f64> {
        let each = self
            .compared(values, self.photo.seed, |weight, target, seen, variance| weight * loss.of(target, seen, variance, self.average))?;
        Ok(each.iter().sum())
    }

    /// What the squares are of, whose sum it makes small.
    fn rests(&self, values: &[f64], seed: u64) -> Result<Vec<f64>> {
        self.compared(values, seed, |weight, target, seen, _| weight.sqrt() * self.loss.rest(target, seen, self.average))
    }

    /// How they change with each value.
    fn derivatives(&self, values: &[f64], seed: u64) -> Result<Vec<Vec<f64>>> {
        let parameters = self.photo.unknown.parameters().iter().enumerate();
        let derivative = |(i, parameter): (usize, &Parameter)| {
            let at = |value: f64| self.rests(&[&values[..i], &[value], &values[i + 1..]].concat(), seed);
            let step = STEP * parameter.range();
            let (low, high) = ((values[i] - step).max(parameter.low), (values[i] + step).min(parameter.high));
            Ok(at(high)?.iter().zip(at(low)?).map(|(above, below)| (above - below) / (high - low)).collect())
        };
        parameters.map(derivative).collect()
    }
}

impl Objective for Direct<'_, '_> {
    fn indifferent(&self) -> &'static str {
        "does the picture show anything of it?"
    }

    fn chi2(&mut self, values: &[f64], _: usize) -> Result<f64> {
        self.judged(values, self.loss)
    }

    fn told(&self, values: &[f64]) -> Result<Option<f64>> {
        (self.loss != Loss::Chi2).then(|| self.judged(values, Loss::Chi2)).transpose()
    }

    /// By the residuals of the pixels, which hold the noise of the picture and that of the renderings, the same in all (White 1980; the bounds
    /// say what the pixels do not). What renderings of other noise do not confirm of a derivative tells nothing; and where they lead to, the values
    /// may as well be.
    fn covariance(&self, values: &[f64]) -> Result<Option<Symmetric>> {
        let (parameters, seed) = (self.photo.unknown.parameters(), self.photo.seed);
        let [rests, other_rests] = [self.rests(values, seed)?, self.rests(values, !seed)?];
        let [slopes, other_slopes] = [self.derivatives(values, seed)?, self.derivatives(values, !seed)?];
        let square = rests.iter().map(|rest| rest * rest).sum::<f64>() / rests.len() as f64;
        let prior = |i: usize, j: usize| if i == j { square / parameters[i].anywhere().powi(2) } else { 0.0 };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let n = parameters.len();
        let pulls: Vec<Vec<f64>> = slopes.iter().map(|slope| slope.iter().zip(&rests).map(|(a, b)| a * b).collect()).collect();
        let squares = Symmetric::of(n, |i, j| square * prior(i, j) + dot(&pulls[i], &pulls[j]));
        let crossed = |i: usize, j: usize| 0.5 * (dot(&slopes[i], &other_slopes[j]) + dot(&other_slopes[i], &slopes[j]));
        let known = |inverse: Symmetric| {
            let scores: Vec<f64> = (0..n).map(|i| 0.5 * (dot(&slopes[i], &other_rests) + dot(&other_slopes[i], &rests))).collect();
            let (errors, way) = (inverse.around(&squares), inverse.times(&scores));
            Symmetric::of(n, |i, j| errors.at(i, j) + way[i] * way[j])
        };
        let nothing = || Symmetric::diagonal(&parameters.iter().map(|p| p.anywhere().powi(2)).collect::<Vec<_>>());
        Ok(Some(Symmetric::of(n, |i, j| prior(i, j) + crossed(i, j)).inverse().map_or_else(nothing, known)))
    }
}
