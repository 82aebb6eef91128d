//! From the numbers of a material to the coefficients of the basis' columns.

use crate::transport::{Alpha, Monomials};
use std::ops::Range;

/// The rough materials: what A1… mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// Whether the specular lobe is coloured: metal.
    pub metal: bool,
    /// Whether it transmits: trans.
    pub transmits: bool,
    /// Whether it has two roughnesses.
    pub anisotropic: bool,
    /// Whether it is polished: a mirror, with a Fresnel term. The nodes of its basis are what that reflects.
    pub polished: bool,
}

impl Kind {
    /// The kind that a type is; `None` if it is none of them.
    pub fn named(name: &str) -> Option<Self> {
        let (stem, anisotropic) = name.strip_suffix('2').map_or((name, false), |stem| (stem, true));
        let kind = |metal, transmits| Some(Self { metal, transmits, anisotropic, polished: false });
        match stem {
            "plastic" => kind(false, false),
            "metal" => kind(true, false),
            "trans" => kind(false, true),
            _ => None,
        }
    }

    /// The places of the roughnesses among the real arguments.
    pub fn roughnesses(self) -> Range<usize> {
        4..if self.anisotropic { 6 } else { 5 }
    }
}

/// The place of the specularity among the real arguments.
pub const SPECULARITY: usize = 3;

/// The coefficients of the four parts for the real arguments `a`, each for red, green and blue (the partition of what is not
/// absorbed).
pub fn parts(kind: Kind, a: &[f64]) -> [[f64; 3]; 4] {
    let at = kind.roughnesses().end;
    let (specular, transmission, through) = match kind.transmits {
        true => (a[SPECULARITY], a[at] * (1.0 - a[SPECULARITY]), a[at + 1]),
        false => (a[SPECULARITY], 0.0, 0.0),
    };
    let colored = |share: f64| [a[0] * share, a[1] * share, a[2] * share];
    [
        colored(1.0 - specular - transmission),
        colored(transmission * (1.0 - through)),
        if kind.metal { colored(specular) } else { [specular; 3] },
        colored(transmission * through),
    ]
}

/// The roughnesses of nodes along the two tangents, rising; without anisotropy the first alone counts. Of what is polished, reflectances.
pub type Grid = [Vec<f64>; 2];

/// The coefficients of red's, green's and blue's columns for the real arguments `a`, in a basis with nodes on `grid` (anisotropic nodes are all
/// pairs, u slowest).
pub fn coefficients(kind: Kind, monomials: &Monomials, grid: &Grid, a: &[f64]) -> [Vec<f64>; 3] {
    let mut parts = parts(kind, a);
    let albedos: [f64; 3] = std::array::from_fn(|c| parts.iter().map(|part| part[c]).sum());
    let nodes = match kind.polished {
        true => std::mem::replace(&mut parts[2], [1.0; 3]).map(|reflectance| lagrange(&grid[0], reflectance, [grid[0].len(); 2])),
        false => {
            let nodes = nodes(kind, grid, &a[kind.roughnesses()]);
            [nodes.clone(), nodes.clone(), nodes]
        }
    };
    std::array::from_fn(|c| {
        let product = |m: usize| monomials.exponents[m].iter().zip(parts).map(|(&e, p)| p[c].powi(e as i32)).product::<f64>();
        let products: Vec<f64> = (0..monomials.exponents.len()).map(product).collect();
        let told = monomials.column().map(|(m, node)| products[m] * node.map_or(1.0, |n| nodes[c][n]));
        told.chain(monomials.beyond(albedos[c])).collect()
    })
}

/// The coefficients that make a picture brighter than the scene is, by these factors of red, green and blue.
pub fn exposed(mut coefficients: [Vec<f64>; 3], exposures: [f64; 3]) -> [Vec<f64>; 3] {
    coefficients.iter_mut().zip(exposures).for_each(|(x, exposure)| x.iter_mut().for_each(|x| *x *= exposure));
    coefficients
}

/// The weights of the nodes at a roughness.
pub fn nodes(kind: Kind, grid: &Grid, roughness: &[f64]) -> Vec<f64> {
    let at = |axis: usize| {
        let grid: Vec<f64> = grid[axis].iter().map(|a| a.ln()).collect();
        cubic(&grid, roughness[axis].abs().max(1e-9).ln())
    };
    let u = at(0);
    match kind.anisotropic {
        false => u,
        true => {
            let v = at(1);
            u.iter().flat_map(|u| v.iter().map(move |v| u * v)).collect()
        }
    }
}

/// The roughnesses of the nodes of a basis, squared.
pub fn alphas(kind: Kind, grid: &Grid) -> Vec<Alpha> {
    match kind.anisotropic {
        false => grid[0].iter().map(|a| [a * a; 2]).collect(),
        true => grid[0].iter().flat_map(|u| grid[1].iter().map(move |v| [u * u, v * v])).collect(),
    }
}

/// Weights that interpolate at `x` between nodes at `grid`: Lagrange's cubic through the four nearest, or a parabola through three. Beyond
/// the ends, the end counts.
pub fn cubic(grid: &[f64], x: f64) -> Vec<f64> {
    lagrange(grid, x, [4; 2])
}

/// The same by the polynomial through the nearest: as many to both sides as there are, but not fewer nor more in all than these, which are even; all
/// if there are not so many.
pub fn lagrange(grid: &[f64], x: f64, [least, most]: [usize; 2]) -> Vec<f64> {
    let n = grid.len();
    let x = x.clamp(grid[0], grid[n - 1]);
    let below = grid.partition_point(|&g| g <= x);
    let points = (2 * below.min(n - below)).clamp(least, most).min(n);
    let first = below.saturating_sub(points / 2).min(n - points);
    let nearest = first..first + points;
    let mut weights = vec![0.0; n];
    for i in nearest.clone() {
        weights[i] = nearest.clone().filter(|&j| j != i).map(|j| (x - grid[j]) / (grid[i] - grid[j])).product();
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cubic_is_exact_for_cubics_and_at_nodes() {
        let grid = [0.0, 0.7, 1.5, 2.0, 3.1, 4.0];
        let f = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x - 0.1 * x * x * x;
        for x in [0.0, 0.3, 0.7, 1.9, 2.0, 3.9, 4.0] {
            let value: f64 = cubic(&grid, x).iter().zip(grid).map(|(w, g)| w * f(g)).sum();
            assert!((value - f(x)).abs() < 1e-12);
        }
    }
}
