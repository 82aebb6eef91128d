//! `genbox`: a box with one corner at the origin, its edges sharp, bevelled or round.

use super::{Printer, number};
use crate::error::{Error, Result};
use crate::rad::real;
use crate::vector::Vec3;

const USAGE: &str = "usage: genbox material name xsize ysize zsize [-i] [-b bevel | -r round]";

/// Faces of a sharp box by their corners (bit 0: x, bit 1: y, bit 2: z), which also name them.
const FACES: [&str; 6] = ["1540", "4620", "2310", "3267", "5137", "6457"];

/// Faces of a bevelled box by their points: a letter from `c` is a corner moved inward in x and z, from `k` in y and z,
/// from `M` in x and y. The first six remain when the edges are round.
const BEVELLED: [&str; 26] = [
    "dhgc", "oqmk", "OPNM", "feij", "plnr", "SQRT", "NdcM", "kmOM", "cgok", "QSqo", "TjiS", "emqi", "efPO", "jrnf", "lNPn", "prTR", "hdlp",
    "QghR", "Mck", "dNl", "Ome", "ogQ", "Siq", "pRh", "fnP", "Trj",
];

/// Round edges by the corners that they join; a letter from `s` is a corner moved inward in x, y and z.
const EDGES: [&str; 12] = ["st", "sw", "su", "vt", "vu", "vz", "xt", "xw", "xz", "yu", "yw", "yz"];

/// The scene text that `genbox` prints for these arguments.
pub fn genbox(arguments: &[String]) -> Result<String> {
    let [material, name, x, y, z, options @ ..] = arguments else { return Err(Error::new(USAGE)) };
    let size = |word: &str| real(word).filter(|&x| x > 0.0).ok_or_else(|| Error::new(format!("`{word}` is not a positive size")));
    let size = Vec3::new(size(x)?, size(y)?, size(z)?);
    let (mut inward, mut bevel, mut round) = (false, 0.0, 0.0);
    let mut options = options.iter();
    while let Some(option) = options.next() {
        match option.as_str() {
            "-i" => inward = true,
            "-b" => bevel = number(option, options.next())?,
            "-r" => round = number(option, options.next())?,
            _ => return Err(Error::new(format!("unknown option `{option}`; {USAGE}"))),
        }
    }
    let inset = if round > 0.0 { round } else { bevel };
    // A corner by its name; a box seen from inside is the same box with opposite corners exchanged.
    let corner = |letter: u8| -> Vec3 {
        let (number, moved) = match letter {
            b'c'..=b'j' => (letter - b'c', Vec3::new(1.0, 0.0, 1.0)),
            b'k'..=b'r' => (letter - b'k', Vec3::new(0.0, 1.0, 1.0)),
            b'M'..=b'T' => (letter - b'M', Vec3::new(1.0, 1.0, 0.0)),
            b's'..=b'z' => (letter - b's', Vec3::ONE),
            _ => (letter - b'0', Vec3::ZERO),
        };
        let number = if inward { 7 - number } else { number };
        let far = Vec3::new(f64::from(number & 1), f64::from(number >> 1 & 1), f64::from(number >> 2 & 1));
        far * size + moved * inset * (Vec3::ONE - 2.0 * far)
    };
    let corners = |name: &str| name.bytes().map(corner).collect::<Vec<_>>();
    let mut printer = Printer::new(material, name);
    let faces: &[&str] = match inset {
        _ if inset <= 0.0 => &FACES,
        _ if round > 0.0 => &BEVELLED[..6],
        _ => &BEVELLED,
    };
    for face in faces {
        printer.surface("polygon", face, &corners(face), &[]);
    }
    if round > 0.0 {
        for edge in EDGES {
            printer.surface("cylinder", edge, &corners(edge), &[round]);
        }
        for letter in ["s", "t", "u", "v", "w", "x", "y", "z"] {
            printer.surface("sphere", letter, &corners(letter), &[round]);
        }
    }
    Ok(printer.text)
}
