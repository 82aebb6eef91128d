//! Statements as text: canonical, with numbers that read back to the same bits.

use super::Primitive;
use super::lex::is_space;
use std::fmt::{self, Display, Formatter};

impl Display for Primitive {
    /// Modifier, type and name on a line, then a line for each kind of argument; a polygon has a line for each vertex.
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "{} {} {}", Quoted(&self.modifier), Quoted(&self.kind), Quoted(&self.name))?;
        if self.kind == "alias" {
            return writeln!(f, " {}", Quoted(self.strings.first().map_or("void", String::as_str)));
        }
        write!(f, "\n{}", self.strings.len())?;
        for string in &self.strings {
            write!(f, " {}", Quoted(string))?;
        }
        write!(f, "\n0\n{}", self.reals.len())?;
        for (i, &real) in self.reals.iter().enumerate() {
            let separator = if self.kind == "polygon" && i % 3 == 0 { "\n  " } else { " " };
            write!(f, "{separator}{}", Number(real))?;
        }
        writeln!(f)
    }
}

/// A number as the shortest text that reads back to it.
pub struct Number(pub f64);

impl Number {
    /// The number with so many digits, one at the least.
    pub fn rounded(x: f64, digits: usize) -> Self {
        Self(format!("{x:.*e}", digits - 1).parse().unwrap_or(x))
    }
}

impl Display for Number {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        // Whole numbers go without a fraction.
        if self.0.fract() == 0.0 && self.0.abs() < 1e16 { write!(f, "{}", self.0) } else { write!(f, "{:?}", self.0) }
    }
}

/// A word, in quotes if it needs them.
pub struct Quoted<'a>(pub &'a str);

impl Display for Quoted<'_> {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let word = self.0;
        let special = |c: char| is_space(c) || matches!(c, '"' | '\'');
        if !word.is_empty() && !word.contains(special) && !word.starts_with(['#', '!']) {
            return f.write_str(word);
        }
        // Alternate between the two kinds of quotes where the word holds both.
        let mut rest = word;
        loop {
            let quote = if rest.starts_with('"') { '\'' } else { '"' };
            let end = rest.find(quote).unwrap_or(rest.len());
            write!(f, "{quote}{}{quote}", &rest[..end])?;
            rest = &rest[end..];
            if rest.is_empty() {
                return Ok(());
            }
        }
    }
}
