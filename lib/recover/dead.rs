//! Where a picture is black though there is light.

use super::{Evidence, Recovery};
use crate::color::bright;
use crate::picture::place;
use crate::world::World;

/// A pixel that a rendering has so many standard errors above black is not black by chance, where half of all pixels are off by no more than this, the
/// square of a part: few samples of a small glow make many black, and the others too bright.
const SURE: f64 = 5.0;
const TYPICAL: f64 = 0.1;

/// Whether a pixel is black in the picture.
pub fn black(evidence: &Evidence, n: usize) -> bool {
    evidence.target.pixels[n] == [0.0; 3]
}

/// Those of some black pixels that surely are not so in a world where the unknown is what was found.
pub fn dead(evidence: &Evidence, world: &World, found: &Recovery, black: Vec<usize>, seed: u64) -> Vec<usize> {
    let mut losses: Vec<f64> = found.losses.iter().map(|(_, loss)| *loss).collect();
    losses.sort_by(f64::total_cmp);
    if losses.get(losses.len() / 2).is_none_or(|loss| *loss > TYPICAL) {
        return vec![];
    }
    let rendering = evidence.rendered(world, &black, seed);
    let surely = rendering.pixels.iter().map(|pixel| bright(pixel.mean()) > SURE * bright(rendering.variance(pixel).map(f64::sqrt)));
    black.into_iter().zip(surely).filter_map(|(n, surely)| surely.then_some(n)).collect()
}

/// What is to be said of them in a picture so wide, if there are any.
pub fn said(dead: &[usize], width: usize) -> Option<String> {
    let first = place(*dead.first()?, width);
    Some(format!(
        "{} pixels, as that in {first}, are black where there is light, as a camera's dead ones are, or those that all exposures have too bright: \
         they are left out",
        dead.len()
    ))
}
