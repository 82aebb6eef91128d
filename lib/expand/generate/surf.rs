//! `gensurf`: a surface over a square of parameters, as quadrilaterals where they are flat and triangles elsewhere.

use super::curve::Functions;
use super::{Printer, Read, SURFACE_LIMIT};
use crate::cal::{Context, Program};
use crate::error::{Error, Result};
use crate::expand::printf::g;
use crate::rad::{Quoted, real};
use crate::vector::Vec3;
use std::fmt::Write;

const USAGE: &str = "usage: gensurf material name x(s,t) y(s,t) z(s,t) m n [-s] [-i] [-e expr] [-f file]";

/// A sine below this is zero: of a corner of a triangle, or between a fourth point and the plane of the others.
const TINY: f64 = 2e-7;

/// Coordinates that come from files: their numbers, how many a vertex takes, and which of these is the one.
struct Data([Option<(Vec<f64>, usize, usize)>; 3]);

impl Data {
    /// The files among three arguments. One file for all three holds all three coordinates of each vertex.
    fn read(arguments: [&String; 3], read: Read) -> Result<Self> {
        let together = arguments[0] == arguments[1] && arguments[1] == arguments[2];
        let mut data = [None, None, None];
        for (axis, (argument, data)) in arguments.into_iter().zip(&mut data).enumerate() {
            let Ok(text) = read(argument, false) else { continue };
            let numbers = text.split_whitespace().map(real).collect::<Option<Vec<_>>>();
            let numbers = numbers.ok_or_else(|| Error::new(format!("{argument}: holds words that are no numbers")))?;
            *data = Some(if together { (numbers, 3, axis) } else { (numbers, 1, 0) });
        }
        Ok(Self(data))
    }

    fn is_empty(&self) -> bool {
        self.0.iter().all(Option::is_none)
    }

    fn is_some_for(&self, axis: usize) -> bool {
        self.0[axis].is_some()
    }

    /// The vertex (index, number of steps along s and t) with the coordinates that come from files; s runs fastest in them.
    fn replace(&self, computed: Vec3, (i, m): (usize, usize), (j, n): (usize, usize)) -> Option<Vec3> {
        let mut point = computed;
        for (axis, data) in self.0.iter().enumerate() {
            if let Some((numbers, stride, offset)) = data {
                point[axis] = *numbers.get((j * (m + 1) + i) * stride + offset).filter(|_| i <= m && j <= n)?;
            }
        }
        Some(point)
    }
}

/// A vertex, and the surface's normal there.
#[derive(Clone, Copy)]
struct Vertex {
    point: Vec3,
    /// Unit; zero where the surface has no tangent plane.
    normal: Vec3,
}

/// The scene text that `gensurf` prints for these arguments.
pub fn gensurf(arguments: &[String], read: Read) -> Result<String> {
    let [material, name, x, y, z, m, n, options @ ..] = arguments else { return Err(Error::new(USAGE)) };
    let (mut functions, others) = Functions::parse(options, read)?;
    if let Some(option) = others.iter().find(|o| !matches!(o.as_str(), "-s" | "-i")) {
        return Err(Error::new(format!("unknown option `{option}`; {USAGE}")));
    }
    let m = functions.count(m, SURFACE_LIMIT)?;
    let n = functions.count(n, SURFACE_LIMIT / m)?;
    let data = Data::read([x, y, z], read)?;
    let expression = |axis: usize, text| if data.is_some_for(axis) { "0" } else { text };
    let program = functions.compile("s,t", &[("x", expression(0, x)), ("y", expression(1, y)), ("z", expression(2, z))])?;
    // Where this is not positive, there is no vertex.
    let is_defined = functions.parameters("valid") == Some(2);
    let valid = is_defined.then(|| functions.compile("s,t", &[("valid", "valid(s,t)")])).transpose()?;
    let point = |i: usize, j: usize| -> Option<Vec3> {
        let parameters = [(i as f64 - 1.0) / m as f64, (j as f64 - 1.0) / n as f64];
        let is_valid = |valid: &Program| valid.call(&Context::default(), &parameters).is_ok_and(|[valid]| valid > 0.0);
        if !valid.as_ref().is_none_or(is_valid) {
            return None;
        }
        // Faces round a vertex without a value are left out.
        let mut computed = program.call(&Context::default(), &parameters).map_or(Vec3::NAN, Vec3::from_array);
        if !data.is_empty() {
            computed = data.replace(computed, (i.checked_sub(1)?, m), (j.checked_sub(1)?, n))?;
        }
        Some(computed)
    };
    // Smooth normals take a rim of vertices beyond the square: index 1 is parameter 0.
    let [smooth, inverted] = ["-s", "-i"].map(|option| others.iter().any(|o| o == option));
    let row =
        |i: usize| -> Vec<Option<Vec3>> { (0..n + 3).map(|j| (smooth || j > 0 && j < n + 2).then(|| point(i, j)).flatten()).collect() };
    let vertices = |rows: [&[Option<Vec3>]; 3]| -> Vec<Option<Vertex>> {
        let or = |there: Option<Vec3>, at: Vec3| there.filter(|p| p.is_finite()).unwrap_or(at);
        let tangent = |before: Option<Vec3>, at: Vec3, behind: Option<Vec3>| or(behind, at) - or(before, at);
        let vertex = |j: usize| {
            let point = rows[1][j]?;
            let along = tangent(rows[0][j], point, rows[2][j]);
            let across = tangent(rows[1][j - 1], point, rows[1][j + 1]);
            Some(Vertex { point, normal: along.cross(across).normalize_or_zero() * if inverted { -1.0 } else { 1.0 } })
        };
        (1..n + 2).map(vertex).collect()
    };
    let none = vec![None; n + 3];
    let (mut before, mut here, mut behind) = (if smooth { row(0) } else { none.clone() }, row(1), row(2));
    let mut rear = vertices([&before, &here, &behind]);
    let mut surface = Surface { material, smooth, inverted, printer: Printer::new(material, name), count: 0 };
    for i in 1..=m {
        before = std::mem::replace(&mut here, behind);
        behind = if smooth || i < m { row(i + 2) } else { none.clone() };
        let front = vertices([&before, &here, &behind]);
        for j in 0..n {
            surface.square([rear[j], rear[j + 1], front[j], front[j + 1]], j % 2 == 0);
        }
        rear = front;
    }
    Ok(surface.printer.text)
}

struct Surface<'a> {
    material: &'a str,
    smooth: bool,
    /// Whether what would be the back is the front.
    inverted: bool,
    printer: Printer<'a>,
    count: usize,
}

impl Surface<'_> {
    /// Prints what stands between four vertices: (s, t) low low, low high, high low, high high. Between three it is a triangle.
    fn square(&mut self, corners: [Option<Vertex>; 4], even: bool) {
        let missing = corners.iter().position(Option::is_none);
        let (mut corners, mut even) = (corners, even);
        if let Some(i) = missing {
            // Instead of it one that makes the square a parallelogram; the diagonal is the one that cuts it off.
            let [Some(beside), Some(other), Some(across)] = [i ^ 1, i ^ 2, i ^ 3].map(|i| corners[i]) else { return };
            let normal = (beside.normal + other.normal).normalize_or_zero();
            corners[i] = Some(Vertex { point: beside.point + other.point - across.point, normal });
            even = i == 1 || i == 2;
        }
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return };
        let [p, q, r, s] = [a, b, c, d].map(|v| v.point);
        // Diagonals change direction from one square to the next along t.
        let (first, second, whole) = match (even, self.inverted) {
            (true, false) => ([r, s, p], [p, s, q], [r, s, q, p]),
            (false, false) => ([p, r, q], [q, r, s], [p, r, s, q]),
            (true, true) => ([r, p, s], [s, p, q], [r, p, q, s]),
            (false, true) => ([p, q, r], [r, q, s], [p, q, s, r]),
        };
        let normals = [first, second].map(|[a, b, c]| {
            let (e, f) = (b - a, c - a);
            let cross = e.cross(f);
            (cross.length() > TINY * e.length() * f.length() && (b - c).length() > 0.0).then(|| cross.normalize())
        });
        if let [Some(u), Some(v)] = normals
            && missing.is_none()
            && u.cross(v).length() <= TINY
            && u.dot(v) > 0.0
        {
            return self.polygon(&whole, u, [a, b, c, d]);
        }
        // Each leaves out one corner.
        let without = if even { [1, 2] } else { [3, 0] };
        for ((triangle, normal), without) in [first, second].iter().zip(normals).zip(without) {
            if let Some(normal) = normal.filter(|_| missing.is_none_or(|i| i == without)) {
                self.polygon(triangle, normal, [a, b, c, d]);
            }
        }
    }

    /// Prints a flat face with its normal, before it the texture that makes it smooth.
    fn polygon(&mut self, points: &[Vec3], normal: Vec3, corners: [Vertex; 4]) {
        self.count += 1;
        let texture = self.smooth.then(|| texture(normal, corners)).flatten();
        if let Some((axis, rows)) = texture {
            let header = "4 surf_dx surf_dy surf_dz surf.cal\n0\n13";
            let _ = writeln!(self.printer.text, "\n{} texfunc Phong\n{header}\t{axis}", Quoted(self.material));
            for row in rows {
                let _ = writeln!(self.printer.text, "\t{} {} {}", g(row.x, 12), g(row.y, 12), g(row.z, 12));
            }
        }
        self.printer.modifier = if texture.is_some() { "Phong" } else { self.material };
        self.printer.surface("polygon", self.count, points, &[]);
    }
}

/// The axis that a face faces, and the factors of u v, u, v and 1 that add to its normal what makes it that of the corners.
fn texture(normal: Vec3, corners: [Vertex; 4]) -> Option<(usize, [Vec3; 4])> {
    let size = corners.iter().map(|c| c.normal).sum::<Vec3>().abs();
    let axis = (0..3).max_by(|&i, &j| size[i].total_cmp(&size[j]))?;
    let mut rows = [([0.0; 4], Vec3::ZERO); 4];
    for (row, corner) in rows.iter_mut().zip(corners) {
        let (u, v) = (corner.point[(axis + 1) % 3], corner.point[(axis + 2) % 3]);
        *row = ([u * v, u, v, 1.0], corner.normal - normal);
    }
    solve(rows).map(|rows| (axis, rows))
}

/// Solves four linear equations by elimination with pivots; `None` if they depend on each other.
fn solve(mut rows: [([f64; 4], Vec3); 4]) -> Option<[Vec3; 4]> {
    for i in 0..4 {
        let pivot = (i..4).max_by(|&a, &b| rows[a].0[i].abs().total_cmp(&rows[b].0[i].abs()))?;
        rows.swap(i, pivot);
        let (left, right) = rows[i];
        if left[i].abs() <= 1e-12 {
            return None;
        }
        for (j, (other, target)) in rows.iter_mut().enumerate() {
            if j != i {
                let factor = other[i] / left[i];
                for k in i..4 {
                    other[k] -= factor * left[k];
                }
                *target -= right * factor;
            }
        }
    }
    let mut solution = [Vec3::ZERO; 4];
    for i in 0..4 {
        solution[i] = rows[i].1 / rows[i].0[i];
    }
    Some(solution)
}
