//! A program that reads what it is fed.

use std::io::Write;
use std::process::{Command, Output, Stdio};
use std::thread::scope;

/// What a command does with this input. A program that has read enough closes its own.
pub fn fed(command: &mut Command, input: &[u8]) -> Output {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    scope(|scope| {
        scope.spawn(move || stdin.write_all(input));
        child.wait_with_output().unwrap()
    })
}
