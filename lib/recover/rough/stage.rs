//! The model of rough materials: nodes of roughness around what is known of it, and what was traced by directions that tell of it.

use super::Sought;
use crate::anneal::Parameter;
use crate::color::Rgb;
use crate::recover::doubts::{FAINT, UNDETERMINED};
use crate::recover::foresight::telling;
use crate::recover::look::Model;
use crate::recover::model::{Grid, Kind, SPECULARITY, alphas, coefficients, exposed, nodes, parts};
use crate::recover::scores::pictures;
use crate::recover::seen::First;
use crate::recover::sheet::Half;
use crate::recover::{Evidence, Recovery};
use crate::transport::{self, Alpha, Basis, Explored, ORDER, POLISHED_ORDER, Pixels, Rough};
use crate::unknown::Unknown;
use std::ops::Range;

/// The smallest roughness that a node stands for; below it a lobe is hardly to be told from a mirror's.
pub const SMOOTHEST: f64 = 0.002;

/// Nodes along an axis, of isotropic and of anisotropic materials, and the ratio of neighbours at a closer look.
const NODES: (usize, f64) = (16, 1.2);
const ANISOTROPIC_NODES: (usize, f64) = (8, 1.3);

/// What of the derivative by a roughness must not be noise for it to be trusted.
const DOUBTFUL: f64 = 0.2;

/// The part of itself that the error of a roughness may be for its derivative there to say how far it may be off. (Of .03 in 130 pixels two pictures of
/// eight said .008 ± .003.)
const HELD: f64 = 0.25;

/// How many of all values that one may have are looked at where it is left open.
const OPEN_VALUES: usize = 8;

/// By how many standard errors a value must have moved for what goes by it to be worth another look; and by how much of all light it may be wrong.
const MOVED: f64 = 2.0;
const ALMOST: f64 = 0.002;

/// The roughness of a lobe that the light changes within: along narrower ones it changes less.
const WIDE_LOBE: f64 = 0.1;

/// How much of a standard error one pixel may make: one that sees a lamp by the way would else outweigh thousands.
const PULLS: [f64; 2] = [0.3, 0.1];

/// Samples of a pixel in the first round, of what is sharp and of what is not: with half as many of each in twice the pixels, errors are larger;
/// with a third more, rounds take longer.
const LEAST: [f64; 2] = [48.0, 32.0];

/// Where directions are drawn from, in terms of the roughness: when it is hardly known, and when its relative standard error is below this.
const WIDE: [f64; 3] = [0.3, 1.0, 3.0];
const NARROW: [f64; 2] = [0.8, 1.3];
const KNOWN: f64 = 0.1;

/// From how many roughnesses directions are drawn where all are looked at.
const WIDE_PROPOSALS: usize = 5;

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
pub struct Stage<'a> {
    evidence: &'a Evidence<'a>,
    unknown: &'a Unknown,
    kind: Kind,
    /// Roughnesses of the nodes.
    pub grid: Grid,
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
    fn new(sought: &Sought<'a>, grid: Grid, proposals: Vec<Alpha>) -> Self {
        let Sought { evidence, unknown, material, kind, .. } = *sought;
        let middle = grid.each_ref().map(|nodes| nodes[nodes.len() / 2]);
        let rough = match kind.polished {
            true => Rough::polished(material, kind.metal, kind.transmits, &grid[0]),
            false => Rough::new(material, kind.metal, kind.transmits, alphas(kind, &grid), proposals),
        };
        Self { evidence, unknown, kind, grid, rough, near: middle, middle, errors: [0.0; 2], guess: None, often: None }
    }

    /// A stage of one that is polished.
    fn polished(sought: &Sought<'a>) -> Self {
        Self::new(sought, [(); 2].map(|()| REFLECTANCES.to_vec()), vec![])
    }

    /// A stage whose nodes lie around these values.
    pub fn near(sought: &Sought<'a>, values: &[f64]) -> Self {
        if sought.kind.polished {
            return Self::polished(sought);
        }
        let middles = roughness(sought.kind, &sought.unknown.reals(values));
        Self::new(sought, middles.map(|middle| around(middle, sought.kind.nodes())), vec![])
    }

    /// A stage of all roughnesses inside the bounds.
    pub fn wide(sought: &Sought<'a>) -> Self {
        let Sought { unknown, kind, .. } = *sought;
        let (bounds, known, slots) = (unknown.bounds(), roughness(kind, &unknown.reals(&unknown.start())), slots(kind, unknown));
        let ends = [0, 1].map(|axis| {
            let (low, high) = slots[axis].map_or((known[axis], known[axis]), |i| bounds[i]);
            (low.max(SMOOTHEST), high.max(SMOOTHEST * 1.5).max(low * 1.01))
        });
        let [u, v] = ends;
        let proposals = geometric(u.0.min(v.0).max(2.0 * SMOOTHEST), u.1.max(v.1), WIDE_PROPOSALS).iter().map(|a| [a * a; 2]).collect();
        Self::new(sought, ends.map(|(low, high)| geometric(low, high, kind.nodes().0)), proposals)
    }

    /// Takes the values for the true ones where they only decide what is worth how many samples.
    pub fn know(&mut self, values: &[f64], control: bool) {
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

    /// By how much of itself light that meets the unknown more often than products tell is off, by what was found: by the shares of its parts at as many
    /// meetings, and by the roughness of those that have one.
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
        let rougher = roughness(self.kind, &was).iter().zip(roughness(self.kind, &is)).map(|(was, is)| wider(*was, is)).fold(0.0, f64::max);
        let channel = |c: usize| {
            let (was, is) = (shares(&was, c), shares(&is, c));
            let differ: f64 = was.iter().zip(is).map(|(was, is)| (was - is).abs()).sum();
            (ORDER + 1) as f64 * differ + (is[2] + is[3]) * rougher
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

    /// Of the shares of what goes through, the one that the pixels leave open most, if they do, and all that it may be: light goes through a body's two
    /// sides, so colours change with it otherwise than their derivatives say.
    fn open(&self, found: &Recovery) -> Option<(usize, Vec<f64>)> {
        let (parameters, errors, through) = (self.unknown.parameters(), found.errors(), self.kind.roughnesses().end);
        let part = |slot: &usize| errors[*slot] / parameters[*slot].anywhere();
        let shares = self.unknown.slots().get(through..through + 2)?.iter().flatten().copied();
        let most = shares.filter(|slot| part(slot) >= UNDETERMINED).max_by(|a, b| part(a).total_cmp(&part(b)))?;
        let Parameter { low, high, .. } = parameters[most];
        Some((most, (0..OPEN_VALUES).map(|k| low + (high - low) * k as f64 / (OPEN_VALUES - 1) as f64).collect()))
    }

    /// The axes whose roughness is unknown, and its place among the parameters; one axis where both have the same.
    pub fn axes(&self) -> impl Iterator<Item = (usize, usize)> {
        let [u, v] = slots(self.kind, self.unknown);
        [u, v.filter(|_| v != u)].into_iter().enumerate().filter_map(|(axis, slot)| Some((axis, slot?)))
    }
}

/// Whether what a closer look sees around a roughness holds all that it may be.
pub fn is_held(found: &Recovery, slot: usize) -> bool {
    found.errors()[slot] <= HELD * found.values[slot].abs()
}

/// How much what is seen along lobes may change with their roughness, in terms of itself.
fn wider(was: f64, is: f64) -> f64 {
    (was / is).ln().abs() * (was.max(is) / WIDE_LOBE).min(1.0)
}

/// Whether there may be no specular light at all: how much there may be depends then on the roughness that is looked at.
pub fn faint(kind: Kind, unknown: &Unknown, found: &Recovery) -> bool {
    let errors = found.errors();
    let none = |argument: usize| match unknown.slots()[argument] {
        Some(slot) => found.values[slot] <= FAINT * errors[slot],
        None => unknown.reals(&found.values)[argument] == 0.0,
    };
    let through = kind.roughnesses().end;
    none(SPECULARITY) && (!kind.transmits || none(through) || none(through + 1))
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
        let faint = faint(self.kind, self.unknown, found);
        let rough = self.axes().filter(|(_, slot)| faint || found.clarity[*slot] < DOUBTFUL || !is_held(found, *slot));
        let open = self.open(found);
        // Of two, every other.
        let stride = 1 + usize::from(open.is_some());
        let inside = |(axis, slot): (usize, usize)| {
            let Parameter { low, high, .. } = self.unknown.parameters()[slot];
            let mut all: Vec<f64> = self.grid[axis].iter().map(|value| value.clamp(low, high)).step_by(stride).collect();
            all.dedup();
            (slot, all)
        };
        // One value is no doubt.
        rough.map(inside).filter(|(_, all)| all.len() > 1).chain(open).collect()
    }

    fn telling(&self, pixels: &[usize], _: u64) -> Option<Vec<f64>> {
        let rough = !self.kind.polished && self.sharp() && self.axes().next().is_some();
        (rough && self.evidence.world.has_environment()).then(|| telling(self.evidence, self.rough.material, self.middle, pixels))
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
        self.axes().all(inside) && self.presumed(found, basis) == 0.0
    }

    fn presumed(&self, found: &Recovery, basis: &Basis) -> f64 {
        let changed = self.changed(found);
        let off = if changed < ALMOST { 0.0 } else { changed * self.beyond(&found.values, basis) };
        if off < ALMOST { 0.0 } else { off }
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

/// Reflectances that a polished unknown is looked at with: as many as a product of the basis needs.
const REFLECTANCES: [f64; POLISHED_ORDER + 1] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];

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
