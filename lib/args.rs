//! What was typed: RADIANCE's spellings made words that clap knows, and the options that all four programs share.
//!
//! Each option is declared once, in the clap structure of its program: its name, its number of values (`num_args`), its
//! help. A long name of one or two letters (`ab`, `vp`, `u`) is RADIANCE's and is typed and shown with one dash. An
//! `Option<bool>` is one of RADIANCE's switches: `-u+`, `-u-`, or `-u` for the contrary of what holds.

use crate::error::{Error, Result};
use crate::rad::decode;
use crate::render::WIDEST;
use clap::builder::{OsStringValueParser, TypedValueParser};
use clap::{ArgAction, CommandFactory, Parser};
use spelling::{Rewritten, attached, is_radiance, is_switch, rewrite};
use std::any::TypeId;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

pub mod anneal;
pub mod imgdiff;
pub mod rparse;
pub mod rtrace;
pub mod spelling;

/// Options that mean the same to all four programs.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Common options")]
pub struct Common {
    /// Seed of every random choice; the same seed gives the same bytes
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,

    /// Number of threads [default: all cores]; the result does not depend on it
    #[arg(short = 'n', long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,

    /// Write the result to FILE, which holds its old content or the whole new one, never a part
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// No progress and no notes; warnings and errors remain
    #[arg(short, long)]
    pub quiet: bool,

    /// Show progress even if standard error is not a terminal
    #[arg(long, overrides_with = "quiet")]
    pub progress: bool,

    /// Print the manual page
    #[arg(long, exclusive = true)]
    man: bool,

    /// Print completions for a shell: bash, elvish, fish, powershell or zsh
    #[arg(long, exclusive = true, value_name = "SHELL", hide_possible_values = true)]
    completions: Option<clap_complete::Shell>,
}

impl Common {
    /// Where the result goes: to a file, or for `-` to standard output.
    pub fn output(&self) -> &Path {
        self.output.as_deref().unwrap_or(Path::new("-"))
    }
}

/// Options of the programs that read scene descriptions.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Scenes {
    /// Whether the commands in scene files may run programs of this machine; the common generators always run inside the
    /// process, unless all are denied [default: what RAD_COMMANDS says, else refuse others]
    #[arg(
        long,
        value_name = "allow|deny",
        help_heading = "Common options",
        hide_possible_values = true,
        env = "RAD_COMMANDS",
        hide_env = true
    )]
    pub commands: Option<Commands>,
}

/// Options of the programs that render scenes.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Reading scenes")]
pub struct Reading {
    /// Definitions of names for the expressions in the scene, as in a function file
    #[arg(long = "e", value_name = "NAME=EXPR", value_parser = definition, action = ArgAction::Append)]
    pub definitions: Vec<String>,

    /// A function file with such definitions
    #[arg(short = 'f', value_name = "FILE", action = ArgAction::Append)]
    pub function_files: Vec<String>,

    /// Leave out surfaces whose material is not supported, and say so, instead of refusing the scene
    #[arg(long)]
    pub skip_unsupported: bool,
}

/// What was said of commands in scene files.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Commands {
    /// Any command runs in the shell.
    Allow,
    /// No command runs, not even those that are built in.
    Deny,
}

/// A radius of a pixel's filter, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radius(pub f64);

fn radius(word: &str) -> std::result::Result<Radius, String> {
    let radius = word.parse().ok().filter(|radius| (0.0..=WIDEST).contains(radius));
    radius.map(Radius).ok_or_else(|| format!("not a radius; give one in pixels, from 0 to {WIDEST}"))
}

/// The words of every view option, in the order they were typed: `-vf cam.vf -vp 0 0 5 -vth`.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(
    after_help = "View options, as for rpict: -vf FILE; -vtv, l, c, h, a or s; -vp X Y Z; -vd X Y Z; -vu X Y Z; -vh N; -vv N; -vo N; -va N; \
                        -vs N; -vl N. They apply in the order they are given."
)]
pub struct ViewWords {
    /// For [`crate::view::View::apply`].
    #[arg(id = spelling::VIEW_WORDS, long = spelling::VIEW_WORDS, hide = true, action = ArgAction::Append)]
    pub words: Vec<String>,
}

impl ViewWords {
    /// The files among them.
    pub fn files(&self) -> impl Iterator<Item = &str> {
        self.words.windows(2).filter(|two| two[0] == "-vf").map(|two| two[1].as_str())
    }
}

/// What a command line asks for.
#[derive(Debug)]
pub enum Typed<A> {
    /// To run, with these arguments; and the command line without what cannot change the result, for the header of a picture.
    Run(A, String),
    /// To print this on standard output and end: help, version, manual page, completions.
    Print(Vec<u8>),
}

/// Understands the words of a command line, the program's name first. `read` gives the text of an `@FILE`.
pub fn parse<A: Parser>(words: Vec<OsString>, read: &dyn Fn(&str) -> Result<String>) -> Result<Typed<A>> {
    let mut command = command::<A>();
    let Rewritten { words, trail } = rewrite(&command, words, read)?;
    let matches = match command.try_get_matches_from_mut(words) {
        Ok(matches) => matches,
        Err(error) if !error.use_stderr() => return Ok(Typed::Print(one_dash(&error.render().to_string(), " -").into_bytes())),
        Err(error) => return Err(usage(&error)),
    };
    let mut printed = Vec::new();
    if matches.get_flag("man") {
        clap_mangen::Man::new(command).render(&mut printed).map_err(|e| Error::new(e.to_string()))?;
        let page = String::from_utf8_lossy(&printed).replace("\\-", "-");
        return Ok(Typed::Print(one_dash(&page, "-").replace('-', "\\-").into_bytes()));
    }
    if let Some(&shell) = matches.get_one::<clap_complete::Shell>("completions") {
        let name = command.get_name().to_string();
        clap_complete::generate(shell, &mut command, name, &mut printed);
        return Ok(Typed::Print(printed));
    }
    A::from_arg_matches(&matches).map(|arguments| Typed::Run(arguments, trail)).map_err(|e| usage(&e))
}

/// The program's options as clap shall take them: the last of two counts, values may begin with a dash, exactly as many as declared.
fn command<A: CommandFactory>() -> clap::Command {
    let mut command = A::command().args_override_self(true).disable_help_flag(true).disable_version_flag(true);
    let mut help = clap::Arg::new("help").long("help").action(ArgAction::Help).help("Print help").help_heading("Common options");
    if !command.get_arguments().any(|a| a.get_long() == Some("h")) {
        help = help.short('h');
    }
    let version = clap::Arg::new("version").long("version").action(ArgAction::Version).help("Print version").help_heading("Common options");
    command = command.arg(help).arg(version).mut_args(|argument| {
        let number = argument.get_action().takes_values() && argument.get_value_parser().type_id() == TypeId::of::<f64>();
        let argument = if number { argument.value_parser(finite) } else { argument };
        if argument.is_positional() || !argument.get_action().takes_values() {
            argument
        } else if is_switch(&argument) {
            argument.value_name("+|-").hide_possible_values(true)
        } else if argument.get_num_args().is_some_and(|n| n.min_values() > 1 && n.min_values() == n.max_values()) {
            argument.allow_hyphen_values(true).action(ArgAction::Set)
        } else {
            argument.allow_hyphen_values(true)
        }
    });
    command.build();
    command
}

/// A name of a file, whatever its encoding.
fn name() -> impl TypedValueParser<Value = String> {
    OsStringValueParser::new().map(|name| decode(name.into_encoded_bytes()))
}

/// A definition for expressions, which has a sign in it that defines.
fn definition(text: &str) -> std::result::Result<String, String> {
    let defines = text.contains(['=', ':']);
    defines.then(|| text.into()).ok_or_else(|| "not a definition like NAME=EXPR; for rpict's -e FILE write 2> FILE".into())
}

/// A number that is one.
fn finite(word: &str) -> std::result::Result<f64, String> {
    word.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| "not a finite number".into())
}

/// A usage error as one line: what is wrong, what was perhaps meant, where to find more. Errors of our own within it say no second time
/// that they are some.
fn usage(error: &clap::Error) -> Error {
    let text = one_dash(&error.render().to_string(), "-").replace("invalid digit found in string", "not a whole number");
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let mut message = lines.next().unwrap_or_default().trim_start_matches("error: ").replace(": error: ", ": ");
    for line in lines.take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more")) {
        message += if message.ends_with(':') { " " } else { "; " };
        message += line.trim_start_matches("tip: ");
    }
    Error::new(message + " (--help lists all options)")
}

/// The text with the two dashes of RADIANCE's short names become `dash`, and what is attached to a letter shown so.
fn one_dash(text: &str, dash: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let name = rest[at + 2..].split(|c: char| !c.is_ascii_alphanumeric() && c != '-').next().unwrap_or_default();
        out += &rest[..at];
        rest = &rest[at + 2 + name.len()..];
        if let Some(letter) = attached(name) {
            // Its value follows without a blank.
            out += dash;
            out.push(letter);
            if let Some((end, value)) = [r"\fR ", " "].iter().find_map(|end| Some((end, rest.strip_prefix(end)?))) {
                out += end.trim_end();
                rest = value;
            }
            continue;
        }
        out += if !name.is_empty() && is_radiance(name) { dash } else { "--" };
        out += name;
    }
    out + rest
}
