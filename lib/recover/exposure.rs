//! Whether a picture is of another exposure than its scene.

use super::Evidence;
use crate::color::{Rgb, bright};
use crate::rad::Number;
use crate::render::Pixel;
use crate::rules::Rules;
use crate::scene::MaterialId;
use crate::unknown::{EXPOSURES, Unknown};
use crate::world::World;

/// The least and the greatest brightness of known things, in terms of what they should have, that is no other exposure.
const EXPOSED: [f64; 2] = [0.9, 1.1];
/// About so many pixels are looked at, and so many that are known tell it, half of them within this part of what they have in common.
const LOOKED_AT: usize = 300;
const FEWEST: usize = 30;
const ALIKE: f64 = 0.25;

/// What is to be said if things in a world that are known are brighter or darker in the picture than they should be, all alike: then it is of another
/// exposure, which none of the parameters is.
pub fn exposed(evidence: &Evidence, world: &World, unknown: &Unknown, material: MaterialId, seed: u64) -> Option<String> {
    if unknown.parameters().iter().any(|p| EXPOSURES.contains(&&p.name[..])) {
        return None;
    }
    let known = |n: &usize| evidence.counts(*n) && !evidence.touches(*n, material);
    let known: Vec<usize> = evidence.film.some(LOOKED_AT).filter(known).collect();
    let rendering = evidence.rendered(world, &known, seed);
    let ratio = |(&n, pixel): (&usize, &Pixel)| bright(Rgb::from(evidence.target.pixels[n].map(f64::from))) / bright(pixel.mean());
    let mut ratios: Vec<f64> = known.iter().zip(&rendering.pixels).map(ratio).filter(|ratio| ratio.is_finite()).collect();
    if ratios.len() < FEWEST {
        return None;
    }
    ratios.sort_by(f64::total_cmp);
    let [low, ratio, high] = [1, 2, 3].map(|part| ratios[part * (ratios.len() - 1) / 4]);
    let alike = low > ratio * (1.0 - ALIKE) && high < ratio * (1.0 + ALIKE);
    if !alike || ratio <= 0.0 || (EXPOSED[0]..=EXPOSED[1]).contains(&ratio) {
        return None;
    }
    let [ratio, low, high] = [1.0, 0.1, 10.0].map(|factor| Number(format!("{:.1e}", factor * ratio).parse().unwrap_or(ratio)));
    let bounces = evidence.rules.ambient_bounces;
    let all = Rules::default().ambient_bounces;
    let cut = if bounces == all {
        String::new()
    } else {
        format!("; or it holds light of more bounces than -ab {bounces}, as a photograph does")
    };
    Some(format!(
        "around the unknown the picture is {ratio} times as bright as the scene is, as by another exposure: \
         --param exposure={ratio}:{low}:{high} finds that, with something of the material known{cut}"
    ))
}
