//! How a broken input is put before a program, and what every refusal must look like.

use rayon::prelude::*;
use std::fs::{self, File};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Processor seconds (a machine that stalls may charge one or two to whoever runs) and KiB of address space that a program may take.
const SECONDS: u32 = 5;
const MEMORY: u32 = 200 << 10;
/// A program that has not ended by then hangs.
const PATIENCE: Duration = Duration::from_secs(30);

/// What stands in a file's place.
#[derive(Clone)]
pub enum Content {
    Bytes(Vec<u8>),
    Directory,
    /// A link to this name.
    Link(&'static str),
}

impl From<&str> for Content {
    fn from(text: &str) -> Self {
        Self::Bytes(text.into())
    }
}

impl From<&[u8]> for Content {
    fn from(bytes: &[u8]) -> Self {
        Self::Bytes(bytes.into())
    }
}

/// A broken input, before one program.
#[derive(Clone)]
pub struct Case {
    /// What is broken, and how.
    pub label: String,
    /// The program and its arguments.
    pub words: Vec<String>,
    pub files: Vec<(String, Content)>,
    pub stdin: Vec<u8>,
    /// What the message must hold: the file with the line, the argument.
    pub place: String,
    pub status: i32,
}

impl Case {
    /// A case of a program that must be refused with status 2; blanks separate the words of `line`, `~` stands for a blank in one.
    pub fn new(label: impl Into<String>, line: &str, place: impl Into<String>) -> Self {
        let words = line.split(' ').map(|word| word.replace('~', " ")).collect();
        Self { label: label.into(), words, files: Vec::new(), stdin: Vec::new(), place: place.into(), status: 2 }
    }

    /// The same with a file.
    pub fn with(mut self, name: &str, content: impl Into<Content>) -> Self {
        self.files.push((name.into(), content.into()));
        self
    }

    /// The same with something on standard input.
    pub fn reading(mut self, bytes: &[u8]) -> Self {
        self.stdin = bytes.into();
        self
    }

    /// The same with another exit status.
    pub fn ending(mut self, status: i32) -> Self {
        self.status = status;
        self
    }
}

/// Runs all cases and shows, as one failure, what is wrong with those that are not refused as they should be.
pub fn refuse(kind: &str, cases: &[Case]) {
    let outcomes: Vec<_> = cases.par_iter().map(|case| (case, run(case))).collect();
    let slowest = outcomes.iter().map(|(_, (_, time))| *time).max().unwrap_or_default();
    let wrong: Vec<String> = outcomes
        .iter()
        .filter_map(|(case, (outcome, _))| Some(format!("{}: `{}`: {}", case.label, case.words.join(" "), outcome.as_ref().err()?)))
        .collect();
    eprintln!("{kind}: {} cases, {} wrong, the slowest took {slowest:.2?}", cases.len(), wrong.len());
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), cases.len(), wrong.join("\n"));
}

/// Runs the same programs on inputs that nothing is wrong with: what is refused elsewhere is refused for its damage.
pub fn accept(cases: &[Case]) {
    for case in cases {
        let (outcome, _) = run(&case.clone().ending(0));
        assert!(outcome.is_ok(), "{}: {outcome:?}", case.label);
    }
}

/// What is wrong with the refusal, if anything; and how long it took.
fn run(case: &Case) -> (Result<(), String>, Duration) {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    for (name, content) in &case.files {
        match content {
            Content::Bytes(bytes) => fs::write(at(name), bytes).unwrap(),
            Content::Directory => fs::create_dir(at(name)).unwrap(),
            Content::Link(to) => std::os::unix::fs::symlink(to, at(name)).unwrap(),
        }
    }
    // Outside of the directory that the program sees: it must leave that as it is.
    let outside = tempfile::tempdir().unwrap();
    let open = |name: &str| File::create(outside.path().join(name)).unwrap();
    fs::write(outside.path().join("in"), &case.stdin).unwrap();
    let before = list(directory.path());
    let begin = Instant::now();
    let mut child = Command::new("sh")
        .args(["-c", &format!("ulimit -t {SECONDS}; ulimit -v {MEMORY}; exec \"$0\" \"$@\""), program(&case.words[0])])
        .args(&case.words[1..])
        .current_dir(directory.path())
        .env_remove("RAD_COMMANDS")
        .env("RAYPATH", "")
        // A pool of its own for each thread takes address space, not memory.
        .env("MALLOC_ARENA_MAX", "1")
        .stdin(File::open(outside.path().join("in")).unwrap())
        .stdout(open("out"))
        .stderr(open("err"))
        .spawn()
        .unwrap();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break Some(status);
        }
        if begin.elapsed() > PATIENCE {
            child.kill().unwrap();
            child.wait().unwrap();
            break None;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    let took = begin.elapsed();
    let read = |name: &str| String::from_utf8_lossy(&fs::read(outside.path().join(name)).unwrap()).into_owned();
    let (out, err) = (read("out"), read("err"));
    let said = judge(case, status.map(|s| s.code().ok_or(s.to_string())), &out, &err).and_then(|()| {
        let after = list(directory.path());
        if after == before { Ok(()) } else { Err(format!("leaves {after:?}")) }
    });
    (said.map_err(|what| format!("{what}\n    {}", err.chars().take(600).collect::<String>().replace('\n', "\n    "))), took)
}

fn judge(case: &Case, status: Option<Result<i32, String>>, out: &str, err: &str) -> Result<(), String> {
    let tool = &case.words[0];
    match status {
        None => return Err(format!("does not end within {PATIENCE:?}")),
        Some(Err(signal)) => return Err(format!("dies: {signal}")),
        Some(Ok(status)) if status != case.status => return Err(format!("ends with {status}, not {}", case.status)),
        Some(Ok(_)) => {}
    }
    if err.contains("panicked") || err.contains("fault of the program") {
        return Err("panics".into());
    }
    if case.status == 0 {
        return if err.contains("error: ") { Err("complains".into()) } else { Ok(()) };
    }
    if !out.is_empty() {
        return Err(format!("prints {} bytes all the same", out.len()));
    }
    // One line each, and the line of the file with its caret, which are indented.
    let own = format!("{tool}: ");
    let stray = err.lines().find(|line| !line.starts_with(&own) && !line.starts_with("  "));
    if let Some(stray) = stray {
        return Err(format!("says a line of its own: {stray}"));
    }
    let errors: Vec<&str> = err.lines().filter(|line| line.starts_with(&own) && line.contains("error: ")).collect();
    if errors.is_empty() || (case.status == 2 && errors.len() > 1) {
        return Err(format!("says {} errors", errors.len()));
    }
    if errors.iter().any(|line| line.chars().count() > 1000 || line.chars().any(char::is_control)) {
        return Err("says a line that is too long or holds control characters".into());
    }
    if !errors.iter().any(|line| line.contains(&case.place)) {
        return Err(format!("does not name {}", case.place));
    }
    Ok(())
}

/// The names in a directory, with what stands in the files.
fn list(directory: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap());
    let mut names: Vec<_> = entries
        .map(|entry| {
            let content = if entry.file_type().unwrap().is_file() { fs::read(entry.path()).unwrap() } else { Vec::new() };
            (entry.file_name().to_string_lossy().into_owned(), content)
        })
        .collect();
    names.sort();
    names
}

fn program(name: &str) -> &'static str {
    match name {
        "rparse" => env!("CARGO_BIN_EXE_rparse"),
        "rtrace-rs" => env!("CARGO_BIN_EXE_rtrace-rs"),
        "imgdiff" => env!("CARGO_BIN_EXE_imgdiff"),
        "anneal" => env!("CARGO_BIN_EXE_anneal"),
        _ => panic!("{name} is none of the programs"),
    }
}
