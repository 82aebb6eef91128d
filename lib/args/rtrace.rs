//! What a person types to `rtrace-rs`, and what it means as [`Rules`] and a budget.

mod accuracy;
mod explain;
mod modes;
mod rays;
mod tuning;

pub use accuracy::Accuracy;
pub use explain::{FEATURES, defaults, explain, has};
pub use modes::ends_in;
pub use rays::RayOptions;
pub use tuning::Tuning;

use super::{Common, Radius, Reading, Scenes, ViewWords, radius};
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::picture::PRIMARIES;
use crate::rays::Space;
use crate::render::Filter;
use crate::rules::defaults::SIZE;
use crate::rules::{Field, Rules, Ward, lowers_fresnel};
use clap::ArgAction;
use std::collections::HashSet;
use std::path::PathBuf;

/// Renders RADIANCE scenes. With a view it writes a picture; without one it reads rays on standard input and writes what they see.
///
/// Exit status: 0 done, 1 interrupted (the picture is the best so far), 2 trouble.
#[derive(clap::Parser, Clone, Debug)]
#[command(name = "rtrace-rs", version, max_term_width = 100)]
pub struct Arguments {
    /// Scene files, or an octree; - is standard input, and so is none if there is a view
    #[arg(value_name = "SCENE", value_parser = super::name())]
    pub scenes: Vec<String>,

    /// The view.
    #[command(flatten)]
    pub view: ViewWords,

    /// The picture.
    #[command(flatten)]
    pub picture: PictureOptions,

    /// The rays.
    #[command(flatten)]
    pub rays: RayOptions,

    /// The light.
    #[command(flatten)]
    pub light: Light,

    /// How accurate.
    #[command(flatten)]
    pub accuracy: Accuracy,

    /// How scenes are read.
    #[command(flatten)]
    pub reading: Reading,

    /// Which programs scenes may run.
    #[command(flatten)]
    pub scene_options: Scenes,

    /// The files named are parts of a picture, made with --samples: join them
    #[arg(long, conflicts_with_all = ["error", "spp", "samples", "time", "z", "aov", "coverage"])]
    pub merge: bool,

    /// Say on standard error what each given option does, and which defaults are not RADIANCE's
    #[arg(long)]
    pub explain: bool,

    /// Print what holds for every option of RADIANCE's, with those given, and end
    #[arg(long = "defaults")]
    pub defaults: bool,

    /// Print which features of RADIANCE's there are, and end: with exit status 1 if one that is named is not among them
    #[arg(long = "features")]
    pub features: bool,

    /// What all programs share.
    #[command(flatten)]
    pub common: Common,
}

/// What colours may be told in: the last that is given counts.
const SPACES: [&str; 5] = ["rgb", "xyz", "luminance", "scotopic", "melanopic"];

/// The size and kind of a picture.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Picture options")]
pub struct PictureOptions {
    /// Largest width of the picture in pixels [default: 512]; for rays, how many are answered together, or are in a line of a picture
    #[arg(long = "x", value_name = "N")]
    pub x: Option<usize>,

    /// Largest height of the picture in pixels [default: 512]; for rays, how many lines are answered
    #[arg(long = "y", value_name = "N")]
    pub y: Option<usize>,

    /// Pixel aspect ratio, height over width; 0 keeps the size [default: 1]
    #[arg(long = "pa", value_name = "F")]
    pub pa: Option<f64>,

    /// The part of a pixel's width that its samples cover; 0 samples centres [default: 1]
    #[arg(long = "pj", value_name = "F")]
    pub pj: Option<f64>,

    /// A pixel weighs light by a Gaussian of this radius in pixels around its centre, as pfilt -r does; 0 is the box [default: by -pj]
    #[arg(long, value_name = "R", conflicts_with = "pj", value_parser = radius)]
    pub filter: Option<Radius>,

    /// Diameter of the lens; things are in focus at the length of -vd [default: 0]
    #[arg(long = "pd", value_name = "F")]
    pub pd: Option<f64>,

    /// Keep the length of each pixel's central ray, by way of flat mirrors and panes: a 4-byte number a pixel
    #[arg(long = "z", value_name = "FILE")]
    pub z: Option<PathBuf>,

    /// Write OpenEXR instead of a RADIANCE picture, as for an output file that ends in .exr
    #[arg(long)]
    pub exr: bool,

    /// Keep the variance of each pixel; of a picture in parts, with --merge
    #[arg(long, value_name = "FILE.exr")]
    pub variance: Option<PathBuf>,

    /// Keep other pictures of the same pixels: any of normal, depth, albedo, direct, indirect
    #[arg(long, value_names = ["NAMES", "FILE.exr"], num_args = 2)]
    pub aov: Option<Vec<String>>,

    /// Instead of light, the fraction of each pixel that is covered by surfaces whose material is ID, seen through panes and in mirrors too
    #[arg(long, value_name = "ID", conflicts_with_all = ["variance", "aov", "xyz"])]
    pub coverage: Option<String>,

    /// Red, green and blue (the default)
    #[arg(long = "pRGB", overrides_with_all = SPACES)]
    pub rgb: bool,

    /// CIE XYZ, times 179; of a picture in parts, with --merge
    #[arg(long = "pXYZ", overrides_with_all = SPACES)]
    pub xyz: bool,

    /// Luminance, times 179; for rays only
    #[arg(long = "pY", overrides_with_all = SPACES)]
    pub luminance: bool,

    /// What the eye sees by night; for rays only
    #[arg(long = "pS", overrides_with_all = SPACES)]
    pub scotopic: bool,

    /// CIE (x, y) of red, green, blue and white; RADIANCE's own only
    #[arg(long = "pc", hide = true, value_names = ["X", "Y", "X", "Y", "X", "Y", "X", "Y"], num_args = 8)]
    pub pc: Option<Vec<f64>>,

    /// What sets the clock of the body; for rays only
    #[arg(long = "pM", overrides_with_all = SPACES)]
    pub melanopic: bool,
}

impl PictureOptions {
    /// Refuses primaries other than RADIANCE's.
    pub fn check(&self) -> Result<()> {
        let own = PRIMARIES.iter().flatten();
        match &self.pc {
            Some(given) if given.iter().zip(own).any(|(a, b)| (a - b).abs() > 1e-3) => {
                Err(Error::new("-pc: other primaries than RADIANCE's (.64 .33 .29 .6 .15 .06 .3333 .3333) are not supported; use -pXYZ"))
            }
            _ => Ok(()),
        }?;
        if let Some(bad) = self.pj.filter(|pj| !(0.0..=1.0).contains(pj)) {
            return Err(Error::new(format!("-pj must be from 0 to 1, not {bad}")));
        }
        match self.pd.filter(|pd| *pd < 0.0) {
            Some(bad) => Err(Error::new(format!("-pd must be 0 or more, not {bad}"))),
            None => Ok(()),
        }
    }

    /// The largest width and height of a picture, pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.x.unwrap_or(SIZE), self.y.unwrap_or(SIZE))
    }

    /// How many rays make a line, and how many lines are answered; 0 for any number.
    pub fn lines(&self) -> (usize, usize) {
        (self.x.unwrap_or(0), self.y.unwrap_or(0))
    }

    /// The height of a pixel over its width; 0 if the size is kept as it is.
    pub fn aspect(&self) -> f64 {
        self.pa.unwrap_or(1.0)
    }

    /// The diameter of the lens.
    pub fn aperture(&self) -> f64 {
        self.pd.unwrap_or(0.0)
    }

    /// Which of the light around its centre a pixel takes in.
    pub fn filter(&self) -> Filter {
        self.filter.map_or_else(|| Filter::boxed(self.pj.map_or(1.0, |width| width.max(0.0))), |radius| Filter::gaussian(radius.0, None))
    }

    /// What colours are told in.
    pub fn space(&self) -> Space {
        match (self.xyz, self.luminance, self.scotopic, self.melanopic) {
            (true, ..) => Space::Xyz,
            (_, true, ..) => Space::Photopic,
            (_, _, true, _) => Space::Scotopic,
            (.., true) => Space::Melanopic,
            _ => Space::Rgb,
        }
    }
}

/// Light transport, in RADIANCE's options. What is not given is not limited.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "Light transport (as RADIANCE when given; otherwise converged)")]
pub struct Light {
    /// Diffuse bounces [default: all]
    #[arg(long = "ab", value_name = "N")]
    pub ab: Option<i64>,

    /// Radiance that stands for what the bounces leave out
    #[arg(long = "av", value_names = ["R", "G", "B"], num_args = 3)]
    pub av: Option<Vec<f64>>,

    /// Surfaces with this modifier gather no indirect light: -av stands for it
    #[arg(long = "ae", value_name = "MOD", action = ArgAction::Append)]
    pub ae: Vec<String>,

    /// Only surfaces with this modifier gather indirect light
    #[arg(long = "ai", value_name = "MOD", action = ArgAction::Append)]
    pub ai: Vec<String>,

    /// As -ae, for the modifiers listed in a file
    #[arg(long = "aE", value_name = "FILE", action = ArgAction::Append)]
    pub ae_files: Vec<String>,

    /// As -ai, for the modifiers listed in a file
    #[arg(long = "aI", value_name = "FILE", action = ArgAction::Append)]
    pub ai_files: Vec<String>,

    /// Limit of reflections; negative or 0: roulette decides
    #[arg(long = "lr", value_name = "N")]
    pub lr: Option<i32>,

    /// Smallest weight of a ray
    #[arg(long = "lw", value_name = "F")]
    pub lw: Option<f64>,

    /// Rough specularity at or below this counts as diffuse [default: 0]
    #[arg(long = "st", value_name = "F")]
    pub st: Option<f64>,

    /// Up to 1.5: rough reflection by RADIANCE's single unweighted samples, narrowed below 1 [default: the lobe itself]
    #[arg(long = "ss", value_name = "F")]
    pub ss: Option<f64>,

    /// One sample of each part of each light source, jittered over this fraction of it [default: integrated]
    #[arg(long = "dj", value_name = "F")]
    pub dj: Option<f64>,

    /// With -dj: light sources are divided until their parts are smaller than this fraction of their distance [default: .2]
    #[arg(long = "ds", value_name = "F")]
    pub ds: Option<f64>,

    /// Mirrors that a light is seen through [default: 2]
    #[arg(long = "dr", value_name = "N")]
    pub dr: Option<u32>,

    /// Whether light sources are seen [default: on]
    #[arg(long = "dv")]
    pub dv: Option<bool>,

    /// Whether the backs of surfaces are there [default: on]
    #[arg(long = "bv")]
    pub bv: Option<bool>,

    /// Irradiance instead of radiance
    #[arg(long = "i")]
    pub irradiance: Option<bool>,

    /// Extinction of the medium that fills the scene
    #[arg(long = "me", value_names = ["R", "G", "B"], num_args = 3)]
    pub me: Option<Vec<f64>>,

    /// What lights a point where environments were measured at several places (#@probe) [default: blend, of the two nearest by 1/distance²,
    /// but small round lamps that all of three or more see stand where their lines of sight meet]
    #[arg(long, value_name = "nearest|blend", value_parser = ["nearest", "blend"])]
    pub field: Option<String>,

    /// The reflection lobe of the 2002 paper instead of RADIANCE's present one
    #[arg(long, value_name = "1992", value_parser = ["1992"])]
    pub ward: Option<String>,

    /// What the Fresnel term of polished surfaces is lowered by; RADIANCE from 2023 to 6.0.2: .00202943064
    /// [default: that of RADIANCE since, or of the release that the header of a target names]
    #[arg(long, value_name = "F")]
    pub fresnel_offset: Option<f64>,

    /// Options that only tune RADIANCE's approximations are accepted and do nothing: there is nothing to tune
    #[command(flatten)]
    pub tuning: Tuning,
}

impl AsRef<Common> for Arguments {
    fn as_ref(&self) -> &Common {
        &self.common
    }
}

impl Arguments {
    /// The files that are named; if there are none, standard input.
    pub fn scenes(&self) -> Vec<String> {
        if self.scenes.is_empty() { vec!["-".into()] } else { self.scenes.clone() }
    }
}

impl Light {
    /// What these options say. `list` gives the words of a file of modifiers.
    pub fn rules(&self, list: &dyn Fn(&str) -> Result<Vec<String>>) -> Result<Rules> {
        let default = Rules::default();
        let color = |v: &Option<Vec<f64>>, other: Rgb| v.as_ref().map_or(other, |v| Rgb::new(v[0], v[1], v[2]));
        self.check()?;
        let excluded = modifiers(&self.ae, &self.ae_files, list)?;
        let included = modifiers(&self.ai, &self.ai_files, list)?;
        let refusal = "-ae and -ai exclude each other: give either what gathers light or what does not";
        let gathering = either(excluded, included, refusal)?;
        // A negative count shows photons in RADIANCE, of which there are none here.
        let bounces = self.ab.map(|n| n.clamp(0, u32::MAX as i64) as u32).unwrap_or(default.ambient_bounces);
        Ok(Rules {
            ambient_bounces: if self.tuning.ad == Some(0) { 0 } else { bounces },
            ambient_value: color(&self.av, default.ambient_value),
            limit_reflections: self.lr,
            limit_weight: self.lw,
            specular_threshold: self.st.unwrap_or(default.specular_threshold),
            specular_sampling: self.ss,
            light_jitter: self.dj,
            light_division: self.ds.unwrap_or(default.light_division),
            gathering,
            back_visible: self.bv.unwrap_or(default.back_visible),
            lights_visible: self.dv.unwrap_or(default.lights_visible),
            mirror_levels: self.dr.unwrap_or(default.mirror_levels),
            extinction: color(&self.me, default.extinction),
            irradiance: self.irradiance.unwrap_or(default.irradiance),
            field: if self.field.as_deref() == Some("nearest") { Field::Nearest } else { default.field },
            lobe: if self.ward.is_some() { Ward::Original } else { default.lobe },
            fresnel_offset: self.fresnel_offset.unwrap_or(default.fresnel_offset),
        })
    }

    /// Refuses what has no meaning here.
    fn check(&self) -> Result<()> {
        let Tuning { ma, pm, cs, am, r, ro, sequence, persist, persist_parallel, .. } = &self.tuning;
        let refused = [
            (
                r.is_some() || ro.is_some(),
                "-r, -ro: there is nothing to recover: a picture is written when it is finished; render it again",
            ),
            (sequence.is_some(), "-S: views in sequence are not read from standard input; render each by its own command, with -vf"),
            (persist.is_some() || persist_parallel.is_some(), "-P, -PP: the program does not stay in memory; send it all rays at once"),
        ];
        if let Some((_, reason)) = refused.iter().find(|(given, _)| *given) {
            return Err(Error::new(*reason));
        }
        let positive = |v: &Option<f64>| v.is_some_and(|v| v > 0.0);
        if ma.as_ref().is_some_and(|v| v.iter().any(|&v| v != 0.0)) && self.me.as_ref().is_some_and(|v| v.iter().any(|&v| v != 0.0)) {
            return Err(Error::new("-ma: a medium that scatters light is not supported; -ma 0 0 0 leaves one that only absorbs it"));
        }
        if positive(pm) {
            return Err(Error::new("-pm: motion is not supported; render a sequence of views and average it"));
        }
        if positive(am) {
            return Err(Error::new("-am: photon maps are not supported, nor needed; leave the option out"));
        }
        if cs.is_some_and(|n| n > 3) {
            return Err(Error::new("-cs: more than three spectral samples are not supported"));
        }
        let extinction = self.me.iter().flatten().map(|&value| ("-me", Some(value)));
        for (option, value) in [("-lw", self.lw), ("-ss", self.ss), ("-ds", self.ds)].into_iter().chain(extinction) {
            if let Some(bad) = value.filter(|v| !(*v >= 0.0)) {
                return Err(Error::new(format!("{option} must be 0 or more, not {bad}")));
            }
        }
        if let Some(bad) = self.dj.filter(|dj| !(0.0..=1.0).contains(dj)) {
            return Err(Error::new(format!("-dj must be from 0 to 1, not {bad}")));
        }
        if let Some(bad) = self.fresnel_offset.filter(|offset| !lowers_fresnel(*offset)) {
            return Err(Error::new(format!("--fresnel-offset must be from 0 to .1, not {bad}")));
        }
        if self.lw == Some(0.0) && self.lr.is_none_or(|lr| lr <= 0) {
            return Err(Error::new("-lw 0 leaves nothing for roulette to go by; give -lr above 0, or -lw above 0"));
        }
        Ok(())
    }
}

/// What is left out (false), or what alone is meant (true); both are refused.
fn either(excluded: Option<HashSet<String>>, included: Option<HashSet<String>>, refusal: &str) -> Result<Option<(bool, HashSet<String>)>> {
    match (excluded, included) {
        (Some(_), Some(_)) => Err(Error::new(refusal)),
        (excluded, included) => Ok(excluded.map(|names| (false, names)).or(included.map(|names| (true, names)))),
    }
}

/// The modifiers of a list on the command line and of files; `None` if there are neither.
fn modifiers(names: &[String], files: &[String], list: &dyn Fn(&str) -> Result<Vec<String>>) -> Result<Option<HashSet<String>>> {
    let mut all: HashSet<String> = names.iter().cloned().collect();
    for file in files {
        all.extend(list(file)?);
    }
    Ok((!names.is_empty() || !files.is_empty()).then_some(all))
}
