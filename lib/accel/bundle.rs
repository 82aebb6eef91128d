//! Rays beside one another: one walk through the tree for all of a bundle.
//!
//! What all of them miss is found out for eight boxes at a time, by the beam that they are within (Wald et al. 2006, "Ray Tracing Animated
//! Scenes using Coherent Grid Traversal"); only in front of a leaf is each asked by itself whether it meets the leaf's box.

use super::search::Search;
use super::tree::{LEAF, Node, Tree, passage};
use crate::vector::across;
use wide::{f32x4, f32x8};

/// The most rays of a bundle.
pub(super) const WIDTH: usize = 16;

/// The fewest: two are as quick by themselves.
const FEWEST: usize = 3;

/// By how much a beam is wider than its rays, for what is rounded: some steps at magnitudes up to 2.
const MARGIN: f32 = 16.0 * f32::EPSILON;

/// A number for each ray.
type Each = [f32x8; WIDTH / 8];

/// Runs searches, together if they go the same way; whether they do.
pub(super) fn run(tree: &Tree, searches: &mut [Option<Search>; WIDTH]) -> bool {
    let mut ways = searches.iter().flatten().map(|search| (search.probe.axis, search.probe.signs));
    let together = ways.next().is_none_or(|first| ways.all(|way| way == first));
    match if together { Bundle::new(tree, searches) } else { None } {
        Some(mut bundle) => bundle.walk(tree, searches),
        None => searches.iter_mut().flatten().for_each(Search::run),
    }
    together
}

/// Rays whose directions are longest along the same axis, and whose directions' components have the same signs.
struct Bundle {
    beam: Beam,
    /// [`Probe::inverse`] and [`Probe::shift`].
    inverse: [Each; 3],
    shift: [Each; 3],
    /// How far each ray matters; negative where there is none.
    limits: Each,
    /// The beam's depth where each starts, and how much deeper it is for each length of a ray.
    starts: Each,
    rates: Each,
    /// [`Probe::far_rows`].
    far_rows: [usize; 3],
}

/// What rays are within. Its depth is measured along the axis that they are longest along, from where the first of them starts.
struct Beam {
    /// That axis.
    axis: usize,
    /// 1 if they go up along it, −1 if down.
    sign: f32,
    /// The coordinate along it, times the sign, where the depth is 0.
    start: f32,
    /// The least coordinates at depth 0, and the greatest.
    from: [f32x4; 2],
    /// How much these grow with the depth: the least slopes, and the greatest.
    slopes: [f32x4; 2],
}

impl Bundle {
    /// The bundle of some rays that go the same way; `None` if it is not worth while.
    #[inline(never)]
    fn new(tree: &Tree, searches: &[Option<Search>; WIDTH]) -> Option<Self> {
        let probes = || searches.iter().enumerate().filter_map(|(n, search)| Some((n, &search.as_ref()?.probe)));
        let first = probes().next()?.1;
        if tree.root.is_none_or(|root| root & LEAF != 0) {
            return None;
        }
        let axis = first.axis;
        let sign = first.depth.signum();
        let mut rows = [[0.0; WIDTH]; 6];
        let (mut limits, mut starts, mut depths) = ([-1.0; WIDTH], [0.0; WIDTH], [1.0; WIDTH]);
        let mut start = f32::INFINITY;
        let mut count = 0;
        for (n, probe) in probes() {
            count += 1;
            let (inverse, shift) = (probe.inverse.to_array(), probe.shift.to_array());
            for axis in 0..3 {
                (rows[axis][n], rows[3 + axis][n]) = (inverse[axis], shift[axis]);
            }
            (limits[n], depths[n]) = (probe.limit, probe.depth);
            starts[n] = probe.origin.as_array()[axis & 3] * sign;
            start = start.min(starts[n]);
        }
        if count < FEWEST {
            return None;
        }
        let none = [f32x4::splat(f32::INFINITY), f32x4::splat(f32::NEG_INFINITY)];
        let (mut from, mut slopes) = (none, none);
        let join = |[least, most]: [f32x4; 2], value| [least.fast_min(value), most.fast_max(value)];
        for (n, probe) in probes() {
            starts[n] -= start;
            let slope = probe.shear * f32x4::splat(sign);
            slopes = join(slopes, slope);
            from = join(from, slope.mul_neg_add(f32x4::splat(starts[n]), probe.origin));
        }
        let beam =
            Beam { axis, sign, start: start - MARGIN, from: [from[0] - f32x4::splat(MARGIN), from[1] + f32x4::splat(MARGIN)], slopes };
        let [a, b, c, d, e, f] = rows;
        let depths = each(depths);
        Some(Self {
            beam,
            inverse: [each(a), each(b), each(c)],
            shift: [each(d), each(e), each(f)],
            limits: each(limits),
            starts: each(starts),
            rates: [f32x8::ONE / depths[0].abs(), f32x8::ONE / depths[1].abs()],
            far_rows: first.far_rows(),
        })
    }

    /// The depth from which on nothing matters to any ray.
    #[inline(always)]
    fn reach(&self) -> f32 {
        let of = |half: usize| self.limits[half].mul_add(self.rates[half], self.starts[half]);
        let [a, b, c, d, e, f, g, h] = of(0).fast_max(of(1)).to_array();
        a.max(b).max(c.max(d)).max(e.max(f).max(g.max(h))) + MARGIN
    }

    /// Which rays pass a box of a node before their limits: a bit for each.
    #[inline(always)]
    fn passing(&self, node: &Node, lane: usize) -> u32 {
        let plane = |row: usize| f32x8::splat(node.bounds[row].as_array()[lane]);
        let [x, y, z] = self.far_rows;
        let (near, far) = ([plane(x ^ 1), plane(y ^ 1), plane(z ^ 1)], [plane(x), plane(y), plane(z)]);
        let pass = |half: usize| {
            let of = |each: &[Each; 3]| [each[0][half], each[1][half], each[2][half]];
            passage(near, far, of(&self.inverse), of(&self.shift), self.limits[half]).1
        };
        pass(0) | pass(1) << 8
    }

    /// Visits with each ray the leaves that matter to it.
    fn walk(&mut self, tree: &Tree, searches: &mut [Option<Search>; WIDTH]) {
        // Depths, and of which node which child.
        let mut stack: Vec<(f32, u32)> = Vec::with_capacity(64);
        let mut reach = self.reach();
        let mut current = tree.root;
        loop {
            if let Some(number) = current {
                let (depths, mut mask) = self.beam.meets(&tree.nodes[number as usize], reach);
                let base = stack.len();
                // The nearest last.
                while mask != 0 {
                    let lane = mask.trailing_zeros() & 7;
                    mask &= mask - 1;
                    let entry = (depths[lane as usize], number << 3 | lane);
                    let mut place = stack.len();
                    stack.push(entry);
                    while place > base && stack[place - 1].0 < entry.0 {
                        stack[place] = stack[place - 1];
                        place -= 1;
                    }
                    stack[place] = entry;
                }
            }
            let Some((depth, at)) = stack.pop() else { return };
            current = None;
            if depth > reach {
                continue;
            }
            let (node, lane) = (&tree.nodes[(at >> 3) as usize], (at & 7) as usize);
            let child = node.child[lane];
            if child & LEAF == 0 {
                current = Some(child);
                continue;
            }
            let mut passing = self.passing(node, lane);
            if passing == 0 {
                continue;
            }
            while passing != 0 {
                let n = passing.trailing_zeros() as usize % WIDTH;
                passing &= passing - 1;
                if let Some(search) = &mut searches[n] {
                    let limit = &mut self.limits[n / 8].as_mut_array()[n % 8];
                    *limit = search.visit(child, *limit);
                }
            }
            reach = self.reach();
        }
    }
}

impl Beam {
    /// Which boxes of a node the beam meets before a depth, a bit for each, and at what depths they begin.
    #[inline(always)]
    fn meets(&self, node: &Node, reach: f32) -> ([f32; 8], u32) {
        let far_row = 2 * self.axis + usize::from(self.sign > 0.0);
        let depth = |row: usize| node.bounds[row].mul_add(f32x8::splat(self.sign), f32x8::splat(-self.start));
        let near = depth(far_row ^ 1).fast_max(f32x8::ZERO);
        let far = depth(far_row).fast_min(f32x8::splat(reach));
        let mut met = near.simd_le(far);
        let [least, most] = self.slopes;
        for axis in across(self.axis) {
            let pick = |v: f32x4| f32x8::splat(v.as_array()[axis & 3]);
            // Where a side leans in, the beam is widest at the near end of the box.
            let side =
                |from: f32x4, near_slope: f32x4, far_slope: f32x4| pick(far_slope).mul_add(far, pick(near_slope).mul_add(near, pick(from)));
            let low = side(self.from[0], least.fast_max(f32x4::ZERO), least.fast_min(f32x4::ZERO));
            let high = side(self.from[1], most.fast_min(f32x4::ZERO), most.fast_max(f32x4::ZERO));
            met = met & low.simd_le(node.bounds[2 * axis + 1]) & high.simd_ge(node.bounds[2 * axis]);
        }
        (near.to_array(), met.to_bitmask())
    }
}

/// A number for each ray, in lanes.
#[inline(always)]
fn each(numbers: [f32; WIDTH]) -> Each {
    let [a, b] = numbers.as_chunks().0 else { unreachable!() };
    [f32x8::new(*a), f32x8::new(*b)]
}
