//! What is said of a recovery.

use super::run;
use std::path::Path;

/// What anneal writes in a directory; shown where a test fails.
pub fn recovered(directory: &Path, arguments: &str) -> String {
    let done = run(env!("CARGO_BIN_EXE_anneal"), directory, arguments);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let out = String::from_utf8(done.stdout).unwrap();
    println!("{out}");
    out
}

/// The value of a parameter and its standard error, as they are printed.
pub fn said(out: &str, name: &str) -> (f64, f64) {
    let line = out.lines().find(|line| line.starts_with(&format!("# {name} "))).unwrap();
    let words: Vec<&str> = line.split(' ').collect();
    (words[2].parse().unwrap(), words[4].trim_end_matches(':').parse().unwrap())
}
