//! Whether what light goes into is inside out.

use super::Evidence;
use crate::scene::MaterialId;
use crate::unknown::Unknown;

/// What is to be said of a dielectric most of which is seen from its back, as from inside.
pub fn said(evidence: &Evidence, unknown: &Unknown, material: MaterialId) -> Option<String> {
    if unknown.material().kind != "dielectric" {
        return None;
    }
    let seen = |ray| evidence.world.shown(&ray, f64::INFINITY, material).map(|(rest, normal)| rest.direction.dot(normal));
    let (back, front): (Vec<f64>, Vec<f64>) = evidence.film.some_rays().filter_map(seen).partition(|along| *along > 0.0);
    (back.len() > front.len()).then(|| {
        let name = &unknown.material().name;
        format!("most of `{name}` is seen from its back, as from inside: the normals of a dielectric point out of it; if they do not, xform -I turns them")
    })
}
