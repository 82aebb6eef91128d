//! A transparent unknown by what paths through it let through.

use crate::anneal::linear::Symmetric;
use crate::geometry::Ray;
use crate::material::GLASS_INDEX;
use crate::recover::{Evidence, Recovery};
use crate::scene::MaterialId;
use crate::unknown::Unknown;
use rayon::prelude::*;

/// The smallest index that is looked at.
pub const LEAST_INDEX: f64 = 0.2;
/// The least that roulette takes a transmissivity for.
pub const DARKEST: f64 = 1e-3;

/// An unknown by what paths through it let through: in another unit of length its picture would be the same, and so would this. What a unit of
/// length lets through is a needle at 1 where that is short beside the object, and one at 0 where it is long.
pub struct Through<'a> {
    /// What is known.
    pub evidence: &'a Evidence<'a>,
    /// Its place among the materials of the scene.
    pub material: MaterialId,
    /// The unknown with such colours.
    pub unknown: Unknown,
    /// About how far paths go inside: the mean way straight through. 1 for glass, which has no inside, and where nothing is behind it.
    pub length: f64,
    /// The places of the colours among the parameters.
    colors: Vec<usize>,
}

/// So many pixels of a film tell the mean way through.
const WAYS: usize = 50_000;

impl<'a> Through<'a> {
    /// What to look for instead of an unknown.
    pub fn new(evidence: &'a Evidence<'a>, unknown: &Unknown, material: MaterialId) -> Self {
        let (film, lens) = (evidence.film, evidence.film.lens());
        let way = |n: usize| {
            let (origin, direction, _) = lens(n, [0.5; 2])?;
            let inside = evidence.world.behind(&Ray { origin, direction }, material)?;
            evidence.world.nearest(&inside, f64::INFINITY).map(|hit| hit.t)
        };
        let glass = unknown.material().kind == "glass";
        let pixels: Vec<usize> = film.some(if glass { 0 } else { WAYS }).collect();
        let ways: Vec<f64> = pixels.into_par_iter().filter_map(way).collect();
        let length = if ways.is_empty() { 1.0 } else { ways.iter().sum::<f64>() / ways.len() as f64 };
        let colors = unknown.slots()[..3].iter().copied().flatten().collect();
        Self { evidence, material, unknown: unknown.through(length), length, colors }
    }

    /// The place of the index among the parameters, if it is one.
    pub fn slot(&self) -> Option<usize> {
        self.unknown.slots().get(3).copied().flatten()
    }

    /// The index among these values of the unknown.
    pub fn index(&self, values: &[f64]) -> f64 {
        self.unknown.reals(values).get(3).copied().unwrap_or(GLASS_INDEX)
    }

    /// The place of a colour that lets nothing through within its bounds, as far as numbers go.
    pub fn dark(&self) -> Option<usize> {
        let bounds = self.unknown.bounds();
        self.colors.iter().copied().find(|&i| bounds[i].0 >= bounds[i].1)
    }

    /// From where to where each value is sought: an index of less than `LEAST_INDEX` bends light no further.
    pub fn bounds(&self) -> Vec<(f64, f64)> {
        let mut bounds = self.unknown.bounds();
        if let Some(i) = self.slot() {
            bounds[i] = (bounds[i].0.max(LEAST_INDEX), bounds[i].1.max(LEAST_INDEX));
        }
        bounds
    }

    /// The values for those of the unknown itself.
    pub fn values(&self, values: &[f64]) -> Vec<f64> {
        let value = |(i, v): (usize, &f64)| if self.colors.contains(&i) { v.max(0.0).powf(self.length) } else { *v };
        values.iter().enumerate().map(value).collect()
    }

    /// What a value here is one of in the unknown itself.
    fn own(&self, i: usize, value: f64) -> f64 {
        if self.colors.contains(&i) { value.clamp(0.0, 1.0).powf(1.0 / self.length) } else { value }
    }

    /// By how much a value of the unknown itself changes with one here.
    pub fn rate(&self, i: usize, value: f64) -> f64 {
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
    pub fn found(&self, mut found: Recovery) -> Recovery {
        let rates = self.rates(&found.values, &found.covariance);
        for matrix in [&mut found.covariance, &mut found.own, &mut found.common] {
            *matrix = matrix.scaled(&rates);
        }
        found.values = found.values.iter().enumerate().map(|(i, value)| self.own(i, *value)).collect();
        found
    }
}
