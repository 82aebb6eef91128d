//! Recovery of dielectric and glass: an index of refraction and a transmissivity.
//!
//! A search over all its range finds about where the index is (`indices`); looks at the pixels say the rest (`look`).

use super::foresight::at_a_glance;
use super::indices::Search;
use super::look::{Look, Looked, Model};
use super::model::{cubic, exposed, lagrange};
use super::seen::First;
use super::sheet::Sheet;
use super::{Effort, Evidence, Recovery, Seeds};
use crate::anneal::anywhere;
use crate::anneal::linear::Symmetric;
use crate::color::Rgb;
use crate::error::Result;
use crate::geometry::Ray;
use crate::material::{GLASS_INDEX, hartmann};
use crate::scene::MaterialId;
use crate::transport::{self, Basis, Clear, Explored, Pixels, depth};
use crate::unknown::Unknown;
use rayon::prelude::*;
use std::ops::Range;
use std::time::Instant;

/// The types of material that are recovered so.
pub const KINDS: [&str; 2] = ["dielectric", "glass"];

/// The smallest index that is looked at: less bends light no further.
const LEAST_INDEX: f64 = 0.2;
/// The most that an index is sought to.
const MOST_INDEX: f64 = 10.0;
/// The least that roulette takes a transmissivity for.
const DARKEST: f64 = 1e-3;

/// How much of a standard error one pixel may make. Few samples of what is seen through glass are bright, most are dark: whoever holds back
/// those that are too bright finds it darker than it is (by 1 % of a transmissivity of .9, where this is as small as for rough materials).
const PULLS: [f64; 2] = [3.0, 1.0];

/// Columns that tell what is let through between them, at the ends and at the most: ways of .02 to 20 times the mean are known to 8e-4 of what comes
/// in, and a transmissivity from .1 on by ways of the mean to 5e-5.
const POINTS: [usize; 2] = [6, 10];

/// Samples of a pixel in the first round: with 24, errors are a third larger in as much time. Where it is foreseen which pixels tell most, so many of
/// them are looked at, with more samples each.
const LEAST: f64 = 64.0;
const FIRST: First = First { pixels: 625, samples: 128, squares: true, again: false };

/// How far the two indices that the pixels are looked at with lie to either side: where less than `TOLD` of the change between them is not noise, or
/// the index may lie anywhere between them, `WIDER` times as far, up to the last. (Of a bunny of index 2.4 a thirtieth is not: wherever a look began,
/// .05 off too, it was sure to .005.)
const SPREAD: f64 = 0.003;
const WIDER: f64 = 4.0;
const WIDEST: f64 = 0.048;
const TOLD: f64 = 0.15;

/// Indices, and the bases there.
pub struct Stage<'a> {
    evidence: &'a Evidence<'a>,
    /// The unknown.
    pub unknown: &'a Unknown,
    indices: Vec<f64>,
    parts: Vec<Clear>,
    /// Where the columns stand by what they let through.
    depths: Vec<f64>,
    length: f64,
    /// What the values are, as far as is known.
    known: Option<Vec<f64>>,
}

impl<'a> Stage<'a> {
    /// A stage of these indices, without what Hartmann's constant adds to them.
    pub fn new(evidence: &'a Evidence<'a>, sought: &'a Through, material: MaterialId, indices: Vec<f64>) -> Self {
        let Through { unknown, length, .. } = sought;
        let glass = unknown.material().kind == "glass";
        let constant = unknown.reals(&unknown.start()).get(4).copied().unwrap_or(0.0);
        let parts: Vec<Clear> = indices.iter().map(|&index| Clear::new(material, glass, hartmann(index, constant), *length)).collect();
        let depths = parts[0].nodes.iter().map(|t| depth(*t)).collect();
        Self { evidence, unknown, indices, parts, depths, length: *length, known: None }
    }

    /// The weights of the columns of each channel in the basis of one index.
    pub fn columns(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let a = self.unknown.reals(values);
        exposed(std::array::from_fn(|c| between(&self.depths, a[c].clamp(0.0, 1.0))), self.unknown.exposures(values))
    }

    fn index(&self, values: &[f64]) -> f64 {
        index(self.unknown, values)
    }

    /// Whether the pixels tell its index between those of the stage, or not between farther ones either.
    fn tells(&self, found: &Recovery) -> bool {
        let wide = self.indices[self.indices.len() - 1] - self.indices[0] > WIDEST;
        wide || slot(self.unknown).is_none_or(|i| found.clarity[i] > TOLD)
    }
}

impl Model for Stage<'_> {
    fn tune(&mut self, values: &[f64], _: Option<&[f64]>) {
        self.known = Some(values.to_vec());
        let a = self.unknown.reals(values);
        let extinction = Rgb::from(std::array::from_fn(|c| -a[c].clamp(DARKEST, 1.0).ln() / self.length));
        self.parts.iter_mut().for_each(|part| part.guess = extinction);
    }

    fn trace(&self, pixels: &[usize], samples: &[Range<u32>], seed: u64) -> Basis {
        let guess = self.known.as_ref().map(|values| self.columns(values));
        let pixels = Pixels { numbers: pixels, samples, lens: &self.evidence.film.lens(), picture: guess.as_ref() };
        let at = |clear| transport::trace(self.evidence.world, self.evidence.rules, Explored::Clear(clear), &pixels, 2, seed);
        Basis::beside(&self.parts.iter().map(at).collect::<Vec<_>>())
    }

    fn coefficients(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let columns = self.columns(values);
        let indices = if self.indices.len() > 1 { cubic(&self.indices, self.index(values)) } else { vec![1.0] };
        columns.map(|columns| indices.iter().flat_map(|n| columns.iter().map(move |c| n * c)).collect())
    }

    fn trusted(&self, values: &[f64]) -> Vec<f64> {
        let mut values = values.to_vec();
        if let Some(i) = slot(self.unknown) {
            values[i] = values[i].clamp(self.indices[0], self.indices[self.indices.len() - 1]);
        }
        values
    }

    fn doubtful(&self, _: &Recovery) -> Vec<(usize, Vec<f64>)> {
        vec![]
    }

    fn telling(&self, pixels: &[usize], seed: u64) -> Option<Vec<f64>> {
        let near = self.known.as_ref()?;
        Some(at_a_glance(self, near, &self.unknown.bounds(), &Sheet::new(self.evidence, pixels), seed))
    }

    fn first(&self) -> First {
        FIRST
    }

    fn glints(&self) -> bool {
        true
    }

    fn pulls(&self) -> [f64; 2] {
        PULLS
    }

    fn least(&self) -> f64 {
        LEAST
    }

    fn holds(&self, found: &Recovery, _: &Basis) -> bool {
        let inside = |value: f64| value > self.indices[0] && value < self.indices[self.indices.len() - 1];
        slot(self.unknown).is_none_or(|i| inside(found.values[i])) && self.tells(found)
    }
}

/// The weights of columns at some depths for what is let through.
fn between(depths: &[f64], transmissivity: f64) -> Vec<f64> {
    lagrange(depths, depth(transmissivity), POINTS)
}

/// A model near the starting values.
pub fn near_start<'a>(evidence: &'a Evidence<'a>, sought: &'a Through, material: MaterialId) -> impl Model + 'a {
    let index = index(&sought.unknown, &sought.unknown.start());
    Stage::new(evidence, sought, material, if slot(&sought.unknown).is_some() { close(index, SPREAD) } else { vec![index] })
}

/// The place of the index among the parameters, if it is one.
pub fn slot(unknown: &Unknown) -> Option<usize> {
    unknown.slots().get(3).copied().flatten()
}

/// The index among these values of the unknown.
fn index(unknown: &Unknown, values: &[f64]) -> f64 {
    unknown.reals(values).get(3).copied().unwrap_or(GLASS_INDEX)
}

/// Indices to look at the pixels with.
fn close(index: f64, aside: f64) -> Vec<f64> {
    [-aside, aside].map(|aside| index + aside).to_vec()
}

/// An unknown by what paths through it let through: in another unit of length its picture would be the same, and so would this. What a unit of
/// length lets through is a needle at 1 where that is short beside the object, and one at 0 where it is long.
pub struct Through {
    /// The unknown with such colours.
    pub unknown: Unknown,
    /// About how far paths go inside: the mean way straight through. 1 for glass, which has no inside, and where nothing is behind it.
    length: f64,
    /// The places of the colours among the parameters.
    colors: Vec<usize>,
}

impl Through {
    /// What to look for instead of an unknown.
    pub fn new(evidence: &Evidence, unknown: &Unknown, material: MaterialId) -> Self {
        let (film, lens) = (evidence.film, evidence.film.lens());
        let way = |n: usize| {
            let (origin, direction, _) = lens(n, [0.5; 2])?;
            let inside = evidence.world.behind(&Ray { origin, direction }, material)?;
            evidence.world.nearest(&inside, f64::INFINITY).map(|hit| hit.t)
        };
        let glass = unknown.material().kind == "glass";
        let ways: Vec<f64> = (0..if glass { 0 } else { film.width * film.height }).into_par_iter().filter_map(way).collect();
        let length = if ways.is_empty() { 1.0 } else { ways.iter().sum::<f64>() / ways.len() as f64 };
        let colors = unknown.slots()[..3].iter().copied().flatten().collect();
        Self { unknown: unknown.through(length), length, colors }
    }

    /// The values for those of the unknown itself.
    fn values(&self, values: &[f64]) -> Vec<f64> {
        let value = |(i, v): (usize, &f64)| if self.colors.contains(&i) { v.max(0.0).powf(self.length) } else { *v };
        values.iter().enumerate().map(value).collect()
    }

    /// What a value here is one of in the unknown itself.
    fn own(&self, i: usize, value: f64) -> f64 {
        if self.colors.contains(&i) { value.clamp(0.0, 1.0).powf(1.0 / self.length) } else { value }
    }

    /// By how much a value of the unknown itself changes with one here.
    fn rate(&self, i: usize, value: f64) -> f64 {
        let inverse = 1.0 / self.length;
        if self.colors.contains(&i) { inverse * value.clamp(DARKEST, 1.0).powf(inverse - 1.0) } else { 1.0 }
    }

    /// The same over as much as the values may be off.
    pub fn rates(&self, values: &[f64], covariance: &Symmetric) -> Vec<f64> {
        let rate = |(i, (value, error)): (usize, (&f64, f64))| {
            let (low, high) = (value - error, value + error);
            let [low, high] = if self.colors.contains(&i) { [low.max(0.0), high.min(1.0)] } else { [low, high] };
            if high > low && error.is_finite() { (self.own(i, high) - self.own(i, low)) / (high - low) } else { 1.0 }
        };
        values.iter().zip(covariance.deviations()).enumerate().map(rate).collect()
    }

    /// What was found of the unknown itself.
    fn found(&self, mut found: Recovery) -> Recovery {
        let rates = self.rates(&found.values, &found.covariance);
        for matrix in [&mut found.covariance, &mut found.own, &mut found.common] {
            *matrix = matrix.scaled(&rates);
        }
        found.values = found.values.iter().enumerate().map(|(i, value)| self.own(i, *value)).collect();
        found
    }
}

/// Recovers the numbers.
pub fn recover(
    evidence: &Evidence,
    unknown: &Unknown,
    material: MaterialId,
    pixels: &[usize],
    effort: Effort,
    tell: &dyn Fn(&str),
) -> Result<Recovery> {
    let sought = Through::new(evidence, unknown, material);
    let told = |found: &Recovery| (effort.told)(&sought.found(found.clone()));
    let around = effort.around.map(|values| sought.values(values));
    let rate = |i: usize, value: f64| sought.rate(i, value);
    let effort = Effort { around: around.as_deref(), rate: &rate, told: &told, ..effort };
    let found = looked(evidence, &sought, material, pixels, effort, tell)?;
    Ok(sought.found(found))
}

fn looked(
    evidence: &Evidence,
    sought: &Through,
    material: MaterialId,
    pixels: &[usize],
    effort: Effort,
    tell: &dyn Fn(&str),
) -> Result<Recovery> {
    let unknown = &sought.unknown;
    let parameters = unknown.parameters();
    let sheet = Sheet::new(evidence, pixels);
    let mut seeds = Seeds::new(effort.seed);
    let slot = slot(unknown);
    let fixed = index(unknown, &unknown.start());
    let (low, high) = slot.map_or((fixed, fixed), |i| (parameters[i].low.max(LEAST_INDEX), parameters[i].high.max(LEAST_INDEX)));
    if slot.is_some() && high > MOST_INDEX {
        return Err(unknown
            .material()
            .error(format!("an index of refraction is sought up to {MOST_INDEX}; give it nearer bounds: --param ior=1.5:1:2.5")));
    }
    let bounds: Vec<(f64, f64)> =
        parameters.iter().enumerate().map(|(i, p)| if Some(i) == slot { (low, high) } else { (p.low, p.high) }).collect();

    let search = Search { evidence, sought, material, range: (low, high), effort: &effort };
    let (mut best, known) = match effort.around {
        Some(values) => (values.to_vec(), (low, high)),
        None => search.best(&sheet, &mut seeds, tell)?,
    };

    // Each look that finds the index farther on in the same direction is followed by one twice as far; one that went too far, by one just beside
    // the lowest place so far.
    let begin = Instant::now();
    let (mut lowest, mut stride, mut aside): (Option<Recovery>, f64, f64) = (None, 0.0, SPREAD);
    for look in 1.. {
        tell(&format!("look {look}"));
        let indices = match slot {
            Some(i) => close(best[i], aside),
            None => vec![fixed],
        };
        let mut stage = Stage::new(evidence, sought, material, indices);
        let another = || look < MOST_LOOKS && effort.affords_another(begin, look);
        let closer = Look { evidence, pixels, parameters, bounds: &bounds, effort: &effort, another: &another };
        let Looked { found, held, .. } = closer.at(&mut stage, &best, &mut seeds);
        let Some(i) = slot.filter(|_| !held && found.amiss().is_none()) else { return Ok(found) };
        let open = found.errors()[i] > aside && aside < WIDEST;
        if (open || !stage.tells(&found)) && another() {
            (best, aside) = (found.values, WIDER * aside);
            continue;
        }
        let (mut here, next) = match lowest.take_if(|lowest| found.excess(lowest) > SURE) {
            Some(lower) => {
                stride = 0.0;
                let beside = lower.values[i];
                (lower, beside)
            }
            None => {
                let way = found.values[i] - best[i];
                stride = if stride * way > 0.0 { 2.0 * stride } else { way };
                (found, best[i] + stride)
            }
        };
        if !another() {
            // It was not got hold of: the index may be anywhere where the search has it.
            let range = if (known.0..=known.1).contains(&here.values[i]) { known } else { (low, high) };
            here.covariance.set(i, i, anywhere(range).powi(2));
            return Ok(here);
        }
        best.clone_from(&here.values);
        best[i] = next.clamp(low, high);
        lowest = Some(here);
    }
    unreachable!()
}

/// By how many standard errors a look must find the pixels farther off than another to have gone too far.
const SURE: f64 = 1.0;

/// Looks before the search gives up to keep the answer inside the indices.
const MOST_LOOKS: u32 = 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_short_and_long_are_known_between_the_columns() {
        let nodes = Clear::new(MaterialId::default(), false, 1.5, 1.0).nodes;
        let depths = nodes.map(depth);
        for way in [0.02, 0.05, 0.1, 0.3, 1.0, 3.0, 10.0, 20.0] {
            for transmissivity in (2..1000).map(|i| f64::from(i) / 1000.0) {
                let told: f64 = between(&depths, transmissivity).iter().zip(nodes).map(|(w, t)| w * t.powf(way)).sum();
                let off = told - transmissivity.powf(way);
                assert!(off.abs() < 8e-4, "{transmissivity} along {way}: {off}");
                assert!(way != 1.0 || transmissivity < 0.1 || off.abs() < 5e-5, "{transmissivity}: {off}");
            }
        }
    }
}
