//! The eight-wide tree itself: nodes, leaf blocks of eight triangles, and the walk along a ray.
//!
//! Everything in it is single precision, in a cube of size one round the origin; see [`Space`].

use super::exact::Detail;
use super::probe::{LEAD, Probe};
use crate::geometry::Bounds;
use crate::vector::Vec3;
use bytemuck::{Pod, Zeroable, cast};
use wide::{f32x4, f32x8, f64x4, i32x8};
use yoke::Yokeable;

/// Set in a child that is not a node.
pub(super) const LEAF: u32 = 1 << 31;
/// Set, with [`LEAF`], in a child that is one primitive other than a triangle; the rest is its number in the order of the leaves. Without it, the
/// rest of a leaf is the number of its block of triangles.
pub(super) const SINGLE: u32 = 1 << 30;

/// The cube of size one that the tree lives in: `local = (world − center) · scale`, the scale a power of two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    /// The middle of the bounds.
    pub center: Vec3,
    /// A power of two.
    pub scale: f64,
    /// One over `scale`.
    pub unit: f64,
    /// How far before its range a probe starts, in the world.
    pub lead: f64,
    /// The world bounds of all there is.
    pub bounds: Bounds,
    /// Smallest coordinates of those bounds, a little grown, and −∞.
    pub low: f64x4,
    /// Largest coordinates, and ∞.
    pub high: f64x4,
}

impl Space {
    /// The space for what these bounds hold.
    pub fn new(bounds: Bounds) -> Self {
        let exponent = if bounds.is_empty() { 0.0 } else { bounds.size().log2().ceil().clamp(-900.0, 900.0) };
        let center = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
        let unit = exponent.exp2();
        let lead = f64::from(LEAD) * unit;
        let grown = bounds.grow(lead);
        let (low, high) = (four(grown.min, f64::NEG_INFINITY), four(grown.max, f64::INFINITY));
        Self { center, scale: (-exponent).exp2(), unit, lead, bounds, low, high }
    }

    /// A world point in the tree's own coordinates.
    #[inline]
    pub fn local(&self, p: Vec3) -> Vec3 {
        (p - self.center) * self.scale
    }
}

/// A point in lanes, and a number beside it.
#[inline(always)]
pub(super) fn four(p: Vec3, rest: f64) -> f64x4 {
    f64x4::new([p.x, p.y, p.z, rest])
}

/// A point in single precision.
#[inline(always)]
pub(super) fn single(p: Vec3) -> [f32; 3] {
    [p.x as f32, p.y as f32, p.z as f32]
}

/// Eight times each coordinate of a point. (Written out: mapped, it is a call, which every ray would wait for.)
#[inline(always)]
fn spread(p: f32x4) -> [f32x8; 3] {
    let [x, y, z, _] = p.to_array();
    [f32x8::splat(x), f32x8::splat(y), f32x8::splat(z)]
}

/// Where rays enter boxes, and which leave them behind that and before a limit: eight pairs of a ray, by its inverse and shift, and a box, by
/// the planes that the ray comes to first and last. What is rounded here and in the triangle test, the boxes have a margin for.
///
/// The bits of floating-point numbers are in the order of the numbers where those are not negative, and below all those where they are: that is
/// enough here, and whole numbers are compared in one cycle, not four, for which all that follows would wait.
#[inline(always)]
pub(super) fn passage(near: [f32x8; 3], far: [f32x8; 3], inverse: [f32x8; 3], shift: [f32x8; 3], limit: f32x8) -> (f32x8, u32) {
    let ([x, y, z], [to_x, to_y, to_z]) = (near, far);
    let at = |plane: f32x8, axis: usize| cast::<f32x8, i32x8>(plane.mul_add(inverse[axis], shift[axis]));
    let enter = at(x, 0).max(at(y, 1)).max(at(z, 2).max(i32x8::ZERO));
    let leave = at(to_x, 0).min(at(to_y, 1)).min(at(to_z, 2).min(cast(limit)));
    (cast(enter), leave.simd_gt(enter).to_bitmask())
}

/// Eight boxes and what is in them.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Smallest and largest coordinates along the first axis, the second, the third. An empty slot has +∞, −∞.
    pub bounds: [f32x8; 6],
    /// Node numbers, or [`LEAF`]s.
    pub child: [u32; 8],
    /// To fill whole lines of the cache.
    pub rest: [u32; 8],
}

/// Up to eight triangles.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// Per vertex and axis. Unused lanes are NaN, which no test accepts.
    pub corners: [[f32x8; 3]; 3],
    /// The number, in the order of the leaves, of the first.
    pub first: u32,
    /// What a side of a triangle is at most long when sheared: √2 times the longest.
    pub width: f32,
    /// To fill whole lines of the cache.
    pub rest: [u32; 6],
}

/// The whole tree.
#[derive(Clone, Copy, Debug, Yokeable)]
pub(super) struct Tree<'a> {
    /// Inner nodes.
    pub nodes: &'a [Node],
    /// Triangles.
    pub blocks: &'a [Block],
    /// All primitives, in the order of the leaves.
    pub details: &'a [Detail],
    /// Node 0, a leaf, or `None` when there is nothing.
    pub root: Option<u32>,
}

/// Entries of the stack that need no allocation.
const STACK: usize = 32;

impl Tree<'_> {
    /// Visits the leaves whose boxes the probe passes before `limit`, near ones first if `ORDERED`, else the first children first. `leaf` gets
    /// the leaf's number and the limit and returns the new limit, which only counts if `ORDERED`; a negative one ends the walk.
    #[inline(always)]
    pub fn walk<const ORDERED: bool>(&self, probe: &Probe, mut limit: f32, mut leaf: impl FnMut(u32, f32) -> f32) {
        let Some(root) = self.root else { return };
        let mut stack = [0u64; STACK];
        let mut spilled: Vec<u64> = Vec::new();
        stack[0] = u64::from(root);
        let mut top = 1;
        let (inverse, shift) = (spread(probe.inverse), spread(probe.shift));
        let far_rows = probe.far_rows();
        let near_rows = far_rows.map(|row| row ^ 1);
        let rest = |mask: u32| mask & mask.wrapping_sub(1);
        'next: loop {
            if top == 0 {
                if spilled.is_empty() {
                    return;
                }
                let rest = spilled.len().saturating_sub(STACK / 2);
                top = spilled.len() - rest;
                stack[..top].copy_from_slice(&spilled[rest..]);
                spilled.truncate(rest);
            }
            top -= 1;
            let entry = stack[top % STACK];
            if f32::from_bits((entry >> 32) as u32) > limit {
                continue;
            }
            let mut current = entry as u32;
            let far_most = f32x8::splat(limit);
            while current & LEAF == 0 {
                let node = &self.nodes[current as usize];
                let planes = |[x, y, z]: [usize; 3]| [node.bounds[x], node.bounds[y], node.bounds[z]];
                let (near, first_of) = passage(planes(near_rows), planes(far_rows), inverse, shift, far_most);
                if first_of == 0 {
                    continue 'next;
                }
                let second_of = rest(first_of);
                if second_of == 0 {
                    current = node.child[(first_of.trailing_zeros() & 7) as usize];
                    continue;
                }
                if top > STACK - 8 {
                    spilled.extend_from_slice(&stack[..top]);
                    top = 0;
                }
                if !ORDERED {
                    let mut more = first_of;
                    while more != 0 {
                        // The last first: it is visited last.
                        let lane = more.ilog2() & 7;
                        stack[top % STACK] = u64::from(node.child[lane as usize]);
                        top += 1;
                        more ^= 1 << lane;
                    }
                    top -= 1;
                    current = stack[top % STACK] as u32;
                    continue;
                }
                // Go on with the nearest child and stack the others, the farthest first. Two or three are placed without branches, an
                // absent one being farther than any.
                let near = near.to_array();
                let entry = |mask: u32| {
                    let lane = (mask.trailing_zeros() & 7) as usize;
                    u64::from(near[lane].to_bits()) << 32 | u64::from(node.child[lane])
                };
                let third_of = rest(second_of);
                let mut more = rest(third_of);
                let absent = u64::from(third_of == 0).wrapping_neg();
                let (a, b, c) = (entry(first_of), entry(second_of), entry(third_of) | absent);
                let (a, b) = (a.min(b), a.max(b));
                let (b, c) = (b.min(c), b.max(c));
                let (mut a, b) = (a.min(b), a.max(b));
                let base = top;
                stack[top % STACK] = c;
                top += usize::from(third_of != 0);
                stack[top % STACK] = b;
                top += 1;
                while more != 0 {
                    let d = entry(more);
                    more = rest(more);
                    let next = a.max(d);
                    a = a.min(d);
                    let mut place = top;
                    while place > base && stack[(place - 1) % STACK] < next {
                        stack[place % STACK] = stack[(place - 1) % STACK];
                        place -= 1;
                    }
                    stack[place % STACK] = next;
                    top += 1;
                }
                current = a as u32;
            }
            limit = leaf(current, limit);
            if limit < 0.0 {
                return;
            }
        }
    }

    /// How much memory it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes) + size_of_val(self.blocks) + size_of_val(self.details)
    }
}
