//! What a test says that has nothing to compare with on this machine.

use std::io::Write;

/// Says so, past the harness, which keeps what a test prints to itself unless it fails.
pub fn skipped(why: &str) {
    let test = std::thread::current().name().unwrap_or_default().to_string();
    let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {why}");
}
