//! Which type of material it is: recoveries of one picture as several types, compared pixel by pixel.
//!
//! Vuong's test (1989, equation 3.1) for models that are not nested: the difference of their losses, pixel by pixel, is measured by its own
//! scatter. Pixels go together with their neighbours, so they are summed by blocks first.

use super::model::{Kind, parts};
use super::words::list;
use super::{Evidence, Recovery, tile};
use crate::anneal::Parameter;
use crate::unknown::Unknown;
use std::collections::{BTreeMap, HashMap};

/// A loss as small as this is that of a perfect photograph: 1 % in each channel.
const MISFIT: f64 = 3e-4;
/// The largest side of a block, in pixels; and about how many blocks there are at least where there are as many pixels: few pixels are compared
/// in smaller ones.
const BLOCK: usize = 8;
const BLOCKS: f64 = 24.0;
/// A type is excluded when another is better by so many standard errors.
const EXCLUDED: f64 = 2.0;
/// And by so many where both may well say the same: in light that is the same from everywhere, a plastic was farther off than a metal by up to 5.
const CLEARLY: f64 = 6.0;
/// By so many it surely is, however few pixels say so; and by no more may one be worse that surely is not.
const SURE: f64 = 4.0;
const NEAR: f64 = 1.0;
/// Coefficients are the same when they differ by less than so many standard errors, taken between two limits; surely so below another one.
const SAME: f64 = 3.0;
const SAME_WITHIN: (f64, f64) = (0.003, 0.02);
const SURELY_WITHIN: f64 = 0.01;

/// The picture recovered as one type.
pub struct Trial {
    /// The type.
    pub kind: String,
    /// How many parameters were free.
    pub free: usize,
    /// What was found.
    pub recovery: Recovery,
    /// What it reflects and transmits: coefficients with their variances; `None` for what does so by an index of refraction.
    lobes: Option<Vec<(f64, f64)>>,
}

/// What another type than the chosen one is to be thought of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rival {
    /// It says the same in other numbers.
    Same,
    /// It says something else, and the picture does not tell which is right.
    Open,
    /// The picture excludes it, by so many standard errors.
    Excluded(f64),
}

/// Which type it is, and what there is to think of the others.
pub struct Verdict {
    /// The place of the chosen type among the trials.
    pub chosen: usize,
    /// Each type that was tried, and what it is beside the chosen one, which is the same as itself.
    pub rivals: Vec<(String, Rival)>,
    /// Of which of them more pixels would hardly say otherwise.
    pub sure: Vec<bool>,
}

impl Trial {
    /// What `unknown` was recovered as.
    pub fn new(unknown: &Unknown, recovery: Recovery) -> Self {
        let kind = unknown.material().kind.clone();
        let lobes = Kind::named(&kind).map(|kind| {
            let numbers = |values: &[f64]| lobes(kind, &unknown.reals(values));
            let at = numbers(&recovery.values);
            let bounds = unknown.parameters().iter().map(Parameter::range);
            let slopes: Vec<Vec<f64>> = bounds
                .enumerate()
                .map(|(i, range)| {
                    let moved = |by: f64| {
                        let mut values = recovery.values.clone();
                        values[i] += by * 1e-4 * range;
                        numbers(&values)
                    };
                    moved(0.5).iter().zip(moved(-0.5)).map(|(a, b)| (a - b) / (1e-4 * range)).collect()
                })
                .collect();
            let variance = |k: usize| recovery.covariance.form(&slopes.iter().map(|s| s[k]).collect::<Vec<_>>());
            // Of what nothing is known, nothing is known of what it makes.
            let known = |variance: f64| if variance.is_nan() { f64::INFINITY } else { variance };
            at.iter().enumerate().map(|(k, &value)| (value, known(variance(k)))).collect()
        });
        Self { kind, free: unknown.parameters().len(), recovery, lobes }
    }

    /// Whether it can say all that another can, so that it cannot be excluded by it.
    fn contains(&self, other: &Self) -> bool {
        let (Some(mine), Some(others)) = (Kind::named(&self.kind), Kind::named(&other.kind)) else { return false };
        let parts = mine.metal == others.metal && mine.transmits == others.transmits || mine.transmits && !others.metal;
        parts && (mine.anisotropic || !others.anisotropic)
    }

    /// Whether it reflects and transmits the same as another, as far as both are sure.
    fn same(&self, other: &Self) -> bool {
        self.same_within(other, SAME_WITHIN.1)
    }

    /// The same, coefficients differing by no more than `most`. Two roughnesses are not the same as one however little they show: whether they
    /// are needed the pixels say.
    fn same_within(&self, other: &Self, most: f64) -> bool {
        let (Some(mine), Some(others)) = (&self.lobes, &other.lobes) else { return false };
        let near = |(a, b): (&(f64, f64), &(f64, f64))| {
            let error = SAME * (a.1 + b.1).max(0.0).sqrt();
            (a.0 - b.0).abs() < error.clamp(SAME_WITHIN.0, most)
        };
        self.kind.ends_with('2') == other.kind.ends_with('2') && mine.iter().zip(others).all(near)
    }
}

/// What a rough material does to light, in numbers that mean the same for each type: the coefficients of its parts, and the width of its
/// lobe as far as it shows.
fn lobes(kind: Kind, a: &[f64]) -> Vec<f64> {
    let parts = parts(kind, a);
    let shows: f64 = [parts[2], parts[3]].iter().flatten().sum::<f64>() / 6.0;
    parts.into_iter().flatten().chain(std::iter::once(a[4].abs() * shows)).collect()
}

/// How many pixels are compared, in whole blocks, evenly spread: few tell most pictures' type, more are taken where they do not.
pub const SAMPLES: [usize; 2] = [600, 2500];

/// Which pixels are compared.
pub struct Sample {
    /// How much each pixel of the film counts: those that are not compared do not.
    pub mask: Vec<f32>,
    /// The block of each pixel that is.
    blocks: HashMap<usize, usize>,
}

impl Sample {
    /// A sample of about so many of the pixels that show the unknown, as [`Evidence::enough_pixels`] found them.
    pub fn of(evidence: &Evidence, pixels: &[usize], about: usize) -> Self {
        let width = evidence.film.width;
        let side = ((pixels.len().min(about) as f64 / BLOCKS).sqrt() as usize).clamp(1, BLOCK);
        let pixels = kept(pixels, width, about, side);
        let mut mask = vec![0.0; width * evidence.film.height];
        pixels.iter().for_each(|&n| mask[n] = evidence.mask.map_or(1.0, |mask| mask[n]));
        Self { mask, blocks: pixels.iter().map(|&n| (n, tile(n, width, side))).collect() }
    }
}

/// The pixels of some blocks of that side, about so many; all if they are few.
fn kept(pixels: &[usize], width: usize, about: usize, side: usize) -> Vec<usize> {
    let mut blocks: Vec<usize> = pixels.iter().map(|&n| tile(n, width, side)).collect();
    blocks.sort_unstable();
    blocks.dedup();
    // Multiples of the golden ratio leave no pattern that the picture could have too.
    let share = about as f64 / pixels.len() as f64;
    let counts = |n: &usize| (blocks.binary_search(&tile(*n, width, side)).unwrap_or(0) as f64 * 0.618_033_988_749_895).fract() < share;
    pixels.iter().copied().filter(counts).collect()
}

/// Which of the trials of a sample the picture supports best: of those that none excludes the simplest, of the nearest's kind where none explains it, but
/// with two roughnesses if that is tried.
///
/// # Panics
/// Without any trial.
pub fn choose(trials: &[Trial], sample: &Sample) -> Verdict {
    let loss = |t: &Trial| t.recovery.loss();
    let distance = |i: usize, from: usize| if i == from { 0.0 } else { vuong(&trials[i], &trials[from], &sample.blocks) };
    // A pixel or two that are mostly noise may make a sum of losses what it is: the best is the one that none is much better than.
    let behind = |i: usize| (0..trials.len()).map(|j| distance(i, j)).fold(0.0, f64::max);
    let best = (0..trials.len()).min_by(|&a, &b| behind(a).total_cmp(&behind(b)).then(loss(&trials[a]).total_cmp(&loss(&trials[b]))));
    let best = best.expect("there is a trial");
    let open: Vec<usize> = (0..trials.len()).filter(|&i| distance(i, best) < EXCLUDED || trials[i].same(&trials[best])).collect();
    // Of those that say the same the first counts; then the simplest; then the nearest.
    let first = |i: usize| open.iter().copied().find(|&j| j == i || trials[j].same(&trials[i])).unwrap_or(i);
    // Where none explains the picture, another kind of thing may be simpler, and explain it least.
    let kin = |i: &usize| trials[best].recovery.explained() || *i == best || trials[best].contains(&trials[*i]);
    let chosen = open.iter().map(|&i| first(i)).filter(kin).min_by(|&a, &b| {
        let nearer = loss(&trials[a]).total_cmp(&loss(&trials[b]));
        trials[a].free.cmp(&trials[b].free).then(nearer)
    });
    let chosen = chosen.unwrap_or(best);
    // START.rad has two roughnesses for a reason.
    let chosen = open.iter().copied().find(|&i| trials[i].kind.strip_suffix('2') == Some(&trials[chosen].kind)).unwrap_or(chosen);
    // What can say more than another is never farther off, and few samples may not have found the best of each.
    let spared = |i: usize| distance(i, best) < CLEARLY && trials[best].same_within(&trials[i], f64::INFINITY);
    let rival = |i: usize| {
        // One that can say all that the chosen one does says the same, unless that explains the picture less well, or it surely says something else.
        let explained = || distance(chosen, i) < NEAR && trials[chosen].recovery.explained();
        let includes = || trials[i].contains(&trials[chosen]) && explained() && trials[i].same_within(&trials[chosen], f64::INFINITY);
        let same = i == chosen || trials[i].same(&trials[chosen]) || includes();
        match distance(i, best) {
            _ if same => Rival::Same,
            z if z < EXCLUDED && trials[chosen].contains(&trials[i]) => Rival::Same,
            z if !spared(i) && z >= EXCLUDED => Rival::Excluded(distance(i, chosen).max(EXCLUDED)),
            _ => Rival::Open,
        }
    };
    let rivals: Vec<(String, Rival)> = (0..trials.len()).map(|i| (trials[i].kind.clone(), rival(i))).collect();
    let near = distance(chosen, best) < NEAR;
    let surely = |i: usize| match rivals[i].1 {
        Rival::Same => {
            let (one, other) = (&trials[i], &trials[chosen]);
            i == chosen || one.same_within(other, SURELY_WITHIN) || one.contains(other) && near
        }
        other => other.is_out(),
    };
    let sure = (0..trials.len()).map(surely).collect();
    Verdict { chosen, rivals, sure }
}

/// By how many standard errors `a` is worse than `b`: the logarithm of the ratio of their likelihoods, by its own standard error. The scatter of
/// the misfits is what each finds it to be, block by block, or a few glints would decide.
fn vuong(a: &Trial, b: &Trial, blocks: &HashMap<usize, usize>) -> f64 {
    let others: HashMap<usize, f64> = b.recovery.losses.iter().copied().collect();
    let mut sums = BTreeMap::<usize, [f64; 3]>::new();
    for (number, loss) in &a.recovery.losses {
        if let (Some(other), Some(block)) = (others.get(number), blocks.get(number)) {
            let sum = sums.entry(*block).or_default();
            [*loss, *other, 1.0].iter().zip(sum).for_each(|(term, sum)| *sum += term);
        }
    }
    let scatter = |loss: f64, count: f64| (loss / count).max(0.0) + MISFIT;
    let ratios: Vec<(f64, f64)> = sums.values().map(|&[a, b, n]| (n, (scatter(a, n) / scatter(b, n)).ln())).collect();
    let count: f64 = ratios.iter().map(|(n, _)| n).sum();
    let mean = ratios.iter().map(|(n, r)| n * r).sum::<f64>() / count.max(1.0);
    // As many blocks of one size would tell as much.
    let blocks = count * count / ratios.iter().map(|(n, _)| n * n).sum::<f64>().max(1.0);
    let freedom = blocks - 1.0;
    let squares = ratios.iter().map(|(n, r)| (n * (r - mean)).powi(2)).sum::<f64>();
    normal(mean * count * (freedom.max(0.0) / (blocks * squares).max(f64::MIN_POSITIVE)).sqrt(), freedom)
}

/// The number of standard errors that is as rare in the normal distribution as `t` is in Student's of so many degrees of freedom: few blocks
/// tell their own scatter badly (Wallace 1959).
fn normal(t: f64, freedom: f64) -> f64 {
    let corrected = (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0);
    if freedom > 0.0 { t.signum() * corrected * (freedom * (t * t / freedom).ln_1p()).sqrt() } else { 0.0 }
}

impl Rival {
    /// Whether it surely is another type.
    pub fn is_out(&self) -> bool {
        matches!(self, Self::Excluded(z) if *z >= SURE)
    }
}

impl Verdict {
    /// The type that was chosen.
    pub fn kind(&self) -> &str {
        &self.rivals[self.chosen].0
    }

    /// Whether more pixels would hardly say otherwise of any.
    pub fn is_sure(&self) -> bool {
        self.sure.iter().all(|sure| *sure)
    }

    /// What is to be said of it, on a line: `type plastic (as good: metal, the same reflectance); glass excluded by 12 standard errors`.
    pub fn title(&self) -> String {
        let kinds = |rival: Rival, what: &str| -> Vec<String> {
            let others = self.rivals.iter().enumerate().filter(|(i, (_, s))| *i != self.chosen && *s == rival);
            others.map(|(_, (kind, _))| format!("{kind}, {what}")).collect()
        };
        let good = [kinds(Rival::Same, "the same reflectance"), kinds(Rival::Open, "another reflectance")].concat();
        let mut text = format!("type {}", self.kind());
        if !good.is_empty() {
            text += &format!(" (as good: {})", good.join("; "));
        }
        for (kind, rival) in &self.rivals {
            if let Rival::Excluded(z) = rival {
                text += &format!("; {kind} excluded by {z:.0} standard errors");
            }
        }
        text
    }

    /// What there is to doubt.
    pub fn doubts(&self) -> Vec<String> {
        let open: Vec<&str> = self.rivals.iter().filter(|(_, s)| *s == Rival::Open).map(|(kind, _)| &**kind).collect();
        if open.is_empty() {
            return vec![];
        }
        let chosen = self.kind();
        vec![format!("this picture does not tell {chosen} from {}: they fit as well", list(&open))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::rad::Document;
    use crate::recover::misfit::Misfit;
    use crate::unknown::Wishes;

    /// A recovery of 64 blocks of one pixel each, whose losses scatter about `loss`, of values that are known to a thousandth.
    fn trial(material: &str, loss: f64, phase: f64) -> Trial {
        known_to(1e-3, material, loss, phase)
    }

    /// The same of values with this standard error.
    fn known_to(error: f64, material: &str, loss: f64, phase: f64) -> Trial {
        let document = Document::parse(Source::new("m.rad", format!("void {material}"))).unwrap();
        let unknown = Unknown::new(document, &Wishes::default()).unwrap();
        let values = unknown.start();
        let losses = (0..64).map(|p| (p, loss * (1.0 + 0.5 * (p as f64 * 2.4 + phase).sin()))).collect();
        Trial::new(&unknown, Recovery { losses, ..Recovery::plain(&values, &vec![error; values.len()]) })
    }

    fn verdict(trials: &[Trial]) -> (String, Vec<String>, bool) {
        let verdict = choose(trials, &Sample { mask: vec![], blocks: (0..64).map(|n| (n, n)).collect() });
        (verdict.title(), verdict.doubts(), verdict.is_sure())
    }

    #[test]
    fn types_that_say_the_same_are_one() {
        // .9 · .6 = .6 · .9 diffuse, and a lobe of .1: a plastic. So are a grey metal, and a trans that lets nothing through.
        let trials = [
            trial("plastic m 0 0 5 .6 .6 .6 .1 .1", 0.010, 0.0),
            trial("metal m 0 0 5 .64 .64 .64 .15625 .1", 0.0099, 1.0),
            trial("trans m 0 0 7 .6 .6 .6 .1 .1 0 .5", 0.0101, 2.0),
            trial("glass m 0 0 3 .9 .9 .9", 1.0, 3.0),
        ];
        let (title, doubts, sure) = verdict(&trials);
        let good = "type plastic (as good: metal, the same reflectance; trans, the same reflectance); glass excluded by ";
        assert!(title.starts_with(good) && doubts.is_empty() && sure, "{title} {doubts:?}");
        // Not quite the same: more pixels may tell.
        let (title, _, sure) =
            verdict(&[trial("plastic m 0 0 5 .6 .6 .6 .1 .1", 0.010, 0.0), trial("metal m 0 0 5 .64 .64 .65 .16 .1", 0.0099, 1.0)]);
        assert!(title.contains("metal") && !sure, "{title}");
    }

    #[test]
    fn a_plastic_is_no_trans_only_where_it_is_as_near() {
        let plastic = || trial("plastic m 0 0 5 .6 .6 .6 .1 .1", 0.010, 0.0);
        let found = |error: f64, loss: f64, areas: f64| {
            let mut plastic = plastic();
            plastic.recovery.misfit = Misfit { areas, ..Misfit::default() };
            verdict(&[plastic, known_to(error, "trans m 0 0 7 .7 .7 .7 .1 .1 .2 .5", loss, 1.0)])
        };
        for loss in [0.0101, 0.0099] {
            let (title, doubts, sure) = found(0.1, loss, 0.0);
            assert_eq!(title, "type plastic (as good: trans, the same reflectance)");
            assert!(doubts.is_empty() && sure, "{loss}: {doubts:?}");
        }
        // Where it is less near, does not explain the picture, or the light that goes through is surely some.
        for (error, loss, areas) in [(0.1, 0.0093, 0.0), (0.1, 0.0101, 0.03), (0.001, 0.0101, 0.0)] {
            let (title, doubts, sure) = found(error, loss, areas);
            assert_eq!(title, "type plastic (as good: trans, another reflectance)");
            assert!(!doubts.is_empty() && !sure, "{error} {loss} {areas}");
        }
        // It says more, and so is nearer: that alone excludes no plastic, unless what it says more is sure. Nor is one excluded that is hardly known.
        assert_eq!(found(0.1, 0.0087, 0.0).0, "type trans (as good: plastic, another reflectance)");
        assert!(found(0.001, 0.0087, 0.0).0.starts_with("type trans; plastic excluded by "));
    }

    #[test]
    fn types_that_say_different_things_as_well_are_doubted() {
        let plastic = || trial("plastic m 0 0 5 .6 .6 .6 .1 .1", 0.010, 0.0);
        let (title, doubts, sure) = verdict(&[plastic(), trial("metal m 0 0 5 .9 .5 .2 .8 .1", 0.0099, 1.0)]);
        assert_eq!(title, "type metal (as good: plastic, another reflectance)");
        assert!(doubts[0].contains("does not tell metal from plastic") && !sure);
        let (title, doubts, _) = verdict(&[plastic(), trial("metal m 0 0 5 .9 .5 .2 .8 .1", 0.001, 1.0)]);
        assert!(title.starts_with("type metal; plastic excluded by ") && doubts.is_empty(), "{title}");
        // The fewest numbers suffice.
        let (title, ..) = verdict(&[plastic(), trial("glass m 0 0 3 .9 .9 .9", 0.0101, 1.0)]);
        assert_eq!(title, "type glass (as good: plastic, another reflectance)");
        // Where none explains the picture, the nearest.
        let mut astray = plastic();
        astray.recovery.misfit = Misfit { areas: 0.1, ..Misfit::default() };
        let (title, ..) = verdict(&[astray, trial("glass m 0 0 3 .9 .9 .9", 0.0101, 1.0)]);
        assert_eq!(title, "type plastic (as good: glass, another reflectance)");
    }

    #[test]
    fn the_noise_of_one_pixel_makes_no_type_the_best() {
        let mut glass = trial("glass m 0 0 3 .9 .9 .9", 0.2, 1.0);
        glass.recovery.losses[5].1 = -1e4;
        let (title, ..) = verdict(&[trial("plastic m 0 0 5 .6 .6 .6 .1 .1", 0.010, 0.0), glass]);
        assert!(title.starts_with("type plastic; glass excluded by "), "{title}");
    }

    #[test]
    fn few_blocks_tell_less() {
        // Student's table: as rare as 1.96 in the normal distribution.
        for (t, freedom) in [(4.303, 2.0), (2.776, 4.0), (2.086, 20.0), (1.960, 1e9)] {
            assert!((normal(t, freedom) - 1.96).abs() < 0.04 && normal(-t, freedom) == -normal(t, freedom));
        }
        assert_eq!(normal(9.0, 0.0), 0.0);
    }

    #[test]
    fn a_sample_is_whole_blocks_all_over() {
        let pixels: Vec<usize> = (0..200 * 200).collect();
        let block = |n: usize| (n % 200 / BLOCK, n / 200 / BLOCK);
        let kept = kept(&pixels, 200, 2500, BLOCK);
        assert!((kept.len() as f64 / 2500.0 - 1.0).abs() < 0.1, "{}", kept.len());
        assert!((0..4).all(|q| kept.iter().any(|&n| (block(n).0 / 13, block(n).1 / 13) == (q % 2, q / 2))));
        assert!(kept.iter().all(|&n| kept.contains(&(n - n % 200 % BLOCK))));
    }
}
