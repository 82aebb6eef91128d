//! The options of rparse.

use super::{Common, Scenes};

/// Reads RADIANCE scene descriptions.
///
/// Prints one flat, canonical description of the same scene: inline commands carried out, transforms applied, aliases kept, numbers
/// to full precision. oconv accepts it. With no FILE, or when FILE is -, reads standard input.
///
/// xform, cat, echo, genbox, genprism, genrev, genworm, gensurf, gensky and gendaylit run inside the process; other commands are
/// refused unless --commands allow is given. Exit status: 0 done, 1 --check found errors, 2 trouble.
#[derive(clap::Parser, Clone, Debug)]
#[command(name = "rparse", version)]
pub struct Args {
    /// Scene descriptions, which follow each other; - is standard input, !COMMAND is what a command prints, unless a file has that name
    #[arg(value_name = "FILE", default_value = "-", value_parser = super::name())]
    pub files: Vec<String>,

    /// What to print.
    #[command(flatten)]
    pub mode: Mode,

    /// With --keep: give parameter PARAM (rough, a5) of the modifier ID this value; can be repeated
    #[arg(long, value_name = "ID:PARAM=VALUE", requires = "keep", conflicts_with_all = ["check", "json", "stats", "materials"])]
    pub set: Vec<String>,

    /// What programs that read scenes share.
    #[command(flatten)]
    pub scenes: Scenes,

    /// What all programs share.
    #[command(flatten)]
    pub common: Common,
}

/// What to print instead of a flat description.
#[derive(clap::Args, Clone, Debug)]
#[group(multiple = false)]
pub struct Mode {
    /// Print nothing but every problem; exit status 1 if there is one
    #[arg(long, conflicts_with = "output")]
    pub check: bool,

    /// Print a JSON object on a line for each primitive: file, line, modifier, type, id, sargs, iargs, fargs
    #[arg(long)]
    pub json: bool,

    /// Print only the modifiers that surfaces use, each after those it depends on
    #[arg(long)]
    pub materials: bool,

    /// Print what the scene holds and what rendering it requires
    #[arg(long)]
    pub stats: bool,

    /// Print the files as they are: comments, spacing, order and commands stay
    #[arg(long)]
    pub keep: bool,
}

impl Mode {
    /// Whether it prints a whole scene.
    pub fn is_scene(&self) -> bool {
        !(self.json || self.materials || self.stats || self.check)
    }
}

impl AsRef<Common> for Args {
    fn as_ref(&self) -> &Common {
        &self.common
    }
}
