//! What is known of a pixel: exact sums of its samples, and from them its radiance and the variance of that.

use super::Budget;
use crate::color::{Rgb, bright};
use crate::integrator::Outcome;
use crate::sampling::Sampler;
use std::ops::Range;
use std::time::Instant;

/// The number of sums that the samples of a pixel are dealt to, in turn.
pub const GROUPS: usize = 16;

/// The number of sequences, scrambled independently, that the samples of a picture's pixel are dealt to, in turn. One would need the fewest
/// samples and say nothing of its error; with sixteen it took up to 2.4 times as many samples for the same error (measured).
pub const SETS: usize = 2;

/// The most samples of a pixel that has an error of its own to reach.
pub(super) const MOST: u32 = 1 << 20;

/// The fewest such samples of a ray that is left to chance: fewer may all miss what matters.
const FEWEST: u32 = 4 * GROUPS as u32;

/// Whether it is time, after so many samples, to ask whether a ray is near enough: not before [`FEWEST`], and as often while they double.
fn is_rung(samples: u32) -> bool {
    let step = (samples / RUNGS).checked_ilog2().map_or(1, |log| 1 << log).max(GROUPS as u32);
    samples >= FEWEST && samples.is_multiple_of(step)
}

/// How often it is asked while samples double.
const RUNGS: u32 = 4;

/// What the groups of one sequence say of a variance is in doubt itself, and it is asked again and again: with so many times as much the error of rays
/// is what was asked for (of the skewed light of the test below .104, .053 and .020, where .1, .05 and .02 are).
const DOUBT: f64 = 2.0;

/// What is known of a pixel: sums of its samples, sample `i` in sum `i` modulo [`GROUPS`], so that each sequence has sums of its own. They are
/// exact: the same in whatever order, and in however many parts, the samples were added. Each sequence counts as much as the other, however
/// many samples it has: so one may decide for the other how many these are, and nothing is biased.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pixel {
    /// The sums, as near as one number is.
    sums: [[f64; 3]; GROUPS],
    /// What the sums leave out: which of them (three to a group), and the rest or a part of it.
    rest: Vec<(u8, f64)>,
    /// The place of the first sample in each sequence.
    first: [u32; SETS],
    /// The number of samples of each sequence.
    counts: [u32; SETS],
    /// Whether a sample met a surface.
    pub surface: bool,
    /// Whether the pixel is exact: no sample was left to chance.
    pub(super) exact: bool,
}

/// How many of the first `samples` samples of a pixel are of each sequence.
pub(super) fn dealt(samples: u32) -> [u32; SETS] {
    std::array::from_fn(|set| samples / SETS as u32 + u32::from(set < samples as usize % SETS))
}

impl Pixel {
    /// A pixel whose first sample is the one with this index.
    pub(super) fn from(first: u32) -> Self {
        Self { first: dealt(first), ..Self::default() }
    }

    /// A pixel of which other samples were taken by another.
    pub(super) fn taken(samples: &Range<u32>, surface: bool, exact: bool) -> Self {
        let (first, end) = (dealt(samples.start), dealt(if exact { samples.start + 1 } else { samples.end }));
        let counts = std::array::from_fn(|set| end[set] - first[set]);
        Self { first, counts, surface, exact, ..Self::default() }
    }

    /// Takes samples until the pixel by itself is what the budget asks for. `pixel` is its number; `sample` gives the light of one sample.
    /// All [`GROUPS`] are scrambled independently here: nothing else tells the error.
    pub fn converged(budget: Budget, seed: u64, pixel: u64, mut sample: impl FnMut(Sampler) -> (Rgb, Outcome)) -> Self {
        let start = matches!(budget, Budget::Time(_)).then(Instant::now);
        // All samples, and those that count once they are others: of each sequence, until the other one says that it is enough. One that decided for
        // itself would end where it is too bright by chance.
        let (mut seen, mut counted) = (Self::default(), None::<Self>);
        let mut open = [true; SETS];
        let mut exact = false;
        while !exact && open.contains(&true) {
            let place = seen.samples() as usize;
            let set = place % SETS;
            let (light, outcome) = sample(Sampler::new(seed, pixel, (place % GROUPS) as u32, (place / GROUPS) as u32));
            for pixel in [Some(&mut seen), counted.as_mut().filter(|_| open[set])].into_iter().flatten() {
                pixel.add(set, light);
                pixel.surface |= outcome.surface;
            }
            exact = !outcome.random;
            let taken = seen.samples();
            match budget {
                Budget::Samples(samples) => open = [taken < samples; SETS],
                Budget::Time(time) => open = [start.is_some_and(|start| start.elapsed() < time); SETS],
                Budget::Error(error) if is_rung(taken) => {
                    (0..SETS).for_each(|set| open[set] &= taken < MOST && !seen.is_near((set + 1) % SETS, error));
                    if open.contains(&false) && counted.is_none() {
                        counted = Some(seen.clone());
                    }
                }
                Budget::Error(_) => {}
            }
        }
        Self { exact, ..counted.unwrap_or(seen) }
    }

    /// Whether a sequence by itself says that a whole of as many samples of each is within a relative error.
    fn is_near(&self, set: usize, error: f64) -> bool {
        let mean = self.groups(set).map(|(sum, _)| sum).sum::<Rgb>() / self.counts[set] as f64;
        DOUBT * self.set_spread(set).1 <= SETS as f64 * (error * bright(mean)).powi(2)
    }

    /// How many samples were taken.
    pub fn samples(&self) -> u32 {
        self.counts.iter().sum()
    }

    /// How many samples each sequence has.
    pub(super) fn counts(&self) -> [u32; SETS] {
        self.counts
    }

    /// The place in its sequence of the next sample of one.
    pub(super) fn next(&self, set: usize) -> u32 {
        self.first[set] + self.counts[set]
    }

    /// Adds the next sample of a sequence.
    pub(super) fn add(&mut self, set: usize, value: Rgb) {
        let group = (self.next(set) as usize * SETS + set) % GROUPS;
        for (channel, value) in value.to_array().into_iter().enumerate() {
            // Few bits to a sample leave room in the sum for many of them.
            self.add_to(3 * group + channel, value as f32 as f64);
        }
        self.counts[set] += 1;
    }

    /// Adds other samples of the same pixel. Which ones a pixel has must be without a gap in the end.
    pub(super) fn append(&mut self, other: &Self) {
        // Of an exact pixel, one sample says all.
        if !(self.exact && self.samples() > 0) {
            other.parts().for_each(|(sum, value)| self.add_to(sum, value));
            self.counts.iter_mut().zip(other.counts).for_each(|(count, more)| *count += more);
        }
        self.surface |= other.surface;
        self.exact |= other.exact;
    }

    /// Adds to one of the sums, without rounding.
    pub(super) fn add_to(&mut self, sum: usize, value: f64) {
        let at = &mut self.sums[sum / 3][sum % 3];
        let mut off;
        (*at, off) = two_sum(*at, value);
        if off == 0.0 {
            return;
        }
        for (_, part) in self.rest.iter_mut().filter(|(s, _)| *s as usize == sum) {
            (*part, off) = two_sum(*part, off);
        }
        if off != 0.0 {
            self.rest.push((sum as u8, off));
        }
    }

    /// The numbers that add up to each sum.
    pub(super) fn parts(&self) -> impl Iterator<Item = (usize, f64)> {
        let rest = self.rest.iter().map(|&(sum, part)| (sum as usize, part));
        self.sums.as_flattened().iter().copied().enumerate().chain(rest)
    }

    /// The sums of each group, rounded once.
    fn rounded(&self) -> [Rgb; GROUPS] {
        let mut sums = self.sums;
        let mut last = usize::MAX;
        for (sum, _) in &self.rest {
            let sum = *sum as usize;
            if sum != last {
                let rest = self.rest.iter().filter(|(s, _)| *s as usize == sum).map(|(_, part)| *part);
                sums[sum / 3][sum % 3] = round(self.sums[sum / 3][sum % 3], rest);
                last = sum;
            }
        }
        sums.map(Rgb::from)
    }

    /// The sum and the number of samples of each group of a sequence.
    fn groups(&self, set: usize) -> impl Iterator<Item = (Rgb, f64)> + Clone + use<> {
        let sums = self.rounded();
        let (first, end) = (self.first[set], self.next(set));
        (set..GROUPS).step_by(SETS).enumerate().map(move |(place, group)| {
            let before = |end: u32| end.saturating_sub(place as u32).div_ceil((GROUPS / SETS) as u32);
            (sums[group], (before(end) - before(first)) as f64)
        })
    }

    /// The mean of each sequence that has samples.
    fn means(&self) -> impl Iterator<Item = Rgb> + Clone {
        let sums = self.rounded();
        let sampled = (0..SETS).filter(|&set| self.counts[set] > 0);
        sampled.map(move |set| sums.iter().skip(set).step_by(SETS).sum::<Rgb>() / self.counts[set] as f64)
    }

    /// The estimated radiance.
    pub fn mean(&self) -> Rgb {
        let sampled = self.counts.iter().filter(|&&count| count > 0).count();
        self.means().sum::<Rgb>() / sampled.max(1) as f64
    }

    /// The estimated variance of [`Pixel::mean`] in a picture, of each channel and of the luminance, by the distance of its independent
    /// [`SETS`]: unbiased, but from one difference. Infinite while there are fewer than two samples.
    pub fn variance(&self) -> (Rgb, f64) {
        if self.exact {
            return (Rgb::ZERO, 0.0);
        }
        deviation(self.means().map(|mean| (mean, 1.0)))
    }

    /// The estimated variance of [`Pixel::mean`] if all groups were independent, of each channel and of the luminance: what it is for a ray by
    /// itself. In a picture, where groups share sequences, mostly too large. Infinite while there are too few samples to tell.
    pub fn spread(&self) -> (Rgb, f64) {
        let [(a, luminance_a), (b, luminance_b)] = std::array::from_fn(|set| self.set_spread(set));
        ((a + b) / 4.0, (luminance_a + luminance_b) / 4.0)
    }

    /// The same for the mean of one sequence.
    pub(super) fn set_spread(&self, set: usize) -> (Rgb, f64) {
        if self.exact {
            return (Rgb::ZERO, 0.0);
        }
        deviation(self.groups(set))
    }
}

/// The variance of the mean of all samples, and of its luminance, from the sums of some independent groups of them and their counts.
fn deviation(groups: impl Iterator<Item = (Rgb, f64)> + Clone) -> (Rgb, f64) {
    let groups = groups.filter(|(_, n)| *n > 0.0);
    let count = groups.clone().count();
    if count < 2 {
        return (Rgb::splat(f64::INFINITY), f64::INFINITY);
    }
    let total: f64 = groups.clone().map(|(_, n)| n).sum();
    let mean = groups.clone().map(|(sum, _)| sum).sum::<Rgb>() / total;
    let (mut channels, mut luminance) = (Rgb::ZERO, 0.0);
    for (sum, n) in groups {
        let off = sum / n - mean;
        channels += off * off * n;
        luminance += bright(off).powi(2) * n;
    }
    let scale = 1.0 / ((count - 1) as f64 * total);
    (channels * scale, luminance * scale)
}

/// A sum, and what it leaves out (Knuth 1969, theorem 4.2.2 B). Beyond what numbers can hold nothing is left out.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    let off = (a - (sum - part)) + (b - part);
    (sum, if off.is_finite() { off } else { 0.0 })
}

/// The number nearest to a sum of numbers (Shewchuk 1997, "Adaptive precision floating-point arithmetic", grow-expansion; rounded as Python's
/// `fsum` does).
fn round(first: f64, rest: impl Iterator<Item = f64>) -> f64 {
    // Parts that do not overlap, the smallest first.
    let mut parts = vec![first];
    for mut value in rest {
        let mut kept = 0;
        for i in 0..parts.len() {
            let (sum, off) = two_sum(value, parts[i]);
            if off != 0.0 {
                parts[kept] = off;
                kept += 1;
            }
            value = sum;
        }
        parts.truncate(kept);
        parts.push(value);
    }
    let mut sum = parts.pop().unwrap_or(0.0);
    while let Some(part) = parts.pop() {
        let off;
        (sum, off) = two_sum(sum, part);
        if off != 0.0 {
            // Half a step goes the way of what is below it.
            if let Some(below) = parts.last()
                && (*below > 0.0) == (off > 0.0)
            {
                let further = sum + 2.0 * off;
                if further - sum == 2.0 * off {
                    return further;
                }
            }
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::mix64;

    /// Values of all sizes, of both signs.
    fn value(i: u32) -> Rgb {
        let random = |k: u64| mix64(3 * i as u64 + k);
        Rgb::from([0, 1, 2].map(|k| {
            let r = random(k);
            (r as i64 as f64 / i64::MAX as f64) * 2f64.powi((r % 120) as i32 - 60)
        }))
    }

    fn sum(range: std::ops::Range<u32>) -> Pixel {
        let mut pixel = Pixel::from(range.start);
        range.for_each(|i| pixel.add(i as usize % SETS, value(i)));
        pixel
    }

    #[test]
    fn sums_are_the_same_in_however_many_parts() {
        let whole = sum(0..1000);
        assert!(!whole.rest.is_empty());
        for cuts in [[0, 1, 2, 1000], [0, 500, 777, 1000], [0, 16, 999, 1000]] {
            let mut joined = Pixel::default();
            cuts.windows(2).for_each(|cut| joined.append(&sum(cut[0]..cut[1])));
            assert_eq!((joined.rounded(), joined.samples()), (whole.rounded(), 1000));
            assert_eq!((joined.mean(), joined.variance(), joined.spread()), (whole.mean(), whole.variance(), whole.spread()));
        }
    }

    #[test]
    fn sequences_share_any_number_of_samples() {
        assert_eq!(dealt(SETS as u32 + 1)[..2], [2, 1]);
        let all = dealt(u32::MAX);
        assert_eq!(all.iter().map(|&n| u64::from(n)).sum::<u64>(), u64::from(u32::MAX));
        assert!(all.windows(2).all(|two| two[0] == two[1] || two[0] == two[1] + 1));
    }

    #[test]
    fn rays_that_end_where_they_are_near_are_not_too_bright() {
        // Mostly dark, sometimes bright: the product of two exponential variables.
        let sample = |mut sampler: Sampler| {
            let light = sampler.pair().map(|u| (1.0 - u).ln()).iter().product();
            (Rgb::splat(light), Outcome { surface: true, random: true })
        };
        let found = |ray| Pixel::converged(Budget::Error(0.1), 1, ray, sample).mean().x;
        let rays = 4000;
        let values: Vec<f64> = (0..rays).map(found).collect();
        let mean = values.iter().sum::<f64>() / rays as f64;
        let off = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / rays as f64).sqrt();
        assert!((mean - 1.0).abs() < 3.0 * off / (rays as f64).sqrt(), "{mean}");
        assert!(off < 0.11, "{off}");
    }

    #[test]
    fn sums_are_rounded_once() {
        // Each sum as Python's math.fsum gives it.
        assert_eq!(round(1e100, [1.0, -1e100].into_iter()), 1.0);
        assert_eq!(round(1.0, [2f64.powi(-53), 2f64.powi(-120)].into_iter()), 1.0 + f64::EPSILON);
        assert_eq!(round(1.0, [2f64.powi(-53), -2f64.powi(-120)].into_iter()), 1.0);
        assert_eq!(round(0.1, std::iter::repeat_n(0.1, 9)), 1.0);
        let mut pixel = Pixel::default();
        pixel.add_to(0, f64::INFINITY);
        pixel.add_to(0, 1.0);
        assert_eq!(pixel.rounded()[0].x, f64::INFINITY);
    }

    #[test]
    fn the_variance_is_that_of_the_mean() {
        // Of n numbers uniform in [0, 1) the mean has the variance 1/(12 n); the average over 4000 pixels is within 5 of its standard errors.
        let (n, pixels) = (36, 4000u32);
        let (mut halves, mut spread) = (0.0, 0.0);
        for p in 0..pixels {
            let mut pixel = Pixel::default();
            (0..n).for_each(|i| pixel.add(i as usize % SETS, Rgb::splat(mix64(((p as u64) << 32) + i) as f64 / 2f64.powi(64))));
            halves += pixel.variance().0.x / pixels as f64;
            spread += pixel.spread().0.x / pixels as f64;
        }
        let truth = 1.0 / (12.0 * n as f64);
        assert!((halves / truth - 1.0).abs() < 5.0 * (2.0 / pixels as f64).sqrt(), "{}", halves / truth);
        assert!((spread / truth - 1.0).abs() < 5.0 * (2.0 / 14.0 / pixels as f64).sqrt(), "{}", spread / truth);
    }
}
