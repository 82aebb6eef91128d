//! The search for what one ray meets first.

use super::body::{self, Body};
use super::probe::Probe;
use super::tree::{LEAF, SINGLE};
use super::{Accel, Hit};
use crate::geometry::Ray;
use std::cell::Cell;

/// A ray under way, and what it met so far.
pub(super) struct Search<'a> {
    /// The ray.
    pub probe: Probe<'a>,
    nearest: Nearest<'a>,
}

/// The nearest candidate so far.
struct Nearest<'a> {
    accel: &'a Accel,
    /// Between which distances of the world hits count.
    range: [f64; 2],
    /// Its distance, in the tree's units.
    t: f32,
    /// By how much that may be wrong.
    blur: f32,
    /// Which triangle (block · 8 + lane), or [`SINGLE`] and which other primitive; all ones for none.
    slot: u32,
    /// Whether another one is so near that it may be in front, or the same place.
    tie: bool,
    /// Distances that differ by less are one place.
    tolerance: f32,
    /// Room for the hit, if it is on another primitive than a triangle: elsewhere, as a search is copied often and this needed rarely.
    single: &'a Cell<Option<Hit>>,
}

impl<'a> Search<'a> {
    /// The search along a ray between two distances; `None` when it misses the bounds.
    #[inline(always)]
    pub fn new(accel: &'a Accel, ray: &'a Ray, range: [f64; 2], single: &'a Cell<Option<Hit>>) -> Option<Self> {
        let probe = Probe::new(&accel.space, ray, range[0], range[1])?;
        let tolerance = (accel.tolerance * accel.space.scale) as f32;
        let nearest = Nearest { accel, range, t: f32::INFINITY, blur: 0.0, slot: u32::MAX, tie: false, tolerance, single };
        Some(Self { probe, nearest })
    }

    /// Visits all leaves that matter.
    #[inline(always)]
    pub fn run(&mut self) {
        let Self { probe, nearest } = self;
        nearest.accel.tree().walk::<true>(probe, probe.limit, |leaf, limit| nearest.visit(probe, leaf, limit));
    }

    /// Visits a leaf; the new limit of what matters.
    #[inline(always)]
    pub fn visit(&mut self, leaf: u32, limit: f32) -> f32 {
        self.nearest.visit(&self.probe, leaf, limit)
    }

    /// The first hit.
    #[inline(always)]
    pub fn finish(&self) -> Option<Hit> {
        let Self { probe, nearest } = self;
        let &Nearest { accel, range: [t_min, t_max], t, blur, slot, tie, .. } = nearest;
        if slot == u32::MAX {
            return None;
        }
        if tie {
            return accel.settle(probe.ray, t_min, t_max.min(probe.world(f64::from(t + 2.0 * blur))));
        }
        if slot & SINGLE != 0 {
            return nearest.single.get();
        }
        let detail = accel.tree().detail(slot);
        Some(accel.tree().meet(probe, slot, t, blur).hit(probe, detail, accel.surfaces[detail.surface as usize].mirrored()))
    }
}

impl Nearest<'_> {
    /// Takes the hits in a leaf that are near enough; the new limit.
    #[inline(always)]
    fn visit(&mut self, probe: &Probe, leaf: u32, limit: f32) -> f32 {
        if leaf & SINGLE != 0 { self.take_single(probe, leaf, limit) } else { self.take_triangles(probe, leaf & !LEAF, limit) }
    }

    /// Takes the triangles of a block. On its own, so that registers are left for the walk.
    #[inline(never)]
    fn take_triangles(&mut self, probe: &Probe, number: u32, mut limit: f32) -> f32 {
        let tree = self.accel.tree();
        let mut lanes = probe.test(&tree.blocks[number as usize], limit);
        while lanes.mask != 0 {
            let lane = (lanes.mask.trailing_zeros() & 7) as usize;
            lanes.mask &= lanes.mask - 1;
            let (t, blur, slot) = (lanes.t[lane], lanes.blur[lane], number << 3 | lane as u32);
            if t <= limit && probe.within(t, blur).unwrap_or_else(|| tree.within(probe, slot, [t, blur], self.range)) {
                limit = self.take(t, blur, slot);
                tree.ask(slot);
            }
        }
        limit
    }

    /// Takes the hit of a shape or instance.
    #[inline(never)]
    fn take_single(&mut self, probe: &Probe, leaf: u32, limit: f32) -> f32 {
        let ([t_min, t_max], ray) = (self.range, probe.ray);
        let (surface, body) = self.accel.body(leaf);
        let far = t_max.min(probe.world(f64::from(limit)));
        let hit = match body {
            Body::Shape(shape) => body::shape_hit(shape, ray, t_min, far, surface),
            Body::Instance(instance) => instance.nearest(ray, t_min, far, surface),
            Body::Mesh(_) => None,
        };
        let Some(t) = hit.as_ref().map(|hit| probe.local(hit.t)).filter(|&t| t <= limit) else { return limit };
        let limit = self.take(t, f32::EPSILON * (1.0 + t), leaf & !LEAF);
        if self.slot == leaf & !LEAF {
            self.single.set(hit);
        }
        limit
    }

    /// Takes a candidate nearer than the limit; the new limit.
    #[inline(always)]
    fn take(&mut self, t: f32, blur: f32, slot: u32) -> f32 {
        let blur = blur + self.tolerance;
        if t <= self.t + self.blur + blur {
            self.tie = t >= self.t - self.blur - blur;
            if t < self.t {
                (self.t, self.slot) = (t, slot);
            }
            self.blur = if self.tie { self.blur.max(blur) } else { blur };
        }
        self.t + 2.0 * self.blur
    }
}
