//! Words of a scene file: where each begins and ends, what quotes mean, which are numbers.

use super::bytes;
use nom::IResult;
use nom::bytes::complete::{take_while, take_while1};
use nom::error::{ErrorKind, ParseError};
use std::borrow::Cow;

/// The longest word, in bytes. What follows is the next word, as in RADIANCE.
pub const WORD_LIMIT: usize = 511;

/// What a parser of this room returns: the text left, and the thing parsed.
pub type Parsed<'a, T> = IResult<&'a str, T, Fault>;

/// A grammatical error: its place counted from the end of the text, and its message.
#[derive(Debug, PartialEq)]
pub struct Fault {
    /// Bytes from the place of the error to the end of the text.
    pub left: usize,
    /// What is wrong; empty at the end of the text.
    pub message: String,
}

impl Fault {
    /// A failure at the beginning of `at`.
    pub fn at<T>(at: &str, message: impl Into<String>) -> Parsed<'_, T> {
        Err(nom::Err::Failure(Self { left: at.len(), message: message.into() }))
    }
}

impl ParseError<&str> for Fault {
    fn from_error_kind(input: &str, _: ErrorKind) -> Self {
        Self { left: input.len(), message: String::new() }
    }

    fn append(_: &str, _: ErrorKind, other: Self) -> Self {
        other
    }
}

/// A word: the text that it takes, quotes and all, and what it says.
#[derive(Clone, Debug, PartialEq)]
pub struct Word<'a> {
    /// From the first byte of the word to the end of the text, so that its place can be told.
    pub at: &'a str,
    /// The word without its quotes.
    pub text: Cow<'a, str>,
}

/// Whether `c` separates words: C's `isspace`.
pub fn is_space(c: char) -> bool {
    matches!(c, ' ' | '\t'..='\r')
}

/// White space, perhaps none.
pub fn space(input: &str) -> Parsed<'_, &str> {
    take_while(is_space)(input)
}

/// The next word. At the end of the text a recoverable error without a message.
pub fn word(input: &str) -> Parsed<'_, Word<'_>> {
    let (at, _) = space(input)?;
    let plain: Parsed<&str> = take_while1(|c| !is_space(c) && !is_quote(c))(at);
    match plain {
        Ok((rest, text)) if text.len() <= WORD_LIMIT && !rest.starts_with(is_quote) => Ok((rest, Word { at, text: text.into() })),
        Err(error) if at.is_empty() => Err(error),
        _ => Ok(quoted_word(at)),
    }
}

/// A word with quotes in it, or one that reaches the limit.
fn quoted_word(at: &str) -> (&str, Word<'_>) {
    let (mut text, mut quote, mut room) = (String::new(), None, WORD_LIMIT);
    let mut end = at.len();
    for (i, c) in at.char_indices() {
        match quote {
            Some(q) if c == q => quote = None,
            None if is_quote(c) => quote = Some(c),
            None if is_space(c) => {
                end = i;
                break;
            }
            _ if bytes::width(c) > room => {
                end = i;
                break;
            }
            _ => {
                room -= bytes::width(c);
                text.push(c);
            }
        }
    }
    (&at[end..], Word { at, text: text.into() })
}

fn is_quote(c: char) -> bool {
    matches!(c, '"' | '\'')
}

/// The number that `word` is, if it has the form of a real: sign, digits with at most one point, exponent. Finite.
pub fn real(word: &str) -> Option<f64> {
    let form = word.bytes().all(|b| matches!(b, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'));
    word.parse().ok().filter(|x: &f64| form && x.is_finite())
}

/// The number that `word` is, if it has the form of an integer: sign, digits.
pub fn integer(word: &str) -> Option<i64> {
    word.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(mut text: &str) -> Vec<String> {
        let mut words = Vec::new();
        while let Ok((rest, word)) = word(text) {
            words.push(word.text.into_owned());
            text = rest;
        }
        words
    }

    #[test]
    fn quotes_open_and_close_within_a_word() {
        assert_eq!(words("a\"b c\"d 'x\"y' \"\" z\r\n"), ["ab cd", "x\"y", "", "z"]);
        assert_eq!(words("\"no end "), ["no end "]);
    }

    #[test]
    fn a_long_word_is_cut_after_511_bytes() {
        assert_eq!(words(&"n".repeat(600)).iter().map(String::len).collect::<Vec<_>>(), [511, 89]);
        assert_eq!(words(&"é".repeat(300)).iter().map(String::len).collect::<Vec<_>>(), [510, 90]);
    }

    #[test]
    fn reals_have_the_form_that_radiance_accepts() {
        for good in ["+1.", ".5", "-0", "3E+0", "1e-3", "007"] {
            assert!(real(good).is_some(), "{good}");
        }
        for bad in ["0x1", "inf", "nan", "1,5", ".", "+", "1e", "1e+", "--1", "1_0", "1e999", ""] {
            assert!(real(bad).is_none(), "{bad}");
        }
    }

    #[test]
    fn integers_have_no_point() {
        assert_eq!((integer("+4"), integer("-0"), integer("4.0"), integer("")), (Some(4), Some(0), None, None));
    }
}
