//! The syntax of scene files (`.rad`), read without loss: what was not changed is printed byte for byte.

mod bytes;
mod json;
mod lex;
mod likely;
mod links;
mod parse;
mod print;
mod set;
mod types;

pub use bytes::{decode, encode};
pub use json::json;
pub use lex::{is_space, real, word};
pub use likely::{Undefined, likely};
pub use links::{Link, Links, WEIGHT_LIMIT};
pub use print::{Number, Quoted};
pub use set::set;
pub use types::{Class, Reals, TYPES, Type};

use crate::error::{Error, Result, Source, Span};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// One primitive, as written.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// The name of its modifier; `void` when it has none.
    pub modifier: String,
    /// RADIANCE's name of its type: `plastic`, `mesh`, `alias`…
    pub kind: String,
    /// Its identifier.
    pub name: String,
    /// String arguments. An alias has one, its target.
    pub strings: Vec<String>,
    /// Real arguments.
    pub reals: Vec<f64>,
    /// The whole statement.
    pub span: Span,
    /// Where each word begins in the source: modifier, type, name, the strings as written, the reals as written.
    words: Arc<[u32]>,
}

/// What is wrong with a text that is no scene description from its beginning on.
fn foreign(text: &str) -> Option<&'static str> {
    let is_picture = || text.lines().take_while(|line| !line.is_empty()).any(|line| line.starts_with("FORMAT=32-bit_rle_"));
    if text.starts_with('\u{feff}') {
        Some("the file begins with a byte order mark, which RADIANCE takes for a part of the first word; save it as UTF-8 without one")
    } else if text.starts_with("#?RADIANCE") && is_picture() || text.starts_with("v/1\u{1}") {
        Some("this is a picture, not a scene description; name the scene here (a picture to compare with is `anneal --target`)")
    } else {
        None
    }
}

/// After so many errors no more are looked for.
pub const ERROR_LIMIT: usize = 1000;

/// One statement of a scene file.
#[derive(Clone, Debug)]
pub enum Statement {
    /// `#` to the end of the line.
    Comment(Span),
    /// `!` to the end of the line, with the lines it continues on.
    Command(Span),
    /// Modifier, type, identifier and arguments.
    Primitive(Primitive),
}

/// A scene file: its statements, and all that stands between them.
#[derive(Clone, Debug)]
pub struct Document {
    /// The text.
    pub source: Arc<Source>,
    /// The statements, in order.
    pub statements: Vec<Statement>,
    /// Words that were changed, by their first byte: what to print in place of which stretch.
    changes: BTreeMap<usize, (usize, String)>,
}

/// Whether that is the name of a file of a mesh.
fn is_mesh(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|end| ["obj", "rtm"].iter().any(|mesh| end.eq_ignore_ascii_case(mesh)))
}

impl Document {
    /// The statements of `source`, or the first error.
    pub fn parse(source: Arc<Source>) -> Result<Self> {
        let (document, errors) = Self::parse_some_errors(source, 1);
        errors.into_iter().next().map_or(Ok(document), Err)
    }

    /// The statements that could be read, and what is wrong with the others.
    pub fn parse_all_errors(source: Arc<Source>) -> (Self, Vec<Error>) {
        Self::parse_some_errors(source, ERROR_LIMIT)
    }

    fn parse_some_errors(source: Arc<Source>, limit: usize) -> (Self, Vec<Error>) {
        if let Some(problem) = foreign(&source.text) {
            let error = Span::new(&source, 0, source.text.chars().next().map_or(0, char::len_utf8)).error(problem);
            return (Self { source, statements: vec![], changes: BTreeMap::new() }, vec![error]);
        }
        let (statements, mut errors) = parse::statements(&source, limit);
        if !errors.is_empty() && is_mesh(&source.name) {
            let remedy = format!("a mesh is no scene; name it in one: MODIFIER mesh NAME 1 {} 0 0", source.name);
            errors = vec![Error::new(format!("{}: {remedy}", source.name))];
        }
        (Self { source, statements, changes: BTreeMap::new() }, errors)
    }

    /// The statements of a file's bytes, whatever their encoding.
    pub fn read(name: &str, bytes: Vec<u8>) -> Result<Self> {
        Self::parse(Source::new(name, decode(bytes)))
    }

    /// The primitives that are written in it.
    pub fn primitives(&self) -> impl Iterator<Item = &Primitive> {
        self.statements.iter().filter_map(|s| if let Statement::Primitive(p) = s { Some(p) } else { None })
    }

    /// The file: byte for byte as it was read, except for the changed words.
    pub fn bytes(&self) -> Vec<u8> {
        let (text, mut out, mut done) = (&self.source.text, String::with_capacity(self.source.text.len() + 16), 0);
        for (&start, (end, word)) in &self.changes {
            out.push_str(&text[done..start]);
            out.push_str(word);
            done = *end;
        }
        out.push_str(&text[done..]);
        encode(&out)
    }
}

impl Primitive {
    /// Its type's entry in [`TYPES`]; `None` only for a primitive that was not parsed.
    pub fn type_of(&self) -> Option<&'static Type> {
        Type::named(&self.kind)
    }

    /// Errors unless it has as many arguments as its type takes; strings that it does not take are passed over, as by RADIANCE.
    pub fn complete(&self) -> Result<()> {
        let Some(&Type { name, strings: (least, most), .. }) = self.type_of() else { return Ok(()) };
        let strings = self.strings.len();
        if strings < least {
            let needed = if most == least { least.to_string() } else { format!("{least} or more") };
            return Err(self.error(format!("{name} needs {needed} string arguments, not {strings}")));
        }
        self.complete_reals()
    }

    /// Errors if it has not as many real arguments as its type takes.
    pub fn complete_reals(&self) -> Result<()> {
        self.type_of().map_or(Ok(()), |kind| kind.takes(self.reals.len())).map_err(|message| self.error(message))
    }

    /// An error at the statement's type.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.word_span(1).error(message)
    }

    /// An error at its modifier.
    pub fn modifier_error(&self, message: impl Into<String>) -> Error {
        self.word_span(0).error(message)
    }

    /// An error at its name.
    pub fn name_error(&self, message: impl Into<String>) -> Error {
        self.word_span(2).error(message)
    }

    /// An error at string argument `i`, counted from 0. At the type, if a transform added that word.
    pub fn string_error(&self, i: usize, message: impl Into<String>) -> Error {
        self.word_span(if i < self.written_strings() { 3 + i } else { 1 }).error(message)
    }

    /// The error, at string argument `i` if it has no place yet.
    pub fn at_string(&self, i: usize, error: Error) -> Error {
        if error.place.is_some() { error } else { self.string_error(i, error.message) }
    }

    /// An error at real argument `i`, counted from 0.
    pub fn real_error(&self, i: usize, message: impl Into<String>) -> Error {
        self.real_span(i).error(message)
    }

    fn real_span(&self, i: usize) -> Span {
        self.word_span(if i < self.reals.len() { 3 + self.written_strings() + i } else { 1 })
    }

    /// How many strings the source has: `xform` may have added transform words to them.
    fn written_strings(&self) -> usize {
        self.words.len().saturating_sub(3 + self.reals.len())
    }

    /// Where a word of it is: its modifier is the first, its type the second.
    pub fn word_span(&self, i: usize) -> Span {
        let source = &self.span.source;
        let Some(&start) = self.words.get(i) else { return self.span.clone() };
        let rest = source.text.get(start as usize..).unwrap_or("");
        let end = word(rest).map_or(source.text.len(), |(rest, _)| source.text.len() - rest.len());
        Span::new(source, start as usize, end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(text: &str) -> Result<Document> {
        Document::parse(Source::new("t.rad", text))
    }

    fn message(text: &str) -> String {
        parse(text).map(|_| String::new()).unwrap_or_else(|e| e.to_string())
    }

    #[test]
    fn statements_are_read_whatever_the_line_breaks() {
        let d = parse("# c\r\n void plastic\nred 0 0\n5 .7 .1 .1 0 0 # after\n!echo a \\\n b\nvoid alias x red inherit alias y x").unwrap();
        let kinds: Vec<_> = d.primitives().map(|p| format!("{} {} {} {:?} {:?}", p.modifier, p.kind, p.name, p.strings, p.reals)).collect();
        assert_eq!(kinds, ["void plastic red [] [0.7, 0.1, 0.1, 0.0, 0.0]", "void alias x [\"red\"] []", "inherit alias y [\"x\"] []"]);
        assert!(matches!(&d.statements[3], Statement::Command(s) if &s.source.text[s.start..s.end] == "!echo a \\\n b"));
    }

    #[test]
    fn errors_point_at_the_word_and_say_what_to_do() {
        let wrong = message("void plastic red 0 0 5 1 1 1 0\nred sphere s 0 0 4 0 0 0 1\n");
        assert!(wrong.starts_with("t.rad:2:1: error: expected real argument 5 of 5, found `red`; correct it or the count"), "{wrong}");
        assert!(message("void plastik a 0 0 0").contains("unknown type `plastik`; `plastic` is one"));
        let mesh = Document::read("parts/bunny.obj", b"v 0 0 1\nv 0 1 0\n".to_vec()).unwrap_err();
        assert_eq!(mesh.message, "parts/bunny.obj: a mesh is no scene; name it in one: MODIFIER mesh NAME 1 parts/bunny.obj 0 0");
        assert!(message("void ligth a 0 0 0").contains("unknown type `ligth`; `light` is one"));
        assert!(message("void plastic a 0 1 3 0").contains("integer arguments"));
        assert!(message("void plastic a -1 0 0").contains("cannot be negative"));
        assert!(message("void plastic a 4.0 0 0").contains("found `4.0`"));
        assert!(message("a b").contains("the text ends inside the statement `a b`"));
        assert!(message("void sphere b # c\n0 0 4 0 0 0 1").contains("found `#`"));
    }

    #[test]
    fn all_errors_are_found_in_one_reading() {
        let text = "void plastic a 0 0 x\nvoid metal b 0 0 5 1 1 1 0 0\nb spere c 0 0 4 0 0 0 1\nb sphere d 0 0 4 0 0 0 1\n";
        let (document, errors) = Document::parse_all_errors(Source::new("t.rad", text));
        assert_eq!((document.statements.len(), errors.len()), (2, 2));
    }

    #[test]
    fn setting_a_number_changes_only_that_word() {
        let mut d = parse("# red\nvoid plastic \"a b\" 0 0 5\t.7  .1 .1 0 0 # end\n").unwrap();
        d.set("a b", 4, 0.125).unwrap();
        d.set("a b", 0, 0.5).unwrap();
        assert_eq!(d.bytes(), b"# red\nvoid plastic \"a b\" 0 0 5\t0.5  .1 .1 0 0.125 # end\n");
        assert!(d.set("a b", 5, 0.0).is_err() && d.set("c", 0, 0.0).is_err());
    }

    #[test]
    fn a_count_does_not_allocate() {
        assert!(message("void plastic a 99999999999 b").contains("the text ends inside"));
        assert!(message("void plastic a 0 0 99999999999 1").contains("the text ends inside"));
    }

    proptest! {
        #[test]
        fn any_text_is_read_without_panic(text in "[#!a \"'\n0-9.e+-]{0,80}|\\PC{0,40}") {
            let (document, _) = Document::parse_all_errors(Source::new("t", text.clone()));
            prop_assert_eq!(document.bytes(), encode(&text));
        }

        #[test]
        fn what_is_printed_reads_back_the_same(
            words in proptest::collection::vec("[a-z#!\"' \n\u{e9}]{0,8}", 1..6),
            reals in proptest::collection::vec(proptest::num::f64::NORMAL | proptest::num::f64::ZERO, 0..9),
        ) {
            let mut primitive = parse("void polygon p 0 0 0").unwrap().primitives().next().unwrap().clone();
            primitive.modifier = words[0].clone();
            primitive.strings = words;
            primitive.reals = reals;
            let again = parse(&primitive.to_string()).unwrap().primitives().next().unwrap().clone();
            prop_assert_eq!((&again.modifier, &again.strings, &again.reals), (&primitive.modifier, &primitive.strings, &primitive.reals));
        }
    }
}
