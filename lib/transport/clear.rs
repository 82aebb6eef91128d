//! The basis of a smooth transparent unknown, dielectric or glass: the picture at several transmissivities, for one index of refraction.
//!
//! Each channel of a picture depends on the transmissivity of that channel only. In a dielectric a path of length ℓ inside is dimmed by T^ℓ; a
//! pane of glass reflects and transmits by the formula of its many inner reflections.

use super::{LANES, Nodes, decay};
use crate::bsdf::{Arriving, Bsdf, Delta, Part, smooth::pane};
use crate::color::Rgb;
use crate::geometry::FAR;
use crate::integrator::{Radiance, Scattering, Transport};
use crate::material::{Inside, Material, Medium};
use crate::rules::Rules;
use crate::scene::MaterialId;
use crate::vector::Vec3;
use crate::world::Layer;
use wide::f32x8;

/// Groups of [`LANES`] transmissivities.
const L: usize = 2;

/// The extinction, along the length that paths go inside, below which a body is thin, and the most that is told from more.
const THIN: f64 = 0.02;
const OPAQUE: f64 = 20.0;

/// Where a transmissivity stands among others: ln(1 + σ/`THIN`) of the extinction σ. There what is let through on a way of any length, e^−σℓ, is as
/// smooth as on any other, or smoother.
pub fn depth(transmissivity: f64) -> f64 {
    ((-transmissivity.ln()).clamp(0.0, OPAQUE) / THIN).ln_1p()
}

/// A transparent material with a given index, explored at several transmissivities.
pub struct Clear {
    /// The material.
    pub material: MaterialId,
    /// Whether it is a pane of glass rather than a body.
    pub glass: bool,
    /// Index of refraction.
    pub index: f64,
    /// What the length that [`Clear::new`] is told lets through (of glass, the whole pane), falling from 1 to nearly 0, evenly by [`depth`].
    pub nodes: [f64; L * LANES],
    /// What roulette takes the extinction for; until something is known, nothing is absorbed.
    pub guess: Rgb,
    /// The same material that absorbs nothing.
    cleared: Material,
    logarithms: Nodes<L>,
}

impl Clear {
    /// A dielectric or glass of this index. `length` is about how far paths go inside: what they let through is told there, whatever the scene's unit
    /// of length. 1 for glass.
    pub fn new(material: MaterialId, glass: bool, index: f64, length: f64) -> Self {
        let extinction = |i: usize| THIN * (depth(0.0) * i as f64 / (L * LANES - 1) as f64).exp_m1();
        let nodes = std::array::from_fn(|i| (-extinction(i)).exp());
        let logarithm = |i: usize| (-extinction(i) / length) as f32;
        let logarithms = std::array::from_fn(|l| f32x8::from(std::array::from_fn(|i| logarithm(l * LANES + i))));
        let medium = Medium { transmissivity: Rgb::ONE, index };
        let cleared = if glass { Material::Glass(medium) } else { Material::Dielectric(medium) };
        Self { material, glass, index, nodes, guess: Rgb::ZERO, cleared, logarithms }
    }

    /// The columns of a channel.
    pub fn columns(&self) -> usize {
        L * LANES
    }
}

/// A throughput: what is known of it, and what the unknown makes of it at each transmissivity.
#[derive(Clone)]
pub(super) struct Beta {
    known: Rgb,
    nodes: Nodes<L>,
}

/// Hands each path's light to the columns.
pub(super) struct Dimming<'a> {
    /// What is known of a throughput scatters as colours do.
    pub colors: Radiance<'a>,
    pub unknown: &'a Clear,
    pub columns: &'a mut [f32],
}

/// Scattering, and whether it is the unknown's.
pub(super) struct Surface {
    bsdf: Bsdf,
    unknown: bool,
    pattern: Rgb,
}

impl Scattering for Surface {
    fn bsdf(&self) -> &Bsdf {
        &self.bsdf
    }
}

impl Transport for Dimming<'_> {
    type Beta = Beta;
    type Surface = Surface;

    fn start(&self) -> Beta {
        Beta { known: Rgb::ONE, nodes: [f32x8::ONE; L] }
    }

    fn scale(&self, beta: &mut Beta, by: Rgb) {
        beta.known *= by;
    }

    fn size(&self, beta: &Beta) -> f64 {
        beta.known.abs().max_element()
    }

    fn surface(&self, layer: &Layer, rules: &Rules) -> Surface {
        if layer.id != self.unknown.material || layer.material.is_none() {
            return Surface { bsdf: layer.bsdf(rules), unknown: false, pattern: Rgb::ONE };
        }
        let bsdf = Bsdf::new(&self.unknown.cleared, &layer.point, layer.pattern, rules);
        let mut surface = Surface { bsdf, unknown: true, pattern: layer.pattern };
        // What is refracted into a body goes on in the unknown.
        if let (false, true, Some(Delta { medium: Some(medium), .. })) =
            (self.unknown.glass, layer.point.front, &mut surface.bsdf.deltas[1])
        {
            *medium = Inside { extinction: Rgb::ZERO, unknown: Some(medium.extinction) };
        }
        surface
    }

    fn aimed(&self, beta: &Beta, surface: &Surface, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> Beta {
        Beta { known: self.colors.aimed(&beta.known, &surface.bsdf, wi, arriving, pdf, counts), ..*beta }
    }

    fn drawn(&self, beta: &Beta, surface: &Surface, wi: Vec3, part: Part, way: usize, count: f64) -> (Beta, f64) {
        let (known, density) = self.colors.drawn(&beta.known, &surface.bsdf, wi, part, way, count);
        (Beta { known, ..*beta }, density)
    }

    fn ambient(&self, beta: &Beta, surface: &Surface, side: usize) -> Beta {
        Beta { known: self.colors.ambient(&beta.known, &surface.bsdf, side), ..*beta }
    }

    fn follow(&self, beta: &Beta, surface: &Surface, delta: &Delta) -> Beta {
        if !(surface.unknown && self.unknown.glass) {
            return Beta { known: beta.known * delta.coefficient, ..*beta };
        }
        let (cos, way) = (surface.bsdf.viewer().z, !delta.reflected as usize);
        let nodes = std::array::from_fn(|l| {
            beta.nodes[l]
                * f32x8::from(std::array::from_fn(|i| pane(cos, self.unknown.index, self.unknown.nodes[l * LANES + i])[way] as f32))
        });
        Beta { known: if delta.reflected { beta.known } else { beta.known * surface.pattern }, nodes }
    }

    fn absorb(&self, beta: &mut Beta, medium: &Inside, length: f64) {
        let Some(patterns) = medium.unknown else {
            beta.known *= medium.transmittance(length);
            return;
        };
        beta.known *= Inside::of(patterns).transmittance(length);
        for (node, ln) in beta.nodes.iter_mut().zip(self.unknown.logarithms) {
            *node *= decay(ln * length.min(FAR) as f32);
        }
    }

    fn extinction(&self, medium: &Inside) -> Rgb {
        medium.unknown.map_or(medium.extinction, |patterns| self.unknown.guess + patterns)
    }

    fn collect(&mut self, beta: &Beta, radiance: Rgb) {
        for (columns, light) in self.columns.chunks_exact_mut(L * LANES).zip((beta.known * radiance).to_array()) {
            for (columns, nodes) in columns.chunks_exact_mut(LANES).zip(beta.nodes) {
                let sum = f32x8::from(&columns[..]) + nodes * light as f32;
                columns.copy_from_slice(&sum.to_array());
            }
        }
    }
}
