//! Scenes and views as they are named on a command line.

use super::{Input, stream::file};
use crate::args::{Commands, Scenes, ViewWords};
use crate::error::Result;
use crate::expand::{Flat, expand, refuse_commands};
use crate::rad::Document;
use crate::resolve::Resolve;
use crate::view::View;

/// The documents of scene files; `-` is standard input.
pub fn documents(names: &[String]) -> Result<Vec<Document>> {
    let input = Input::default();
    names
        .iter()
        .map(|name| {
            let (name, bytes) = input.read(name)?;
            Document::read(&name, bytes)
        })
        .collect()
}

/// The description that scene files make together.
pub fn flat(names: &[String], options: &Scenes, resolve: &dyn Resolve) -> Result<Flat> {
    let documents = documents(names)?;
    if options.commands == Some(Commands::Deny) {
        refuse_commands(&documents)?;
    }
    expand(documents, resolve)
}

/// The view that the words of a command line describe.
pub fn view(words: &ViewWords) -> Result<View> {
    let mut view = View::default();
    view.apply(&words.words, &|name| file(name))?;
    Ok(view)
}
