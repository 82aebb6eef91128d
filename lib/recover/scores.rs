//! How much the values can be trusted that were fitted to the pixels, and which way these pull.

mod covariance;

use super::farther::in_standard_errors;
use super::sheet::{Channels, Half, Sheet, Weights, mean, weight};
use super::total::total;
use crate::anneal::anywhere;
use crate::anneal::linear::Symmetric;
use crate::transport::{Basis, Mixture};
use rayon::prelude::*;

/// The pictures that each set of a basis makes of some coefficients, for each of them. A pixel is read once for all.
pub fn pictures(basis: &Basis, coefficients: &[[Vec<f64>; 3]]) -> Vec<Vec<Half>> {
    let mixtures: Vec<Mixture> = coefficients.iter().map(Mixture::new).collect();
    let pixels = basis.samples.len() / basis.sets;
    let width = mixtures.len() * basis.sets;
    let mut rows = vec![[0.0; 3]; pixels * width];
    rows.par_chunks_mut(width).enumerate().with_min_len(512).for_each(|(p, row)| {
        for (i, value) in row.iter_mut().enumerate() {
            *value = mixtures[i % mixtures.len()].of(basis.pixel(p, i / mixtures.len()));
        }
    });
    let picture = |i: usize| rows.iter().skip(i).step_by(width).copied().collect();
    (0..mixtures.len()).map(|i| (0..basis.sets).map(|set| picture(set * mixtures.len() + i)).collect()).collect()
}

/// What a model says at some values of the parameters.
pub struct Evaluation {
    /// The values.
    pub values: Vec<f64>,
    /// The picture of each half.
    pub halves: Vec<Half>,
    /// Its derivative by each parameter, of each half.
    pub derivatives: Vec<Vec<Half>>,
}

/// The sums over pixels and channels of weight × derivative × `rest`, and of weight × derivative × derivative, for the mean of both halves.
pub fn products(weights: &[Channels; 2], derivatives: &[Vec<Half>], rest: impl Fn(usize, usize) -> f64 + Sync) -> (Vec<f64>, Symmetric) {
    let n = derivatives.len();
    let sums = total(weights[0].len(), n + n * n, &|p, sums| {
        for c in 0..3 {
            let (w, rest) = (weight(weights, p, c), rest(p, c));
            let d = |i: usize| mean(&derivatives[i], p, c);
            for i in 0..n {
                let wd = w * d(i);
                sums[i] += wd * rest;
                (0..=i).for_each(|j| sums[n + i * n + j] += wd * d(j));
            }
        }
    });
    (sums[..n].to_vec(), Symmetric::of(n, |i, j| sums[n + i * n + j]))
}

/// How far values are to move, and the covariance of that.
pub type Way = (Vec<f64>, Symmetric);

/// What the pixels say about the values: the products of residuals and derivatives of independent halves, which have no bias from the noise
/// of the rendering.
///
/// Where the derivative of a half is mostly noise it says nothing and disturbs much. So what asks is not the derivative but an instrument
/// (Reiersøl 1945; Hansen 1982): the derivative, shrunk by how far those of the two halves agree around the pixel (Wiener 1949).
pub struct Scores<'a> {
    sheet: &'a Sheet<'a>,
    /// How much its pixels count.
    pub weights: Weights,
    /// What the model says there.
    pub here: Evaluation,
    /// How far each derivative is to be trusted at each pixel.
    trust: Vec<Vec<f64>>,
    /// How χ² curves by each pair of values, and how each score changes with each value.
    curvature: Symmetric,
    slopes: Vec<Vec<f64>>,
    /// What takes scores to steps: nearly the inverse of the slopes. `None` if the pixels do not determine the values.
    inverse: Option<Vec<Vec<f64>>>,
    /// What is known before of each parameter: one over [`anywhere`].
    prior: Vec<f64>,
    /// Covariance of the values, by all that makes the residuals.
    pub covariance: Symmetric,
    /// The part of it that the noise of the rendering makes.
    pub own: Symmetric,
}

impl<'a> Scores<'a> {
    /// The scores at a place, for parameters with these bounds.
    pub fn new(sheet: &'a Sheet<'a>, weights: Weights, here: Evaluation, bounds: &[(f64, f64)]) -> Self {
        let (derivatives, free) = (&here.derivatives, weights.free());
        let mut curvature = products(&free, derivatives, |_, _| 0.0).1;
        let trust = derivatives.par_iter().with_max_len(1).map(|d| trust(sheet, &weights.halves, d)).collect();
        let prior: Vec<f64> = bounds.iter().map(|b| anywhere(*b).powi(2).max(f64::MIN_POSITIVE).recip()).collect();
        let n = derivatives.len();
        let unknown = Symmetric::diagonal(&vec![f64::INFINITY; n]);
        let (covariance, own) = (unknown.clone(), unknown);
        for (i, prior) in prior.iter().enumerate() {
            curvature.set(i, i, curvature.at(i, i) + prior);
        }
        let mut scores = Self { sheet, weights, here, trust, curvature, slopes: vec![], inverse: None, prior, covariance, own };
        scores.slopes = scores.slopes(&free);
        scores.inverse = scores.inverse_of(&(0..n).collect::<Vec<_>>());
        if let Some(inverse) = &scores.inverse {
            let reached = reached(inverse, &scores.slopes);
            let whole = |covariance: &Symmetric| Symmetric::of(n, |i, j| covariance.at(i, j) / (reached[i] * reached[j]));
            let (covariance, own) = scores.covariances(inverse, bounds);
            (scores.covariance, scores.own) = (whole(&covariance), whole(&own));
        }
        scores
    }

    /// For each pair of parameters, the sum over pixels and channels of weight × instrument of one half × what the other half has there, both
    /// ways.
    fn slopes(&self, weights: &[Channels; 2]) -> Vec<Vec<f64>> {
        let (d, n) = (&self.here.derivatives, self.here.derivatives.len());
        let half = |i: usize, j: usize, p: usize, c: usize, h: usize| weights[h][p][c] as f64 * d[i][h][p][c] * d[j][1 - h][p][c];
        let both = |i: usize, j: usize, p: usize| 0.5 * (0..3).map(|c| half(i, j, p, c, 0) + half(i, j, p, c, 1)).sum::<f64>();
        let sums = total(self.pixels(), n * n, &|p, sums| {
            sums.iter_mut().enumerate().for_each(|(k, sum)| *sum += self.trust[k / n][p] * both(k / n, k % n, p));
        });
        let mut slopes: Vec<Vec<f64>> = sums.chunks(n.max(1)).map(<[f64]>::to_vec).collect();
        self.prior.iter().enumerate().for_each(|(i, prior)| slopes[i][i] += prior);
        slopes
    }

    /// What takes the scores of some parameters to their steps, while all others stay.
    fn inverse_of(&self, free: &[usize]) -> Option<Vec<Vec<f64>>> {
        let forward = Symmetric::of(free.len(), |i, j| self.curvature.at(free[i], free[j])).inverse()?;
        let slopes: Vec<Vec<f64>> = free.iter().map(|&i| free.iter().map(|&j| self.slopes[i][j]).collect()).collect();
        Some(landweber(&forward, &slopes))
    }

    fn pixels(&self) -> usize {
        self.weights.halves[0].len()
    }

    fn residual(&self, p: usize, c: usize, half: usize) -> f64 {
        self.sheet.target[p][c] as f64 - self.here.halves[half][p][c]
    }

    /// By how many standard errors the pixels are farther off in the pictures of another place, by the weights that they have at this one.
    pub fn excess(&self, other: &[Half]) -> f64 {
        let cross = |halves, p, c| self.sheet.cross(halves, p, c);
        let more = |p: usize, c: usize| weight(&self.weights.halves, p, c) * (cross(other, p, c) - cross(&self.here.halves, p, c));
        in_standard_errors((0..self.pixels()).map(|p| (0..3).map(|c| more(p, c)).sum()))
    }

    /// A pixel's part of the score of parameter `i`.
    fn score(&self, i: usize, p: usize) -> f64 {
        let d = &self.here.derivatives[i];
        let cross = |c: usize| {
            let half = |h: usize| self.weights.halves[h][p][c] as f64 * d[h][p][c] * self.residual(p, c, 1 - h);
            0.5 * (half(0) + half(1))
        };
        self.trust[i][p] * (0..3).map(cross).sum::<f64>()
    }

    /// A step toward where the scores vanish; `None` if there is no saying.
    pub fn step(&self) -> Option<Vec<f64>> {
        self.inverse.as_ref().map(|inverse| times(inverse, &self.scores()))
    }

    /// The same for values that stay inside their bounds: what is at one and would go beyond is held there, and the others go where that is best.
    pub fn step_within(&self, bounds: &[(f64, f64)]) -> Option<Vec<f64>> {
        let scores = self.scores();
        let mut step = times(self.inverse.as_ref()?, &scores);
        let mut free: Vec<usize> = (0..step.len()).collect();
        while free.iter().any(|&i| self.leaves(bounds, i, step[i])) {
            free.retain(|&i| !self.leaves(bounds, i, step[i]));
            let asked: Vec<f64> = free.iter().map(|&i| scores[i]).collect();
            step.fill(0.0);
            times(&self.inverse_of(&free)?, &asked).into_iter().zip(&free).for_each(|(s, &i)| step[i] = s);
        }
        Some(step)
    }

    /// Whether a value is at a bound, and a step would lead beyond it.
    fn leaves(&self, bounds: &[(f64, f64)], i: usize, step: f64) -> bool {
        let (value, (low, high)) = (self.here.values[i], bounds[i]);
        step < 0.0 && value <= low || step > 0.0 && value >= high
    }

    /// Which values bounds surely keep from going on, and how much farther all would go if they did not; `None` where none does.
    pub fn pressed(&self, bounds: &[(f64, f64)]) -> Option<(Vec<bool>, Vec<f64>)> {
        let (free, errors) = (self.step()?, self.covariance.deviations());
        let surely = |i: usize| self.leaves(bounds, i, free[i]) && free[i].abs() > PRESSED * errors[i];
        let pressed: Vec<bool> = (0..free.len()).map(surely).collect();
        if !pressed.contains(&true) {
            return None;
        }
        let within = self.step_within(bounds)?;
        Some((pressed, free.iter().zip(&within).map(|(free, within)| free - within).collect()))
    }

    /// The score of each parameter.
    fn scores(&self) -> Vec<f64> {
        total(self.pixels(), self.here.derivatives.len(), &|p, sums| {
            sums.iter_mut().enumerate().for_each(|(i, sum)| *sum += self.score(i, p))
        })
    }

    /// How far a pixel by itself moves each value.
    fn pull(&self, inverse: &[Vec<f64>], p: usize) -> Vec<f64> {
        times(inverse, &(0..inverse.len()).map(|i| self.score(i, p)).collect::<Vec<_>>())
    }

    /// Weights under which no pixel by itself moves the values too far; `None` if none does. One that sees a lamp by the way in a few samples would
    /// outweigh thousands (bounded influence: Krasker and Welsch 1982). Where few pixels tell a value, as those of a small highlight do, each may move
    /// it by more.
    pub fn bounded(&self, most: f64) -> Option<Weights> {
        let (inverse, errors) = (self.inverse.as_ref()?, self.covariance.deviations());
        let n = errors.len();
        let told = total(self.pixels(), 2 * n, &|p, sums| {
            let (squares, fourths) = sums.split_at_mut(n);
            for (i, told) in self.tells(inverse, p).into_iter().enumerate() {
                squares[i] += told;
                fourths[i] += told * told;
            }
        });
        // As many pixels that tell it alike would have the same sums.
        let tell = |i: usize| (told[i] * told[i] / told[n + i].max(f64::MIN_POSITIVE)).max(1.0);
        let most: Vec<f64> = errors.iter().enumerate().map(|(i, error)| error * most.max(FEW / tell(i).sqrt())).collect();
        let pull = |p: usize| length(&self.pull(inverse, p), &most).max(self.noise(p) / MOST_NOISE);
        let pulls: Vec<f64> = (0..self.pixels()).into_par_iter().map(pull).collect();
        let part = |pull: &f64| if *pull > SLACK { 1.0 / *pull as f32 } else { 1.0 };
        let lighter = |half: &Channels| half.iter().zip(&pulls).map(|(w, pull)| w.map(|w| w * part(pull))).collect();
        let kept = self.weights.kept.iter().zip(&pulls).map(|(kept, pull)| kept * part(pull)).collect();
        pulls.iter().any(|pull| *pull > SLACK).then(|| Weights {
            halves: self.weights.halves.each_ref().map(lighter),
            kept,
            rounded: self.weights.rounded.clone(),
        })
    }

    /// The largest part that the noise of a pixel's derivative makes of how χ² curves by a value, where it is more than what both halves confirm.
    fn noise(&self, p: usize) -> f64 {
        let part = |(i, d): (usize, &Vec<Half>)| {
            let [common, whole] = agreement(&self.weights.halves, p, |half, c| d[half][p][c]);
            if whole > 2.0 * common { (whole - common) / self.curvature.at(i, i) } else { 0.0 }
        };
        self.here.derivatives.iter().enumerate().map(part).fold(0.0, f64::max)
    }

    /// Where the pixels that are held back would move the values, and how sure that is; `None` where it is chance.
    ///
    /// Noise that is as often too bright as too dark leaves nothing there. But a photograph whose few samples seldom find a small lamp is too dark
    /// in most pixels, and far too bright in some: these lead astray on the way, and are a part of the mean in the end. So it is with a rendering
    /// whose few samples do: that leads to the other side, and is seen in the pixels that only one half finds off.
    pub fn withheld(&self) -> Option<Way> {
        let inverse = self.inverse.as_ref()?;
        let ways = [true, false].into_iter().filter_map(|agreed| self.withheld_where(inverse, agreed));
        ways.reduce(|(a, b), (c, d)| {
            let covariance = Symmetric::of(a.len(), |i, j| b.at(i, j) + d.at(i, j));
            (a.iter().zip(&c).map(|(a, c)| a + c).collect(), covariance)
        })
    }

    /// The same of the pixels that both halves find off alike, or of the others. Where it may be chance, it moves nowhere, but the values may be as
    /// far off.
    fn withheld_where(&self, inverse: &[Vec<f64>], agreed: bool) -> Option<Way> {
        let n = inverse.len();
        let sums = total(self.pixels(), n + n * n, &|p, sums| {
            let more = 1.0 / self.weights.kept[p] as f64 - 1.0;
            if more > 0.0 && self.agreed(p) == agreed {
                let (moved, squares) = sums.split_at_mut(n);
                let pull: Vec<f64> = self.pull(inverse, p).iter().map(|pull| pull * more).collect();
                moved.iter_mut().zip(&pull).for_each(|(sum, pull)| *sum += pull);
                add_square(squares, &pull);
            }
        });
        let (way, covariance) = (sums[..n].to_vec(), Symmetric::of(n, |i, j| sums[n + i * n + j]));
        let beyond = |least: f64| (0..n).any(|i| way[i].powi(2) > (least * covariance.at(i, i)).max(self.covariance.at(i, i)));
        let perhaps = || beyond(PERHAPS).then(|| (vec![0.0; n], Symmetric::of(n, |i, j| way[i] * way[j])));
        if beyond(SKEWED) { Some((way, covariance)) } else { perhaps() }
    }

    /// Whether both halves are off at a pixel by about as much.
    fn agreed(&self, p: usize) -> bool {
        let [common, whole] = agreement(&self.weights.halves, p, |half, c| self.residual(p, c, half));
        common > AGREED * whole
    }

    /// The part of the squares of what both halves together are off by that the noise of the rendering makes.
    pub fn own_part(&self) -> f64 {
        let whole = self.squares(1.0);
        if whole > 0.0 { (self.squares(-1.0) / whole).min(1.0) } else { 0.0 }
    }

    /// The weighted squares, over all pixels, of what one half is off by plus `sign` times the other: of the rendering's noise if that is −1.
    pub fn squares(&self, sign: f64) -> f64 {
        let both = |p: usize, c: usize| self.residual(p, c, 0) + sign * self.residual(p, c, 1);
        total(self.pixels(), 3, &|p, sums| (0..3).for_each(|c| sums[c] += weight(&self.weights.halves, p, c) * both(p, c).powi(2)))
            .iter()
            .sum()
    }

    /// How much of the derivative by each parameter is not noise, from 0 to 1.
    pub fn clarity(&self) -> Vec<f64> {
        let clarity = |d: &Vec<Half>| {
            let sums = total(self.pixels(), 2, &|p, sums| {
                agreement(&self.weights.halves, p, |half, c| d[half][p][c]).iter().zip(sums).for_each(|(part, sum)| *sum += part)
            });
            if sums[1] > 0.0 { (sums[0] / sums[1]).clamp(0.0, 1.0) } else { 0.0 }
        };
        self.here.derivatives.iter().map(clarity).collect()
    }

    /// How far a step goes: the largest part of it, in standard errors.
    pub fn length(&self, step: &[f64]) -> f64 {
        length(step, &self.covariance.deviations())
    }

    /// The number of each pixel and how far it is off, with fixed weights, without what the noise of the rendering adds to it.
    pub fn losses(&self) -> Vec<(usize, f64)> {
        let weights = &self.sheet.relative;
        let loss = |p: usize| (0..3).map(|c| weights[p][c] as f64 * self.sheet.cross(&self.here.halves, p, c)).sum();
        self.sheet.numbers.iter().enumerate().map(|(p, n)| (*n, loss(p))).collect()
    }

    /// The numbers of the pixels that are far brighter than anything explains.
    pub fn strays(&self, losses: &[(usize, f64)]) -> Vec<usize> {
        let unexplained = |p: usize| {
            let photographed = |c: usize| self.sheet.target[p][c] as f64;
            (0..3).map(|c| mean(&self.here.halves, p, c)).sum::<f64>() < EXPLAINED * (0..3).map(photographed).sum::<f64>()
        };
        let strays = losses.iter().enumerate().filter(|(p, (_, loss))| *loss > STRAY && unexplained(*p));
        strays.map(|(_, (n, _))| *n).collect()
    }
}

/// The square by which a pixel is off, in terms of the light around it, that nothing explains, if less than a part of its own light is explained: glints
/// leave a few at the most.
const STRAY: f64 = 100.0;
const EXPLAINED: f64 = 0.2;

/// What the numbers of two halves, channel by channel, have in common at a pixel, and what there is of their mean: weighted squares.
fn agreement(weights: &[Channels; 2], p: usize, of: impl Fn(usize, usize) -> f64) -> [f64; 2] {
    let (mut common, mut whole) = (0.0, 0.0);
    for c in 0..3 {
        let (a, b, w) = (of(0, c), of(1, c), weight(weights, p, c));
        common += w * a * b;
        whole += w * 0.25 * (a + b) * (a + b);
    }
    [common, whole]
}

/// How far the derivatives of two halves agree around each pixel: 0 where they are noise, 1 where they are the same. Not in those beside it, as the
/// derivative by a blur ([`Look::blurred`](super::look::Look)) there holds the pixel itself, and the trust in it must not go by what it found.
fn trust(sheet: &Sheet, weights: &[Channels; 2], derivative: &[Half]) -> Vec<f64> {
    let sums = |p: usize| {
        let [common, whole] = agreement(weights, p, |half, c| derivative[half][p][c]);
        [common, whole, 0.0]
    };
    let values: Vec<[f64; 3]> = (0..weights[0].len()).map(sums).collect();
    let apart = sheet.apart(&values, 2);
    apart.iter().map(|[common, whole, _]| if *whole > 0.0 { (common / whole).clamp(0.0, 1.0) } else { 0.0 }).collect()
}

/// How much the error of one sample of each pixel disturbs the values, each in terms of the error that is wished for, as its neighbours say: the
/// samples that a pixel is given must not depend on what it found before.
pub fn influence(scores: &Scores, variances: &[Vec<[f64; 3]>; 2], wished: &[f64]) -> Vec<f64> {
    let Some(inverse) = &scores.inverse else { return vec![1.0; scores.pixels()] };
    let n = wished.len();
    let half = |half: usize, p: usize| -> f64 {
        let instrument = |j: usize, c: usize| scores.trust[j][p].sqrt() * scores.here.derivatives[j][half][p][c];
        let moved = |i: usize, c: usize| (0..n).map(|j| inverse[i][j] * instrument(j, c)).sum::<f64>() / wished[i];
        let weight = |c: usize| scores.weights.halves[half][p][c] as f64;
        let channel = |c: usize| variances[half][p][c] * weight(c).powi(2) * (0..n).map(|i| moved(i, c).powi(2)).sum::<f64>();
        (0..3).map(channel).sum::<f64>().sqrt()
    };
    let own: Vec<[f64; 3]> = (0..scores.pixels()).into_par_iter().map(|p| [0.5 * (half(0, p) + half(1, p)), 0.0, 0.0]).collect();
    scores.sheet.around(&own, 1).iter().map(|around| around[0]).collect()
}

/// Where few pixels tell a value, one may move it by so many times its fair share, which is 1/√pixels of a standard error.
const FEW: f64 = 6.0;
/// The most that the noise of one pixel's derivative may make of how χ² curves: else many more steps are needed than are taken.
const MOST_NOISE: f64 = 0.03;
/// How nearly that is kept, in at most so many turns: what is taken from one pixel makes the standard errors smaller.
const SLACK: f64 = 1.1;
pub const BOUNDINGS: usize = 12;

/// Steps toward the values that the scores ask for, and of what a step is made of.
pub const STEPS: usize = 24;

/// How large the square of what was withheld must be, in terms of its variance, not to be chance, and not to be taken for chance.
const SKEWED: f64 = 6.25;
const PERHAPS: f64 = 2.25;

/// By how many standard errors a value that is at a bound must be asked to go beyond it for that not to be chance.
const PRESSED: f64 = 3.0;

/// How much of what two halves are off by, in terms of their mean's square, they must have in common for it to be the photograph's: the mean of
/// their squares is twice their product then.
const AGREED: f64 = 2.0 / 3.0;

/// The largest part of a step, in terms of what each value may err by.
fn length(step: &[f64], errors: &[f64]) -> f64 {
    step.iter().zip(errors).map(|(s, e)| s.abs() / e.max(1e-12)).fold(0.0, f64::max)
}

/// The product of a matrix and a vector.
fn times(matrix: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    matrix.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect()
}

/// Adds the products of each pair of the entries of a vector to the lower half of a matrix.
fn add_square(sum: &mut [f64], x: &[f64]) {
    for i in 0..x.len() {
        (0..=i).for_each(|j| sum[i * x.len() + j] += x[i] * x[j]);
    }
}

/// Which part of the way to where the scores vanish a step comes, value by value: what disturbs the scores disturbs the step by that part only.
fn reached(inverse: &[Vec<f64>], slopes: &[Vec<f64>]) -> Vec<f64> {
    let part = |(i, row): (usize, &Vec<f64>)| row.iter().zip(slopes).map(|(x, slope)| x * slope[i]).sum::<f64>();
    inverse.iter().enumerate().map(|row| part(row).clamp(LEAST_REACHED, 1.0)).collect()
}

/// The least part that is reckoned with.
const LEAST_REACHED: f64 = 0.05;

/// What takes scores that change with the values by `slopes` to a step: what [`STEPS`] steps by `forward`, the inverse of the curvature, come to.
///
/// The slope of the scores is itself known by the noise alone where little is sampled, and its inverse may lead anywhere. The curvature of
/// χ² is too steep by the noise, but never flat: many steps by its inverse come nearly as far where the slope is well known, and
/// not astray where it is not (Landweber 1951).
fn landweber(forward: &Symmetric, slopes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = forward.size();
    let forward: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| forward.at(i, j)).collect()).collect();
    let times = |a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<Vec<f64>> {
        (0..n).map(|i| (0..n).map(|j| (0..n).map(|k| a[i][k] * b[k][j]).sum()).collect()).collect()
    };
    let mut all = forward.clone();
    for _ in 1..STEPS {
        let left = times(slopes, &all);
        let rest: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| (i == j) as u8 as f64 - left[i][j]).collect()).collect();
        let more = times(&forward, &rest);
        all.iter_mut().flatten().zip(more.into_iter().flatten()).for_each(|(a, m)| *a += m);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_come_as_far_as_the_slope_is_known() {
        // Of a curvature of 4 that is all noise but a hundredth, steps come 1 − .99^24 of the way.
        let slopes = [vec![4.0, 0.0], vec![0.0, 0.04]];
        let inverse = landweber(&Symmetric::diagonal(&[0.25; 2]), &slopes);
        let [all, part] = reached(&inverse, &slopes)[..] else { panic!() };
        assert!((all - 1.0).abs() < 1e-12 && (part - (1.0 - 0.99f64.powi(24))).abs() < 1e-12, "{all} {part}");
        assert_eq!(reached(&[vec![0.0]], &[vec![4.0]]), [LEAST_REACHED]);
    }
}
