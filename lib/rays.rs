//! What is asked and said of single rays, in the forms of `rtrace`: text, single or double precision, RGBE.
//!
//! A [`Reader`] takes rays from a stream; [`Teller::tell`] makes the record of a ray: the fields that `-o` names, with the colours of
//! `-p`. Records of a text end with a line break, their fields with a tab.

mod fields;
mod teller;
mod tree;

pub use fields::{Fields, Space};
pub use teller::{Teller, lengths};

use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::vector::Vec3;
use std::fmt::Display;
use std::io::{BufRead, ErrorKind};

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// As text.
    Ascii,
    /// Four bytes, the processor's order.
    Single,
    /// Eight bytes, the processor's order.
    Double,
    /// A colour in four bytes: three mantissas and an exponent.
    Color,
}

/// The letters of `-f`: the form of the rays, and of the answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// The form of the rays.
    pub input: Form,
    /// The form of the answers.
    pub output: Form,
}

impl Format {
    /// What `-f` and one or two letters mean.
    pub fn of(letters: &str) -> Result<Self> {
        let form = |letter: char| match letter {
            'a' => Some(Form::Ascii),
            'f' => Some(Form::Single),
            'd' => Some(Form::Double),
            'c' => Some(Form::Color),
            _ => None,
        };
        let forms: Option<Vec<Form>> = letters.chars().map(form).collect();
        match forms.as_deref() {
            Some(&[both]) if both != Form::Color => Ok(Self { input: both, output: both }),
            Some(&[input, output]) if input != Form::Color => Ok(Self { input, output }),
            _ => Err(Error::new(format!(
                "-f{letters}: give the form of the rays (a, f or d) and then of the answers (a, f, d or c), as in -ffc"
            ))),
        }
    }
}

impl Form {
    /// What the header of a stream of answers calls it.
    pub fn name(self, space: Space) -> &'static str {
        match self {
            Self::Ascii => "ascii",
            Self::Single => "float",
            Self::Double => "double",
            Self::Color if space == Space::Xyz => "32-bit_rle_xyze",
            Self::Color => "32-bit_rle_rgbe",
        }
    }

    /// The ray that bytes begin with, if it is whole and of finite numbers, and how many bytes it is.
    #[inline]
    fn first(self, bytes: &[u8]) -> Option<([f64; 6], usize)> {
        let first = match self {
            Self::Ascii => words(bytes),
            Self::Double => bytes.as_chunks().0.first_chunk::<6>().map(|ray| (ray.map(f64::from_ne_bytes), size_of_val(ray))),
            _ => bytes.as_chunks().0.first_chunk::<6>().map(|ray| (ray.map(|b| f32::from_ne_bytes(b) as f64), size_of_val(ray))),
        };
        first.filter(|(ray, _)| ray.iter().all(|number| number.is_finite()))
    }
}

/// Whether a ray has no direction: all answers are then wanted at once.
pub fn is_still(ray: &[f64; 6]) -> bool {
    ray[3..] == [0.0; 3]
}

/// The longest word of a text, in bytes.
const LONGEST_WORD: usize = 64;

/// Whether a byte stands between words.
fn is_space(byte: &u8) -> bool {
    byte.is_ascii_whitespace() || *byte == 0x0b
}

/// The six numbers that a text begins with, and its length up to their end, if it goes on behind them.
fn words(text: &[u8]) -> Option<([f64; 6], usize)> {
    let mut rest = text;
    let mut numbers = [0.0; 6];
    for number in &mut numbers {
        let (_, from) = rest.split_at(rest.iter().position(|b| !is_space(b))?);
        let (word, behind) = from.split_at(from.iter().position(is_space).filter(|&length| length <= LONGEST_WORD)?);
        *number = std::str::from_utf8(word).ok()?.parse().ok()?;
        rest = behind;
    }
    Some((numbers, text.len() - rest.len()))
}

/// A ray that is asked about.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// The ray; its direction is zero if that given has no length.
    pub ray: Ray,
    /// The length of the direction given.
    pub length: f64,
}

impl Asked {
    /// What six numbers ask: an origin and a direction of any length.
    pub fn new([x, y, z, dx, dy, dz]: [f64; 6]) -> Self {
        let direction = Vec3::new(dx, dy, dz);
        Self { ray: Ray::new(Vec3::new(x, y, z), direction.normalize_or_zero()), length: direction.length() }
    }
}

/// Rays from a stream: six numbers each, an origin and a direction.
pub struct Reader<R> {
    input: R,
    form: Form,
    rays: usize,
}

impl<R: BufRead> Reader<R> {
    /// Rays written in that form.
    pub fn new(input: R, form: Form) -> Self {
        Self { input, form, rays: 0 }
    }

    /// Adds rays to those until there are `most`, but none behind one without direction; fewer at the end.
    pub fn read(&mut self, rays: &mut Vec<[f64; 6]>, most: usize) -> Result<()> {
        let wanted = |rays: &[[f64; 6]]| rays.len() < most && !rays.last().is_some_and(is_still);
        while wanted(rays) {
            let before = rays.len();
            if let Ok(bytes) = self.input.fill_buf() {
                let mut taken = 0;
                while wanted(rays)
                    && let Some((ray, length)) = self.form.first(&bytes[taken..])
                {
                    rays.push(ray);
                    taken += length;
                }
                self.input.consume(taken);
            }
            // Where the next ray's bytes are not all there, or no ray, its numbers come one by one.
            if rays.len() == before {
                match self.pieces()? {
                    Some(ray) => rays.push(ray),
                    None => return Ok(()),
                }
            }
            self.rays += rays.len() - before;
        }
        Ok(())
    }

    /// The next ray, number by number; `None` at the end.
    fn pieces(&mut self) -> Result<Option<[f64; 6]>> {
        let mut ray = [0.0; 6];
        for (i, value) in ray.iter_mut().enumerate() {
            *value = match self.number()? {
                Some(value) => value,
                None if i == 0 => return Ok(None),
                None => return Err(self.wrong(format!("the input ends after {i} of its 6 numbers"))),
            };
        }
        Ok(Some(ray))
    }

    fn place(&self) -> String {
        format!("<stdin>: ray {}", self.rays + 1)
    }

    /// What is wrong with the next ray.
    fn wrong(&self, what: impl Display) -> Error {
        let form = match self.form {
            Form::Ascii => "words of text (-fa)",
            Form::Double => "doubles of this machine (-fd)",
            _ => "floats of this machine (-ff)",
        };
        Error::new(format!("{}: {what}; a ray is an origin and a direction, six {form}", self.place()))
    }

    fn number(&mut self) -> Result<Option<f64>> {
        match self.form {
            Form::Ascii => match self.word()? {
                Some(word) => match word.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(Some(value)),
                    _ => Err(self.wrong(format!("`{word}` is not a number"))),
                },
                None => Ok(None),
            },
            Form::Double => self.bytes::<8>()?.map(|b| self.finite(f64::from_ne_bytes(b))).transpose(),
            _ => self.bytes::<4>()?.map(|b| self.finite(f32::from_ne_bytes(b) as f64)).transpose(),
        }
    }

    /// A number that a ray can have.
    fn finite(&self, value: f64) -> Result<f64> {
        if value.is_finite() { Ok(value) } else { Err(self.wrong(format!("{value} is not a finite number"))) }
    }

    /// The next word of a text.
    fn word(&mut self) -> Result<Option<String>> {
        let mut word = String::new();
        while let Some(byte) = self.byte()? {
            match byte {
                b if is_space(&b) => {
                    if !word.is_empty() {
                        break;
                    }
                }
                b if word.len() < LONGEST_WORD => word.push(b as char),
                _ => return Err(self.wrong(format!("`{word}…` is too long for a number"))),
            }
        }
        Ok(if word.is_empty() { None } else { Some(word) })
    }

    /// The next bytes; `None` at the end.
    fn bytes<const N: usize>(&mut self) -> Result<Option<[u8; N]>> {
        let mut bytes = [0; N];
        for (i, byte) in bytes.iter_mut().enumerate() {
            match self.byte()? {
                Some(b) => *byte = b,
                None if i == 0 => return Ok(None),
                None => return Err(self.wrong("the input ends within a number")),
            }
        }
        Ok(Some(bytes))
    }

    fn byte(&mut self) -> Result<Option<u8>> {
        loop {
            match self.input.fill_buf() {
                Ok(bytes) => {
                    let byte = bytes.first().copied();
                    self.input.consume(byte.is_some() as usize);
                    return Ok(byte);
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return Err(Error::new(format!("{}: {e}", self.place()))),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_are_read_in_every_form() {
        let rays: [[f64; 6]; 2] = [[0.0, -1.5, 2.0, 0.25, 0.0, -1.0], [1.0; 6]];
        let text = "0 -1.5\t2e0\r\n.25 0 -1\n\n1 1 1 1 1 1";
        let single: Vec<u8> = rays.iter().flatten().flat_map(|&v| (v as f32).to_ne_bytes()).collect();
        let double: Vec<u8> = rays.iter().flatten().flat_map(|v| v.to_ne_bytes()).collect();
        for (bytes, form) in [(text.as_bytes(), Form::Ascii), (&single, Form::Single), (&double, Form::Double)] {
            assert_eq!(read(Reader::new(bytes, form)).unwrap(), rays);
        }
    }

    #[test]
    fn rays_may_come_in_pieces() {
        let text = "0 -1.5\t2e0\r\n.25 0 -1\n\n1 1 1 1 1 1 ";
        let single: Vec<u8> = (0..12).flat_map(|v| (v as f32).to_ne_bytes()).collect();
        for (bytes, form) in [(text.as_bytes(), Form::Ascii), (&single, Form::Single)] {
            let whole = read(Reader::new(bytes, form)).unwrap();
            assert_eq!(whole.len(), 2);
            for size in 1..bytes.len() {
                let pieces = std::io::BufReader::with_capacity(size, bytes);
                assert_eq!(read(Reader::new(pieces, form)).unwrap(), whole, "{size}");
            }
        }
    }

    fn read(mut reader: Reader<impl BufRead>) -> Result<Vec<[f64; 6]>> {
        let mut rays = Vec::new();
        reader.read(&mut rays, usize::MAX)?;
        Ok(rays)
    }

    #[test]
    fn no_more_rays_are_read_than_asked_for_and_none_behind_one_without_direction() {
        let numbers = [1.0f32, 1.0, 1.0, 0.0, 1.0, 1.0];
        let (text, single) = (
            numbers.map(|v| format!("{v} {v} {v} {v} {v} {v}\n")).concat(),
            numbers.iter().flat_map(|v| [v.to_ne_bytes(); 6]).flatten().collect::<Vec<u8>>(),
        );
        for (bytes, form) in [(text.as_bytes(), Form::Ascii), (&single[..], Form::Single)] {
            let mut reader = Reader::new(bytes, form);
            let counts = [(); 4].map(|()| {
                let mut rays = Vec::new();
                reader.read(&mut rays, 3).unwrap();
                rays.len()
            });
            assert_eq!(counts, [3, 1, 2, 0]);
        }
    }

    #[test]
    fn what_is_no_ray_is_an_error_with_its_number() {
        for (text, wanted) in [
            ("0 0 0 0 0 1 2 3", "<stdin>: ray 2: the input ends after 2 of its 6 numbers"),
            ("0 0 x", "<stdin>: ray 1: `x` is not a number; a ray is an origin and a direction, six words of text (-fa)"),
            ("nan", "`nan` is not a number"),
        ] {
            let error = read(Reader::new(text.as_bytes(), Form::Ascii)).unwrap_err();
            assert!(error.message.contains(wanted), "{}", error.message);
        }
        let error = read(Reader::new(&[1; 26][..], Form::Single)).unwrap_err();
        assert!(error.message.contains("<stdin>: ray 2: the input ends within a number"), "{}", error.message);
    }

    #[test]
    fn formats_are_one_letter_or_two() {
        use Form::*;
        for (letters, input, output) in [("a", Ascii, Ascii), ("fc", Single, Color), ("da", Double, Ascii)] {
            assert_eq!(Format::of(letters).unwrap(), Format { input, output });
        }
        assert!(["", "c", "cf", "afd", "x"].into_iter().all(|letters| Format::of(letters).is_err()));
    }
}
