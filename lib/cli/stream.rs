//! Files and pipes: inputs read whole, outputs complete or absent.

use super::{Outcome, Stop, signal};
use crate::error::{Error, Result};
use crate::rad::encode;
use std::collections::HashSet;
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::NamedTempFile;

/// The largest input that is read, in bytes.
const INPUT_LIMIT: u64 = 1 << 32;

/// Links that one name may lead through.
const LINKS: usize = 40;

/// The name for messages, and all bytes, of the file `name`, or for `-` of standard input, which can be read only once.
pub fn input(name: impl AsRef<OsStr>) -> Result<(String, Vec<u8>)> {
    static STDIN_TAKEN: AtomicBool = AtomicBool::new(false);
    let name = name.as_ref();
    if name != "-" {
        return Ok((name.to_string_lossy().into_owned(), file(name)?));
    }
    if STDIN_TAKEN.swap(true, Ordering::Relaxed) {
        return Err(Error::new("standard input can be read only once; write - for one input only"));
    }
    Ok(("<stdin>".into(), all(io::stdin().lock(), "<stdin>")?))
}

/// A name or a command as the operating system knows it: the bytes that were written, whatever their encoding.
pub fn native(text: &str) -> OsString {
    #[cfg(unix)]
    return std::os::unix::ffi::OsStringExt::from_vec(encode(text));
    #[cfg(not(unix))]
    return text.into();
}

/// Where a file of that name is, if there is one: its one path.
pub fn place(name: &Path) -> Option<PathBuf> {
    std::fs::canonicalize(path(name)).ok()
}

/// A file's name as the operating system knows it.
fn path(name: &Path) -> PathBuf {
    name.to_str().map_or_else(|| name.to_path_buf(), |text| native(text).into())
}

/// All bytes of a file.
pub fn file(name: impl AsRef<Path>) -> Result<Vec<u8>> {
    let name = name.as_ref();
    let shown = name.display().to_string();
    all(File::open(path(name)).map_err(|e| Error::new(format!("{shown}: {}", plain(&e))))?, &shown)
}

/// All bytes of a stream, up to the limit.
pub fn all(stream: impl Read, name: &str) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.take(INPUT_LIMIT + 1).read_to_end(&mut bytes).map_err(|e| Error::new(format!("{name}: {}", plain(&e))))?;
    if bytes.len() as u64 > INPUT_LIMIT {
        return Err(Error::new(format!("{name}: longer than {} GiB, the most that is read", INPUT_LIMIT >> 30)));
    }
    Ok(bytes)
}

/// What the operating system said, in its words.
pub fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or_default();
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// Whether standard output goes to that file.
fn is_stdout(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let place = |path: &Path| std::fs::metadata(path).ok().map(|file| (file.dev(), file.ino()));
        place(path).is_some_and(|file| place(Path::new("/dev/stdout")) == Some(file))
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

/// An output: standard output, a device or pipe, or a file that is written beside its name and renamed when finished.
pub struct Output {
    name: String,
    to: To,
}

enum To {
    Stdout(BufWriter<io::Stdout>),
    Device(BufWriter<File>),
    File(BufWriter<NamedTempFile>, PathBuf),
}

impl Output {
    /// An output to the file, or to standard output if there is none or its name is `-`.
    pub fn create(path: Option<&Path>) -> Outcome<Self> {
        let Some(path) = path.filter(|path| *path != Path::new("-")) else {
            return Ok(Self { name: "standard output".into(), to: To::Stdout(BufWriter::with_capacity(1 << 16, io::stdout())) });
        };
        let name = path.display().to_string();
        let failed = |e: io::Error| Error::new(format!("{name}: {}", plain(&e)));
        // A link keeps pointing to the file, which is replaced where it stands.
        let path = std::fs::canonicalize(path).unwrap_or_else(|_| behind_links(path));
        let existing = std::fs::metadata(&path).ok();
        if existing.as_ref().is_some_and(|m| m.is_dir()) {
            return Err(Error::new(format!("{name}: is a directory")).into());
        }
        if existing.as_ref().is_some_and(|m| !m.is_file()) {
            let device = File::options().write(true).open(&path).map_err(failed)?;
            return Ok(Self { name, to: To::Device(BufWriter::new(device)) });
        }
        let directory = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".inverad-");
        #[cfg(unix)]
        let permissions = existing.map_or_else(|| std::os::unix::fs::PermissionsExt::from_mode(0o666), |m| m.permissions());
        #[cfg(unix)]
        builder.permissions(permissions);
        let file = builder.tempfile_in(directory).map_err(failed)?;
        signal::begun(file.path());
        Ok(Self { name, to: To::File(BufWriter::with_capacity(1 << 16, file), path) })
    }

    /// Errors if one of the files that are to be written later could not be, is named twice, or is one of the `sources` that are read and would be lost,
    /// so that long work is not done for nothing. What is there stays as it is; a pipe or a device is not tried, since whoever reads it would take the
    /// trial for the whole.
    pub fn check<'a>(paths: impl IntoIterator<Item = &'a Path>, sources: &[&str]) -> Outcome<()> {
        let mut places = HashSet::new();
        for path in paths {
            if std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir()) {
                continue;
            }
            let there = place(path);
            if there.is_some() && sources.iter().any(|source| place(source.as_ref()) == there) {
                return Err(lost(path).into());
            }
            let mut place = None;
            if let To::File(writer, path) = Self::create(Some(path))?.to {
                signal::ended(writer.get_ref().path());
                let directory = writer.get_ref().path().parent().and_then(|directory| directory.canonicalize().ok());
                place = Some((directory, path.file_name().map(OsStr::to_os_string))).filter(|_| !is_stdout(&path));
            }
            if !places.insert(place) {
                return Err(Error::new(format!("{}: named for two outputs; give each a file of its own", path.display())).into());
            }
        }
        Ok(())
    }

    /// Writes these bytes and no others to the file, or to standard output if there is none or its name is `-`.
    pub fn whole(path: Option<&Path>, bytes: &[u8]) -> Outcome<()> {
        let mut output = Self::create(path)?;
        output.write(bytes)?;
        output.finish()
    }

    /// Writes these bytes.
    pub fn write(&mut self, bytes: &[u8]) -> Outcome<()> {
        let written = self.writer().write_all(bytes);
        self.outcome(written)
    }

    /// Hands on what was written so far, for a reader that waits for it.
    pub fn flush(&mut self) -> Outcome<()> {
        let flushed = self.writer().flush();
        self.outcome(flushed)
    }

    /// Completes the output: only now does a file appear under its name.
    pub fn finish(mut self) -> Outcome<()> {
        self.flush()?;
        let To::File(writer, path) = self.to else { return Ok(()) };
        let failed = |e: io::Error| Error::new(format!("{}: {}", self.name, plain(&e)));
        let file = writer.into_inner().map_err(|e| failed(e.into_error()))?;
        file.as_file().sync_all().map_err(failed)?;
        let temporary = file.path().to_path_buf();
        file.persist(&path).map_err(|e| failed(e.error))?;
        signal::ended(&temporary);
        Ok(())
    }

    fn writer(&mut self) -> &mut dyn Write {
        match &mut self.to {
            To::Stdout(writer) => writer,
            To::Device(writer) => writer,
            To::File(writer, _) => writer,
        }
    }

    /// A closed pipe ends the program quietly, any other failure with a message.
    fn outcome(&self, result: io::Result<()>) -> Outcome<()> {
        result.map_err(|e| match e.kind() {
            ErrorKind::BrokenPipe => Stop::Closed,
            _ => Error::new(format!("{}: {}", self.name, plain(&e))).into(),
        })
    }
}

/// That a file which is to be written is read too.
pub fn lost(path: &Path) -> Error {
    Error::new(format!("{}: read here, and would be lost; give the output a file of its own", path.display()))
}

/// What a link that leads to no file yet stands for; any other path as it is.
fn behind_links(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..LINKS {
        let Some(to) = std::fs::read_link(&path).ok().filter(|_| !path.exists()) else { break };
        path = path.parent().unwrap_or(Path::new("")).join(to);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_appears_only_when_finished_and_keeps_its_permissions() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out");
        std::fs::write(&path, "old").unwrap();
        #[cfg(unix)]
        std::fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o640)).unwrap();
        let mut given_up = Output::create(Some(&path)).unwrap();
        given_up.write(b"part").unwrap();
        given_up.flush().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        drop(given_up);
        let mut output = Output::create(Some(&path)).unwrap();
        output.write(b"new").unwrap();
        output.finish().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 1, "nothing is left beside it");
        #[cfg(unix)]
        assert_eq!(std::os::unix::fs::PermissionsExt::mode(&std::fs::metadata(&path).unwrap().permissions()) & 0o777, 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_keeps_pointing_to_the_file_and_a_full_device_is_an_error() {
        let directory = tempfile::tempdir().unwrap();
        let (path, link) = (directory.path().join("file"), directory.path().join("link"));
        std::fs::write(&path, "old").unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        let mut output = Output::create(Some(&link)).unwrap();
        output.write(b"new").unwrap();
        output.finish().unwrap();
        assert!(link.is_symlink() && std::fs::read(&path).unwrap() == b"new");
        // So does one to a file that is not there yet, by way of another one.
        let (far, near) = (directory.path().join("far"), directory.path().join("near"));
        std::os::unix::fs::symlink("near", &far).unwrap();
        std::os::unix::fs::symlink("later", &near).unwrap();
        Output::whole(Some(&far), b"first").unwrap();
        assert!(far.is_symlink() && near.is_symlink() && std::fs::read(directory.path().join("later")).unwrap() == b"first");
        if Path::new("/dev/full").exists() {
            let mut output = Output::create(Some(Path::new("/dev/full"))).unwrap();
            output.write(b"text").unwrap();
            assert!(matches!(output.finish(), Err(Stop::Failed(e)) if e.message == "/dev/full: no space left on device"));
        }
    }

    #[test]
    fn what_could_not_be_written_is_said_before_and_what_could_is_left_alone() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        std::fs::write(&path, "old").unwrap();
        let new = directory.path().join("new");
        Output::check([&*path, &*new, Path::new("-"), Path::new("/dev/null"), Path::new("/dev/null")], &["none"]).unwrap();
        assert!(Output::check([&*directory.path().join("no/such")], &[]).is_err() && Output::check([directory.path()], &[]).is_err());
        let source = directory.path().join("./file").display().to_string();
        assert!(matches!(Output::check([&*path], &["-", &source]), Err(Stop::Failed(e)) if e.message.contains("would be lost")));
        for twice in [[&*path, &*directory.path().join("./file")], [&*new, &*new], [Path::new("-"), Path::new("-")]] {
            assert!(matches!(Output::check(twice, &[]), Err(Stop::Failed(e)) if e.message.contains("named for two outputs")));
        }
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(&directory).unwrap().count(), 1);
    }

    #[test]
    fn errors_name_the_file_in_plain_words() {
        assert_eq!(input("/no/such").unwrap_err().message, "/no/such: no such file or directory");
        assert!(
            matches!(Output::create(Some(Path::new("/no/such"))), Err(Stop::Failed(e)) if e.message == "/no/such: no such file or directory")
        );
    }
}
