//! The smallest χ² over the parameters of a material, once χ² is a quadratic form of what they make.

use super::gram::Gram;
use crate::anneal::linear::Symmetric;

/// A quadratic form, and how parameters enter it.
pub struct Problem<'a> {
    /// χ² of coefficients.
    pub gram: &'a Gram,
    /// The coefficients of the basis' columns, channel by channel, for values of the parameters.
    pub coefficients: &'a (dyn Fn(&[f64]) -> [Vec<f64>; 3] + Sync),
    /// Bounds of the parameters.
    pub bounds: &'a [(f64, f64)],
}

/// Values of the parameters, and their χ².
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The values.
    pub values: Vec<f64>,
    /// Their χ².
    pub chi2: f64,
}

/// Derivatives of coefficients by each parameter, by central differences inside the bounds.
pub fn derivatives(coefficients: &dyn Fn(&[f64]) -> [Vec<f64>; 3], bounds: &[(f64, f64)], values: &[f64]) -> Vec<[Vec<f64>; 3]> {
    let by = |i: usize| {
        let (low, high) = bounds[i];
        let step = (high - low) * 1e-5;
        let at = |v: f64| {
            let mut moved = values.to_vec();
            moved[i] = v.clamp(low, high);
            (moved[i], coefficients(&moved))
        };
        let ((a, below), (b, above)) = (at(values[i] - step), at(values[i] + step));
        std::array::from_fn(|c| above[c].iter().zip(&below[c]).map(|(x, y)| (x - y) / (b - a).max(f64::MIN_POSITIVE)).collect())
    };
    (0..values.len()).map(by).collect()
}

/// A sum of squares over values inside bounds.
pub trait Valley {
    /// The bounds of the values.
    fn bounds(&self) -> &[(f64, f64)];

    /// The sum of squares.
    fn chi2(&self, values: &[f64]) -> f64;

    /// Half its gradient, and Gauss and Newton's matrix.
    fn normal_equations(&self, values: &[f64]) -> (Vec<f64>, Symmetric);

    /// A relative gain that is not worth another step.
    fn enough(&self) -> f64 {
        1e-12
    }

    /// The minimum near `start`: Gauss and Newton's steps, damped (Levenberg 1944, Marquardt 1963) and kept inside the bounds.
    /// `free` says which parameters move.
    fn polish(&self, start: &[f64], free: &[bool]) -> Point {
        let bounds = self.bounds();
        let mut best = Point { values: start.to_vec(), chi2: self.chi2(start) };
        let mut damping = 1e-3;
        for _ in 0..60 {
            let (gradient, matrix) = self.normal_equations(&best.values);
            // A parameter at a bound that pushes outward stays there.
            let moving: Vec<usize> = (0..start.len())
                .filter(|&i| {
                    let (low, high) = bounds[i];
                    free[i] && !(best.values[i] <= low && gradient[i] > 0.0) && !(best.values[i] >= high && gradient[i] < 0.0)
                })
                .collect();
            let mut improved = false;
            for _ in 0..12 {
                let scale = |i: usize| matrix.at(i, i).abs().max(1e-300);
                let damped = Symmetric::of(moving.len(), |a, b| {
                    let (i, j) = (moving[a], moving[b]);
                    if i == j { matrix.at(i, i).max(0.0) + damping * scale(i) } else { matrix.at(i, j) }
                });
                let step = damped.inverse().map(|inverse| inverse.times(&moving.iter().map(|&i| -gradient[i]).collect::<Vec<_>>()));
                let Some(step) = step else {
                    damping *= 10.0;
                    continue;
                };
                let mut values = best.values.clone();
                for (&i, s) in moving.iter().zip(&step) {
                    values[i] = (values[i] + s).clamp(bounds[i].0, bounds[i].1);
                }
                let chi2 = self.chi2(&values);
                if chi2 < best.chi2 {
                    improved = best.chi2 - chi2 > self.enough() * best.chi2.abs();
                    best = Point { values, chi2 };
                    damping = (damping * 0.2).max(1e-12);
                    break;
                }
                damping *= 5.0;
            }
            if !improved {
                break;
            }
        }
        best
    }
}

impl Valley for Problem<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        self.bounds
    }

    fn chi2(&self, values: &[f64]) -> f64 {
        self.gram.chi2(&(self.coefficients)(values))
    }

    fn normal_equations(&self, values: &[f64]) -> (Vec<f64>, Symmetric) {
        self.gram.normal_equations(&(self.coefficients)(values), &derivatives(self.coefficients, self.bounds, values))
    }
}
