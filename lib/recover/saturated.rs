//! Where a picture seems to show the most that a camera can tell instead of the light there was.

use super::{Evidence, Recovery};
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
    let beside = |n: usize| evidence.film.around(n, 1).any(|n| numbers.contains(&n));
    let others: Vec<usize> = pixels.iter().copied().filter(|&n| !beside(n)).collect();
    (saturated, if others.len() < LEFT { pixels } else { others })
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

/// What is to be said of pixels that seem saturated, if most of those of a channel should be brighter in a world where the unknown is as it was found;
/// or, where so few others are left that they count all the same, if the picture is not explained.
pub fn confirmed(evidence: &Evidence, world: &World, found: &Recovery, exposures: [f64; 3], seed: u64) -> Option<String> {
    let have = |n: usize, count: usize, so: &str| {
        let example = place(n, evidence.film.width);
        format!("{count} pixels, as that in {example}, have the largest value of their channel, {so}")
    };
    let saturated = &found.saturated;
    let numbers: BTreeSet<usize> = saturated.iter().map(|&(n, _)| n).collect();
    if found.counts_saturated() {
        let so = "nearly all there are: if the camera is saturated there, nothing that is found holds";
        return numbers.first().filter(|_| !found.explained()).map(|n| have(*n, numbers.len(), so));
    }
    let rendering = evidence.rendered(world, &saturated.iter().map(|&(n, _)| n).collect::<Vec<_>>(), seed);
    let brighter =
        |((n, c), pixel): (&Saturated, &Pixel)| exposures[*c] * pixel.mean()[*c] > BRIGHTER * f64::from(evidence.target.pixels[*n][*c]);
    let of = |channel: usize| {
        let flat: Vec<_> = saturated.iter().zip(&rendering.pixels).filter(|((_, c), _)| *c == channel).collect();
        let most = 2 * flat.iter().filter(|one| brighter(**one)).count() > flat.len();
        flat.into_iter().filter(|_| most).map(|((n, _), _)| *n).collect::<Vec<_>>()
    };
    // One may be so in several channels.
    let flat: BTreeSet<usize> = (0..3).flat_map(of).collect();
    let so = "and most of them should be brighter, as where a camera is saturated: they and those beside them are left out";
    flat.first().map(|n| have(*n, flat.len(), so))
}
