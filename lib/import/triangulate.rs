//! A polygon without holes as triangles, by clipping ears (Meisters 1975, "Polygons Have Ears").

use crate::vector::{Vec3, across, longest};

/// Three places in the list of corners for each triangle, n − 2 of them. Starts with the ear at the first corner, as `obj2mesh` does.
pub fn triangulate(corners: &[Vec3]) -> Vec<[usize; 3]> {
    let n = corners.len();
    let normal: Vec3 = (1..n.saturating_sub(1)).map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0])).sum();
    let axis = longest(normal);
    let [x, y] = across(axis);
    let flip = normal[axis] < 0.0;
    let flat: Vec<[f64; 2]> = corners.iter().map(|p| if flip { [p[y], p[x]] } else { [p[x], p[y]] }).collect();
    let side = |a: usize, b: usize, c: usize| {
        let (a, b, c) = (flat[a], flat[b], flat[c]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut left: Vec<usize> = (0..n).collect();
    let mut out = Vec::with_capacity(n.saturating_sub(2));
    while left.len() > 3 {
        let m = left.len();
        let around = |i: usize| [left[(i + m - 1) % m], left[i], left[(i + 1) % m]];
        // An ear turns the right way and has no other corner inside. A polygon that crosses itself may have none: clip any corner then.
        let bends: Vec<usize> = (0..m)
            .filter(|&i| {
                let [a, b, c] = around(i);
                side(a, b, c) < 0.0
            })
            .map(|i| left[i])
            .collect();
        let ear = (0..m).find(|&i| {
            let [a, b, c] = around(i);
            side(a, b, c) > 0.0
                && bends.iter().all(|&p| {
                    let touching = [a, b, c].iter().any(|&q| flat[q] == flat[p]);
                    touching || side(a, b, p) < 0.0 || side(b, c, p) < 0.0 || side(c, a, p) < 0.0
                })
        });
        let i = ear.unwrap_or(0);
        out.push(around(i));
        left.remove(i);
    }
    if let [a, b, c] = left[..] {
        out.push([a, b, c]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[Vec3], triangles: &[[usize; 3]]) -> f64 {
        triangles.iter().map(|t| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).z / 2.0).sum()
    }

    #[test]
    fn ears_cover_the_polygon_once() {
        let star: Vec<Vec3> = (0..40)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 40.0).sin_cos();
                Vec3::new(cos, sin, 0.0) * if i % 2 == 0 { 1.0 } else { 0.2 }
            })
            .collect();
        let triangles = triangulate(&star);
        assert_eq!(triangles.len(), 38);
        // Each of the 40 equal pieces from the middle has area ½ · 1 · .2 · sin 9°.
        assert!((area(&star, &triangles) - 20.0 * 0.2 * 9f64.to_radians().sin()).abs() < 1e-12);
        assert!(triangles.iter().all(|t| area(&star, &[*t]) > 0.0));
    }

    #[test]
    fn what_has_no_ear_still_ends() {
        assert_eq!(triangulate(&[Vec3::ZERO; 9]).len(), 7);
        assert_eq!(triangulate(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE, Vec3::X]).len(), 3);
        assert_eq!(triangulate(&[]).len(), 0);
    }
}
