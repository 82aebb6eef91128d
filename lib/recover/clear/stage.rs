//! The model of a transparent unknown: the picture at a few indices of refraction, each by what it lets through.

use super::WIDEST;
use super::through::{DARKEST, Through};
use crate::color::Rgb;
use crate::material::hartmann;
use crate::recover::Recovery;
use crate::recover::foresight::at_a_glance;
use crate::recover::look::Model;
use crate::recover::model::{cubic, exposed, lagrange};
use crate::recover::seen::First;
use crate::recover::sheet::Sheet;
use crate::transport::{self, Basis, Clear, Explored, Pixels, depth};
use std::ops::Range;

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

/// Which part of the change between its indices must not be noise for the pixels to tell one between them.
const TOLD: f64 = 0.15;

/// Indices, and the bases there.
pub struct Stage<'a> {
    /// What is looked at.
    pub through: &'a Through<'a>,
    indices: Vec<f64>,
    parts: Vec<Clear>,
    /// Where the columns stand by what they let through.
    depths: Vec<f64>,
    /// What the values are, as far as is known.
    known: Option<Vec<f64>>,
}

impl<'a> Stage<'a> {
    /// A stage of these indices, without what Hartmann's constant adds to them.
    pub fn new(through: &'a Through<'a>, indices: Vec<f64>) -> Self {
        let Through { unknown, material, length, .. } = through;
        let glass = unknown.material().kind == "glass";
        let constant = unknown.reals(&unknown.start()).get(4).copied().unwrap_or(0.0);
        let parts: Vec<Clear> = indices.iter().map(|&index| Clear::new(*material, glass, hartmann(index, constant), *length)).collect();
        let depths = parts[0].nodes.iter().map(|t| depth(*t)).collect();
        Self { through, indices, parts, depths, known: None }
    }

    /// The weights of the columns of each channel in the basis of one index.
    pub fn columns(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let a = self.through.unknown.reals(values);
        exposed(std::array::from_fn(|c| between(&self.depths, a[c].clamp(0.0, 1.0))), self.through.unknown.exposures(values))
    }

    /// Whether the pixels tell its index between those of the stage, or not between farther ones either.
    pub fn tells(&self, found: &Recovery) -> bool {
        let wide = self.indices[self.indices.len() - 1] - self.indices[0] > WIDEST;
        wide || self.through.slot().is_none_or(|i| found.clarity[i] > TOLD)
    }
}

impl Model for Stage<'_> {
    fn tune(&mut self, values: &[f64], _: Option<&[f64]>) {
        self.known = Some(values.to_vec());
        let a = self.through.unknown.reals(values);
        let extinction = Rgb::from(std::array::from_fn(|c| -a[c].clamp(DARKEST, 1.0).ln() / self.through.length));
        self.parts.iter_mut().for_each(|part| part.guess = extinction);
    }

    fn trace(&self, pixels: &[usize], samples: &[Range<u32>], seed: u64) -> Basis {
        let guess = self.known.as_ref().map(|values| self.columns(values));
        let pixels = Pixels { numbers: pixels, samples, lens: &self.through.evidence.film.lens(), picture: guess.as_ref() };
        let at =
            |clear| transport::trace(self.through.evidence.world, self.through.evidence.rules, Explored::Clear(clear), &pixels, 2, seed);
        Basis::beside(&self.parts.iter().map(at).collect::<Vec<_>>())
    }

    fn coefficients(&self, values: &[f64]) -> [Vec<f64>; 3] {
        let columns = self.columns(values);
        let indices = if self.indices.len() > 1 { cubic(&self.indices, self.through.index(values)) } else { vec![1.0] };
        columns.map(|columns| indices.iter().flat_map(|n| columns.iter().map(move |c| n * c)).collect())
    }

    fn trusted(&self, values: &[f64]) -> Vec<f64> {
        let mut values = values.to_vec();
        if let Some(i) = self.through.slot() {
            values[i] = values[i].clamp(self.indices[0], self.indices[self.indices.len() - 1]);
        }
        values
    }

    fn doubtful(&self, _: &Recovery) -> Vec<(usize, Vec<f64>)> {
        vec![]
    }

    fn telling(&self, pixels: &[usize], seed: u64) -> Option<Vec<f64>> {
        let near = self.known.as_ref()?;
        Some(at_a_glance(self, near, &self.through.unknown.bounds(), &Sheet::new(self.through.evidence, pixels), seed))
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
        self.through.slot().is_none_or(|i| inside(found.values[i])) && self.tells(found)
    }

    fn presumed(&self, _: &Recovery, _: &Basis) -> f64 {
        0.0
    }
}

/// The weights of columns at some depths for what is let through.
fn between(depths: &[f64], transmissivity: f64) -> Vec<f64> {
    lagrange(depths, depth(transmissivity), POINTS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::MaterialId;

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
