//! Any renderer: a shell command that says how good a candidate is.

use super::search::Objective;
use super::signal;
use super::stream::plain;
use crate::args::imgdiff::{CHI2, DOF, SCALE};
use crate::error::{Error, Result};
use crate::expand::quoted;
use crate::unknown::Unknown;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// The end of what a command prints that is kept, in bytes.
const KEPT: u64 = 1 << 16;
/// The lines of its complaint that are shown.
const SHOWN: usize = 5;

/// A command that is run for every candidate.
pub struct Exec<'a> {
    command: String,
    unknown: &'a Unknown,
    directory: TempDir,
}

impl<'a> Exec<'a> {
    /// The shell command `command`, in which `{}` stands for the candidate's file as one word, as `$MATERIAL` does.
    pub fn new(command: &str, unknown: &'a Unknown) -> Result<Self> {
        unknown.told_by_file()?;
        let directory = tempfile::Builder::new().prefix("anneal-").tempdir();
        let directory =
            directory.map_err(|e| Error::new(format!("no temporary directory: {}; set TMPDIR to a place for one", plain(&e))))?;
        signal::begun(directory.path());
        let file = directory.path().join("material.rad");
        let word = quoted(&file.to_string_lossy());
        // Quotes around it would undo those of the name.
        let command = ["'{}'", "\"{}\"", "{}"].iter().fold(command.to_string(), |command, place| command.replace(place, &word));
        Ok(Self { command, unknown, directory })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }
}

impl Objective for Exec<'_> {
    fn indifferent(&self) -> &'static str {
        "does the command use $MATERIAL?"
    }

    fn chi2(&mut self, values: &[f64], stage: usize) -> Result<f64> {
        let material = self.path("material.rad");
        let failed = |e: std::io::Error| Error::new(format!("--exec: {}", plain(&e)));
        std::fs::write(&material, self.unknown.document(values)?.bytes()).map_err(failed)?;
        // Files take any amount of output while nobody reads.
        let (out, complaint) = (self.path("stdout"), self.path("stderr"));
        let status = Command::new("sh")
            .args(["-c", &self.command])
            .env("MATERIAL", &material)
            .env("STAGE", (stage + 1).to_string())
            .stdin(Stdio::null())
            .stdout(File::create(&out).map_err(failed)?)
            .stderr(File::create(&complaint).map_err(failed)?)
            .status()
            .map_err(failed)?;
        let complaint = shown(&tail(&complaint).map_err(failed)?);
        if !status.success() {
            return Err(Error::new(format!("--exec: the command ended with {status}{complaint}")));
        }
        let printed = tail(&out).map_err(failed)?;
        chi2(&printed).ok_or_else(|| match printed.trim() {
            _ if is_binary(&printed) => {
                Error::new(format!("--exec: the command printed no text (a picture?); pipe it into imgdiff photo.hdr -{complaint}"))
            }
            "" => Error::new(format!("--exec: the command printed nothing; its last program must print chi-squared{complaint}")),
            _ => Error::new(format!(
                "--exec: the command printed no number but `{}`{complaint}",
                printed.trim().lines().last().unwrap_or_default()
            )),
        })
    }
}

/// Chi-squared among what a program printed: what imgdiff names so, else the last word that is a number, but for what imgdiff says after it.
pub fn chi2(text: &str) -> Option<f64> {
    if is_binary(text) {
        return None;
    }
    let named = |line: &str| match serde_json::from_str(line) {
        Ok(serde_json::Value::Object(measures)) => measures.get(CHI2)?.as_f64(),
        _ => words(line).skip_while(|word| *word != CHI2).nth(1)?.parse().ok(),
    };
    let other = |line: &&str| line.starts_with('{') || line.split(' ').next().is_some_and(|name| [SCALE, DOF].contains(&name));
    let last = |line: &str| words(line).filter_map(|word| word.parse().ok()).last();
    text.lines().rev().find_map(named).or_else(|| text.lines().filter(|line| !other(line)).rev().find_map(last))
}

/// The words of a line, without commas around them; within one they stay: `1,5` is no number, nor two.
fn words(line: &str) -> impl Iterator<Item = &str> {
    let between = |c: char| c.is_whitespace() || matches!(c, ';' | '=' | ':' | '(' | ')');
    line.split(between).map(|word| word.trim_matches(',')).filter(|word| !word.is_empty())
}

/// Whether it holds what no text does.
fn is_binary(text: &str) -> bool {
    text.contains(['\0', char::REPLACEMENT_CHARACTER])
}

/// The end of what was printed to a file.
fn tail(path: &Path) -> std::io::Result<String> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(KEPT)))?;
    let mut bytes = Vec::new();
    file.take(KEPT).read_to_end(&mut bytes)?;
    // It may begin within a letter.
    let whole = if length > KEPT { bytes.iter().position(|byte| byte & 0xC0 != 0x80).unwrap_or(0) } else { 0 };
    Ok(String::from_utf8_lossy(&bytes[whole..]).into_owned())
}

/// The last lines of a complaint, as the end of a message of one line.
fn shown(complaint: &str) -> String {
    let lines: Vec<&str> = complaint.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    if lines.is_empty() { String::new() } else { format!("; it said: {}", lines[lines.len().saturating_sub(SHOWN)..].join(" | ")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rad::Document;
    use crate::unknown::Wishes;

    fn run(command: &str) -> Result<f64> {
        let document = Document::read("s.rad", b"void plastic m 0 0 5 .5 .5 .5 0 0\n".to_vec())?;
        let unknown = Unknown::new(document, &Wishes::default())?;
        Exec::new(command, &unknown)?.chi2(&[0.25, 0.5, 0.5, 0.0, 0.0], 1)
    }

    #[test]
    fn the_command_finds_the_candidate_and_the_stage() {
        assert_eq!(run("awk '{print $7}' $MATERIAL").unwrap(), 0.25);
        assert_eq!(run("awk '{print $7}' {}").unwrap(), 0.25);
        assert_eq!(run("echo chi2=$STAGE").unwrap(), 2.0);
        assert_eq!(run("echo 3; echo '(chi2: -1.5e-3)'; echo done").unwrap(), -1.5e-3);
        assert_eq!(run("echo chi2=0.25 rmse=7").unwrap(), 0.25);
        assert_eq!(run("echo 0.5, 0.25,").unwrap(), 0.25);
        assert_eq!(run("echo 0.25; echo scale 1.5; echo dof 768").unwrap(), 0.25);
        assert_eq!(run("echo chi2 0.25; echo mse 1; echo max 7").unwrap(), 0.25);
        assert_eq!(run(r#"echo '{"chi2":0.25,"max_at":{"channel":"red","x":3,"y":4},"pixels":900}'"#).unwrap(), 0.25);
        assert!(run(r#"echo '{"mse":0.25,"pixels":900}'"#).unwrap_err().message.contains("no number"));
        assert_eq!(run("cat; yes | head -c 200000; echo 7; yes | head -c 200000 >&2").unwrap(), 7.0);
    }

    #[test]
    fn what_goes_wrong_is_said_in_one_line() {
        let message = |command: &str| run(command).unwrap_err().message;
        assert_eq!(
            message("echo no scene >&2; echo at all >&2; exit 3"),
            "--exec: the command ended with exit status: 3; it said: no scene | at all"
        );
        assert!(message("true").contains("printed nothing; its last program must print chi-squared"));
        assert!(message("echo hello; echo oops >&2").contains("no number but `hello`; it said: oops"));
        assert!(message("echo 1,5").contains("no number but `1,5`"));
        assert!(message("/no/such/program").contains("/no/such/program"));
        assert!(message("echo -Y 32 +X 32; head -c 4 /dev/zero").contains("printed no text (a picture?); pipe it into imgdiff"));
    }
}
