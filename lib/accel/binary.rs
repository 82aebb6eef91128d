//! The binary tree that the eight-wide one is made of: built by `obvhs`, laid out so that every subtree is one stretch.

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;
use rayon::prelude::*;
use std::collections::HashMap;

/// As many primitives as may have their middle in one place before they are built apart: `obvhs` takes quadratic time for them.
const CROWD: usize = 64;

/// Nodes in pre-order: the first child of an inner node is next to it, the second follows the first's subtree. Every leaf is one
/// primitive, so a subtree of n leaves has 2n − 1 nodes.
#[derive(Debug, Default)]
pub(super) struct Binary {
    /// The box of each node.
    pub boxes: Vec<Aabb>,
    /// How many leaves stand below each node; 1 for a leaf.
    pub leaves: Vec<u32>,
    /// How many leaves stand before each node.
    pub before: Vec<u32>,
    /// The primitives, in the order of the leaves.
    pub order: Vec<u32>,
}

/// Half the surface area of a box.
#[inline]
pub(super) fn half_area(b: &Aabb) -> f32 {
    let d = b.max - b.min;
    d.x * d.y + d.y * d.z + d.z * d.x
}

impl Binary {
    /// The tree over these boxes, finite and at most 2³⁰ of them.
    pub fn build(boxes: &[Aabb]) -> Self {
        let crowds = crowds(boxes);
        // Let one box stand for each crowd.
        let mut lone = vec![true; if crowds.is_empty() { 0 } else { boxes.len() }];
        crowds.iter().flatten().for_each(|&i| lone[i as usize] = false);
        let mut subjects: Vec<u32> = Vec::new();
        let joined: Vec<Aabb>;
        let mut subject_boxes = boxes;
        if !crowds.is_empty() {
            subjects = (0..boxes.len() as u32).filter(|&i| lone[i as usize]).collect();
            let unions = crowds.iter().map(|crowd| crowd.iter().fold(Aabb::empty(), |b, &i| b.union(&boxes[i as usize])));
            joined = subjects.iter().map(|&i| boxes[i as usize]).chain(unions).collect();
            subject_boxes = &joined;
        }
        let uneven: Vec<Aabb> = subject_boxes.iter().zip(0..).map(|(b, i)| uneven(b, i)).collect();
        // As `build_bvh2` of `obvhs` does it for leaves of one primitive, but for a check of its debug builds that takes a tree that is only
        // deep for a broken one.
        let BvhBuildParams { ploc_search_distance, sort_precision, search_depth_threshold, reinsertion_batch_ratio, .. } =
            BvhBuildParams::medium_build();
        let subject_numbers = (0..subject_boxes.len() as u32).collect();
        let mut built = PlocBuilder::with_capacity(subject_boxes.len()).build(
            ploc_search_distance,
            &uneven,
            subject_numbers,
            sort_precision,
            search_depth_threshold,
        );
        ReinsertionOptimizer::default().run(&mut built, reinsertion_batch_ratio, None);

        let mut out = Self::with_capacity(boxes.len());
        let mut stack = vec![0u32];
        while let Some(i) = stack.pop().filter(|_| !built.nodes.is_empty()) {
            let node = &built.nodes[i as usize];
            if !node.is_leaf() {
                out.push(Aabb::empty(), 0);
                stack.extend([node.first_index + 1, node.first_index]);
                continue;
            }
            let subject = built.primitive_indices[node.first_index as usize] as usize;
            match subject.checked_sub(subjects.len()) {
                _ if crowds.is_empty() => out.leaf(subject as u32, boxes),
                None => out.leaf(subjects[subject], boxes),
                Some(crowd) => out.halve(&crowds[crowd], boxes),
            }
        }
        out.gather();
        out
    }

    fn with_capacity(primitives: usize) -> Self {
        let nodes = (2 * primitives).saturating_sub(1);
        Self {
            boxes: Vec::with_capacity(nodes),
            leaves: Vec::with_capacity(nodes),
            before: Vec::with_capacity(nodes),
            order: Vec::with_capacity(primitives),
        }
    }

    fn push(&mut self, b: Aabb, leaves: u32) {
        self.boxes.push(b);
        self.leaves.push(leaves);
        self.before.push(self.order.len() as u32);
    }

    fn leaf(&mut self, primitive: u32, boxes: &[Aabb]) {
        self.push(boxes[primitive as usize], 1);
        self.order.push(primitive);
    }

    /// Adds a balanced subtree of these primitives in the order given.
    fn halve(&mut self, crowd: &[u32], boxes: &[Aabb]) {
        if let [one] = crowd {
            return self.leaf(*one, boxes);
        }
        self.push(Aabb::empty(), 0);
        let (left, right) = crowd.split_at(crowd.len() / 2);
        self.halve(left, boxes);
        self.halve(right, boxes);
    }

    /// Counts the leaves below each node and finds its box: children stand behind their parents.
    fn gather(&mut self) {
        for i in (0..self.leaves.len()).rev() {
            if self.leaves[i] == 0 {
                let second = self.second(i);
                self.leaves[i] = self.leaves[i + 1] + self.leaves[second];
                self.boxes[i] = self.boxes[i + 1].union(&self.boxes[second]);
            }
        }
    }

    /// The node number of the second child of an inner node.
    #[inline]
    pub fn second(&self, node: usize) -> usize {
        node + 2 * self.leaves[node + 1] as usize
    }
}

/// The box made larger by chance, by what is small beside it or hardly more than rounding. Of equal boxes in a row each would be as near to the
/// one before as to the one behind, and of all of them only two would find each other at a time.
fn uneven(b: &Aabb, number: u32) -> Aabb {
    let chance = (number.wrapping_mul(0x9e37_79b9) >> 8) as f32 / (1 << 24) as f32;
    Aabb::new(b.min, b.max + chance * ((b.max - b.min).max_element() / 32.0).min(1e-6))
}

/// The sets of more than [`CROWD`] boxes whose middles are in one cell of a 2²⁰ grid, each ordered by size.
fn crowds(boxes: &[Aabb]) -> Vec<Vec<u32>> {
    if boxes.len() <= CROWD {
        return Vec::new();
    }
    // Coordinates lie within ±½, up to rounding.
    let key = |b: &Aabb| {
        let [x, y, z] = (b.min + b.max).to_array().map(|x| ((f64::from(x) + 1.5) * f64::from(1 << 19)) as u64);
        x << 42 | y << 21 | z
    };
    // Count by hash first: nearly always no count is large, and then there is no crowd.
    let bits = boxes.len().ilog2() + 1;
    let slot = |key: u64| (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - bits)) as usize;
    let mut counts = vec![0u32; 1 << bits];
    boxes.iter().for_each(|b| counts[slot(key(b))] += 1);
    if counts.iter().all(|&n| n as usize <= CROWD) {
        return Vec::new();
    }
    let mut sets: HashMap<u64, Vec<u32>> = HashMap::new();
    for (i, b) in boxes.iter().enumerate().filter(|(_, b)| counts[slot(key(b))] as usize > CROWD) {
        sets.entry(key(b)).or_default().push(i as u32);
    }
    let mut sets: Vec<Vec<u32>> = sets.into_values().filter(|set| set.len() > CROWD).collect();
    sets.sort_unstable_by_key(|set| set[0]);
    sets.par_iter_mut().for_each(|set| set.sort_by(|&a, &b| half_area(&boxes[a as usize]).total_cmp(&half_area(&boxes[b as usize]))));
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(boxes: &[Aabb]) {
        let tree = Binary::build(boxes);
        assert_eq!(tree.boxes.len(), (2 * boxes.len()).saturating_sub(1));
        let mut order = tree.order.clone();
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..boxes.len() as u32));
        for node in 0..tree.boxes.len() {
            let below = &tree.order[tree.before[node] as usize..][..tree.leaves[node] as usize];
            let union = below.iter().fold(Aabb::empty(), |b, &i| b.union(&boxes[i as usize]));
            assert_eq!((union.min, union.max), (tree.boxes[node].min, tree.boxes[node].max));
            if tree.leaves[node] > 1 {
                assert_eq!(tree.leaves[node], tree.leaves[node + 1] + tree.leaves[tree.second(node)]);
            }
        }
    }

    fn cube(x: f32, r: f32) -> Aabb {
        Aabb::new([x - r; 3].into(), [x + r; 3].into())
    }

    #[test]
    fn subtrees_are_stretches_and_boxes_are_unions() {
        check(&[]);
        check(&[cube(0.0, 0.1)]);
        check(&(0..1000).map(|i| cube((i * 7919 % 1000) as f32 / 1000.0 - 0.5, 0.001)).collect::<Vec<_>>());
    }

    #[test]
    fn equal_boxes_in_a_row_make_a_whole_tree() {
        // In quadratic time this would be half a minute.
        check(&(0..100_000).map(|i| cube(i as f32 * 1e-5 - 0.5, 2e-6)).collect::<Vec<_>>());
    }

    #[test]
    fn crowds_are_built_apart() {
        let mut boxes: Vec<Aabb> = (0..3000).map(|i| cube(0.25, i as f32 * 1e-4)).collect();
        boxes.extend((0..100).map(|i| cube(i as f32 / 200.0, 0.001)));
        boxes.extend((0..3000).map(|_| cube(-0.25, 0.01)));
        check(&boxes);
        assert!((2..5).contains(&crowds(&boxes).len()), "one each, but for rounding between two cells");
    }
}
