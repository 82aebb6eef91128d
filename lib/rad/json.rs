//! Primitives as JSON, one object a line.

use super::Primitive;
use super::bytes::readable;
use serde::Serialize;

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

/// The object of a primitive, without the end of the line.
pub fn json(p: &Primitive) -> String {
    let Primitive { modifier, kind, name, strings, reals, .. } = p;
    let (line, _) = p.span.line_column();
    let object = Object { file: &p.span.source.name, line, modifier, kind, id: name, sargs: strings, iargs: [], fargs: reals };
    readable(&serde_json::to_string(&object).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::rad::Document;

    #[test]
    fn an_object_has_all_that_the_statement_has() {
        let text = "void alias a b\n\na brightfunc 'f \" é' 2 sin(x) . 0 2 1 2.5e-9";
        let document = Document::parse(Source::new("t.rad", text)).unwrap();
        let printed: Vec<String> = document.primitives().map(json).collect();
        let first = r#"{"file":"t.rad","line":1,"modifier":"void","type":"alias","id":"a","sargs":["b"],"iargs":[],"fargs":[]}"#;
        let head = r#"{"file":"t.rad","line":3,"modifier":"a","type":"brightfunc","id":"f \" é""#;
        assert_eq!(printed, [first.to_string(), format!(r#"{head},"sargs":["sin(x)","."],"iargs":[],"fargs":[1.0,2.5e-9]}}"#)]);
    }
}
