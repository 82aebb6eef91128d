//! The outside: where bytes come from and go to, what is said on standard error, and with which status a program ends.
//!
//! A program is `fn main() -> ExitCode { cli::main("tool", run) }`. Its `run` gets what was typed and a [`Console`]; it
//! answers yes or no, or stops: with an error, or because nobody reads its output any more.

pub use disk::Disk;
pub use scene::{documents, list, say_failures, typed, view, world};
pub use signal::interrupted;
pub use stream::{Output, input};

use crate::args::{self, Common, Typed};
use crate::error::Error;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};

pub mod auto;
pub mod exec;
pub mod film;
pub mod kept;
pub mod photo;
pub mod picture;
pub mod predict;
pub mod rays;
pub mod recovery;
pub mod report;
pub mod search;

mod disk;
mod remarks;
mod scene;
mod signal;
mod stream;

/// What a program that worked has to say by its exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// It worked: status 0.
    Yes,
    /// It worked, and the answer is no: status 1.
    No,
}

/// How much stack a thread has, in bytes.
const STACK: usize = 8 << 20;

/// More threads than this no machine has a use for: each takes time to start and to be asked for work.
const MOST_THREADS: usize = 256;

/// Why a program stops before its end.
#[derive(Debug)]
pub enum Stop {
    /// Nobody reads its output any more: a quiet end, status 0.
    Closed,
    /// Trouble: a message, status 2.
    Failed(Error),
}

/// What came of a piece of a program's work.
pub type Outcome<T> = Result<T, Stop>;

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// Runs a program from its command line to its exit status.
pub fn main<A: clap::Parser + AsRef<Common> + Send>(
    tool: &'static str,
    run: impl FnOnce(A, &Console) -> Outcome<Answer> + Send,
) -> ExitCode {
    std::panic::set_hook(Box::new(move |info| {
        let _ = writeln!(io::stderr(), "{tool}: error: {}; this is a fault of the program, please report it", one_line(&info.to_string()));
        signal::clean();
        std::process::exit(2);
    }));
    let outcome = args::parse::<A>(std::env::args_os().collect(), &|name| Ok(String::from_utf8_lossy(&stream::file(name)?).into_owned()));
    let stopped = match outcome {
        Ok(Typed::Print(text)) => Output::whole(None, &text).map(|()| Answer::Yes),
        Ok(Typed::Run(arguments, trail)) => {
            let common = arguments.as_ref();
            let console = Console::new(tool, common.quiet, common.progress, trail);
            let threads = common.threads.map_or(0, usize::from).min(MOST_THREADS);
            match rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK).build_global() {
                Ok(()) => {
                    // On one of the threads, which need not be woken then for every piece of work.
                    let outcome = rayon::scope(|_| run(arguments, &console));
                    console.clear();
                    outcome
                }
                Err(e) => Err(Error::new(format!("cannot start threads: {e}")).into()),
            }
        }
        Err(error) => Err(error.into()),
    };
    match stopped {
        Ok(Answer::Yes) | Err(Stop::Closed) => ExitCode::SUCCESS,
        Ok(Answer::No) => ExitCode::from(1),
        Err(Stop::Failed(error)) => {
            let _ = writeln!(io::stderr(), "{tool}: {error}");
            ExitCode::from(2)
        }
    }
}

/// Standard error: warnings, and one line of progress on a terminal. What cannot be written there is lost without a word.
pub struct Console {
    tool: &'static str,
    trail: String,
    quiet: bool,
    /// Progress is shown: in place on a terminal, line after line elsewhere; or not at all.
    progress: Option<Style>,
    shown: Mutex<Shown>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Style {
    InPlace,
    Lines,
}

/// The progress that was last shown.
#[derive(Default)]
struct Shown {
    at: Option<Instant>,
    /// A line stands on the terminal that the next one replaces.
    standing: bool,
}

impl Console {
    fn new(tool: &'static str, quiet: bool, progress: bool, trail: String) -> Self {
        let progress = match (io::stderr().is_terminal(), progress) {
            _ if quiet => None,
            (true, _) => Some(Style::InPlace),
            (false, true) => Some(Style::Lines),
            (false, false) => None,
        };
        Self { tool, trail, quiet, progress, shown: Mutex::default() }
    }

    /// The command line for the header of a picture: without the options that cannot change it, as `-n`, `-q` and where it and what is told beside
    /// it are written.
    pub fn trail(&self) -> &str {
        &self.trail
    }

    /// Says what the user should know although the program goes on.
    pub fn warn(&self, message: &str) {
        self.say("warning", message);
    }

    /// Says what the user may want to know, if he does not want quiet.
    pub fn note(&self, message: &str) {
        if !self.quiet {
            self.say("note", message);
        }
    }

    /// Shows how far the work is, at most ten times a second on a terminal, once a second elsewhere. `text` is only made when shown.
    pub fn progress(&self, text: impl FnOnce() -> String) {
        let Some(style) = self.progress else { return };
        // A thread that finds another one showing progress has nothing to add.
        let Ok(mut shown) = self.shown.try_lock() else { return };
        let pause = Duration::from_millis(if style == Style::InPlace { 100 } else { 1000 });
        if shown.at.is_some_and(|at| at.elapsed() < pause) {
            return;
        }
        shown.at = Some(Instant::now());
        let text: String = one_line(&text()).chars().take(79 - self.tool.len() - 2).collect();
        let line = match style {
            Style::InPlace => format!("\r\x1b[K{}: {text}", self.tool),
            Style::Lines => format!("{}: {text}\n", self.tool),
        };
        shown.standing = style == Style::InPlace;
        let _ = io::stderr().write_all(line.as_bytes());
    }

    fn say(&self, kind: &str, message: &str) {
        self.clear();
        let _ = writeln!(io::stderr(), "{}: {kind}: {}", self.tool, one_line(message));
    }

    /// Takes the line of progress away.
    fn clear(&self) {
        let mut shown = self.shown.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if std::mem::take(&mut shown.standing) {
            let _ = io::stderr().write_all(b"\r\x1b[K");
        }
    }
}

/// The text without line breaks and control characters.
fn one_line(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}
