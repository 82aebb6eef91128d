//! What a person types to `rtrace-rs`, and what it means as [`Rules`] and [`Budget`].

use super::{Common, Scenes, ViewWords};
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::render::{Budget, DEFAULT_ERROR};
use crate::rules::{FRESNEL_OFFSET, Rules, Ward};
use std::path::PathBuf;
use std::time::Duration;

/// Renders RADIANCE scenes. With a view it writes a picture; without one it reads rays on standard input and writes what they see.
#[derive(clap::Parser, Clone, Debug)]
#[command(name = "rtrace-rs", version, max_term_width = 100)]
pub struct Arguments {
    /// Scene files, or an octree; - is standard input
    #[arg(value_name = "SCENE", required = true)]
    pub scenes: Vec<String>,

    /// The view.
    #[command(flatten)]
    pub view: ViewWords,

    /// The picture.
    #[command(flatten)]
    pub picture: PictureOptions,

    /// The light.
    #[command(flatten)]
    pub light: Light,

    /// How accurate.
    #[command(flatten)]
    pub accuracy: Accuracy,

    /// How scenes are read.
    #[command(flatten)]
    pub scene_options: Scenes,

    /// Leave out surfaces whose material is not supported, and say so, instead of refusing the scene
    #[arg(long)]
    pub skip_unsupported: bool,

    /// What all programs share.
    #[command(flatten)]
    pub common: Common,
}

/// The size and kind of a picture.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Picture options")]
pub struct PictureOptions {
    /// Largest width of the picture in pixels
    #[arg(long = "x", value_name = "N", default_value_t = 512)]
    pub x: usize,

    /// Largest height of the picture in pixels
    #[arg(long = "y", value_name = "N", default_value_t = 512)]
    pub y: usize,

    /// Pixel aspect ratio, height over width; 0 keeps the size
    #[arg(long = "pa", value_name = "F", default_value_t = 1.0)]
    pub pa: f64,

    /// The part of a pixel's width that its samples cover; 0 samples centres
    #[arg(long = "pj", value_name = "F", default_value_t = 1.0)]
    pub pj: f64,

    /// Write OpenEXR instead of a RADIANCE picture, as for an output file that ends in .exr
    #[arg(long)]
    pub exr: bool,

    /// Keep the variance of each pixel
    #[arg(long, value_name = "FILE.exr")]
    pub variance: Option<PathBuf>,
}

/// Light transport, in RADIANCE's options. What is not given is not limited.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Light transport (as RADIANCE when given; otherwise converged)")]
pub struct Light {
    /// Diffuse bounces [default: all]
    #[arg(long = "ab", value_name = "N")]
    pub ab: Option<u32>,

    /// Radiance that stands for what the bounces leave out
    #[arg(long = "av", value_names = ["R", "G", "B"], num_args = 3)]
    pub av: Option<Vec<f64>>,

    /// Limit of reflections; negative or 0: roulette decides
    #[arg(long = "lr", value_name = "N")]
    pub lr: Option<i32>,

    /// Smallest weight of a ray
    #[arg(long = "lw", value_name = "F")]
    pub lw: Option<f64>,

    /// Rough specularity at or below this counts as diffuse [default: 0]
    #[arg(long = "st", value_name = "F")]
    pub st: Option<f64>,

    /// Up to 1.5: RADIANCE's single unweighted sample of rough reflection, narrowed below 1 [default: the lobe itself]
    #[arg(long = "ss", value_name = "F")]
    pub ss: Option<f64>,

    /// One sample of each light source, jittered over this part of it [default: integrated]
    #[arg(long = "dj", value_name = "F")]
    pub dj: Option<f64>,

    /// Mirrors that a light is seen through
    #[arg(long = "dr", value_name = "N")]
    pub dr: Option<u32>,

    /// Whether light sources are seen
    #[arg(long = "dv")]
    pub dv: Option<bool>,

    /// Whether the backs of surfaces are there
    #[arg(long = "bv")]
    pub bv: Option<bool>,

    /// Irradiance instead of radiance
    #[arg(long = "i")]
    pub irradiance: Option<bool>,

    /// Extinction of the medium that fills the scene
    #[arg(long = "me", value_names = ["R", "G", "B"], num_args = 3)]
    pub me: Option<Vec<f64>>,

    /// The reflection lobe of the 2002 paper instead of RADIANCE's present one
    #[arg(long, value_name = "1992", value_parser = ["1992"])]
    pub ward: Option<String>,

    /// What the Fresnel term of polished surfaces is lowered by; RADIANCE before June 2026: .00202943064
    #[arg(long, value_name = "F", default_value_t = FRESNEL_OFFSET, hide = true)]
    pub fresnel_offset: f64,

    /// Options that only tune RADIANCE's approximations are accepted and do nothing: there is nothing to tune
    #[command(flatten)]
    pub tuning: Tuning,
}

/// Options of RADIANCE that only tune its approximations.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Tuning {
    /// Ambient accuracy
    #[arg(long = "aa", hide = true, value_name = "F")]
    aa: Option<f64>,
    /// Ambient resolution
    #[arg(long = "ar", hide = true, value_name = "N")]
    ar: Option<i64>,
    /// Ambient divisions
    #[arg(long = "ad", hide = true, value_name = "N")]
    ad: Option<i64>,
    /// Ambient super-samples
    #[arg(long = "as", hide = true, value_name = "N")]
    r#as: Option<i64>,
    /// Ambient weight
    #[arg(long = "aw", hide = true, value_name = "N")]
    aw: Option<i64>,
    /// Pixel sampling
    #[arg(long = "ps", hide = true, value_name = "N")]
    ps: Option<i64>,
    /// Pixel threshold
    #[arg(long = "pt", hide = true, value_name = "F")]
    pt: Option<f64>,
    /// Light subdivision
    #[arg(long = "ds", hide = true, value_name = "F")]
    ds: Option<f64>,
    /// Shadow threshold
    #[arg(long = "dt", hide = true, value_name = "F")]
    dt: Option<f64>,
    /// Shadow certainty
    #[arg(long = "dc", hide = true, value_name = "F")]
    dc: Option<f64>,
    /// Virtual light pretest
    #[arg(long = "dp", hide = true, value_name = "N")]
    dp: Option<i64>,
    /// Uncorrelated sampling
    #[arg(long = "u", hide = true)]
    u: Option<bool>,
    /// Warnings
    #[arg(long = "w")]
    pub w: Option<bool>,
}

/// Accuracy for time: at most one of these.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
#[command(next_help_heading = "Accuracy for time")]
#[group(multiple = false)]
pub struct Accuracy {
    /// Stop when the estimated relative standard error is this [default: 0.05]
    #[arg(long, value_name = "E")]
    pub error: Option<f64>,

    /// Samples a pixel
    #[arg(long, value_name = "N")]
    pub spp: Option<u32>,

    /// The best picture in this many seconds
    #[arg(long, value_name = "S")]
    pub time: Option<f64>,
}

impl AsRef<Common> for Arguments {
    fn as_ref(&self) -> &Common {
        &self.common
    }
}

impl Light {
    /// What these options say.
    pub fn rules(&self) -> Rules {
        let default = Rules::default();
        let color = |v: &Option<Vec<f64>>, other: Rgb| v.as_ref().map_or(other, |v| Rgb::new(v[0], v[1], v[2]));
        Rules {
            ambient_bounces: self.ab.unwrap_or(default.ambient_bounces),
            ambient_value: color(&self.av, default.ambient_value),
            limit_reflections: self.lr,
            limit_weight: self.lw,
            specular_threshold: self.st.unwrap_or(default.specular_threshold),
            specular_sampling: self.ss,
            light_jitter: self.dj,
            back_visible: self.bv.unwrap_or(default.back_visible),
            lights_visible: self.dv.unwrap_or(default.lights_visible),
            mirror_levels: self.dr.unwrap_or(default.mirror_levels),
            extinction: color(&self.me, default.extinction),
            irradiance: self.irradiance.unwrap_or(default.irradiance),
            lobe: if self.ward.is_some() { Ward::Original } else { default.lobe },
            fresnel_offset: self.fresnel_offset,
        }
    }
}

impl Accuracy {
    /// The budget these options ask for.
    pub fn budget(&self) -> Result<Budget> {
        let positive = |name: &str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(value),
            false => Err(Error::new(format!("--{name} must be above 0, not {value}"))),
        };
        Ok(match (self.error, self.spp, self.time) {
            (_, Some(0), _) => return Err(Error::new("--spp must be at least 1")),
            (_, Some(samples), _) => Budget::Samples(samples),
            (_, _, Some(seconds)) => Budget::Time(Duration::from_secs_f64(positive("time", seconds)?.min(1e9))),
            (error, ..) => Budget::Error(positive("error", error.unwrap_or(DEFAULT_ERROR))?),
        })
    }
}
