//! Where a picture is black though there is light.

use super::median::median;
use super::{Evidence, Recovery};
use crate::color::bright;
use crate::picture::place;
use crate::scene::MaterialId;
use crate::world::World;

/// A pixel that a rendering has so many standard errors above black is not black by chance, where half of those around it, so far away at the most, are off
/// by no more than this, the square of a part: few samples of a small glow make many black, and the others too bright.
const SURE: f64 = 5.0;
const AROUND: usize = 3;
const TYPICAL: f64 = 0.1;

/// Whether a pixel is black in the picture.
pub fn black(evidence: &Evidence, n: usize) -> bool {
    evidence.target.pixels[n] == [0.0; 3]
}

/// Whether one that is has only neighbours in the picture that are not.
pub fn alone(evidence: &Evidence, n: usize) -> bool {
    evidence.film.around(n, 1).all(|neighbour| neighbour == n || !black(evidence, neighbour))
}

/// Whether all these pixels are, that show a material or touch it; or all that show nothing else.
pub fn all(evidence: &Evidence, pixels: &[usize], material: MaterialId) -> bool {
    let (black, lit): (Vec<usize>, Vec<usize>) = pixels.iter().partition(|n| black(evidence, **n));
    let mixed = |n: &usize| !evidence.filled(*n, material);
    lit.is_empty() || lit.iter().all(mixed) && !black.iter().all(mixed)
}

/// Those of some black pixels that surely are not so in a world where the unknown is what was found.
pub fn dead(evidence: &Evidence, world: &World, found: &Recovery, black: Vec<usize>, seed: u64) -> Vec<usize> {
    let lit: Vec<(usize, f64)> = found.losses.iter().copied().filter(|(n, _)| !self::black(evidence, *n)).collect();
    let Some(everywhere) = median(lit.iter().map(|(_, loss)| *loss)) else { return vec![] };
    let mut off = vec![None; evidence.target.pixels.len()];
    lit.iter().for_each(|(n, loss)| off[*n] = Some(*loss));
    let explained = |n: &usize| median(evidence.film.around(*n, AROUND).filter_map(|n| off[n])).unwrap_or(everywhere) <= TYPICAL;
    let black: Vec<usize> = black.into_iter().filter(explained).collect();
    if black.is_empty() {
        return vec![];
    }
    let rendering = evidence.rendered(world, &black, seed);
    let errors = rendering.variances(black.len()).into_iter().map(|variance| bright(variance.map(f64::sqrt)));
    let surely = rendering.pixels.iter().zip(errors).map(|(pixel, error)| bright(pixel.mean()) > SURE * error);
    black.into_iter().zip(surely).filter_map(|(n, surely)| surely.then_some(n)).collect()
}

/// What is to be said of them in a picture so wide, if there are any: whether they could be left out yet.
pub fn said(dead: &[usize], width: usize, left_out: bool) -> Option<String> {
    let first = place(*dead.first()?, width);
    let so = if left_out { "they are left out" } else { "they count here, as time is up: leave them out with --mask, or give more of it" };
    Some(format!(
        "{} pixels, as that in {first}, are black where there is light, as a camera's dead ones are, or those that all exposures have too bright: {so}",
        dead.len()
    ))
}
