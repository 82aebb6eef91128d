//! A picture of the unknown alone, cut out: black all around it, where the scene is not.

use super::Evidence;
use super::dead::black;
use crate::color::bright;
use crate::scene::MaterialId;

/// About so many pixels are looked at; so many of them are black at the least; and so many of those are rendered, most of which are not black then.
const LOOKED_AT: usize = 1000;
const FEWEST: usize = 30;
const RENDERED: usize = 64;

/// Whether a picture is of the unknown alone, cut out on black, though its scene is not black around it.
pub fn alone(evidence: &Evidence, material: MaterialId, seed: u64) -> bool {
    let Evidence { film, world, .. } = *evidence;
    let touches = |n: &usize| evidence.touches(*n, material);
    let (mut around, seen): (Vec<usize>, Vec<usize>) = film.some(LOOKED_AT).partition(|n| black(evidence, *n));
    if around.len() < FEWEST || !seen.iter().all(touches) {
        return false;
    }
    around.retain(|n| !touches(n));
    around.truncate(RENDERED);
    let lit = || evidence.rendered(world, &around, seed).pixels.iter().filter(|pixel| bright(pixel.mean()) > 0.0).count();
    around.len() >= FEWEST && 2 * lit() >= around.len()
}
