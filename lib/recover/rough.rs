//! Recovery of plastic, metal, trans and their anisotropic kin.

use super::fit::{Point, Problem};
use super::gram::{Form, Gram};
use super::look::{Look, Model};
use super::model::{Kind, alphas, coefficients, parts};
use super::statistics::Sheet;
use super::{Effort, Evidence, Recovery, Seeds};
use crate::anneal::{Annealer, Options};
use crate::color::Rgb;
use crate::error::Result;
use crate::scene::MaterialId;
use crate::transport::{self, Basis, Pixels, Rough};
use crate::unknown::Unknown;

/// The smallest roughness that a node stands for; below it a lobe is hardly to be told from a mirror's.
const SMOOTHEST: f64 = 0.002;

/// Nodes of the first look.
const COARSE: usize = 16;
/// Evaluations of the annealing.
const STEPS: usize = 2000;

/// What a stage works with.
struct Stage<'a> {
    evidence: &'a Evidence<'a>,
    unknown: &'a Unknown,
    kind: Kind,
    /// Roughnesses of the nodes.
    grid: Vec<f64>,
    what: transport::Unknown,
}

impl<'a> Stage<'a> {
    /// A stage with these nodes, all seen along directions from these proposals.
    fn new(evidence: &'a Evidence<'a>, unknown: &'a Unknown, material: MaterialId, kind: Kind, grid: Vec<f64>, proposals: &[f64]) -> Self {
        let nodes = alphas(kind, &grid);
        let proposals = proposals.iter().map(|a| [a * a; 2]).collect();
        let rough = Rough::new(material, kind.metal, kind.transmits, nodes, proposals);
        Self { evidence, unknown, kind, grid, what: transport::Unknown::Rough(Box::new(rough)) }
    }
}

impl Model for Stage<'_> {
    fn trace(&self, pixels: &[usize], samples: &[u32], seed: u64) -> Basis {
        let pixels = Pixels { numbers: pixels, samples, lens: &self.evidence.film.lens() };
        transport::trace(self.evidence.world, self.evidence.rules, &self.what, &pixels, 2, seed)
    }

    fn coefficients(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let transport::Unknown::Rough(rough) = &self.what else { unreachable!() };
        coefficients(self.kind, &rough.monomials, &self.grid, &self.unknown.reals(values))
    }

    fn trusted(&self, values: &[f64]) -> Vec<f64> {
        let mut values = values.to_vec();
        if let Some(i) = self.unknown.slots()[4] {
            values[i] = values[i].clamp(self.grid[0], self.grid[self.grid.len() - 1]);
        }
        values
    }
}

/// Nodes in equal ratio from `low` to `high`.
fn geometric(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| low * (high / low).powf(i as f64 / (count - 1) as f64)).collect()
}

/// Nodes in the ratio `ratio` around `middle`.
fn around(middle: f64, ratio: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| middle * ratio.powf(i as f64 - (count - 1) as f64 / 2.0)).collect()
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
    let name = unknown.material().kind.as_str();
    let kind = Kind::named(name).ok_or_else(|| unknown.material().error(format!("{name} is not a rough material")))?;
    let parameters = unknown.parameters();
    let bounds: Vec<(f64, f64)> = parameters.iter().map(|p| (p.low, p.high)).collect();
    let sheet = Sheet::new(evidence, pixels);
    let slot = unknown.slots()[4];
    let fixed = unknown.material().reals[4].abs();
    let (low, high) = slot.map_or((fixed, fixed), |i| bounds[i]);
    let (low, high) = (low.max(SMOOTHEST), high.max(SMOOTHEST * 1.5));

    // A first look at all roughnesses.
    tell("first look");
    let stage = Stage::new(evidence, unknown, material, kind, geometric(low, high, COARSE), &geometric(low.max(0.004), high, 5));
    let basis = stage.trace(pixels, &vec![FIRST_SAMPLES; pixels.len()], effort.seed);
    let gram = Gram::new(&basis, &sheet.target, &sheet.relative(), Form::Whole);
    let problem = Problem { gram: &gram, coefficients: &|v| stage.coefficients(v), bounds: &bounds };
    let mut best = search(&problem, unknown, effort.seed, &stage.grid, slot)?;

    // Closer looks at what is left of them, each around the answer of the one before, until it stays well inside.
    let roughness = |values: &[f64]| unknown.reals(values)[4].abs().max(SMOOTHEST);
    let mut seeds = Seeds::new(effort.seed);
    let mut last = false;
    let mut shares = vec![1.0; pixels.len()];
    for look in 1.. {
        tell(&format!("look {look}: {:.4?}", best.values));
        let middle = roughness(&best.values);
        let (nodes, ratio, proposals) = match last {
            false => (2 * transport::LANES, 1.25, vec![middle * 0.3, middle, middle * 3.0]),
            true => (transport::LANES, 1.15, vec![middle * 0.8, middle * 1.3]),
        };
        let mut stage = Stage::new(evidence, unknown, material, kind, around(middle, ratio, nodes), &proposals);
        stage.economise(&best.values);
        let rounds: &[f64] = if last { &LAST_SAMPLES } else { &CLOSE_SAMPLES };
        let near = |found: &Recovery| slot.is_none_or(|i| found.errors()[i] < NEAR * roughness(&found.values)) || effort.late();
        let enough = |found: &Recovery, before: Option<&Recovery>| if last { effort.contents(found, before) } else { near(found) };
        let (found, next) =
            Look { sheet: &sheet, bounds: &bounds, rounds, shares: &shares, effort: &effort }.at(&stage, &best.values, &mut seeds, &enough);
        shares = next;
        best = Point { values: found.values.clone(), chi2: found.chi2 };
        let a = roughness(&best.values);
        let inside = slot.is_none() || (a > stage.grid[1] && a < stage.grid[nodes - 2]) || a == SMOOTHEST;
        if last && inside || look == MOST_LOOKS {
            return Ok(found);
        }
        last |= inside;
    }
    unreachable!()
}

/// Looks before the search gives up to keep the answer inside the nodes.
const MOST_LOOKS: usize = 10;

/// Samples of a pixel in each half, round by round: of a closer look, and of the last one.
const CLOSE_SAMPLES: [f64; 5] = [16.0, 16.0, 32.0, 64.0, 128.0];
const LAST_SAMPLES: [f64; 6] = [16.0, 16.0, 32.0, 64.0, 128.0, 256.0];

/// A closer look has found the roughness when its relative standard error is this.
const NEAR: f64 = 0.1;

/// Samples of a pixel at the first look, in each half.
const FIRST_SAMPLES: u32 = 4;

impl Stage<'_> {
    /// Samples each part as often as it is worth with these values.
    fn economise(&mut self, values: &[f64]) {
        let a = self.unknown.reals(values);
        let transport::Unknown::Rough(rough) = &mut self.what else { unreachable!() };
        let color = (a[0] + a[1] + a[2]) / 3.0;
        let (diffuse, specular) = (color * (1.0 - a[3]), if self.kind.metal { color * a[3] } else { a[3] });
        let worth = (2.0 * diffuse / specular.max(1e-3)).clamp(0.125, 1.0);
        rough.guess = Some(parts(self.kind, &a).map(Rgb::from));
        rough.rates = [worth, 1.0, if a[4] < 0.05 { worth } else { 1.0 }];
    }
}

/// The deepest valley: annealing inside the bounds, and descents from every roughness in case it was not found.
fn search(problem: &Problem, unknown: &Unknown, seed: u64, grid: &[f64], roughness: Option<usize>) -> Result<Point> {
    let options = Options {
        seed,
        steps: STEPS,
        groups: unknown.groups().to_vec(),
        stages: vec![1.0],
        polish: false,
        tolerance: None,
        residuals: None,
    };
    let mut annealer = Annealer::new(unknown.parameters().to_vec(), options)?;
    while let Some(values) = annealer.propose() {
        let chi2 = problem.chi2(values);
        annealer.tell(chi2);
    }
    let all = vec![true; unknown.parameters().len()];
    let mut starts: Vec<Vec<f64>> = annealer.best().map(|b| b.values).into_iter().collect();
    for &a in grid {
        let mut values: Vec<f64> = unknown.parameters().iter().map(|p| 0.5 * (p.low + p.high)).collect();
        let mut free = all.clone();
        if let Some(i) = roughness {
            values[i] = a.clamp(unknown.parameters()[i].low, unknown.parameters()[i].high);
            free[i] = false;
        }
        starts.push(problem.polish(&values, &free).values);
    }
    let found = starts.iter().map(|start| problem.polish(start, &all)).min_by(|a, b| a.chi2.total_cmp(&b.chi2));
    Ok(found.unwrap_or(Point { values: starts.swap_remove(0), chi2: f64::INFINITY }))
}
