//! How sure the values are: what errors of pixels, of all of them, and of what they have in common, do to them.

use super::{Scores, add_square, times, total};
use crate::anneal::linear::Symmetric;
use crate::recover::misfit::Misfit;
use crate::recover::sheet::{Alike, COMMON, mean, weight};
use rayon::prelude::*;

/// The most of a pixel's error that values are taken to follow.
const MOST_LEVERAGE: f64 = 0.95;
/// As many areas lie beside each other, and below each other, in what is seen of the unknown.
const AREAS: usize = 8;

impl Scores<'_> {
    /// Covariances of the values: by all that makes the residuals and by the rounding of the target, and by the noise of the rendering alone.
    ///
    /// The sandwich form (White 1980), the scores summed per pixel over the channels, whose errors go together. What is held back has a score but no
    /// slope (Huber 1981, section 3.2). Residuals that the values follow are smaller than errors (MacKinnon and White 1985, HC2); where values go by one
    /// pixel nothing is left of its error, and by as much as they follow it, its error is also taken for what those of others are in terms of their weights.
    pub(super) fn covariances(&self, inverse: &[Vec<f64>], bounds: &[(f64, f64)]) -> (Symmetric, Symmetric) {
        let n = self.here.derivatives.len();
        let usual = self.usual();
        let sums = total(self.pixels(), 2 * n * n, &|p, sums| {
            let (all, own) = sums.split_at_mut(n * n);
            let followed = self.leverage(inverse, p).clamp(0.0, MOST_LEVERAGE);
            let larger = (1.0 - followed).sqrt().recip();
            add_square(all, &self.pull(inverse, p).iter().map(|pull| larger * pull).collect::<Vec<_>>());
            add_square(all, &self.foreseen(inverse, p).iter().map(|pull| (followed * usual).sqrt() * pull).collect::<Vec<_>>());
            for half in 0..2 {
                let noise = |c: usize| {
                    0.5 * 0.5f64.sqrt() * (self.here.halves[0][p][c] - self.here.halves[1][p][c]) * self.weights.halves[half][p][c] as f64
                };
                let score = |i: usize| self.trust[i][p] * (0..3).map(|c| noise(c) * self.here.derivatives[i][half][p][c]).sum::<f64>();
                add_square(own, &times(inverse, &(0..n).map(score).collect::<Vec<_>>()));
            }
        });
        let (mut all, own) = (sums[..n * n].to_vec(), &sums[n * n..]);
        // Residuals tell of the rounding of each value, but not that it is the same where the value is.
        for alike in self.weights.rounded.iter() {
            add_square(&mut all, &self.rounded(inverse, alike));
        }
        // What as many steps again would do is not known either; what the pixels leave open, the bounds still tell.
        self.step_within(bounds).iter().for_each(|step| add_square(&mut all, step));
        for i in 0..n {
            let known: Vec<f64> = (0..n).map(|j| if i == j { self.prior[i].sqrt() } else { 0.0 }).collect();
            add_square(&mut all, &times(inverse, &known));
        }
        (Symmetric::of(n, |i, j| all[i * n + j]), Symmetric::of(n, |i, j| own[i * n + j]))
    }

    /// The square of a channel's error in terms of its weight, on the average.
    fn usual(&self) -> f64 {
        let square = |p: usize| (0..3).map(|c| weight(&self.weights.halves, p, c) * self.sheet.cross(&self.here.halves, p, c)).sum::<f64>();
        total(self.pixels(), 1, &|p, sum| sum[0] += square(p))[0].max(0.0) / (3 * self.pixels().max(1)) as f64
    }

    /// How far an error of one over the root of its weight in each channel of a pixel moves the values.
    fn foreseen(&self, inverse: &[Vec<f64>], p: usize) -> Vec<f64> {
        let of_channel =
            |i: usize, c: usize| (weight(&self.weights.halves, p, c) * self.weights.kept[p] as f64).sqrt() * self.instrument(i, p, c);
        times(inverse, &(0..inverse.len()).map(|i| (0..3).map(|c| of_channel(i, c)).sum()).collect::<Vec<_>>())
    }

    /// Which part of a pixel's error the values follow: near 1 where they were found by that pixel alone.
    fn leverage(&self, inverse: &[Vec<f64>], p: usize) -> f64 {
        let d = &self.here.derivatives;
        let followed = |c: usize, half: usize| -> f64 {
            let asked = |i: usize| self.trust[i][p] * d[i][half][p][c];
            let moved = |row: &[f64]| row.iter().enumerate().map(|(i, inverse)| inverse * asked(i)).sum::<f64>();
            self.weights.halves[half][p][c] as f64 * inverse.iter().zip(d).map(|(row, d)| d[1 - half][p][c] * moved(row)).sum::<f64>()
        };
        (0..3).map(|c| 0.5 * (followed(c, 0) + followed(c, 1))).sum()
    }

    /// How far the rounding of what is rounded alike moves the values of the parameters.
    fn rounded(&self, inverse: &[Vec<f64>], alike: &Alike) -> Vec<f64> {
        let mut scores = vec![0.0; inverse.len()];
        for &(p, c, error) in alike.iter().filter(|value| self.weights.kept[value.0] == 1.0) {
            let error = error as f64 * weight(&self.weights.halves, p, c);
            scores.iter_mut().enumerate().for_each(|(i, score)| *score += error * self.instrument(i, p, c));
        }
        times(inverse, &scores)
    }

    /// What asks for a parameter at a channel of a pixel.
    fn instrument(&self, i: usize, p: usize, c: usize) -> f64 {
        self.trust[i][p] * mean(&self.here.derivatives[i], p, c)
    }

    /// What an error of the picture that is as large a part of each value as [`COMMON`] does to the values, where its signs do most harm:
    /// its size on the diagonal, and beside it how what it does to two values goes together. Of a picture that is explained but for noise, it has one
    /// sign in each of [`AREAS`]² areas; of another, in each pixel.
    ///
    /// Standard errors take the errors of pixels for independent, so that thousands of pixels can tell a value by changes of a thousandth.
    /// Those of a shape, of a measured light, of the formula of a lobe are not, and no number of pixels averages them out.
    pub fn common(&self, misfit: &Misfit) -> Symmetric {
        let value = |p: usize, c: usize| mean(&self.here.halves, p, c).abs();
        let error = |p: usize, c: usize| COMMON * value(p, c) * weight(&self.weights.halves, p, c);
        let (squares, sizes) = if misfit.is_noise() { self.moved_by_areas(error) } else { self.moved(error) };
        let correlations = squares.correlations();
        // What does not move goes together with nothing.
        let together = |i: usize, j: usize| if sizes[i] * sizes[j] > 0.0 { sizes[i] * sizes[j] * correlations.at(i, j) } else { 0.0 };
        Symmetric::of(sizes.len(), |i, j| if i == j { sizes[i].powi(2) } else { together(i, j) })
    }

    /// The covariance of the values where a filter has spread the photograph's noise over neighbouring pixels: pixels at the distance d then have
    /// the correlation exp(−d²/4`variance`), and what they do to a value together is more than if they were independent, or less.
    /// The rendering's noise is not spread.
    pub fn spread(&self, variance: f64) -> Symmetric {
        let n = self.here.derivatives.len();
        let Some(inverse) = &self.inverse else { return self.covariance.clone() };
        let moved = |p: usize, c: usize| self.pulled(inverse, p, c, weight(&self.weights.halves, p, c).sqrt());
        let all: Vec<[Vec<f64>; 3]> = (0..self.pixels()).into_par_iter().map(|p| std::array::from_fn(|c| moved(p, c))).collect();
        let factor = |i: usize| {
            let field: Vec<[f64; 3]> = all.iter().map(|moved| std::array::from_fn(|c| moved[c][i])).collect();
            let product = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
            let [alone, together] =
                [&field, &self.sheet.correlated(&field, variance)].map(|other| field.iter().zip(other).map(product).sum::<f64>());
            let photographed = (1.0 - self.own.at(i, i) / self.covariance.at(i, i)).max(0.0);
            if alone > 0.0 && photographed > 0.0 { (1.0 + photographed * (together / alone - 1.0)).sqrt() } else { 1.0 }
        };
        let factors: Vec<f64> = (0..n).map(factor).collect();
        Symmetric::of(n, |i, j| factors[i] * factors[j] * self.covariance.at(i, j))
    }

    /// The covariance of the values that is to be expected of a picture whose noise is what the weights say.
    pub fn expected(&self) -> Symmetric {
        let mut all = self.moved(|p, c| weight(&self.weights.halves, p, c).sqrt()).0;
        if let Some(inverse) = &self.inverse {
            let known = |i: usize, j: usize| (0..self.prior.len()).map(|k| inverse[i][k] * inverse[j][k] * self.prior[k]).sum::<f64>();
            all = Symmetric::of(all.size(), |i, j| all.at(i, j) + known(i, j));
        }
        all
    }

    /// How much a pixel tells of each value: the square of what its noise does to it, if that is what the weights say.
    pub(super) fn tells(&self, inverse: &[Vec<f64>], p: usize) -> Vec<f64> {
        let mut squares = vec![0.0; inverse.len()];
        for c in 0..3 {
            let moved = self.pulled(inverse, p, c, weight(&self.weights.halves, p, c).sqrt());
            squares.iter_mut().zip(moved).for_each(|(square, moved)| *square += moved * moved);
        }
        squares
    }

    /// What an error of that weight in a channel of a pixel does to the values.
    fn pulled(&self, inverse: &[Vec<f64>], p: usize, c: usize, error: f64) -> Vec<f64> {
        times(inverse, &(0..self.prior.len()).map(|j| self.instrument(j, p, c) * error).collect::<Vec<_>>())
    }

    /// What errors of that weight in each pixel and channel do to the values: the sum of their products, and of their sizes. What is held back
    /// they do not move.
    fn moved(&self, error: impl Fn(usize, usize) -> f64 + Sync) -> (Symmetric, Vec<f64>) {
        let n = self.here.derivatives.len();
        let Some(inverse) = &self.inverse else { return (Symmetric::diagonal(&vec![f64::INFINITY; n]), vec![f64::INFINITY; n]) };
        let sums = total(self.pixels(), n + n * n, &|p, sums| {
            if self.weights.kept[p] == 1.0 {
                (0..3).for_each(|c| add(sums, &self.pulled(inverse, p, c, error(p, c))));
            }
        });
        summed(n, &sums)
    }

    /// The same of errors that have one sign in each area.
    fn moved_by_areas(&self, error: impl Fn(usize, usize) -> f64 + Sync) -> (Symmetric, Vec<f64>) {
        let n = self.here.derivatives.len();
        let Some(inverse) = &self.inverse else { return self.moved(error) };
        let areas = self.sheet.areas(AREAS);
        let moved = total(self.pixels(), 3 * AREAS * AREAS * n, &|p, sums| {
            let channels = sums.chunks_mut(n.max(1)).skip(3 * areas[p]).zip(0..3);
            for (sums, c) in channels.filter(|_| self.weights.kept[p] == 1.0) {
                sums.iter_mut().zip(self.pulled(inverse, p, c, error(p, c))).for_each(|(sum, moved)| *sum += moved);
            }
        });
        let mut sums = vec![0.0; n + n * n];
        moved.chunks(n.max(1)).for_each(|moved| add(&mut sums, moved));
        summed(n, &sums)
    }
}

/// The sums of the products and of the sizes that [`add`] makes of `n` values.
fn summed(n: usize, sums: &[f64]) -> (Symmetric, Vec<f64>) {
    (Symmetric::of(n, |i, j| sums[n + i * n + j]), sums[..n].to_vec())
}

/// Adds by how much each value is moved, and behind those the products of each pair.
fn add(sums: &mut [f64], moved: &[f64]) {
    let (sizes, squares) = sums.split_at_mut(moved.len());
    sizes.iter_mut().zip(moved).for_each(|(size, moved)| *size += moved.abs());
    add_square(squares, moved);
}
