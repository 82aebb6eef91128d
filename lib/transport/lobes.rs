//! The lobes of a rough unknown: the Gaussian of each roughness that it is explored at, and of those that directions are drawn from.

use super::{Nodes, decay, lanes};
use wide::f32x8;

/// Squared roughnesses along the two tangents of the lobe.
pub type Alpha = [f64; 2];

/// Lobes in lanes. Lanes without one are 0.
#[derive(Clone, Debug)]
pub(super) struct Lobes {
    /// Those that the unknown is explored at.
    nodes: Vec<Lanes>,
    /// The proposals: those that directions are drawn from.
    proposals: Vec<Lanes>,
    /// The least inverses of all their squared roughnesses.
    widest: [f64; 2],
}

/// Inverses of the two squared roughnesses, and of the root of their product.
type Lanes = (f32x8, f32x8, f32x8);

/// The densities of slopes, times π: of each node, and of all proposals together.
#[derive(Clone, Copy)]
pub(super) struct Gaussians<const L: usize> {
    pub nodes: Nodes<L>,
    pub proposed: f64,
}

/// The directions that were drawn from the proposals at a point.
pub(super) struct Drawn<const L: usize> {
    /// The densities of the last one.
    pub last: Gaussians<L>,
    /// What the densities of the nodes over those of the proposals leave of one.
    pub left: Nodes<L>,
}

/// Where all exponents are beyond this, the densities are nothing: one more than where [`decay`] is 0, for what `f32` rounds.
const NOTHING: f64 = 88.0;

fn inverses(roughnesses: &[Alpha]) -> Vec<Lanes> {
    let of = |inverse: fn(&Alpha) -> f64| lanes(&roughnesses.iter().map(inverse).collect::<Vec<_>>());
    let (u, v, both) = (of(|a| 1.0 / a[0]), of(|a| 1.0 / a[1]), of(|a| 1.0 / (a[0] * a[1]).sqrt()));
    u.into_iter().zip(v).zip(both).map(|((u, v), both)| (u, v, both)).collect()
}

impl Lobes {
    pub fn new(nodes: &[Alpha], proposals: &[Alpha]) -> Self {
        let widest = |[u, v]: [f64; 2], a: &Alpha| [u.min(1.0 / a[0]), v.min(1.0 / a[1])];
        let widest = nodes.iter().chain(proposals).fold([f64::INFINITY; 2], widest);
        Self { nodes: inverses(nodes), proposals: inverses(proposals), widest }
    }

    /// The densities of slopes with these squares along the two tangents, with this added to the squared roughnesses of the nodes.
    pub fn at<const L: usize>(&self, [x, y]: [f64; 2], widened: f32) -> Gaussians<L> {
        if widened == 0.0 && self.widest[0] * x + self.widest[1] * y > NOTHING {
            return Gaussians { nodes: [f32x8::ZERO; L], proposed: 0.0 };
        }
        let (x, y) = (x as f32, y as f32);
        let gaussian = |&(u, v, area): &Lanes| decay(-(u * x + v * y)) * area;
        let wider = |&(u, v, _): &Lanes| {
            let (u, v) = (u / (u * widened + 1.0), v / (v * widened + 1.0));
            (u, v, (u * v).sqrt())
        };
        let node = |lanes: &Lanes| if widened == 0.0 { gaussian(lanes) } else { gaussian(&wider(lanes)) };
        let nodes = std::array::from_fn(|l| self.nodes.get(l).map_or(f32x8::ZERO, node));
        let proposed: f32 = self.proposals.iter().map(|lanes| gaussian(lanes).reduce_add()).sum();
        Gaussians { nodes, proposed: proposed as f64 }
    }

    /// What [`Gaussians::proposed`] is in the middle of the lobes.
    pub fn most_proposed(&self) -> f64 {
        self.proposals.iter().map(|(_, _, area)| area.reduce_add()).sum::<f32>() as f64
    }
}

impl<const L: usize> Drawn<L> {
    /// No direction yet.
    pub const NONE: Self = Self { last: Gaussians { nodes: [f32x8::ZERO; L], proposed: 0.0 }, left: [f32x8::ONE; L] };

    /// Takes in one more.
    pub fn take(&mut self, densities: Gaussians<L>) {
        let over = 1.0 / densities.proposed as f32;
        self.left.iter_mut().zip(densities.nodes).for_each(|(left, node)| *left -= node * over);
        self.last = densities;
    }
}
