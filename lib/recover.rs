//! What material it is: the numbers of an unknown that make the picture, how sure they are, and what they leave open.
//!
//! Simulated annealing over the transport basis finds the valley, coarse first and fine last; least squares find its bottom; the residuals of
//! the pixels tell how far it can be trusted (Sun and Wu 2002, section 5; the basis makes a χ² cost microseconds).

pub mod answer;
pub mod around;
mod average;
mod clear;
pub mod cut_out;
pub mod dead;
pub mod doubts;
mod drift;
mod enough;
mod farther;
mod fit;
mod foresight;
mod gram;
pub mod inside_out;
mod look;
mod median;
pub mod misfit;
pub mod model;
mod polished;
pub mod predict;
mod rough;
pub mod saturated;
mod scores;
mod seen;
mod settle;
mod sharpness;
mod sheet;
mod total;
pub mod types;
pub mod words;

use crate::anneal::linear::Symmetric;
use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::picture::Picture;
use crate::render::{Budget, Film, Filter, Rendering, Task, render};
use crate::rules::Rules;
use crate::sampling::mix64;
use crate::scene::MaterialId;
use crate::unknown::Unknown;
use crate::world::World;
use doubts::Known;
use misfit::Misfit;
use model::Kind;
pub use polished::{begun, otherwise};
use rayon::prelude::*;
use rough::Sought;
use saturated::Saturated;
use serde::{Deserialize, Serialize};
pub use sharpness::Blur;
use std::collections::BTreeSet;
use std::time::Instant;

/// What is known: the scene, the view, the picture.
pub struct Evidence<'a> {
    /// The scene, with the unknown as it is [`begun`].
    pub world: &'a World,
    /// The same with the unknown as [`otherwise`] says, if it says anything.
    pub otherwise: Option<&'a World>,
    /// The rules of its light.
    pub rules: &'a Rules,
    /// The view.
    pub film: &'a Film,
    /// The picture of it, in radiance.
    pub target: &'a Picture,
    /// The distance between each of its values and the next that its file could have held ([`Picture::steps`]), if it was in a file.
    pub steps: Option<&'a [[f32; 3]]>,
    /// How much each pixel counts, from 0 to 1; all the same if `None`.
    pub mask: Option<&'a [f32]>,
    /// Whether the picture is of the unknown alone, cut out on black.
    pub alone: bool,
    /// Whether its pixels may be blurred otherwise than the view's: then that is found too.
    pub blurred: bool,
}

/// How hard to try.
#[derive(Clone, Copy)]
pub struct Effort<'a> {
    /// Fixes every random choice.
    pub seed: u64,
    /// When to end, if not when the noise of the rendering hardly matters any more: asked again and again, since it may change its mind.
    pub until: &'a (dyn Fn() -> Option<Instant> + Sync),
    /// The standard error that every value is to have, if not what the picture allows.
    pub tolerance: Option<f64>,
    /// About where the values are, if that is known.
    pub around: Option<&'a [f64]>,
    /// Only look at what can be seen at once: enough to compare types of material.
    pub quick: bool,
    /// Whether pixels that seem [`saturated`] are left out.
    pub wary: bool,
    /// `rate(i, x)`: by how much the value of parameter i that is told changes with the one that is searched for, where that is x.
    pub rate: &'a (dyn Fn(usize, f64) -> f64 + Sync),
    /// Who is told what each round found.
    pub told: &'a (dyn Fn(&Recovery) + Sync),
}

/// What was found.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Recovery {
    /// The values of the parameters.
    pub values: Vec<f64>,
    /// Covariance of the values, by all that makes the residuals: noise of the picture and of the rendering.
    pub covariance: Symmetric,
    /// The part of it that the rendering makes.
    pub own: Symmetric,
    /// The covariance of the values if all pixels had one relative error of `sheet::COMMON`, with the signs that do most harm.
    pub common: Symmetric,
    /// What is left of it that no noise is.
    pub misfit: Misfit,
    /// How its pixels are blurred, if there is any saying.
    pub blur: Option<Blur>,
    /// χ² of equation 11 over the pixels that count, without what the noise of the rendering adds to it.
    pub chi2: f64,
    /// How many pixels count.
    pub pixels: usize,
    /// The number of each of them, and the square by which it is off where all together fit best, relatively, without the noise of the rendering: about 0,
    /// and below it too, where it fits. Empty in one that was kept.
    #[serde(skip)]
    pub losses: Vec<(usize, f64)>,
    /// The numbers of those that are far brighter than anything explains. Empty in one that was kept.
    #[serde(skip)]
    pub strays: Vec<usize>,
    /// Those that seem [`saturated`], and the channel in which each does: they are left out, unless hardly any others are left. Empty in one that was kept.
    #[serde(skip)]
    pub saturated: Vec<Saturated>,
    /// How much of the derivative by each value is not noise, from 0 to 1. Empty in one that was kept.
    #[serde(skip)]
    pub clarity: Vec<f64>,
    /// Whether each value surely would go on if a bound did not keep it.
    pub pressed: Vec<bool>,
}

impl<'a> Effort<'a> {
    /// To find all that is unknown, wherever it is.
    pub fn new(seed: u64, tolerance: Option<f64>, until: &'a (dyn Fn() -> Option<Instant> + Sync)) -> Self {
        Self { seed, until, tolerance, around: None, quick: false, wary: true, rate: &|_, _| 1.0, told: &|_| {} }
    }

    /// Whether time is over.
    pub fn late(&self) -> bool {
        (self.until)().is_some_and(|until| Instant::now() >= until)
    }

    /// The end of the first of so many equal parts of the time that is left.
    pub fn part(&self, parts: u32) -> Option<Instant> {
        let now = Instant::now();
        (self.until)().map(|until| now + until.saturating_duration_since(now) / parts)
    }

    /// Whether there is time for one more look that takes as long as those since `begin` on the average.
    pub fn affords_another(&self, begin: Instant, looks: u32) -> bool {
        !self.quick && (self.until)().is_none_or(|until| Instant::now() + begin.elapsed() / looks <= until)
    }
}

/// A seed for every tracing.
struct Seeds {
    state: u64,
}

impl Seeds {
    fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    fn next(&mut self) -> u64 {
        self.state = mix64(self.state.wrapping_add(0x9e37_79b9_7f4a_7c15));
        self.state
    }
}

impl Recovery {
    /// The standard error of each value.
    pub fn errors(&self) -> Vec<f64> {
        self.covariance.deviations()
    }

    /// One of these values with these standard errors, for tests.
    #[cfg(test)]
    fn plain(values: &[f64], errors: &[f64]) -> Self {
        let covariance = Symmetric::diagonal(&errors.iter().map(|error| error * error).collect::<Vec<_>>());
        Self {
            values: values.to_vec(),
            own: covariance.clone(),
            common: covariance.scaled(&vec![0.0; values.len()]),
            covariance,
            misfit: Misfit::default(),
            blur: None,
            chi2: 0.0,
            pixels: 64,
            losses: vec![],
            strays: vec![],
            saturated: vec![],
            clarity: vec![1.0; values.len()],
            pressed: vec![false; values.len()],
        }
    }

    /// Whether those that seem saturated count, as hardly any others are left.
    pub fn counts_saturated(&self) -> bool {
        let saturated: BTreeSet<usize> = self.saturated.iter().map(|&(n, _)| n).collect();
        self.losses.iter().any(|(n, _)| saturated.contains(n))
    }

    /// Whether noise may be all that is left of the picture.
    pub fn explained(&self) -> bool {
        self.misfit.is_noise()
    }

    /// The part of the variance of a value that the noise of the rendering makes; all of it where nothing is known.
    fn own_part(&self, i: usize) -> f64 {
        (self.own.at(i, i) / self.covariance.at(i, i)).min(1.0)
    }

    /// How its pixels are blurred, if that was to be found.
    pub fn sharpness(&self) -> Option<Blur> {
        self.blur.filter(|blur| blur.sought)
    }

    /// What is to be said of how they were found to be blurred: what is elsewhere than it should be seems blurred too.
    pub fn filter(&self) -> Option<String> {
        let otherwise = if self.explained() { "" } else { ", or something else is not as in the picture" };
        self.sharpness().map(|blur| blur.title() + otherwise)
    }

    /// How pixels are blurred, if they surely are blurred otherwise than they were taken to be.
    fn amiss(&self) -> Option<Blur> {
        self.sharpness().filter(Blur::is_sure)
    }

    /// By how many standard errors the pixels that both have seen are farther off than in another.
    fn excess(&self, other: &Self) -> f64 {
        farther::farther_off(&self.losses, &other.losses)
    }

    /// The same by all pixels alike.
    fn excess_alike(&self, other: &Self) -> f64 {
        farther::farther_off_alike(&self.losses, &other.losses)
    }

    /// How far all its pixels are off.
    fn loss(&self) -> f64 {
        self.losses.iter().map(|(_, loss)| farther::counted(*loss)).sum()
    }

    /// What is known of the errors of the values.
    pub fn known(&self) -> Known<'_> {
        Known {
            covariance: self.covariance.clone(),
            common: Some(&self.common),
            pressed: &self.pressed,
            misfit: self.misfit,
            blur: self.blur.filter(|blur| !blur.sought),
        }
    }
}

impl Evidence<'_> {
    /// The pixels that show the unknown, and count; errors if there is none, or one is not finite. In an illumination field it must cover them wholly.
    pub fn pixels(&self, unknown: &Unknown, material: MaterialId) -> Result<Vec<usize>> {
        self.pixels_in_parts(1, unknown, material)
    }

    /// Of the [`Self::pixels`] of a large picture no more, in tiles all over it, than a recovery looks at.
    pub fn enough_pixels(&self, unknown: &Unknown, material: MaterialId) -> Result<Vec<usize>> {
        self.pixels_in_parts((self.film.width * self.film.height).div_ceil(LARGE), unknown, material)
    }

    /// The [`Self::enough_pixels`]; errors if the picture is black in all, but where something else is seen beside it.
    pub fn telling_pixels(&self, unknown: &Unknown, material: MaterialId) -> Result<Vec<usize>> {
        let pixels = self.enough_pixels(unknown, material)?;
        if dead::all(self, &pixels, material) {
            let remedy = inside_out::said(self, unknown, material)
                .unwrap_or_else(|| "check that it is the right one, and the view and the mask".into());
            return Err(Error::new(format!("the picture is black wherever it shows `{}`: {remedy}", unknown.material().name)));
        }
        Ok(pixels)
    }

    /// The [`Self::pixels`] of a picture in so many parts, of as many parts as have enough.
    fn pixels_in_parts(&self, parts: usize, unknown: &Unknown, material: MaterialId) -> Result<Vec<usize>> {
        let isolated = self.isolated();
        let shown = |n: &usize| self.counts(*n) && if isolated { self.whole(*n, material) } else { self.touches(*n, material) };
        let Film { width, height, .. } = *self.film;
        let mut tiles = vec![vec![]; parts];
        for (row, column) in (0..height.div_ceil(TILE)).flat_map(|row| (0..width.div_ceil(TILE)).map(move |column| (row, column))) {
            tiles[(mix64((row * width + column) as u64) % parts as u64) as usize].push([row, column].map(|at| TILE * at));
        }
        let within = |[top, left]: [usize; 2]| {
            let columns = left..(left + TILE).min(width);
            (top..(top + TILE).min(height)).flat_map(move |y| columns.clone().map(move |x| y * width + x))
        };
        let mut pixels = Vec::new();
        for part in tiles {
            if pixels.len() < ENOUGH {
                pixels.par_extend(part.into_par_iter().flat_map_iter(within).filter(shown));
            }
        }
        pixels.sort_unstable();
        if pixels.is_empty() {
            return Err(Error::new(format!(
                "no pixel of the picture {} `{}`, by itself, in a mirror or through panes of glass (in a body of dielectric it is not looked for): check \
                 the view and the mask",
                if isolated { "shows nothing but" } else { "shows" },
                unknown.material().name
            )));
        }
        match self.target.infinite(pixels.iter().copied()) {
            Some(wrong) => Err(Error::new(format!("the picture's {wrong}; leave such out with --mask"))),
            None => Ok(pixels),
        }
    }

    /// Some pixels of a world in its view, by a few samples each.
    pub fn rendered(&self, world: &World, pixels: &[usize], seed: u64) -> Rendering {
        let lens = self.film.lens();
        let of_pixel = |i: usize, at| lens(pixels[i], at);
        let task = Task::new(world, self.rules, self.film, &of_pixel, Budget::Samples(SAMPLES), seed);
        render(&Task { count: pixels.len(), width: pixels.len(), ..task }, &|| false, &mut |_| {})
    }

    /// Whether a pixel counts.
    pub fn counts(&self, n: usize) -> bool {
        self.mask.is_none_or(|mask| mask[n] > 0.0)
    }

    /// Whether nothing is known of what is seen beside the unknown: it is not in an illumination field, and was cut off where the unknown was cut out.
    pub fn isolated(&self) -> bool {
        self.alone || self.world.has_field()
    }

    /// Whether a pixel holds no light but the unknown's: that of a filter's neighbours counts too.
    fn whole(&self, n: usize, material: MaterialId) -> bool {
        let reach = usize::from(self.film.filter.beyond().is_some());
        self.film.around(n, reach).all(|beside| self.filled(beside, material))
    }

    /// Whether the unknown is seen somewhere in a pixel.
    pub fn touches(&self, n: usize, material: MaterialId) -> bool {
        (0..16).map(|k| [k % 4, k / 4].map(|i| i as f64 / 4.0 + 0.125)).any(|at| self.shows(n, at, material))
    }

    /// Whether the unknown covers a pixel to its corners.
    pub fn filled(&self, n: usize, material: MaterialId) -> bool {
        (0..25).map(|k| [k % 5, k / 5].map(|i| i as f64 / 4.0)).all(|at| self.shows(n, at, material))
    }

    fn shows(&self, n: usize, at: [f64; 2], material: MaterialId) -> bool {
        self.film.lens()(n, at).is_some_and(|(origin, direction, limit)| self.world.shows(&Ray { origin, direction }, limit, material))
    }
}

/// Errors unless the numbers of the unknown's type can be recovered.
fn supported(unknown: &Unknown) -> Result<()> {
    let material = unknown.material();
    if material.kind == "dielectric" && unknown.slots()[4].is_some() {
        return Err(material.error("a picture does not tell Hartmann's constant from the index; give it, and --fix hartmann"));
    }
    if Kind::named(&material.kind).is_some() || clear::KINDS.contains(&material.kind.as_str()) {
        return Ok(());
    }
    Err(material.error(format!(
        "the numbers of {} cannot be recovered; use plastic, metal, trans, plastic2, metal2, trans2, dielectric or glass",
        material.kind
    )))
}

/// Recovers an unknown material of the scene. `tell` hears how far it is.
pub fn recover(evidence: &Evidence, unknown: &Unknown, material: MaterialId, effort: Effort, tell: &dyn Fn(&str)) -> Result<Recovery> {
    supported(unknown)?;
    let mut film = evidence.film.clone();
    let once = |film: &Film, effort: Effort| {
        let evidence = Evidence { film, ..*evidence };
        let pixels = evidence.telling_pixels(unknown, material)?;
        let (saturated, pixels) = if effort.wary { saturated::apart(&evidence, pixels) } else { (vec![], pixels) };
        let found = match Kind::named(&unknown.material().kind) {
            Some(kind) => polished::recover(&Sought { evidence: &evidence, unknown, material, kind, pixels: &pixels }, effort, tell),
            None => clear::recover(&clear::Through::new(&evidence, unknown, material), &pixels, effort, tell),
        };
        found.map(|found| Recovery { saturated, ..found })
    };
    let mut found = once(&film, effort)?;
    for _ in 0..MOST_FILTERS {
        let Some(blur) = found.amiss().filter(|_| !effort.late()) else { break };
        film.filter = Filter::blurring(blur.variance());
        found = once(&film, Effort { around: Some(&found.values), ..effort })?;
    }
    Ok(found)
}

/// Samples of a pixel that is rendered anew.
const SAMPLES: u32 = 32;

/// About so many pixels are searched at a time for the unknown.
const LARGE: usize = 1 << 20;
/// The side of the tiles that they come in.
const TILE: usize = 8;
/// Once it is seen in so many, no more are searched: without a tolerance, rounds end before they see half of those.
const ENOUGH: usize = 40_000;

/// The number of the square, of so many pixels a side, that a pixel is in; rising from row to row of squares.
fn tile(pixel: usize, width: usize, side: usize) -> usize {
    pixel / width / side * width + pixel % width / side
}

/// How often a picture is looked at again because its pixels are not blurred as they were taken to be.
const MOST_FILTERS: usize = 8;
