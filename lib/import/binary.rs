//! RADIANCE's binary helpers (filefmts): big-endian integers, 5-byte floats, strings that end with a zero byte; octree cells and scenes
//! made of them.

use super::error;
use crate::error::{Error, Result, Source};
use crate::rad::{Document, Number, Quoted, decode};
use std::fmt::Write;

/// What every RADIANCE header begins with.
pub const SIGNATURE: &[u8] = b"#?RADIANCE\n";

/// The longest string: a command line of a scene file.
const LONGEST: usize = 2047;
/// The longest text that a scene is written out to: so many bytes, or so many times the file, where a name and a number take a few bytes each.
const MOST_TEXT: usize = 1 << 20;
const MOST_TIMES: usize = 64;

/// Bytes being read, front to back.
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    name: &'a str,
    /// Bytes per object number.
    pub object_width: usize,
}

impl<'a> Reader<'a> {
    /// A reader of a whole file.
    pub fn new(bytes: &'a [u8], name: &'a str) -> Self {
        Self { bytes, at: 0, name, object_width: 4 }
    }

    /// An error at the present place.
    pub fn error(&self, message: impl std::fmt::Display) -> Error {
        error(self.name, format!("{message} (byte {})", self.at))
    }

    /// Skips the text header, which must name this format.
    pub fn header(&mut self, format: &str) -> Result<()> {
        let mut found = None;
        loop {
            let rest = &self.bytes[self.at..];
            let Some(end) = rest.iter().position(|&b| b == b'\n') else { return Err(self.error("no header; is this a RADIANCE file?")) };
            let line = &rest[..end];
            if self.at == 0 && line != &SIGNATURE[..SIGNATURE.len() - 1] {
                return Err(self.error("does not begin with #?RADIANCE"));
            }
            self.at += end + 1;
            if let Some(value) = line.strip_prefix(b"FORMAT=") {
                found = Some(String::from_utf8_lossy(value.trim_ascii()).into_owned());
            }
            if line.is_empty() {
                break;
            }
        }
        match found {
            Some(found) if found == format => Ok(()),
            Some(found) => Err(error(self.name, format!("its format is {found}, not {format}"))),
            None => Err(error(self.name, format!("its header names no format, not even {format}"))),
        }
    }

    /// Reads the number that tells the format and the width of object numbers.
    pub fn magic(&mut self, base: i64) -> Result<()> {
        match self.integer(2)? - base {
            width @ 1..=8 => self.object_width = width as usize,
            _ => return Err(self.error("wrong magic number; the file is damaged or of an unknown version")),
        }
        Ok(())
    }

    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let taken = self.at.checked_add(count).and_then(|end| self.bytes.get(self.at..end));
        let taken = taken.ok_or_else(|| self.error("the file ends too early"))?;
        self.at += count;
        Ok(taken)
    }

    /// A signed integer of that many bytes, at most 8.
    #[inline]
    pub fn integer(&mut self, width: usize) -> Result<i64> {
        let bytes = self.take(width)?;
        let sign = if bytes.first().is_some_and(|b| b & 0x80 != 0) { -1 } else { 0 };
        Ok(bytes.iter().fold(sign, |n, &b| n << 8 | i64::from(b)))
    }

    /// An integer that counts something.
    pub fn count(&mut self, width: usize) -> Result<usize> {
        usize::try_from(self.integer(width)?).map_err(|_| self.error("a count is negative"))
    }

    /// One byte.
    pub fn byte(&mut self) -> Result<u8> {
        Ok(self.take(1)?[0])
    }

    /// A number of an object: `None` for void.
    pub fn object(&mut self) -> Result<Option<usize>> {
        Ok(usize::try_from(self.integer(self.object_width)?).ok())
    }

    /// A float: a 31-bit mantissa and an exponent.
    pub fn float(&mut self) -> Result<f64> {
        let (mantissa, exponent) = (self.integer(4)?, self.integer(1)? as i32);
        if mantissa == 0 {
            return Ok(0.0);
        }
        let middle = mantissa as f64 + if mantissa < 0 { -0.5 } else { 0.5 };
        Ok(middle / 2147483647.0 * f64::from(exponent).exp2())
    }

    /// A string, of at most [`LONGEST`] bytes: a few bytes of the file may make many copies of it.
    pub fn string(&mut self) -> Result<String> {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().take(LONGEST + 1).position(|&b| b == 0);
        let end = end.ok_or_else(|| self.error(format!("a string has no end within {LONGEST} bytes")))?;
        self.at += end + 1;
        Ok(decode(rest[..end].to_vec()))
    }

    /// A number written as a string.
    pub fn decimal(&mut self) -> Result<f64> {
        let text = self.string()?;
        text.trim().parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| self.error(format!("`{text}` is not a number")))
    }

    /// Skips the cells of an octree.
    pub fn skip_cells(&mut self) -> Result<()> {
        let mut open = 1usize;
        while open > 0 {
            open -= 1;
            match self.byte()? {
                0 => {}
                1 => {
                    let objects = self.count(self.object_width)?;
                    self.take(objects.saturating_mul(self.object_width))?;
                }
                2 => open += 8,
                kind => return Err(self.error(format!("an octree cell is of unknown kind {kind}"))),
            }
        }
        Ok(())
    }

    /// The scene that follows, as text would describe it.
    pub fn scene(&mut self) -> Result<Document> {
        let mut types = Vec::new();
        loop {
            let name = self.string()?;
            if name.is_empty() {
                break;
            }
            types.push(name);
        }
        let mut text = String::new();
        let mut names: Vec<String> = Vec::new();
        // Writing to a string cannot fail.
        while let Ok(kind) = usize::try_from(self.integer(1)?) {
            let kind = types.get(kind).ok_or_else(|| self.error(format!("primitive {} is of unknown type {kind}", names.len())))?;
            let modifier = match self.object()? {
                None => "void",
                Some(i) => names.get(i).ok_or_else(|| self.error(format!("primitive {} has a later one as modifier", names.len())))?,
            };
            let name = self.string()?;
            let strings = (0..self.count(2)?).map(|_| self.string()).collect::<Result<Vec<_>>>()?;
            let count = self.count(2)?;
            if kind == "alias" {
                // One without target is another name for its modifier.
                let (modifier, target) = strings.first().map_or(("inherit", modifier), |target| (modifier, target));
                let _ = writeln!(text, "{} alias {} {}", Quoted(modifier), Quoted(&name), Quoted(target));
            } else {
                let _ = write!(text, "{} {} {}\n{}", Quoted(modifier), Quoted(kind), Quoted(&name), strings.len());
                for string in &strings {
                    let _ = write!(text, " {}", Quoted(string));
                }
                let _ = write!(text, "\n0\n{count}");
                for _ in 0..count {
                    let _ = write!(text, " {}", Number(self.float()?));
                }
                text.push('\n');
            }
            names.push(name);
            if text.len() > MOST_TEXT.max(MOST_TIMES * self.bytes.len()) {
                return Err(self.error("the scene in it repeats names that are too long"));
            }
        }
        let document = Document::parse(Source::new(format!("{} (the scene in it)", self.name), text))?;
        if document.primitives().count() != names.len() {
            return Err(self.error("the scene in it has names or arguments that no scene file can have"));
        }
        Ok(document)
    }
}
