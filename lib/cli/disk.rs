//! The file system and the shell as the library sees them: RAYPATH, the function files that ship with the project, and the
//! gate for commands.

use super::stream::{all, file, lost, native, place, plain};
use super::{Console, Outcome};
use crate::args::Commands;
use crate::cal;
use crate::error::{Error, Result};
use crate::resolve::Resolve;
use crate::sampling::mix64;
use std::collections::HashSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// Where RADIANCE looks when RAYPATH is not set.
const DEFAULT_RAYPATH: &str = ":/usr/local/lib/ray";

/// Commands that one run may start: scene files can print commands that print commands.
const MAX_COMMANDS: usize = 1000;

/// Finds and reads files, runs commands if the user allowed it.
pub struct Disk<'a> {
    raypath: Vec<PathBuf>,
    /// What was said of commands.
    commands: Option<Commands>,
    /// Hears what went wrong with a command whose output is used all the same.
    console: &'a Console,
    started: AtomicUsize,
    /// A number that any change of what was read changes.
    read: AtomicU64,
    /// The files that were read.
    opened: Mutex<HashSet<PathBuf>>,
}

impl<'a> Disk<'a> {
    /// The file system along `RAYPATH`, and behind it the files of the project itself, by name; commands but for the common generators are refused if
    /// nothing is said of them.
    pub fn new(commands: Option<Commands>, console: &'a Console) -> Self {
        let raypath = std::env::var_os("RAYPATH").unwrap_or_else(|| OsString::from(DEFAULT_RAYPATH));
        Self {
            raypath: std::env::split_paths(&raypath).collect(),
            commands,
            console,
            started: AtomicUsize::new(0),
            read: AtomicU64::new(0),
            opened: Mutex::default(),
        }
    }

    /// A number that any change of what was read so far changes, whatever the order.
    pub fn digest(&self) -> u64 {
        self.read.load(Ordering::Relaxed)
    }

    /// Counts something that was read under a name.
    pub fn count(&self, name: &str, bytes: &[u8]) {
        self.read.fetch_add(mix64(number(name.as_bytes()) ^ number(bytes).rotate_left(1)), Ordering::Relaxed);
    }

    fn counted(&self, name: &str, path: impl AsRef<Path>) -> Result<Vec<u8>> {
        let bytes = file(&path)?;
        self.count(name, &bytes);
        if let (Some(path), Ok(mut opened)) = (place(path.as_ref()), self.opened.lock()) {
            opened.insert(path);
        }
        Ok(bytes)
    }

    /// Errors if one of these files, which are to be written, was read here: it would be lost.
    pub fn spares<'p>(&self, outputs: impl IntoIterator<Item = &'p Path>) -> Outcome<()> {
        let read =
            |path: &&Path| place(path).is_some_and(|path| path.is_file() && self.opened.lock().is_ok_and(|opened| opened.contains(&path)));
        outputs.into_iter().find(read).map_or(Ok(()), |path| Err(lost(path).into()))
    }
}

/// A number for some bytes, eight at a time.
fn number(bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks();
    let words = words.iter().map(|word| u64::from_le_bytes(*word));
    let rest = rest.iter().map(|byte| u64::from(*byte));
    words.chain(rest).fold(bytes.len() as u64, |number, word| mix64(number ^ word))
}

impl Resolve for Disk<'_> {
    fn scene(&self, path: &str) -> Result<Vec<u8>> {
        self.counted(path, path)
    }

    fn library(&self, name: &str) -> Result<Vec<u8>> {
        if name.starts_with(['/', '.']) || Path::new(name).is_absolute() {
            return self.counted(name, name);
        }
        if let Some(rest) = name.strip_prefix('~') {
            let Some(home) = std::env::var_os("HOME").filter(|_| rest.starts_with('/')) else {
                return Err(Error::new(format!("{name}: only your own home directory is known by ~; write the whole path")));
            };
            return self.counted(name, Path::new(&home).join(rest.trim_start_matches('/')));
        }
        // As in RADIANCE, an empty entry is the current directory, and what cannot be opened in one place is looked for in the next.
        let mut places = self.raypath.iter().map(|directory| directory.join(native(name)));
        if let Some(found) = places.find(|path| path.is_file() && std::fs::File::open(path).is_ok()) {
            return self.counted(name, found);
        }
        if let Some(text) = cal::shipped(name) {
            return Ok(text.into());
        }
        let searched: Vec<_> =
            self.raypath.iter().map(|p| if p.as_os_str().is_empty() { ".".into() } else { p.display().to_string() }).collect();
        Err(Error::new(format!(
            "{name}: not found in {} nor among the files of this program; set RAYPATH to where it is",
            searched.join(":")
        )))
    }

    fn command(&self, command: &str) -> Result<Vec<u8>> {
        if self.commands != Some(Commands::Allow) {
            return Err(Error::new(format!(
                "command not run: {command}; if you trust the scene, give --commands allow (or set RAD_COMMANDS=allow)"
            )));
        }
        if self.started.fetch_add(1, Ordering::Relaxed) >= MAX_COMMANDS {
            return Err(Error::new(format!("command not run: {command}; more than {MAX_COMMANDS} commands (does one print itself?)")));
        }
        let (output, status) = printed(command)?;
        if !status.success() {
            self.console.warn(&format!("command {command}: {status}; what it printed is used"));
        }
        self.count(command, &output);
        Ok(output)
    }

    fn denies(&self) -> bool {
        self.commands == Some(Commands::Deny)
    }
}

/// What a command prints, and how it ends.
pub fn printed(command: &str) -> Result<(Vec<u8>, ExitStatus)> {
    let failed = |e: std::io::Error| Error::new(format!("command {command}: {}", plain(&e)));
    let mut child =
        Command::new("sh").arg("-c").arg(native(command)).stdin(Stdio::null()).stdout(Stdio::piped()).spawn().map_err(failed)?;
    let output = child.stdout.take().map_or_else(|| Ok(Vec::new()), |stdout| all(stdout, &format!("output of {command}")));
    // A child that printed too much waits for a reader for ever.
    if output.is_err() {
        let _ = child.kill();
    }
    let status = child.wait().map_err(failed)?;
    Ok((output?, status))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disk<'a>(directories: &[&Path], commands: Commands, console: &'a Console) -> Disk<'a> {
        let raypath = directories.iter().map(|p| p.to_path_buf()).collect();
        Disk { raypath, ..Disk::new(Some(commands), console) }
    }

    fn silent() -> Console {
        Console::new("tool", true, false, String::new())
    }

    #[test]
    fn library_files_are_searched_in_order_and_the_projects_own_come_last() {
        let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let console = silent();
        let disk = disk(&[first.path(), second.path()], Commands::Deny, &console);
        assert_eq!(disk.library("curves.cal").unwrap(), cal::shipped("curves.cal").unwrap().as_bytes());
        std::fs::write(second.path().join("curves.cal"), "second").unwrap();
        assert_eq!(disk.library("curves.cal").unwrap(), b"second");
        std::fs::create_dir(first.path().join("curves.cal")).unwrap();
        assert_eq!(disk.library("curves.cal").unwrap(), b"second", "a directory is not a file");
        std::fs::remove_dir(first.path().join("curves.cal")).unwrap();
        std::fs::write(first.path().join("curves.cal"), "first").unwrap();
        assert_eq!(disk.library("curves.cal").unwrap(), b"first");
        let absent = disk.library("absent.cal").unwrap_err().to_string();
        assert!(absent.contains(&first.path().display().to_string()) && absent.contains("RAYPATH"));
        assert!(disk.library("./curves.cal").is_err(), "a name with a dot in front is not searched");
    }

    #[test]
    fn the_digest_tells_which_file_holds_what_in_any_order() {
        let console = silent();
        let digest = |files: [(&str, &str); 2]| {
            let disk = disk(&[], Commands::Deny, &console);
            files.iter().for_each(|(name, text)| disk.count(name, text.as_bytes()));
            disk.digest()
        };
        assert_eq!(digest([("a.cal", "1"), ("b.cal", "2")]), digest([("b.cal", "2"), ("a.cal", "1")]));
        assert_ne!(digest([("a.cal", "1"), ("b.cal", "2")]), digest([("a.cal", "2"), ("b.cal", "1")]));
    }

    #[test]
    fn commands_run_only_when_allowed() {
        let refused = disk(&[], Commands::Deny, &silent()).command("echo hello").unwrap_err().to_string();
        assert!(refused.contains("echo hello") && refused.contains("--commands allow"));
        let console = silent();
        let allowed = disk(&[], Commands::Allow, &console);
        assert_eq!(allowed.command("echo hello; exit 3").unwrap(), b"hello\n");
        assert_eq!(allowed.command("cat").unwrap(), b"", "a command does not read our standard input");
        allowed.started.store(MAX_COMMANDS, Ordering::Relaxed);
        assert!(allowed.command("echo hello").is_err());
    }
}
