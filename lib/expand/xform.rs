//! `xform`: moves primitives, renames them, turns them inside out, repeats them.

use super::shell::quoted;
use super::{Annotation, Command, Item, Step, Stop};
use crate::error::{Error, Result};
use crate::rad::{Class, Number, Primitive, real};
use crate::transform::Transform;
use crate::vector::Vec3;

/// Most words of one command once its arrays are written out: half a million copies.
const WORD_LIMIT: usize = 4_000_000;

/// What one `xform` command asks for.
pub struct Xform {
    /// Whether commands in the input are run (`-e`) or only get an `xform` of their own appended (`-c`).
    pub expand: bool,
    /// The copies to make of the input.
    pub copies: Vec<Copy>,
    /// The files to read; none means standard input.
    pub files: Vec<String>,
}

/// One copy of the input.
pub struct Copy {
    prefix: Option<String>,
    modifier: Option<String>,
    invert: bool,
    words: Vec<String>,
    transform: Transform,
}

impl Xform {
    /// Reads the command's arguments; `argument_file` gives the text of the file that `-f` names.
    pub fn parse(arguments: &[String], argument_file: impl Fn(&str) -> Result<String>) -> Step<Self> {
        let (mut expand, mut invert, mut prefixes, mut modifier, mut at) = (true, false, Vec::new(), None, 0);
        while let Some(option) = arguments.get(at) {
            match (option.as_str(), arguments.get(at + 1)) {
                ("-e", _) => expand = true,
                ("-c", _) => expand = false,
                ("-I", _) => invert = true,
                ("-n", Some(name)) => prefixes.push(name.clone()),
                ("-m", Some(name)) => modifier = Some(name.clone()),
                _ => break,
            }
            at += if matches!(option.as_str(), "-n" | "-m") { 2 } else { 1 };
        }
        // Names of copies are built on the name given last; without copies all names given are joined.
        let mut lists = vec![(None, arguments[at..].to_vec())];
        repeat_for_lines(&mut lists, &argument_file)?;
        repeat_for_counts(&mut lists)?;
        let (mut copies, mut files) = (Vec::new(), Vec::new());
        for (id, words) in lists {
            let (transform, used) = Transform::parse(&words).map_err(|e| Error::new(format!("xform: {}", e.message)))?;
            if let Some(word) = words.get(used).filter(|w| w.starts_with('-') && w.len() > 1) {
                return Err(
                    Error::new(format!("xform: `{word}` is no transform; -n, -m, -I, -c and -e must stand before all transforms")).into()
                );
            }
            let prefix = match id {
                None => (!prefixes.is_empty()).then(|| prefixes.join(".")),
                Some((letter, id)) => Some(prefixes.last().map_or(format!("{letter}{id}"), |name| format!("{name}.{id}"))),
            };
            files = words[used..].to_vec();
            copies.push(Copy { prefix, modifier: modifier.clone(), invert, words: words[..used].to_vec(), transform });
        }
        Ok(Self { expand, copies, files })
    }
}

/// The name of a copy (a letter unless a name is given, and a number for each array) and its arguments.
type List = (Option<(char, String)>, Vec<String>);

/// Puts each line of an argument file (`-f file`) in its place, one copy a line.
fn repeat_for_lines(lists: &mut Vec<List>, argument_file: impl Fn(&str) -> Result<String>) -> Step<()> {
    for round in 0.. {
        if !lists.iter().any(|(_, words)| words.iter().any(|w| w == "-f")) {
            break;
        }
        if round == 8 {
            return Err(Error::new("xform: an argument file names an argument file; write all lines into one").into());
        }
        let mut longer = Vec::new();
        for (id, words) in lists.iter() {
            let Some(at) = words.iter().position(|w| w == "-f") else {
                longer.push((id.clone(), words.clone()));
                continue;
            };
            let name = words.get(at + 1).ok_or_else(|| Error::new("xform: `-f` needs the name of a file"))?;
            let text = argument_file(name)?;
            let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
            for (i, line) in lines.enumerate() {
                let mut copy = words.clone();
                copy.splice(at..at + 2, line.split_whitespace().map(String::from));
                longer.push((extended(id, 'i', i), copy));
                limit(longer.len(), words.len())?;
            }
        }
        *lists = longer;
    }
    Ok(())
}

/// Puts `-i 0`, `-i 1`… in place of each array (`-a n`), the first outermost.
fn repeat_for_counts(lists: &mut Vec<List>) -> Step<()> {
    while lists.iter().any(|(_, words)| words.iter().any(|w| w == "-a")) {
        let mut longer = Vec::new();
        for (id, words) in lists.iter() {
            let Some(at) = words.iter().position(|w| w == "-a") else {
                longer.push((id.clone(), words.clone()));
                continue;
            };
            let count = words.get(at + 1).and_then(|w| w.parse().ok()).filter(|&n: &usize| n > 0);
            let count = count.ok_or_else(|| Error::new("xform: `-a` needs a count, 1 or more"))?;
            limit(count.saturating_mul(lists.len()), words.len())?;
            for i in 0..count {
                let mut copy = words.clone();
                copy[at] = "-i".into();
                copy[at + 1] = i.to_string();
                longer.push((extended(id, 'a', i), copy));
            }
        }
        *lists = longer;
    }
    Ok(())
}

fn extended(id: &Option<(char, String)>, letter: char, i: usize) -> Option<(char, String)> {
    Some(id.as_ref().map_or((letter, i.to_string()), |(letter, name)| (*letter, format!("{name}.{i}"))))
}

fn limit(copies: usize, words: usize) -> Step<()> {
    if copies.saturating_mul(words) > WORD_LIMIT {
        return Err(Stop::Fatal(Error::new(format!("xform: {copies} copies; make a smaller array, or arrays of arrays in files"))));
    }
    Ok(())
}

impl Copy {
    /// The item as this copy has it.
    pub fn of(&self, item: &Item) -> Item {
        match item {
            Item::Primitive(p) => Item::Primitive(self.primitive(p)),
            Item::Annotation(a) => Item::Annotation(self.annotation(a)),
            Item::Command(c) => {
                let mut text = format!("{} | xform -e", c.text);
                let mut option = |words: &[&str]| words.iter().for_each(|w| text += &format!(" {}", quoted(w)));
                if self.invert {
                    option(&["-I"]);
                }
                if let Some(prefix) = &self.prefix {
                    option(&["-n", prefix]);
                }
                if let Some(modifier) = &self.modifier {
                    option(&["-m", modifier]);
                }
                self.words.iter().for_each(|w| option(&[w]));
                Item::Command(Command { text, span: c.span.clone() })
            }
        }
    }

    fn primitive(&self, old: &Primitive) -> Primitive {
        let mut p = old.clone();
        let (t, reals) = (&self.transform, &mut p.reals);
        let prefixed = |name: &str| self.prefix.as_ref().map_or(name.into(), |prefix| format!("{prefix}.{name}"));
        let known = old.type_of();
        if known.is_some_and(|k| k.class == Class::Surface) {
            p.name = prefixed(&old.name);
            if let Some(modifier) = &self.modifier {
                p.modifier.clone_from(modifier);
            }
            if self.invert {
                p.kind = inverted(&old.kind).into();
            }
        }
        if known.is_some_and(|k| k.moves_by_words) && !self.words.is_empty() {
            if self.words[0] != "-i" {
                p.strings.extend(["-i".into(), "1".into()]);
            }
            p.strings.extend(self.words.iter().cloned());
        }
        match old.kind.as_str() {
            "polygon" => {
                each(reals, 0.., |v| t.point(v));
                if t.mirrored != self.invert {
                    reals.reverse();
                    reals.chunks_exact_mut(3).for_each(<[f64]>::reverse);
                }
            }
            "sphere" | "bubble" => {
                each(reals, 0..3, |v| t.point(v));
                scale(reals, 3.., t.scale);
            }
            "cone" | "cup" | "cylinder" | "tube" => {
                each(reals, 0..6, |v| t.point(v));
                scale(reals, 6.., t.scale);
            }
            "ring" => {
                each(reals, 0..3, |v| t.point(v));
                each(reals, 3..6, |v| t.vector(if self.invert { -v } else { v }));
                scale(reals, 6.., t.scale);
            }
            "source" => each(reals, 0..3, |v| t.vector(v)),
            "glow" => scale(reals, 3.., t.scale),
            "spotlight" => each(reals, 4..7, |v| t.vector(v)),
            "dielectric" => pass(reals, 0..3, t.scale),
            "interface" => [0..3, 4..7].into_iter().for_each(|media| pass(reals, media, t.scale)),
            "mist" => {
                scale(reals, 0..3, 1.0 / t.scale);
                // The strings name light sources, which are surfaces; those of a relay are joined by `>`.
                if self.prefix.is_some() {
                    p.strings.iter_mut().for_each(|s| *s = s.split('>').map(&prefixed).collect::<Vec<_>>().join(">"));
                }
            }
            "colortext" | "brighttext" | "mixtext" => {
                each(reals, 0..3, |v| t.point(v));
                each(reals, 3..9, |v| t.vector(v));
            }
            _ => {}
        }
        p
    }

    fn annotation(&self, old: &Annotation) -> Annotation {
        let mut a = old.clone();
        if a.word != "probe" {
            return a;
        }
        // The first three words of a probe are a point.
        let numbers: Vec<f64> = a.arguments.iter().take(3).map_while(|w| real(w)).collect();
        if let [x, y, z] = numbers[..] {
            let moved = self.transform.point(Vec3::new(x, y, z));
            for (word, x) in a.arguments.iter_mut().zip(moved.to_array()) {
                *word = Number(x).to_string();
            }
        }
        a
    }
}

fn inverted(kind: &str) -> &str {
    const PAIRS: [(&str, &str); 3] = [("sphere", "bubble"), ("cone", "cup"), ("cylinder", "tube")];
    let other = |&(a, b)| if a == kind { Some(b) } else { Some(a).filter(|_| b == kind) };
    PAIRS.iter().find_map(other).unwrap_or(kind)
}

/// Replaces the triples among the real arguments `range`.
fn each(reals: &mut [f64], range: impl std::slice::SliceIndex<[f64], Output = [f64]>, map: impl Fn(Vec3) -> Vec3) {
    for triple in reals.get_mut(range).unwrap_or_default().chunks_exact_mut(3) {
        // Adding zero makes a negative zero positive.
        triple.copy_from_slice(&(map(Vec3::new(triple[0], triple[1], triple[2])) + Vec3::ZERO).to_array());
    }
}

/// Multiplies the real arguments `range`.
fn scale(reals: &mut [f64], range: impl std::slice::SliceIndex<[f64], Output = [f64]>, factor: f64) {
    reals.get_mut(range).unwrap_or_default().iter_mut().for_each(|x| *x *= factor);
}

/// Of what a unit of a medium lets pass, what one lets pass that is so many times as long.
fn pass(reals: &mut [f64], range: impl std::slice::SliceIndex<[f64], Output = [f64]>, scale: f64) {
    reals.get_mut(range).unwrap_or_default().iter_mut().for_each(|x| *x = x.max(0.0).powf(1.0 / scale));
}
