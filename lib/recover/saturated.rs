//! Where a picture seems to show the most that a camera can tell instead of the light there was.

use super::Evidence;
use crate::picture::place;
use crate::render::Pixel;
use crate::world::World;
use std::collections::BTreeSet;

/// A pixel, by its number, and the channel that is of the largest value there.
pub type Saturated = (usize, usize);

/// A plateau of a channel: so many pixels at the least have its largest value, and this part at the least of those that are within `NEAR` of it.
/// In a highlight, or where a surface turns to the light, a tenth has.
const FEWEST: usize = 8;
const FLAT: f64 = 0.25;
const NEAR: f32 = 0.8;
/// By how much values may differ, in terms of themselves, that are the same.
const SAME: f32 = 1e-3;
/// So many other pixels tell something.
const LEFT: usize = 50;
/// By which factor a pixel that seems saturated must be darker than what was found makes it.
const BRIGHTER: f64 = 1.05;

/// Those of these pixels that seem saturated, and those that are not, nor beside one, as they may be so in part; all, if these are too few.
/// A flat surface looks saturated too: whether it should be brighter, by what the others tell, shows which it is.
pub fn apart(evidence: &Evidence, pixels: Vec<usize>) -> (Vec<Saturated>, Vec<usize>) {
    let saturated: Vec<Saturated> = (0..3).flat_map(|channel| plateau(evidence, &pixels, channel)).collect();
    let numbers: BTreeSet<usize> = saturated.iter().map(|&(n, _)| n).collect();
    let width = evidence.film.width;
    let beside = |n: usize| {
        let (row, column) = (n / width, n % width);
        let columns = column.saturating_sub(1)..=(column + 1).min(width - 1);
        (row.saturating_sub(1)..=row + 1).any(|row| columns.clone().any(|column| numbers.contains(&(row * width + column))))
    };
    let others: Vec<usize> = pixels.iter().copied().filter(|&n| !beside(n)).collect();
    if others.len() < LEFT { (vec![], pixels) } else { (saturated, others) }
}

/// The pixels that have the largest value of a channel, where they are as many as no highlight has.
fn plateau(evidence: &Evidence, pixels: &[usize], channel: usize) -> Vec<Saturated> {
    let value = |n: usize| evidence.target.pixels[n][channel];
    let largest = pixels.iter().map(|&n| value(n)).fold(0.0, f32::max);
    let step = |n: usize| evidence.steps.map_or(0.0, |steps| steps[n][channel]).max(SAME * largest);
    let (flat, lower): (Vec<usize>, Vec<usize>) = pixels.iter().partition(|&&n| value(n) >= largest - step(n));
    let near = lower.iter().filter(|&&n| value(n) > NEAR * largest).count();
    let is_one = largest > 0.0 && flat.len() >= FEWEST && flat.len() as f64 > FLAT * (flat.len() + near) as f64;
    if is_one { flat.into_iter().map(|n| (n, channel)).collect() } else { vec![] }
}

/// What is to be said of pixels that seem saturated, if most of those of a channel should be brighter in a world where the unknown is as it was found,
/// in a picture of these exposures.
pub fn confirmed(evidence: &Evidence, world: &World, saturated: &[Saturated], exposures: [f64; 3], seed: u64) -> Option<String> {
    let numbers: Vec<usize> = saturated.iter().map(|&(n, _)| n).collect();
    let rendering = evidence.rendered(world, &numbers, seed);
    let brighter = |((n, c), pixel): (&Saturated, &Pixel)| {
        let photographed = f64::from(evidence.target.pixels[*n][*c]);
        (exposures[*c] * pixel.mean()[*c] > BRIGHTER * photographed).then_some(*n)
    };
    let of = |channel: usize| {
        let flat = || saturated.iter().zip(&rendering.pixels).filter(|((_, c), _)| *c == channel);
        let brighter: Vec<usize> = flat().filter_map(brighter).collect();
        if 2 * brighter.len() > flat().count() { brighter } else { vec![] }
    };
    // One may be so in several channels.
    let brighter: BTreeSet<usize> = (0..3).flat_map(of).collect();
    brighter.first().map(|n| {
        format!(
            "{} pixels, as that in {}, have the largest value of their channel, and should be brighter, as where a camera is saturated: they and \
             those beside them are left out",
            brighter.len(),
            place(*n, evidence.film.width),
        )
    })
}
