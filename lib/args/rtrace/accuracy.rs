//! How accurate, or how long: the dial.

use crate::error::{Error, Result};
use crate::render::{Budget, DEFAULT_ERROR, range};
use std::ops::Range;
use std::time::Duration;

/// Accuracy for time: at most one of these.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Accuracy for time")]
#[group(multiple = false)]
pub struct Accuracy {
    /// Stop when the estimated relative standard error is this [default: 0.05]
    #[arg(long, value_name = "E")]
    pub error: Option<f64>,

    /// Samples a pixel
    #[arg(long, value_name = "N")]
    pub spp: Option<u32>,

    /// Of each pixel only the samples from number A on and before B; keeps their sums (OpenEXR). --merge makes of 0..8 and 8..16 what
    /// --spp 16 gives
    #[arg(long, value_name = "A..B", value_parser = samples, conflicts_with_all = ["variance", "aov", "coverage", "xyz"])]
    pub samples: Option<Range<u32>>,

    /// The best picture in this many seconds; of rays, for those that are answered together
    #[arg(long, value_name = "S")]
    pub time: Option<f64>,
}

/// A range of samples.
fn samples(word: &str) -> std::result::Result<Range<u32>, String> {
    range(word).ok_or_else(|| "not a range of samples; write 0..16 for the first 16".into())
}

impl Accuracy {
    /// The budget these options ask for.
    pub fn budget(&self) -> Result<Budget> {
        let positive = |name: &str, value: f64| match value > 0.0 {
            true => Ok(value),
            false => Err(Error::new(format!("--{name} must be above 0, not {value}"))),
        };
        if let Some(range) = &self.samples {
            return Ok(Budget::Samples(range.end - range.start));
        }
        Ok(match (self.error, self.spp, self.time) {
            (_, Some(0), _) => return Err(Error::new("--spp must be at least 1")),
            (_, Some(samples), _) => Budget::Samples(samples),
            (_, _, Some(seconds)) => Budget::Time(Duration::from_secs_f64(positive("time", seconds)?.min(1e9))),
            (error, ..) => Budget::Error(positive("error", error.unwrap_or(DEFAULT_ERROR))?),
        })
    }

    /// The index of the first sample.
    pub fn first(&self) -> u32 {
        self.samples.as_ref().map_or(0, |range| range.start)
    }
}
