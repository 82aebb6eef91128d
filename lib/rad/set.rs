//! One number of one modifier changed: `ID:PARAM=VALUE`.

use super::{Document, Primitive, Statement, real};
use crate::error::{Error, Result};

/// Does what `setting` says, `ID:PARAM=VALUE`, in the last of `documents` that defines a modifier of that name. PARAM is a
/// parameter's name (`rough`) or number (`a5`).
pub fn set(documents: &mut [Document], setting: &str) -> Result<()> {
    let form = || Error::new(format!("`{setting}` is not of the form ID:PARAM=VALUE, for instance horse:rough=0.1"));
    let (place, value) = setting.rsplit_once('=').ok_or_else(form)?;
    let (name, parameter) = place.rsplit_once(':').ok_or_else(form)?;
    let value = real(value).ok_or_else(|| Error::new(format!("`{setting}`: `{value}` is not a number")))?;
    let found = documents.iter_mut().rev().find(|d| d.primitives().any(|p| is_modifier_named(p, name)));
    let document = found.ok_or_else(|| Error::new(format!("no modifier is called `{name}`")))?;
    let primitives: Vec<&Primitive> = document.primitives().filter(|p| is_modifier_named(p, name)).collect();
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
        let Some(primitive) = place else { return Err(Error::new(format!("no modifier is called `{name}`"))) };
        if index >= primitive.reals.len() {
            return Err(primitive.error(format!("`{name}` has {} real arguments, not {}", primitive.reals.len(), index + 1)));
        }
        let word = primitive.real_span(index);
        primitive.reals[index] = value;
        self.changes.insert(word.start, (word.end, super::Number(value).to_string()));
        Ok(())
    }
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
        for wrong in ["p", "p:rough", "p:rough=x", "q:rough=1", "p:ior=1", "p:a6=1", "p:a0=1"] {
            assert!(set(&mut documents, wrong).is_err(), "{wrong}");
        }
    }
}
