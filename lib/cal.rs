//! The `.cal` language of RADIANCE's function files: from text to numbers.
//!
//! A [`Library`] takes definitions ([`Library::load`], [`Library::define`]) and compiles expressions that use them to a [`Program`]: all names
//! looked up, all calls expanded, constants folded. A program is evaluated for a [`Context`]: the ray variables and the variables the
//! caller sets. A result that does not exist is an error, never a NaN.
//!
//! ```
//! use inverad::cal::{Context, FileId, Library};
//! let mut library = Library::stand_alone();
//! let t = library.variable("t");
//! library.define(inverad::error::Source::new("-e", "wave(x) = sin(2*3.14159265*x)/2;"), FileId::GLOBAL).unwrap();
//! let program = library.compile(FileId::GLOBAL, &[("1 + wave(t)", None)], &[]).unwrap();
//! let mut free = [0.0];
//! free[t] = 0.25;
//! assert!((program.eval(&Context { free: &free, ..Default::default() }).unwrap() - 1.5).abs() < 1e-9);
//! ```

mod emit;
mod functions;
mod graph;
mod lower;
mod noise;
mod parse;
mod run;
mod shipped;

pub use run::Program;
pub use shipped::shipped;

use crate::error::{Error, Result, Source, Span};
use crate::resolve::Resolve;
use crate::vector::Vec3;
use functions::Builtin;
use lower::{Function, Lowering};
use parse::{Expression, Fault, Statement, Target};
use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

/// What a program may read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Context<'a> {
    /// The values of `$1`, `$2`, …: the ray variables in the order of [`Ray`], or the input of a filter. Those beyond have no value.
    pub channels: &'a [f64],
    /// The values of the variables made by [`Library::variable`], by their numbers.
    pub free: &'a [f64],
}

/// The ray variables, in the frame of the modifier that is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Ray([f64; 37]);

impl Ray {
    /// Where `Dx` stands, the direction of travel; y and z follow. The numbers are those of the channels, less one.
    pub const DIRECTION: usize = 0;
    /// `Nx`, the surface normal.
    pub const NORMAL: usize = 3;
    /// `Px`, the point that is hit.
    pub const POINT: usize = 6;
    /// `T`, the distance from the eye.
    pub const DISTANCE: usize = 9;
    /// `Rdot`, the cosine between normal and ray, positive where the surface faces the viewer.
    pub const RDOT: usize = 10;
    /// `S`, what one world unit measures in the modifier's frame.
    pub const SCALE: usize = 11;
    /// `Tx`, where the world's origin falls.
    pub const ORIGIN: usize = 12;
    /// `Ix`, `Jx`, `Kx`, three apart: the images of the world's unit vectors.
    pub const AXES: usize = 15;
    /// `Ts`, the length of this ray (with its shadow parents).
    pub const LENGTH: usize = 24;
    /// `Lu`, `Lv`, the coordinates on a mesh.
    pub const UV: usize = 25;
    /// `NxP`, the perturbed normal: for materials that functions describe.
    pub const PERTURBED_NORMAL: usize = 27;
    /// `RdotP`, the cosine to the perturbed normal.
    pub const PERTURBED_RDOT: usize = 30;
    /// `CrP`, `CgP`, `CbP`, the colour the patterns gave.
    pub const PATTERN_COLOR: usize = 31;
    /// `DxA`, the direction to the light source: for prisms.
    pub const AIM: usize = 34;

    /// Distances 0, scale 1, axes those of the world, and no value for what only some materials have.
    pub fn new(direction: Vec3, normal: Vec3, point: Vec3) -> Self {
        let mut ray = Self([0.0; 37]);
        ray.set(Self::DIRECTION, direction);
        ray.set(Self::NORMAL, normal);
        ray.set(Self::POINT, point);
        ray.0[Self::RDOT] = -direction.dot(normal);
        ray.0[Self::SCALE] = 1.0;
        ray.set(Self::AXES, Vec3::X);
        ray.set(Self::AXES + 3, Vec3::Y);
        ray.set(Self::AXES + 6, Vec3::Z);
        ray.0[Self::PERTURBED_NORMAL..].fill(f64::NAN);
        ray
    }

    /// Sets three variables that follow each other.
    pub fn set(&mut self, first: usize, value: Vec3) {
        self.0[first..first + 3].copy_from_slice(&value.to_array());
    }

    /// Sets one variable.
    pub fn put(&mut self, index: usize, value: f64) {
        self.0[index] = value;
    }

    /// What a program reads of it.
    pub fn context(&self) -> Context<'_> {
        Context { channels: &self.0, free: &[] }
    }
}

/// An evaluation came to no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

impl std::error::Error for Failed {}

impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("no value: a division by zero, an argument outside a function's range, or a recursion without end")
    }
}

/// A function file, as a place where names are looked up first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileId(usize);

impl FileId {
    /// No file: names that all files see.
    pub const GLOBAL: Self = Self(0);
}

/// An expression or a name, and where it was written.
pub type Written<'a> = (&'a str, Option<&'a Span>);

/// Definitions, by name and by file.
pub struct Library {
    symbols: Vec<Symbol>,
    /// By full name: the name, and behind a back quote the context if it is local to a file.
    index: HashMap<String, usize>,
    /// Name and context of each file.
    files: Vec<(String, String)>,
    free: usize,
}

impl Default for Library {
    fn default() -> Self {
        Self::new()
    }
}

impl Library {
    /// What the renderer knows: the functions of the language, the ray variables, and RADIANCE's initialization file.
    pub fn new() -> Self {
        let mut library = Self::stand_alone();
        let own = [
            ("NxP", Ray::PERTURBED_NORMAL),
            ("NyP", Ray::PERTURBED_NORMAL + 1),
            ("NzP", Ray::PERTURBED_NORMAL + 2),
            ("RdotP", Ray::PERTURBED_RDOT),
            ("CrP", Ray::PATTERN_COLOR),
            ("CgP", Ray::PATTERN_COLOR + 1),
            ("CbP", Ray::PATTERN_COLOR + 2),
            ("DxA", Ray::AIM),
            ("DyA", Ray::AIM + 1),
            ("DzA", Ray::AIM + 2),
        ];
        for (name, channel) in own {
            let symbol = library.symbol(name);
            library.symbols[symbol].meaning = Some(Meaning::Channel(channel as u16));
        }
        library.ship("rayinit.cal");
        library
    }

    /// What a filter knows: the functions of the language, `PI` and the curves (`hermite`, `bezier`, `bspline`).
    pub fn stand_alone() -> Self {
        let mut library = Self { symbols: Vec::new(), index: HashMap::new(), files: vec![(".".into(), String::new())], free: 0 };
        library.ship("curves.cal");
        library
    }

    /// Adds the definitions of the function file `name`, once; `.` is no file. Where `resolve` has no such file, one that ships with
    /// the project will do.
    ///
    /// # Errors
    /// The file is not to be found, or its text is not in the language.
    pub fn load(&mut self, name: &str, resolve: &dyn Resolve) -> Result<FileId> {
        if let Some(known) = self.files.iter().position(|(file, _)| file == name) {
            return Ok(FileId(known));
        }
        let text = match (resolve.library(name), shipped(name)) {
            (Ok(bytes), _) => String::from_utf8_lossy(&bytes).into_owned(),
            (Err(_), Some(text)) => text.to_string(),
            (Err(error), None) => return Err(error),
        };
        let context = name.strip_suffix(".cal").unwrap_or(name);
        let context = context.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '_' }).collect();
        self.files.push((name.to_string(), context));
        let file = FileId(self.files.len() - 1);
        self.define(Source::new(name, text), file).inspect_err(|_| _ = self.files.pop())?;
        Ok(file)
    }

    /// Adds definitions, local to a file or global. A name that is defined already gets the new meaning.
    ///
    /// # Errors
    /// The text is not in the language.
    pub fn define(&mut self, source: Arc<Source>, file: FileId) -> Result<()> {
        let text = Text { start: 0, end: source.text.len(), source, whole: None };
        let statements = parse::statements(&text.source.text).map_err(|fault| text.fault(fault))?;
        for mut statement in statements {
            let parameters = statement.parameters.take().unwrap_or_default();
            let function = !parameters.is_empty();
            let mut uses = Vec::new();
            self.bind(&mut statement.body, &parameters, file, &mut uses);
            let symbol = self.symbol(&self.own_name(&statement.name, file));
            statement.parameters = Some(parameters);
            let definition = Arc::new(Definition { statement, uses, text: text.clone() });
            self.symbols[symbol].meaning = Some(if function { Meaning::Function(definition) } else { Meaning::Variable(definition) });
        }
        Ok(())
    }

    /// A variable that the caller sets, seen by all files: its number in [`Context::free`].
    pub fn variable(&mut self, name: &str) -> usize {
        let symbol = self.symbol(name);
        if let Some(Meaning::Free(known)) = self.symbols[symbol].meaning {
            return known;
        }
        self.free += 1;
        self.symbols[symbol].meaning = Some(Meaning::Free(self.free - 1));
        self.free - 1
    }

    /// The program of some expressions, as seen from `file`, for a modifier with these real arguments.
    ///
    /// # Errors
    /// An expression is not in the language, uses what is not defined, or has no value for any ray.
    pub fn compile(&mut self, file: FileId, expressions: &[Written], arguments: &[f64]) -> Result<Program> {
        let mut bound = Vec::new();
        for written in expressions {
            let text = Text::of(*written);
            let mut node = parse::expression(written.0).map_err(|fault| text.fault(fault))?;
            self.bind(&mut node, &[], file, &mut Vec::new());
            bound.push((node, text));
        }
        let mut lowering = Lowering::new(self, arguments);
        let roots = bound.iter().map(|(node, text)| lowering.expression(node, text)).collect::<Result<Vec<_>>>()?;
        lowering.finish(&roots, 0).ok_or_else(|| too_large(expressions))
    }

    /// The program of the functions of these names, each applied to those of the program's `parameters` parameters that are listed
    /// with it (by number).
    ///
    /// # Errors
    /// A name is no function's, or as [`Library::compile`].
    pub fn functions(&mut self, file: FileId, names: &[(Written, &[usize])], parameters: usize, arguments: &[f64]) -> Result<Program> {
        let symbols: Vec<usize> = names.iter().map(|((name, _), _)| self.find(name, file)).collect();
        let mut lowering = Lowering::new(self, arguments);
        let mut roots = Vec::new();
        for (((name, at), list), symbol) in names.iter().zip(symbols) {
            roots.push(lowering.applied(symbol, name, list, &Text::of((name, *at)))?);
        }
        lowering.finish(&roots, parameters).ok_or_else(|| too_large(&names.iter().map(|(written, _)| *written).collect::<Vec<_>>()))
    }

    /// How many parameters the function of that name has, as seen from `file`; `None` if there is no such function.
    pub fn parameters(&mut self, name: &str, file: FileId) -> Option<usize> {
        let symbol = self.find(name, file);
        Some(match self.function_of(symbol)? {
            Function::Builtin(builtin) => builtin.arity(),
            Function::Symbol(symbol) => match &self.symbols[symbol].meaning {
                Some(Meaning::Function(definition)) => definition.parameters().len(),
                _ => return None,
            },
        })
    }

    fn ship(&mut self, name: &'static str) {
        let text = shipped(name).unwrap_or_default();
        let defined = self.define(Source::new(name, text), FileId::GLOBAL);
        debug_assert!(defined.is_ok(), "{name}: {defined:?}");
    }

    /// The symbol of a full name, made if need be.
    fn symbol(&mut self, full: &str) -> usize {
        if let Some(&known) = self.index.get(full) {
            return known;
        }
        self.symbols.push(Symbol { builtin: Builtin::named(full), meaning: None });
        self.index.insert(full.to_string(), self.symbols.len() - 1);
        self.symbols.len() - 1
    }

    /// The full name that a definition of `name` in `file` gets: a back quote at the end makes it global.
    fn own_name(&self, name: &str, file: FileId) -> String {
        let name = name.strip_prefix('`').unwrap_or(name);
        match (name.strip_suffix('`'), self.files[file.0].1.as_str()) {
            (Some(global), _) => global.to_string(),
            (None, "") => name.to_string(),
            (None, context) => format!("{name}`{context}"),
        }
    }

    /// The symbol that `name` means in `file`: its own, unless only a global one is known. A back quote in front forbids the latter.
    fn find(&mut self, name: &str, file: FileId) -> usize {
        let own = self.own_name(name, file);
        if !self.index.contains_key(&own) && !name.starts_with('`') {
            let defined = self.index.get(name).is_some_and(|&symbol| self.symbols[symbol].meaning.is_some());
            if defined || Builtin::named(name).is_some() {
                return self.symbol(name);
            }
        }
        self.symbol(&own)
    }

    /// Looks up every name of an expression, in the order they are written.
    fn bind(&mut self, node: &mut parse::Node, parameters: &[String], file: FileId, uses: &mut Vec<usize>) {
        let name = match &mut node.expression {
            Expression::Number(_) | Expression::Channel(_) => return,
            Expression::Negate(inner) => return self.bind(inner, parameters, file, uses),
            Expression::Sum(first, rest) | Expression::Product(first, rest) => {
                self.bind(first, parameters, file, uses);
                return rest.iter_mut().for_each(|(_, node)| self.bind(node, parameters, file, uses));
            }
            Expression::Power(base, exponent) => {
                self.bind(base, parameters, file, uses);
                return self.bind(exponent, parameters, file, uses);
            }
            Expression::Name(name) => name,
            Expression::Call(name, arguments) => {
                arguments.iter_mut().for_each(|node| self.bind(node, parameters, file, uses));
                name
            }
        };
        name.target = match parameters.iter().position(|parameter| *parameter == name.text) {
            Some(i) => Target::Parameter(i),
            None => {
                let symbol = self.find(&name.text, file);
                uses.push(symbol);
                Target::Symbol(symbol)
            }
        };
    }

    fn is_variable(&self, symbol: usize) -> bool {
        matches!(self.symbols[symbol].meaning, Some(Meaning::Variable(_) | Meaning::Channel(_) | Meaning::Free(_)))
    }

    fn function_of(&self, symbol: usize) -> Option<Function> {
        match (&self.symbols[symbol].meaning, self.symbols[symbol].builtin) {
            (Some(Meaning::Function(_)), _) => Some(Function::Symbol(symbol)),
            (_, builtin) => builtin.map(Function::Builtin),
        }
    }
}

struct Symbol {
    /// The function of the language with that name, if it is a global one.
    builtin: Option<Builtin>,
    meaning: Option<Meaning>,
}

enum Meaning {
    Variable(Arc<Definition>),
    Function(Arc<Definition>),
    Channel(u16),
    Free(usize),
}

struct Definition {
    statement: Statement,
    /// The symbols its body mentions.
    uses: Vec<usize>,
    text: Text,
}

impl Definition {
    fn parameters(&self) -> &[String] {
        self.statement.parameters.as_deref().unwrap_or_default()
    }
}

/// A text that was parsed, as part of what the user wrote.
#[derive(Clone)]
struct Text {
    source: Arc<Source>,
    start: usize,
    end: usize,
    /// What to point at instead, if places in the text are not places in the source.
    whole: Option<Span>,
}

impl Text {
    fn of((text, at): Written) -> Self {
        match at {
            Some(at) if at.source.text.get(at.start..at.end) == Some(text) => {
                Self { source: at.source.clone(), start: at.start, end: at.end, whole: None }
            }
            _ => Self { source: Source::new("expression", text), start: 0, end: text.len(), whole: at.cloned() },
        }
    }

    fn len(&self) -> usize {
        self.end - self.start
    }

    /// An error at the place that has `left` bytes behind it.
    fn error(&self, left: usize, message: impl Into<String>) -> Error {
        if let Some(whole) = &self.whole {
            return whole.error(format!("{} in \"{}\"", message.into(), self.source.text));
        }
        let start = self.end - left.min(self.len());
        let word = self.source.text[start..self.end].chars().take_while(|c| c.is_ascii_alphanumeric() || "_.`".contains(*c)).count();
        Span::new(&self.source, start, start + word.max(1)).error(message)
    }

    fn fault(&self, fault: Fault) -> Error {
        self.error(fault.left, fault.message)
    }
}

fn too_large(written: &[Written]) -> Error {
    match written.first() {
        Some(first) => Text::of(*first).error(first.0.len(), "this expands to too large an expression"),
        None => Error::new("the definitions expand to too large a program"),
    }
}

#[cfg(test)]
mod tests;
