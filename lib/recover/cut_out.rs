//! A picture of the unknown alone, cut out: black all around it, where the scene is not.

use super::Evidence;
use super::dead::black;
use crate::color::bright;
use crate::scene::MaterialId;
use rayon::prelude::*;

/// About so many pixels are looked at; so many of them are black at the least; and so many of those are rendered, most of which are not black then.
const LOOKED_AT: usize = 1000;
const FEWEST: usize = 30;
const RENDERED: usize = 64;

/// The pixels that show something else than the unknown, or something else too, which was cut off or not, where a picture of which all counts is one that
/// was cut out.
pub fn others(evidence: &Evidence, material: MaterialId, seed: u64) -> Vec<usize> {
    let Evidence { film, world, mask, .. } = *evidence;
    let touches = |n: &usize| evidence.touches(*n, material);
    let (mut around, seen): (Vec<usize>, Vec<usize>) = film.some(LOOKED_AT).partition(|n| black(evidence, *n));
    if mask.is_some() || around.len() < FEWEST || !seen.iter().all(touches) {
        return vec![];
    }
    around.retain(|n| !touches(n));
    around.truncate(RENDERED);
    let lit = || evidence.rendered(world, &around, seed).pixels.iter().filter(|pixel| bright(pixel.mean()) > 0.0).count();
    if around.len() < FEWEST || 2 * lit() < around.len() {
        return vec![];
    }
    // What a filter gives to pixels beside it was cut too.
    let reach = usize::from(film.filter.beyond().is_some());
    let whole = |n: usize| film.around(n, reach).all(|beside| evidence.filled(beside, material));
    (0..film.width * film.height).into_par_iter().filter(|&n| !whole(n)).collect()
}
