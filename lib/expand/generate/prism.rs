//! `genprism`: a prism over any polygon in the xy plane, its edges sharp or round.

use super::{Printer, Read, SURFACE_LIMIT, number};
use crate::error::{Error, Result};
use crate::rad::real;
use crate::vector::Vec3;

const USAGE: &str = "usage: genprism material name { vfile | N v1 v2 .. vN } [-l lvect] [-r radius] [-c] [-e]";

/// What takes one number for another: angles and areas below this are none.
const TINY: f64 = 1e-7;

/// The scene text that `genprism` prints for these arguments.
pub fn genprism(arguments: &[String], read: Read) -> Result<String> {
    let [material, name, rest @ ..] = arguments else { return Err(Error::new(USAGE)) };
    let (vertices, used) = vertices(rest, read)?;
    let (mut length, mut radius, mut closed, mut ends) = (Vec3::Z, 0.0, true, true);
    let mut options = rest[used..].iter();
    while let Some(option) = options.next() {
        match option.as_str() {
            "-l" => {
                let mut coordinate = || number(option, options.next());
                length = Vec3::new(coordinate()?, coordinate()?, coordinate()?);
            }
            "-r" => radius = number(option, options.next())?,
            "-c" => closed = false,
            "-e" => ends = false,
            _ => return Err(Error::new(format!("unknown option `{option}`; {USAGE}"))),
        }
    }
    if length.z.abs() <= TINY {
        return Err(Error::new("the extrusion vector must leave the xy plane"));
    }
    let n = vertices.len();
    let sides = if closed { n } else { n - 1 };
    let mut printer = Printer::new(material, name);
    if radius > 0.0 {
        rounded(&mut printer, &vertices, length, radius, sides, ends)?;
        return Ok(printer.text);
    }
    if ends {
        printer.surface("polygon", "b", &vertices, &[]);
        printer.surface("polygon", "t", &vertices.iter().rev().map(|&v| v + length).collect::<Vec<_>>(), &[]);
    }
    for i in 0..sides {
        let (a, b) = (vertices[i], vertices[(i + 1) % n]);
        printer.surface("polygon", i + 1, &[a, a + length, b + length, b], &[]);
    }
    Ok(printer.text)
}

/// A prism whose edges are cylinders, its convex corners spheres. The outline moves inward (outward, if the sides face inward)
/// by the radius; faces touch the cylinders.
fn rounded(printer: &mut Printer, vertices: &[Vec3], length: Vec3, radius: f64, sides: usize, ends: bool) -> Result<()> {
    let n = vertices.len();
    let area: f64 = (0..n).map(|i| vertices[i].cross(vertices[(i + 1) % n]).z).sum();
    // Sides face outward when the outline is clockwise as seen from where the prism extends to.
    let outward = if area * length.z < 0.0 { 1.0 } else { -1.0 };
    let left = if area < 0.0 { 1.0 } else { -1.0 };
    let along = |i: usize| (vertices[(i + 1) % n] - vertices[i % n]).try_normalize().ok_or_else(|| Error::new("two vertices coincide"));
    let edges = (0..n).map(along).collect::<Result<Vec<_>>>()?;
    // The normal of an edge within the plane, away from the inside of the outline.
    let away = |i: usize| Vec3::Z.cross(edges[i]) * left;
    let mut inner = Vec::with_capacity(n);
    for i in 0..n {
        let (a, b) = (away((i + n - 1) % n), away(i));
        let both = 1.0 + a.dot(b);
        if both <= TINY {
            return Err(Error::new("the outline turns back on itself"));
        }
        inner.push(vertices[i] - (a + b) / both * (radius * outward));
    }
    let rise = Vec3::Z * radius.copysign(length.z);
    let bottom = |i: usize| inner[i % n] + rise;
    let top = |i: usize| inner[i % n] + length - rise;
    // How sharply the outline turns at a vertex, positive where the solid is convex.
    let turn = |i: usize| edges[(i + n - 1) % n].cross(edges[i % n]).z * -left * outward;
    if ends {
        printer.surface("polygon", "b", &inner, &[]);
        printer.surface("polygon", "t", &inner.iter().rev().map(|&v| v + length).collect::<Vec<_>>(), &[]);
        for (letter, corner) in [('b', &bottom as &dyn Fn(usize) -> Vec3), ('t', &top)] {
            for i in 0..n {
                if turn(i) > TINY {
                    printer.surface("sphere", format!("{letter}c{}", i + 1), &[corner(i)], &[radius]);
                }
                printer.surface("cylinder", format!("{letter}e{}", i + 1), &[corner(i + n - 1), corner(i)], &[radius]);
            }
        }
    }
    for i in 0..sides {
        // The face leans as the extrusion does across the edge.
        let lean = length.normalize().dot(away(i));
        let touch = (away(i) * (1.0 - lean * lean).sqrt() - Vec3::Z * (lean * length.z.signum())) * (radius * outward);
        let face = [bottom(i), top(i), top(i + 1), bottom(i + 1)].map(|p| p + touch);
        printer.surface("polygon", i + 1, &face, &[]);
        if turn(i + 1) >= -TINY {
            printer.surface("cylinder", format!("e{}", i + 1), &[bottom(i + 1), top(i + 1)], &[radius]);
        }
    }
    Ok(())
}

/// The outline, and how many of the arguments tell it.
fn vertices(arguments: &[String], read: Read) -> Result<(Vec<Vec3>, usize)> {
    let Some(first) = arguments.first() else { return Err(Error::new(USAGE)) };
    let from_words = |words: &mut dyn Iterator<Item = &str>| -> Vec<f64> { words.map_while(real).collect() };
    let (numbers, used) = match first.parse::<usize>() {
        Ok(n) => {
            let words = n.saturating_mul(2).min(SURFACE_LIMIT);
            let numbers = from_words(&mut arguments[1..].iter().take(words).map(String::as_str));
            if numbers.len() != n.saturating_mul(2) {
                return Err(Error::new(format!("{n} vertices need {} coordinates; {USAGE}", n.saturating_mul(2))));
            }
            (numbers, 1 + words)
        }
        Err(_) => (from_words(&mut read(first, false)?.split_whitespace()), 1),
    };
    if numbers.len() < 6 {
        return Err(Error::new("a prism needs three vertices"));
    }
    Ok((numbers.chunks_exact(2).map(|c| Vec3::new(c[0], c[1], 0.0)).collect(), used))
}
