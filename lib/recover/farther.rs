//! Which of two that were found explains the pixels better, and how sure that is.

use super::median::median;
use std::collections::HashMap;

/// By how many standard errors pixels, by their numbers, are farther off in one row than in another, as far as they are in both.
pub fn farther_off(here: &[(usize, f64)], there: &[(usize, f64)]) -> f64 {
    in_standard_errors(farther_by(here, there))
}

/// The same by all of them alike: none counts for more than `MOST` times the middle one of those that make a difference. Where a small lamp is seen in
/// a mirror, a few pixels make most of what chance does: of a ball and a box of metal in a room, mirrors, that between two lamps, they were .5 standard
/// errors farther from a mirror than from a lobe, and by all alike 22 nearer; of rough ones 1.5 to 4 and 20 to 21 farther.
pub fn farther_off_alike(here: &[(usize, f64)], there: &[(usize, f64)]) -> f64 {
    let by = farther_by(here, there);
    let most = MOST * median(by.iter().map(|d| d.abs()).filter(|size| *size > 0.0)).unwrap_or(0.0);
    in_standard_errors(by.into_iter().map(|d| d.clamp(-most, most)))
}

const MOST: f64 = 3.0;

/// By how much more each pixel is off.
fn farther_by(here: &[(usize, f64)], there: &[(usize, f64)]) -> Vec<f64> {
    let there: HashMap<usize, f64> = there.iter().copied().collect();
    here.iter().filter_map(|(n, loss)| Some(counted(*loss) - counted(*there.get(n)?))).collect()
}

/// What a pixel counts for that is off by so much: no more than one that is off by as much as it is bright.
pub fn counted(loss: f64) -> f64 {
    loss.clamp(-1.0, 1.0)
}

/// The sum of independent differences in terms of its standard error, if their mean is next to nothing.
pub fn in_standard_errors(differences: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, squares) = differences.into_iter().fold((0.0, 0.0), |(sum, squares), d| (sum + d, squares + d * d));
    sum / f64::sqrt(squares).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_compared_with_themselves() {
        let here = [(7, 0.4), (2, 0.1), (5, 30.0)];
        assert_eq!(farther_off(&here, &[(5, 2.0), (2, 0.1), (9, 0.0), (7, 0.4)]), 0.0);
        assert!((farther_off(&here, &[(1, 0.0), (7, 0.1), (2, -0.2)]) - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(farther_off(&here, &[(1, 0.0)]), 0.0);
    }

    #[test]
    fn a_few_pixels_do_not_hide_what_all_others_say() {
        // Black where nothing tells them apart, and one that speaks against all others.
        let row = |off: f64, one: f64| -> Vec<(usize, f64)> {
            (0..100).map(|n| (n, if n < 60 { 0.0 } else { off })).chain([(100, one)]).collect()
        };
        let (here, there) = (row(0.01, 0.0), row(0.0, 1.0));
        assert!(farther_off(&here, &there) < -0.5);
        assert!((farther_off_alike(&here, &there) - (40.0 - MOST) / (40.0 + MOST * MOST).sqrt()).abs() < 1e-9);
        assert_eq!(farther_off_alike(&here, &here), 0.0);
    }
}
