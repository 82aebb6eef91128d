//! RADIANCE's `polygon`: any number of vertices near a plane, concave or with holes (by a seam walked twice).

use super::{Bounds, Ray, tolerance};
use crate::vector::{Vec3, across, longest};

/// A flat surface. Hits are on the mean plane of the vertices, inside by the even-odd rule.
#[derive(Clone, Debug)]
pub struct Polygon {
    /// The corners as given, without a last one that repeats the first.
    pub vertices: Box<[Vec3]>,
    /// Unit normal; the vertices are counter-clockwise seen from where it points.
    pub normal: Vec3,
    /// The mean plane: `normal · p = offset`.
    pub offset: f64,
    /// Half the length of the sum of the cross products round the first vertex: with holes taken off.
    pub area: f64,
    /// The two axes of the plane the inside test projects onto: those without the largest normal component.
    axes: [usize; 2],
    /// The projected corners.
    outline: Box<[[f64; 2]]>,
    /// The box round `outline`, grown by `margin`: smallest and largest.
    frame: [[f64; 2]; 2],
    /// A point this near to an edge counts as inside.
    margin: f64,
}

impl Polygon {
    /// The polygon with these corners (at least 3, finite); `None` when its area is zero.
    pub fn new(mut vertices: Vec<Vec3>) -> Option<Self> {
        let size = Bounds::of(vertices.iter().copied()).size();
        let margin = tolerance(size);
        if vertices.len() > 3 && (vertices[0] - vertices[vertices.len() - 1]).abs().max_element() <= margin {
            vertices.pop();
        }
        let first = vertices[0];
        let sum: Vec3 = vertices.windows(2).skip(1).map(|w| (w[0] - first).cross(w[1] - first)).sum();
        let normal = sum.try_normalize()?;
        let offset = first.dot(normal) + vertices.iter().map(|&v| (v - first).dot(normal)).sum::<f64>() / vertices.len() as f64;
        let axes = across(longest(normal));
        let outline: Box<[_]> = vertices.iter().map(|v| axes.map(|i| v[i])).collect();
        let low = [0, 1].map(|i| outline.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min) - margin);
        let high = [0, 1].map(|i| outline.iter().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max) + margin);
        Some(Self { vertices: vertices.into(), normal, offset, area: sum.length() / 2.0, axes, outline, frame: [low, high], margin })
    }

    /// The distance of the hit with `t_min < t < t_max`.
    pub fn intersect(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<f64> {
        let t = plane(ray, self.normal, self.offset)?;
        (t > t_min && t < t_max && self.contains(ray.at(t))).then_some(t)
    }

    /// Whether a point of the plane is inside, or within the margin of an edge.
    pub fn contains(&self, point: Vec3) -> bool {
        let p = self.axes.map(|i| point[i]);
        let [low, high] = self.frame;
        if !(p[0] >= low[0] && p[0] <= high[0] && p[1] >= low[1] && p[1] <= high[1]) {
            return false;
        }
        let edges = || self.outline.iter().zip(self.outline.iter().cycle().skip(1));
        // Count the edges to the right that reach from below the point to it or above. Taking the lower end first makes an edge and its
        // reverse (a seam) agree to the last bit.
        let crossings = edges().filter(|&(a, b)| {
            let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            a[1] <= p[1] && p[1] < b[1] && (p[0] - a[0]) * (b[1] - a[1]) < (p[1] - a[1]) * (b[0] - a[0])
        });
        crossings.count() % 2 == 1 || edges().any(|(a, b)| near(p, *a, *b, self.margin))
    }

    /// The point of the mean plane that projects onto the given coordinates of the outline.
    fn lift(&self, p: [f64; 2]) -> Vec3 {
        let mut point = Vec3::ZERO;
        (point[self.axes[0]], point[self.axes[1]]) = (p[0], p[1]);
        let axis = 3 - self.axes[0] - self.axes[1];
        point[axis] = (self.offset - point.dot(self.normal)) / self.normal[axis];
        point
    }

    /// The box round all points that count as inside.
    pub fn bounds(&self) -> Bounds {
        // The margin is in the projection; along the third axis the plane rises at most as fast.
        Bounds::of(self.outline.iter().map(|&p| self.lift(p))).grow(2.0 * self.margin)
    }

    /// The average of the corners.
    pub fn vertex_average(&self) -> Vec3 {
        self.vertices[0] + self.vertices.iter().map(|&v| v - self.vertices[0]).sum::<Vec3>() / self.vertices.len() as f64
    }

    /// How far the corners are from the mean plane at most, as RADIANCE measures it: relative to the offset of the plane where that
    /// is above 1e-6.
    pub fn unevenness(&self) -> f64 {
        let scale = if self.offset.abs() > super::TINY { self.offset.abs() } else { 1.0 };
        self.vertices.iter().map(|v| (v.dot(self.normal) - self.offset).abs() / scale).fold(0.0, f64::max)
    }

    /// The part inside by the even-odd rule as trapezoids: corners in the plane, the first two on one parallel side, the other two on
    /// the other (in the same sense), so that the first and the last share a slanted side. `None` if they are too many, as where an outline crosses itself
    /// again and again.
    pub fn trapezoids(&self) -> Option<Vec<[Vec3; 4]>> {
        let mut levels: Vec<f64> = self.outline.iter().map(|p| p[1]).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        let mut out = Vec::new();
        for w in levels.windows(2) {
            // The edges that reach through this slab, by where they do so at its bottom and at its top.
            let edges = self.outline.iter().zip(self.outline.iter().cycle().skip(1));
            let mut sides: Vec<[f64; 2]> = edges
                .filter_map(|(a, b)| {
                    let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
                    let x = |y: f64| a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]));
                    (a[1] <= w[0] && b[1] >= w[1]).then(|| [x(w[0]), x(w[1])])
                })
                .collect();
            if sides.len() > MOST_SIDES {
                return None;
            }
            let between = |[low, high]: [f64; 2], t: f64| low * (1.0 - t) + high * t;
            // Where none cross, in order; every second gap between them is inside.
            for part in uncrossed(&mut sides).windows(2) {
                let middle = 0.5 * (part[0] + part[1]);
                sides.sort_by(|a, b| between(*a, middle).total_cmp(&between(*b, middle)));
                for pair in sides.chunks_exact(2).filter(|pair| pair[0] != pair[1]) {
                    let corner = |side: usize, end: usize| self.lift([between(pair[side], part[end]), between([w[0], w[1]], part[end])]);
                    out.push([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
                }
                if out.len() > MOST_TRAPEZOIDS {
                    return None;
                }
            }
        }
        Some(out)
    }
}

/// The most sides that a level line of a lamp may cross, and trapezoids that a lamp may be.
const MOST_SIDES: usize = 2048;
const MOST_TRAPEZOIDS: usize = 1 << 17;

/// The parts of the way from one end to the other, from 0 to 1, between which no straight sides cross that are here and there at their ends.
fn uncrossed(sides: &mut [[f64; 2]]) -> Vec<f64> {
    let mut ends = vec![0.0, 1.0];
    sides.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    if !sides.is_sorted_by(|a, b| a[1] <= b[1]) {
        let pairs = sides.iter().enumerate().flat_map(|(i, a)| sides[i..].iter().map(move |b| (a, b)));
        ends.extend(pairs.filter(|(a, b)| a[0] < b[0] && a[1] > b[1]).map(|(a, b)| (b[0] - a[0]) / (b[0] - a[0] + a[1] - b[1])));
        ends.sort_by(f64::total_cmp);
        ends.dedup();
    }
    ends
}

/// The distance along the ray to the plane `normal · p = offset`; `None` when it runs along the plane (RADIANCE: |cos| ≤ 1e-6).
pub(super) fn plane(ray: &Ray, normal: Vec3, offset: f64) -> Option<f64> {
    let slope = ray.direction.dot(normal);
    (slope.abs() > super::TINY).then(|| (offset - ray.origin.dot(normal)) / slope)
}

/// Whether `p` is within `margin` of the segment from `a` to `b`.
fn near(p: [f64; 2], a: [f64; 2], b: [f64; 2], margin: f64) -> bool {
    let (d, q) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length2 = d[0] * d[0] + d[1] * d[1];
    let s = if length2 > 0.0 { ((q[0] * d[0] + q[1] * d[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let (x, y) = (q[0] - s * d[0], q[1] - s * d[1]);
    x * x + y * y <= margin * margin
}
