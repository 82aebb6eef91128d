//! Recovery of plastic, metal, trans and their anisotropic kin.

use super::fit::{Point, Problem};
use super::gram::{Form, Gram};
use super::model::{Kind, Model, alphas};
use super::statistics::{Channels, Sheet, covariances, pictures, shares};
use super::{Effort, Evidence, Recovery};
use crate::anneal::linear::Symmetric;
use crate::anneal::{Annealer, Options};
use crate::error::Result;
use crate::sampling::mix64;
use crate::scene::MaterialId;
use crate::transport::{self, Basis, Pixels, Rough};
use crate::unknown::Unknown;

/// The smallest roughness that a node stands for; below it a lobe is hardly to be told from a mirror's.
const SMOOTHEST: f64 = 0.002;

/// Nodes of the last look.
const MATCHED: usize = 3;
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
    /// A stage with these nodes, and with directions of their own for each, or from proposals if there are some.
    fn new(evidence: &'a Evidence<'a>, unknown: &'a Unknown, material: MaterialId, kind: Kind, grid: Vec<f64>, proposals: &[f64]) -> Self {
        let nodes = alphas(kind, &grid);
        let rough = match proposals {
            [] => Rough::matched(material, kind.metal, kind.transmits, nodes),
            _ => Rough::shared(material, kind.metal, kind.transmits, nodes, proposals.iter().map(|a| [a * a; 2]).collect()),
        };
        Self { evidence, unknown, kind, grid, what: transport::Unknown::Rough(Box::new(rough)) }
    }

    fn trace(&self, pixels: &[usize], samples: &[u32], seed: u64) -> Basis {
        let pixels = Pixels { numbers: pixels, samples, lens: &self.evidence.film.lens() };
        transport::trace(self.evidence.world, self.evidence.rules, &self.what, &pixels, 2, seed)
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
    let basis = stage.trace(pixels, &vec![FIRST_SAMPLES; pixels.len()], effort.seed);
    let gram = Gram::new(&basis, &sheet.target, &sheet.relative(), Form::Whole);
    let problem = Problem { gram: &gram, coefficients: &|v| stage.coefficients(v), bounds: &bounds };
    let mut best = search(&problem, unknown, effort.seed, &stage.grid, slot)?;

    // Closer looks at what is left of them, each around the answer of the one before, until it stays well inside.
    let roughness = |p: &Point| unknown.reals(&p.values)[4].abs().max(SMOOTHEST);
    let mut seeds = Seeds(effort.seed);
    let mut last = false;
    let mut shares = vec![1.0; pixels.len()];
    for look in 1.. {
        tell(&format!("look {look}: {:.4?}", best.values));
        let middle = roughness(&best);
        let (nodes, ratio, proposals) = match last {
            false => (2 * transport::LANES, 1.25, vec![middle * 0.3, middle, middle * 3.0]),
            true => (MATCHED, 1.2, vec![]),
        };
        let mut stage = Stage::new(evidence, unknown, material, kind, around(middle, ratio, nodes), &proposals);
        stage.economise(&best.values);
        let rounds: &[f64] = if last { &LAST_SAMPLES } else { &CLOSE_SAMPLES };
        let (found, next) = stage.look(&sheet, &best, &bounds, rounds, &shares, &mut seeds);
        shares = next;
        best = Point { values: found.values.clone(), chi2: found.chi2 };
        let a = roughness(&best);
        let inside = slot.is_none()
            || (if last { a > stage.grid[0] && a < stage.grid[nodes - 1] } else { a >= stage.grid[1] && a <= stage.grid[nodes - 2] })
            || a == SMOOTHEST;
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
const CLOSE_SAMPLES: [f64; 1] = [16.0];
const LAST_SAMPLES: [f64; 3] = [16.0, 16.0, 32.0];

/// The fewest and the most samples of a pixel in each half of a round, whatever its share.
const SAMPLES: (f64, f64) = (4.0, 1024.0);

/// A seed for every tracing.
struct Seeds(u64);

impl Seeds {
    fn next(&mut self) -> u64 {
        self.0 = mix64(self.0.wrapping_add(0x9e37_79b9_7f4a_7c15));
        self.0
    }
}

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
        rough.rates = [worth, 1.0, if a[4] < 0.05 { worth } else { 1.0 }];
    }

    /// Traces and fits, round by round, until the noise of the rendering hardly matters.
    fn look(
        &self,
        sheet: &Sheet,
        near: &Point,
        bounds: &[(f64, f64)],
        rounds: &[f64],
        shares: &[f64],
        seeds: &mut Seeds,
    ) -> (Recovery, Vec<f64>) {
        let mut best = near.values.clone();
        let mut basis: Option<Basis> = None;
        for (round, mean) in rounds.iter().enumerate() {
            let samples: Vec<u32> = shares.iter().map(|share| (mean * share).clamp(SAMPLES.0, SAMPLES.1) as u32).collect();
            let mut all = self.trace(sheet.numbers, &samples, seeds.next());
            if let Some(before) = &basis {
                all.join(before);
            }
            let halves = pictures(&all, &self.coefficients(&best));
            let variance = sheet.variance(&halves, &all.samples);
            let weights = sheet.by_variance(&halves, &variance);
            let gram = Gram::new(&all, &sheet.target, &weights, Form::Whole);
            let problem = Problem { gram: &gram, coefficients: &|v| self.coefficients(v), bounds };
            best = problem.polish(&best, &vec![true; bounds.len()]).values;
            let (found, shares) = self.conclude(&all, sheet, &weights, &variance, &problem, &best);
            if round + 1 == rounds.len() || found.settled() {
                return (found, shares);
            }
            basis = Some(all);
        }
        unreachable!("a look has rounds")
    }

    /// What the bottom of a valley is worth: the values there, freed of the bias of the rendering's noise, and their covariance.
    fn conclude(
        &self,
        basis: &Basis,
        sheet: &Sheet,
        weights: &Channels,
        variance: &[[f64; 3]],
        problem: &Problem,
        values: &[f64],
    ) -> (Recovery, Vec<f64>) {
        let count = values.len();
        let x = self.coefficients(values);
        let jacobian = problem.jacobian(values);
        let matrix = problem.gram.normal_equations(&x, &jacobian).1;
        let matrix = Symmetric::of(count, |i, j| matrix[i][j]);
        let halves = pictures(basis, &x);
        let derivatives: Vec<Vec<Vec<[f64; 3]>>> = jacobian.iter().map(|j| pictures(basis, j)).collect();
        let mean =
            |d: &Vec<Vec<[f64; 3]>>| (0..sheet.target.len()).map(|p| std::array::from_fn(|c| 0.5 * (d[0][p][c] + d[1][p][c]))).collect();
        let means: Vec<Vec<[f64; 3]>> = derivatives.iter().map(mean).collect();
        let nothing = Symmetric::diagonal(&vec![f64::INFINITY; count]);
        let covariance = covariances(&matrix, &sheet.target, weights, &halves, &means);
        let (covariance, own) = covariance.unwrap_or((nothing.clone(), nothing));
        // One step of Newton's with the score of one half against the other: that has no bias, and this matrix is safe.
        let residual = |p: usize, c: usize, set: usize| sheet.target[p][c] as f64 - halves[set][p][c];
        let score = |d: &Vec<Vec<[f64; 3]>>| -> f64 {
            let at = |p: usize, c: usize| weights[p][c] as f64 * 0.5 * (d[0][p][c] * residual(p, c, 1) + d[1][p][c] * residual(p, c, 0));
            (0..sheet.target.len()).map(|p| (0..3).map(|c| at(p, c)).sum::<f64>()).sum()
        };
        let mut values = values.to_vec();
        let mut next = vec![1.0; sheet.numbers.len()];
        if let Some(inverse) = matrix.inverse() {
            let errors: Vec<f64> = (0..count).map(|i| covariance.at(i, i).sqrt()).collect();
            next = shares(&inverse, &errors, weights, variance, &means);
            let step = inverse.times(&derivatives.iter().map(score).collect::<Vec<_>>());
            for (i, s) in step.iter().enumerate() {
                values[i] = (values[i] + s).clamp(problem.bounds[i].0, problem.bounds[i].1);
            }
        }
        let chi2 = (0..sheet.target.len()).map(|p| (0..3).map(|c| residual(p, c, 0) * residual(p, c, 1)).sum::<f64>()).sum();
        (Recovery { values, covariance, own, chi2, pixels: sheet.numbers.len() }, next)
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
