//! `gensurf`: a surface over a square of parameters, as quadrilaterals where they are flat and triangles elsewhere.

use super::curve::Functions;
use super::{Printer, Read, SURFACE_LIMIT};
use crate::cal::Context;
use crate::error::{Error, Result};
use crate::expand::printf::g;
use crate::rad::Quoted;
use crate::vector::Vec3;
use std::fmt::Write;

const USAGE: &str = "usage: gensurf material name x(s,t) y(s,t) z(s,t) m n [-s] [-e expr] [-f file]";

/// A sine below this is zero: of a corner of a triangle, or between a fourth point and the plane of the others.
const TINY: f64 = 2e-7;

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
    if let Some(option) = others.iter().find(|o| *o != "-s") {
        return Err(Error::new(format!("unknown option `{option}`; {USAGE}")));
    }
    let m = functions.count(m, SURFACE_LIMIT)?;
    let n = functions.count(n, SURFACE_LIMIT / m)?;
    let program = functions.compile("s,t", &[("x", x), ("y", y), ("z", z)])?;
    // A vertex without a value is left out, and the faces round it.
    let point = |i: usize, j: usize| -> Option<Vec3> {
        let parameters = [(i as f64 - 1.0) / m as f64, (j as f64 - 1.0) / n as f64];
        program.call(&Context::default(), &parameters).ok().map(Vec3::from_array).filter(|p| p.is_finite())
    };
    // Smooth normals take a rim of vertices beyond the square: index 1 is parameter 0.
    let smooth = !others.is_empty();
    let row =
        |i: usize| -> Vec<Option<Vec3>> { (0..n + 3).map(|j| (smooth || j > 0 && j < n + 2).then(|| point(i, j)).flatten()).collect() };
    let vertices = |rows: [&[Option<Vec3>]; 3]| -> Vec<Option<Vertex>> {
        let tangent = |before: Option<Vec3>, at: Vec3, behind: Option<Vec3>| behind.unwrap_or(at) - before.unwrap_or(at);
        let vertex = |j: usize| {
            let point = rows[1][j]?;
            let along = tangent(rows[0][j], point, rows[2][j]);
            let across = tangent(rows[1][j - 1], point, rows[1][j + 1]);
            Some(Vertex { point, normal: along.cross(across).normalize_or_zero() })
        };
        (1..n + 2).map(vertex).collect()
    };
    let none = vec![None; n + 3];
    let (mut before, mut here, mut behind) = (if smooth { row(0) } else { none.clone() }, row(1), row(2));
    let mut rear = vertices([&before, &here, &behind]);
    let mut surface = Surface { material, smooth, printer: Printer::new(material, name), count: 0 };
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
    printer: Printer<'a>,
    count: usize,
}

impl Surface<'_> {
    /// Prints what stands between four vertices: (s, t) low low, low high, high low, high high.
    fn square(&mut self, corners: [Option<Vertex>; 4], even: bool) {
        let [Some(a), Some(b), Some(c), Some(d)] = corners else { return };
        let [p, q, r, s] = [a, b, c, d].map(|v| v.point);
        // Diagonals change direction from one square to the next along t.
        let (first, second, whole) = if even { ([r, s, p], [p, s, q], [r, s, q, p]) } else { ([p, r, q], [q, r, s], [p, r, s, q]) };
        let normals = [first, second].map(|[a, b, c]| {
            let (e, f) = (b - a, c - a);
            let cross = e.cross(f);
            (cross.length() > TINY * e.length() * f.length() && (b - c).length() > 0.0).then(|| cross.normalize())
        });
        if let [Some(u), Some(v)] = normals
            && u.cross(v).length() <= TINY
            && u.dot(v) > 0.0
        {
            return self.polygon(&whole, u, [a, b, c, d]);
        }
        for (triangle, normal) in [first, second].iter().zip(normals) {
            if let Some(normal) = normal {
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
