//! Where a ray first meets the scene: an eight-wide hierarchy over an `obvhs` build.
//!
//! Single precision lives only inside the hierarchy, where it finds candidates; every answer is computed in `f64`. The triangle test is
//! watertight. Hits are two-sided, at distances strictly between `t_min` and `t_max`; the caller keeps a secondary ray off its own
//! surface by `t_min`.

mod binary;
mod body;
mod build;
mod collapse;
mod probe;
mod tree;

use crate::geometry::{Bounds, LEVELS, Mesh, Ray, Shape};
use crate::vector::{Affine, Vec3};
use body::Body;
use probe::Probe;
use std::sync::Arc;
use tree::{SINGLE, Space, Tree};

/// What a tree is built over.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// One surface.
    Shape(Shape),
    /// A mesh, moved by a similarity. One that is used several times is kept once.
    Mesh(Arc<Mesh>, Affine),
    /// Another tree, moved by a similarity.
    Group(Arc<Accel>, Affine),
}

/// Who is seen where surfaces coincide: the greatest of these, in the order of the fields, but whether the front is seen decides between
/// `class` and `order`; equal ones leave it to the later surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rank {
    /// RADIANCE's: 0 no material, 1 a transparent one, 2 an opaque one.
    pub class: u8,
    /// Grows with the place where the modifier is defined.
    pub order: u32,
}

/// One surface of the scene and its rank against coincident ones.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Where it is.
    pub geometry: Geometry,
    /// Of a shape: one. Of a mesh: one for each of its materials. Of a group: none (what is in it has its own), or one for all of it.
    /// Missing ones are the default; the last one stands for those after it.
    pub ranks: Vec<Rank>,
}

impl From<Geometry> for Surface {
    fn from(geometry: Geometry) -> Self {
        Self { geometry, ranks: Vec::new() }
    }
}

/// Surfaces made ready for rays. Numbers of surfaces are places in the list it was built from.
#[derive(Clone, Debug)]
pub struct Accel {
    tree: Tree,
    space: Space,
    /// Surface and triangle of each primitive of the tree.
    primitives: Vec<(u32, u32)>,
    surfaces: Vec<Body>,
    ranks: Vec<Vec<Rank>>,
    /// Distances that differ by less are one place.
    tolerance: f64,
    dropped: usize,
    depth: usize,
}

/// The surfaces inside groups that lead to a hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Path {
    numbers: [u32; LEVELS],
    length: u8,
}

impl Path {
    /// The number of the surface hit inside each group, from the outermost group in; empty for a hit outside groups.
    pub fn surfaces(&self) -> &[u32] {
        &self.numbers[..self.length as usize]
    }

    /// The path one level further out.
    fn within(&self, surface: u32) -> Self {
        let mut numbers = [surface; LEVELS];
        numbers[1..].copy_from_slice(&self.numbers[..LEVELS - 1]);
        Self { numbers, length: (self.length + 1).min(LEVELS as u8) }
    }
}

/// Where a ray met a surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray.
    pub t: f64,
    /// The point, on the surface as exactly as `f64` allows.
    pub point: Vec3,
    /// Geometric normal: unit, on the front, whichever side was hit.
    pub normal: Vec3,
    /// Which surface of the list; for a hit inside a group, the group.
    pub surface: u32,
    /// Inside groups: which surface of theirs.
    pub path: Path,
    /// Which triangle of a mesh; 0 for a shape.
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex; 0 for a shape.
    pub barycentric: [f64; 2],
}

/// The nearest candidate so far.
struct Nearest {
    /// Its distance, in the tree's units.
    t: f32,
    /// By how much that may be wrong.
    blur: f32,
    primitive: u32,
    /// Whether another one is so near that it may be in front, or the same place.
    tie: bool,
    /// Distances that differ by less are one place.
    tolerance: f32,
    /// The hit, where it is known already.
    hit: Option<Hit>,
}

impl Nearest {
    /// Takes a candidate nearer than the limit; the new limit.
    #[inline(always)]
    fn take(&mut self, t: f32, blur: f32, primitive: u32) -> f32 {
        let blur = blur + self.tolerance;
        if t <= self.t + self.blur + blur {
            self.tie = t >= self.t - self.blur - blur;
            if t < self.t {
                (self.t, self.primitive) = (t, primitive);
            }
            self.blur = if self.tie { self.blur.max(blur) } else { blur };
        }
        self.t + 2.0 * self.blur
    }
}

impl Accel {
    /// The first surface met at a distance between `t_min` and `t_max` (both excluded). Of surfaces less than 1e-6 apart along the ray (in
    /// scenes of ordinary size) the one of greatest [`Rank`] is first.
    pub fn nearest(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<Hit> {
        let probe = Probe::new(&self.space, ray, t_min, t_max)?;
        let tolerance = (self.tolerance * self.space.scale) as f32;
        let mut best = Nearest { t: f32::INFINITY, blur: 0.0, primitive: u32::MAX, tie: false, tolerance, hit: None };
        self.tree.walk::<true>(&probe, probe.limit, |leaf, mut limit| {
            if leaf & SINGLE != 0 {
                let primitive = leaf & (SINGLE - 1);
                let far = t_max.min(probe.distance(limit));
                let (surface, body) = self.body(primitive);
                let inner = body.instance().and_then(|instance| instance.nearest(ray, t_min, far, surface));
                let t = inner.as_ref().map(|hit| hit.t).or_else(|| body.shape()?.intersect(ray, t_min, far));
                if let Some(t) = t.map(|t| probe.local(t)).filter(|&t| t <= limit) {
                    limit = best.take(t, f32::EPSILON * (1.0 + t), primitive);
                    if best.primitive == primitive {
                        best.hit = inner;
                    }
                }
                return limit;
            }
            for block in self.tree.blocks_of(leaf) {
                let mut lanes = probe.test(block, limit);
                while lanes.mask != 0 {
                    let lane = (lanes.mask.trailing_zeros() & 7) as usize;
                    lanes.mask &= lanes.mask - 1;
                    let (t, blur, primitive) = (lanes.t[lane], lanes.blur[lane], block.primitives[lane]);
                    if t <= limit && (probe.sure(t, blur) || self.within(primitive, ray, probe.distance(t), t_min, t_max)) {
                        limit = best.take(t, blur, primitive);
                    }
                }
            }
            limit
        });
        if best.primitive == u32::MAX {
            return None;
        }
        if best.tie {
            return self.settle(ray, t_min, t_max.min(probe.distance(best.t + 2.0 * best.blur)));
        }
        let (surface, triangle) = self.primitives[best.primitive as usize];
        match &self.surfaces[surface as usize] {
            Body::Shape(shape) => body::shape_hit(shape, ray, t_min, t_max, surface),
            Body::Mesh(placed) => Some(placed.hit(ray, probe.distance(best.t), surface, triangle)),
            Body::Instance(_) => best.hit,
        }
    }

    /// Whether any surface is met at a distance between `t_min` and `t_max` (both excluded).
    pub fn occluded(&self, ray: &Ray, t_min: f64, t_max: f64) -> bool {
        let Some(probe) = Probe::new(&self.space, ray, t_min, t_max) else { return false };
        let mut found = false;
        self.tree.walk::<false>(&probe, probe.limit, |leaf, limit| {
            found = if leaf & SINGLE != 0 {
                self.body(leaf & (SINGLE - 1)).1.occludes(ray, t_min, t_max)
            } else {
                self.tree.blocks_of(leaf).iter().any(|block| {
                    let lanes = probe.test(block, limit);
                    (0..8).filter(|lane| lanes.mask >> lane & 1 == 1).any(|lane| {
                        let (t, blur) = (lanes.t[lane], lanes.blur[lane]);
                        probe.sure(t, blur) || self.within(block.primitives[lane], ray, probe.distance(t), t_min, t_max)
                    })
                })
            };
            if found { -1.0 } else { limit }
        });
        found
    }

    /// Every hit at a distance between `t_min` and `t_max` (both excluded), in no particular order, with the rank it has among coincident ones.
    pub fn each(&self, ray: &Ray, t_min: f64, t_max: f64, visit: &mut dyn FnMut(Hit, Rank)) {
        let Some(probe) = Probe::new(&self.space, ray, t_min, t_max) else { return };
        self.tree.walk::<false>(&probe, probe.limit, |leaf, limit| {
            if leaf & SINGLE != 0 {
                let (surface, body) = self.body(leaf & (SINGLE - 1));
                body.each(ray, t_min, t_max, surface, &self.ranks[surface as usize], visit);
                return limit;
            }
            for block in self.tree.blocks_of(leaf) {
                let lanes = probe.test(block, limit);
                for lane in (0..8).filter(|lane| lanes.mask >> lane & 1 == 1) {
                    let (surface, triangle) = self.primitives[block.primitives[lane] as usize];
                    let Body::Mesh(placed) = &self.surfaces[surface as usize] else { continue };
                    let hit = placed.hit(ray, probe.distance(lanes.t[lane]), surface, triangle);
                    if hit.t > t_min && hit.t < t_max {
                        visit(hit, placed.rank(&self.ranks[surface as usize], triangle));
                    }
                }
            }
            limit
        });
    }

    /// The world box round all there is.
    pub fn bounds(&self) -> Bounds {
        self.space.bounds
    }

    /// How many triangles were left out: with corners that are not finite numbers below 1e100, or without area.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// The nearest hit where several are near each other: all decisions in double precision.
    #[cold]
    fn settle(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<Hit> {
        let mut first = f64::INFINITY;
        self.each(ray, t_min, t_max, &mut |hit, _| first = first.min(hit.t));
        let mut best: Option<(Hit, _)> = None;
        self.each(ray, t_min, t_max, &mut |hit, rank| {
            let key = (rank.class, ray.direction.dot(hit.normal) < 0.0, rank.order, hit.surface, hit.path.numbers, u32::MAX - hit.triangle);
            if hit.t - first <= self.tolerance && best.as_ref().is_none_or(|(_, other)| key > *other) {
                best = Some((hit, key));
            }
        });
        best.map(|(hit, _)| hit)
    }

    /// The surface a primitive is of or on.
    fn body(&self, primitive: u32) -> (u32, &Body) {
        let (surface, _) = self.primitives[primitive as usize];
        (surface, &self.surfaces[surface as usize])
    }

    /// Whether a candidate's exact distance is in the range.
    #[inline(never)]
    fn within(&self, primitive: u32, ray: &Ray, t: f64, t_min: f64, t_max: f64) -> bool {
        let (surface, triangle) = self.primitives[primitive as usize];
        let Body::Mesh(placed) = &self.surfaces[surface as usize] else { return false };
        let hit = placed.hit(ray, t, surface, triangle);
        hit.t > t_min && hit.t < t_max
    }
}

#[cfg(test)]
mod tests;
