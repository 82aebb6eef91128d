//! A ray made ready for the tree: moved up to it, in its coordinates, with the shear of the watertight triangle test.

use super::tree::{Block, Space, four};
use crate::geometry::Ray;
use crate::vector::{Vec3, across};
use wide::{f32x4, f32x8, f64x4};

/// How far single precision may put a point from where it is, relative to its distance along the probe plus a quarter of the tree's cube:
/// the corners and the origin are rounded at magnitudes up to ½, the direction and the test's own arithmetic at the distance.
const ERROR: f32 = 2.0 * f32::EPSILON;
/// How far before its range a probe starts, so that no hit at the range's begin is lost to rounding.
pub(super) const LEAD: f32 = 1.0 / 65536.0;
/// What the uncertainty of a distance is taken for where single precision cannot tell it.
const WORST: f32 = 1.0 / 64.0;

/// Which lanes of a block are hit.
pub(super) struct Lanes {
    /// One bit each.
    pub mask: u32,
    /// Distances.
    pub t: [f32; 8],
    /// By how much the distances may be wrong. Hits less than that from an end of the range, or from each other, must be decided in
    /// double precision.
    pub blur: [f32; 8],
}

/// Where a ray from outside enters the bounds, if it does in its range, a little grown. What is no number counts as no bound.
#[inline(always)]
fn enter(space: &Space, origin: f64x4, inverse: f64x4, [t_min, t_max]: [f64; 2]) -> Option<f64> {
    let (a, b) = ((space.low - origin) * inverse, (space.high - origin) * inverse);
    let (near, far) = (a.fast_min(b).to_array(), a.fast_max(b).to_array());
    let (more, less) = (|a, b| if b > a { b } else { a }, |a, b| if b < a { b } else { a });
    // The third first: the others can be had without it.
    let start = more(more(more(t_min, near[2]), near[0]), near[1]);
    let end = less(less(less(t_max, far[2]), far[0]), far[1]);
    (start <= end + space.lead).then_some(start)
}

/// A ray in the coordinates of a tree.
#[derive(Clone, Debug)]
pub(super) struct Probe<'a> {
    /// The ray it is of.
    pub ray: &'a Ray,
    /// The coordinates it is in.
    space: &'a Space,
    /// Where it starts: at the near end of the range or, from outside the bounds, where it enters them, less [`LEAD`].
    pub origin: f32x4,
    /// The same, exactly.
    exact_origin: f64x4,
    /// One over the direction, finite.
    pub inverse: f32x4,
    /// Minus the product of both: a plane at x along an axis is met at the distance x · inverse + shift.
    pub shift: f32x4,
    /// Whether the direction is negative: a bit for each axis.
    pub signs: usize,
    /// The far end of the range, and a little more.
    pub limit: f32,
    /// The near end.
    from: f32,
    /// The far end.
    to: f32,
    /// The distance on the world's ray that this one starts at.
    start: f64,
    /// The axis the direction is longest along.
    pub axis: usize,
    /// The direction, one long along that axis: the shear that makes the ray an axis (Woop et al. 2013, "Watertight Ray/Triangle
    /// Intersection").
    pub shear: f32x4,
    /// The distance at which it is one away along that axis.
    pub depth: f32,
}

impl<'a> Probe<'a> {
    /// The probe for the part of the ray between the distances, or `None` when it misses the bounds.
    #[inline(always)]
    pub fn new(space: &'a Space, ray: &'a Ray, t_min: f64, t_max: f64) -> Option<Self> {
        let (o, d) = (four(ray.origin, 0.0), four(ray.direction, 1.0));
        // A huge number stands for infinity, without ever making 0 · ∞: boxes are padded.
        let least = f64x4::splat(1e-18);
        let inverse = f64x4::ONE / d.abs().simd_lt(least).bitselect(least | (d & f64x4::splat(-0.0)), d);
        let inside = (o.simd_ge(space.low) & o.simd_le(space.high)).all();
        let start = if inside { t_min } else { enter(space, o, inverse, [t_min, t_max])? } - space.lead;
        let exact_origin = (d.mul_add(f64x4::splat(start), o) - four(space.center, 0.0)) * f64x4::splat(space.scale);
        let single = |v: f64x4| f32x4::new(v.to_array().map(|x| x as f32));
        // A ray that is no ray meets nothing.
        if !exact_origin.simd_eq(exact_origin).all() {
            return None;
        }
        let (origin, inverse_single) = (single(exact_origin), single(inverse));
        let [x, y, z, _] = d.abs().to_array();
        let axis = if z > x && z > y { 2 } else { usize::from(y > x) };
        let depth = inverse.to_array()[axis];
        let reach = ((t_max - start) * space.scale) as f32;
        Some(Self {
            ray,
            space,
            origin,
            exact_origin,
            inverse: inverse_single,
            shift: -(origin * inverse_single),
            signs: d.to_bitmask() as usize,
            limit: reach + LEAD,
            from: ((t_min - start) * space.scale) as f32,
            to: reach,
            start,
            axis,
            shear: single(d * f64x4::splat(depth)),
            depth: depth as f32,
        })
    }

    /// The rows of a node's bounds that the ray comes to last, along each axis; those opposite are their numbers ^ 1.
    #[inline(always)]
    pub fn far_rows(&self) -> [usize; 3] {
        [self.signs & 1 ^ 1, 2 | self.signs >> 1 & 1 ^ 1, 4 | self.signs >> 2 & 1 ^ 1]
    }

    /// The point at a distance, in the tree's coordinates.
    #[inline(always)]
    pub fn at(&self, t: f64) -> Vec3 {
        let [x, y, z, _] = self.exact_origin.to_array();
        Vec3::new(x, y, z) + self.ray.direction * t
    }

    /// The world's distance for one of this probe's.
    #[inline(always)]
    pub fn world(&self, t: f64) -> f64 {
        self.start + t * self.space.unit
    }

    /// The world's point for one of the tree's.
    #[inline(always)]
    pub fn world_point(&self, p: Vec3) -> Vec3 {
        self.space.center + p * self.space.unit
    }

    /// This probe's distance for one of the world's.
    #[inline(always)]
    pub fn local(&self, t: f64) -> f32 {
        ((t - self.start) * self.space.scale) as f32
    }

    /// Whether a hit is within the range; `None` when single precision cannot tell.
    #[inline(always)]
    pub fn within(&self, t: f32, blur: f32) -> Option<bool> {
        if t - blur > self.from && t + blur < self.to {
            Some(true)
        } else if t + blur < self.from || t - blur > self.to {
            Some(false)
        } else {
            None
        }
    }

    /// Which triangles of the block are hit at a distance between 0 and `limit`. Triangles that are seen exactly edge
    /// on are not hit; no ray passes between triangles that share an edge or a vertex (Woop et al. 2013).
    #[inline(always)]
    pub fn test(&self, block: &Block, limit: f32) -> Lanes {
        let k = self.axis;
        let [i, j] = across(k);
        let (origin, shear) = (self.origin.to_array(), self.shear.to_array());
        let origin = [i, j, k].map(|axis| f32x8::splat(origin[axis]));
        let shear = [f32x8::splat(shear[i]), f32x8::splat(shear[j]), f32x8::splat(self.depth)];
        let corner = |v: usize| {
            let z = block.corners[v][k] - origin[2];
            let x = shear[0].mul_neg_add(z, block.corners[v][i] - origin[0]);
            let y = shear[1].mul_neg_add(z, block.corners[v][j] - origin[1]);
            [x, y, z]
        };
        let (a, b, c) = (corner(0), corner(1), corner(2));
        // Rounding a product is monotonic: these differences have the right sign or are zero, and change only sign with the order.
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let positive = u.fast_min(v).fast_min(w).simd_ge(f32x8::ZERO);
        let negative = u.fast_max(v).fast_max(w).simd_le(f32x8::ZERO);
        let area = u + v + w;
        let depth = u * a[2] + v * b[2] + w * c[2];
        let t = depth * shear[2] / area;
        let reached = (positive | negative) & t.simd_ge(f32x8::ZERO) & t.simd_le(f32x8::splat(limit));
        // Where all three vanish, single precision cannot tell: products of two singles are exact in double precision.
        let flat = positive & negative;
        // One branch, which is foreseen: most blocks are not reached. That one is in line with a triangle, as half of them are, is not.
        if (reached | flat).to_bitmask() == 0 {
            return Lanes { mask: 0, t: [0.0; 8], blur: [0.0; 8] };
        }
        // Moving the corners by ERROR changes each weight by ERROR times the triangle's width, relative to its area, and with it the
        // point of the triangle's depth that they pick, at most by all of that.
        let error = (t + f32x8::splat(0.25)) * f32x8::splat(ERROR);
        let range = (a[2].fast_max(b[2]).fast_max(c[2]) - a[2].fast_min(b[2]).fast_min(c[2])) * shear[2].abs();
        let blur = error + (error * f32x8::splat(block.width) * range / area.abs()).fast_min(range);
        let flat = flat.to_bitmask();
        if flat != 0 {
            return self.test_exactly(flat, &[a, b, c].map(|p| p.map(|x| x.to_array())), limit, [t, blur], reached.to_bitmask());
        }
        Lanes { mask: reached.to_bitmask(), t: t.to_array(), blur: blur.to_array() }
    }

    /// The same, in double precision, for some lanes of the sheared corners.
    #[cold]
    fn test_exactly(&self, which: u32, corners: &[[[f32; 8]; 3]; 3], limit: f32, [t, blur]: [f32x8; 2], mask: u32) -> Lanes {
        let mut lanes = Lanes { mask, t: t.to_array(), blur: blur.to_array() };
        for lane in (0..8).filter(|&lane| which >> lane & 1 == 1) {
            let [a, b, c] = corners.map(|p| p.map(|x| f64::from(x[lane])));
            let (u, v, w) = (c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]);
            let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
            let t = ((u * a[2] + v * b[2] + w * c[2]) * f64::from(self.depth) / (u + v + w)) as f32;
            if inside && t >= 0.0 && t <= limit {
                lanes.mask |= 1 << lane;
                (lanes.t[lane], lanes.blur[lane]) = (t, WORST);
            }
        }
        lanes
    }
}
