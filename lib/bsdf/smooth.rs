//! Smooth transparent bodies: refraction at the boundary of two media, and thin panes of glass.

use super::{Bsdf, Delta, Point};
use crate::color::Rgb;
use crate::geometry::TINY;
use crate::material::{Inside, Medium};
use crate::rules::Rules;
use crate::vector::Vec3;

impl Bsdf {
    /// The boundary of a body: `inside` is behind the surface, `outside` before it (none: what fills the scene). The pattern colours both.
    pub(super) fn interface(point: &Point, inside: &Medium, outside: Option<&Medium>, pattern: Rgb, rules: &Rules) -> Self {
        let mut bsdf = Self::black(point);
        let index = inside.index / outside.map_or(1.0, |o| o.index);
        let eta = if point.front { 1.0 / index } else { index };
        let cos = bsdf.to_viewer.z;
        let direction = bsdf.mirror(point);
        let mirror = |coefficient: f64| Delta { direction, coefficient: Rgb::splat(coefficient), reflected: true, medium: None };
        let k = 1.0 - eta * eta * (1.0 - cos * cos);
        // Also true of an index that is none: then everything is reflected.
        if !(TINY..f64::INFINITY).contains(&k) {
            bsdf.deltas[0] = Some(mirror(1.0));
            return bsdf;
        }
        let cos_beyond = k.sqrt();
        let reflected = reflectance(cos, cos_beyond, eta);
        let refracted = |normal: Vec3| (-point.to_viewer * eta + normal * (eta * cos - cos_beyond)).normalize();
        let mut direction = refracted(point.shading);
        if point.perturbation != Vec3::ZERO && direction.dot(point.geometric) >= -TINY {
            direction = refracted(point.geometric);
        }
        let beyond = match outside {
            _ if point.front => inside.extinction(pattern),
            Some(outside) => outside.extinction(pattern),
            None => rules.extinction,
        };
        // Radiance is concentrated by the square of the index.
        let coefficient = Rgb::splat((1.0 - reflected) * eta * eta);
        if reflected > 0.0 {
            bsdf.deltas[0] = Some(mirror(reflected));
        }
        bsdf.deltas[1] = Some(Delta { direction, coefficient, reflected: false, medium: Some(Inside::of(beyond)) });
        bsdf
    }

    /// A thin pane: all its internal reflections at once.
    pub(super) fn glass(point: &Point, glass: &Medium, pattern: Rgb) -> Self {
        let mut bsdf = Self::black(point);
        let pane = glass.transmissivity.to_array().map(|t| pane(bsdf.to_viewer.z, glass.index, t));
        let [reflected, transmitted] = [0, 1].map(|way| Rgb::from(pane.map(|p| p[way])));
        let transmitted = if glass.transmissivity.max_element() <= 1e-15 { Rgb::ZERO } else { transmitted * pattern };
        let direction = point.mirrored(point.shading);
        bsdf.deltas[0] = Some(Delta { direction, coefficient: reflected, reflected: true, medium: None });
        if transmitted != Rgb::ZERO {
            let straight = -point.to_viewer;
            let bent = (straight + point.perturbation * (2.0 * (1.0 - glass.index))).try_normalize().unwrap_or(straight);
            let direction = if point.bends { bent } else { straight };
            bsdf.deltas[1] = Some(Delta { direction, coefficient: transmitted, reflected: false, medium: None });
        }
        bsdf
    }
}

/// What a pane of index `n` and transmissivity `t` at normal incidence reflects and transmits at the cosine `cos`, all inner reflections together.
/// Everything is reflected where no light gets inside.
pub fn pane(cos: f64, n: f64, t: f64) -> [f64; 2] {
    let inside = (1.0 - (1.0 - cos * cos) / (n * n)).max(0.0).sqrt();
    if !(n * inside > 0.0) {
        return [1.0, 0.0];
    }
    let through = t.max(1e-15).powf(1.0 / inside);
    let mut sum = [0.0; 2];
    for (a, b) in [(cos, n * inside), (inside, n * cos)] {
        // What enters is not the difference of two numbers near 1.
        let (r, enters) = (((a - b) / (a + b)).powi(2), 4.0 * a * b / (a + b).powi(2));
        // A pane that lets through more than all may reflect inside without end: then only its face counts.
        let back = r * through;
        let transmitted = if back < 1.0 { enters * enters * through / ((enters + r * (1.0 - through)) * (1.0 + back)) } else { 0.0 };
        sum[0] += 0.5 * (r + if back < 1.0 { back * transmitted } else { 0.0 });
        sum[1] += 0.5 * transmitted;
    }
    sum
}

/// Fresnel's reflectance for unpolarised light, at cosines `cos` before and `cos_beyond` behind a boundary with the ratio of indices `eta`.
fn reflectance(cos: f64, cos_beyond: f64, eta: f64) -> f64 {
    let parallel = (cos - eta * cos_beyond) / (cos + eta * cos_beyond);
    let perpendicular = (cos_beyond - eta * cos) / (cos_beyond + eta * cos);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}
