//! `genrev`: a curve turned round the z axis, as cones, cylinders and rings.

use super::curve::Functions;
use super::{Printer, Read, SURFACE_LIMIT};
use crate::cal::Context;
use crate::error::{Error, Result};
use crate::expand::printf::g;
use crate::rad::Quoted;
use crate::vector::Vec3;
use std::fmt::Write;

const USAGE: &str = "usage: genrev material name z(t) r(t) nseg [-e expr] [-f file] [-s]";

/// Coordinates nearer to each other than this are equal.
const TINY: f64 = 1e-9;

/// The scene text that `genrev` prints for these arguments.
pub fn genrev(arguments: &[String], read: Read) -> Result<String> {
    let [material, name, z, r, segments, options @ ..] = arguments else { return Err(Error::new(USAGE)) };
    let (mut functions, others) = Functions::parse(options, read)?;
    if let Some(option) = others.iter().find(|o| *o != "-s") {
        return Err(Error::new(format!("unknown option `{option}`; {USAGE}")));
    }
    let segments = functions.count(segments, SURFACE_LIMIT)?;
    let program = functions.compile("t", &[("z", z), ("r", r)])?;
    let mut points = Vec::with_capacity(segments + 1);
    for i in 0..=segments {
        let t = i as f64 / segments as f64;
        let point: [f64; 2] = program.call(&Context::default(), &[t]).map_err(|e| Error::new(format!("at t = {t}: {e}")))?;
        points.push(point);
    }
    // The normal of a segment along z and away from the axis; none beyond the ends, or where the curve stands still.
    let normal = |i: Option<usize>| -> [f64; 2] {
        let Some([[z0, r0], [z1, r1]]) = i.and_then(|i| Some([*points.get(i)?, *points.get(i + 1)?])) else { return [0.0; 2] };
        let length = (z1 - z0).hypot(r1 - r0);
        if length > 0.0 { [(r0 - r1) / length, (z1 - z0) / length] } else { [0.0; 2] }
    };
    let smooth = !others.is_empty();
    let mut printer = Printer::new(if smooth { "Phong" } else { material }, name);
    for (i, pair) in points.windows(2).enumerate() {
        let ([z0, r0], [z1, r1]) = (pair[0], pair[1]);
        let (flat, straight) = ((z1 - z0).abs() <= TINY, (r1 - r0).abs() <= TINY);
        if flat && straight {
            continue;
        }
        if smooth {
            // Add the normal of the segment before at the start and of the one behind at the end, linear between.
            let (before, own, behind) = (normal(i.checked_sub(1)), normal(Some(i)), normal(Some(i + 1)));
            let line = |constant: bool, a: f64, b: f64, from: f64, to: f64, own: f64| {
                let slope = if constant { 0.0 } else { (b - a) / (to - from) };
                format!("{} {}", g(slope, 12), g(if constant { own } else { a - slope * from }, 12))
            };
            let along = line(flat, before[0], behind[0], z0, z1, own[0]);
            let across = line(straight, before[1], behind[1], r0, r1, own[1]);
            let header = "4 rev_dx rev_dy rev_dz rev.cal\n0\n4";
            let _ = write!(printer.text, "\n{} texfunc Phong\n{header}\n\t{along}\n\t{across}\n", Quoted(material));
        }
        let (p, q) = (Vec3::Z * z0, Vec3::Z * z1);
        match (flat, straight) {
            (true, _) => printer.surface("ring", i + 1, &[q, Vec3::Z * (r0 - r1).signum()], &[r0, r1]),
            (_, true) => printer.surface(if z1 > z0 { "cylinder" } else { "tube" }, i + 1, &[p, q], &[r1]),
            _ => printer.surface(if z1 > z0 { "cone" } else { "cup" }, i + 1, &[p, q], &[r0, r1]),
        }
    }
    Ok(printer.text)
}
