//! One number of one modifier changed: `ID:PARAM=VALUE`; or its type.

use super::{Document, Number, Primitive, Statement, lex, real};
use crate::error::{Error, Result};
use std::ops::Range;

/// Does what `setting` says, `ID:PARAM=VALUE`, in the last of `documents` that defines a modifier of that name. PARAM is a
/// parameter's name (`rough`) or number (`a5`).
pub fn set(documents: &mut [Document], setting: &str) -> Result<()> {
    let form = || Error::new(format!("`{setting}` is not of the form ID:PARAM=VALUE, for instance horse:rough=0.1"));
    let (place, value) = setting.rsplit_once('=').ok_or_else(form)?;
    let (name, parameter) = place.rsplit_once(':').ok_or_else(form)?;
    let value = real(value).ok_or_else(|| Error::new(format!("`{setting}`: `{value}` is not a number")))?;
    let found = documents.iter_mut().rev().find(|d| d.primitives().any(|p| is_modifier_named(p, name)));
    let document = found.ok_or_else(|| nothing_called(name))?;
    let primitives: Vec<&Primitive> = document.primitives().filter(|p| is_modifier_named(p, name)).collect();
    if let Some(alias) = primitives.last().filter(|p| p.kind == "alias") {
        let target = alias.strings.first().map_or("", String::as_str);
        return Err(alias.name_error(format!("`{name}` is an alias and has no numbers of its own; set `{target}:{parameter}={value}`")));
    }
    let Some(known) = primitives.last().and_then(|p| p.type_of()) else { return Err(form()) };
    let index = known.parameter(parameter).ok_or_else(|| {
        let names = if known.parameters.is_empty() { "a1, a2…".into() } else { known.parameters.join(", ") };
        Error::new(format!("`{setting}`: {} has no parameter `{parameter}`; it has {names}", known.name))
    })?;
    document.set(name, index, value)
}

impl Document {
    /// Gives real argument `index` of the last modifier called `name` the value `value`; nothing else changes in print.
    pub fn set(&mut self, name: &str, index: usize, value: f64) -> Result<()> {
        let place = self.statements.iter_mut().rev().find_map(|s| match s {
            Statement::Primitive(p) if is_modifier_named(p, name) => Some(p),
            _ => None,
        });
        let Some(primitive) = place else { return Err(nothing_called(name)) };
        if index >= primitive.reals.len() {
            return Err(primitive.error(format!("`{name}` has {} real arguments, not {}", primitive.reals.len(), index + 1)));
        }
        let word = primitive.real_span(index);
        primitive.reals[index] = value;
        self.changes.insert(word.start, (word.end, Number(value).to_string()));
        Ok(())
    }

    /// The document with the last modifier called `name` of another type: without string arguments, with the real arguments `reals`. Those
    /// that have the value of the one in their place before keep its spelling.
    pub fn retyped(&self, name: &str, kind: &str, reals: &[f64]) -> Result<Self> {
        let place = self.primitives().filter(|p| is_modifier_named(p, name)).last();
        let primitive = place.filter(|p| p.kind != "alias").ok_or_else(|| nothing_called(name))?;
        let words = words(&self.source.text, primitive);
        let mut changed = self.clone();
        let mut put = |place: Range<usize>, text: String| changed.changes.insert(place.start, (place.end, text));
        // Modifier, type, name, number of strings, strings, number of integers, number of reals, reals.
        let (strings, counts) = (&words[3..4 + primitive.strings.len()], &words[4 + primitive.strings.len()..]);
        put(words[1].clone(), kind.into());
        put(strings[0].start..strings[strings.len() - 1].end, "0".into());
        put(counts[1].clone(), reals.len().to_string());
        let old = &counts[2..];
        for (i, &real) in reals.iter().enumerate().filter(|(i, real)| primitive.reals.get(*i).is_some_and(|old| old != *real)) {
            put(old[i].clone(), Number(real).to_string());
        }
        let end = counts[counts.len() - 1].end;
        if reals.len() < old.len() {
            put(counts[1 + reals.len()].end..end, String::new());
        } else if reals.len() > old.len() {
            put(end..end, reals[old.len()..].iter().map(|&real| format!(" {}", Number(real))).collect());
        }
        Self::read(&self.source.name, changed.bytes())
    }
}

/// Where the words of a statement stand.
fn words(text: &str, primitive: &Primitive) -> Vec<Range<usize>> {
    let mut rest = &text[primitive.span.start..primitive.span.end];
    let mut words = Vec::new();
    while let Ok((after, word)) = lex::word(rest) {
        words.push(primitive.span.end - word.at.len()..primitive.span.end - after.len());
        rest = after;
    }
    words
}

fn nothing_called(name: &str) -> Error {
    Error::new(format!("no modifier is called `{name}`"))
}

fn is_modifier_named(primitive: &Primitive, name: &str) -> bool {
    primitive.name == name && primitive.type_of().is_some_and(|t| t.is_modifier())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;

    #[test]
    fn settings_name_parameters_in_words_or_by_number() {
        let text = "void trans a:b 0 0 7 1 1 1 0 .1 .5 .5\nvoid plastic p 0 0 5 1 1 1 0 0\nvoid metal p 0 0 5 1 1 1 0 0\n";
        let mut documents = [text, "p sphere p 0 0 4 0 0 0 1"].map(|t| Document::parse(Source::new("t.rad", t)).unwrap());
        set(&mut documents, "a:b:tspec=.25").unwrap();
        set(&mut documents, "p:a4=1e-3").unwrap();
        assert_eq!(
            documents[0].bytes(),
            text.replace(".5\n", "0.25\n").replace("metal p 0 0 5 1 1 1 0", "metal p 0 0 5 1 1 1 0.001").as_bytes()
        );
        let mut alias = [Document::parse(Source::new("t.rad", "void metal m 0 0 5 1 1 1 0 0 void alias al m")).unwrap()];
        let said = set(&mut alias, "al:rough=1").unwrap_err().to_string();
        assert!(said.starts_with("t.rad:1:41: error: `al` is an alias and has no numbers of its own; set `m:rough=1`"), "{said}");
        for wrong in ["p", "p:rough", "p:rough=x", "q:rough=1", "p:ior=1", "p:a6=1", "p:a0=1"] {
            assert!(set(&mut documents, wrong).is_err(), "{wrong}");
        }
    }
    #[test]
    fn another_type_keeps_all_that_stands_around_it() {
        let becomes = |text: &str, kind: &str, reals: &[f64]| {
            let document = Document::parse(Source::new("t.rad", text)).unwrap().retyped("p", kind, reals).unwrap();
            let last = document.primitives().filter(|p| p.name == "p" && p.kind == kind).last().unwrap();
            assert_eq!((last.reals.as_slice(), last.strings.len()), (reals, 0));
            String::from_utf8(document.bytes()).unwrap()
        };
        let plastic = "# a\nvoid plastic p\n0\n0\n5\t.50 .5\n  5e-1 0 .10 # z\np sphere s 0 0 4 0 0 0 1\n";
        assert_eq!(becomes(plastic, "metal", &[0.5, 0.5, 0.5, 0.0, 0.1]), plastic.replace("plastic", "metal"));
        let glass = becomes(plastic, "glass", &[0.5, 0.25, 0.5]);
        assert_eq!(glass, plastic.replace("plastic", "glass").replace("5\t.50 .5", "3\t.50 0.25").replace(" 0 .10", ""));
        let trans = becomes(plastic, "trans", &[0.5, 0.5, 0.5, 0.0, 0.1, 1.0, 0.5]);
        assert_eq!(trans, plastic.replace("plastic", "trans").replace("5\t", "7\t").replace(".10", ".10 1 0.5"));
        let anisotropic = "void plastic2 p 4 0 'a b' 1 . 0 6 1 1 1 0 .1 .2";
        assert_eq!(becomes(anisotropic, "plastic", &[1.0, 1.0, 1.0, 0.0, 0.1]), "void plastic p 0 0 5 1 1 1 0 .1");
    }
}
