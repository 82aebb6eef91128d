//! The options of imgdiff.

use super::Common;
use crate::metric::Measures;
use std::path::PathBuf;

/// The name of the measure that stands for all others, beside others and in JSON.
pub const CHI2: &str = "chi2";
/// What is printed after the measures: what B was multiplied with, and the degrees of freedom.
pub const SCALE: &str = "scale";
/// See [`SCALE`].
pub const DOF: &str = "dof";

/// How far is one picture from another?
///
/// Prints chi-squared: the sum over all pixels of the squared differences of red, green and blue, in radiance. A and B are RADIANCE pictures (.hdr, .pic) or OpenEXR files of one size; - is standard input. A is the reference. Exposure
/// and colour correction are undone, XYZ is turned to RGB.
///
/// One measure is printed as a bare number on the first line, several as name and value on a line each. Exit status: 0 done, 1 the
/// measure exceeds --fail-above, 2 trouble.
#[derive(clap::Parser, Clone, Debug)]
#[command(name = "imgdiff", version)]
pub struct Args {
    /// The reference: a photograph, or a picture known to be right
    pub a: String,

    /// What shall resemble it
    #[arg(default_value = "-")]
    pub b: String,

    /// What to print, separated by commas: chi2, mse, rmse, relmse, mape, psnr, max (relmse is relative to A² + .01 m²,
    /// mape to |A| + .01 m, where m is the mean of A)
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = "chi2", hide_possible_values = true)]
    pub metric: Vec<Metric>,

    /// Print every measure
    #[arg(long, conflicts_with = "metric")]
    pub all: bool,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,

    /// Count only where the picture M is not black; values between 0 and 1 count in part
    #[arg(long, value_name = "M")]
    pub mask: Option<String>,

    /// Divide the squared differences in chi2 by these variances (channels variance.R, .G, .B, or R, G, B); also prints the degrees of
    /// freedom
    #[arg(long, value_name = "V")]
    pub variance: Option<String>,

    /// A second rendering like B with another seed: removes what noise adds to chi2, mse and relmse
    #[arg(long, value_name = "C")]
    pub unbiased: Option<String>,

    /// Multiply B by what makes chi2 least, and print it
    #[arg(long)]
    pub fit_exposure: bool,

    /// Exit with status 1 if the measure exceeds X
    #[arg(long, value_name = "X")]
    pub fail_above: Option<f64>,

    /// Write a picture of the differences: warm where B is brighter, cold where A is
    #[arg(long, value_name = "FILE.png")]
    pub heatmap: Option<PathBuf>,

    /// Write A, B and the differences beside each other
    #[arg(long, value_name = "FILE.png")]
    pub side_by_side: Option<PathBuf>,

    /// What all programs share.
    #[command(flatten)]
    pub common: Common,
}

/// A measure by its name.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// Sum of squared differences.
    Chi2,
    /// Their mean.
    Mse,
    /// The root of their mean.
    Rmse,
    /// Mean of squared differences relative to A.
    Relmse,
    /// Mean of differences relative to A.
    Mape,
    /// Peak signal to noise ratio in decibels.
    Psnr,
    /// The largest difference.
    Max,
}

impl Metric {
    /// Its name and its value.
    pub fn of(self, m: &Measures) -> (&'static str, f64) {
        match self {
            Self::Chi2 => (CHI2, m.chi2),
            Self::Mse => ("mse", m.mse),
            Self::Rmse => ("rmse", m.rmse()),
            Self::Relmse => ("relmse", m.relmse),
            Self::Mape => ("mape", m.mape),
            Self::Psnr => ("psnr", m.psnr()),
            Self::Max => ("max", m.max),
        }
    }
}

impl AsRef<Common> for Args {
    fn as_ref(&self) -> &Common {
        &self.common
    }
}

impl Args {
    /// The measures to print, in order; of all, those that a second rendering leaves meaningful. Errors if the options do not go together.
    pub fn metrics(&self) -> crate::error::Result<Vec<Metric>> {
        use Metric::{Chi2, Mape, Max, Mse, Psnr, Relmse, Rmse};
        let fails = |message: &str| Err(crate::error::Error::new(message));
        let unbiased = [Chi2, Mse, Relmse];
        let metrics = match (self.all, &self.unbiased) {
            (true, None) => vec![Chi2, Mse, Rmse, Relmse, Mape, Psnr, Max],
            (true, Some(_)) => unbiased.to_vec(),
            (false, _) => self.metric.clone(),
        };
        if self.unbiased.is_some() && metrics.iter().any(|metric| !unbiased.contains(metric)) {
            return fails("--unbiased goes with chi2, mse and relmse only: the others are not sums of squares");
        }
        if self.fail_above.is_some() && metrics.len() != 1 {
            return fails("--fail-above needs to know which measure: give one with --metric");
        }
        if self.fail_above.is_some() && metrics == [Psnr] {
            return fails("--fail-above with psnr would fail on good pictures; use rmse or max");
        }
        Ok(metrics)
    }
}
