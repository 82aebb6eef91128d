//! How many samples each pixel gets.
//!
//! Samples are worth most where the noise is: the error of the whole is least for a given number of samples if each pixel has samples in
//! proportion to its standard deviation (Neyman 1934). What that is, the first samples tell: of the neighbours, and of the pixel's other
//! sequence. No sample of a sequence decides how many the sequence will have, so the picture has no bias.

use super::{Pixel, Rendering, SETS, around};
use crate::color::bright;
use crate::sampling::mix64;
use rayon::prelude::*;

/// Samples of each pixel before its share is known. With fewer, small highlights are missed and the shares do harm (measured).
pub(super) const PILOT: u32 = 64;

/// The fewest samples of each pixel from which the error of a picture is told.
pub(super) const FEWEST: u32 = 16;

/// The least share of a pixel, in shares of the average that shows a surface: noise that was not seen yet must be found too, and what shows
/// no surface does not count for the error but is looked at.
const LEAST: f64 = 0.25;

/// The share of each sequence of each pixel in the samples, the average over pixels that show a surface being 1.
pub(super) fn shares(pixels: &[Pixel], width: usize) -> Vec<[f32; SETS]> {
    // The variance of a single sample of each sequence.
    let single = |pixel: &Pixel, set: usize| pixel.set_spread(set).1 * pixel.counts()[set] as f64;
    let single: Vec<[f64; SETS]> = pixels.par_iter().map(|p| std::array::from_fn(|set| single(p, set))).collect();
    let own_and_around = |number: usize| {
        let (mut around, mut count, mut surface) = (0.0, 0.0, false);
        for place in neighbours(number, width, pixels.len()) {
            around += single[place].iter().sum::<f64>() / SETS as f64;
            count += 1.0;
            surface |= pixels[place].surface;
        }
        let around = if count > 0.0 { around / count } else { 0.0 };
        std::array::from_fn(|set| if surface { around.max(single[number][(set + 1) % SETS]).sqrt() } else { 0.0 })
    };
    let deviations: Vec<[f64; SETS]> = (0..pixels.len()).into_par_iter().map(own_and_around).collect();
    let all = deviations.as_flattened();
    let mean = all.iter().sum::<f64>() / all.iter().filter(|&&d| d > 0.0).count().max(1) as f64;
    let share = |d: f64| if mean > 0.0 { (d / mean).max(LEAST) as f32 } else { 1.0 };
    deviations.iter().map(|d| d.map(share)).collect()
}

/// The pixels next to one.
fn neighbours(number: usize, width: usize, count: usize) -> impl Iterator<Item = usize> {
    around(number, [width, count / width], 1).filter(move |&place| place != number)
}

/// The number of samples of each sequence of a pixel at a level of `level` samples for an average share. Powers of two, at which the sequence
/// is most even; which pixels are ahead of others is spread over the picture, so that the whole grows as steadily as the level.
pub(super) fn wanted(shares: &[f32; SETS], level: f64, number: usize) -> [u32; SETS] {
    std::array::from_fn(|set| {
        let ahead = (mix64((SETS * number + set) as u64) >> 40) as f64 / (1u64 << 24) as f64;
        let doublings = ((shares[set] as f64 * level / SETS as f64).log2() + ahead).floor();
        (doublings.clamp(0.0, 19.0).exp2() as u32).max(PILOT / SETS as u32)
    })
}

/// An estimate of the error of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    /// The relative standard error, as [`Rendering::noise`] defines it.
    pub error: f64,
    /// The relative standard error of that, and of what it estimates: the true error of this picture is as much a matter of chance.
    pub doubt: f64,
}

/// The error of a picture, from the distance between the two independent sets of each pixel.
pub(super) fn noise(pixels: &[Pixel]) -> Noise {
    const { assert!(SETS == 2) };
    // Sums of the variance, of what it is about and the square of that; the count of pixels whose variance one sample cannot tell, and that of others left
    // to chance, with the sum of the variance of their samples; the sum of the light of what shows a surface, and its count; always in the same order.
    let sums = pixels.par_chunks(4096).map(|pixels| {
        let mut sums = [0.0; 8];
        for pixel in pixels.iter().filter(|p| p.surface && p.samples() > 0) {
            let (variance, spread) = (pixel.variance().1, pixel.spread().1);
            let each = variance * pixel.samples() as f64;
            let told = match (variance.is_finite(), spread.is_finite()) {
                _ if pixel.exact => [0.0; 6],
                (true, true) => [variance, spread, spread * spread, 0.0, 1.0, each],
                // The square of a squared normal number is three times that of its mean.
                (true, false) => [variance, variance, variance * variance / 3.0, 0.0, 1.0, each],
                (false, _) => [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            };
            let terms = told.into_iter().chain([bright(pixel.mean()), 1.0]);
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        sums
    });
    let sums: Vec<[f64; 8]> = sums.collect();
    let [told, about, squared, untold, random, each, light, shown] = std::array::from_fn(|i| sums.iter().map(|sums| sums[i]).sum::<f64>());
    // Pixels that there was no time for may show anything, and nothing is known of how single samples vary.
    if random == 0.0 && (untold > 0.0 || pixels.iter().any(|pixel| pixel.samples() == 0)) {
        return Noise { error: f64::INFINITY, doubt: 0.0 };
    }
    // Where time ended before a pixel's second sample, take the one it has to vary as those of other pixels do.
    let variance = if untold > 0.0 { told + untold * each / random } else { told };
    if variance == 0.0 {
        return Noise { error: 0.0, doubt: 0.0 };
    }
    // The variance of a squared normal number is twice its mean squared, and the true error varies as much; a root halves deviations.
    Noise { error: (variance / shown).sqrt() / (light / shown).abs(), doubt: squared.sqrt() / about }
}

/// The level at which a picture will be good enough, or the next one on the way there.
pub(super) fn next_level(rendering: &Rendering, level: f64, error: f64) -> f64 {
    // The error falls at least as the root of the number of samples; go there in steps, so that little is done in vain.
    let needed = (rendering.noise.error * (1.0 + CONFIDENCE * rendering.noise.doubt) / error).powi(2);
    level * (0.8 * needed).clamp(1.1, 2.0)
}

/// Whether the error is within what was asked for, with 95 % confidence.
pub(super) fn reached(noise: &Noise, error: f64) -> bool {
    noise.error * (1.0 + CONFIDENCE * noise.doubt) <= error
}

/// How many standard errors a normal variable stays within, on one side, in 95 of 100 cases.
const CONFIDENCE: f64 = 1.645;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;

    /// A pixel of samples uniform in [0, 1), whose mean is 1/2 and whose variance 1/12.
    fn uniform(number: u64, samples: u64) -> Pixel {
        let mut pixel = Pixel::default();
        pixel.surface = true;
        let value = |i| Rgb::splat(mix64(number << 32 | i) as f64 / 2f64.powi(64));
        (0..samples).for_each(|i| pixel.add(i as usize % SETS, value(i)));
        pixel
    }

    /// 8000 of them, of so many samples each.
    fn pixels(samples: &dyn Fn(u64) -> u64) -> Vec<Pixel> {
        (0..8000).map(|number| uniform(number, samples(number))).collect()
    }

    #[test]
    fn the_error_is_known_where_time_ended_before_the_second_sample_of_some_pixels() {
        let error = |samples: &dyn Fn(u64) -> u64| noise(&pixels(samples)).error;
        let truth = ((0.75 / 16.0 + 0.25) / 12.0f64).sqrt() / 0.5;
        let found = error(&|number| if number % 4 == 0 { 1 } else { 16 });
        assert!((found / truth - 1.0).abs() < 0.05, "{found} {truth}");
        assert_eq!(error(&|_| 1), f64::INFINITY);
        // What was not left to chance says nothing of what is.
        let exact = |samples: u64| {
            let mut pixels = pixels(&|number| if number % 2 == 0 { 1 } else { samples });
            pixels.iter_mut().step_by(2).for_each(|pixel| pixel.exact = true);
            noise(&pixels).error
        };
        assert_eq!(exact(1), f64::INFINITY);
        let (found, truth) = (exact(16), (0.5 / 16.0 / 12.0f64).sqrt() / 0.5);
        assert!((found / truth - 1.0).abs() < 0.05, "{found} {truth}");
    }

    #[test]
    fn pixels_of_few_samples_have_the_variance_of_those_and_others_theirs() {
        for few in [2, 3] {
            let rendering = Rendering::of(pixels(&|number| if number % 4 == 0 { u64::from(few) } else { 16 }));
            let mean = |count: u32| {
                let all = rendering.pixels.iter().zip(rendering.variances(80));
                let variances = all.filter(|(pixel, _)| pixel.samples() == count).map(|(_, variance)| variance.x);
                variances.clone().sum::<f64>() / variances.count() as f64
            };
            // Two sets of one sample and of two weigh alike.
            let truth = |count: u32| if count == 3 { 1.5 / 4.0 / 12.0 } else { 1.0 / (12.0 * f64::from(count)) };
            for count in [few, 16] {
                assert!((mean(count) / truth(count) - 1.0).abs() < 0.1, "{count}: {} for {}", mean(count), truth(count));
            }
            // The sum of 2000 squares of normal numbers is known to a relative √(2/2000).
            assert!(rendering.noise.doubt > 0.005 && rendering.noise.doubt < 0.05, "{:?}", rendering.noise);
        }
        assert!(noise(&pixels(&|_| 2)).doubt < 0.05);
    }
}
