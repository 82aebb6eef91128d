//! Whether a recovery is enough, and what is worth more: more pixels, or more samples of those seen.
//!
//! With n pixels and e samples of each, the variance of a value is about (1 + k/e) (P + R/e) / n: the noise of the photograph and that of the
//! rendering are what the residuals are off by, and the rendering's noise in the derivative, by which they are judged, weakens that.

use super::doubts::{ASTRAY, TOGETHER, UNDETERMINED};
use super::sheet::COMMON;
use super::{Effort, Recovery};
use crate::anneal::Parameter;
use crate::unknown::ROUGHNESSES;

/// The standard error that satisfies when nothing is said: of a colour or a share, of an index of refraction, and of a roughness in terms
/// of itself, down to the last: what the paper reached.
const NEAR: f64 = 0.0018;
const NEAR_INDEX: f64 = 0.0004;
const NEAR_ROUGHNESS: f64 = 0.016;
const NEAREST_ROUGHNESS: f64 = 0.0002;

/// Or what the picture allows: the part of a variance that would be left whatever was sampled, where nothing is said and where too small an error
/// is asked for.
const LEFT: f64 = 0.5;
const ALL_LEFT: f64 = 0.8;

/// Of an error that pixels have in common, the part that hardly adds to it.
const LESS: f64 = 0.3;

/// How much of a derivative must not be noise for more pixels to be worth more than more samples of those seen. It must also be more than the
/// rendering's part o of the variance, which falls 1 − c + o times as fast with samples as with pixels.
const CLEAR: f64 = 0.25;
/// So many samples of each pixel in each half say what they can.
const DEEP: f64 = 192.0;
/// Where those are seen that tell most of a roughness, so many are worth more than other pixels.
const DEEPER: f64 = 400.0;
/// But once so many samples have said that the photograph's own noise is most of a variance, and leaves `FAR` times the one that satisfies, other pixels
/// are all that helps: where the roughness had seemed smaller than it is, a plastic bunny's stayed at .063 ± .006, for .08, and its colours at ± .001
/// instead of ± .0003.
const FEW: f64 = 96.0;
const FAR: f64 = 4.0;

/// What to take more of, and how many times as much as there is, as far as can be said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum More {
    /// Pixels, with as many samples each.
    Pixels(f64),
    /// Samples of the pixels seen.
    Samples(f64),
}

/// How a value stands.
#[derive(Clone, Copy, Debug)]
struct Need {
    /// Its variance, in terms of the one that satisfies.
    variance: f64,
    /// The part of it that the rendering makes.
    own: f64,
    /// How much of the derivative is not noise.
    clarity: f64,
    /// Whether the pixels that were foreseen to tell most of it are seen.
    foreseen: bool,
}

impl Need {
    /// The part of its variance that any number of samples would leave.
    fn left(&self) -> f64 {
        (1.0 - self.own) * self.clarity
    }

    /// How many times as many samples leave `part` of its variance: x = 1/that solves (c + (1 − c) x) (1 − o + o x) = `part`.
    fn samples(&self, part: f64) -> f64 {
        let Self { own, clarity, .. } = *self;
        let square = (1.0 - clarity) * own;
        let linear = clarity * own + (1.0 - clarity) * (1.0 - own);
        let rest = part - self.left();
        if rest > 0.0 { (linear + (linear * linear + 4.0 * square * rest).sqrt()) / (2.0 * rest) } else { f64::INFINITY }
    }
}

impl Effort<'_> {
    /// The standard error that satisfies for the parameter at place `i`.
    pub fn near(&self, i: usize, parameter: &Parameter, value: f64) -> f64 {
        let rate = (self.rate)(i, value).max(f64::MIN_POSITIVE);
        self.tolerance.map_or_else(
            || match parameter.name.as_str() {
                name if ROUGHNESSES.contains(&name) => (NEAR_ROUGHNESS * value.abs()).max(NEAREST_ROUGHNESS),
                "ior" => NEAR_INDEX,
                _ => NEAR / rate.max(1.0),
            },
            |tolerance| tolerance / rate,
        )
    }

    /// Of what is not determined, by itself or together with others, and of all where nothing explains the picture, the standard error that hardly adds
    /// to what an error that the pixels have in common makes; 0 of what is, and where a tolerance is asked for.
    fn open(&self, parameters: &[Parameter], found: &Recovery) -> Vec<f64> {
        let astray = found.misfit.areas >= ASTRAY;
        let off = if astray { found.misfit.areas / COMMON } else { 1.0 };
        let common: Vec<f64> = found.common.deviations().iter().map(|error| off * error).collect();
        let undetermined = |i: usize| common[i] * (self.rate)(i, found.values[i]) >= UNDETERMINED * parameters[i].anywhere();
        let correlations = found.common.correlations();
        let with = |i: usize| (0..common.len()).any(|j| undetermined(j) && (i == j || correlations.at(i, j).abs() >= TOGETHER));
        (0..common.len()).map(|i| if self.tolerance.is_none() && (astray || with(i)) { LESS * common[i] } else { 0.0 }).collect()
    }

    /// What would make a recovery as good as is wished for, or as the picture allows; `None` if it is. Seen are `seen` of `all` pixels, by `each`
    /// samples in each half; those among them that tell most of a roughness, if those were `foreseen`.
    pub fn more(&self, parameters: &[Parameter], found: &Recovery, [seen, all]: [f64; 2], each: f64, foreseen: bool) -> Option<More> {
        let open = self.open(parameters, found);
        let need = |(i, parameter): (usize, &Parameter)| {
            let (variance, near) = (found.covariance.at(i, i), self.near(i, parameter, found.values[i]).max(open[i]));
            let foreseen = foreseen && ROUGHNESSES.contains(&parameter.name.as_str());
            Need { variance: variance / near.powi(2), own: found.own_part(i), clarity: found.clarity[i], foreseen }
        };
        let allowed = |s: &Need| match self.tolerance {
            None => s.left() / LEFT,
            Some(_) if s.left() * s.variance < 1.0 => 0.0,
            Some(_) => s.left() / ALL_LEFT,
        };
        let lacks = |s: &Need| s.variance > 1.0 && (seen < all || allowed(s) < 1.0);
        let lacking: Vec<Need> = parameters.iter().enumerate().map(need).filter(lacks).collect();
        let worst = lacking.iter().max_by(|a, b| a.variance.total_cmp(&b.variance))?;
        let noisy = || each >= FEW && worst.left() > LEFT && worst.left() * worst.variance > FAR;
        let pixels = if worst.foreseen { each >= DEEPER || noisy() } else { worst.clarity > worst.own.max(CLEAR) || each >= DEEP };
        if seen < all && pixels {
            return Some(More::Pixels(worst.variance));
        }
        Some(More::Samples(lacking.iter().map(|s| s.samples(allowed(s).max(1.0 / s.variance))).fold(1.0, f64::max)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anneal::linear::Symmetric;
    use crate::recover::misfit::Misfit;

    fn effort(tolerance: Option<f64>) -> Effort<'static> {
        Effort::new(0, tolerance, &|| None)
    }

    /// A parameter, and what was found of it: this standard error, a part of it the rendering's `own`.
    fn asked(name: &str, error: f64, own: f64, clarity: f64) -> (Parameter, Recovery) {
        let own = Symmetric::diagonal(&[own * error * error]);
        let found = Recovery { own, clarity: vec![clarity], ..Recovery::plain(&[0.01], &[error]) };
        (Parameter { name: name.into(), start: 0.5, low: 0.0, high: 1.0 }, found)
    }

    /// What is wanted after a look at so many pixels of a thousand, by 40 samples each, of a colour with this standard error.
    fn wanted(seen: f64, error: f64, own: f64, clarity: f64, tolerance: Option<f64>) -> Option<More> {
        let (parameter, found) = asked("red", error, own, clarity);
        effort(tolerance).more(&[parameter], &found, [seen, 1000.0], 40.0, false)
    }

    #[test]
    fn what_the_photograph_lacks_no_samples_make_up_for() {
        assert_eq!(wanted(1000.0, 2.0 * NEAR, 0.2, 0.9, None), None);
        assert_eq!(wanted(1000.0, 0.9 * NEAR, 1.0, 0.1, None), None);
        // More pixels do, and more samples where a derivative is mostly noise or the error the rendering's.
        let Some(More::Pixels(times)) = wanted(500.0, 2.0 * NEAR, 0.2, 0.9, None) else { panic!() };
        assert!((times - 4.0).abs() < 1e-9, "{times}");
        for (seen, own, clarity) in [(500.0, 0.2, 0.1), (500.0, 0.9, 0.5), (1000.0, 0.9, 0.9), (1000.0, 0.1, 0.3)] {
            assert!(matches!(wanted(seen, 2.0 * NEAR, own, clarity, None), Some(More::Samples(times)) if times > 1.0));
        }
        // Where those pixels are seen that tell most of it, others are worth less.
        let foreseen = |name: &str, each: f64, error: f64| {
            let (parameter, found) = asked(name, error, 0.2, 0.9);
            effort(None).more(&[parameter], &found, [500.0, 1000.0], each, true)
        };
        assert!(matches!(foreseen("rough", 128.0, 1.9 * NEAREST_ROUGHNESS), Some(More::Samples(_))));
        assert!(matches!(foreseen("rough", DEEPER, 1.9 * NEAREST_ROUGHNESS), Some(More::Pixels(_))));
        assert!(matches!(foreseen("red", 64.0, 1.9 * NEAR), Some(More::Pixels(_))));
        // Unless it is the photograph's noise that is far too much.
        assert!(matches!(foreseen("rough", 64.0, 5.0 * NEAREST_ROUGHNESS), Some(More::Samples(_))));
        assert!(matches!(foreseen("rough", 128.0, 5.0 * NEAREST_ROUGHNESS), Some(More::Pixels(_))));
        // Where nothing is known, much is wanted.
        assert_eq!(wanted(1000.0, f64::INFINITY, 1.0, 0.9, None), Some(More::Samples(f64::INFINITY)));
        // Who asks for less gets it tried, until hardly anything is left to gain.
        assert!(matches!(wanted(1000.0, 2.0 * NEAR, 0.2, 0.9, Some(0.5 * NEAR)), Some(More::Samples(times)) if times > 1.0));
        assert_eq!(wanted(1000.0, 2.0 * NEAR, 0.1, 0.95, Some(0.5 * NEAR)), None);
        assert!(wanted(1000.0, 2.0 * NEAR, 0.1, 0.95, Some(1.9 * NEAR)).is_some());
    }

    #[test]
    fn what_nothing_explains_is_not_looked_at_for_long() {
        let wanted = |areas: f64, tolerance: Option<f64>| {
            let (parameter, found) = asked("red", 2.0 * NEAR, 0.9, 0.9);
            let found = Recovery { misfit: Misfit { areas, ..Misfit::default() }, common: Symmetric::diagonal(&[NEAR * NEAR]), ..found };
            effort(tolerance).more(&[parameter], &found, [500.0, 1000.0], 40.0, false)
        };
        assert!(wanted(0.05, None).is_some() && wanted(0.2, Some(NEAR)).is_some());
        assert_eq!(wanted(0.2, None), None);
    }

    #[test]
    fn so_many_more_samples_leave_what_is_asked() {
        for (own, clarity, part) in [(0.5, 0.5, 0.5), (1.0, 0.3, 0.1), (0.2, 1.0, 0.9), (0.0, 0.4, 0.7), (0.9, 0.9, 0.95)] {
            let need = Need { variance: 1.0, own, clarity, foreseen: false };
            let x = 1.0 / need.samples(part);
            let left = (clarity + (1.0 - clarity) * x) * (1.0 - own + own * x);
            assert!((left - part).abs() < 1e-12, "{need:?}: {left} for {part}");
        }
        // Less than no noise is not to be had.
        assert_eq!(Need { variance: 1.0, own: 0.5, clarity: 0.5, foreseen: false }.samples(0.25), f64::INFINITY);
    }
}
