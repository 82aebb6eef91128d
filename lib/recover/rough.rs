//! Recovery of plastic, metal, trans and their anisotropic kin.

mod stage;

use super::fit::{Point, Problem, Valley};
use super::gram::Gram;
use super::look::{Look, Model, Traced};
use super::model::Kind;
use super::seen::{scattered, traced_in_time};
use super::sheet::Sheet;
use super::{Effort, Evidence, Recovery, Seeds};
use crate::anneal::{Annealer, Options};
use crate::error::Result;
use crate::scene::MaterialId;
use crate::unknown::Unknown;
use rayon::prelude::*;
pub use stage::{SMOOTHEST, faint};
use stage::{Stage, is_held};
use std::time::Instant;

/// The first look: about so many pixels, and samples of each in each half, of isotropic and of anisotropic materials. (With 16, one of roughnesses
/// .25 and .06 under two small lamps was taken for a mirror by every other seed.)
const FIRST_PIXELS: usize = 640;
const FIRST_SAMPLES: [u32; 2] = [16, 64];

/// Where what a closer look sees does not hold all that a roughness may be, all roughnesses are looked at once more: the most pixels, and the samples of
/// all of them in each half, where the derivatives are mostly noise, and where there is next to nothing specular or single pixels hold the light of it;
/// and the most of each.
const LAST_PIXELS: usize = 2000;
const LAST_SAMPLES: [usize; 2] = [400_000, 100_000];
const LAST_OF_PIXEL: usize = 1500;

/// Evaluations of the annealing.
const STEPS: usize = 2000;

/// Valleys of the first look whose χ² differs by less than this factor are as deep.
const ALIKE: f64 = 1.05;

/// Looks before the search gives up to keep the answer inside the nodes; and after which one that strays where the derivatives are mostly noise
/// is taken to have lost its way.
const MOST_LOOKS: u32 = 10;
const LOST: u32 = 3;

/// A model near the starting values.
pub fn near_start<'a>(sought: &Sought<'a>) -> impl Model + 'a {
    Stage::near(sought, &sought.unknown.start())
}

/// What is recovered, and from what.
#[derive(Clone, Copy)]
pub struct Sought<'a> {
    /// What is known.
    pub evidence: &'a Evidence<'a>,
    /// What is not.
    pub unknown: &'a Unknown,
    /// Its place among the materials of the scene.
    pub material: MaterialId,
    /// What it is.
    pub kind: Kind,
    /// The pixels that show it, and count.
    pub pixels: &'a [usize],
}

impl Sought<'_> {
    /// What one look finds near some values.
    pub fn look(&self, effort: Effort, near: &[f64]) -> Recovery {
        let Self { evidence, unknown, pixels, .. } = *self;
        let mut stage = Stage::near(self, near);
        let bounds = unknown.bounds();
        let parameters = unknown.parameters();
        let look = Look { evidence, pixels, parameters, bounds: &bounds, effort: &effort, another: &|| false, enough: &|_| false };
        look.at(&mut stage, near, &mut Seeds::new(effort.seed)).found
    }

    /// What the pixels, or as many of them as a quick look has, say at a glance of values near some.
    pub fn glance(&self, effort: Effort, near: &[f64]) -> Recovery {
        self.look(Effort { quick: true, told: &|_| {}, ..effort }, near)
    }
}

/// Recovers the numbers; no further than to rounds that find what is `enough`.
pub fn recover(sought: &Sought, effort: Effort, enough: &(dyn Fn(&Recovery) -> bool + Sync), tell: &dyn Fn(&str)) -> Result<Recovery> {
    let Sought { evidence, unknown, pixels, .. } = *sought;
    let (parameters, bounds, mut seeds) = (unknown.parameters(), unknown.bounds(), Seeds::new(effort.seed));
    let order = scattered(pixels, evidence.film.width);
    let mut best = match effort.around {
        Some(values) => values.to_vec(),
        None => {
            tell("first look");
            begun(sought, effort, &order, &mut seeds)?
        }
    };

    // Closer looks, each around the answer of the one before, until it stays well inside.
    let begin = Instant::now();
    for look in 1.. {
        tell(&format!("look {look}"));
        let mut stage = Stage::near(sought, &best);
        let late = || !effort.affords_another(begin, look);
        let another = || look < MOST_LOOKS && !late();
        let closer = Look { evidence, pixels, parameters, bounds: &bounds, effort: &effort, another: &another, enough };
        let looked = closer.at(&mut stage, &best, &mut seeds);
        let found = &looked.found;
        if late() || found.amiss().is_some() || enough(found) {
            return Ok(looked.found);
        }
        let (doubtful, strayed) = (stage.doubtful(found), !looked.held);
        if strayed && another() && (look < LOST || doubtful.is_empty()) {
            best.clone_from(&found.values);
            continue;
        }
        let held = |slot: usize| !strayed && is_held(found, slot);
        let rough = |slot: usize| stage.axes().any(|(_, of)| of == slot);
        if doubtful.iter().all(|(slot, _)| !rough(*slot) || held(*slot)) {
            return Ok(looked.found);
        }
        tell("last look");
        let little = faint(sought.kind, unknown, found) || found.misfit.singles > 0.0;
        let sheet = some(evidence, &order, LAST_PIXELS);
        let mut stage = Stage::wide(sought);
        stage.know(&found.values, true);
        let samples = (LAST_SAMPLES[little as usize] / sheet.numbers.len()).min(LAST_OF_PIXEL);
        let basis = traced_in_time(&stage, sheet.numbers, samples as u32, (effort.until)(), seeds.next());
        let traced = Traced { sheet: &sheet, model: &stage, basis: &basis };
        return Ok(closer.averaged(looked.found, &looked.aside, traced));
    }
    unreachable!("the last look ends")
}

/// About what the values are: a look at all roughnesses, by some of the pixels in this order.
fn begun(sought: &Sought, effort: Effort, order: &[usize], seeds: &mut Seeds) -> Result<Vec<f64>> {
    let Sought { evidence, unknown, kind, .. } = *sought;
    let (stage, sheet) = (Stage::wide(sought), some(evidence, order, FIRST_PIXELS));
    let samples = FIRST_SAMPLES[kind.anisotropic as usize];
    let basis = traced_in_time(&stage, sheet.numbers, samples, effort.part(2), seeds.next());
    let gram = Gram::new(&basis, &sheet.target, &sheet.relative);
    let problem = Problem { gram: &gram, coefficients: &|v| stage.coefficients(v), bounds: &unknown.bounds() };
    let found = search(&problem, &stage, unknown, effort.seed)?;
    Ok(match unknown.parameters().iter().position(|p| p.name == "tspec") {
        Some(slot) if !effort.late() => through(&Sought { pixels: sheet.numbers, ..*sought }, effort, slot, found),
        _ => found,
    })
}

/// A sheet of so many of the pixels in this order, if there are as many.
fn some<'a>(evidence: &'a Evidence<'a>, order: &'a [usize], most: usize) -> Sheet<'a> {
    Sheet::new(evidence, &order[..most.min(order.len())])
}

/// The better of what a look finds from some values, and from others with much more, or less, of the light that goes through at parameter `slot` seen
/// sharply. Along sharp lobes through a body it is so noisy where all roughnesses are looked at that none of it seems to fit best.
fn through(sought: &Sought, effort: Effort, slot: usize, values: Vec<f64>) -> Vec<f64> {
    let (low, high) = sought.unknown.bounds()[slot];
    let mut other = values.clone();
    other[slot] = if values[slot] < 0.5 * (low + high) { 0.25 * low + 0.75 * high } else { 0.75 * low + 0.25 * high };
    let [one, two] = [values, other].map(|values| sought.glance(effort, &values));
    if two.loss() < one.loss() { two.values } else { one.values }
}

/// The deepest valley: annealing inside the bounds, and descents from every roughness in case it was not found.
fn search(problem: &Problem, stage: &Stage, unknown: &Unknown, seed: u64) -> Result<Vec<f64>> {
    let parameters = unknown.parameters();
    let options = Options { seed, steps: STEPS, groups: unknown.groups().to_vec(), polish: false, ..Options::default() };
    let mut annealer = Annealer::new(parameters.to_vec(), options)?;
    annealer.drive(|values, _| problem.chi2(values));
    let all = vec![true; parameters.len()];
    let mut starts: Vec<Vec<f64>> = annealer.best().map(|b| b.values).into_iter().collect();
    let axes: Vec<(usize, usize)> = stage.axes().collect();
    // Every roughness; of two, every other pair.
    let (count, stride) = match axes.len() {
        0 => (1, 1),
        1 => (stage.grid[0].len(), 1),
        _ => (stage.grid[0].len().pow(2) / 4, 2),
    };
    let descent = |start: usize| {
        let mut values: Vec<f64> = parameters.iter().map(|p| 0.5 * (p.low + p.high)).collect();
        let mut free = all.clone();
        let mut rest = start;
        for &(axis, slot) in &axes {
            let along = stage.grid[axis].len() / stride;
            values[slot] = stage.grid[axis][(rest % along) * stride].clamp(parameters[slot].low, parameters[slot].high);
            free[slot] = false;
            rest /= along;
        }
        problem.polish(&values, &free).values
    };
    starts.par_extend((0..count).into_par_iter().map(descent));
    let found: Vec<Point> = starts.par_iter().map(|start| problem.polish(start, &all)).collect();
    let Some(best) = found.iter().min_by(|a, b| a.chi2.total_cmp(&b.chi2)) else { return Ok(starts.swap_remove(0)) };
    // The truth then lies between valleys that are as deep: directions were drawn to both sides of it, and little is known between.
    let alike: Vec<&Point> = found.iter().filter(|point| !(point.chi2 - best.chi2 > (ALIKE - 1.0) * best.chi2.abs())).collect();
    let (mut values, mut free) = (best.values.clone(), all);
    for (_, slot) in axes {
        let ends = [f64::min, f64::max].map(|end| alike.iter().map(|p| p.values[slot].abs().max(SMOOTHEST)).reduce(end));
        let between = ends.iter().flatten().product::<f64>().sqrt();
        values[slot] = between.clamp(parameters[slot].low, parameters[slot].high);
        free[slot] = false;
    }
    Ok(problem.polish(&values, &free).values)
}
