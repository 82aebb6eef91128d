//! What material it is: the numbers of an unknown that make the picture, how sure they are, and what they leave open.
//!
//! Simulated annealing over the transport basis finds the valley, coarse first and fine last; least squares find its bottom; the residuals of
//! the pixels tell how far it can be trusted (Sun and Wu 2002, section 5; the basis makes a χ² cost microseconds).

pub mod fit;
pub mod gram;
pub mod model;
mod rough;
mod statistics;

use crate::anneal::linear::Symmetric;
use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::picture::Picture;
use crate::render::Film;
use crate::rules::Rules;
use crate::scene::MaterialId;
use crate::unknown::Unknown;
use crate::world::World;
use rayon::prelude::*;
use std::time::{Duration, Instant};

/// What is known: the scene, the view, the picture.
pub struct Evidence<'a> {
    /// The scene, with the unknown at its starting values.
    pub world: &'a World,
    /// The rules of its light.
    pub rules: &'a Rules,
    /// The view.
    pub film: &'a Film,
    /// The picture of it, in radiance.
    pub target: &'a Picture,
    /// How much each pixel counts, from 0 to 1; all the same if `None`.
    pub mask: Option<&'a [f32]>,
}

/// How hard to try.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Fixes every random choice.
    pub seed: u64,
    /// When to end, if the answer is not as good as the picture allows before.
    pub until: Instant,
}

impl Effort {
    /// As much as fits into a time.
    pub fn of(seed: u64, time: Duration) -> Self {
        Self { seed, until: Instant::now() + time }
    }
}

/// What was found.
#[derive(Clone, Debug)]
pub struct Recovery {
    /// The values of the parameters.
    pub values: Vec<f64>,
    /// Covariance of the values, by all that makes the residuals: noise of the picture and of the rendering.
    pub covariance: Symmetric,
    /// The part of it that the rendering makes.
    pub own: Symmetric,
    /// χ² of equation 11 over the pixels that count, without what the noise of the rendering adds to it.
    pub chi2: f64,
    /// How many pixels count.
    pub pixels: usize,
}

impl Recovery {
    /// Whether the noise of the rendering hardly matters any more.
    fn settled(&self) -> bool {
        (0..self.values.len()).all(|i| self.own.at(i, i) <= 0.15 * self.covariance.at(i, i))
    }

    /// The standard error of each value.
    pub fn errors(&self) -> Vec<f64> {
        (0..self.values.len()).map(|i| self.covariance.at(i, i).max(0.0).sqrt()).collect()
    }
}

/// Recovers an unknown material of the scene. `tell` hears how far it is.
pub fn recover(evidence: &Evidence, unknown: &Unknown, material: MaterialId, effort: Effort, tell: &dyn Fn(&str)) -> Result<Recovery> {
    let pixels = covered(evidence, material);
    if pixels.is_empty() {
        return Err(Error::new(format!("no pixel of the picture shows `{}`: check the view and the mask", unknown.material().name)));
    }
    match unknown.material().kind.as_str() {
        "plastic" | "metal" | "trans" | "plastic2" | "metal2" | "trans2" => {
            rough::recover(evidence, unknown, material, &pixels, effort, tell)
        }
        kind => {
            Err(unknown.material().error(format!("the numbers of {kind} cannot be recovered; use plastic, metal, trans or dielectric")))
        }
    }
}

/// The pixels that show the material, and count.
fn covered(evidence: &Evidence, material: MaterialId) -> Vec<usize> {
    let lens = evidence.film.lens();
    (0..evidence.film.width * evidence.film.height)
        .into_par_iter()
        .filter(|&n| {
            evidence.mask.is_none_or(|mask| mask[n] > 0.0)
                && (0..16).any(|k| {
                    let at = [(k % 4) as f64 / 4.0 + 0.125, (k / 4) as f64 / 4.0 + 0.125];
                    lens(n, at).is_some_and(|(origin, direction, _)| evidence.world.shows(&Ray { origin, direction }, material))
                })
        })
        .collect()
}
