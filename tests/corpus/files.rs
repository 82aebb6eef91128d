//! Where the real scene files are that tests read, if they are there.

use crate::skipped::skipped;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The directory of real scene files and the files in it, if they are there and so are these programs of RADIANCE's; otherwise says so.
pub fn corpus(programs: &[&str]) -> Option<(PathBuf, Vec<PathBuf>)> {
    let shared = std::env::var_os("INVERAD_SHARED").map_or(Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let corpus = shared.join("corpus");
    if !corpus.is_dir() {
        skipped("no corpus of scene files (INVERAD_SHARED, ../shared)");
        return None;
    }
    if let Some(missing) = programs.iter().find(|program| Command::new(program).stdin(Stdio::null()).output().is_err()) {
        skipped(&format!("{missing} is not on PATH"));
        return None;
    }
    let mut files = Vec::new();
    scene_files(&corpus, &mut files);
    files.sort();
    Some((corpus, files))
}

fn scene_files(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            scene_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rad" || e == "mat" || e == "sky") {
            found.push(path);
        }
    }
}
