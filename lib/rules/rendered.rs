//! How a picture was rendered, by its header, and what that means for whoever recovers a material from it.

mod reckoning;
mod release;
mod shortcuts;

use super::defaults::{SIZE, radiances};
use crate::color::Rgb;
use crate::picture::command_words;
pub use reckoning::{Reckoning, Typed};
pub use shortcuts::{guesses_bounces, otherwise, shortcuts};
use std::str::FromStr;

/// A command in a picture's header: the program's name without its directory, and its options.
pub struct Command<'a>(Vec<&'a str>);

impl<'a> Command<'a> {
    /// What a line of a header says.
    pub fn of(line: &'a str) -> Self {
        Self(command_words(line))
    }

    /// The last of these programs in the lines of a header; `None` if it is none of them that made the picture.
    fn last(lines: impl IntoIterator<Item = &'a str>, programs: &[&str]) -> Option<Self> {
        lines.into_iter().map(Self::of).filter(|command| programs.contains(&command.program())).last()
    }

    /// The program; empty in an empty line.
    pub fn program(&self) -> &str {
        self.0.first().copied().unwrap_or_default()
    }

    /// The word after an option, or after its `=`, if it is given.
    pub fn word(&self, name: &str) -> Option<&str> {
        match self.after(name) {
            Some(words) => words.first().copied(),
            None => self.0.iter().rev().find_map(|word| word.strip_prefix(name)?.strip_prefix('=')),
        }
    }

    /// What follows an option, if it is given.
    fn after(&self, name: &str) -> Option<&[&'a str]> {
        self.0.iter().rposition(|word| *word == name).map(|at| &self.0[at + 1..])
    }

    /// The colour that an option has, if it is given.
    fn color(&self, name: &str) -> Option<Rgb> {
        let number = |word: &&str| word.parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
        let numbers: Vec<f64> = self.after(name)?.iter().take(3).map_while(number).collect();
        <[f64; 3]>::try_from(numbers).ok().map(Rgb::from)
    }

    /// Whether an option is on that is if it is not given: by itself it turns to the other, and by what follows it on or off.
    fn on(&self, name: &str) -> bool {
        self.0.iter().filter_map(|word| word.strip_prefix(name)).fold(true, |on, rest| match rest.as_bytes() {
            [] => !on,
            [b'+' | b'1' | b'y' | b'Y' | b't' | b'T'] => true,
            [b'-' | b'0' | b'n' | b'N' | b'f' | b'F'] => false,
            _ => on,
        })
    }

    /// By how many times `-x /N` makes a picture smaller, if it says so.
    pub fn times<N: FromStr>(&self) -> Option<N> {
        self.word("-x")?.strip_prefix('/')?.parse().ok()
    }

    /// The number that an option has, if it is given.
    pub fn given(&self, name: &str) -> Option<f64> {
        self.word(name)?.parse().ok()
    }

    /// How often light bounces, if that is said: never without samples of it.
    fn bounces(&self) -> Option<f64> {
        if self.given("-ad") == Some(0.0) { Some(0.0) } else { self.given("-ab") }
    }

    /// What one of RADIANCE's programs takes for an option that is not given.
    fn default(&self, name: &str) -> f64 {
        radiances(name)[(self.program() == "rpict") as usize]
    }

    /// Whether it is this project's, which leaves nothing out that it is not asked to.
    fn is_ours(&self) -> bool {
        self.program() == "rtrace-rs"
    }

    /// The number that an option has, and the words for it; `None` if it has none.
    fn option(&self, name: &str) -> Option<(f64, String)> {
        match self.given(name) {
            Some(value) => Some((value, format!("{name} {value}"))),
            None if self.is_ours() => None,
            None => Some((self.default(name), format!("{name} {}, its default", self.default(name)))),
        }
    }
}

/// The programs that render pictures.
const PROGRAMS: [&str; 3] = ["rpict", "rtrace", "rtrace-rs"];

/// The width, height and aspect of pixels that the last rpict in the lines of a header was asked for, and by how many times `pfilt -x /N` made the
/// picture smaller since; `None` if it did not.
pub fn reduced<'a>(lines: impl IntoIterator<Item = &'a str>) -> Option<([f64; 3], usize)> {
    let mut reduced = None;
    for command in lines.into_iter().map(Command::of) {
        match command.program() {
            "rpict" => {
                reduced = Some((
                    [("-x", SIZE as f64), ("-y", SIZE as f64), ("-pa", 1.0)].map(|(name, default)| command.given(name).unwrap_or(default)),
                    1,
                ))
            }
            "pfilt" => {
                reduced = reduced.map(|(size, before)| (size, usize::saturating_mul(before, command.times().unwrap_or(1))));
            }
            _ => {}
        }
    }
    reduced.filter(|(_, times)| *times > 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn how_much_smaller_a_rendering_was_made_is_read_off_its_header() {
        let lines = ["oconv a.rad", "rpict -x 400 -y 320 a.oct", "VIEW= -vtv", "", "pfilt -1 -x /2 -y /2", "\tpfilt -x /2 -y /2"];
        assert_eq!(reduced(lines), Some(([400.0, 320.0, 1.0], 4)));
        assert_eq!(reduced(lines[..3].iter().copied()), None);
        assert_eq!(reduced(["pfilt -x /2"]), None);
    }
}
