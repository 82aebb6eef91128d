//! How far values could lie from those that were found and make the same picture, all over their bounds.
//!
//! Standard errors tell how sharp a valley is, not whether there are others. Where the light is even, a mirror and a matt surface look the same,
//! and the deepest of many shallow valleys is a matter of chance.

use super::statistics::{COMMON, Half, pictures};
use crate::anneal::linear::Symmetric;
use crate::transport::Basis;

/// The mean square of how far `others`, each with how much it counts, are from `values`: of those that make the same picture but for an error
/// that pixels may have in common. `values` themselves count as much as `own`.
pub fn spread(
    basis: &Basis,
    coefficients: &dyn Fn(&[f64]) -> [Vec<f64>; 3],
    values: &[f64],
    own: f64,
    others: &[(f64, Vec<f64>)],
) -> Symmetric {
    let found = mean(&pictures(basis, &coefficients(values)));
    let level = found.iter().flatten().sum::<f64>() / (3 * found.len().max(1)) as f64;
    let same = |other: &&(f64, Vec<f64>)| {
        let (mut squares, mut sizes) = (0.0, 0.0);
        for (a, b) in found.iter().zip(mean(&pictures(basis, &coefficients(&other.1)))) {
            for c in 0..3 {
                let off = (b[c] - a[c]) / (a[c].abs() + FLOOR * level);
                squares += off * off;
                sizes += off.abs();
            }
        }
        eprintln!("{:.4?} D {:.4} rms {:.4}", other.1, squares / sizes, (squares / (3 * found.len()) as f64).sqrt());
        squares < COMMON * sizes
    };
    let alike: Vec<&(f64, Vec<f64>)> = others.iter().filter(same).collect();
    let total = own + alike.iter().map(|(weight, _)| weight).sum::<f64>();
    let off =
        |i: usize, j: usize| alike.iter().map(|(weight, other)| weight * (other[i] - values[i]) * (other[j] - values[j])).sum::<f64>();
    Symmetric::of(values.len(), |i, j| off(i, j) / total)
}

/// What is darker than this part of the mean need not agree as well.
const FLOOR: f64 = 0.1;

/// The mean of two halves.
fn mean(halves: &[Half]) -> Half {
    halves[0].iter().zip(&halves[1]).map(|(a, b)| std::array::from_fn(|c| 0.5 * (a[c] + b[c]))).collect()
}
