//! What a material does at a point: how much it scatters from one direction to another, and where to look for that.
//!
//! All directions point away from the surface. Local directions have z along the shading normal on the viewer's side, so that
//! `wi.z > 0` is reflection and `wi.z < 0` transmission. Values include the cosine: they are f·|cos θ|, per unit solid angle.

pub mod lobe;
mod rough;
pub mod smooth;

use crate::color::{Rgb, bright};
use crate::geometry::TINY;
use crate::material::{FunctionMaterial, Inside, Material, Reflectance};
use crate::pattern::{At, Functions, Seen};
use crate::rules::{Rules, Ward};
use crate::sampling::{Sampler, cosine_hemisphere};
use crate::vector::{Frame, Vec3};
use lobe::{above, fresnel, power_reflection, reflection, reflection_pdf, sample_power, sample_reflection, schlick};
use lobe::{sample_transmission, transmission, transmission_pdf};
use std::f64::consts::PI;
use std::sync::Arc;

/// What light arrives along a direction. RADIANCE scatters them by different formulas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arriving {
    /// Straight from a light source that the sample represents with a solid angle (0: an integrated source), in sr.
    Lamp(f64),
    /// Anything else: glow, environment, other surfaces.
    Indirect,
}

/// The parts that scattering is made of. Each is gathered, sampled and weighted on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Diffuse, on the viewer's side.
    DiffuseReflection,
    /// Diffuse, on the other side.
    DiffuseTransmission,
    /// The rough lobe around the mirror direction.
    SpecularReflection,
    /// The rough lobe around the straight-through direction.
    SpecularTransmission,
}

impl Part {
    /// All parts; a part's number is its place here.
    pub const ALL: [Self; 4] = [Self::DiffuseReflection, Self::DiffuseTransmission, Self::SpecularReflection, Self::SpecularTransmission];

    /// Whether it is diffuse: a diffuse bounce counts toward `-ab`.
    pub fn diffuse(self) -> bool {
        matches!(self, Self::DiffuseReflection | Self::DiffuseTransmission)
    }

    /// Weights of which this part has `weight`, and the others nothing.
    pub fn alone(self, weight: f64) -> [f64; 4] {
        let mut weights = [0.0; 4];
        weights[self as usize] = weight;
        weights
    }

    /// 0 for reflection, 1 for transmission.
    pub fn side(self) -> usize {
        self as usize % 2
    }

    /// A local direction drawn from a diffuse part, in proportion to its cosine, whatever the surface hides.
    pub fn lambert(self, u: [f64; 2]) -> Vec3 {
        cosine_hemisphere(u) * [1.0, -1.0][self.side()]
    }
}

/// Where a ray met a surface, as a material needs to know it.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Unit vector to the viewer.
    pub to_viewer: Vec3,
    /// Geometric normal, unit, on the viewer's side.
    pub geometric: Vec3,
    /// Shading normal, unit, on the viewer's side: bent by textures and smoothing.
    pub shading: Vec3,
    /// What bent it, on the viewer's side: the perturbation, zero where there is none.
    pub perturbation: Vec3,
    /// Whether the viewer is on the front, where the surface's own normal points.
    pub front: bool,
    /// Whether RADIANCE widens highlights by the size of the source: an untextured polygon or ring.
    pub flat: bool,
    /// World direction of the first tangent of an anisotropic lobe; any length, zero where it does not matter.
    pub orientation: Vec3,
    /// Whether the perturbation bends light that goes straight through.
    pub bends: bool,
}

impl Point {
    /// The direction to the viewer, mirrored at a unit normal.
    pub fn mirrored(&self, normal: Vec3) -> Vec3 {
        normal * (2.0 * normal.dot(self.to_viewer)) - self.to_viewer
    }
}

/// A rough lobe: its colour and its two roughnesses.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// Fraction of the light in it, per channel.
    pub color: Rgb,
    /// Which shape it has.
    pub form: LobeForm,
    /// Squared roughness along the first and second tangent; of a power lobe, the powers.
    pub alpha: [f64; 2],
    /// Whether it takes part in gathering indirect light (if not, its colour has joined the diffuse part).
    pub gathers: bool,
}

/// The shapes of lobes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LobeForm {
    /// Ward's Gaussian of slopes.
    Gaussian,
    /// Ashikhmin and Shirley's power of cosines. RADIANCE gathers indirect light with samples of it that all count alike.
    Power,
}

/// What becomes of the diffuse part toward a light source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Loss {
    /// Nothing.
    None,
    /// Part of the light is reflected by a polished surface.
    Polished,
    /// The same, as Schlick approximates it.
    Schlick,
}

/// A direction that is scattered into alone: mirror reflection, refraction, straight transfer.
#[derive(Clone, Copy, Debug)]
pub struct Delta {
    /// Unit direction, world.
    pub direction: Vec3,
    /// What its radiance is multiplied with.
    pub coefficient: Rgb,
    /// Whether it stays on the viewer's side: a reflection counts toward `-lr`, and shadow rays do not follow it.
    pub reflected: bool,
    /// The medium it goes on in; `None` if that does not change.
    pub medium: Option<Inside>,
}

/// How often RADIANCE draws a sample anew that falls below the surface.
const TRIES: u32 = 10;

/// Scattering at a point, for one direction to the viewer.
#[derive(Clone, Debug)]
pub struct Bsdf {
    frame: Frame,
    to_viewer: Vec3,
    geometric: Vec3,
    straight: Vec3,
    flat: bool,
    /// Albedo for lamps: reflected, transmitted.
    pub diffuse: [Rgb; 2],
    /// Albedo for indirect light: the same, and what `-st` adds.
    pub ambient: [Rgb; 2],
    /// Rough lobes: reflected, transmitted.
    pub lobes: [Option<Lobe>; 2],
    /// Directions scattered into alone.
    pub deltas: [Option<Delta>; 2],
    loss: Loss,
    /// Whether a texture bends the normal.
    bent: bool,
    /// Whether rough reflection is gathered by [`Rules::single`] samples.
    pub single: bool,
    /// What a bent normal leaves of the diffuse lobe above the surface, as a fraction; indirect light is divided by it.
    pub kept: f64,
    /// How light sources are scattered by expressions.
    functions: Option<Box<(Arc<Functions>, Seen)>>,
}

impl Bsdf {
    /// What `material` does at `point` with the pattern `pattern`.
    pub fn new(material: &Material, point: &Point, pattern: Rgb, rules: &Rules) -> Self {
        match material {
            Material::Reflectance(m) => Self::reflectance(point, &Reflectance { color: m.color * pattern, ..*m }, rules),
            Material::Ashikhmin(m) => Self::ashikhmin(point, m, pattern, rules),
            Material::Dielectric(inside) => Self::interface(point, inside, None, pattern, rules),
            Material::Interface(inside, outside) => Self::interface(point, inside, Some(outside), pattern, rules),
            Material::Glass(glass) => Self::glass(point, glass, pattern),
            Material::Mirror(color) => {
                let mut bsdf = Self::black(point);
                if point.front {
                    bsdf.deltas[0] =
                        Some(Delta { direction: bsdf.mirror(point), coefficient: *color * pattern, reflected: true, medium: None });
                }
                bsdf
            }
            Material::Light(_) | Material::Illum(_) | Material::Glow(..) | Material::Spotlight(..) => Self::black(point),
            Material::Functions(_) | Material::Antimatter => Self::black(point),
        }
    }

    /// BRTDfunc at a hit: coefficients of the mirror direction and of the straight one, diffuse parts, a function for lamps.
    pub fn functions(m: &FunctionMaterial, at: &At, point: &Point, pattern: Rgb) -> Self {
        let mut bsdf = Self::black(point);
        let seen = m.functions.seen(at, point.shading, bsdf.to_viewer.z, pattern);
        let [reflected, straight] = m.functions.straight(&seen);
        if straight != Rgb::ZERO {
            let direction = if point.bends { (-point.to_viewer - point.perturbation).normalize() } else { -point.to_viewer };
            bsdf.deltas[1] = Some(Delta { direction, coefficient: straight, reflected: false, medium: None });
        }
        if reflected != Rgb::ZERO {
            let direction = point.mirrored(point.shading);
            bsdf.deltas[0] = Some(Delta { direction, coefficient: reflected, reflected: true, medium: None });
        }
        bsdf.diffuse = [m.diffuse[!point.front as usize] * pattern, m.through * pattern];
        bsdf.gather_diffuse(point);
        if m.functions.scatters() {
            bsdf.functions = Some(Box::new((m.functions.clone(), seen)));
        }
        bsdf
    }

    /// Lets indirect light be scattered by the diffuse parts. A tilted shading normal must not lose light: the cosine lobe cut by the geometric
    /// horizon keeps (1 + cos)/2 of itself.
    fn gather_diffuse(&mut self, point: &Point) {
        if self.bent {
            self.kept = (0.5 * (1.0 + point.shading.dot(point.geometric))).max(0.5);
        }
        self.ambient = self.diffuse;
    }

    /// Nothing is scattered: where lights and voids are.
    pub fn black(point: &Point) -> Self {
        let frame = Frame::around(point.shading);
        Self {
            frame,
            to_viewer: frame.to_local(point.to_viewer),
            geometric: frame.to_local(point.geometric),
            straight: frame.to_local(-point.to_viewer),
            flat: point.flat,
            diffuse: [Rgb::ZERO; 2],
            ambient: [Rgb::ZERO; 2],
            lobes: [None; 2],
            deltas: [None; 2],
            loss: Loss::None,
            bent: point.perturbation != Vec3::ZERO,
            single: false,
            kept: 1.0,
            functions: None,
        }
    }

    /// What a polished surface reflects toward the viewer whatever it is made of.
    pub fn fresnel(&self, rules: &Rules) -> f64 {
        fresnel(self.to_viewer.z.max(0.001), rules.fresnel_offset)
    }

    /// The mirror direction, world: at the bent normal, unless that would lead through the surface.
    pub fn mirror(&self, point: &Point) -> Vec3 {
        let direction = point.mirrored(point.shading);
        if self.bent && direction.dot(point.geometric) <= TINY { point.mirrored(point.geometric) } else { direction }
    }

    /// The local form of a world direction.
    pub fn to_local(&self, direction: Vec3) -> Vec3 {
        self.frame.to_local(direction)
    }

    /// The world form of a local direction.
    pub fn to_world(&self, direction: Vec3) -> Vec3 {
        self.frame.to_world(direction)
    }

    /// Unit vector to the viewer, local.
    pub fn viewer(&self) -> Vec3 {
        self.to_viewer
    }

    /// The direction of light that goes straight through, local.
    pub fn straight(&self) -> Vec3 {
        self.straight
    }

    /// f·|cos θ| toward the viewer for light arriving from the local direction `wi`, in 1/sr per channel: the sum over the parts, each times its weight.
    pub fn value(&self, wi: Vec3, arriving: Arriving, weights: &[f64; 4], rules: &Rules) -> Rgb {
        let side = (wi.z < 0.0) as usize;
        let diffuse = weights[side];
        let lambert = wi.z.abs() / PI;
        let lobe = |side: usize| self.lobes[side].as_ref().filter(|_| weights[2 + side] != 0.0);
        match arriving {
            Arriving::Lamp(omega) => {
                let specular = weights[2 + side];
                let loss = match self.loss {
                    Loss::None => 1.0,
                    Loss::Polished => 1.0 - fresnel(wi.z.abs(), rules.fresnel_offset),
                    Loss::Schlick => 1.0 - schlick(wi.z.abs()),
                };
                let mut highlight =
                    lobe(side).map_or(Rgb::ZERO, |lobe| lobe.color * (specular * self.highlight(lobe, side, wi, omega, rules)));
                if let Some((functions, seen)) = self.functions.as_deref() {
                    let value = functions.source(seen, self.to_world(wi), omega);
                    if bright(value) > TINY {
                        highlight += value * (specular * wi.z.abs());
                    }
                }
                self.diffuse[side] * (lambert * loss * diffuse) + highlight
            }
            Arriving::Indirect => {
                let gathers =
                    |part: Part| lobe(part.side()).filter(|l| l.gathers && l.form == LobeForm::Gaussian).filter(|_| self.admits(part, wi));
                let mut light = if self.passes(wi) { self.ambient[side] * (lambert * diffuse / self.kept) } else { Rgb::ZERO };
                if let Some(lobe) = gathers(Part::SpecularReflection) {
                    light += lobe.color * (weights[2] * self.gathered(lobe.alpha, wi, rules.lobe));
                }
                if let Some(lobe) = gathers(Part::SpecularTransmission) {
                    light += lobe.color * (weights[3] * self.through_pdf(lobe, wi));
                }
                light
            }
        }
    }

    /// The balance heuristic's weight, over the density, of each part for a direction aimed at a light with density `pdf`, where `counts` samples
    /// of each part might have found the light too (Veach 1997, equation 9.8): none where the direction does not pass. Indirect light is
    /// weighed for the parts that have such samples only.
    pub fn balance(&self, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> [f64; 4] {
        std::array::from_fn(|k| match if self.admits(Part::ALL[k], wi) { counts[k] } else { 0.0 } {
            0.0 if arriving == Arriving::Indirect => 0.0,
            0.0 => 1.0 / pdf,
            count => 1.0 / (pdf + count * self.pdf(Part::ALL[k], wi)),
        })
    }

    /// The reflected lobe for indirect light, without its colour.
    fn gathered(&self, alpha: [f64; 2], wi: Vec3, form: Ward) -> f64 {
        if self.single {
            self.repeated(alpha) * reflection_pdf(alpha, self.to_viewer, wi)
        } else {
            self.tilt(wi) * reflection(form, alpha, self.to_viewer, wi)
        }
    }

    /// How many times as dense as the first try the samples are that RADIANCE finds above the surface in as many tries as it makes.
    pub fn repeated(&self, alpha: [f64; 2]) -> f64 {
        let missed = 1.0 - above(alpha, self.to_viewer, self.geometric);
        (0..TRIES).fold(0.0, |tries, _| 1.0 + missed * tries)
    }

    /// What RADIANCE makes of a bent normal where it gathers indirect light by a reflecting lobe: its samples are weighted by the cosines to
    /// the geometric normal instead, and the lobe is this many times as strong.
    pub fn tilt(&self, wi: Vec3) -> f64 {
        if !self.bent {
            return 1.0;
        }
        let (to_light, to_viewer) = (wi.dot(self.geometric), self.to_viewer.dot(self.geometric));
        to_light / (to_light + to_viewer) * (wi.z + self.to_viewer.z) / wi.z
    }

    /// By how much more a part scatters lamps than indirect light from the direction `wi`; `None` where its colour or shape differs too, so that
    /// lamps must not be found by sampling it.
    pub fn lamp_ratio(&self, part: Part, wi: Vec3) -> Option<f64> {
        let side = part.side();
        match part {
            Part::DiffuseReflection | Part::DiffuseTransmission => {
                let alike = self.loss == Loss::None && self.lobes[side].is_none_or(|l| l.gathers);
                alike.then_some(self.kept)
            }
            Part::SpecularReflection => (!self.single).then(|| 1.0 / self.tilt(wi)),
            Part::SpecularTransmission => None,
        }
    }

    /// Whether a part's samples all count alike, as in RADIANCE, instead of being weighted.
    pub fn is_unweighted(&self, part: Part) -> bool {
        !part.diffuse() && self.lobes[part.side()].is_some_and(|l| l.form == LobeForm::Power)
    }

    /// What is added to the squared roughness of the lobe on a side for a lamp that one sample of solid angle `omega` stands for.
    pub fn widened(&self, side: usize, omega: f64, rules: &Rules) -> f64 {
        match side {
            1 => omega / PI,
            _ if self.flat => omega / (4.0 * PI) * (1.0 - rules.light_jitter.unwrap_or(1.0)),
            _ => 0.0,
        }
    }

    /// A rough lobe for a lamp that one sample of solid angle `omega` stands for, without its colour.
    fn highlight(&self, lobe: &Lobe, side: usize, wi: Vec3, omega: f64, rules: &Rules) -> f64 {
        let alpha = lobe.alpha.map(|a| a + self.widened(side, omega, rules));
        let value = if lobe.form == LobeForm::Power {
            power_reflection(lobe.alpha, self.to_viewer, wi)
        } else if side == 0 {
            reflection(rules.lobe, alpha, self.to_viewer, wi)
        } else {
            transmission(alpha, self.straight, self.to_viewer, wi)
        };
        // RADIANCE drops the tail of a lobe.
        let negligible = rules.light_jitter.is_some()
            && value <= TINY * if side == 0 { wi.z } else { (wi.z.abs() / self.to_viewer.z.max(0.001)).sqrt() };
        if negligible { 0.0 } else { value }
    }

    /// Whether a local direction is on the same side of the surface as of the shading normal.
    pub fn passes(&self, wi: Vec3) -> bool {
        (wi.dot(self.geometric) > TINY) == (wi.z > 0.0) && wi.z != 0.0
    }

    /// Whether indirect light from a local direction goes into a part: into the lobe of what is seen through a surface on the other side of the
    /// surface itself, however bent its normal is (as in RADIANCE), into any other on one side of both.
    pub fn admits(&self, part: Part, wi: Vec3) -> bool {
        if part == Part::SpecularTransmission {
            return wi.dot(self.geometric) < -TINY;
        }
        self.passes(wi) && (wi.z < 0.0) as usize == part.side()
    }

    fn through_pdf(&self, lobe: &Lobe, wi: Vec3) -> f64 {
        transmission_pdf(lobe.alpha, self.straight, wi)
    }

    /// The part of uniform light that is scattered toward the viewer, by the coefficients of all parts; lobes count whole.
    pub fn albedo(&self) -> Rgb {
        let lobes = self.lobes.iter().flatten().filter(|l| l.gathers).map(|l| l.color);
        let deltas = self.deltas.iter().flatten().map(|d| d.coefficient);
        self.ambient[0] + self.ambient[1] + lobes.sum::<Rgb>() + deltas.sum::<Rgb>()
    }

    /// How much indirect light each part gathers, for choosing among them: the largest channel of its albedo, 0 for a part that gathers none.
    pub fn weights(&self) -> [f64; 4] {
        let lobe = |side: usize| self.lobes[side].filter(|l| l.gathers).map_or(0.0, |l| l.color.max_element());
        [self.ambient[0].max_element(), self.ambient[1].max_element(), lobe(0), lobe(1)]
    }

    /// A local direction drawn from one part; `None` if it falls where nothing is scattered.
    pub fn sample(&self, part: Part, u: [f64; 2]) -> Option<Vec3> {
        let wi = match part {
            Part::DiffuseReflection | Part::DiffuseTransmission => part.lambert(u),
            Part::SpecularReflection => match self.lobes[0]? {
                Lobe { form: LobeForm::Power, alpha, .. } => sample_power(alpha, self.to_viewer, u),
                Lobe { alpha, .. } => sample_reflection(alpha, self.to_viewer, u),
            },
            Part::SpecularTransmission => sample_transmission(self.lobes[1]?.alpha, self.straight, u),
        };
        self.admits(part, wi).then_some(wi)
    }

    /// The density per solid angle with which [`Bsdf::sample`] draws `wi` from `part`, before rejection; a lobe of ashik2, which is only sampled
    /// by [`Bsdf::unweighted`], has none.
    pub fn pdf(&self, part: Part, wi: Vec3) -> f64 {
        if part != Part::SpecularTransmission && (wi.z < 0.0) as usize != part.side() {
            return 0.0;
        }
        match part {
            Part::DiffuseReflection | Part::DiffuseTransmission => wi.z.abs() / PI,
            Part::SpecularReflection => {
                self.lobes[0].filter(|l| l.form == LobeForm::Gaussian).map_or(0.0, |l| reflection_pdf(l.alpha, self.to_viewer, wi))
            }
            Part::SpecularTransmission => self.lobes[1].map_or(0.0, |l| self.through_pdf(&l, wi)),
        }
    }

    /// One sample of a rough lobe by RADIANCE's rule: a local direction that carries the whole colour of the lobe, as it is accepted within so many tries.
    /// Below 1, `-ss` narrows the lobe; at 0 it is a mirror.
    pub fn unweighted(&self, part: Part, spread: f64, sampler: &mut Sampler) -> Option<(Vec3, Rgb)> {
        let lobe = self.lobes[part.side()].filter(|l| l.gathers)?;
        let color = lobe.color;
        let tries = if spread == 0.0 { 1 } else { TRIES };
        (0..tries).find_map(|_| {
            let [u, v] = if spread == 0.0 { [0.0; 2] } else { sampler.pair() };
            self.sample(part, [spread * u, v]).map(|wi| (wi, color))
        })
    }
}
