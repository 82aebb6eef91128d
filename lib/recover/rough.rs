//! Recovery of plastic, metal, trans and their anisotropic kin.

use super::fit::{Point, Problem, Valley};
use super::foresight::telling;
use super::gram::Gram;
use super::look::{Look, Model, Traced};
use super::model::{Grid, Kind, SPECULARITY, alphas, coefficients, exposed, nodes, parts};
use super::scores::pictures;
use super::seen::{First, scattered};
use super::sheet::{Half, Sheet};
use super::{Effort, Evidence, Recovery, Seeds};
use crate::anneal::{Annealer, Options};
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::MaterialId;
use crate::transport::{self, Alpha, Basis, Explored, POLISHED_ORDER, Pixels, Rough};
use crate::unknown::Unknown;
use rayon::prelude::*;
use std::ops::Range;
use std::time::Instant;

/// The smallest roughness that a node stands for; below it a lobe is hardly to be told from a mirror's.
pub const SMOOTHEST: f64 = 0.002;

/// Nodes along an axis, of isotropic and of anisotropic materials, and the ratio of neighbours at a closer look.
const NODES: (usize, f64) = (16, 1.2);
const ANISOTROPIC_NODES: (usize, f64) = (8, 1.3);

/// The first look: about so many pixels, and samples of each in each half, of isotropic and of anisotropic materials. (With 16, one of roughnesses
/// .25 and .06 under two small lamps was taken for a mirror by every other seed.)
const FIRST_PIXELS: usize = 640;
const FIRST_SAMPLES: [u32; 2] = [16, 64];
/// From how many roughnesses directions are drawn where all are looked at.
const WIDE_PROPOSALS: usize = 5;

/// What of the derivative by a roughness must not be noise for it to be trusted; and the part of itself that its error may be for the nodes of a
/// closer look to hold all that it may be.
const DOUBTFUL: f64 = 0.2;
const HELD: f64 = 0.4;

/// The standard errors that a specularity may be for there to be none, perhaps.
const FAINT: f64 = 2.0;

/// Where they do not, all roughnesses are looked at once more: the most pixels, and the samples of all of them in each half, where the derivatives are
/// mostly noise and where there is next to nothing specular.
const LAST_PIXELS: usize = 2000;
const LAST_SAMPLES: [usize; 2] = [400_000, 100_000];

/// By how many standard errors a value must have moved for what goes by it to be worth another look; and by how much of all light it may be wrong.
const MOVED: f64 = 2.0;
const ALMOST: f64 = 0.003;

/// Evaluations of the annealing.
const STEPS: usize = 2000;

/// Valleys of the first look whose χ² differs by less than this factor are as deep.
const ALIKE: f64 = 1.05;

/// How much of a standard error one pixel may make: one that sees a lamp by the way would else outweigh thousands.
const PULLS: [f64; 2] = [0.3, 0.1];

/// Samples of a pixel in the first round, of what is sharp and of what is not: with half as many of each in twice the pixels, errors are larger;
/// with a third more, rounds take longer.
const LEAST: [f64; 2] = [48.0, 32.0];

/// Looks before the search gives up to keep the answer inside the nodes; and after which one that strays where the derivatives are mostly noise
/// is taken to have lost its way.
const MOST_LOOKS: u32 = 10;
const LOST: u32 = 3;

/// Where directions are drawn from, in terms of the roughness: when it is hardly known, and when its relative standard error is below this.
const WIDE: [f64; 3] = [0.3, 1.0, 3.0];
const NARROW: [f64; 2] = [0.8, 1.3];
const KNOWN: f64 = 0.1;

/// By which factor a roughness may move from where directions are drawn: farther off few of them tell of it, and their noise passes for signal.
const REACH: f64 = 2.0;

/// A roughness below which one more direction is worth its cost: at .01 it makes errors three times smaller, at .12 no smaller. Derivatives by
/// such a roughness are mostly noise.
const SHARP: f64 = 0.04;

impl Kind {
    /// How many nodes a closer look has along an axis, and their ratio.
    fn nodes(self) -> (usize, f64) {
        if self.anisotropic { ANISOTROPIC_NODES } else { NODES }
    }
}

/// What a look works with.
struct Stage<'a> {
    evidence: &'a Evidence<'a>,
    unknown: &'a Unknown,
    material: MaterialId,
    kind: Kind,
    /// Roughnesses of the nodes.
    grid: Grid,
    /// How it is explored.
    rough: Rough,
    /// The roughness as far as is known, and those that directions are drawn around: as much rougher as it may be, since narrower ones tell little.
    near: [f64; 2],
    middle: [f64; 2],
    /// Its errors, as known before.
    errors: [f64; 2],
    /// The coefficients of the columns of each channel, as far as is known.
    guess: Option<[Vec<f64>; 3]>,
    /// The first values that were known: those of light that meets the unknown more often than products tell.
    often: Option<Vec<f64>>,
}

impl<'a> Stage<'a> {
    /// A stage with these nodes, all seen along directions drawn from these roughnesses.
    fn new(evidence: &'a Evidence<'a>, unknown: &'a Unknown, material: MaterialId, kind: Kind, grid: Grid, proposals: Vec<Alpha>) -> Self {
        let middle = grid.each_ref().map(|nodes| nodes[nodes.len() / 2]);
        let rough = match kind.polished {
            true => Rough::polished(material, kind.metal, kind.transmits, &grid[0]),
            false => Rough::new(material, kind.metal, kind.transmits, alphas(kind, &grid), proposals),
        };
        Self { evidence, unknown, material, kind, grid, rough, near: middle, middle, errors: [0.0; 2], guess: None, often: None }
    }

    /// A stage of one that is polished.
    fn polished(sought: &Sought<'a>) -> Self {
        let Sought { evidence, unknown, material, kind, .. } = *sought;
        Self::new(evidence, unknown, material, kind, [(); 2].map(|()| REFLECTANCES.to_vec()), vec![])
    }

    /// A stage whose nodes lie around these values.
    fn near(sought: &Sought<'a>, values: &[f64]) -> Self {
        let Sought { evidence, unknown, material, kind, .. } = *sought;
        let grid = roughness(kind, &unknown.reals(values)).map(|middle| around(middle, kind.nodes()));
        Self::new(evidence, unknown, material, kind, grid, vec![])
    }

    /// Takes the values for the true ones where they only decide what is worth how many samples.
    fn know(&mut self, values: &[f64], control: bool) {
        let reals = self.unknown.reals(values);
        let weights = if self.kind.polished { vec![] } else { nodes(self.kind, &self.grid, &reals[self.kind.roughnesses()]) };
        self.rough.know(parts(self.kind, &reals).map(Rgb::from), &weights);
        self.rough.control = control;
        self.often.get_or_insert_with(|| values.to_vec());
        self.guess = Some(self.coefficients(values));
    }

    /// Whether the roughness is small.
    fn sharp(&self) -> bool {
        self.kind.polished || self.middle[0].max(self.middle[1]) < SHARP
    }

    /// Whether there may be no specular light at all. How much there may be depends then on the roughness that is looked at.
    fn faint(&self, found: &Recovery) -> bool {
        let errors = found.errors();
        let none = |argument: usize| match self.unknown.slots()[argument] {
            Some(slot) => found.values[slot] <= FAINT * errors[slot],
            None => self.unknown.material().reals[argument] == 0.0,
        };
        let through = self.kind.roughnesses().end;
        none(SPECULARITY) && (!self.kind.transmits || none(through) || none(through + 1))
    }

    /// By how much what light meets that meets the unknown more often than products tell differs from what was found: by the shares of its parts, and by
    /// the roughness of those that have one.
    fn changed(&self, found: &Recovery) -> f64 {
        let Some(often) = self.often.as_ref().filter(|_| !self.kind.polished) else { return 0.0 };
        let moved = often.iter().zip(&found.values).zip(found.errors()).any(|((was, is), error)| (was - is).abs() > MOVED * error);
        if !moved {
            return 0.0;
        }
        let [was, is] = [often, &found.values].map(|values| self.unknown.reals(values));
        let shares = |reals: &[f64], c: usize| {
            let parts = parts(self.kind, reals).map(|part| part[c]);
            parts.map(|part| part / parts.iter().sum::<f64>().max(f64::MIN_POSITIVE))
        };
        let logs = |reals: &[f64]| roughness(self.kind, reals).map(f64::ln);
        let rougher = logs(&was).iter().zip(logs(&is)).map(|(was, is)| (was - is).abs()).fold(0.0, f64::max);
        let channel = |c: usize| {
            let (was, is) = (shares(&was, c), shares(&is, c));
            let differ = was.iter().zip(is).map(|(was, is)| (was - is).abs()).fold(0.0, f64::max);
            differ + (is[2] + is[3]) * rougher
        };
        (0..3).map(channel).fold(0.0, f64::max)
    }

    /// The part of all light that meets the unknown more often than products tell.
    fn beyond(&self, values: &[f64], basis: &Basis) -> f64 {
        let all = self.coefficients(values);
        let mut often = all.clone();
        often.iter_mut().for_each(|x| x[..self.rough.monomials.told()].fill(0.0));
        let sum = |picture: &Vec<Half>| picture.iter().flatten().flatten().sum::<f64>();
        let sums: Vec<f64> = pictures(basis, &[all, often]).iter().map(sum).collect();
        if sums[0] > 0.0 { sums[1] / sums[0] } else { 0.0 }
    }

    /// The axes whose roughness is unknown, and its place among the parameters; one axis where both have the same.
    fn axes(&self) -> impl Iterator<Item = (usize, usize)> {
        let [u, v] = slots(self.kind, self.unknown);
        [u, v.filter(|_| v != u)].into_iter().enumerate().filter_map(|(axis, slot)| Some((axis, slot?)))
    }
}

/// From where to where a roughness may move among rising nodes when it is `near` and directions are drawn around `middle`, which is no less: from
/// the nearest node where that lies beyond them, as it does when the surface seems smoother than any.
fn reach(nodes: &[f64], near: f64, middle: f64) -> (f64, f64) {
    let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
    (first.max(near.clamp(first, last) / REACH), last.min(middle.clamp(first, last) * REACH))
}

/// The places among the real arguments of the roughnesses along the two tangents.
fn arguments(kind: Kind) -> [usize; 2] {
    let places = kind.roughnesses();
    [places.start, places.end - 1]
}

/// Their places among the parameters; `None` for what is not one.
fn slots(kind: Kind, unknown: &Unknown) -> [Option<usize>; 2] {
    arguments(kind).map(|argument| unknown.slots()[argument])
}

/// The roughnesses along the two tangents that the real arguments `a` say.
fn roughness(kind: Kind, a: &[f64]) -> [f64; 2] {
    arguments(kind).map(|argument| a[argument].abs().max(SMOOTHEST))
}

impl Model for Stage<'_> {
    fn tune(&mut self, values: &[f64], errors: Option<&[f64]>) {
        if self.kind.polished {
            return self.know(values, false);
        }
        let near = roughness(self.kind, &self.unknown.reals(values));
        let known = self.axes().all(|(axis, slot)| errors.is_some_and(|e| e[slot] < KNOWN * near[axis]));
        let errors = slots(self.kind, self.unknown).map(|slot| slot.zip(errors).map_or(0.0, |(slot, errors)| errors[slot]));
        // An error that is large twice is so; once it may be chance.
        let beyond = |axis: usize| near[axis].hypot(errors[axis].min(self.errors[axis])).min(self.grid[axis][self.grid[axis].len() - 1]);
        (self.middle, self.near, self.errors) = ([0, 1].map(beyond), near, errors);
        let middle = self.middle;
        let factors: &[f64] = if known { &NARROW } else { &WIDE };
        self.rough.propose(factors.iter().map(|f| middle.map(|m| (f * m).powi(2))).collect());
        self.know(values, self.sharp());
    }

    fn trace(&self, pixels: &[usize], samples: &[Range<u32>], seed: u64) -> Basis {
        let pixels = Pixels { numbers: pixels, samples, lens: &self.evidence.film.lens(), picture: self.guess.as_ref() };
        transport::trace(self.evidence.world, self.evidence.rules, Explored::Rough(&self.rough), &pixels, 2, seed)
    }

    fn coefficients(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let scene = coefficients(self.kind, &self.rough.monomials, &self.grid, &self.unknown.reals(values));
        exposed(scene, self.unknown.exposures(values))
    }

    fn trusted(&self, values: &[f64]) -> Vec<f64> {
        let mut values = values.to_vec();
        for (axis, slot) in self.axes() {
            let (low, high) = reach(&self.grid[axis], self.near[axis], self.middle[axis]);
            values[slot] = values[slot].clamp(low, high);
        }
        values
    }

    fn doubtful(&self, found: &Recovery) -> Vec<(usize, Vec<f64>)> {
        let faint = self.faint(found);
        let doubtful = self.axes().filter(|(_, slot)| faint || found.clarity[*slot] < DOUBTFUL);
        doubtful.map(|(axis, slot)| (slot, self.grid[axis].clone())).collect()
    }

    fn telling(&self, pixels: &[usize], _: u64) -> Option<Vec<f64>> {
        let rough = !self.kind.polished && self.sharp() && self.axes().next().is_some();
        (rough && self.evidence.world.has_environment()).then(|| telling(self.evidence, self.material, self.middle, pixels))
    }

    fn first(&self) -> First {
        First { pixels: 600, samples: 64, squares: false, again: true }
    }

    fn glints(&self) -> bool {
        false
    }

    fn pulls(&self) -> [f64; 2] {
        PULLS
    }

    fn least(&self) -> f64 {
        LEAST[!self.sharp() as usize]
    }

    fn holds(&self, found: &Recovery, basis: &Basis) -> bool {
        let inside = |(axis, slot): (usize, usize)| {
            let (a, grid) = (found.values[slot].abs(), &self.grid[axis]);
            a <= SMOOTHEST || a > grid[1] && a < grid[grid.len() - 2]
        };
        let changed = self.changed(found);
        self.axes().all(inside) && (changed < ALMOST || changed * self.beyond(&found.values, basis) < ALMOST)
    }
}

/// Roughnesses in equal ratio from `low` to `high`.
fn geometric(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| low * (high / low).powf(i as f64 / (count - 1) as f64)).collect()
}

/// Roughnesses in the ratio `ratio` around `middle`.
fn around(middle: f64, (count, ratio): (usize, f64)) -> Vec<f64> {
    (0..count).map(|i| middle * ratio.powf(i as f64 - (count - 1) as f64 / 2.0)).collect()
}

/// A model near the starting values.
pub fn near_start<'a>(sought: &Sought<'a>) -> impl Model + 'a {
    Stage::near(sought, &sought.unknown.start())
}

/// Reflectances that a polished unknown is looked at with: as many as a product of the basis needs.
const REFLECTANCES: [f64; POLISHED_ORDER + 1] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];

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
        let mut stage = if self.kind.polished { Stage::polished(self) } else { Stage::near(self, near) };
        let bounds = unknown.bounds();
        let look = Look { evidence, pixels, parameters: unknown.parameters(), bounds: &bounds, effort: &effort, another: &|| false };
        look.at(&mut stage, near, &mut Seeds::new(effort.seed)).found
    }

    /// What all pixels say at a glance of values near some.
    pub fn glance(&self, effort: Effort, near: &[f64]) -> Recovery {
        self.look(Effort { quick: true, told: &|_| {}, ..effort }, near)
    }
}

/// Recovers the numbers; no further than to a look that finds what is `enough`.
pub fn recover(sought: &Sought, effort: Effort, enough: &dyn Fn(&Recovery) -> bool, tell: &dyn Fn(&str)) -> Result<Recovery> {
    let Sought { evidence, unknown, material, kind, pixels } = *sought;
    let nodes = kind.nodes();
    let bounds = unknown.bounds();
    let mut seeds = Seeds::new(effort.seed);

    // A first look at all roughnesses, by some of the pixels.
    let order = scattered(pixels, evidence.film.width);
    let some = |most: usize| Sheet::new(evidence, &order[..most.min(order.len())]);
    let known = roughness(kind, &unknown.material().reals);
    let slots = slots(kind, unknown);
    let [u, v] = [0, 1].map(|axis| {
        let (low, high) = slots[axis].map_or((known[axis], known[axis]), |i| bounds[i]);
        (low.max(SMOOTHEST), high.max(SMOOTHEST * 1.5).max(low * 1.01))
    });
    let wide = || {
        let proposals = geometric(u.0.min(v.0).max(2.0 * SMOOTHEST), u.1.max(v.1), WIDE_PROPOSALS).iter().map(|a| [a * a; 2]).collect();
        Stage::new(evidence, unknown, material, kind, [u, v].map(|(low, high)| geometric(low, high, nodes.0)), proposals)
    };
    let mut best = match effort.around {
        Some(values) => values.to_vec(),
        None => {
            tell("first look");
            let (stage, sheet) = (wide(), some(FIRST_PIXELS));
            let samples = FIRST_SAMPLES[kind.anisotropic as usize];
            let gram = Gram::new(&stage.trace_all(sheet.numbers, samples, seeds.next()), &sheet.target, &sheet.relative);
            let found = search(&Problem { gram: &gram, coefficients: &|v| stage.coefficients(v), bounds: &bounds }, &stage, effort.seed)?;
            match unknown.parameters().iter().position(|p| p.name == "tspec") {
                Some(slot) if !effort.late() => through(&Sought { pixels: sheet.numbers, ..*sought }, effort, slot, found),
                _ => found,
            }
        }
    };

    // Closer looks, each around the answer of the one before, until it stays well inside.
    let begin = Instant::now();
    for look in 1.. {
        tell(&format!("look {look}"));
        let mut stage = Stage::near(sought, &best);
        let late = || !effort.affords_another(begin, look);
        let another = || look < MOST_LOOKS && !late();
        let closer = Look { evidence, pixels, parameters: unknown.parameters(), bounds: &bounds, effort: &effort, another: &another };
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
        let held = |slot: usize| !strayed && found.errors()[slot] <= HELD * found.values[slot].abs();
        if doubtful.iter().all(|(slot, _)| held(*slot)) {
            return Ok(looked.found);
        }
        tell("last look");
        let sheet = some(LAST_PIXELS);
        let faint = stage.faint(found);
        let mut stage = wide();
        stage.know(&found.values, true);
        let basis = stage.trace_all(sheet.numbers, (LAST_SAMPLES[faint as usize] / sheet.numbers.len()) as u32, seeds.next());
        let traced = Traced { sheet: &sheet, model: &stage, basis: &basis };
        return Ok(closer.averaged(looked.found, &looked.aside, traced));
    }
    unreachable!()
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
fn search(problem: &Problem, stage: &Stage, seed: u64) -> Result<Vec<f64>> {
    let parameters = stage.unknown.parameters();
    let options = Options { seed, steps: STEPS, groups: stage.unknown.groups().to_vec(), polish: false, ..Options::default() };
    let mut annealer = Annealer::new(parameters.to_vec(), options)?;
    annealer.drive(|values, _| problem.chi2(values));
    let all = vec![true; parameters.len()];
    let mut starts: Vec<Vec<f64>> = annealer.best().map(|b| b.values).into_iter().collect();
    let axes: Vec<(usize, usize)> = stage.axes().collect();
    // Every roughness; of two, every other pair.
    let (count, stride) = if axes.len() == 2 { (stage.grid[0].len().pow(2) / 4, 2) } else { (stage.grid[0].len(), 1) };
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
    let alike: Vec<&Point> = found.iter().filter(|point| point.chi2 <= ALIKE * best.chi2).collect();
    let (mut values, mut free) = (best.values.clone(), all);
    for (_, slot) in axes {
        let ends = [f64::min, f64::max].map(|end| alike.iter().map(|p| p.values[slot].abs().max(SMOOTHEST)).reduce(end));
        let between = ends.iter().flatten().product::<f64>().sqrt();
        values[slot] = between.clamp(parameters[slot].low, parameters[slot].high);
        free[slot] = false;
    }
    Ok(problem.polish(&values, &free).values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roughness_has_somewhere_to_move_wherever_directions_are_drawn() {
        let nodes = around(0.02, NODES);
        assert_eq!(reach(&nodes, 0.02, 0.02), (0.01, 0.04));
        for middle in [SMOOTHEST, nodes[0], 0.02, nodes[15], 1.0] {
            let (low, high) = reach(&nodes, middle, middle);
            assert!(nodes[0] <= low && low < high && high <= nodes[15], "{middle}: {low} to {high}");
        }
    }
}
