//! rparse: reads scene descriptions.

use inverad::args::rparse::Args;
use inverad::check::{Problems, check, glance};
use inverad::cli::{self, Answer, Console, Disk, Outcome, Output};
use inverad::error::{Error, Source};
use inverad::expand::{Flat, expand, expand_all_errors};
use inverad::import::is_octree;
use inverad::inventory::Inventory;
use inverad::rad::{self, Document, ERROR_LIMIT, Links, Type};
use inverad::resolve::Resolve;
use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::Arc;

/// So many warnings are shown.
const WARNINGS: usize = 100;

fn main() -> ExitCode {
    cli::main("rparse", run)
}

fn run(args: Args, console: &Console) -> Outcome<Answer> {
    let disk = Disk::new(args.scenes.commands, console);
    let mut sources = Vec::new();
    for name in &args.files {
        let (name, bytes) = cli::typed(name, &disk)?;
        if is_octree(&bytes) {
            let remedy = "rtrace-rs reads it; give rparse the scene files that it was made from";
            return Err(Error::new(format!("{name}: this is an octree, not a scene file: {remedy}")).into());
        }
        sources.push(Source::new(name, rad::decode(bytes)));
    }
    if args.mode.check {
        return Ok(report(sources, &disk, console));
    }
    let mut documents = sources.into_iter().map(Document::parse).collect::<Result<Vec<_>, Error>>()?;
    let text = if args.mode.keep {
        args.set.iter().try_for_each(|setting| rad::set(&mut documents, setting))?;
        whole(&documents)
    } else {
        let flat = expand(documents, &disk)?;
        // A scene is printed for oconv.
        let Problems { errors, warnings } = if args.mode.is_scene() { glance(&flat) } else { Problems::default() };
        let warnings = flat.warnings.iter().cloned().chain(warnings.iter().map(Error::remark));
        show(warnings, WARNINGS, "warnings", |warning| console.warn(warning));
        if let Some(error) = errors.into_iter().next() {
            return Err(error.into());
        }
        rad::encode(&print(&args, flat))
    };
    disk.spares(args.common.output.as_deref())?;
    Output::whole(args.common.output.as_deref(), &text)?;
    Ok(Answer::Yes)
}

/// Documents one after the other, each at the beginning of a line.
fn whole(documents: &[Document]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for document in documents {
        if bytes.last().is_some_and(|last| *last != b'\n') {
            bytes.push(b'\n');
        }
        bytes.extend(document.bytes());
    }
    bytes
}

/// The description in the form that is asked for.
fn print(args: &Args, mut flat: Flat) -> String {
    if args.mode.stats {
        return Inventory::of(&flat).to_string();
    }
    if args.mode.json {
        return flat.primitives.iter().map(|p| rad::json(p) + "\n").collect();
    }
    if args.mode.materials {
        let mut used = Links::of(&flat.primitives).used(&flat.primitives).into_iter();
        flat.primitives.retain(|p| used.next() == Some(true) && p.type_of().is_some_and(Type::is_modifier));
        flat.annotations.clear();
    }
    flat.to_string()
}

/// Shows what is to be said, but so much of it at the most.
fn show(mut said: impl Iterator<Item = String>, most: usize, what: &str, say: impl Fn(&str)) {
    said.by_ref().take(most).for_each(|said| say(&said));
    let more = said.count();
    if more > 0 {
        say(&format!("{more} more {what} are not shown"));
    }
}

/// Says everything that is wrong.
fn report(sources: Vec<Arc<Source>>, resolve: &dyn Resolve, console: &Console) -> Answer {
    let (mut documents, mut errors) = (Vec::new(), Vec::new());
    for source in sources {
        let (document, mut wrong) = Document::parse_all_errors(source);
        documents.push(document);
        errors.append(&mut wrong);
    }
    let (flat, mut wrong) = expand_all_errors(documents, resolve);
    errors.append(&mut wrong);
    let mut problems = check(&flat, resolve);
    errors.append(&mut problems.errors);
    let warnings = flat.warnings.into_iter().chain(problems.warnings.iter().map(Error::remark));
    show(warnings, WARNINGS, "warnings", |warning| console.warn(warning));
    show(errors.iter().map(Error::to_string), ERROR_LIMIT, "errors", |error| drop(writeln!(io::stderr(), "rparse: {error}")));
    if errors.is_empty() { Answer::Yes } else { Answer::No }
}
