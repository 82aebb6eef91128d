//! `genworm`: spheres along a curve, joined by cones that touch them.

use super::curve::Functions;
use super::{Printer, Read, SURFACE_LIMIT};
use crate::cal::Context;
use crate::error::{Error, Result};
use crate::vector::Vec3;

const USAGE: &str = "usage: genworm material name x(t) y(t) z(t) r(t) nseg [-e expr] [-f file]";

/// Radii nearer to each other than this are equal.
const TINY: f64 = 1e-7;

/// The scene text that `genworm` prints for these arguments.
pub fn genworm(arguments: &[String], read: Read) -> Result<String> {
    let [material, name, x, y, z, r, segments, options @ ..] = arguments else { return Err(Error::new(USAGE)) };
    let (mut functions, others) = Functions::parse(options, read)?;
    if let Some(option) = others.first() {
        return Err(Error::new(format!("unknown option `{option}`; {USAGE}")));
    }
    let segments = functions.count(segments, SURFACE_LIMIT / 2)?;
    let program = functions.compile("t", &[("x", x), ("y", y), ("z", z), ("r", r)])?;
    let ball = |i: usize| -> Result<(Vec3, f64)> {
        let t = i as f64 / segments as f64;
        let [x, y, z, r] = program.call(&Context::default(), &[t]).map_err(|e| Error::new(format!("at t = {t}: {e}")))?;
        Ok((Vec3::new(x, y, z), r))
    };
    let mut printer = Printer::new(material, name);
    let (mut p, mut r) = ball(0)?;
    printer.surface("sphere", "s0", &[p], &[r]);
    for i in 1..=segments {
        let (q, s) = ball(i)?;
        let (axis, grow) = (q - p, s - r);
        if grow.abs() <= TINY {
            printer.surface("cylinder", format!("c{i}"), &[p, q], &[s]);
        } else {
            // Both spheres have the same tangent cone: its circles lie back by radius × sine of its half angle.
            let distance = axis.length();
            let sine = grow / distance;
            let cosine = (1.0 - sine * sine).max(0.0).sqrt();
            let back = axis / distance * sine;
            printer.surface("cone", format!("c{i}"), &[p - back * r, q - back * s], &[r * cosine, s * cosine]);
        }
        printer.surface("sphere", format!("s{i}"), &[q], &[s]);
        (p, r) = (q, s);
    }
    Ok(printer.text)
}
