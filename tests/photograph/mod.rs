//! A picture of a known material, and the files that a recovery of it begins with.

pub mod said;
pub mod waves;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Arc, Mutex, OnceLock};
use tempfile::TempDir;

/// The bytes of the pictures that were taken, by what they were taken of and how: each is taken once.
static TAKEN: Mutex<BTreeMap<String, Arc<OnceLock<Vec<u8>>>>> = Mutex::new(BTreeMap::new());

/// Runs a program in a directory.
pub fn run(program: &str, directory: &Path, arguments: &str) -> Output {
    Command::new(program).current_dir(directory).args(arguments.split_whitespace()).output().unwrap()
}

/// A directory with `scene.rad`, with `true.rad`, the `material` without its `void`, with `start.rad`, another of its type, and with the
/// picture that the options `view` make.
pub fn photographed(material: &str, scene: &str, view: &str) -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    // Patterns may come before it.
    let (head, _) = material.split_once(" it ").unwrap();
    let start = match head.rsplit(' ').next().unwrap() {
        "dielectric" => "0 0 5 .5 .5 .5 1.5 0",
        "glass" => "0 0 3 .5 .5 .5",
        "trans" => "0 0 7 .5 .5 .5 .1 .1 .3 .2",
        _ => "0 0 5 .5 .5 .5 .1 .1",
    };
    fs::write(path.join("start.rad"), format!("void {head} it {start}\n")).unwrap();
    fs::write(path.join("true.rad"), format!("void {material}\n")).unwrap();
    fs::write(path.join("scene.rad"), scene).unwrap();
    let picture = path.join(view.split_once("-o ").unwrap().1.split(' ').next().unwrap());
    let taken = TAKEN.lock().unwrap().entry([material, scene, view].join("\n")).or_default().clone();
    let bytes = taken.get_or_init(|| {
        let arguments = format!("-vp 0 -5 1 -vd 0 1 -.2 -vh 26 -vv 26 {view} true.rad scene.rad");
        assert!(run(env!("CARGO_BIN_EXE_rtrace-rs"), path, &arguments).status.success());
        fs::read(&picture).unwrap()
    });
    fs::write(&picture, bytes).unwrap();
    directory
}
