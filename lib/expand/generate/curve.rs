//! Functions of parameters, as `genrev`, `genworm` and `gensurf` take them: expressions with `-e` and `-f` definitions.

use super::Read;
use crate::cal::{Context, FileId, Library, Program};
use crate::error::{Error, Result, Source};

/// The functions of a generator's command line.
pub struct Functions {
    library: Library,
}

impl Functions {
    /// Takes `-e expression` and `-f file` out of the options; what is left are the others.
    pub fn parse(options: &[String], read: Read) -> Result<(Self, Vec<String>)> {
        let (mut library, mut others) = (Library::stand_alone(), Vec::new());
        let mut options = options.iter();
        while let Some(option) = options.next() {
            let source = match option.as_str() {
                "-e" => options.next().map(|text| Source::new("-e", text.as_str())),
                "-f" => match options.next() {
                    Some(name) => Some(Source::new(name.as_str(), read(name, true)?)),
                    None => None,
                },
                _ => {
                    others.push(option.clone());
                    continue;
                }
            };
            let source = source.ok_or_else(|| Error::new(format!("`{option}` needs an argument")))?;
            library.define(source, FileId::GLOBAL)?;
        }
        Ok((Self { library }, others))
    }

    /// The number that `expression` is, as a count from 1 to `limit`.
    pub fn count(&mut self, expression: &str, limit: usize) -> Result<usize> {
        let program = self.library.compile(FileId::GLOBAL, &[(expression, None)], &[])?;
        let count = program.eval(&Context::default()).map_err(|e| Error::new(format!("`{expression}`: {e}")))? + 0.5;
        if count < 1.0 {
            return Err(Error::new(format!("`{expression}` is no count of segments")));
        }
        if count > limit as f64 {
            return Err(Error::new(format!("`{expression}` is more than {limit} segments")));
        }
        Ok(count as usize)
    }

    /// How many parameters the function of that name has, if it is defined.
    pub fn parameters(&mut self, name: &str) -> Option<usize> {
        self.library.parameters(name, FileId::GLOBAL)
    }

    /// The program of some expressions in the variables `parameters` (`t`, or `s,t`).
    pub fn compile(&mut self, parameters: &str, expressions: &[(&str, &str)]) -> Result<Program> {
        let names: Vec<String> = expressions.iter().map(|(name, _)| format!("curve_{name}")).collect();
        for ((name, expression), function) in expressions.iter().zip(&names) {
            let source = Source::new(format!("{name}({parameters})"), format!("{function}({parameters})={expression};"));
            self.library.define(source, FileId::GLOBAL)?;
        }
        let count = parameters.split(',').count();
        let places: Vec<usize> = (0..count).collect();
        let functions: Vec<_> = names.iter().map(|name| ((name.as_str(), None), &places[..])).collect();
        self.library.functions(FileId::GLOBAL, &functions, count, &[])
    }
}
