//! Where a ray first meets the scene: an eight-wide hierarchy over an `obvhs` build.
//!
//! Single precision lives only inside the hierarchy, where it finds candidates; every answer is computed in `f64`. The triangle test is
//! watertight. Hits are two-sided, at distances strictly between `t_min` and `t_max`; the caller keeps a secondary ray off its own
//! surface by `t_min`.

mod binary;
mod body;
mod build;
mod bundle;
mod collapse;
mod exact;
mod probe;
mod search;
mod store;
mod tree;

use crate::geometry::{Bounds, LEVELS, Mesh, Ray, Shape};
use crate::vector::{Affine, Vec3};
use body::Body;
use bundle::WIDTH;
use probe::Probe;
use search::Search;
use std::cell::Cell;
use std::sync::Arc;
use store::Stored;
use tree::{LEAF, SINGLE, Space, Tree};

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
    tree: Stored,
    space: Space,
    surfaces: Vec<Body>,
    ranks: Vec<Vec<Rank>>,
    /// Distances that differ by less are one place.
    tolerance: f64,
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

/// With each bundle in a row that was none, twice as many rays are taken alone before the next try, so often.
const MOST_STRAYS: u32 = 4;

impl Accel {
    /// The first surface met at a distance between `t_min` and `t_max` (both excluded). Of surfaces less than 1e-6 apart along the ray (in
    /// scenes of ordinary size) the one of greatest [`Rank`] is first.
    pub fn nearest(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<Hit> {
        // A constant: otherwise it is copied from where the answer goes.
        let single = const { Cell::new(None) };
        let mut search = Search::new(self, ray, [t_min, t_max], &single)?;
        search.run();
        search.finish()
    }

    /// What [`Accel::nearest`] finds for each of some rays and ranges of distances, told in their order with their numbers: quicker where rays are
    /// beside those before them, as are those of a picture.
    pub fn nearest_each<'r>(&self, rays: impl IntoIterator<Item = (&'r Ray, [f64; 2])>, mut found: impl FnMut(usize, Option<Hit>)) {
        let mut rays = rays.into_iter().fuse().enumerate().peekable();
        let singles = [const { Cell::new(None) }; WIDTH];
        let mut searches = [const { None }; WIDTH];
        let mut strays = 0;
        while let Some(&(first, _)) = rays.peek() {
            let mut count = 0;
            for (search, single) in searches.iter_mut().zip(&singles) {
                *search = rays.next().and_then(|(_, (ray, range))| {
                    count += 1;
                    Search::new(self, ray, range, single)
                });
            }
            let together = bundle::run(self.tree(), &mut searches);
            let hits = searches[..count].iter().map(|search| search.as_ref().and_then(Search::finish));
            hits.enumerate().for_each(|(n, hit)| found(first + n, hit));
            if together {
                strays = 0;
                continue;
            }
            // Rays behind some that go different ways are likely to do so too, the more of these there were.
            strays = (strays + 1).min(MOST_STRAYS);
            rays.by_ref().take(WIDTH << strays).for_each(|(n, (ray, [t_min, t_max]))| found(n, self.nearest(ray, t_min, t_max)));
        }
    }

    /// Whether any surface is met at a distance between `t_min` and `t_max` (both excluded).
    pub fn occluded(&self, ray: &Ray, t_min: f64, t_max: f64) -> bool {
        let Some(probe) = Probe::new(&self.space, ray, t_min, t_max) else { return false };
        let mut found = false;
        self.tree().walk::<false>(&probe, probe.limit, |leaf, limit| {
            found = if leaf & SINGLE != 0 {
                self.body(leaf).1.occludes(ray, t_min, t_max)
            } else {
                let number = leaf & !LEAF;
                let lanes = probe.test(&self.tree().blocks[number as usize], limit);
                (0..8).filter(|lane| lanes.mask >> lane & 1 == 1).any(|lane| {
                    let (t, blur) = (lanes.t[lane], lanes.blur[lane]);
                    probe
                        .within(t, blur)
                        .unwrap_or_else(|| self.tree().within(&probe, number << 3 | lane as u32, [t, blur], [t_min, t_max]))
                })
            };
            if found { -1.0 } else { limit }
        });
        found
    }

    /// Every hit at a distance between `t_min` and `t_max` (both excluded), in no particular order, with the rank it has among coincident ones.
    pub fn each(&self, ray: &Ray, t_min: f64, t_max: f64, visit: &mut dyn FnMut(Hit, Rank)) {
        let Some(probe) = Probe::new(&self.space, ray, t_min, t_max) else { return };
        self.tree().walk::<false>(&probe, probe.limit, |leaf, limit| {
            if leaf & SINGLE != 0 {
                let (surface, body) = self.body(leaf);
                body.each(ray, t_min, t_max, surface, &self.ranks[surface as usize], visit);
                return limit;
            }
            let number = leaf & !LEAF;
            let lanes = probe.test(&self.tree().blocks[number as usize], limit);
            for lane in (0..8).filter(|lane| lanes.mask >> lane & 1 == 1) {
                let slot = number << 3 | lane as u32;
                let detail = self.tree().detail(slot);
                let Body::Mesh(placed) = &self.surfaces[detail.surface as usize] else { continue };
                let hit = self.tree().meet(&probe, slot, lanes.t[lane], lanes.blur[lane]).hit(&probe, detail, placed.mirrored);
                if hit.t > t_min && hit.t < t_max {
                    visit(hit, placed.rank(&self.ranks[detail.surface as usize], detail.triangle));
                }
            }
            limit
        });
    }

    /// The world box round all there is.
    pub fn bounds(&self) -> Bounds {
        self.space.bounds
    }

    #[inline(always)]
    fn tree(&self) -> &Tree<'_> {
        self.tree.get()
    }

    /// How much memory the tree takes, without the meshes it was built from and without other trees in it.
    pub fn bytes(&self) -> usize {
        self.tree().bytes()
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

    /// The shape or instance in a leaf of its own.
    fn body(&self, leaf: u32) -> (u32, &Body) {
        let surface = self.tree().details[(leaf & (SINGLE - 1)) as usize].surface;
        (surface, &self.surfaces[surface as usize])
    }
}

#[cfg(test)]
mod tests;
