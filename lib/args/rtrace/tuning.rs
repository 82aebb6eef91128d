//! Options that are accepted so that command lines for RADIANCE work, and mostly do nothing.

/// Options of RADIANCE that only tune its approximations, or that this program has no use for.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Tuning {
    /// Ambient accuracy
    #[arg(long = "aa", hide = true, value_name = "F")]
    pub aa: Option<f64>,
    /// Ambient resolution
    #[arg(long = "ar", hide = true, value_name = "N")]
    pub ar: Option<i64>,
    /// Ambient divisions
    #[arg(long = "ad", hide = true, value_name = "N")]
    pub ad: Option<i64>,
    /// Ambient super-samples
    #[arg(long = "as", hide = true, value_name = "N")]
    pub r#as: Option<i64>,
    /// Ambient weight
    #[arg(long = "aw", hide = true, value_name = "N")]
    pub aw: Option<i64>,
    /// Ambient file
    #[arg(long = "af", hide = true, value_name = "FILE")]
    pub af: Option<String>,
    /// Pixel sampling
    #[arg(long = "ps", hide = true, value_name = "N")]
    pub ps: Option<i64>,
    /// Pixel threshold
    #[arg(long = "pt", hide = true, value_name = "F")]
    pub pt: Option<f64>,
    /// Pixel motion
    #[arg(long = "pm", hide = true, value_name = "F")]
    pub pm: Option<f64>,
    /// Time between reports
    #[arg(long = "t", hide = true, value_name = "S")]
    pub t: Option<f64>,
    /// Shadow threshold
    #[arg(long = "dt", hide = true, value_name = "F")]
    pub dt: Option<f64>,
    /// Shadow certainty
    #[arg(long = "dc", hide = true, value_name = "F")]
    pub dc: Option<f64>,
    /// Virtual light pretest
    #[arg(long = "dp", hide = true, value_name = "N")]
    pub dp: Option<i64>,
    /// Albedo of the medium
    #[arg(long = "ma", hide = true, value_names = ["R", "G", "B"], num_args = 3)]
    pub ma: Option<Vec<f64>>,
    /// Eccentricity of the medium
    #[arg(long = "mg", hide = true, value_name = "F")]
    pub mg: Option<f64>,
    /// Sampling distance in the medium
    #[arg(long = "ms", hide = true, value_name = "F")]
    pub ms: Option<f64>,
    /// Photon search radius
    #[arg(long = "am", hide = true, value_name = "F")]
    pub am: Option<f64>,
    /// Spectral samples
    #[arg(long = "cs", hide = true, value_name = "N")]
    pub cs: Option<i64>,
    /// Wavelengths
    #[arg(long = "cw", hide = true, value_names = ["NM", "NM"], num_args = 2)]
    pub cw: Option<Vec<f64>>,
    /// Uncorrelated sampling
    #[arg(long = "u", hide = true)]
    pub u: Option<bool>,
    /// Spectral output
    #[arg(long = "co", hide = true)]
    pub co: Option<bool>,
    /// Recover a picture
    #[arg(long = "r", hide = true, value_name = "FILE")]
    pub r: Option<String>,
    /// Recover a picture in its place
    #[arg(long = "ro", hide = true, value_name = "FILE")]
    pub ro: Option<String>,
    /// A sequence of views
    #[arg(long = "S", hide = true, value_name = "N")]
    pub sequence: Option<i64>,
    /// Stay in memory
    #[arg(long = "P", hide = true, value_name = "FILE")]
    pub persist: Option<String>,
    /// Stay in memory, many times
    #[arg(long = "PP", hide = true, value_name = "FILE")]
    pub persist_parallel: Option<String>,
    /// Warnings [default: on]
    #[arg(long = "w")]
    pub w: Option<bool>,
}
