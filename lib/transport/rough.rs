//! The basis of a rough unknown: plastic, metal, trans and their anisotropic kin.
//!
//! A path that meets the unknown j times diffusely and k times specularly contributes ρd^j ρs^k times something that depends on the
//! roughness alone. So a picture is a polynomial in the coefficients of the lobes, whose terms are pictures. Roughness is sampled at a few
//! nodes, all evaluated on the same directions. Choices on a path never depend on what is unknown.

use super::lobes::{Alpha, Drawn, Gaussians, Lobes};
use super::monomials::Monomials;
use super::{LANES, Nodes, lanes};
use crate::bsdf::{Arriving, Bsdf, Delta, Part, Point, lobe};
use crate::color::Rgb;
use crate::integrator::{Scattering, Transport};
use crate::material::Inside;
use crate::rules::Rules;
use crate::scene::MaterialId;
use crate::vector::Vec3;
use crate::world::Layer;
use std::cell::OnceCell;
use std::f64::consts::PI;
use wide::f32x8;

/// What is unknown, and how it is explored.
#[derive(Clone, Debug)]
pub struct Rough {
    /// The material.
    pub material: MaterialId,
    /// Whether its specular lobe takes the colour of its patterns, as metal's does.
    pub metal: bool,
    /// Whether it transmits.
    pub transmits: bool,
    /// The roughnesses at which lobes are evaluated; at most [`MOST_NODES`].
    pub nodes: Vec<Alpha>,
    /// The roughnesses from which directions are drawn.
    proposals: Vec<Alpha>,
    /// The products of coefficients.
    pub monomials: Monomials,
    /// What the coefficients of the four parts are taken for where they only decide what is worth how many samples.
    guess: Option<[Rgb; 4]>,
    /// What the parts are taken to scatter of all that is scattered where a path meets the unknown more often than products tell.
    shares: [Rgb; 4],
    /// And how much each node counts there, in lanes.
    there: Vec<f32x8>,
    /// Whether a direction more is worth its cost at the first surface ([`Transport::control`]): where light hardly differs within the lobe.
    pub control: bool,
    /// Of a polished unknown, what its mirror reflects at the nodes, in lanes, apart from the Fresnel term.
    mirror: Option<Vec<f32x8>>,
    /// The nodes and the proposals.
    lobes: Lobes,
}

/// The most roughnesses of a basis.
pub const MOST_NODES: usize = 8 * LANES;

impl Rough {
    /// A material explored at the roughnesses `nodes`, all on the same directions, drawn from the roughnesses `proposals`.
    pub fn new(material: MaterialId, metal: bool, transmits: bool, nodes: Vec<Alpha>, proposals: Vec<Alpha>) -> Self {
        let monomials = Monomials::new(transmits, false, nodes.len());
        let lobes = Lobes::new(&nodes, &proposals);
        let shares = [0, 1, 2, 3].map(|part| if part % 2 == 0 { Rgb::splat(UNKNOWN_SHARE) } else { Rgb::ZERO });
        let middle = middle(&nodes);
        let there = lanes(&(0..nodes.len()).map(|n| f64::from(n == middle)).collect::<Vec<_>>());
        let (guess, control, mirror) = (None, false, None);
        Self { material, metal, transmits, nodes, proposals, monomials, guess, shares, there, control, mirror, lobes }
    }

    /// A polished material: a mirror that is explored at these reflectances, from 0 to 1. A product's picture is a polynomial of its reflectance,
    /// no higher than [`POLISHED_ORDER`](super::POLISHED_ORDER), as (1 − F) r + F is at every meeting: one reflectance more than that suffices.
    pub fn polished(material: MaterialId, metal: bool, transmits: bool, reflectances: &[f64]) -> Self {
        let mirror = Some(lanes(reflectances));
        let monomials = Monomials::new(transmits, true, reflectances.len());
        Self { mirror, monomials, ..Self::new(material, metal, transmits, vec![[0.0; 2]; reflectances.len()], vec![]) }
    }

    /// Takes these for the coefficients of the four parts, and the first that are known also for how what is scattered most often is shared by them,
    /// by a lobe that lies between the nodes as these `weights` have it.
    pub fn know(&mut self, coefficients: [Rgb; 4], weights: &[f64]) {
        let albedo = coefficients.iter().copied().sum::<Rgb>();
        if self.guess.is_none() && albedo.min_element() > 0.0 {
            self.shares = coefficients.map(|coefficient| coefficient / albedo);
            self.there = lanes(weights);
        }
        self.guess = Some(coefficients);
    }

    /// Draws directions from these roughnesses from now on.
    pub fn propose(&mut self, proposals: Vec<Alpha>) {
        self.lobes = Lobes::new(&self.nodes, &proposals);
        self.proposals = proposals;
    }
}

impl Rough {
    /// Something at each node, in lanes.
    fn at_nodes<const L: usize>(&self, f: impl Fn(Alpha) -> f64) -> Nodes<L> {
        std::array::from_fn(|l| f32x8::from(std::array::from_fn(|i| self.nodes.get(l * LANES + i).map_or(0.0, |&alpha| f(alpha) as f32))))
    }

    /// How much the choice of a way on counts each part: what it carries, as far as is known, but never so little that what it does carry comes in
    /// few samples that weigh much.
    fn weights(&self) -> [f64; 4] {
        let sizes = self.guess.map_or([UNKNOWN_SHARE; 4], |guess| guess.map(|g| g.max_element()));
        let least = LEAST_SHARE * sizes.into_iter().fold(UNKNOWN_SHARE, f64::max);
        let gathers = |part: usize| (part < 2 || self.mirror.is_none()) && (part.is_multiple_of(2) || self.transmits);
        std::array::from_fn(|part| if gathers(part) { sizes[part].max(least) } else { 0.0 })
    }

    /// What is special at a point where it is polished; `shape` stands for it there.
    fn polish(&self, shape: &Bsdf, point: &Point, rules: &Rules) -> Polish {
        let fresnel = shape.fresnel(rules);
        let guess = |part: Part| self.guess.map_or(Rgb::splat(UNKNOWN_SHARE), |guess| guess[part as usize]) * (1.0 - fresnel);
        let delta = |direction, coefficient, reflected| Some(Delta { direction, coefficient, reflected, medium: None });
        let straight = delta(shape.to_world(shape.straight()), guess(Part::SpecularTransmission), false);
        let mirror = delta(shape.mirror(point), guess(Part::SpecularReflection) + Rgb::splat(fresnel), true);
        Polish { fresnel, deltas: [mirror, straight.filter(|_| self.transmits)] }
    }

    /// A term after one more part: its product with that, and what else is to be multiplied with.
    #[inline]
    fn meet<const L: usize>(&self, term: &Term<L>, part: Part) -> Option<Term<L>> {
        match (self.monomials.times(term.monomial, part), self.mirror.is_some()) {
            (Some(monomial), _) => Some(Term { monomial, ..*term }),
            (_, false) => Some(Term { beyond: term.beyond.saturating_add(1), known: term.known * self.shares[part as usize], ..*term }),
            (_, true) => self.guess.map(|guess| Term { known: term.known * guess[part as usize], ..*term }),
        }
    }
}

/// The node nearest to the mean of all, by logarithms.
fn middle(nodes: &[Alpha]) -> usize {
    let log = |alpha: &Alpha| alpha.map(|a| a.max(f64::MIN_POSITIVE).ln());
    let mean = |axis: usize| nodes.iter().map(|alpha| log(alpha)[axis]).sum::<f64>() / nodes.len() as f64;
    let means = [0, 1].map(mean);
    let off = |alpha: &Alpha| (0..2).map(|axis| (log(alpha)[axis] - means[axis]).powi(2)).sum::<f64>();
    (0..nodes.len()).min_by(|a, b| off(&nodes[*a]).total_cmp(&off(&nodes[*b]))).unwrap_or(0)
}

/// One term of a throughput.
#[derive(Clone, Copy)]
struct Term<const L: usize> {
    monomial: u8,
    /// How often the unknown was met since, more often than products tell.
    beyond: u16,
    /// What known surfaces and patterns make of it.
    known: Rgb,
    /// What the lobes of the unknown make of it, at each node, over the densities of the directions.
    lobes: Nodes<L>,
}

/// The throughput of a path: a sum of at most two terms, as the last surface may have scattered diffusely or specularly.
#[derive(Clone)]
pub(super) struct Beta<const L: usize> {
    terms: [Option<Term<L>>; 2],
}

/// Hands each path's light to the columns of its product.
pub(super) struct Tagging<'a, const L: usize> {
    pub rules: &'a Rules,
    pub unknown: &'a Rough,
    pub columns: &'a mut [f32],
}

/// Scattering at a known surface, or at the unknown.
pub(super) enum Surface<'a, const L: usize> {
    Known(Bsdf),
    Unknown { shape: Bsdf, pattern: Rgb, unknown: &'a Rough, polish: Option<Box<Polish>>, repeated: Repeated<L>, drawn: Drawn<L> },
}

/// How many times as dense as the lobe of each node the [`Rules::single`] samples of it are, where those gather indirect light; found when it is asked.
type Repeated<const L: usize> = Option<OnceCell<Box<Nodes<L>>>>;

/// What is special where the unknown is polished.
pub(super) struct Polish {
    /// What is reflected toward the viewer whatever it is made of.
    fresnel: f64,
    /// The mirror's direction, and straight on.
    deltas: [Option<Delta>; 2],
}

/// A lobe that is sampled in more ways than these has no control variate.
const MOST_CONTROLLED: usize = 4;

/// What a part of the unknown counts for in the choice of a way on where nothing is known of it; and the least, in terms of the largest.
const UNKNOWN_SHARE: f64 = 0.5;
const LEAST_SHARE: f64 = 0.1;

impl<const L: usize> Tagging<'_, L> {
    /// A part's value at a direction, without its coefficient, and the density with which its samples are drawn there.
    pub(super) fn shape(&self, shape: &Bsdf, repeated: &Repeated<L>, part: Part, wi: Vec3, arriving: Arriving) -> (Nodes<L>, f64) {
        let polished = self.unknown.mirror.is_some();
        if part.diffuse() {
            let lambert = wi.z.abs() / PI;
            let value = match arriving {
                Arriving::Indirect => lambert / shape.kept,
                Arriving::Lamp(_) if polished => lambert * (1.0 - lobe::fresnel(wi.z.abs(), self.rules.fresnel_offset)),
                Arriving::Lamp(_) => lambert,
            };
            return ([f32x8::splat(value as f32); L], lambert);
        }
        if polished {
            return ([f32x8::ZERO; L], 0.0);
        }
        let widened = match arriving {
            Arriving::Lamp(omega) => shape.widened(part.side(), omega, self.rules),
            Arriving::Indirect => 0.0,
        };
        if part == Part::SpecularReflection {
            let slopes = lobe::slopes(shape.viewer() + wi);
            return self.reflection(shape, repeated, wi, arriving, self.unknown.lobes.at(slopes, widened as f32));
        }
        let drawn: Gaussians<L> = self.unknown.lobes.at(lobe::shifts(shape.straight(), wi), 0.0);
        let density = lobe::transmission_density_beside_gaussian(shape.straight(), wi);
        let (nodes, scale) = match arriving {
            Arriving::Lamp(_) => {
                let bent: Gaussians<L> = self.unknown.lobes.at(lobe::bends(shape.straight(), wi), widened as f32);
                (bent.nodes, lobe::transmission_beside_gaussian(shape.viewer(), wi))
            }
            Arriving::Indirect => (drawn.nodes, density),
        };
        (nodes.map(|node| node * scale as f32), drawn.proposed * density)
    }

    /// The same of the reflected lobe, where its densities are known.
    fn reflection(
        &self,
        shape: &Bsdf,
        repeated: &Repeated<L>,
        wi: Vec3,
        arriving: Arriving,
        Gaussians { nodes, proposed }: Gaussians<L>,
    ) -> (Nodes<L>, f64) {
        let density = lobe::density_beside_gaussian(shape.viewer() + wi);
        let nodes = match repeated {
            Some(repeated) if arriving == Arriving::Indirect => {
                let repeated = repeated.get_or_init(|| Box::new(self.unknown.at_nodes(|alpha| shape.repeated(alpha))));
                std::array::from_fn(|l| nodes[l] * repeated[l] * density as f32)
            }
            _ => {
                let tilt = if arriving == Arriving::Indirect { shape.tilt(wi) } else { 1.0 };
                let scale = (tilt * lobe::beside_gaussian(self.rules.lobe, shape.viewer(), wi)) as f32;
                nodes.map(|n| n * scale)
            }
        };
        (nodes, proposed * density)
    }

    /// The first term of a throughput, after meeting a part of the unknown that makes `lobes` of it at each group of nodes.
    fn met(&self, beta: &Beta<L>, surface: &Surface<L>, part: Part, lobes: impl Fn(usize) -> f32x8) -> Option<Term<L>> {
        let (Surface::Unknown { pattern, unknown, polish, .. }, Some(term)) = (surface, beta.terms[0]) else { return None };
        let next = unknown.meet(&term, part)?;
        let known = polish.as_ref().map_or(next.known, |polish| next.known * (1.0 - polish.fresnel));
        let known = if part == Part::SpecularReflection && !unknown.metal { known } else { known * *pattern };
        Some(Term { known, lobes: std::array::from_fn(|l| term.lobes[l] * lobes(l)), ..next })
    }

    /// What the first term of a throughput is behind a mirror, or straight through it.
    fn mirrored(&self, beta: &Beta<L>, surface: &Surface<L>, polish: &Polish, delta: &Delta) -> Option<Term<L>> {
        let (Surface::Unknown { pattern, unknown, .. }, Some(mirror), Some(term)) = (surface, &self.unknown.mirror, beta.terms[0]) else {
            return None;
        };
        if !delta.reflected {
            return self.met(beta, surface, Part::SpecularTransmission, |_| f32x8::ONE);
        }
        // RADIANCE leaves the Fresnel term of a patterned metal white. Here it takes the hue of a pattern, but not its level.
        let level = if unknown.metal { pattern.max_element() } else { 1.0 };
        let hue = if unknown.metal && level > 0.0 { *pattern / level } else { Rgb::ONE };
        let (known, f) = (term.known * hue, polish.fresnel);
        Some(match unknown.monomials.times(term.monomial, Part::SpecularReflection) {
            Some(monomial) => {
                let (f, left) = (f32x8::splat(f as f32), f32x8::splat((level * (1.0 - f)) as f32));
                let lobes = std::array::from_fn(|l| term.lobes[l] * (mirror.get(l).map_or(f, |r| *r * left + f)));
                Term { monomial, known, lobes, ..term }
            }
            None => Term { known: known * (f + (delta.coefficient - f) * level), ..term },
        })
    }

    /// Hands a path's light that met the unknown more often than products tell to the columns of the albedos.
    fn collect_beyond(&mut self, term: &Term<L>, radiance: Rgb) {
        let Rough { monomials, shares, there, .. } = self.unknown;
        let before = &monomials.exponents[term.monomial as usize];
        let shared = before.iter().zip(shares).fold(term.known, |known, (&e, &share)| (0..e).fold(known, |known, _| known * share));
        let lobe = term.lobes.iter().zip(there).fold(f32x8::ZERO, |sum, (lobes, weights)| sum + *lobes * *weights).reduce_add();
        for (columns, light) in self.columns.chunks_exact_mut(monomials.columns()).zip((shared * radiance).to_array()) {
            let sums = &mut columns[monomials.told()..];
            sums.iter_mut().zip(monomials.albedos()).for_each(|(sum, a)| *sum += lobe * light as f32 * a.powi(i32::from(term.beyond) - 1));
        }
    }

    /// A throughput behind a known surface.
    fn known(&self, beta: &Beta<L>, bsdf: &Bsdf, wi: Vec3, arriving: Arriving, weights: &[f64; 4]) -> Beta<L> {
        let mut beta = beta.clone();
        self.scale(&mut beta, bsdf.value(wi, arriving, weights, self.rules));
        beta
    }
}

impl<'a, const L: usize> Transport for Tagging<'a, L> {
    type Beta = Beta<L>;
    type Surface = Surface<'a, L>;

    fn start(&self) -> Beta<L> {
        Beta { terms: [Some(Term { monomial: 0, beyond: 0, known: Rgb::ONE, lobes: [f32x8::ONE; L] }), None] }
    }

    fn scale(&self, beta: &mut Beta<L>, by: Rgb) {
        beta.terms.iter_mut().flatten().for_each(|t| t.known *= by);
    }

    fn size(&self, beta: &Beta<L>) -> f64 {
        let largest = |lobes: &Nodes<L>| lobes.iter().fold(f32x8::ZERO, |m, &v| m.fast_max(v)).to_array().into_iter().fold(0.0, f32::max);
        let albedo = self.unknown.guess.map_or(UNKNOWN_SHARE, |guess| guess.iter().copied().sum::<Rgb>().max_element());
        let term = |t: &Term<L>| t.known.abs().max_element() * largest(&t.lobes) as f64 * albedo.powi(t.beyond.into());
        beta.terms.iter().flatten().map(term).fold(0.0, f64::max)
    }

    fn surface(&self, layer: &Layer, rules: &Rules) -> Surface<'a, L> {
        if layer.id != self.unknown.material || layer.material.is_none() {
            return Surface::Known(layer.bsdf(rules));
        }
        let shape = layer.bsdf(rules);
        let polish = self.unknown.mirror.is_some().then(|| Box::new(self.unknown.polish(&shape, &layer.point, rules)));
        // What is polished has no lobes.
        let repeated = (rules.single() && polish.is_none()).then(OnceCell::new);
        Surface::Unknown { shape, pattern: layer.pattern, unknown: self.unknown, polish, repeated, drawn: Drawn::NONE }
    }

    fn aimed(&self, beta: &Beta<L>, surface: &Surface<L>, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> Beta<L> {
        match surface {
            Surface::Known(bsdf) => self.known(beta, bsdf, wi, arriving, &bsdf.balance(wi, arriving, pdf, counts)),
            Surface::Unknown { shape, repeated, .. } => {
                let mut next = Beta { terms: [None; 2] };
                let asked = |part: &Part| match arriving {
                    Arriving::Indirect => counts[*part as usize] > 0.0 && shape.admits(*part, wi),
                    Arriving::Lamp(_) => (wi.z < 0.0) as usize == part.side(),
                };
                // A path is a single term, the first, until it is aimed at a light: no direction goes into more than two parts.
                let asked = Part::ALL.into_iter().filter(asked);
                for (slot, part) in next.terms.iter_mut().zip(asked) {
                    let count = counts[part as usize];
                    let (values, density) = self.shape(shape, repeated, part, wi, arriving);
                    // What does not pass is not drawn.
                    let drawn = if shape.admits(part, wi) { count * density } else { 0.0 };
                    let scale = (1.0 / (pdf + drawn)) as f32;
                    *slot = self.met(beta, surface, part, |l| values[l] * scale);
                }
                next
            }
        }
    }

    fn drawn(&self, beta: &Beta<L>, surface: &Surface<L>, wi: Vec3, part: Part, _: usize, count: f64) -> (Beta<L>, f64) {
        match surface {
            Surface::Known(bsdf) => {
                let density = count * bsdf.pdf(part, wi);
                (self.known(beta, bsdf, wi, Arriving::Indirect, &part.alone(1.0 / density)), density)
            }
            Surface::Unknown { shape, repeated, drawn, .. } => {
                let (values, density) = match part {
                    Part::SpecularReflection => self.reflection(shape, repeated, wi, Arriving::Indirect, drawn.last),
                    _ => self.shape(shape, repeated, part, wi, Arriving::Indirect),
                };
                let density = count * density;
                let scale = (1.0 / density) as f32;
                let term = self.met(beta, surface, part, |l| values[l] * scale);
                (Beta { terms: [term, None] }, density)
            }
        }
    }

    /// What the densities of the nodes' lobes were sampled with adds up to one only on the average. Where light is the same all over the lobe
    /// this is all the noise there is, most of that in what depends on the roughness; the light of one direction more takes it away.
    fn control(&self, beta: &Beta<L>, surface: &Surface<L>, part: Part, count: f64) -> Option<(Beta<L>, Vec3, f64)> {
        let Surface::Unknown { shape, unknown, drawn, .. } = surface else { return None };
        if part != Part::SpecularReflection || !unknown.control || unknown.proposals.len() > MOST_CONTROLLED {
            return None;
        }
        // What is seen along the middle of the lobe is the best guess at what is seen within it.
        let wo = shape.viewer();
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        let density = unknown.lobes.most_proposed() * lobe::density_beside_gaussian(wo + wi);
        shape.passes(wi).then(|| (Beta { terms: [self.met(beta, surface, part, |l| drawn.left[l]), None] }, wi, count * density))
    }

    fn ambient(&self, beta: &Beta<L>, surface: &Surface<L>, side: usize) -> Beta<L> {
        match surface {
            Surface::Known(bsdf) => {
                let mut beta = beta.clone();
                self.scale(&mut beta, bsdf.ambient[side]);
                beta
            }
            Surface::Unknown { pattern, unknown, polish, .. } => {
                let left = polish.as_ref().map_or(1.0, |polish| 1.0 - polish.fresnel);
                let mut beta = beta.clone();
                for slot in &mut beta.terms {
                    let met = slot.and_then(|t| unknown.meet(&t, Part::ALL[side]));
                    *slot = met.map(|t| Term { known: t.known * *pattern * left, ..t });
                }
                beta
            }
        }
    }

    fn follow(&self, beta: &Beta<L>, surface: &Surface<L>, delta: &Delta) -> Beta<L> {
        if let Surface::Unknown { polish: Some(polish), .. } = surface {
            return Beta { terms: [self.mirrored(beta, surface, polish, delta), None] };
        }
        let mut beta = beta.clone();
        self.scale(&mut beta, delta.coefficient);
        beta
    }

    fn absorb(&self, beta: &mut Beta<L>, medium: &Inside, length: f64) {
        self.scale(beta, medium.transmittance(length));
    }

    fn collect(&mut self, beta: &Beta<L>, radiance: Rgb) {
        let monomials = &self.unknown.monomials;
        let per_channel = monomials.columns();
        for term in beta.terms.iter().flatten() {
            if term.beyond > 0 {
                self.collect_beyond(term, radiance);
                continue;
            }
            let offset = monomials.offset(term.monomial);
            let varies = monomials.varies(term.monomial as usize);
            let nodes = self.unknown.nodes.len();
            for (channel, light) in (term.known * radiance).to_array().into_iter().enumerate() {
                let columns = &mut self.columns[channel * per_channel + offset..];
                if !varies {
                    columns[0] += light as f32 * term.lobes[0].to_array()[0];
                    continue;
                }
                for (lobes, columns) in term.lobes.iter().zip(columns[..nodes].chunks_mut(LANES)) {
                    let added = *lobes * light as f32;
                    columns.iter_mut().zip(added.to_array()).for_each(|(sum, a)| *sum += a);
                }
            }
        }
    }
}

impl<const L: usize> Scattering for Surface<'_, L> {
    fn bsdf(&self) -> &Bsdf {
        match self {
            Self::Known(shape) | Self::Unknown { shape, .. } => shape,
        }
    }

    fn is_known(&self) -> bool {
        matches!(self, Self::Known(_))
    }

    fn deltas(&self) -> &[Option<Delta>; 2] {
        match self {
            Self::Known(bsdf) => &bsdf.deltas,
            Self::Unknown { polish, .. } => polish.as_ref().map_or(&[None; 2], |polish| &polish.deltas),
        }
    }

    fn weights(&self) -> [f64; 4] {
        match self {
            Self::Known(bsdf) => bsdf.weights(),
            Self::Unknown { unknown, .. } => unknown.weights(),
        }
    }

    fn ways(&self, part: Part) -> usize {
        match self {
            Self::Unknown { unknown, .. } if !part.diffuse() => unknown.proposals.len(),
            _ => 1,
        }
    }

    fn sample(&mut self, part: Part, way: usize, u: [f64; 2]) -> Option<Vec3> {
        match self {
            Self::Unknown { shape, unknown, drawn, .. } if !part.diffuse() => {
                let proposal = unknown.proposals[way];
                let wi = if part == Part::SpecularReflection {
                    let wi = lobe::sample_reflection(proposal, shape.viewer(), u);
                    drawn.take(unknown.lobes.at(lobe::slopes(shape.viewer() + wi), 0.0));
                    wi
                } else {
                    lobe::sample_transmission(proposal, shape.straight(), u)
                };
                shape.admits(part, wi).then_some(wi)
            }
            _ => self.bsdf().sample(part, u),
        }
    }

    fn lamp_ratio(&self, part: Part, wi: Vec3) -> Option<f64> {
        match self {
            Self::Known(bsdf) => bsdf.lamp_ratio(part, wi),
            Self::Unknown { polish: Some(_), .. } => None,
            Self::Unknown { shape, .. } if part.diffuse() => Some(shape.kept),
            Self::Unknown { shape, .. } => shape.lamp_ratio(part, wi),
        }
    }
}
