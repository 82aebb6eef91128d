//! Primitives as JSON, one object a line.

use super::Primitive;
use crate::error::Source;
use serde::Serialize;
use std::sync::Arc;

/// The lines of a list of primitives, written one after the other.
#[derive(Default)]
pub struct JsonLines {
    /// Where lines were last counted: the source, a byte in it, and the line there.
    counted: Option<(Arc<Source>, usize, usize)>,
}

#[derive(Serialize)]
struct Object<'a> {
    file: &'a str,
    line: usize,
    modifier: &'a str,
    #[serde(rename = "type")]
    kind: &'a str,
    id: &'a str,
    sargs: &'a [String],
    iargs: [i64; 0],
    fargs: &'a [f64],
}

impl JsonLines {
    /// The object of a primitive, without the end of the line.
    pub fn line(&mut self, p: &Primitive) -> String {
        let line = self.number(&p.span.source, p.span.start);
        let Primitive { modifier, kind, name, strings, reals, .. } = p;
        let object = Object { file: &p.span.source.name, line, modifier, kind, id: name, sargs: strings, iargs: [], fargs: reals };
        serde_json::to_string(&object).unwrap_or_default()
    }

    /// The line of a byte; counts on from the byte before, if it is in the same source.
    fn number(&mut self, source: &Arc<Source>, at: usize) -> usize {
        let (from, line) = match &self.counted {
            Some((known, byte, line)) if Arc::ptr_eq(known, source) && *byte <= at => (*byte, *line),
            _ => (0, 1),
        };
        let line = line + source.text.as_bytes()[from..at].iter().filter(|&&b| b == b'\n').count();
        self.counted = Some((source.clone(), at, line));
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rad::Document;

    #[test]
    fn an_object_has_all_that_the_statement_has() {
        let text = "void alias a b\n\na brightfunc 'f \" é' 2 sin(x) . 0 2 1 2.5e-9";
        let document = Document::parse(Source::new("t.rad", text)).unwrap();
        let mut lines = JsonLines::default();
        let printed: Vec<String> = document.primitives().map(|p| lines.line(p)).collect();
        let first = r#"{"file":"t.rad","line":1,"modifier":"void","type":"alias","id":"a","sargs":["b"],"iargs":[],"fargs":[]}"#;
        let head = r#"{"file":"t.rad","line":3,"modifier":"a","type":"brightfunc","id":"f \" é""#;
        assert_eq!(printed, [first.to_string(), format!(r#"{head},"sargs":["sin(x)","."],"iargs":[],"fargs":[1.0,2.5e-9]}}"#)]);
    }
}
