//! The products of coefficients that paths carry, and the columns of a basis that belong to them.
//!
//! Of a path that meets the unknown more often than products tell, nothing counts but how often, and all that is scattered, the albedo: such light is
//! Σ wₙ Aⁿ, the wₙ being moments of what the albedo must be for the light to grow without end, one over numbers κ from 0 to 1. It is told at a few
//! albedos. Between them Σ wₙ Aⁿ is as sums of 1/(1 − κ A) are (Cauchy 1841): a polynomial over a product of such (1 − κ A).

use super::LANES;
use crate::bsdf::Part;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// How many products a path may carry.
pub const ORDER: usize = 3;

/// The same of one that is polished, which needs few nodes: light goes straight through closed bodies, and meets them again and again. If it meets
/// them more often, the coefficients are taken for what they are as far as is known.
pub const POLISHED_ORDER: usize = 5;

/// Where albedos and κ would end that stand ever denser: behind 1. So light is known to 1e-4 of itself where κ is up to .95, to .005 where it is .99.
const END: f64 = 1.02;

/// The products of lobe coefficients that paths carry: how often each [`Part`] of the unknown was met, up to [`ORDER`] or [`POLISHED_ORDER`] in all.
#[derive(Clone, Debug)]
pub struct Monomials {
    /// Exponents of the coefficients of the four parts.
    pub exponents: Vec<[u8; 4]>,
    /// The first column of each product.
    offsets: Vec<usize>,
    /// Which product each becomes with one more of a part.
    next: Vec<[Option<u8>; 4]>,
    polished: bool,
    nodes: usize,
    /// The columns of products.
    told: usize,
    /// The albedos of the columns after them.
    albedos: Vec<f32>,
}

impl Monomials {
    /// All products for an unknown that transmits light or does not, with lobes at `nodes` roughnesses; of a polished one, with reflectances.
    pub fn new(transmits: bool, polished: bool, nodes: usize) -> Self {
        let albedos = if polished { vec![] } else { albedos().map(|a| a as f32).to_vec() };
        let mut monomials = Self { exponents: Vec::new(), offsets: Vec::new(), next: Vec::new(), polished, nodes, told: 0, albedos };
        let order = if polished { POLISHED_ORDER } else { ORDER };
        let most = |part: usize, left: usize| if part % 2 == 1 && !transmits { 0 } else { left };
        for a in 0..=order {
            for b in 0..=most(1, order - a) {
                for c in 0..=order - a - b {
                    for d in 0..=most(3, order - a - b - c) {
                        monomials.offsets.push(monomials.told);
                        monomials.exponents.push([a as u8, b as u8, c as u8, d as u8]);
                        monomials.told += if monomials.varies(monomials.exponents.len() - 1) { nodes } else { 1 };
                    }
                }
            }
        }
        let with = |mut exponents: [u8; 4], part: usize| {
            exponents[part] += 1;
            monomials.exponents.iter().position(|e| *e == exponents).map(|m| m as u8)
        };
        monomials.next = monomials.exponents.iter().map(|&e| [0, 1, 2, 3].map(|part| with(e, part))).collect();
        monomials
    }

    /// The product `m` times the coefficient of one more part; `None` if it was met too often.
    pub fn times(&self, m: u8, part: Part) -> Option<u8> {
        self.next[m as usize][part as usize]
    }

    /// Whether a product's picture depends on the roughness, or on what a mirror reflects.
    pub fn varies(&self, m: usize) -> bool {
        let [_, _, reflected, through] = self.exponents[m];
        reflected > 0 || through > 0 && !self.polished
    }

    /// The first column of a product.
    pub fn offset(&self, m: u8) -> usize {
        self.offsets[m as usize]
    }

    /// The number of columns of a channel: one for each product, or one for each product and node, and one for each albedo.
    pub fn columns(&self) -> usize {
        self.told + self.albedos.len()
    }

    /// How many of them are products': the first.
    pub fn told(&self) -> usize {
        self.told
    }

    /// For each of those: its product, and its node if it has one.
    pub fn column(&self) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
        (0..self.exponents.len()).flat_map(move |m| {
            let count = if self.varies(m) { self.nodes } else { 1 };
            (0..count).map(move |n| (m, self.varies(m).then_some(n)))
        })
    }

    /// The albedos of the others: each holds Aⁿ for n + 1 meetings more than products tell.
    pub fn albedos(&self) -> &[f32] {
        &self.albedos
    }

    /// What the picture takes of those if this is all that is scattered, from 0 to 1.
    pub fn beyond(&self, albedo: f64) -> Vec<f64> {
        if self.albedos.is_empty() { vec![] } else { between(albedo.clamp(0.0, 1.0)).to_vec() }
    }
}

/// A part of the way to [`END`], in even steps of its logarithm.
fn toward_end(part: f64) -> f64 {
    END * (1.0 - (1.0 - 1.0 / END).powf(part))
}

/// The albedos, from 0 to 1: by that, Chebyshev's points, the first and the last of them at the ends.
fn albedos() -> [f64; LANES] {
    let point = |i: usize| (PI * (i as f64 + 0.5) / LANES as f64).cos();
    std::array::from_fn(|i| toward_end(0.5 - 0.5 * point(i) / point(0)))
}

/// The product of 1 − κ A over all κ.
fn lacking(albedo: f64) -> f64 {
    static GROWTHS: LazyLock<[f64; LANES]> = LazyLock::new(|| std::array::from_fn(|j| toward_end(j as f64 / LANES as f64)));
    GROWTHS.iter().map(|growth| 1.0 - albedo * growth).product()
}

/// What light that met the unknown more often than [`ORDER`] times takes of the columns of the albedos.
fn between(albedo: f64) -> [f64; LANES] {
    static NODES: LazyLock<[(f64, f64); LANES]> = LazyLock::new(|| albedos().map(|node| (node, lacking(node))));
    let (met, rest) = (albedo.powi(ORDER as i32 + 1), lacking(albedo));
    NODES.map(|(node, lacking)| {
        let others = NODES.iter().filter(|(other, _)| *other != node);
        met * others.map(|(other, _)| (albedo - other) / (node - other)).product::<f64>() * lacking / rest
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_that_is_scattered_often_is_known_between_the_albedos() {
        for (growth, tolerance) in
            [(0.0, 1e-4), (0.1, 1e-4), (0.3, 1e-4), (0.6, 1e-4), (0.8, 1e-4), (0.95, 1e-4), (0.98, 2e-3), (0.99, 5e-3)]
        {
            for albedo in (0..=100).map(|i| f64::from(i) / 100.0) {
                let told: f64 = between(albedo).iter().zip(albedos()).map(|(w, a)| w / (1.0 - growth * a)).sum();
                let light = albedo.powi(4) / (1.0 - growth * albedo);
                assert!((told - light).abs() <= tolerance * light, "{growth} {albedo}: {told} for {light}");
            }
        }
    }
}
