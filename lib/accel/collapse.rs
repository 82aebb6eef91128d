//! From a binary tree to an eight-wide one, at the least expected cost of a ray.
//!
//! The dynamic programme of Ylitie et al. 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", section 3.1:
//! C(n, i) is the least cost of subtree n shown as at most i children of something.

use super::binary::{Binary, half_area};
use super::exact::Detail;
use super::store::{Stored, store};
use super::tree::{Block, LEAF, Node, SINGLE};
use crate::vector::Vec3;
use rayon::prelude::*;
use std::f64::consts::SQRT_2;
use wide::f32x8;

/// Cost of a visit to a node, per unit of area.
const NODE: f32 = 1.0;
/// Cost of a block of eight triangles.
const BLOCK: f32 = 0.9;
/// Cost of a primitive other than a triangle.
const OTHER: f32 = 0.9;
/// How likely a ray through the box of a primitive other than a triangle is taken to meet it: of a ball it is .52.
const FILLED: f32 = 0.5;
/// By how much the boxes are larger than what is in them: more than what rounding moves a ray within the tree's cube. The origin, the bounds
/// and the corners are rounded at magnitudes up to ½, the direction at distances below √3; a few roundings each make a bound and a
/// triangle's edge (after Ize 2013, "Robust BVH Ray Traversal", whose error grows with the distance instead).
const MARGIN: f32 = 16.0 * f32::EPSILON;
/// Subtrees smaller than this are not worth a thread.
const SEQUENTIAL: usize = 1 << 14;

/// The solution for one subtree.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// `cost[i - 1]` is C(n, i) for i = 1..=7.
    cost: [f32; 7],
    /// `split[i - 1]`, i = 1..=8: how many of at most i places go to the first child; 0 to use fewer places. At i = 8: for the places of a
    /// node of its own.
    split: [u8; 8],
    /// Shown in one place: a leaf rather than a node.
    leaf: bool,
    /// Whether there are only triangles below.
    triangles: bool,
    /// The area of all triangles below, of what is none [`FILLED`] of half that of its box, and at most half that of the box: what part of that it is,
    /// is how likely a ray through the box is to meet one, if they do not hide each other (Cauchy: what is convex is met in proportion to its surface).
    surface: f32,
}

/// The wide tree of `binary`, over primitives that are a surface, or a triangle of one. `corners` gives a triangle's, in the tree's
/// coordinates; `None` for what is no triangle.
pub(super) fn collapse(binary: &Binary, primitives: &[(u32, u32)], corners: impl Fn(u32) -> Option<[Vec3; 3]> + Sync) -> Stored {
    let detail = |&primitive: &u32| {
        let (surface, triangle) = primitives[primitive as usize];
        let residue = corners(primitive).map_or([[0.0; 3]; 3], |c| c.map(|p| p.to_array().map(|x| (x - f64::from(x as f32)) as f32)));
        Detail { surface, triangle, residue }
    };
    let triangle_area = |primitive: u32| corners(primitive).map(|[a, b, c]| ((b - a).cross(c - a).length() / 2.0) as f32);
    let mut plans = vec![Plan::default(); binary.boxes.len()];
    solve(binary, 0, &mut plans, &triangle_area, 0);
    let (mut nodes, mut leaves) = (Vec::new(), Vec::new());
    // Number a child: a primitive, a block, or a node that is filled later.
    let mut number = |i: usize, nodes: &mut Vec<Node>, todo: &mut Vec<(usize, usize)>| {
        if !plans[i].leaf {
            let [low, high] = [f32::INFINITY, f32::NEG_INFINITY].map(f32x8::splat);
            nodes.push(Node { bounds: [low, high, low, high, low, high], child: [LEAF; 8], rest: [0; 8] });
            todo.push((i, nodes.len() - 1));
            return nodes.len() as u32 - 1;
        }
        if !plans[i].triangles {
            return LEAF | SINGLE | binary.before[i];
        }
        leaves.push((binary.before[i], binary.leaves[i]));
        LEAF | (leaves.len() as u32 - 1)
    };
    let mut todo = Vec::new();
    let root = (!plans.is_empty()).then(|| number(0, &mut nodes, &mut todo));
    let mut children = Vec::with_capacity(8);
    while let Some((i, slot)) = todo.pop() {
        children.clear();
        gather(binary, &plans, i, &mut children);
        // Where any hit will do, those first that are likeliest to have one for what a visit costs (both times half the area of the box).
        let promise = |child: usize| plans[child].surface / plans[child].cost[0];
        children.sort_by(|&a, &b| promise(b).total_cmp(&promise(a)));
        nodes[slot].bounds = std::array::from_fn(|row| {
            let side = |child: &usize| match (&binary.boxes[*child], row / 2) {
                (b, axis) if row % 2 == 0 => b.min[axis] - MARGIN,
                (b, axis) => b.max[axis] + MARGIN,
            };
            f32x8::new(std::array::from_fn(|lane| children.get(lane).map_or([f32::INFINITY, f32::NEG_INFINITY][row % 2], side)))
        });
        let begin = todo.len();
        for (lane, &child) in children.iter().enumerate() {
            let child = number(child, &mut nodes, &mut todo);
            nodes[slot].child[lane] = child;
        }
        todo[begin..].reverse();
    }
    let block = |&(first, count): &(u32, u32)| {
        let mut rows = [[[f32::NAN; 8]; 3]; 3];
        let mut longest = 0.0f64;
        for lane in 0..count as usize {
            let Some(triangle) = corners(binary.order[first as usize + lane]) else { continue };
            for vertex in 0..3 {
                longest = longest.max((triangle[(vertex + 1) % 3] - triangle[vertex]).length());
                for axis in 0..3 {
                    rows[vertex][axis][lane] = triangle[vertex][axis] as f32;
                }
            }
        }
        Block { corners: rows.map(|vertex| vertex.map(f32x8::new)), first, width: (SQRT_2 * longest) as f32, rest: [0; 6] }
    };
    let blocks = leaves.par_iter().with_min_len(64).map(block);
    store(nodes, blocks, binary.order.par_iter().with_min_len(4096).map(detail), root)
}

/// Fills the plans of the subtree at `root`, whose plans these are, children before parents.
fn solve(binary: &Binary, root: usize, plans: &mut [Plan], triangle_area: &(impl Fn(u32) -> Option<f32> + Sync), depth: u32) {
    let mut start = 0;
    if plans.len() > SEQUENTIAL && depth < 16 {
        let (first, second) = plans[1..].split_at_mut(2 * binary.leaves[root + 1] as usize - 1);
        let at = binary.second(root);
        rayon::join(|| solve(binary, root + 1, first, triangle_area, depth + 1), || solve(binary, at, second, triangle_area, depth + 1));
        start = plans.len() - 1;
    }
    for i in (0..plans.len() - start).rev() {
        let node = root + i;
        let area = half_area(&binary.boxes[node]);
        let count = binary.leaves[node];
        if count == 1 {
            let own = triangle_area(binary.order[binary.before[node] as usize]);
            let (triangles, surface) = (own.is_some(), own.unwrap_or(area * FILLED));
            let cost = area * if triangles { BLOCK } else { OTHER };
            plans[i] = Plan { cost: [cost; 7], split: [0; 8], leaf: true, triangles, surface };
            continue;
        }
        let (a, b) = (plans[i + 1], plans[i + 2 * binary.leaves[node + 1] as usize]);
        let mut plan = Plan { triangles: a.triangles && b.triangles, surface: (a.surface + b.surface).min(area), ..Plan::default() };
        let mut shared = [f32::INFINITY; 8];
        for i in 2..=8 {
            for k in 1..i {
                let cost = a.cost[k - 1] + b.cost[i - k - 1];
                if cost < shared[i - 1] {
                    shared[i - 1] = cost;
                    plan.split[i - 1] = k as u8;
                }
            }
        }
        let as_node = shared[7] + area * NODE;
        let as_leaf = if plan.triangles && count <= 8 { area * BLOCK } else { f32::INFINITY };
        plan.leaf = as_leaf <= as_node;
        plan.cost[0] = as_leaf.min(as_node);
        for i in 2..=7 {
            plan.cost[i - 1] = shared[i - 1].min(plan.cost[i - 2]);
            if plan.cost[i - 2] <= shared[i - 1] {
                plan.split[i - 1] = 0;
            }
        }
        plans[i] = plan;
    }
}

/// The children of the node that subtree `i` becomes.
fn gather(binary: &Binary, plans: &[Plan], i: usize, children: &mut Vec<usize>) {
    let first = plans[i].split[7] as usize;
    show(binary, plans, i + 1, first, children);
    show(binary, plans, binary.second(i), 8 - first, children);
}

/// Shows subtree `i` in at most `places` places.
fn show(binary: &Binary, plans: &[Plan], i: usize, mut places: usize, children: &mut Vec<usize>) {
    let plan = &plans[i];
    places = places.min(7);
    while places > 1 && plan.split[places - 1] == 0 {
        places -= 1;
    }
    if places == 1 {
        return children.push(i);
    }
    let first = plan.split[places - 1] as usize;
    show(binary, plans, i + 1, first, children);
    show(binary, plans, binary.second(i), places - first, children);
}
