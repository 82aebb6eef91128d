//! Recovery of plastic, metal, trans and their anisotropic kin.

use super::fit::{Point, Problem};
use super::gram::{Form, Gram};
use super::model::{Kind, Model, alphas};
use super::statistics::{Channels, Sheet, covariances, pictures};
use super::{Effort, Evidence, Recovery};
use crate::anneal::{Annealer, Options};
use crate::anneal::linear::Symmetric;
use crate::error::Result;
use crate::scene::MaterialId;
use crate::transport::{self, Basis, Pixels, Rough};
use crate::unknown::Unknown;
use std::time::Instant;

/// The smallest roughness that a node stands for; below it a lobe is hardly to be told from a mirror's.
const SMOOTHEST: f64 = 0.002;

/// Nodes of the first look, and their proposals.
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
    fn new(evidence: &'a Evidence<'a>, unknown: &'a Unknown, material: MaterialId, kind: Kind, grid: Vec<f64>, proposals: &[f64]) -> Self {
        let rough = Rough::new(material, kind.metal, kind.transmits, alphas(kind, &grid), proposals.iter().map(|a| [a * a; 2]).collect());
        Self { evidence, unknown, kind, grid, what: transport::Unknown::Rough(rough) }
    }

    fn trace(&self, pixels: &[usize], sets: usize, samples: u32, seed: u64) -> Basis {
        let lens = self.evidence.film.lens();
        transport::trace(self.evidence.world, self.evidence.rules, &self.what, &Pixels { numbers: pixels, lens: &lens }, sets, samples, seed)
    }

    /// The coefficients of the columns for values of the parameters.
    fn coefficients(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let transport::Unknown::Rough(rough) = &self.what else { unreachable!() };
        Model::new(self.kind, &rough.monomials, &self.grid).coefficients(&self.unknown.reals(values))
    }
}

/// Nodes in equal ratio from `low` to `high`.
fn geometric(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| low * (high / low).powf(i as f64 / (count - 1) as f64)).collect()
}

/// Nodes in the ratio `ratio` around `middle`.
fn around(middle: f64, ratio: f64) -> Vec<f64> {
    (0..transport::LANES).map(|i| middle * ratio.powf(i as f64 - (transport::LANES - 1) as f64 / 2.0)).collect()
}

/// Recovers the numbers.
pub fn recover(evidence: &Evidence, unknown: &Unknown, material: MaterialId, pixels: &[usize], effort: Effort, tell: &dyn Fn(&str)) -> Result<Recovery> {
    let name = unknown.material().kind.as_str();
    let kind = Kind { metal: name.starts_with("metal"), transmits: name.starts_with("trans"), anisotropic: name.ends_with('2') };
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
    let basis = stage.trace(pixels, 2, 4, effort.seed);
    let gram = Gram::new(&basis, &sheet.target, &sheet.relative(), Form::Whole);
    let problem = Problem { gram: &gram, coefficients: &|v| stage.coefficients(v), bounds: &bounds };
    let mut best = search(&problem, unknown, effort.seed, &stage.grid, slot)?;

    // A closer one at those that are left.
    let roughness = |p: &Point| unknown.reals(&p.values)[4].max(SMOOTHEST);
    for round in 0..4 {
        tell("closer look");
        let middle = roughness(&best);
        let stage = Stage::new(evidence, unknown, material, kind, around(middle, 1.3), &[middle * 0.5, middle, middle * 2.0]);
        let basis = stage.trace(pixels, 2, 8, effort.seed ^ (round + 1) << 32);
        let x = stage.coefficients(&best.values);
        let gram = Gram::new(&basis, &sheet.target, &sheet.by_variance(&pictures(&basis, &x), 8.0), Form::Whole);
        let problem = Problem { gram: &gram, coefficients: &|v| stage.coefficients(v), bounds: &bounds };
        best = problem.polish(&best.values, &vec![true; bounds.len()]);
        let a = roughness(&best);
        if a > stage.grid[1] && a < stage.grid[transport::LANES - 2] {
            break;
        }
    }

    // The last look, with as many samples as the answer or the time allows.
    let middle = roughness(&best);
    let stage = Stage::new(evidence, unknown, material, kind, around(middle, 1.15), &[middle * 0.8, middle * 1.3]);
    let mut sum: Option<(Basis, u32)> = None;
    loop {
        let done = sum.as_ref().map_or(0, |(_, n)| *n);
        tell(&format!("last look, {} samples", 2 * done));
        let more = if done == 0 { 16 } else { 8 };
        let start = Instant::now();
        let fresh = stage.trace(pixels, 2, more, effort.seed ^ (done as u64 + 100) << 32);
        let took = start.elapsed();
        let (basis, samples) = match sum.take() {
            None => (fresh, more),
            Some((mut basis, n)) => {
                let (a, b) = (n as f32 / (n + more) as f32, more as f32 / (n + more) as f32);
                basis.values.iter_mut().zip(&fresh.values).for_each(|(v, f)| *v = a * *v + b * f);
                (basis, n + more)
            }
        };
        if Instant::now() + took < effort.until {
            sum = Some((basis, samples));
            continue;
        }
        let x = stage.coefficients(&best.values);
        let weights = sheet.by_variance(&pictures(&basis, &x), samples as f64);
        return Ok(conclude(&stage, &basis, &sheet, &weights, &best, &bounds));
    }
}

/// The values at the bottom of the valley, and their errors.
fn conclude(stage: &Stage, basis: &Basis, sheet: &Sheet, weights: &Channels, near: &Point, bounds: &[(f64, f64)]) -> Recovery {
    let gram = Gram::new(basis, &sheet.target, weights, Form::Halves);
    let problem = Problem { gram: &gram, coefficients: &|v| stage.coefficients(v), bounds };
    let best = problem.polish(&near.values, &vec![true; bounds.len()]);
    let x = stage.coefficients(&best.values);
    let jacobian = problem.jacobian(&best.values);
    let (_, matrix) = gram.normal_equations(&x, &jacobian);
    let matrix = Symmetric::of(bounds.len(), |i, j| matrix[i][j]);
    let shown = pictures(basis, &x);
    let halves = |x: &[Vec<f64>; 3]| {
        let sets = pictures(basis, x);
        (0..sheet.target.len()).map(|p| std::array::from_fn(|c| 0.5 * (sets[0][p][c] + sets[1][p][c]))).collect::<Vec<[f64; 3]>>()
    };
    let derivatives: Vec<Vec<[f64; 3]>> = jacobian.iter().map(halves).collect();
    let unknown = Symmetric::diagonal(&vec![f64::INFINITY; bounds.len()]);
    let (covariance, own) = covariances(&matrix, &sheet.target, weights, &shown, &derivatives).unwrap_or((unknown.clone(), unknown));
    let residual = |p: usize, c: usize, set: usize| sheet.target[p][c] as f64 - shown[set][p][c];
    let chi2 = (0..sheet.target.len()).map(|p| (0..3).map(|c| residual(p, c, 0) * residual(p, c, 1)).sum::<f64>()).sum();
    Recovery { values: best.values, covariance, own, chi2, pixels: sheet.numbers.len() }
}

/// The deepest valley: annealing inside the bounds, and descents from every roughness in case it was not found.
fn search(problem: &Problem, unknown: &Unknown, seed: u64, grid: &[f64], roughness: Option<usize>) -> Result<Point> {
    let options =
        Options { seed, steps: STEPS, groups: unknown.groups().to_vec(), stages: vec![1.0], polish: false, tolerance: None, residuals: None };
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
