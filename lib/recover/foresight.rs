//! Which pixels tell most: of a small roughness, as the scene alone says, or of any values, as a few samples say.
//!
//! A picture of what is nearly a mirror tells of its roughness only where what is mirrored changes within the lobe: on the paper's horse a
//! hundredth of the pixels hold half of it, a twentieth nine tenths. Samples hardly find them, since derivatives are mostly noise at first. But the
//! environment is known, and where the way to it is free it can be looked up all around the mirrored direction, where what is even cancels.
//!
//! Where derivatives are not mostly noise, as of what is clear, a glance is enough. A few samples say little of a pixel's changes; but the eighth of
//! the bunny's pixels that they make most of holds a third of what all tell.

use super::Evidence;
use super::look::Model;
use super::scores::Evaluation;
use super::sheet::{COMMON, Sheet, joined};
use crate::color::Rgb;
use crate::geometry::Ray;
use crate::sampling::Sampler;
use crate::scene::MaterialId;
use crate::vector::Vec3;
use crate::vector::angle::sin_cos;
use crate::world::{Coming, Layer};
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Points of a pixel, and directions on each ring around the mirrored one.
const POINTS: u32 = 16;
const AROUND: usize = 4;

/// The squares of the rings' slopes in terms of the roughness, and what each makes of the mean over the lobe (Gauss and Laguerre's rule of two points:
/// Abramowitz and Stegun 1964, 25.4.45).
const RINGS: [(f64, f64); 2] = [(2.0 - SQRT_2, 0.25 * (2.0 + SQRT_2)), (2.0 + SQRT_2, 0.25 * (2.0 - SQRT_2))];

/// How much of the variance within a pixel is taken to be left as noise of the photograph and the rendering.
const NOISE: f64 = 0.02;

/// The level of the light at which a pixel counts half as much as if it were brighter, in terms of the mean of all.
const DARK: f64 = 0.01;

/// Samples in each half of a pixel that make a glance.
const GLANCE: u32 = 2;

/// For each pixel, the square of its relative change with the logarithm of the roughnesses along the two tangents, in terms of its variance.
pub fn telling(evidence: &Evidence, material: MaterialId, roughness: [f64; 2], pixels: &[usize]) -> Vec<f64> {
    let lens = evidence.film.lens();
    let foreseen = |n: &usize| {
        let mut sums = [Rgb::ZERO; 3];
        for index in 0..POINTS {
            let mut sampler = Sampler::new(0, *n as u64, 0, index);
            let (at, turn) = (sampler.pair(), sampler.single());
            let Some((origin, direction, limit)) = lens(*n, at) else { continue };
            let ray = Ray { origin, direction };
            let Some(hit) = evidence.world.nearest(&ray, limit) else { continue };
            evidence.world.layers(&hit, &Coming::viewer(&ray), evidence.rules, &mut |layer| {
                if layer.id == material && layer.material.is_some() {
                    let [inner, outer] = mirrored(evidence, layer, hit.point, roughness, turn).map(|ring| ring * layer.fraction);
                    let light = inner * RINGS[0].1 + outer * RINGS[1].1;
                    sums = [sums[0] + (outer - inner) * FRAC_1_SQRT_2, sums[1] + light, sums[2] + light * light];
                }
            });
        }
        let [change, mean, square] = sums.map(|sum| sum / f64::from(POINTS));
        [change * change, mean, square - mean * mean].map(|sum| sum.to_array())
    };
    let all: Vec<[[f64; 3]; 3]> = pixels.par_iter().map(foreseen).collect();
    worth(&all)
}

/// For each pixel of a sheet, the squares of its changes with the values near some, in terms of its variance; one value counts as much as another.
pub fn at_a_glance(model: &dyn Model, near: &[f64], bounds: &[(f64, f64)], sheet: &Sheet, seed: u64) -> Vec<f64> {
    let basis = model.trace_all(sheet.numbers, GLANCE, seed);
    let Evaluation { halves, derivatives, .. } = Evaluation::new(model, &basis, near, bounds);
    // Neither the light of a pixel nor its variance is told by that pixel alone: where few samples happen to be dark, they would seem sure.
    let light = sheet.light(&halves);
    let variances = sheet.blurred(&joined(&halves, |a, b| 0.5 * f64::from(GLANCE) * (a - b).powi(2)), 1);
    let mut sums = vec![0.0; sheet.numbers.len()];
    for derivative in &derivatives {
        let squares = joined(derivative, |a, b| (0.5 * (a + b)).powi(2));
        let worth = worth(&(0..sums.len()).map(|i| [squares[i], light[i], variances[i]]).collect::<Vec<_>>());
        let whole = worth.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        sums.iter_mut().zip(worth).for_each(|(sum, worth)| *sum += worth / whole);
    }
    sums
}

/// How much pixels tell: the squares of their changes in terms of their noise, from those squares, their means and the variances of a sample, in each
/// channel.
fn worth(pixels: &[[[f64; 3]; 3]]) -> Vec<f64> {
    let level = pixels.iter().flat_map(|[_, mean, _]| mean).sum::<f64>() / (3 * pixels.len()) as f64;
    let floor = (DARK * level).powi(2).max(f64::MIN_POSITIVE);
    let part = |[square, mean, variance]: [f64; 3]| square / (NOISE * variance.max(0.0) + (COMMON * mean).powi(2) + floor);
    pixels.iter().map(|pixel| (0..3).map(|c| part(pixel.map(|value| value[c]))).sum()).collect()
}

/// The mean light of the environment on each ring around the direction that is mirrored at a point; none where something is in the way.
fn mirrored(evidence: &Evidence, layer: &Layer, origin: Vec3, roughness: [f64; 2], turn: f64) -> [Rgb; 2] {
    let shape = layer.bsdf(evidence.rules);
    let wo = shape.viewer();
    let facing = |x: f64, y: f64| {
        let h = Vec3::new(x, y, 1.0).normalize();
        shape.to_world(h * (2.0 * wo.dot(h)) - wo)
    };
    if evidence.world.occluded(&Ray { origin, direction: facing(0.0, 0.0) }) {
        return [Rgb::ZERO; 2];
    }
    RINGS.map(|(square, _)| {
        let light = |k: usize| {
            let (sin, cos) = sin_cos((k as f64 + turn) / AROUND as f64);
            let wi = facing(square.sqrt() * roughness[0] * cos, square.sqrt() * roughness[1] * sin);
            evidence.world.sky(origin, wi, None, true).map_or(Rgb::ZERO, |emission| emission.radiance)
        };
        (0..AROUND).map(light).sum::<Rgb>() / AROUND as f64
    })
}
