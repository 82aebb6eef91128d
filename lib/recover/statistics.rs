//! How much each pixel can be trusted, and how much the values that were fitted to them.

use super::Evidence;
use crate::anneal::linear::Symmetric;
use crate::transport::Basis;

/// Three numbers for each pixel that counts.
pub type Channels = Vec<[f32; 3]>;

/// The pixels that count, where they lie, and what was photographed there.
pub struct Sheet<'a> {
    evidence: &'a Evidence<'a>,
    /// Their numbers on the film.
    pub numbers: &'a [usize],
    /// The target's values there.
    pub target: Channels,
    /// The place in `numbers` of each pixel of the film.
    places: Vec<u32>,
    /// The mean of the target's values.
    pub level: f64,
}

impl<'a> Sheet<'a> {
    /// The sheet of some pixels.
    pub fn new(evidence: &'a Evidence<'a>, numbers: &'a [usize]) -> Self {
        let target: Channels = numbers.iter().map(|&n| evidence.target.pixels[n]).collect();
        let level = target.iter().flatten().map(|&v| v as f64).sum::<f64>() / (3 * target.len()) as f64;
        let mut places = vec![u32::MAX; evidence.film.width * evidence.film.height];
        numbers.iter().enumerate().for_each(|(i, &n)| places[n] = i as u32);
        Self { evidence, numbers, target, places, level }
    }

    /// For each pixel, the mean of `values` over the pixels at most `reach` away that count.
    fn blurred(&self, values: &[[f64; 3]], reach: isize) -> Vec<[f64; 3]> {
        let (width, height) = (self.evidence.film.width as isize, self.evidence.film.height as isize);
        let mean = |&n: &usize| {
            let (x, y) = (n as isize % width, n as isize / width);
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for v in (y - reach).max(0)..=(y + reach).min(height - 1) {
                for u in (x - reach).max(0)..=(x + reach).min(width - 1) {
                    let place = self.places[(v * width + u) as usize];
                    if place != u32::MAX {
                        (0..3).for_each(|c| sum[c] += values[place as usize][c]);
                        count += 1.0;
                    }
                }
            }
            sum.map(|s| s / count)
        };
        self.numbers.iter().map(mean).collect()
    }

    fn masked(&self, i: usize, weight: [f64; 3]) -> [f32; 3] {
        let counts = self.evidence.mask.map_or(1.0, |mask| mask[self.numbers[i]] as f64);
        weight.map(|w| (w * counts) as f32)
    }

    /// Weights that make errors relative, from the target blurred: what a first look can go by.
    pub fn relative(&self) -> Channels {
        let target: Vec<[f64; 3]> = self.target.iter().map(|t| t.map(f64::from)).collect();
        let floor = 0.1 * self.level;
        self.blurred(&target, 2).into_iter().enumerate().map(|(i, t)| self.masked(i, t.map(|v| (v + floor).powi(-2)))).collect()
    }

    /// The variance of one sample of each pixel, with what its neighbours say of it. `halves` are two independent estimates, of `samples`
    /// samples each. Glints make it differ by orders of magnitude from pixel to pixel, so the pixel itself must have a say in it.
    pub fn variance(&self, halves: &[Vec<[f64; 3]>], samples: &[u32]) -> Vec<[f64; 3]> {
        let own = |(i, &n): (usize, &u32)| std::array::from_fn(|c| 0.5 * (halves[0][i][c] - halves[1][i][c]).powi(2) * n as f64);
        self.blurred(&samples.iter().enumerate().map(own).collect::<Vec<_>>(), 1)
    }

    /// Weights that go by the variance of a sample.
    pub fn by_variance(&self, halves: &[Vec<[f64; 3]>], variance: &[[f64; 3]]) -> Channels {
        let mean: Vec<[f64; 3]> = halves[0].iter().zip(&halves[1]).map(|(a, b)| std::array::from_fn(|c| 0.5 * (a[c] + b[c]))).collect();
        let mean = self.blurred(&mean, 2);
        let floor = (0.01 * self.level).powi(2);
        (0..self.numbers.len())
            .map(|i| self.masked(i, std::array::from_fn(|c| 1.0 / (variance[i][c] / TARGET_SAMPLES + (0.02 * mean[i][c]).powi(2) + floor))))
            .collect()
    }
}

/// How many samples a pixel of the target is taken to hold: what a photograph lacks in noise it has in misfit.
const TARGET_SAMPLES: f64 = 12.0;

/// The picture that each set of a basis makes of the coefficients `x`.
pub fn pictures(basis: &Basis, x: &[Vec<f64>; 3]) -> Vec<Vec<[f64; 3]>> {
    let n = basis.columns;
    let pixels = basis.values.len() / (basis.sets * 3 * n);
    let value = |columns: &[f32], c: usize| x[c].iter().zip(&columns[c * n..]).map(|(x, v)| x * *v as f64).sum::<f64>();
    (0..basis.sets).map(|set| (0..pixels).map(|p| std::array::from_fn(|c| value(basis.pixel(p, set), c))).collect()).collect()
}

/// How further samples are best shared among the pixels (Neyman 1934): in proportion to what the error of a sample does to the values, each
/// measured by its own error. `inverse` is that of Gauss and Newton's matrix; the mean share is 1.
pub fn shares(inverse: &Symmetric, errors: &[f64], weights: &Channels, variance: &[[f64; 3]], derivatives: &[Vec<[f64; 3]>]) -> Vec<f64> {
    let n = inverse.size();
    let spread = |p: usize| -> f64 {
        let moved =
            |i: usize, c: usize| (0..n).map(|j| inverse.at(i, j) * derivatives[j][p][c]).sum::<f64>() * weights[p][c] as f64 / errors[i];
        (0..3).map(|c| variance[p][c] * (0..n).map(|i| moved(i, c).powi(2)).sum::<f64>()).sum::<f64>().sqrt()
    };
    let spreads: Vec<f64> = (0..weights.len()).map(spread).collect();
    let mean = spreads.iter().sum::<f64>() / spreads.len() as f64;
    spreads.iter().map(|s| if mean > 0.0 { s / mean } else { 1.0 }).collect()
}

/// Covariances of fitted values: by all that makes the residuals, and by the noise of the rendering alone.
///
/// The sandwich form (White 1980): `matrix` is Gauss and Newton's, the scores are summed per pixel over the channels, whose errors go together.
/// `derivatives` are the pictures' derivatives by each parameter.
pub fn covariances(
    matrix: &Symmetric,
    target: &Channels,
    weights: &Channels,
    pictures: &[Vec<[f64; 3]>],
    derivatives: &[Vec<[f64; 3]>],
) -> Option<(Symmetric, Symmetric)> {
    let inverse = matrix.inverse()?;
    let (n, sets) = (matrix.size(), pictures.len() as f64);
    let (mut all, mut own) = (Symmetric::diagonal(&vec![0.0; n]), Symmetric::diagonal(&vec![0.0; n]));
    let add = |sum: &mut Symmetric, score: &[f64], factor: f64| {
        for i in 0..n {
            for j in 0..=i {
                sum.set(i, j, sum.at(i, j) + score[i] * score[j] * factor);
            }
        }
    };
    for p in 0..target.len() {
        let mean: [f64; 3] = std::array::from_fn(|c| pictures.iter().map(|s| s[p][c]).sum::<f64>() / sets);
        let score = |residual: [f64; 3]| -> Vec<f64> {
            derivatives.iter().map(|d| (0..3).map(|c| weights[p][c] as f64 * residual[c] * d[p][c]).sum()).collect()
        };
        add(&mut all, &score(std::array::from_fn(|c| target[p][c] as f64 - mean[c])), 1.0);
        for picture in pictures {
            add(&mut own, &score(std::array::from_fn(|c| picture[p][c] - mean[c])), 1.0 / (sets * (sets - 1.0)));
        }
    }
    let wrap = |middle: Symmetric| {
        Symmetric::of(n, |i, j| (0..n).map(|a| (0..n).map(|b| inverse.at(i, a) * middle.at(a, b) * inverse.at(b, j)).sum::<f64>()).sum())
    };
    Some((wrap(all), wrap(own)))
}
