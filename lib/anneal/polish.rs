//! Where a function of a vector has its minimum, told from noisy values near it.
//!
//! A quadratic is fitted by weighted least squares to all values inside a region, and the region follows it: its centre goes
//! to the quadratic's minimum, its shape to the quadratic's level lines (so that it lies along a valley), its size to the
//! level that stands well above what the quadratic leaves unexplained. Where that is curvature of higher order, the region
//! shrinks and convergence is fast; where it is noise, the region stays and every further value sharpens the average. A lucky
//! value can pull the fit a little; it cannot become the answer by itself. See Conn, Scheinberg and Vicente (2009), chapters 4
//! and 10, for trust regions with regression models.
//!
//! Nelder and Mead's simplex and a pattern search were tried in its place: at equal evaluations their errors were two to twelve
//! times larger on noisy valleys, and no smaller on smooth ones.

use super::linear::Symmetric;
use super::random::Random;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A value that was measured, at a point of the unit cube.
pub struct Seen {
    /// Where.
    pub at: Vec<f64>,
    /// The mean of what was measured there.
    pub value: f64,
    /// Of how many measurements.
    pub weight: f64,
}

/// What the quadratic says of the minimum.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fit {
    /// Where the quadratic is smallest inside the unit cube and the region.
    pub minimum: Vec<f64>,
    /// Its value there.
    pub value: f64,
    /// Second derivatives, made positive definite.
    pub hessian: Symmetric,
    /// Standard error of each coordinate of the minimum, from the scatter of the values about the quadratic; at most `f64::MAX`.
    pub errors: Vec<f64>,
    /// Standard deviation of one value about the quadratic.
    pub scatter: f64,
}

/// The search for the minimum: a region and the last fit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Polish {
    center: Vec<f64>,
    /// The region is (u − c)ᵀ M (u − c) ≤ 1.
    metric: Symmetric,
    /// The smallest scatter that any fit left: the noise, as far as it is known.
    noise: f64,
    /// What the last fit found, if there was one.
    pub fit: Option<Fit>,
}

/// A quadratic in the region's own coordinates z, in which the region is the unit ball.
struct Quadratic {
    value: f64,
    gradient: Vec<f64>,
    hessian: Symmetric,
    /// Covariance of the coefficients (value, gradient, second derivatives by [`pairs`]) for a scatter of 1.
    covariance: Symmetric,
    scatter: f64,
    freedom: f64,
}

/// The region's edge stands this many standard deviations above its centre.
const EDGE: f64 = 3.0;
/// A scatter known from few degrees of freedom is taken to be larger: by this many of its own standard errors.
const SLACK: f64 = 2.0;
/// Half-lengths of the region never exceed this part of the unit cube's side; below the other it is as good as a point.
const LENGTHS: (f64, f64) = (0.5, 1e-7);
/// The region's half-lengths change at most by these factors from one fit to the next.
const CHANGE: (f64, f64) = (1.0 / 3.0, 2.0);
/// How strongly second derivatives that the values leave open are held to the fit before, or to 0 when there was none.
const HOLD: (f64, f64) = (1e-3, 1e-6);
/// Where values jump, the width of a pit, in parts of the region.
const PIT: f64 = 0.2;
/// A step is long from here on, in parts of the region, and ends at the edge from there on.
const LONG: (f64, f64) = (0.3, 0.95);

/// How many coefficients a quadratic in that many variables has.
pub fn coefficients(variables: usize) -> usize {
    1 + variables + variables * (variables + 1) / 2
}

impl Polish {
    /// A search about the lowest of these values, in a region as large as the lowest few are spread, and all that jumps may have made higher.
    pub fn about(seen: &[Seen], variables: usize, jumps: f64) -> Self {
        let mut lowest: Vec<&Seen> = seen.iter().collect();
        lowest.sort_by(|a, b| a.value.total_cmp(&b.value));
        let wanted = coefficients(variables) * 5 / 4;
        let level = lowest.first().map_or(0.0, |s| s.value) + 2.0 * EDGE * jumps;
        lowest.truncate(wanted.max(lowest.partition_point(|s| s.value < level)));
        let center = lowest.first().map_or(vec![0.5; variables], |s| s.at.clone());
        // Too few values say little about how far to look.
        let least = if lowest.len() < wanted { 0.05 } else { 1e-3 };
        let half_lengths = (0..variables).map(|i| {
            let square = lowest.iter().map(|s| (s.at[i] - center[i]).powi(2)).sum::<f64>() / lowest.len().max(1) as f64;
            (1.5 * square.sqrt().max(least)).min(LENGTHS.0)
        });
        let metric = Symmetric::diagonal(&half_lengths.map(|h| h.powi(-2)).collect::<Vec<_>>());
        Self { center, metric, noise: f64::MAX, fit: None }
    }

    /// The quadratic's minimum, if there was a fit.
    pub fn minimum(&self) -> Option<Vec<f64>> {
        self.fit.as_ref().map(|fit| fit.minimum.clone())
    }

    /// Whether its parts are those of a search in that many variables.
    pub fn is_consistent(&self, variables: usize) -> bool {
        let vector = |x: &[f64]| x.len() == variables && x.iter().all(|x| x.is_finite());
        vector(&self.center)
            && self.metric.is_finite_of(variables)
            && self.fit.as_ref().is_none_or(|fit| vector(&fit.minimum) && vector(&fit.errors) && fit.hessian.is_finite_of(variables))
    }

    /// The next point to measure, in the unit cube; `None` when the region has become a point. Noise is no less than values jump that repeat.
    pub fn next(&mut self, seen: &[Seen], jumps: f64, random: &mut Random) -> Option<Vec<f64>> {
        let variables = self.center.len();
        let many = coefficients(variables) + 2;
        // Fit and move as often as the values allow it.
        for _ in 0..8 {
            let near = seen.iter().filter(|s| self.distance(&s.at) <= 1.0).count();
            if near < if self.fit.is_some() { 2 * variables + 1 } else { many } {
                break;
            }
            let moved = self.refit(seen, jumps);
            if self.longest() < LENGTHS.1 {
                return None;
            }
            if moved || seen.iter().all(|s| self.distance(&s.at) > LONG.0) {
                return Some(self.center.clone());
            }
            if near >= many {
                break;
            }
        }
        Some(self.design(seen, random))
    }

    /// Distance from the centre; 1 at the region's edge.
    fn distance(&self, at: &[f64]) -> f64 {
        self.metric.form(&difference(at, &self.center)).max(0.0).sqrt()
    }

    /// The longest half-length of the box about the region; 0 when it cannot be told.
    fn longest(&self) -> f64 {
        let inverse = self.metric.inverse();
        (0..self.center.len()).map(|i| inverse.as_ref().map_or(0.0, |m| m.at(i, i).sqrt())).fold(0.0, f64::max)
    }

    /// A point toward the region's edge, far from the points measured so far: there a value says most about the quadratic.
    fn design(&self, seen: &[Seen], random: &mut Random) -> Vec<f64> {
        let variables = self.center.len();
        let back = self.metric.with_eigenvalues(|v| v.powf(-0.5));
        let near: Vec<&Seen> = seen.iter().filter(|s| self.distance(&s.at) < 2.0).collect();
        let mut chosen = (f64::NEG_INFINITY, self.center.clone());
        for _ in 0..8 * variables {
            let direction: Vec<f64> = (0..variables).map(|_| random.normal()).collect();
            let radius = (0.6 + 0.4 * random.uniform()) / norm(&direction).max(f64::MIN_POSITIVE);
            let offset = back.times(&direction.iter().map(|x| x * radius).collect::<Vec<_>>());
            let point: Vec<f64> = self.center.iter().zip(&offset).map(|(c, o)| (c + o).clamp(0.0, 1.0)).collect();
            let nearest = near.iter().map(|s| self.metric.form(&difference(&s.at, &point))).fold(f64::INFINITY, f64::min);
            if nearest > chosen.0 {
                chosen = (nearest, point);
            }
        }
        chosen.1
    }

    /// Fits the quadratic and moves, turns and resizes the region; says whether the centre moved by a good part of it.
    fn refit(&mut self, seen: &[Seen], jumps: f64) -> bool {
        let variables = self.center.len();
        let root = self.metric.with_eigenvalues(f64::sqrt);
        let back = self.metric.with_eigenvalues(|v| v.powf(-0.5));
        let near: Vec<(Vec<f64>, f64, f64)> = (seen.iter())
            .filter_map(|s| {
                let z = root.times(&difference(&s.at, &self.center));
                let weight = (2.0 - norm(&z)).clamp(0.0, 1.0).powi(3);
                (weight > 1e-3).then_some((z, s.value, weight * s.weight))
            })
            .collect();
        // Where values jump, those of one pit count as one.
        let mut pits: BTreeMap<Vec<i64>, f64> = BTreeMap::new();
        let pit = |z: &[f64]| z.iter().map(|z| (z / PIT).round() as i64).collect::<Vec<_>>();
        if jumps > 0.0 {
            near.iter().for_each(|(z, ..)| *pits.entry(pit(z)).or_default() += 1.0);
        }
        let alike = |z: &[f64]| if jumps > 0.0 { pits[&pit(z)] } else { 1.0 };
        let rows: Vec<(Vec<f64>, f64, f64)> = near.iter().map(|(z, value, weight)| (features(z), *value, weight / alike(z))).collect();
        let prior = self.fit.as_ref().map(|fit| back.around(&fit.hessian));
        let Some(quadratic) = Quadratic::fit(&rows, variables, prior.as_ref()) else {
            // Values this wild are no quadratic here: look closer.
            self.metric = self.metric.with_eigenvalues(|v| v * CHANGE.0.powi(-2));
            return false;
        };
        let mut largest = 0.0f64;
        quadratic.hessian.with_eigenvalues(|v| {
            largest = largest.max(v.abs());
            v
        });
        let positive = quadratic.hessian.with_eigenvalues(|v| v.max(1e-6 * largest).max(f64::MIN_POSITIVE));
        // Step to the minimum, as far as the region and the unit cube reach.
        let (step, length) = self.descend(&root.times(&quadratic.gradient), &root.around(&positive));
        let z = root.times(&step);
        let value = quadratic.at(&z);
        let errors = back.around(&quadratic.minimum_covariance(&positive, &z));
        let slack = student(quadratic.freedom);
        let error = |i| Some(slack * errors.at(i, i).max(0.0).sqrt()).filter(|e| e.is_finite()).unwrap_or(f64::MAX);
        // The new region is the level line EDGE deviations up; at the edge of the old one, as far up as this step went down.
        if quadratic.freedom > variables as f64 {
            self.noise = self.noise.min(quadratic.scatter * (1.0 + SLACK / quadratic.freedom.sqrt()));
        }
        let at_edge = length > LONG.1;
        let rise = (EDGE * self.noise.min(quadratic.scatter).max(jumps)).max(if at_edge { quadratic.value - value } else { 0.0 });
        let level = 2.0 * rise.max(1e-14 * (quadratic.value.abs() + largest)).max(f64::MIN_POSITIVE);
        let steepest = if at_edge { 1.0 } else { CHANGE.0.powi(-2) };
        let shape = positive.with_eigenvalues(|v| (v / level).clamp(CHANGE.1.powi(-2), steepest));
        self.metric = root.around(&shape).with_eigenvalues(|v| v.max(LENGTHS.0.powi(-2)));
        self.center.iter_mut().zip(&step).for_each(|(c, s)| *c = (*c + s).clamp(0.0, 1.0));
        // Values that only just determine the coefficients say nothing of their errors: keep those known before.
        let errors = match self.fit.take() {
            Some(before) if quadratic.freedom < 1.0 => before.errors,
            _ if quadratic.freedom < 1.0 => vec![f64::MAX; variables],
            _ => (0..variables).map(error).collect(),
        };
        let hessian = root.around(&positive);
        self.fit = Some(Fit { minimum: self.center.clone(), value, hessian, errors, scatter: quadratic.scatter });
        length > LONG.0
    }

    /// The step that minimises the quadratic inside the unit cube and not farther than the region's edge, and its length there.
    fn descend(&self, gradient: &[f64], hessian: &Symmetric) -> (Vec<f64>, f64) {
        let variables = self.center.len();
        let solve = |damping: f64| {
            let damped = Symmetric::of(variables, |i, j| hessian.at(i, j) + damping * self.metric.at(i, j));
            let free = damped.inverse().map(|inverse| inverse.times(gradient).iter().map(|x| -x).collect::<Vec<f64>>());
            let inside = |step: &Vec<f64>| step.iter().zip(&self.center).all(|(s, c)| (0.0..=1.0).contains(&(c + s)));
            let step = free.filter(inside).unwrap_or_else(|| self.descend_in_box(gradient, &damped));
            let length = self.metric.form(&step).sqrt();
            (step, length)
        };
        let free = solve(0.0);
        if free.1 <= 1.0 {
            return free;
        }
        // Bisect the damping (in powers of e) that brings the step back to the edge (Levenberg 1944).
        let scale = (0..variables).map(|i| hessian.at(i, i) / self.metric.at(i, i)).fold(0.0, f64::max).ln();
        let (mut low, mut high) = (scale - 30.0, scale + 30.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if solve(middle.exp()).1 > 1.0 { low = middle } else { high = middle }
        }
        solve(high.exp())
    }

    /// The step that minimises the quadratic inside the unit cube: exact along one coordinate after the other.
    fn descend_in_box(&self, gradient: &[f64], hessian: &Symmetric) -> Vec<f64> {
        let variables = self.center.len();
        let mut step = vec![0.0; variables];
        for _ in 0..1000 {
            let mut change = 0.0f64;
            for i in 0..variables {
                let slope = gradient[i] + (0..variables).map(|j| hessian.at(i, j) * step[j]).sum::<f64>();
                let next = (step[i] - slope / hessian.at(i, i)).clamp(-self.center[i], 1.0 - self.center[i]);
                change = change.max((next - step[i]).abs());
                step[i] = next;
            }
            if change < 1e-10 {
                break;
            }
        }
        step
    }
}

/// How many times as far as two standard errors what is as rare lies out where those are known from so many degrees of freedom, at least 1: Student's
/// distribution beside the normal one (Abramowitz and Stegun 1964, equation 26.7.5, for 2).
fn student(freedom: f64) -> f64 {
    let part = 1.0 / freedom.max(1.0);
    1.0 + part * (1.25 + part * (1.53 + part * 1.43))
}

impl Quadratic {
    /// The quadratic of least squares through rows of features, value and weight; `None` if there is none.
    fn fit(rows: &[(Vec<f64>, f64, f64)], variables: usize, prior: Option<&Symmetric>) -> Option<Self> {
        let size = coefficients(variables);
        let total: f64 = rows.iter().map(|row| row.2).sum();
        let weakly = if prior.is_some() { HOLD.0 } else { HOLD.1 };
        let hold = |k: usize| total * if k <= variables { 1e-12 } else { weakly };
        // Solve the normal equations about the mean value, second derivatives held weakly to those known before.
        let mean = rows.iter().map(|row| row.1 * row.2).sum::<f64>() / total;
        let data = Symmetric::of(size, |i, j| rows.iter().map(|(f, _, w)| w * f[i] * f[j]).sum());
        let covariance = Symmetric::of(size, |i, j| data.at(i, j) + if i == j { hold(i) } else { 0.0 }).inverse()?;
        let mut right: Vec<f64> = (0..size).map(|k| rows.iter().map(|(f, y, w)| w * f[k] * (y - mean)).sum()).collect();
        for (k, (i, j)) in (variables + 1..).zip(pairs(variables)) {
            right[k] += prior.map_or(0.0, |prior| hold(k) * prior.at(i, j));
        }
        let solution = covariance.times(&right);
        // What is left unexplained, for each value beyond the coefficients that the values determine.
        let predicted = |f: &[f64]| mean + f.iter().zip(&solution).map(|(a, b)| a * b).sum::<f64>();
        let left: f64 = rows.iter().map(|(f, y, w)| w * (y - predicted(f)).powi(2)).sum();
        let determined: f64 = (0..size).map(|k| 1.0 - hold(k) * covariance.at(k, k)).sum();
        let freedom = total - determined;
        let scatter = (left / freedom.max(1.0)).sqrt();
        let mut hessian = Symmetric::diagonal(&vec![0.0; variables]);
        pairs(variables).zip(&solution[variables + 1..]).for_each(|((i, j), value)| hessian.set(i, j, *value));
        let gradient = solution[1..=variables].to_vec();
        let finite = scatter.is_finite() && solution.iter().all(|x| x.is_finite());
        finite.then_some(Self { value: mean + solution[0], gradient, hessian, covariance, scatter, freedom })
    }

    /// Its value at z.
    fn at(&self, z: &[f64]) -> f64 {
        self.value + self.gradient.iter().zip(z).map(|(g, x)| g * x).sum::<f64>() + 0.5 * self.hessian.form(z)
    }

    /// The covariance of the minimum's coordinates: dz = −H⁻¹ (dg + dH z), with `hessian` for H.
    fn minimum_covariance(&self, hessian: &Symmetric, z: &[f64]) -> Symmetric {
        let variables = z.len();
        let inverse = hessian.inverse().unwrap_or_else(|| Symmetric::diagonal(&vec![f64::INFINITY; variables]));
        let derivatives: Vec<Vec<f64>> = (0..variables)
            .map(|a| {
                let by_hessian =
                    pairs(variables).map(|(i, j)| inverse.at(a, i) * z[j] + if i == j { 0.0 } else { inverse.at(a, j) * z[i] });
                std::iter::once(0.0).chain((0..variables).map(|i| inverse.at(a, i))).chain(by_hessian).collect()
            })
            .collect();
        let spread: Vec<Vec<f64>> = derivatives.iter().map(|row| self.covariance.times(row)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        Symmetric::of(variables, |i, j| dot(&spread[i], &derivatives[j]) * self.scatter * self.scatter)
    }
}

/// 1, zᵢ, ½ zᵢ², zᵢ zⱼ.
fn features(z: &[f64]) -> Vec<f64> {
    let squares = pairs(z.len()).map(|(i, j)| if i == j { 0.5 * z[i] * z[i] } else { z[i] * z[j] });
    std::iter::once(1.0).chain(z.iter().copied()).chain(squares).collect()
}

/// Rows and columns of the lower triangle, row by row.
fn pairs(size: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..size).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// a − b.
fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn norm(z: &[f64]) -> f64 {
    z.iter().map(|x| x * x).sum::<f64>().sqrt()
}
