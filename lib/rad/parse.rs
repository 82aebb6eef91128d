//! The grammar of scene files: statements out of words.

use super::lex::{Fault, Parsed, Word, integer, real, space, word};
use super::likely::likely;
use super::types::{TYPES, Type};
use super::{Primitive, Statement};
use crate::error::{Error, Source, Span};
use nom::Parser;
use nom::branch::alt;
use nom::bytes::complete::take_till;
use nom::character::complete::char;
use nom::combinator::recognize;
use nom::sequence::preceded;
use std::sync::Arc;

/// The longest command, in bytes.
const COMMAND_LIMIT: usize = 2047;

/// Statements that would go on beyond the end of the text, after which no more is read: each costs all of the rest.
const UNENDED_LIMIT: usize = 20;

/// The statements of `source`, and what is wrong, up to so many errors: after one, reading goes on at the next line that looks like a statement.
pub fn statements(source: &Arc<Source>, limit: usize) -> (Vec<Statement>, Vec<Error>) {
    let (mut statements, mut errors, mut unended) = (Vec::new(), Vec::new(), 0);
    if source.text.len() >= u32::MAX as usize {
        return (statements, vec![Error::new(format!("{}: larger than 4 GiB; split it", source.name))]);
    }
    let mut rest = source.text.as_str();
    loop {
        rest = space(rest).map_or(rest, |(r, _)| r);
        if rest.is_empty() || errors.len() == limit || unended == UNENDED_LIMIT {
            return (statements, errors);
        }
        match statement(source, rest) {
            Ok((r, statement)) => {
                statements.push(statement);
                rest = r;
            }
            Err(error) => {
                let fault = fault(error);
                unended += usize::from(fault.message.is_empty());
                errors.push(place(source, rest, fault));
                rest = next_statement(rest);
            }
        }
    }
}

fn statement<'a>(source: &Arc<Source>, input: &'a str) -> Parsed<'a, Statement> {
    let span = |text: &str| Span::new(source, offset(source, input), offset(source, input) + text.len());
    alt((
        recognize(preceded(char('#'), line)).map(|text: &str| Statement::Comment(span(text))),
        recognize(preceded(char('!'), command)).map(|text: &str| Statement::Command(span(text))),
        |i| primitive(source, i).map(|(rest, p)| (rest, Statement::Primitive(p))),
    ))
    .parse(input)
}

/// The rest of the line, without its end.
fn line(input: &str) -> Parsed<'_, &str> {
    take_till(|c| c == '\n')(input).map(|(rest, text)| {
        let text = text.strip_suffix('\r').unwrap_or(text);
        (&input[text.len()..], if rest.is_empty() { input } else { text })
    })
}

/// The rest of the line and the lines that it continues on: a backslash before the end of a line does not end a command.
fn command(input: &str) -> Parsed<'_, &str> {
    let mut end = 0;
    loop {
        end += input[end..].find('\n').unwrap_or(input.len() - end);
        let text = input[..end].strip_suffix('\r').unwrap_or(&input[..end]);
        if text.len() > COMMAND_LIMIT {
            return Fault::at(input, format!("command longer than {COMMAND_LIMIT} characters; put it into a script"));
        }
        if !text.ends_with('\\') || end == input.len() {
            return Ok((&input[text.len()..], text));
        }
        end += 1;
    }
}

fn primitive<'a>(source: &Arc<Source>, input: &'a str) -> Parsed<'a, Primitive> {
    let (rest, (modifier, kind, name)) = (word, word, word).parse(input)?;
    let mut words: Vec<u32> = [&modifier, &kind, &name].map(|w| offset(source, w.at) as u32).into();
    let known = Type::named(&kind.text);
    let (mut strings, mut reals) = (Vec::new(), Vec::new());
    let rest = match known {
        None => return Fault::at(kind.at, unknown_type(&kind.text)),
        Some(t) if t.name == "alias" => {
            let (rest, target) = word(rest)?;
            words.push(offset(source, target.at) as u32);
            strings.push(target.text.into_owned());
            rest
        }
        Some(_) => {
            let (mut rest, count) = count(rest, "string")?;
            for _ in 0..count {
                let (r, string) = word(rest)?;
                words.push(offset(source, string.at) as u32);
                strings.push(string.text.into_owned());
                rest = r;
            }
            let (r, integers) = self::count(rest, "integer")?;
            if integers != 0 {
                return Fault::at(space(rest)?.0, "integer arguments are not used by any type: the count must be 0");
            }
            let (mut rest, count) = self::count(r, "real")?;
            reals.reserve_exact(count.min(rest.len() / 2 + 1));
            words.reserve_exact(count.min(rest.len() / 2 + 1));
            for i in 0..count {
                let (r, number) = word(rest)?;
                words.push(offset(source, number.at) as u32);
                match real(&number.text) {
                    Some(x) => reals.push(x),
                    None => return Fault::at(number.at, not_a_real(&number, i, count)),
                }
                rest = r;
            }
            rest
        }
    };
    let span = Span::new(source, words[0] as usize, offset(source, rest));
    Ok((
        rest,
        Primitive {
            modifier: modifier.text.into_owned(),
            kind: kind.text.into_owned(),
            name: name.text.into_owned(),
            strings,
            reals,
            span,
            words: words.into(),
        },
    ))
}

/// The number of arguments of one kind.
fn count<'a>(input: &'a str, kind: &str) -> Parsed<'a, usize> {
    let (rest, word) = word(input)?;
    match integer(&word.text).map(usize::try_from) {
        Some(Ok(count)) => Ok((rest, count)),
        Some(Err(_)) => Fault::at(word.at, format!("the number of {kind} arguments cannot be negative")),
        None => Fault::at(word.at, format!("expected the number of {kind} arguments, found `{}`; check the count before it", word.text)),
    }
}

fn not_a_real(word: &Word, i: usize, count: usize) -> String {
    let text = &word.text;
    if text.starts_with('#') {
        return format!("a comment may not stand inside a primitive; move `{text}…` before or after it");
    }
    format!("expected real argument {} of {count}, found `{text}`; correct it or the count", i + 1)
}

fn unknown_type(name: &str) -> String {
    match likely(name, TYPES.iter().map(|t| t.name)) {
        Some(likely) => format!("unknown type `{name}`; `{likely}` is one"),
        None => format!("unknown type `{name}`; a statement begins with modifier, type and name"),
    }
}

fn fault(error: nom::Err<Fault>) -> Fault {
    match error {
        nom::Err::Error(fault) | nom::Err::Failure(fault) => fault,
        nom::Err::Incomplete(_) => Fault { left: 0, message: String::new() },
    }
}

/// The error of a statement that begins at `input`, with its place in the source.
fn place(source: &Arc<Source>, input: &str, fault: Fault) -> Error {
    let start = offset(source, input);
    let whole = Span::new(source, start, source.text.len());
    if fault.message.is_empty() {
        let name = input.split(super::lex::is_space).filter(|w| !w.is_empty()).take(3).collect::<Vec<_>>().join(" ");
        return whole.error(format!("the text ends inside the statement `{name}`; add the missing words or correct the counts"));
    }
    let at = source.text.len() - fault.left;
    let end = word(&source.text[at..]).map_or(at, |(rest, _)| offset(source, rest));
    Span::new(source, at, end).error(fault.message)
}

/// Where to go on after an error in the statement that begins `input`: a later line that begins like a statement.
fn next_statement(input: &str) -> &str {
    let mut rest = input;
    while let Some(end) = rest.find('\n') {
        rest = &rest[end + 1..];
        let mut words = rest.lines().next().unwrap_or("").split_ascii_whitespace();
        let (first, second, third) = (words.next().unwrap_or(""), words.next().unwrap_or(""), words.next());
        // What is meant for a type may be wrong there too.
        let meant = || third.is_some_and(|name| real(name).is_none()) && likely(second, TYPES.iter().map(|t| t.name)).is_some();
        if first.starts_with(['#', '!']) || first == "void" || Type::named(second).is_some() || meant() {
            return rest;
        }
    }
    ""
}

/// Where `rest`, a tail of the source's text, begins.
fn offset(source: &Source, rest: &str) -> usize {
    source.text.len() - rest.len()
}
