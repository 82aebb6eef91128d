//! The options of rays on standard input.

use super::{either, modifiers};
use crate::error::Result;
use clap::ArgAction;
use std::collections::HashSet;

/// How rays are read and what is said of them.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Ray options (without a view)")]
pub struct RayOptions {
    /// Form of the input and of the output: a text, f single, d double precision, c RGBE (output) [default: a]
    #[arg(long, value_name = "IO")]
    pub format: Option<String>,

    /// What to say of each ray, letter by letter: o origin, d direction, v value, V contribution, w weight, W coefficient, l effective length,
    /// L length, c local coordinates, p point, n normal, N unperturbed normal, s surface, m modifier, M material, r x mirrored and
    /// unmirrored part, R X their lengths, ~ a tilde; after t (T: with shadow rays) for every ray it leads to [default: v]
    #[arg(long, value_name = "LETTERS")]
    pub specifiers: Option<String>,

    /// Write a header [default: on]
    #[arg(long = "h")]
    pub header: Option<bool>,

    /// Each ray ends where the vector of its direction does
    #[arg(long = "ld")]
    pub limit: Option<bool>,

    /// Irradiance at the point, on the side the direction points to
    #[arg(long = "I")]
    pub point_irradiance: Option<bool>,

    /// After -ot: leave out rays that meet this modifier
    #[arg(long = "te", value_name = "MOD", action = ArgAction::Append)]
    pub exclude: Vec<String>,

    /// After -ot: only rays that meet this modifier
    #[arg(long = "ti", value_name = "MOD", action = ArgAction::Append)]
    pub include: Vec<String>,

    /// As -te, for the modifiers listed in a file
    #[arg(long = "tE", value_name = "FILE", action = ArgAction::Append)]
    pub exclude_files: Vec<String>,

    /// As -ti, for the modifiers listed in a file
    #[arg(long = "tI", value_name = "FILE", action = ArgAction::Append)]
    pub include_files: Vec<String>,
}

impl RayOptions {
    /// The form of the input and of the output, as `-f` has it.
    pub fn format(&self) -> &str {
        self.format.as_deref().unwrap_or("aa")
    }

    /// What to say of each ray, as `-o` has it.
    pub fn specifiers(&self) -> &str {
        self.specifiers.as_deref().unwrap_or("v")
    }

    /// Whether to write a header.
    pub fn header(&self) -> bool {
        self.header.unwrap_or(true)
    }

    /// Whether each ray ends where the vector of its direction does.
    pub fn limited(&self) -> bool {
        self.limit.unwrap_or(false)
    }

    /// Whether to tell irradiance at the points.
    pub fn point_irradiance(&self) -> bool {
        self.point_irradiance.unwrap_or(false)
    }

    /// The modifiers of what is told of (true), or is not (false). `list` gives the words of a file of modifiers.
    pub fn among(&self, list: &dyn Fn(&str) -> Result<Vec<String>>) -> Result<Option<(bool, HashSet<String>)>> {
        let excluded = modifiers(&self.exclude, &self.exclude_files, list)?;
        let included = modifiers(&self.include, &self.include_files, list)?;
        either(excluded, included, "-te and -ti exclude each other: give either what is told of or what is not")
    }
}
