//! Scene descriptions made flat: inline commands are carried out, transforms applied.
//!
//! `xform`, `cat`, `echo` and the generators run inside the process, with pipes between them. Any other command goes to
//! [`Resolve::command`], which decides. As in RADIANCE a command that fails (a missing file, a wrong option) is a warning,
//! and what it printed stays; text that it printed and that cannot be read is an error.

mod generate;
pub mod printf;
mod shell;
mod xform;

use crate::error::{Error, Result, Source, Span};
use crate::rad::{Document, ERROR_LIMIT, Primitive, Statement, decode, word};
use crate::resolve::Resolve;
pub(crate) use shell::quoted;
use shell::{Stage, pipeline};
use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;
use xform::Xform;

/// Files and commands may stand this deep within each other.
const DEPTH_LIMIT: usize = 64;
/// Most commands that one scene may run.
const COMMAND_LIMIT: usize = 1_000_000;
/// Most primitives that commands may make, copies at every level of nesting counted.
const PRIMITIVE_LIMIT: usize = 4_000_000;

/// A description without commands.
#[derive(Clone, Debug, Default)]
pub struct Flat {
    /// The primitives, in the order of the files. Names are not resolved.
    pub primitives: Vec<Primitive>,
    /// The annotations, moved by the transforms that they stood under.
    pub annotations: Vec<Annotation>,
    /// What went wrong without making the description useless: `file:line:column: message`.
    pub warnings: Vec<String>,
}

/// A comment line `#@word arguments…`, such as `#@probe X Y Z GLOW_ID`.
#[derive(Clone, Debug)]
pub struct Annotation {
    /// What it says.
    pub word: String,
    /// The words after it.
    pub arguments: Vec<String>,
    /// The comment.
    pub span: Span,
    /// The index of the primitive that it stands before.
    pub before: usize,
}

/// Carries out all commands of `documents`, which follow each other, up to the first error.
pub fn expand(documents: Vec<Document>, resolve: &dyn Resolve) -> Result<Flat> {
    let (flat, errors) = expand_with(documents, resolve, 1);
    errors.into_iter().next().map_or(Ok(flat), Err)
}

/// As [`expand`], but goes on after an error: what could be read, and everything that is wrong with the rest.
pub fn expand_all_errors(documents: Vec<Document>, resolve: &dyn Resolve) -> (Flat, Vec<Error>) {
    expand_with(documents, resolve, ERROR_LIMIT)
}

fn expand_with(documents: Vec<Document>, resolve: &dyn Resolve, patience: usize) -> (Flat, Vec<Error>) {
    if resolve.denies()
        && let Err(error) = refuse_commands(&documents)
    {
        return (Flat::default(), vec![error]);
    }
    let mut expander = Expander {
        resolve,
        patience,
        errors: Vec::new(),
        warnings: Vec::new(),
        commands: 0,
        made: 0,
        copies: 1,
        within: Vec::new(),
        files: HashMap::new(),
    };
    let mut flat = Flat::default();
    for document in documents {
        if document.source.text.trim().is_empty() {
            expander.warnings.push(format!("{}: empty file", document.source.name));
        }
        expander.within.push(plain_path(&document.source.name));
        let items = match expander.flatten(items(document), "") {
            Ok(items) => items,
            Err(error) => {
                expander.errors.push(error);
                break;
            }
        };
        for item in items {
            match item {
                Item::Primitive(p) => flat.primitives.push(p),
                Item::Annotation(a) => flat.annotations.push(Annotation { before: flat.primitives.len(), ..a }),
                Item::Command(_) => {}
            }
        }
        expander.within.pop();
    }
    flat.warnings = expander.warnings;
    (flat, expander.errors)
}

/// An error at the first command of `documents`, for those who want none run.
fn refuse_commands(documents: &[Document]) -> Result<()> {
    let command = documents.iter().flat_map(|d| &d.statements).find_map(|s| if let Statement::Command(c) = s { Some(c) } else { None });
    command.map_or(Ok(()), |span| Err(span.error("commands are denied; expand the file beforehand, or allow them with `--commands allow`")))
}

impl fmt::Display for Flat {
    /// One flat, canonical scene description.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut annotations = self.annotations.iter().peekable();
        for (i, primitive) in self.primitives.iter().enumerate() {
            while let Some(annotation) = annotations.next_if(|a| a.before <= i) {
                annotation.fmt(f)?;
            }
            writeln!(f, "{primitive}")?;
        }
        annotations.try_for_each(|a| a.fmt(f))
    }
}

impl fmt::Display for Annotation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "#@{}", self.word)?;
        self.arguments.iter().try_for_each(|a| write!(f, " {}", crate::rad::Quoted(a)))?;
        writeln!(f)
    }
}

/// What a stretch of a description holds while commands remain in it.
#[derive(Clone)]
enum Item {
    Primitive(Primitive),
    Annotation(Annotation),
    Command(Command),
}

/// A command still to be run, without its `!`.
#[derive(Clone)]
struct Command {
    text: String,
    span: Span,
}

/// Why a command stopped.
enum Stop {
    /// It failed; what it printed stays.
    Failed(Error),
    /// The description cannot be used.
    Fatal(Error),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

type Step<T> = std::result::Result<T, Stop>;

fn fatal(error: Error) -> Stop {
    Stop::Fatal(error)
}

struct Expander<'a> {
    resolve: &'a dyn Resolve,
    /// How many errors it takes to stop.
    patience: usize,
    errors: Vec<Error>,
    warnings: Vec<String>,
    commands: usize,
    made: usize,
    /// How many copies the `xform` commands around this place make of each primitive.
    copies: usize,
    /// The files that are being read, outermost first.
    within: Vec<String>,
    /// Files that `xform` has read, their commands carried out.
    files: HashMap<String, Arc<Vec<Item>>>,
}

impl Expander<'_> {
    /// The items with all commands carried out in the directory `folder` (empty, or with a slash at its end).
    fn flatten(&mut self, items: Vec<Item>, folder: &str) -> Result<Vec<Item>> {
        if !items.iter().any(|item| matches!(item, Item::Command(_))) {
            return Ok(items);
        }
        let mut flat = Vec::with_capacity(items.len());
        for item in items {
            match item {
                Item::Command(command) => {
                    let (depth, copies) = (self.within.len(), self.copies);
                    match self.run(&command, folder) {
                        Ok(mut items) => flat.append(&mut items),
                        Err(error) if self.errors.len() + 1 < self.patience => self.errors.push(error),
                        Err(error) => return Err(error),
                    }
                    self.within.truncate(depth);
                    self.copies = copies;
                }
                item => flat.push(item),
            }
        }
        Ok(flat)
    }

    /// What `command` prints, all commands in it carried out too.
    fn run(&mut self, command: &Command, folder: &str) -> Result<Vec<Item>> {
        let Command { text, span } = command;
        self.commands += 1;
        if self.within.len() > DEPTH_LIMIT {
            return Err(span.error(format!("commands within commands, more than {DEPTH_LIMIT} deep; does a file include itself?")));
        }
        if self.commands > COMMAND_LIMIT {
            return Err(span.error(format!("more than {COMMAND_LIMIT} commands; expand the scene in parts")));
        }
        let stages = pipeline(text);
        self.within.push(format!("!{text}"));
        let items = match stages {
            Some(stages) if stages.iter().all(|s| is_built_in(&s.words)) => self.pipe(stages, command, folder)?,
            stages => {
                let there = if folder.is_empty() { text.clone() } else { format!("cd {} && {text}", quoted(folder)) };
                let bytes = self.resolve.command(&there).map_err(|e| {
                    let foreign = stages.iter().flatten().find_map(|stage| Some((&stage.words[0], generate::foreign(&stage.words)?)));
                    let beyond = foreign.map(|(program, option)| format!("{option} is an option of RADIANCE's own {program} only; "));
                    span.error(beyond.unwrap_or_default() + &e.message)
                })?;
                let items = self.read(Source::printed(format!("!{text}"), decode(bytes), span))?;
                self.count(items.len()).map_err(|e| span.error(e.message))?;
                items
            }
        };
        if !items.iter().any(|i| matches!(i, Item::Primitive(_) | Item::Command(_))) {
            self.warn(span, "the command printed no primitive");
        }
        self.flatten(items, folder)
    }

    /// The items of a text, its commands not carried out.
    fn read(&mut self, text: Arc<Source>) -> Result<Vec<Item>> {
        let (document, mut errors) = Document::parse_all_errors(text);
        if self.errors.len() + errors.len() >= self.patience && !errors.is_empty() {
            return Err(errors.swap_remove(0));
        }
        self.errors.append(&mut errors);
        Ok(items(document))
    }

    fn pipe(&mut self, stages: Vec<Stage>, command: &Command, folder: &str) -> Result<Vec<Item>> {
        let mut items = Vec::new();
        for stage in stages {
            let mut out = Vec::new();
            match self.stage(stage, &command.span, items, folder, &mut out) {
                Ok(()) => {}
                Err(Stop::Failed(error)) => self.warn(&command.span, &error.message),
                Err(Stop::Fatal(error)) => return Err(if error.place.is_some() { error } else { command.span.error(error.message) }),
            }
            items = out;
        }
        Ok(items)
    }

    /// Runs one program of a pipeline that stands at `span` on what the one before printed; appends to `out` what it prints.
    fn stage(&mut self, stage: Stage, span: &Span, input: Vec<Item>, folder: &str, out: &mut Vec<Item>) -> Step<()> {
        let input = match &stage.input {
            Some(name) => self.scene(name, folder)?,
            None => input,
        };
        let (program, arguments) = stage.words.split_first().ok_or_else(|| fatal(Error::new("an empty command")))?;
        let printed = match program.as_str() {
            "xform" => return self.xform(arguments, input, folder, out),
            "cat" => return self.cat(arguments, input, folder, out),
            "echo" => Ok(echo(arguments)),
            _ => {
                let read = |name: &str, library: bool| {
                    let path = joined(folder, name);
                    let bytes = if library { self.library(&path, name).map(|(_, bytes)| bytes) } else { self.resolve.scene(&path) };
                    bytes.map(decode)
                };
                generate::generate(program, arguments, &read)
            }
        };
        let text = printed.map_err(Stop::Failed)?;
        out.append(&mut self.read(Source::printed(format!("!{}", stage.words.join(" ")), text, span)).map_err(fatal)?);
        self.count(out.len()).map_err(fatal)
    }

    /// Counts what a command makes; an error if that is too much by now.
    fn count(&mut self, more: usize) -> Result<()> {
        self.made = self.made.saturating_add(more);
        if self.made > PRIMITIVE_LIMIT {
            return Err(Error::new(format!("commands make more than {PRIMITIVE_LIMIT} primitives; make smaller arrays")));
        }
        Ok(())
    }

    fn cat(&mut self, names: &[String], mut input: Vec<Item>, folder: &str, out: &mut Vec<Item>) -> Step<()> {
        if names.is_empty() {
            out.append(&mut input);
        }
        for name in names {
            if name == "-" {
                out.append(&mut input);
            } else {
                let mut items = self.scene(name, folder)?;
                out.append(&mut items);
            }
        }
        self.count(out.len()).map_err(fatal)
    }

    /// The items of a scene file, its commands not carried out.
    fn scene(&mut self, name: &str, folder: &str) -> Step<Vec<Item>> {
        let path = joined(folder, name);
        self.enter(&path).map_err(fatal)?;
        let bytes = self.resolve.scene(&path).map_err(Stop::Failed)?;
        self.read(Source::new(path, decode(bytes))).map_err(fatal)
    }

    fn xform(&mut self, arguments: &[String], input: Vec<Item>, folder: &str, out: &mut Vec<Item>) -> Step<()> {
        let argument_file = |name: &str| self.resolve.scene(&joined(folder, name)).map(decode);
        let xform = Xform::parse(arguments, argument_file)?;
        let around = self.copies;
        self.copies = around.saturating_mul(xform.copies.len());
        // Read all files before the first copy; a missing one ends each copy where it stands.
        let (mut inputs, mut missing) = (Vec::new(), None);
        if xform.files.is_empty() {
            inputs.push(Arc::new(if xform.expand { self.flatten(input, folder).map_err(fatal)? } else { input }));
        }
        for name in &xform.files {
            match self.operand(name, folder, xform.expand) {
                Ok(items) => inputs.push(items),
                Err(Stop::Fatal(error)) => return Err(Stop::Fatal(error)),
                Err(Stop::Failed(error)) => {
                    missing = Some(error);
                    break;
                }
            }
        }
        let size: usize = inputs.iter().map(|items| items.len()).sum();
        // What would become too many is refused before the first copy.
        let copies = std::mem::replace(&mut self.copies, around);
        let made = self.made;
        self.count(size.saturating_mul(copies)).map_err(fatal)?;
        self.made = made.saturating_add(size.saturating_mul(xform.copies.len()));
        out.reserve(size * xform.copies.len());
        for copy in &xform.copies {
            out.extend(inputs.iter().flat_map(|items| items.iter()).map(|item| copy.of(item)));
        }
        missing.map_or(Ok(()), |error| Err(Stop::Failed(error)))
    }

    /// The items of a file that `xform` names. Commands in it are carried out in that file's directory.
    fn operand(&mut self, name: &str, folder: &str, expand: bool) -> Step<Arc<Vec<Item>>> {
        let path = joined(folder, name);
        if expand && let Some(items) = self.files.get(&path) {
            return Ok(items.clone());
        }
        self.enter(&path).map_err(fatal)?;
        let (path, bytes) = self.library(&path, name).map_err(Stop::Failed)?;
        let items = self.read(Source::new(&path, decode(bytes))).map_err(fatal)?;
        if !expand {
            return Ok(Arc::new(items));
        }
        self.within.push(plain_path(&path));
        let flat = Arc::new(self.flatten(items, &path[..path.rfind('/').map_or(0, |i| i + 1)]).map_err(fatal)?);
        self.within.pop();
        self.files.insert(joined(folder, name), flat.clone());
        Ok(flat)
    }

    /// A library file, looked for beside the file that names it and then as it is named; and the name it was found by.
    fn library(&self, path: &str, name: &str) -> Result<(String, Vec<u8>)> {
        match self.resolve.library(path) {
            Err(_) if path != name && !name.starts_with('.') => self.resolve.library(name).map(|bytes| (name.into(), bytes)),
            found => found.map(|bytes| (path.into(), bytes)),
        }
    }

    /// An error if the file is being read already.
    fn enter(&self, path: &str) -> Result<()> {
        let path = plain_path(path);
        if !self.within.contains(&path) {
            return Ok(());
        }
        let through: Vec<&str> = self.within.iter().skip_while(|w| **w != path).skip(1).map(String::as_str).collect();
        Err(Error::new(format!("{path} includes itself through `{}`; break the circle", through.join("`, `"))))
    }

    fn warn(&mut self, span: &Span, message: &str) {
        self.warnings.push(span.error(message).remark());
    }
}

fn is_built_in(words: &[String]) -> bool {
    matches!(words[0].as_str(), "xform" | "cat" | "echo") || generate::is_known(words)
}

/// What the shell's `echo` prints; like dash's it knows `\n` and `\t`.
fn echo(words: &[String]) -> String {
    let words = if words.first().is_some_and(|w| w == "-n") { &words[1..] } else { words };
    words.join(" ").replace("\\n", "\n").replace("\\t", "\t") + "\n"
}

fn items(document: Document) -> Vec<Item> {
    let item = |statement| match statement {
        Statement::Primitive(p) => Some(Item::Primitive(p)),
        Statement::Command(span) => {
            let text = span.source.text[span.start + 1..span.end].replace("\r\n", "\n");
            Some(Item::Command(Command { text: text.trim().to_string(), span }))
        }
        Statement::Comment(span) => annotation(span).map(Item::Annotation),
    };
    document.statements.into_iter().filter_map(item).collect()
}

/// The annotation that a comment is, if it is one.
fn annotation(span: Span) -> Option<Annotation> {
    let text = span.source.text[span.start..span.end].strip_prefix("#@")?;
    let mut words = Vec::new();
    let mut rest = text;
    while let Ok((r, word)) = word(rest) {
        words.push(word.text.into_owned());
        rest = r;
    }
    let mut words = words.into_iter();
    // Its first word stands right there, and is no matter for quotes.
    let word = words.next().filter(|word| !word.is_empty() && text.starts_with(word.as_str()))?;
    Some(Annotation { word, arguments: words.collect(), span, before: 0 })
}

/// The path of `name` as seen from `folder`.
fn joined(folder: &str, name: &str) -> String {
    if name.starts_with(['/', '~']) { name.into() } else { format!("{folder}{name}") }
}

/// The path without `./` and `folder/../`.
fn plain_path(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "." => {}
            ".." if parts.last().is_some_and(|p| !matches!(*p, "" | "..")) => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests;
