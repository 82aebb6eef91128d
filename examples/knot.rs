//! Prints a trefoil knot as a Wavefront mesh: the concave object of the demo, about one unit across.
//!
//! `cargo run --release --example knot > knot.obj`

use inverad::vector::Vec3;
use std::f64::consts::TAU;
use std::io::{self, Write};

/// Rings along the knot, and points around each.
const RINGS: usize = 360;
const POINTS: usize = 48;

fn main() -> io::Result<()> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    writeln!(out, "# A trefoil knot\no knot")?;
    for i in 0..RINGS {
        let t = TAU * i as f64 / RINGS as f64;
        let ahead = (axis(t + 1e-4) - axis(t - 1e-4)).normalize();
        // The inner side of the bend and what is across it: a frame that closes on itself.
        let across = ahead.cross(Vec3::Z).normalize();
        let up = across.cross(ahead);
        for j in 0..POINTS {
            let (sin, cos) = (TAU * j as f64 / POINTS as f64).sin_cos();
            let p = axis(t) + (across * cos + up * sin) * 0.105;
            writeln!(out, "v {:.6} {:.6} {:.6}", p.x, p.y, p.z)?;
        }
    }
    let vertex = |i: usize, j: usize| i % RINGS * POINTS + j % POINTS + 1;
    for i in 0..RINGS {
        for j in 0..POINTS {
            let (a, b, c, d) = (vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
            writeln!(out, "f {a} {b} {c}\nf {a} {c} {d}")?;
        }
    }
    out.flush()
}

/// The axis of the knot.
fn axis(t: f64) -> Vec3 {
    Vec3::new(t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos(), -(3.0 * t).sin() * 1.1) * 0.155
}
