//! Which of the light around its centre a pixel takes in.

use crate::rules::defaults::PIXEL_JITTER;
use crate::rules::rendered::Command;

/// How much light counts by where it is in a pixel or beside it: along both axes alike, a density in steps.
///
/// A camera integrates the area of a pixel, a box. RADIANCE's pictures are rendered larger and reduced by `pfilt`, which weighs the large pixels
/// by exp(−d²/r²) if it is told to (`-r`): half of the light of such a pixel comes from beside it, and is not the surface's roughness.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    /// The width of a step, in pixels.
    step: f64,
    /// The part of the light that counts up to the end of each step: rising, 1 at the last.
    sums: Vec<f64>,
}

/// Steps to a pixel where it is not known how much larger the picture was.
const FINE: f64 = 16.0;

impl Filter {
    /// All that falls on this part of a pixel's width and height counts alike: 1 is its area, 0 its centre.
    pub fn boxed(width: f64) -> Self {
        Self { step: width, sums: vec![1.0] }
    }

    /// What `pfilt -r` makes of a picture that was `larger` times as wide as its own: a Gaussian of this radius in pixels, cut off as there; a box
    /// for a radius of 0.
    pub fn gaussian(radius: f64, larger: Option<f64>) -> Self {
        if radius <= 0.0 {
            return Self::boxed(1.0);
        }
        let larger = larger.unwrap_or(FINE);
        let count = 2 * (2.0 * radius * larger) as usize + 2 + larger.round() as usize % 2;
        let square = |i: usize| (i as f64 + 0.5 - 0.5 * count as f64).powi(2);
        let width = (radius * larger).max(f64::MIN_POSITIVE);
        // The steps at the centre weigh 1, however narrow it is.
        let weight = |i: usize| ((square(count / 2) - square(i)) / width / width).exp();
        let whole: f64 = (0..count).map(weight).sum();
        let mut sum = 0.0;
        let sums = (0..count).map(|i| {
            sum += weight(i) / whole;
            sum
        });
        Self { step: larger.recip(), sums: sums.collect() }
    }

    /// The Gaussian of this variance along each axis, in pixels²: the centre alone for 0.
    pub fn blurring(variance: f64) -> Self {
        let unit = Self::gaussian(1.0, None);
        Self { step: unit.step * Self::radius(variance), ..unit }
    }

    /// The radius of the Gaussian of this variance.
    pub fn radius(variance: f64) -> f64 {
        (variance.max(0.0) / Self::gaussian(1.0, None).variance()).sqrt()
    }

    /// What the command lines in a picture's header say of its pixels; `None` if they say nothing.
    pub fn said<'a>(lines: impl IntoIterator<Item = &'a str>) -> Option<Self> {
        let (mut filter, mut width) = (None, None);
        for line in lines {
            let command = Command::of(line);
            let radius = |name: &str| command.given(name).filter(|radius| (0.0..=WIDEST).contains(radius));
            let jitter = || command.given("-pj").filter(|width| (0.0..=1.0).contains(width)).map(Self::boxed);
            let mut larger = None;
            match command.program() {
                "pfilt" if ["-x", "-y", "-r"].iter().any(|name| command.word(name).is_some()) => {
                    let times = command.times().or_else(|| Some(width? / command.given("-x")?));
                    larger = times.filter(|times| (1.0..=FINE).contains(times));
                    let as_large = filter.filter(|_| larger == Some(1.0));
                    filter = radius("-r").map(|radius| Self::gaussian(radius, larger)).or(as_large);
                }
                "rpict" => filter = jitter().or(Some(Self::boxed(PIXEL_JITTER))),
                "rtrace-rs" => filter = radius("--filter").map(|radius| Self::gaussian(radius, None)).or_else(jitter),
                _ => {}
            }
            width = larger.zip(width).map(|(times, width): (f64, f64)| width / times).or(command.given("-x")).or(width);
        }
        filter
    }

    /// So many pixels apart, those that take in light of their neighbours have hardly any in common: exp(−4) of a Gaussian's, and less.
    pub fn spacing(&self) -> usize {
        self.beyond().map_or(1, |variance| (4.0 * variance.sqrt()).ceil() as usize)
    }

    /// Its variance along each axis, in pixels².
    pub fn variance(&self) -> f64 {
        let middle = 0.5 * (self.sums.len() as f64 - 1.0);
        let steps = self.sums.iter().zip(std::iter::once(&0.0).chain(&self.sums)).enumerate();
        let square = steps.map(|(i, (to, from))| (to - from) * (i as f64 - middle).powi(2)).sum::<f64>();
        self.step.powi(2) * (square + 1.0 / 12.0)
    }

    /// The same, if it takes in more than the area of the pixel.
    pub fn beyond(&self) -> Option<f64> {
        (self.step * self.sums.len() as f64 > 1.0).then(|| self.variance())
    }

    /// Whether only the centre counts.
    pub fn is_point(&self) -> bool {
        self.step == 0.0
    }

    /// Where numbers in [0, 1] fall when all places are to be met as often as their light counts: in pixels, from one side of the pixel to the other
    /// as from 0 to 1.
    pub fn place(&self, at: [f64; 2]) -> [f64; 2] {
        at.map(|u| {
            let i = self.sums.partition_point(|sum| *sum <= u).min(self.sums.len() - 1);
            let before = if i > 0 { self.sums[i - 1] } else { 0.0 };
            0.5 + self.step * (i as f64 + (u - before) / (self.sums[i] - before) - 0.5 * self.sums.len() as f64)
        })
    }
}

/// The widest radius of a Gaussian, in pixels.
pub const WIDEST: f64 = 16.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gaussian_weighs_as_pfilt_does() {
        // What each column of a picture three times as wide adds to a pixel of `pfilt -1 -x /3 -y /3 -r .6` (pyradiance 1.3.1), from pixels
        // that shine one at a time. Its exponents are rounded, to twentieths and worse at the centre.
        let columns = [0.0023, 0.0194, 0.0911, 0.2334, 0.3077, 0.2334, 0.0911, 0.0194, 0.0023];
        let filter = Filter::gaussian(0.6, Some(3.0));
        assert_eq!(filter.sums.len(), columns.len());
        let mut before = 0.0;
        for (sum, column) in filter.sums.iter().zip(columns) {
            assert!((sum - before - column).abs() < 0.02 * column + 0.0001, "{} for {column}", sum - before);
            before = *sum;
        }
        let ends = [0.0, 1.0].map(|u| filter.place([u; 2])[0]);
        assert!((ends[0] + 1.0).abs() < 1e-9 && (ends[1] - 2.0).abs() < 1e-9, "{ends:?}");
    }

    #[test]
    fn places_have_the_variance_of_the_filter() {
        let of = |filter: &Filter| (0..4096).map(|i| (filter.place([(i as f64 + 0.5) / 4096.0; 2])[0] - 0.5).powi(2)).sum::<f64>() / 4096.0;
        for (filter, variance) in [(Filter::boxed(1.0), 1.0 / 12.0), (Filter::boxed(0.0), 0.0), (Filter::gaussian(0.6, None), 0.175)] {
            assert!((filter.variance() - variance).abs() <= 0.01 * variance, "{} for {variance}", filter.variance());
            assert!((of(&filter) - filter.variance()).abs() <= 1e-3 * variance);
        }
        assert_eq!(Filter::boxed(1.0).place([0.123, 0.9]), [0.123, 0.9]);
        assert_eq!(Filter::gaussian(0.0, None), Filter::boxed(1.0));
        for least in [1e-9, 1e-160, f64::from_bits(1)] {
            assert_eq!(Filter::gaussian(least, None), Filter { step: 0.0625, sums: vec![0.5, 1.0] });
        }
        assert!((Filter::blurring(0.2).variance() - 0.2).abs() < 1e-12 && (Filter::radius(0.5) - 1.0).abs() < 0.02);
        assert!(Filter::blurring(-0.1).is_point());
    }

    #[test]
    fn a_header_says_what_was_done_last() {
        let said = |lines: &[&str]| Filter::said(lines.iter().copied());
        let gaussian = |radius, larger| Some(Filter::gaussian(radius, larger));
        assert_eq!(said(&["rpict -x 960 -vf a.vf a.oct", "VIEW= -vp 0 0 0", "pfilt -1 -r .6 -x /3 -y /3"]), gaussian(0.6, Some(3.0)));
        assert_eq!(said(&["rpict -x 960 a.oct", "/usr/bin/pfilt -r 1 -x 480", "\tpcomb -s 2 a.hdr"]), gaussian(1.0, Some(2.0)));
        assert_eq!(said(&["pfilt -r .6 -x 480", "pfilt -1 -e +1"]), gaussian(0.6, None));
        assert_eq!(said(&["rtrace-rs --filter .7 -x 64 a.rad"]), gaussian(0.7, None));
        assert_eq!(said(&["rtrace-rs --filter=.7 -x 64 a.rad"]), gaussian(0.7, None));
        // What was not made smaller is what it was rendered as.
        for (lines, width) in [
            (&["rpict -x 96 a.oct", "pcomb -s 2 a.hdr"][..], Some(0.67)),
            (&["rpict -x 96 -pj 0 a.oct"], Some(0.0)),
            (&["rpict -x 96 -pj .9 a.oct", "pfilt -1 -x 96"], Some(0.9)),
            (&["rpict -x 96 a.oct", "pfilt -1 -x /2 -y /2"], None),
            (&["rtrace-rs -x 96 -pj .5 a.rad"], Some(0.5)),
            (&["rtrace-rs -x 96 a.rad"], None),
        ] {
            assert_eq!(said(lines), width.map(Filter::boxed), "{lines:?}");
        }
        // A box takes in the area of its pixels, however they were filtered.
        assert_eq!(said(&["pfilt -r .6 -x /2", "pfilt -x /4 -y /4"]), None);
        assert_eq!(said(&["rpict -x 960 a.oct", "pfilt -r x -x 480", "pfilt -r -1 -x 0", "pfilt -r"]), None);
    }
}
