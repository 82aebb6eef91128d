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
    flat_of(documents(names)?, options, resolve)
}

/// The description that documents make together.
pub fn flat_of(documents: Vec<Document>, options: &Scenes, resolve: &dyn Resolve) -> Result<Flat> {
    if options.commands == Some(Commands::Deny) {
        refuse_commands(&documents)?;
    }
    expand(documents, resolve)
}

/// The words of a file that lists modifiers.
pub fn list(resolve: &dyn Resolve, file: &str) -> Result<Vec<String>> {
    Ok(String::from_utf8_lossy(&resolve.library(file)?).split_whitespace().map(str::to_string).collect())
}

/// The view that the words of a command line describe.
pub fn view(words: &ViewWords) -> Result<View> {
    let mut view = View::default();
    view.apply(&words.words, &|name| file(name))?;
    Ok(view)
}
