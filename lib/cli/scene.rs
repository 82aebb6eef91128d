//! Scenes and views as they are named on a command line.

use super::disk::{Disk, printed};
use super::stream::file;
use super::{Console, Outcome, input};
use crate::args::rtrace::{Arguments, Light};
use crate::args::{self, ViewWords};
use crate::error::{Error, Result, Source};
use crate::expand::{Flat, expand};
use crate::import::{is_octree, octree};
use crate::rad::{Document, likely};
use crate::resolve::Resolve;
use crate::rules::Rules;
use crate::scene::{Reading, Scene};
use crate::view::View;
use crate::world::World;
use std::path::Path;
use std::sync::Arc;

/// The name and the bytes of a scene file or octree. A name that begins with `!` is a command that prints one; it was typed, so it may run unless all are
/// denied. But a file of that name is a file: `*.rad` may name what somebody else has put there.
pub fn typed(name: &str, resolve: &dyn Resolve) -> Result<(String, Vec<u8>)> {
    match name.strip_prefix('!').filter(|_| !Path::new(name).exists()) {
        Some(_) if resolve.denies() => Err(Error::new(format!("{name}: commands are denied; write ./{name} for a file of this name"))),
        Some(command) => match printed(command)? {
            (bytes, status) if status.success() => Ok((name.into(), bytes)),
            (_, status) => Err(Error::new(format!("command {command}: {status}"))),
        },
        None => input(name),
    }
}

/// The documents of scene files and octrees.
pub fn documents(names: &[String], resolve: &dyn Resolve) -> Result<Vec<Document>> {
    let mut documents = Vec::new();
    for name in names {
        let (name, bytes) = typed(name, resolve)?;
        if !is_octree(&bytes) {
            documents.push(Document::read(&name, bytes)?);
            continue;
        }
        documents.extend(octree(&bytes, &name)?.documents(&name, resolve)?);
    }
    Ok(documents)
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

/// The world of the scene that was named.
pub fn world(args: &Arguments, rules: &Rules, disk: &Disk, console: &Console) -> Outcome<World> {
    let flat = expand(documents(&args.scenes(), disk)?, disk)?;
    let scene = built(&flat, disk, &reading(&args.reading, disk)?, &args.light, console)?;
    Ok(World::new(scene, rules)?)
}

/// Says what expressions of the world had no value for some ray, unless `-w-` wants none of that.
pub fn say_failures(world: &World, light: &Light, console: &Console) {
    if light.tuning.w != Some(false) {
        world.failures().iter().for_each(|failure| console.warn(failure));
    }
}

/// How scenes are read by what was typed.
pub fn reading(typed: &args::Reading, resolve: &dyn Resolve) -> Result<Reading> {
    let mut definitions: Vec<Arc<Source>> = typed.definitions.iter().map(|text| Source::new("-e", text.as_str())).collect();
    for name in &typed.function_files {
        definitions.push(Source::new(name.as_str(), String::from_utf8_lossy(&resolve.library(name)?)));
    }
    Ok(Reading { skip_unsupported: typed.skip_unsupported, definitions, unknown: None })
}

/// The scene that was read; what is to be said of it is said, unless `-w-` wants none of that.
pub fn built(flat: &Flat, resolve: &dyn Resolve, reading: &Reading, light: &Light, console: &Console) -> Result<Scene> {
    let scene = Scene::new(flat, resolve, reading)?;
    if light.tuning.w != Some(false) {
        scene.warnings.iter().for_each(|w| console.warn(w));
        let known = || scene.chains.iter().map(|chain| chain.name.as_str());
        let typed = light.ae.iter().map(|name| ("-ae", name)).chain(light.ai.iter().map(|name| ("-ai", name)));
        for (option, name) in typed.filter(|(_, name)| !known().any(|known| known == *name)) {
            let likely = likely(name, known()).map_or(String::new(), |likely| format!("; `{likely}` is one"));
            console.warn(&format!("{option} {name}: no surface's modifier is called so{likely}"));
        }
    }
    Ok(scene)
}
