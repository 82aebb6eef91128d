//! Ctrl-C, and other signals to end: files being written are removed; a program that can end with what it has so far is given the chance.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

/// Files being written, to be removed when the program is interrupted.
static UNFINISHED: LazyLock<Mutex<Vec<PathBuf>>> = LazyLock::new(|| {
    // Without a handler an interrupted program leaves a hidden file behind; that is no reason not to run.
    let _ = ctrlc::set_handler(|| {
        if PATIENT.load(Ordering::Relaxed) && !ASKED.swap(true, Ordering::Relaxed) {
            return;
        }
        for path in unfinished().iter() {
            let _ = std::fs::remove_file(path);
        }
        std::process::exit(130);
    });
    Mutex::default()
});

/// Whether the program ends by itself when asked.
static PATIENT: AtomicBool = AtomicBool::new(false);

/// Whether it was asked.
static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on the first signal to end is a question: the result tells whether it was asked. The second ends the program at once.
pub fn interrupted() -> impl Fn() -> bool {
    LazyLock::force(&UNFINISHED);
    PATIENT.store(true, Ordering::Relaxed);
    || ASKED.load(Ordering::Relaxed)
}

/// A file is being written.
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
