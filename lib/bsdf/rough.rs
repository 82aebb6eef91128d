//! Surfaces that scatter to all sides: Ward's, polished or not, and Ashikhmin and Shirley's.

use super::lobe::schlick;
use super::{Bsdf, Delta, Lobe, LobeForm, Loss, Point};
use crate::color::{Rgb, bright};
use crate::geometry::TINY;
use crate::material::{Ashikhmin, FRESNEL_FROM, PURE, Reflectance};
use crate::rules::Rules;
use crate::vector::{Frame, Vec3};

impl Bsdf {
    /// Plastic, metal, trans, plastic2, metal2 and trans2.
    pub fn reflectance(point: &Point, m: &Reflectance, rules: &Rules) -> Self {
        let mut bsdf = Self::black(point);
        let pure = m.isotropic && m.roughness[0].abs() <= PURE;
        let polished = pure && m.specularity >= FRESNEL_FROM;
        let f = if polished { bsdf.fresnel(rules) } else { 0.0 };
        let specular = m.specularity + f * (1.0 - m.specularity);
        let transmitted = m.transmission * (1.0 - specular);
        let straight = transmitted * m.transmitted_specular;
        let specular_color = match m.metal {
            true if f > TINY => Rgb::splat(f) + m.color * m.specularity * (1.0 - f),
            true => m.color * specular,
            false => Rgb::splat(specular),
        };
        bsdf.single = rules.single();
        bsdf.loss = if polished { Loss::Polished } else { Loss::None };
        let shares = [1.0 - transmitted - specular, transmitted - straight];
        bsdf.diffuse = shares.map(|share| if share > TINY { m.color * share } else { Rgb::ZERO });
        bsdf.gather_diffuse(point);
        let straight_on = if point.bends { bend(point) } else { -point.to_viewer };
        bsdf.straight = bsdf.frame.to_local(straight_on);
        if pure {
            if straight > TINY {
                bsdf.deltas[1] = Some(Delta { direction: straight_on, coefficient: m.color * straight, reflected: false, medium: None });
            }
            if specular > TINY {
                bsdf.deltas[0] = Some(Delta { direction: bsdf.mirror(point), coefficient: specular_color, reflected: true, medium: None });
            }
            return bsdf;
        }
        let alpha = match m.roughness.map(|r| r * r) {
            alpha if m.isotropic => alpha,
            alpha => bsdf.orient(point, alpha, |[u, v]| [(0.5 * (u + v)).max(1e-12); 2]),
        };
        let lobe = |weight: f64, color: Rgb| {
            (weight > TINY).then_some(Lobe { color, form: LobeForm::Gaussian, alpha, gathers: gathers(rules, weight) })
        };
        bsdf.lobes = [lobe(m.specularity, specular_color), lobe(straight, m.color * straight)];
        for side in 0..2 {
            if let Some(lobe) = bsdf.lobes[side].filter(|l| !l.gathers && shares[side] > TINY) {
                bsdf.ambient[side] += lobe.color;
            }
        }
        bsdf
    }

    /// ashik2. RADIANCE leaves out the Fresnel term of the diffuse part where it gathers indirect light.
    pub(super) fn ashikhmin(point: &Point, m: &Ashikhmin, pattern: Rgb, rules: &Rules) -> Self {
        let mut bsdf = Self::black(point);
        bsdf.diffuse[0] = m.diffuse * pattern;
        bsdf.loss = Loss::Schlick;
        bsdf.gather_diffuse(point);
        if m.specular.max_element() > TINY {
            let color = m.specular + (Rgb::ONE - m.specular) * schlick(bsdf.to_viewer.z.max(0.001));
            let alpha = bsdf.orient(point, m.powers, |[u, v]| {
                let mean = 2.0 / (1.0 / (u + 1e-5) + 1.0 / (v + 1e-5));
                [mean, mean]
            });
            let gathers = gathers(rules, bright(m.specular));
            bsdf.lobes[0] = Some(Lobe { color, form: LobeForm::Power, alpha, gathers });
            if !gathers && bright(bsdf.diffuse[0]) > TINY {
                bsdf.ambient[0] += color;
            }
        }
        bsdf
    }

    /// Turns the frame to an anisotropic lobe's tangent; returns the numbers of the lobe along its axes, which are `[u, v]`, or the same
    /// `mean` of them along both where the tangent has no direction. One that is round is turned, too: it may stand for an unknown that is not.
    fn orient(&mut self, point: &Point, [u, v]: [f64; 2], mean: impl Fn([f64; 2]) -> [f64; 2]) -> [f64; 2] {
        let across = point.shading.cross(point.orientation);
        if across.length_squared() <= 1e-12 * point.orientation.length_squared() || across == Vec3::ZERO {
            return if u == v { [u, v] } else { mean([u, v]) };
        }
        let t = across.normalize();
        let to_world = self.frame;
        self.frame = Frame { s: t.cross(point.shading), t, n: point.shading };
        for v in [&mut self.to_viewer, &mut self.geometric, &mut self.straight] {
            *v = self.frame.to_local(to_world.to_world(*v));
        }
        [u, v]
    }
}

/// Whether a rough lobe of this share gathers indirect light (`-st`).
fn gathers(rules: &Rules, share: f64) -> bool {
    rules.specular_threshold < share - TINY || rules.specular_threshold == 0.0
}

/// The straight-through direction bent by a texture, unless that would not go through.
fn bend(point: &Point) -> Vec3 {
    let bent = -point.to_viewer - point.perturbation;
    if bent.dot(point.geometric) < -TINY { bent.normalize() } else { -point.to_viewer }
}
