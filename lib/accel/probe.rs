//! A ray made ready for the tree: moved up to it, in its coordinates, with the shear of the watertight triangle test.

use super::tree::{Block, Space, single};
use crate::geometry::Ray;
use crate::vector::Vec3;
use wide::f32x8;

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

/// A ray in the coordinates of a tree.
#[derive(Clone, Debug)]
pub(super) struct Probe<'a> {
    /// The ray it is of.
    pub ray: &'a Ray,
    /// The coordinates it is in.
    space: &'a Space,
    /// Where it starts: at the near end of the range or where it enters the bounds, less [`LEAD`].
    pub origin: [f32; 3],
    /// The same, exactly.
    pub exact_origin: Vec3,
    /// One over the direction, finite.
    pub inverse: [f32; 3],
    /// Whether the direction is negative, per axis: 0 or 1.
    pub negative: [usize; 3],
    /// The far end of the range, and a little more.
    pub limit: f32,
    /// The near end.
    from: f32,
    /// The far end.
    to: f32,
    /// The distance on the world's ray that this one starts at.
    start: f64,
    /// Axes: two others, and the one the direction is longest along.
    axes: [usize; 3],
    /// The shear that makes the ray the third axis (Woop et al. 2013, "Watertight Ray/Triangle Intersection").
    shear: [f32; 3],
}

impl<'a> Probe<'a> {
    /// The probe for the part of the ray between the distances, or `None` when it misses the bounds.
    #[inline(always)]
    pub fn new(space: &'a Space, ray: &'a Ray, t_min: f64, t_max: f64) -> Option<Self> {
        let lead = f64::from(LEAD) * space.unit;
        let (o, d) = (ray.origin.to_array(), ray.direction.to_array());
        // A huge number stands for infinity, without ever making 0 · ∞: boxes are padded.
        let invert = |d: f64| 1.0 / if d.abs() < 1e-18 { 1e-18f64.copysign(d) } else { d };
        let inverse = [invert(d[0]), invert(d[1]), invert(d[2])];
        // Clip to the bounds, a little grown.
        let (mut start, mut end) = (t_min, t_max);
        for axis in 0..3 {
            let a = (space.low[axis] - o[axis]) * inverse[axis];
            let b = (space.high[axis] - o[axis]) * inverse[axis];
            let (near, far) = if a < b { (a, b) } else { (b, a) };
            start = if near > start { near } else { start };
            end = if far < end { far } else { end };
        }
        if start > end + lead {
            return None;
        }
        start -= lead;
        let exact_origin = space.local(ray.at(start));
        // A ray that is no ray meets nothing.
        if exact_origin.is_nan() {
            return None;
        }
        let origin = single(exact_origin);
        // The longest axis.
        let (x, y, z) = (d[0].abs(), d[1].abs(), d[2].abs());
        let k = if z > x && z > y { 2 } else { usize::from(y > x) };
        let i = if k == 2 { 0 } else { k + 1 };
        let j = 3 - k - i;
        let depth = inverse[k];
        let reach = ((t_max - start) * space.scale) as f32;
        Some(Self {
            ray,
            space,
            origin,
            exact_origin,
            inverse: [inverse[0] as f32, inverse[1] as f32, inverse[2] as f32],
            negative: [usize::from(d[0].is_sign_negative()), usize::from(d[1].is_sign_negative()), usize::from(d[2].is_sign_negative())],
            limit: reach + LEAD,
            from: ((t_min - start) * space.scale) as f32,
            to: reach,
            start,
            axes: [i, j, k],
            shear: [(d[i] * depth) as f32, (d[j] * depth) as f32, depth as f32],
        })
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
        let [i, j, k] = self.axes;
        let origin = [i, j, k].map(|axis| f32x8::splat(self.origin[axis]));
        let shear = self.shear.map(f32x8::splat);
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
        let low = u.fast_min(v).fast_min(w);
        let high = u.fast_max(v).fast_max(w);
        let inside = low.simd_ge(f32x8::ZERO) | high.simd_le(f32x8::ZERO);
        if inside.to_bitmask() == 0 {
            return Lanes { mask: 0, t: [0.0; 8], blur: [0.0; 8] };
        }
        let area = u + v + w;
        let depth = u * a[2] + v * b[2] + w * c[2];
        let t = depth * shear[2] / area;
        // Moving the corners by ERROR changes each weight by ERROR times the triangle's width, relative to its area, and with it the
        // point of the triangle's depth that they pick, at most by all of that.
        let error = (t + f32x8::splat(0.25)) * f32x8::splat(ERROR);
        let range = (a[2].fast_max(b[2]).fast_max(c[2]) - a[2].fast_min(b[2]).fast_min(c[2])) * shear[2].abs();
        let blur = error + (error * f32x8::splat(block.width) * range / area.abs()).fast_min(range);
        let reached = inside & t.simd_ge(f32x8::ZERO) & t.simd_le(f32x8::splat(limit));
        // Where all three vanish, single precision cannot tell: products of two singles are exact in double precision.
        let flat = (low.simd_ge(f32x8::ZERO) & high.simd_le(f32x8::ZERO)).to_bitmask();
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
            let t = ((u * a[2] + v * b[2] + w * c[2]) * f64::from(self.shear[2]) / (u + v + w)) as f32;
            if inside && t >= 0.0 && t <= limit {
                lanes.mask |= 1 << lane;
                (lanes.t[lane], lanes.blur[lane]) = (t, WORST);
            }
        }
        lanes
    }
}
