//! Whether what is known of a picture, around the unknown, is as the scene has it.

use super::saturated;
use super::words::list;
use super::{Evidence, Recovery};
use crate::color::{Rgb, WHITE_EFFICACY, bright};
use crate::rad::Number;
use crate::rules::Rules;
use crate::sampling::mix64;
use crate::scene::MaterialId;
use crate::unknown::{COLORS, EXPOSURES, Unknown};
use crate::world::World;
use std::collections::HashSet;

/// About so many pairs of neighbours are looked at, and so many tell something; those on the unknown are sought among more.
const LOOKED_AT: usize = 300;
const FEWEST: usize = 30;
const THERE: usize = 10 * LOOKED_AT;
/// By which part of itself the light of known things is off at the least for it to be said: of all alike, half of them within less than that and within
/// this part of what they have in common; of neighbours together, beyond so many standard errors.
const OFF: f64 = 0.05;
const ALIKE: f64 = 0.5;
const SURE: f64 = 4.0;

/// What is around the unknown, otherwise than it is in the scene.
pub struct Around {
    /// What is to be said of it.
    pub said: String,
    /// By which part of itself the light of the unknown may be off by that.
    pub off: f64,
}

/// The part of what things around the unknown are off by that its light is, where they are not so alike: of eight pictures whose map was too coarse,
/// turned or measured in a room, whose walls were too dark, whose view was off or whose corners were dim, the colours found were off by a third of that
/// on the average, and once by more than all of it.
const SHARED: f64 = 1.0 / 3.0;

/// The part by which it may be off where a renderer guessed light that bounces: of six pictures in a room, by the defaults of `rpict -ab 2`, what was found
/// was off by .4 of standard errors that hold this on the average, and by 1.3 at the most; without, by up to 9.
pub const GUESSED: f64 = 0.016;

/// How things in a world that are known are otherwise in the picture, whose red, green and blue are brighter by `exposures` if those are known: all
/// brighter or darker alike, as by another exposure; or otherwise, as in another light or by another view. `None` if they are not.
pub fn otherwise_around(
    evidence: &Evidence,
    world: &World,
    exposures: Option<[f64; 3]>,
    material: MaterialId,
    seed: u64,
) -> Option<Around> {
    if evidence.isolated() {
        return None;
    }
    let looked_at = Looked::new(evidence, LOOKED_AT, |n| !evidence.touches(n, material))?;
    let scene = looked_at.rendered(world, seed);
    let picture = looked_at.photographed(exposures.unwrap_or([1.0; 3]));
    let again = looked_at.rendered(world, mix64(seed));
    let factors = common([0, 1, 2].map(|c| factor(&picture, &scene, |light| light[c])));
    let (mut said, off) = match factors.filter(|factors| exposures.is_none() && in_all(*factors, &picture, &scene, &again)) {
        Some(factors) => {
            let off = factors.into_iter().map(|factor| (factor - 1.0).abs()).fold(0.0, f64::max);
            (exposed(factors, factor(&picture, &scene, bright)), off)
        }
        None => {
            let off = displaced(&picture, &scene, &again)?;
            let said = format!(
                "around the unknown the picture is not as the scene is there, neighbours together by {:.0} %: the light, the view or what is there may not be those of the photograph",
                100.0 * off
            );
            (said, SHARED * off)
        }
    };
    let bounces = evidence.rules.ambient_bounces;
    if bounces != Rules::default().ambient_bounces {
        said += &format!("; or it holds light of more bounces than -ab {bounces}, as a photograph does");
    }
    Some(Around { said, off })
}

/// What is to be said if an unknown is otherwise in the picture than in a world where it is what was found, as few pixels may not show; by more than its
/// colours may be off by anyway.
pub fn otherwise_there(
    evidence: &Evidence,
    world: &World,
    unknown: &Unknown,
    found: &Recovery,
    material: MaterialId,
    seed: u64,
) -> Option<String> {
    let looked_at = Looked::new(evidence, THERE, |n| evidence.filled(n, material))?;
    let [scene, again] = [seed, mix64(seed)].map(|seed| looked_at.rendered(world, seed));
    let part = displaced(&looked_at.photographed(unknown.exposures(&found.values)), &scene, &again)?;
    (part > unsure(unknown, found)).then(|| {
        format!(
            "the picture is not what this makes, neighbours together by {:.0} %: the type, the light or the view may not be those of the photograph, \
             and more --time would tell by how much that moves each value",
            100.0 * part
        )
    })
}

/// The largest part of itself that the standard error of a colour is.
fn unsure(unknown: &Unknown, found: &Recovery) -> f64 {
    let parts = unknown.parameters().iter().zip(found.values.iter().zip(found.errors()));
    let colours = parts.filter(|(p, _)| COLORS.1.contains(&&p.name[..])).map(|(_, (value, error))| error / value);
    colours.filter(|part| part.is_finite()).fold(0.0, f64::max)
}

/// Pairs of neighbours whose noise is their own, one after the other.
struct Looked<'a> {
    evidence: &'a Evidence<'a>,
    numbers: Vec<usize>,
}

impl<'a> Looked<'a> {
    /// About so many of all over the picture that count and are all `such`; `None` if they are too few to tell something.
    fn new(evidence: &'a Evidence<'a>, count: usize, such: impl Fn(usize) -> bool) -> Option<Self> {
        let finite = |n: usize| evidence.target.pixels[n].iter().all(|v| v.is_finite());
        let known = |&n: &usize| evidence.counts(n) && finite(n) && such(n);
        let (width, apart) = (evidence.film.width, evidence.film.filter.spacing());
        let pairs = evidence.film.some(count).filter(|n| n % width + apart < width).map(|n| [n, n + apart]);
        let pairs: Vec<[usize; 2]> = pairs.filter(|pair| pair.iter().all(known)).collect();
        // What seems saturated tells nothing.
        let lit: HashSet<usize> = saturated::apart(evidence, pairs.concat()).1.into_iter().collect();
        let pairs: Vec<[usize; 2]> = pairs.into_iter().filter(|pair| pair.iter().all(|n| lit.contains(n))).collect();
        let numbers = pairs.iter().copied().step_by(pairs.len().div_ceil(LOOKED_AT).max(1)).collect::<Vec<_>>().concat();
        (numbers.len() >= 2 * FEWEST).then_some(Self { evidence, numbers })
    }

    /// What a world shows there.
    fn rendered(&self, world: &World, seed: u64) -> Vec<Rgb> {
        self.evidence.rendered(world, &self.numbers, seed).pixels.iter().map(|pixel| pixel.mean()).collect()
    }

    /// What the picture does, which is brighter by these factors.
    fn photographed(&self, exposures: [f64; 3]) -> Vec<Rgb> {
        let light = |&n: &usize| std::array::from_fn(|c| f64::from(self.evidence.target.pixels[n][c]) / exposures[c]).into();
        self.numbers.iter().map(light).collect()
    }
}

/// By how much light of the picture is brighter than that of the scene, if it is so all alike.
fn factor(picture: &[Rgb], scene: &[Rgb], of: impl Fn(Rgb) -> f64) -> Option<f64> {
    let ratios = picture.iter().zip(scene).map(|(picture, scene)| of(*picture) / of(*scene));
    let mut ratios: Vec<f64> = ratios.filter(|ratio| ratio.is_finite()).collect();
    if ratios.len() < FEWEST {
        return None;
    }
    ratios.sort_by(f64::total_cmp);
    let [low, middle, high] = [1, 2, 3].map(|part| ratios[part * (ratios.len() - 1) / 4]);
    (middle > 0.0 && high - low < (ALIKE * middle).min((middle - 1.0).abs().max(OFF))).then_some(middle)
}

/// The factors of all channels, if each has one and one of them at the least is not 1.
fn common([red, green, blue]: [Option<f64>; 3]) -> Option<[f64; 3]> {
    Some([red?, green?, blue?]).filter(|factors| factors.iter().any(|factor| (factor - 1.0).abs() > OFF))
}

/// Whether a channel that has such a factor is off in the mean too, in terms of a rendering of its own: where few samples find a small lamp most pixels
/// are too dark, and some make up for it.
fn in_all(factors: [f64; 3], picture: &[Rgb], scene: &[Rgb], again: &[Rgb]) -> bool {
    (0..3).filter(|c| (factors[*c] - 1.0).abs() > OFF).any(|c| {
        let lights = picture.iter().zip(scene).zip(again).filter(|(_, again)| again[c] > 0.0);
        let parts: Vec<f64> = lights.map(|((picture, scene), again)| (picture[c] - scene[c]) / again[c]).collect();
        let mean = parts.iter().sum::<f64>() / parts.len() as f64;
        let error = parts.iter().map(|part| (part - mean).powi(2)).sum::<f64>().sqrt() / parts.len() as f64;
        mean.abs() > SURE * error
    })
}

/// That all is brighter or darker by these factors, as by another exposure, or by another white balance if they differ; `all` is that of all light.
fn exposed(factors: [f64; 3], all: Option<f64>) -> String {
    let two = |factor: f64| Number::rounded(factor, 2);
    let param = |(name, factor): (&str, f64)| format!("--param {name}={}:{}:{}", two(factor), two(0.1 * factor), two(10.0 * factor));
    let remedy = "finds that, with something of the material known";
    let (least, most) = (factors.into_iter().fold(f64::INFINITY, f64::min), factors.into_iter().fold(0.0, f64::max));
    let differ = most / least - 1.0 > OFF;
    match all.filter(|_| !differ) {
        Some(all) if (all / WHITE_EFFICACY - 1.0).abs() < 2.0 * OFF => format!(
            "around the unknown the picture is {} times as bright as the scene is, as one in cd/m² is: divided by {WHITE_EFFICACY} it is in radiance",
            two(all)
        ),
        Some(all) => format!(
            "around the unknown the picture is {} times as bright as the scene is, as by another exposure: {} {remedy}",
            two(all),
            param((EXPOSURES[0], all))
        ),
        None => format!(
            "around the unknown red, green and blue of the picture are {} times as bright as the scene is, as by another white balance: {} {remedy}",
            list(&factors.map(|factor| two(factor).to_string())),
            [0, 1, 2].map(|c| param((EXPOSURES[1 + c], factors[c]))).join(" ")
        ),
    }
}

/// By which part neighbours are off together, which no noise of their own makes: in terms of what a rendering of its own has, since what this one
/// lacks by chance it is off by too.
fn displaced(picture: &[Rgb], scene: &[Rgb], again: &[Rgb]) -> Option<f64> {
    let [picture, scene, again] = [picture, scene, again].map(|lights| lights.as_chunks::<2>().0);
    let products = picture.iter().zip(scene).zip(again).filter_map(|((picture, scene), again)| {
        let ([a, b], [c, d]) = (picture.map(bright), scene.map(bright));
        let mean = 0.5 * again.map(bright).iter().sum::<f64>();
        (mean > 0.0).then(|| (a - c) * (b - d) / mean.powi(2))
    });
    let products: Vec<f64> = products.collect();
    let mean = products.iter().sum::<f64>() / products.len() as f64;
    let error = products.iter().map(|product| (product - mean).powi(2)).sum::<f64>().sqrt() / products.len() as f64;
    (mean > OFF * OFF && mean > SURE * error).then(|| mean.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_that_few_samples_find_is_not_off() {
        // Each in ten is five times as bright as the others, by chance.
        let lights = |seed: u64| -> Vec<Rgb> {
            (0..6000).map(|n| Rgb::splat(if mix64(seed << 32 | n).is_multiple_of(10) { 1.0 } else { 0.2 })).collect()
        };
        for seed in 0..20 {
            let [picture, scene, again] = [0, 1, 2].map(|k| lights(3 * seed + k));
            assert_eq!(displaced(&picture, &scene, &again), None);
            let elsewhere: Vec<Rgb> = picture.iter().map(|light| *light * 2.0).collect();
            assert!(displaced(&elsewhere, &scene, &again).is_some());
        }
    }
}
