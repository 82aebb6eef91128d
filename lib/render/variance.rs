//! The variance of each pixel.
//!
//! The two sequences of a pixel say it without bias, but from one difference. The groups say it from many, but as if they were independent, and samples
//! of a sequence are spread more evenly than that. What this gains depends on what a pixel shows (at the edge of a lamp up to five times as much as
//! beside it): those around say it.

use super::{GROUPS, Pixel, SETS, around};
use crate::color::Rgb;
use rayon::prelude::*;

/// So far away, across and down, others may show the like.
const REACH: usize = 2;

/// The fewest samples whose groups say how large a variance is well enough to divide by it.
const FEWEST: u32 = 8;

/// The estimated variance of the mean of each of these pixels in rows of `width`, of each channel: as its groups show it, times what the sequences gain
/// around it; of one with too few samples for groups, as its two sequences do. Infinite where there are fewer than two.
pub(super) fn variances(pixels: &[Pixel], width: usize) -> Vec<Rgb> {
    let size = [width, pixels.len() / width.max(1)];
    let told: Vec<Option<[f64; 2]>> = pixels.par_iter().map(told).collect();
    let variance = |number: usize| {
        let pixel = &pixels[number];
        let near = around(number, size, REACH).filter(|&n| (pixels[n].samples() < FEWEST) == (pixel.samples() < FEWEST));
        let [variance, spread] = near.filter_map(|n| told[n]).fold([0.0; 2], |sum, two| [0, 1].map(|i| sum[i] + two[i]));
        if told[number].is_some() { pixel.spread().0 * (variance / spread) } else { pixel.variance().0 }
    };
    (0..pixels.len()).into_par_iter().map(variance).collect()
}

/// What its two sequences say of a pixel's variance, and what its groups do: in terms of that where they have many samples, so that a bright one counts no
/// more than those beside it. `None` where groups say nothing, or that there is none.
fn told(pixel: &Pixel) -> Option<[f64; 2]> {
    let (variance, spread) = (pixel.variance().1, pixel.spread().1);
    // Over the squares of so many normal numbers the mean of a square is larger than its own (Fisher's distribution).
    let freedom = f64::from(pixel.samples().min(GROUPS as u32)) - SETS as f64;
    let whole = if pixel.samples() < FEWEST { [variance, spread] } else { [variance / spread * (freedom - 2.0) / freedom, 1.0] };
    (spread > 0.0 && spread.is_finite()).then_some(whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::mix64;

    /// A pixel of 32 samples of each sequence, uniform in [0, 1), whose mean is 1/2, times `bright`: independent, or each in a stratum of its own, so that
    /// the mean of a sequence has a variance 32² times less.
    fn pixel(number: u64, bright: f64, stratified: bool) -> Pixel {
        let mut pixel = Pixel::default();
        for i in 0..64 {
            let (place, random) = (i / SETS as u64, mix64(number << 32 | i) as f64 / 2f64.powi(64));
            let value = if stratified { (place as f64 + random) / 32.0 } else { random };
            pixel.add(i as usize % SETS, Rgb::splat(bright * value));
        }
        pixel
    }

    #[test]
    fn what_a_bright_edge_gains_is_not_taken_for_what_its_neighbours_do() {
        // Every twentieth column is a thousand times as bright, and stratified.
        let edge = |number: usize| number.is_multiple_of(20);
        let pixels: Vec<Pixel> = (0..8000).map(|n| pixel(n as u64, if edge(n) { 1000.0 } else { 1.0 }, edge(n))).collect();
        let variances = variances(&pixels, 80);
        let mean = |wanted: &dyn Fn(usize) -> bool| {
            let those: Vec<f64> = (0..8000).filter(|&n| wanted(n)).map(|n| variances[n].x).collect();
            those.iter().sum::<f64>() / those.len() as f64
        };
        let truth = 1.0 / (12.0 * 64.0);
        for (among, wanted) in [
            ("beside", &(|n: usize| (1..3).contains(&(n % 20))) as &dyn Fn(usize) -> bool),
            ("far", &|n: usize| (8..13).contains(&(n % 20))),
        ] {
            assert!((mean(wanted) / truth - 1.0).abs() < 0.2, "{among}: {} for {truth}", mean(wanted));
        }
        assert!(mean(&edge) < 0.5 * truth * 1e6, "{}", mean(&edge));
    }
}
