//! What went wrong and where: one message, with file, line and column where there are such.

use std::fmt;
use std::sync::{Arc, OnceLock};

/// A text that was read, kept so that errors can point into it.
#[derive(Debug)]
pub struct Source {
    /// The name the user knows it by: a path, `<stdin>`, or the command that printed it.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// The command that printed it, if one did.
    printed_by: Option<Span>,
    /// Where each line begins; found when first asked for.
    lines: OnceLock<Vec<usize>>,
}

impl Source {
    /// A source of that name and text.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        Arc::new(Self { name: name.into(), text: text.into(), printed_by: None, lines: OnceLock::new() })
    }

    /// What a command of that name printed.
    pub fn printed(name: impl Into<String>, text: impl Into<String>, by: &Span) -> Arc<Self> {
        Arc::new(Self { name: name.into(), text: text.into(), printed_by: Some(by.clone()), lines: OnceLock::new() })
    }

    /// Where each line begins.
    fn lines(&self) -> &[usize] {
        self.lines.get_or_init(|| {
            std::iter::once(0).chain(self.text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1)).collect()
        })
    }
}

/// A stretch of a source, in bytes. Line and column are counted only when an error is printed.
#[derive(Clone, Debug)]
pub struct Span {
    /// Where the text stands.
    pub source: Arc<Source>,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// Whether it is the same stretch of the same text.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.source, &other.source) && (self.start, self.end) == (other.start, other.end)
    }

    /// The stretch `start..end` of `source`.
    pub fn new(source: &Arc<Source>, start: usize, end: usize) -> Self {
        Self { source: source.clone(), start, end }
    }

    /// Line and column (in characters), both from 1.
    pub fn line_column(&self) -> (usize, usize) {
        let at = self.start.min(self.source.text.len());
        let line = self.source.lines().partition_point(|&begin| begin <= at);
        let before = &self.source.text.as_bytes()[self.source.lines()[line - 1]..at];
        (line, String::from_utf8_lossy(before).chars().count() + 1)
    }

    /// Where somebody wrote it: here, or in the command that printed it.
    pub fn written(&self) -> &Self {
        self.source.printed_by.as_ref().map_or(self, Self::written)
    }

    /// `file:line:column` of where somebody wrote it, and which line of what is printed there it is in, if it is in one.
    fn said(&self) -> (String, String) {
        let written = self.written();
        let (line, column) = written.line_column();
        let printed = self.source.printed_by.as_ref().map(|_| format!(" (in line {} of what this prints)", self.line_column().0));
        (format!("{}:{line}:{column}", shortened(&printable(&written.source.name))), printed.unwrap_or_default())
    }

    /// An error at this place. The message says what is wrong and, where known, what to do about it.
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error { message: message.into(), place: Some(self.clone()) }
    }
}

/// What went wrong, for a person to read.
#[derive(Clone, Debug)]
pub struct Error {
    /// What is wrong and what to do about it; one line, no full stop, no file name.
    pub message: String,
    /// Where, if it is in a text.
    pub place: Option<Span>,
}

/// A result whose error can be shown to the user as it is.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// An error without a place in a text. Name the file in the message.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), place: None }
    }

    /// `file:line:column: message`, for what is no error but a warning.
    pub fn remark(&self) -> String {
        let Some(place) = &self.place else { return self.message.clone() };
        let (at, printed) = place.said();
        format!("{at}: {}{printed}", self.message)
    }
}

impl From<String> for Error {
    fn from(message: String) -> Self {
        Self::new(message)
    }
}

impl std::error::Error for Error {}

impl fmt::Display for Error {
    /// `file:line:column: error: message`, then the line and a caret under the place; control characters are escaped, what is very long
    /// is cut.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let message = shortened(&printable(&self.message));
        let Some(place) = &self.place else { return write!(f, "error: {message}") };
        let (at, printed) = place.said();
        write!(f, "{at}: error: {message}{printed}")?;
        let place = place.written();
        let (line, column) = place.line_column();
        let Some(text) = place.source.text.get(place.source.lines()[line - 1]..).and_then(|rest| rest.lines().next()) else {
            return Ok(());
        };
        // Show at most a screen's width around the place.
        let skip = (column - 1).saturating_sub(60);
        let shown: String = text.chars().skip(skip).take(120).collect();
        let marked = place.source.text.get(place.start..place.end).unwrap_or_default();
        let width = marked.chars().take_while(|c| !c.is_whitespace()).count();
        let caret = "^".repeat(width.clamp(1, 60));
        write!(f, "\n  {}\n  {}{caret}", printable(&shown), " ".repeat(column - 1 - skip))
    }
}

/// The most characters of a message, or of a name, that are shown.
const SHOWN: usize = 480;

/// The text, or its beginning and its end: words of the input may be of any length.
fn shortened(text: &str) -> String {
    let count = text.chars().count();
    if count <= SHOWN {
        return text.into();
    }
    let (begin, end) = (SHOWN * 3 / 4, SHOWN / 4 - 1);
    text.chars().take(begin).chain(['…']).chain(text.chars().skip(count - end)).collect()
}

/// The text with control characters made visible, so that a hostile name cannot drive the terminal.
fn printable(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c == '\t' {
                " ".into()
            } else if c.is_control() {
                c.escape_default().to_string()
            } else {
                c.to_string()
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_shows_file_line_column_and_caret() {
        let source = Source::new("room.rad", "void plastic red\n0\n0\n5 .7 x.1 .1 0 0\n");
        let at = source.text.find("x.1").unwrap();
        let error = Span::new(&source, at, at + 3).error("not a number");
        assert_eq!(error.to_string(), "room.rad:4:6: error: not a number\n  5 .7 x.1 .1 0 0\n       ^^^");
    }

    #[test]
    fn what_is_very_long_is_cut() {
        assert_eq!(shortened(&"x".repeat(SHOWN)).chars().count(), SHOWN);
        let cut = shortened(&format!("a{}ö", "x".repeat(100_000)));
        assert!(cut.starts_with("axx") && cut.ends_with("xö") && cut.contains('…') && cut.chars().count() == SHOWN, "{cut}");
    }
}
