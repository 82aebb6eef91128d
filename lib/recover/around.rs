//! Whether what is known of a picture, around the unknown, is as the scene has it.

use super::median::median;
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
/// By which part of itself the light of known things is off at the least for it to be said: of all alike, where the middle one is off by this part of
/// that at the least, and neighbours together by no more besides; of neighbours together; all by so many standard errors.
const ALL: f64 = 0.03;
const TOGETHER: f64 = 0.05;
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

/// How things in a world that are known are otherwise in the picture, with the exposure that was found: all brighter or darker alike, as by another
/// exposure, where none was sought; or otherwise, as in another light or by another view. `None` if they are not.
pub fn otherwise_around(
    evidence: &Evidence,
    world: &World,
    unknown: &Unknown,
    found: &Recovery,
    material: MaterialId,
    seed: u64,
) -> Option<Around> {
    if evidence.isolated() {
        return None;
    }
    let looked_at = Looked::new(evidence, LOOKED_AT, |n| !evidence.touches(n, material))?;
    let scene = looked_at.rendered(world, seed);
    let picture = looked_at.photographed(unknown.exposures(&found.values));
    let again = looked_at.rendered(world, mix64(seed));
    let compared = Compared::new(&picture, &scene, &again);
    let (mut said, off) = match compared.factors(&looked_at.rounded()).filter(|_| !unknown.seeks_exposure()) {
        Some(factors) => {
            let off = factors.into_iter().map(|factor| (factor - 1.0).abs()).fold(0.0, f64::max);
            (exposed(factors, compared.factor(bright).0), off)
        }
        None => {
            let off = compared.displaced()?;
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
    let part = Compared::new(&looked_at.photographed(unknown.exposures(&found.values)), &scene, &again).displaced()?;
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

    /// By which part of itself light of each channel may be off as its file rounds it.
    fn rounded(&self) -> [f64; 3] {
        let light = |c: usize| self.numbers.iter().map(|n| f64::from(self.evidence.target.pixels[*n][c])).sum::<f64>();
        let steps = |c: usize| self.evidence.steps.map_or(0.0, |steps| self.numbers.iter().map(|n| f64::from(steps[*n][c])).sum());
        [0, 1, 2].map(|c| steps(c) / (light(c) * 12f64.sqrt()))
    }

    /// What the picture does, which is brighter by these factors.
    fn photographed(&self, exposures: [f64; 3]) -> Vec<Rgb> {
        let light = |&n: &usize| std::array::from_fn(|c| f64::from(self.evidence.target.pixels[n][c]) / exposures[c]).into();
        self.numbers.iter().map(light).collect()
    }
}

/// Pairs of neighbours as the picture has them, and as the scene has them, in terms of how bright a rendering of its own has them: what this one lacks
/// by chance, it is off by too.
struct Compared {
    pairs: Vec<[[Rgb; 2]; 2]>,
}

impl Compared {
    fn new(picture: &[Rgb], scene: &[Rgb], again: &[Rgb]) -> Self {
        let [picture, scene, again] = [picture, scene, again].map(|lights| lights.as_chunks::<2>().0);
        let pairs = picture.iter().zip(scene).zip(again).filter_map(|((picture, scene), again)| {
            let mean = 0.5 * again.iter().map(|light| bright(*light)).sum::<f64>();
            (mean > 0.0).then(|| [picture, scene].map(|lights| lights.map(|light| light / mean)))
        });
        Self { pairs: pairs.collect() }
    }

    fn sum(&self, of: impl Fn(&[[Rgb; 2]; 2]) -> f64) -> f64 {
        self.pairs.iter().map(of).sum()
    }

    /// By how many times light of the picture is brighter than that of the scene, and the standard error of that.
    fn factor(&self, of: impl Fn(Rgb) -> f64) -> (f64, f64) {
        let [picture, scene] = [0, 1].map(|which| self.sum(|pair| of(pair[which][0] + pair[which][1])));
        let factor = picture / scene;
        let rest = |[picture, scene]: &[[Rgb; 2]; 2]| of(picture[0] + picture[1]) - factor * of(scene[0] + scene[1]);
        (factor, self.sum(|pair| rest(pair).powi(2)).sqrt() / scene)
    }

    /// The same of the pair in the middle, which a few that are otherwise do not move.
    fn median(&self, c: usize) -> f64 {
        let ratios = self.pairs.iter().map(|[picture, scene]| (picture[0][c] + picture[1][c]) / (scene[0][c] + scene[1][c]));
        median(ratios.filter(|ratio| ratio.is_finite())).unwrap_or(1.0)
    }

    /// By which square neighbours are off together in a channel of a scene that is so many times as bright, which no noise of their own makes.
    fn together(&self, c: usize, factor: f64) -> f64 {
        let product = |[picture, scene]: &[[Rgb; 2]; 2]| (0..2).map(|k| picture[k][c] - factor * scene[k][c]).product::<f64>();
        let count = self.pairs.len() as f64;
        let mean = self.sum(product) / count;
        let error = self.sum(|pair| (product(pair) - mean).powi(2)).sqrt() / count;
        if mean > SURE * error { mean } else { 0.0 }
    }

    /// By how many times the channels of the picture are brighter, if that is no accident, and all that there is to say; each is known no better than
    /// it is `rounded`, in terms of itself.
    fn factors(&self, rounded: &[f64; 3]) -> Option<[f64; 3]> {
        let known = [0, 1, 2].map(|c| self.factor(|light| light[c]));
        let factors = known.map(|(factor, _)| factor);
        let most = |c: usize| (self.median(c) - 1.0) / (factors[c] - 1.0) > ALIKE;
        let off = |c: usize| (factors[c] - 1.0).abs() > ALL.max(SURE * known[c].1.max(rounded[c])) && most(c);
        let alike: f64 = factors.iter().map(|factor| (factor - 1.0).powi(2)).sum();
        let besides = || (0..3).map(|c| self.together(c, factors[c])).sum::<f64>();
        (self.pairs.len() >= FEWEST && factors.iter().all(|factor| *factor > 0.0) && (0..3).any(off) && besides() < ALIKE * ALIKE * alike)
            .then_some(factors)
    }

    /// By which part neighbours are off together in the channel where that is most.
    fn displaced(&self) -> Option<f64> {
        let most = (0..3).map(|c| self.together(c, 1.0)).fold(0.0, f64::max).sqrt();
        (most > TOGETHER).then_some(most)
    }
}

/// That all is brighter or darker by these factors, as by another exposure, or by another white balance if they differ; `all` is that of all light.
fn exposed(factors: [f64; 3], all: f64) -> String {
    let three = |factor: f64| Number::rounded(factor, 3);
    let param = |(name, factor): (&str, f64)| format!("--param {name}={}:{}:{}", three(factor), three(0.1 * factor), three(10.0 * factor));
    let remedy = "finds that, with something of the material known";
    let (least, most) = (factors.into_iter().fold(f64::INFINITY, f64::min), factors.into_iter().fold(0.0, f64::max));
    if most / least - 1.0 > ALL {
        format!(
            "around the unknown red, green and blue of the picture are {} times as bright as the scene is, as by another white balance: {} {remedy}",
            list(&factors.map(|factor| three(factor).to_string())),
            [0, 1, 2].map(|c| param((EXPOSURES[1 + c], factors[c]))).join(" ")
        )
    } else if (all / WHITE_EFFICACY - 1.0).abs() < CANDELAS {
        format!(
            "around the unknown the picture is {} times as bright as the scene is, as one in cd/m² is: divided by {WHITE_EFFICACY} it is in radiance",
            three(all)
        )
    } else {
        format!(
            "around the unknown the picture is {} times as bright as the scene is, as by another exposure: {} {remedy}",
            three(all),
            param((EXPOSURES[0], all))
        )
    }
}

/// A picture that is brighter by RADIANCE's efficacy of white light but for this part of it is one in cd/m².
const CANDELAS: f64 = 0.1;

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
            let compared = Compared::new(&picture, &scene, &again);
            assert_eq!((compared.displaced(), compared.factors(&[0.0; 3])), (None, None));
            let elsewhere: Vec<Rgb> = picture.iter().map(|light| *light * 2.0).collect();
            let compared = Compared::new(&elsewhere, &scene, &again);
            assert!(compared.displaced().is_some() && compared.factors(&[0.0; 3]).is_some_and(|factors| (factors[0] - 2.0).abs() < 0.1));
        }
    }
}
