//! RADIANCE's generators, run in the process: arguments in, the scene text that the original prints out, with its digits.

mod boxes;
mod curve;
mod daylight;
mod prism;
mod rev;
mod sky;
mod sun;
mod surf;
mod worm;

use super::printf::g;
use crate::error::{Error, Result};
use crate::rad::{Quoted, real};
use crate::vector::Vec3;
use std::fmt::Write;

/// Most surfaces that one generator makes.
const SURFACE_LIMIT: usize = 4_000_000;

/// Reads a file that an argument names; the flag tells whether it is looked for along `RAYPATH`.
pub type Read<'a> = &'a dyn Fn(&str, bool) -> Result<String>;

/// Whether `words`, a program and its arguments, is a generator with options that are known here.
pub fn is_known(words: &[String]) -> bool {
    words.first().is_some_and(|program| beyond(program).is_some()) && foreign(words).is_none()
}

/// The options of a generator that the original has beside those known here; `None` if it is none.
fn beyond(program: &str) -> Option<&'static [&'static str]> {
    Some(match program {
        "genbox" => &["-n", "-s", "-o"],
        "genprism" => &["-"],
        "gendaylit" => &["-L", "-l", "-i", "-C", "-n"],
        "gensurf" => &["-o"],
        "genrev" | "genworm" | "gensky" => &[],
        _ => return None,
    })
}

/// Which option of a generator, a program and its arguments, only the original has.
pub fn foreign(words: &[String]) -> Option<&str> {
    let (program, arguments) = words.split_first()?;
    let has = |option: &str| arguments.iter().any(|a| a == option);
    // A round box seen from inside is a mesh of its own.
    let inward = (program == "genbox" && has("-i") && has("-r")).then_some("-i with -r");
    beyond(program)?.iter().copied().find(|option| has(option)).or(inward)
}

/// What the generator `program` prints for `arguments`. An error is one that the original would report too.
pub fn generate(program: &str, arguments: &[String], read: Read) -> Result<String> {
    let printed = match program {
        "genbox" => boxes::genbox(arguments),
        "genprism" => prism::genprism(arguments, read),
        "genrev" => rev::genrev(arguments, read),
        "genworm" => worm::genworm(arguments, read),
        "gensurf" => surf::gensurf(arguments, read),
        "gensky" => sky::gensky(arguments),
        _ => daylight::gendaylit(arguments),
    };
    printed.map_err(|e| Error { message: format!("{program}: {}", e.message), ..e })
}

/// Scene text that grows surface by surface, all of one modifier and with names that begin alike.
struct Printer<'a> {
    modifier: &'a str,
    name: &'a str,
    text: String,
}

impl<'a> Printer<'a> {
    fn new(modifier: &'a str, name: &'a str) -> Self {
        Self { modifier, name, text: String::new() }
    }

    /// A surface named `name.suffix` with these points, then these numbers.
    fn surface(&mut self, kind: &str, suffix: impl std::fmt::Display, points: &[Vec3], numbers: &[f64]) {
        let name = format!("{}.{suffix}", self.name);
        let _ = write!(self.text, "\n{} {kind} {}\n0\n0\n{}\n", Quoted(self.modifier), Quoted(&name), points.len() * 3 + numbers.len());
        for p in points {
            let _ = writeln!(self.text, "\t{} {} {}", g(p.x, 12), g(p.y, 12), g(p.z, 12));
        }
        if !numbers.is_empty() {
            let numbers: Vec<String> = numbers.iter().map(|&x| g(x, 12)).collect();
            let _ = writeln!(self.text, "\t{}", numbers.join(" "));
        }
    }
}

/// The number that stands at an option's place.
fn number(option: &str, word: Option<&String>) -> Result<f64> {
    word.and_then(|w| real(w)).ok_or_else(|| Error::new(format!("`{option}` needs a number")))
}
