//! From the words of a primitive to a pattern: which are expressions, functions, files, transform.

use super::frame::Frame;
use super::mapping::Mapping;
use super::raster::Raster;
use super::table::Table;
use super::{Apply, Expressions, Kind};
use crate::cal::{FileId, Library, Program, Written};
use crate::error::{Result, Span};
use crate::rad::Primitive;
use crate::resolve::Resolve;
use crate::transform::Transform;
use crate::vector::Vec3;
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What the patterns of a scene share.
pub struct Sources<'r> {
    /// The function files read so far, and the initialization file.
    pub library: Library,
    resolve: &'r dyn Resolve,
    pictures: HashMap<String, Arc<Raster>>,
    tables: HashMap<String, Arc<Table>>,
    known: Known,
}

/// What functions compile to that need not be evaluated.
struct Known {
    /// `noop` of each of three values, of the first of three, of one.
    keep: Option<Program>,
    keep_first: Option<Program>,
    keep_one: Option<Program>,
    /// `red green blue` of three values.
    at_least_zero: Option<Program>,
}

impl<'r> Sources<'r> {
    /// Nothing read yet; files will come from `resolve`.
    pub fn new(resolve: &'r dyn Resolve) -> Self {
        let mut library = Library::new();
        let mut program = |names: &[(&'static str, &'static [usize])], parameters| {
            let names: Vec<(Written, &[usize])> = names.iter().map(|(name, list)| ((*name, None), *list)).collect();
            library.functions(FileId::GLOBAL, &names, parameters, &[]).ok()
        };
        let all: &[usize] = &[0, 1, 2];
        let known = Known {
            keep: program(&[("noop", &[0]), ("noop", &[1]), ("noop", &[2])], 3),
            keep_first: program(&[("noop", &[0])], 3),
            keep_one: program(&[("noop", &[0])], 1),
            at_least_zero: program(&[("red", all), ("green", all), ("blue", all)], 3),
        };
        Self { library, resolve, pictures: HashMap::new(), tables: HashMap::new(), known }
    }

    fn picture(&mut self, name: &str) -> Result<Arc<Raster>> {
        if let Some(known) = self.pictures.get(name) {
            return Ok(known.clone());
        }
        let raster = Arc::new(Raster::read(&self.resolve.library(name)?, name)?);
        self.pictures.insert(name.to_string(), raster.clone());
        Ok(raster)
    }

    fn table(&mut self, name: &str) -> Result<Arc<Table>> {
        if let Some(known) = self.tables.get(name) {
            return Ok(known.clone());
        }
        let table = Arc::new(Table::read(&self.resolve.library(name)?, name)?);
        self.tables.insert(name.to_string(), table.clone());
        Ok(table)
    }
}

fn same(known: &Option<Program>, program: &Program) -> bool {
    known.as_ref() == Some(program)
}

/// What a primitive of one of these types says; `None` for other types.
pub(super) fn compile(primitive: &Primitive, sources: &mut Sources, types: &[&str]) -> Result<Option<Expressions>> {
    if !types.contains(&primitive.kind.as_str()) {
        return Ok(None);
    }
    let mut words = Words { primitive, sources };
    let (kind, used) = words.kind()?;
    let frame = Frame::new(&words.transform(used)?);
    Ok(Some(Expressions { frame, kind, place: primitive.span.clone(), name: primitive.name.clone(), failed: AtomicBool::new(false) }))
}

/// The frame of a BRTDfunc, its coefficients of the mirror direction and of the straight one, its functions for light sources. What is
/// written as 0 is `None`.
#[allow(clippy::type_complexity)]
pub(super) fn functions(primitive: &Primitive, sources: &mut Sources) -> Result<(Frame, [Option<Program>; 2], [Option<Program>; 3])> {
    let mut words = Words { primitive, sources };
    let zero = |i: usize| primitive.strings.get(i).is_some_and(|s| s == "0");
    let mut straight = [None, None];
    for (way, program) in straight.iter_mut().enumerate() {
        let range = 3 * way..3 * way + 3;
        if !range.clone().all(zero) {
            *program = Some(words.expressions(range, 9)?);
        }
    }
    let mut by_channel = [None, None, None];
    for (i, program) in by_channel.iter_mut().enumerate().filter(|(i, _)| !zero(6 + i)) {
        let file = words.file(9)?;
        let (name, span) = (words.string(6 + i)?, words.span(6 + i));
        *program = Some(words.sources.library.functions(file, &[((name, span.as_ref()), &[0, 1, 2, 3])], 4, &primitive.reals)?);
    }
    Ok((Frame::new(&words.transform(10)?), straight, by_channel))
}

struct Words<'a, 'r> {
    primitive: &'a Primitive,
    sources: &'a mut Sources<'r>,
}

impl<'a> Words<'a, '_> {
    /// The values, and how many strings they take before the transform.
    fn kind(&mut self) -> Result<(Kind, usize)> {
        Ok(match self.primitive.kind.as_str() {
            "brightfunc" => (Self::one(self.expressions(0..1, 1)?), 2),
            "mixfunc" => (Self::one(self.expressions(2..3, 3)?), 4),
            "colorfunc" | "texfunc" | "plastic2" | "metal2" | "trans2" | "ashik2" => {
                let program = self.expressions(0..3, 3)?;
                let constant = program.constant().and_then(|_| program.eval_all(&Default::default()).ok());
                (constant.map_or_else(|| Kind::Three(program), |values| Kind::Constant(Vec3::from_array(values))), 4)
            }
            "colorpict" => {
                let apply = self.three_functions(4)?;
                let (raster, mapping) = self.picture(3)?;
                (Kind::Picture(raster, mapping, apply), 7)
            }
            "mixpict" => {
                let apply = self.one_function(2, 4, 3)?;
                let (raster, mapping) = self.picture(3)?;
                (Kind::Picture(raster, mapping, apply), 7)
            }
            "brightdata" => self.one_table(0)?,
            "mixdata" => self.one_table(2)?,
            _ => self.three_tables()?,
        })
    }

    fn one(program: Program) -> Kind {
        program.constant().map_or_else(|| Kind::One(program), |value| Kind::Constant(Vec3::splat(value)))
    }

    fn one_table(&mut self, function: usize) -> Result<(Kind, usize)> {
        let apply = self.one_function(function, function + 2, 1)?;
        let table = self.table(function + 1)?;
        let end = function + 3 + table.dimensions();
        let coordinates = self.expressions(function + 3..end, function + 2)?;
        Ok((Kind::OneTable(table, coordinates, apply), end))
    }

    fn three_tables(&mut self) -> Result<(Kind, usize)> {
        let apply = self.three_functions(6)?;
        let tables = [self.table(3)?, self.table(4)?, self.table(5)?];
        let end = 7 + tables.iter().map(|table| table.dimensions()).max().unwrap_or(0);
        let coordinates = self.expressions(7..end, 6)?;
        Ok((Kind::ThreeTables(tables, coordinates, apply), end))
    }

    /// The picture whose name is string `i`, the function file and the two expressions behind it.
    fn picture(&mut self, i: usize) -> Result<(Arc<Raster>, Mapping)> {
        let mapping = Mapping::recognize(self.expressions(i + 2..i + 4, i + 1)?);
        let name = self.string(i)?.to_string();
        let raster = self.sources.picture(&name).map_err(|error| self.primitive.at_string(i, error))?;
        Ok((raster, mapping))
    }

    fn table(&mut self, i: usize) -> Result<Arc<Table>> {
        let name = self.string(i)?.to_string();
        self.sources.table(&name).map_err(|error| self.primitive.at_string(i, error))
    }

    /// The program of the expressions in these strings, with the function file in string `file`.
    fn expressions(&mut self, range: std::ops::Range<usize>, file: usize) -> Result<Program> {
        let file = self.file(file)?;
        let strings: Vec<(&str, Option<Span>)> = range.map(|i| Ok((self.string(i)?, self.span(i)))).collect::<Result<_>>()?;
        let written: Vec<Written> = strings.iter().map(|(text, span)| (*text, span.as_ref())).collect();
        self.sources.library.compile(file, &written, &self.primitive.reals)
    }

    /// What the functions in the first three strings make of three values: the first takes all three, the others too if they have as many parameters, or
    /// are of a texture; else their own.
    fn three_functions(&mut self, file: usize) -> Result<Apply> {
        let file = self.file(file)?;
        let names = [self.string(0)?, self.string(1)?, self.string(2)?];
        let spans = [0, 1, 2].map(|i| self.span(i));
        let texture = self.primitive.kind == "texdata";
        let library = &mut self.sources.library;
        let lists: [&[usize]; 3] = std::array::from_fn(|i| match (i, library.parameters(names[i], file)) {
            (1.., Some(..=2)) if !texture => std::slice::from_ref(&[0, 1, 2][i]),
            _ => &[0, 1, 2],
        });
        let functions: [(Written, &[usize]); 3] = std::array::from_fn(|i| ((names[i], spans[i].as_ref()), lists[i]));
        let program = library.functions(file, &functions, 3, &self.primitive.reals)?;
        let known = &self.sources.known;
        Ok(if same(&known.keep, &program) {
            Apply::Keep
        } else if same(&known.at_least_zero, &program) {
            Apply::AtLeastZero
        } else {
            Apply::Three(program)
        })
    }

    /// What the function in string `i` makes of as many values.
    fn one_function(&mut self, i: usize, file: usize, values: usize) -> Result<Apply> {
        let file = self.file(file)?;
        let (name, span) = (self.string(i)?, self.span(i));
        let list: &[usize] = if values == 3 { &[0, 1, 2] } else { &[0] };
        let program = self.sources.library.functions(file, &[((name, span.as_ref()), list)], values, &self.primitive.reals)?;
        let known = &self.sources.known;
        Ok(if same(&known.keep_one, &program) || same(&known.keep_first, &program) {
            Apply::Keep
        } else if values == 3 {
            Apply::OneOfThree(program)
        } else {
            Apply::One(program)
        })
    }

    fn file(&mut self, i: usize) -> Result<FileId> {
        let name = self.string(i)?.to_string();
        self.sources.library.load(&name, self.sources.resolve).map_err(|error| self.primitive.at_string(i, error))
    }

    /// Where string `i` stands.
    fn span(&self, i: usize) -> Option<Span> {
        self.primitive.string_error(i, "").place
    }

    fn string(&self, i: usize) -> Result<&'a str> {
        self.primitive.strings.get(i).map(String::as_str).ok_or_else(|| {
            let kind = &self.primitive.kind;
            let found = self.primitive.strings.len();
            self.primitive.error(format!("{kind} needs more than {found} string arguments: {}", arguments(kind)))
        })
    }

    /// The transform behind the first `used` strings. As in RADIANCE, words before its first `-` mean nothing.
    fn transform(&self, used: usize) -> Result<Transform> {
        let words = &self.primitive.strings;
        let Some(start) = (used..words.len()).find(|&i| words[i].starts_with('-')) else { return Ok(Transform::IDENTITY) };
        Transform::of(self.primitive, start)
    }
}

/// The string arguments of a type.
fn arguments(kind: &str) -> &'static str {
    match kind {
        "brightfunc" => "expression, function file, transform",
        "colorfunc" => "expressions for red, green and blue, function file, transform",
        "texfunc" => "expressions for x, y and z, function file, transform",
        "plastic2" | "metal2" | "trans2" | "ashik2" => "expressions for ux, uy and uz, function file, transform",
        "colorpict" => "functions for red, green and blue, picture, function file, expressions for u and v, transform",
        "brightdata" => "function, data file, function file, an expression for each dimension of the data, transform",
        "colordata" | "texdata" => {
            "three functions, three data files, function file, an expression for each dimension of the data, transform"
        }
        "mixfunc" => "foreground, background, expression, function file, transform",
        "BRTDfunc" => {
            "three expressions for reflection, three for transmission, three functions for light sources, function file, transform"
        }
        "mixpict" => "foreground, background, function, picture, function file, expressions for u and v, transform",
        _ => "foreground, background, function, data file, function file, an expression for each dimension of the data, transform",
    }
}
