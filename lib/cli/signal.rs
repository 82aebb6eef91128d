//! Ctrl-C and SIGTERM: what is being written is removed; a program that can end with what it has so far is given the chance.

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{LazyLock, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Signals this close to the first are the same: `timeout` signals a program and its process group, which are one program twice.
const SAME: Duration = Duration::from_millis(200);

/// Files and directories of what is under way, to be removed when the program is interrupted.
static UNFINISHED: LazyLock<Mutex<Vec<PathBuf>>> = LazyLock::new(|| {
    // Without a handler an interrupted program leaves hidden files behind; that is no reason not to run.
    if let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) {
        let _ = std::thread::Builder::new().spawn(move || signals.forever().for_each(received));
    }
    Mutex::default()
});

/// Whether the program ends by itself when asked.
static PATIENT: AtomicBool = AtomicBool::new(false);

/// When it was asked.
static ASKED: OnceLock<Instant> = OnceLock::new();

fn received(signal: i32) {
    if PATIENT.load(Ordering::Relaxed) && ASKED.get_or_init(Instant::now).elapsed() < SAME {
        return;
    }
    clean();
    std::process::exit(128 + signal);
}

/// Removes what is under way, before the program ends at once.
pub(super) fn clean() {
    for path in unfinished().iter() {
        let _ = std::fs::remove_file(path).or_else(|_| std::fs::remove_dir_all(path));
    }
}

/// From now on the first signal to end is a question: the result tells whether it was asked. The second ends the program at once.
pub fn interrupted() -> impl Fn() -> bool {
    LazyLock::force(&UNFINISHED);
    PATIENT.store(true, Ordering::Relaxed);
    || ASKED.get().is_some()
}

/// A file is being written, or a directory is used for a time.
pub(super) fn begun(path: &Path) {
    unfinished().push(path.to_path_buf());
}

/// It is written, or given up.
pub(super) fn ended(path: &Path) {
    unfinished().retain(|unfinished| unfinished != path);
}

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}
