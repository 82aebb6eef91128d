//! What paths make together in a picture: a colour.

use super::Transport;
use crate::bsdf::{Arriving, Bsdf, Delta, Part};
use crate::color::Rgb;
use crate::material::Inside;
use crate::rules::Rules;
use crate::vector::Vec3;
use crate::world::Layer;

/// The transport of a picture: the throughput is a colour, the light found adds up.
pub struct Radiance<'a> {
    /// The rules of the picture.
    pub rules: &'a Rules,
    /// The sum of what was found, in W/(sr·m²).
    pub sum: Rgb,
}

impl Transport for Radiance<'_> {
    type Beta = Rgb;
    type Surface = Bsdf;

    fn start(&self) -> Rgb {
        Rgb::ONE
    }

    fn scale(&self, beta: &mut Rgb, by: Rgb) {
        *beta *= by;
    }

    fn size(&self, beta: &Rgb) -> f64 {
        beta.abs().max_element()
    }

    fn surface(&self, layer: &Layer, rules: &Rules) -> Bsdf {
        layer.bsdf(rules)
    }

    fn aimed(&self, beta: &Rgb, surface: &Bsdf, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> Rgb {
        *beta * surface.value(wi, arriving, &surface.balance(wi, arriving, pdf, counts), self.rules)
    }

    fn drawn(&self, beta: &Rgb, surface: &Bsdf, wi: Vec3, part: Part, _: usize, count: f64) -> (Rgb, f64) {
        let density = count * surface.pdf(part, wi);
        (*beta * surface.value(wi, Arriving::Indirect, &part.alone(1.0 / density), self.rules), density)
    }

    fn ambient(&self, beta: &Rgb, surface: &Bsdf, side: usize) -> Rgb {
        *beta * surface.ambient[side]
    }

    fn follow(&self, beta: &Rgb, _: &Bsdf, delta: &Delta) -> Rgb {
        *beta * delta.coefficient
    }

    fn absorb(&self, beta: &mut Rgb, medium: &Inside, length: f64) {
        *beta *= medium.transmittance(length);
    }

    fn collect(&mut self, beta: &Rgb, radiance: Rgb) {
        self.sum += *beta * radiance;
    }
}
