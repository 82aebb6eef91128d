//! The options of anneal.

use super::rtrace::Light;
use super::{Common, Reading, Scenes, ViewWords, radius};
use crate::anneal::Options;
use crate::error::{Error, Result};
use crate::metric::Loss;
use crate::unknown::{Bounds, TYPES, Wishes, names};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What material is it? Finds the numbers of a material with which a rendering comes nearest to a picture.
///
/// START.rad holds the material with the values to start from. The same file with the numbers that were found, and nothing
/// else changed, goes to standard output, preceded by comment lines with chi-squared and each value's standard error.
///
/// Exit status: 0 done, 1 the search was interrupted or ended before it reached --tolerance, or propose had nothing more to propose, 2 trouble.
#[derive(clap::Parser, Clone, Debug)]
#[command(
    name = "anneal",
    version,
    max_term_width = 100,
    override_usage = "anneal [OPTIONS] --scene SCENE -vf VIEW --target PICTURE START.rad\n       anneal [OPTIONS] --exec COMMAND START.rad\n       anneal [OPTIONS] propose STATE [START.rad] > next.rad\n       \
                      anneal tell STATE [CHI2]\n       anneal best STATE"
)]
pub struct Arguments {
    /// The file with the unknown material [default: standard input]; or a step of a search that is driven from outside:
    /// `propose STATE` prints the next candidate (the first time give START.rad and options too), `tell STATE CHI2` takes its
    /// chi-squared (without CHI2 what a program prints there, as --exec reads it), `best STATE` prints the best so far
    #[arg(value_name = "START.rad", num_args = 0..=3, allow_negative_numbers = true)]
    pub words: Vec<String>,

    /// The picture, and the scene it was taken in.
    #[command(flatten)]
    pub photo: Photo,

    /// How candidates are judged.
    #[command(flatten)]
    pub judge: Judge,

    /// What is unknown.
    #[command(flatten)]
    pub unknown: UnknownOptions,

    /// How long and how to search.
    #[command(flatten)]
    pub search: SearchOptions,

    /// The light.
    #[command(flatten)]
    pub light: Light,

    /// How scenes are read.
    #[command(flatten)]
    pub reading: Reading,

    /// Which programs scenes may run.
    #[command(flatten)]
    pub scene_options: Scenes,

    /// What all programs share.
    #[command(flatten)]
    pub common: Common,
}

/// The picture, and what is known of the scene it was taken in.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Photograph")]
pub struct Photo {
    /// The scene without the unknown material, which START.rad holds; a definition of it here does not count. May be repeated
    #[arg(long, value_name = "SCENE", value_parser = super::name(), conflicts_with = "exec")]
    pub scene: Vec<String>,

    /// The view [default: the picture's own].
    #[command(flatten)]
    pub view: ViewWords,

    /// What was photographed: a high-dynamic-range picture, in radiance. What the header of a rendering says of how light was reckoned with (-ab, -av,
    /// -ss, -lr and others), or its program's defaults, holds where it is not typed
    #[arg(long, value_name = "PICTURE", requires = "scene", conflicts_with = "exec")]
    pub target: Option<String>,

    /// How much each pixel counts, from 0 to 1
    #[arg(long, value_name = "PICTURE", requires = "target", conflicts_with = "exec")]
    pub mask: Option<String>,

    /// Radius in pixels of the Gaussian that the picture's pixels weigh light by, as pfilt -r makes them; 0: they take in the light of their area;
    /// auto: the radius is found too, as it must be for a camera's picture that was not made smaller [default: what the picture's header
    /// says, or 0]
    #[arg(long, value_name = "R", requires = "scene", conflicts_with = "exec", value_parser = sharpness)]
    pub filter: Option<Sharpness>,

    /// No picture yet: the standard errors that one would give if the unknown were START.rad's, what it would not tell, and what would
    /// help. Assumed is noise of 2 % in each pixel
    #[arg(long, requires = "scene", conflicts_with_all = ["target", "exec", "state", "log", "report", "time", "tolerance", "steps", "mask", "direct", "stages", "residuals", "loss", "no_polish"])]
    pub predict: bool,

    /// Largest width of the picture to predict, in pixels [default: 160]
    #[arg(long = "x", value_name = "N")]
    pub x: Option<usize>,

    /// Largest height of the picture to predict, in pixels [default: 160]
    #[arg(long = "y", value_name = "N")]
    pub y: Option<usize>,

    /// Render anew for every candidate, instead of once for all
    #[arg(long, requires = "target")]
    pub direct: bool,
}

/// Who says how good a candidate is.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Judge")]
pub struct Judge {
    /// Run COMMAND in the shell for each candidate: the file is $MATERIAL (and {}), $STAGE is 1 and more, chi-squared is what it
    /// prints as chi2, as imgdiff does, or else the last number. 'oconv $MATERIAL scene.rad > t.oct && rpict -vf cam.vf t.oct | imgdiff photo.hdr -' uses RADIANCE
    #[arg(long, value_name = "COMMAND")]
    pub exec: Option<String>,
}

/// Which numbers are unknown, and what is known of them.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Unknown")]
pub struct UnknownOptions {
    /// The identifier of the unknown material, if the file has several
    #[arg(long, value_name = "ID")]
    pub material: Option<String>,

    /// Take the material for this type instead of the file's, or try all, which takes some seconds whatever --time says, and keep the one
    /// that the picture supports best. What is said of parameters that a type does not have is left out for it
    #[arg(long = "type", value_name = "TYPE", value_parser = kinds())]
    pub kind: Option<String>,

    /// Start and bounds of a parameter: red green blue spec rough urough vrough trans tspec ior hartmann, or a1 … for the real
    /// arguments in order. May be repeated; START may be left out. exposure=1:.5:2 lets the picture be brighter than the scene by an
    /// unknown factor; exposure-red, exposure-green and exposure-blue let each channel, as an unknown white balance does
    #[arg(long, value_name = "NAME=START:LOW:HIGH")]
    pub param: Vec<Bounds>,

    /// Keep this parameter as it is in the file, or as --param starts it
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub fix: Vec<String>,

    /// Let these parameters have one value: red=green=blue
    #[arg(long, value_name = "NAME=NAME")]
    pub tie: Vec<String>,

    /// The groups of parameters that move in turn [default: rgb/ and the others]
    #[arg(long, value_name = "rgb/spec,rough")]
    pub groups: Option<String>,
}

/// What is said of the filter of a picture's pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sharpness {
    /// It is to be found.
    Unknown,
    /// Its radius, in pixels.
    Radius(f64),
}

fn sharpness(word: &str) -> std::result::Result<Sharpness, String> {
    if word == AUTO { Ok(Sharpness::Unknown) } else { radius(word).map(|radius| Sharpness::Radius(radius.0)) }
}

/// What `--type` may be.
fn kinds() -> PossibleValuesParser {
    std::iter::once(AUTO).chain(TYPES.map(|(name, _)| name)).into()
}

/// What `--loss` may be.
fn losses() -> impl TypedValueParser<Value = Loss> {
    PossibleValuesParser::new(["chi2", "relative", "log"]).map(|name| match name.as_str() {
        "chi2" => Loss::Chi2,
        "relative" => Loss::Relative,
        _ => Loss::Log,
    })
}

/// The `--type` that tries all, and the `--filter` that is found.
pub const AUTO: &str = "auto";

/// How long and how to search.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Search")]
pub struct SearchOptions {
    /// Evaluations by --exec or --direct in all [default: 400, or as many as --time allows]
    #[arg(long, value_name = "N")]
    pub steps: Option<usize>,

    /// Search for about S seconds; without --exec and --direct for as long as the first answer takes, if that is longer: half a second mostly, one
    /// to three for what is clear
    #[arg(long, value_name = "S")]
    pub time: Option<f64>,

    /// Stop when every standard error is below T
    #[arg(long, value_name = "T")]
    pub tolerance: Option<f64>,

    /// Search by --exec in N stages, coarse first: the command may render small pictures while $STAGE is 1
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "direct")]
    pub stages: u8,

    /// How many independent squares the chi-squared of --exec or --direct is the sum of, as 3 for each pixel that matters: standard errors
    /// then hold the noise of the photograph too
    #[arg(long, value_name = "N")]
    pub residuals: Option<f64>,

    /// What a search by --direct follows: chi2; relative, its squares relative to T² + .01 m², with m the mean of the picture T; or log, the
    /// squares of logarithms of T + .1 m. The last two are `loss` in the log; what is printed in the end is the chi-squared of equation 11
    /// [default: chi2]
    #[arg(long, value_name = "LOSS", requires = "target", value_parser = losses())]
    pub loss: Option<Loss>,

    /// By --exec or --direct only anneal: no local quadratics at the end, and no standard errors
    #[arg(long)]
    pub no_polish: bool,

    /// Keep the search in FILE, and take it up from there if FILE exists: killed at any moment, it goes on to the same result. A recovery
    /// with --target, which takes seconds, is kept when it is done
    #[arg(long, value_name = "FILE")]
    pub state: Option<PathBuf>,

    /// Write each evaluation to FILE, or each round with --target, one JSON object a line
    #[arg(long, value_name = "FILE.jsonl")]
    pub log: Option<PathBuf>,

    /// Write a page to look at to FILE: values, errors and correlations, how they were found, and with --target what they look like
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Job {
    /// Search for the unknown of this file.
    Search(String),
    /// Print the next candidate; begin with this file if there is no state.
    Propose(PathBuf, Option<String>),
    /// Take a chi-squared, from standard input if it is not given.
    Tell(PathBuf, Option<f64>),
    /// Print the best so far.
    Best(PathBuf),
}

/// Where candidates are judged one by one.
const JUDGED: &str = "--exec and --direct";

impl AsRef<Common> for Arguments {
    fn as_ref(&self) -> &Common {
        &self.common
    }
}

impl Photo {
    /// The files that it is read from.
    pub fn files(&self) -> Vec<&str> {
        let pictures = [&self.target, &self.mask].into_iter().flatten();
        pictures.chain(&self.scene).map(String::as_str).chain(self.view.files()).collect()
    }
}

impl Job {
    /// START.rad, if it is read.
    pub fn start(&self) -> Option<&str> {
        match self {
            Self::Search(start) | Self::Propose(_, Some(start)) => Some(start),
            _ => None,
        }
    }

    /// The file that keeps a search which is driven from outside.
    pub fn driven(&self) -> Option<&Path> {
        match self {
            Self::Search(_) => None,
            Self::Propose(state, _) | Self::Tell(state, _) | Self::Best(state) => Some(state),
        }
    }
}

impl Arguments {
    /// The files that are written beside the answer.
    pub fn pages(&self) -> impl Iterator<Item = &Path> {
        let SearchOptions { state, report, log, .. } = &self.search;
        [state, report, log].into_iter().filter_map(Option::as_deref)
    }

    /// What is to be done.
    pub fn job(&self) -> Result<Job> {
        if !self.photo.predict && (self.photo.x.is_some() || self.photo.y.is_some()) {
            return Err(Error::new("-x and -y are the size of a picture that --predict supposes; a --target has its own"));
        }
        if self.photo.filter == Some(Sharpness::Unknown) && (self.photo.target.is_none() || self.photo.direct) {
            return Err(Error::new("--filter auto finds the filter of a --target without --direct; give its radius here"));
        }
        let (light, seen) = (&self.light, self.photo.target.is_some() && !self.photo.direct || self.photo.predict);
        if seen && (light.st.is_some_and(|st| st > 0.0) || light.ss.is_some_and(|ss| ss < 1.0)) {
            return Err(Error::new(
                "-st and -ss below 1 are shortcuts of a rendering, which no photograph takes; leave them out (or give --direct)",
            ));
        }
        if seen && light.irradiance == Some(true) {
            return Err(Error::new("-i renders what arrives at surfaces, which no photograph shows; leave it out (or give --direct)"));
        }
        let kept = [("--state", &self.search.state), ("--log", &self.search.log), ("--report", &self.search.report)];
        let words: Vec<&str> = self.words.iter().map(String::as_str).collect();
        let dashed = kept.iter().find(|(_, path)| path.as_ref().is_some_and(|path| path.as_os_str() == "-")).map(|(option, _)| *option);
        let asked = if let ["propose" | "tell" | "best", "-", ..] = words[..] { Some(words[0]) } else { None };
        if let Some(option) = dashed.or(asked) {
            return Err(Error::new(format!("{option} takes the name of a file: the answer goes to standard output")));
        }
        if matches!(words[..], ["propose" | "tell" | "best", _, ..]) && (self.search.state.is_some() || self.search.log.is_some()) {
            return Err(Error::new(format!("{} keeps the search in the file after it, and no log; leave --state and --log out", words[0])));
        }
        if matches!(words[..], ["propose" | "tell", _, ..]) && self.search.report.is_some() {
            return Err(Error::new(format!("{} writes no page: give --report to best, which tells of the search", words[0])));
        }
        if let ["propose" | "tell" | "best", state] | ["tell", state, _] = words[..]
            && let Some(option) = self.told()
        {
            return Err(Error::new(format!("{state} keeps what was said when its search began: leave {option} out")));
        }
        let photo = &self.photo;
        if matches!(words[..], ["propose" | "tell" | "best", ..])
            && (!photo.scene.is_empty() || photo.target.is_some() || self.judge.exec.is_some())
        {
            return Err(Error::new(format!("{} renders nothing and runs nothing: leave --scene, --target and --exec out", words[0])));
        }
        match words[..] {
            ["propose", state] => Ok(Job::Propose(state.into(), None)),
            ["propose", state, start] => Ok(Job::Propose(state.into(), Some(start.into()))),
            ["tell", state] => Ok(Job::Tell(state.into(), None)),
            ["tell", state, chi2] => {
                let chi2 = chi2.parse().map_err(|_| Error::new(format!("tell: chi-squared `{chi2}` is not a number")))?;
                Ok(Job::Tell(state.into(), Some(chi2)))
            }
            ["best", state] => Ok(Job::Best(state.into())),
            ["propose" | "tell" | "best", ..] => Err(Error::new(format!("{} takes the file that keeps the search; see --help", words[0]))),
            [start] => Ok(Job::Search(start.into())),
            [] if !photo.scene.is_empty() || self.judge.exec.is_some() => Ok(Job::Search("-".into())),
            [] => Err(Error::new("nothing to do: give --scene, --target and START.rad; see --help")),
            _ => Err(Error::new(format!(
                "one START.rad only, not `{}`: put the unknown material into one file, and --scene before each file of the scene",
                words.join("` and `")
            ))),
        }
    }

    /// What is unknown.
    pub fn wishes(&self) -> Wishes {
        let unknown = &self.unknown;
        Wishes {
            material: unknown.material.clone(),
            bounds: unknown.param.clone(),
            fixed: unknown.fix.clone(),
            tied: unknown.tie.iter().map(|tie| names(tie, '=')).collect(),
            groups: unknown.groups.iter().flat_map(|groups| names(groups, '/')).map(|group| names(&group, ',')).collect(),
        }
    }

    /// An option that says what is unknown or how to search, if one was given.
    fn told(&self) -> Option<&'static str> {
        let (unknown, search) = (&self.unknown, &self.search);
        let said = [
            ("--material", unknown.material.is_some()),
            ("--type", unknown.kind.is_some()),
            ("--param", !unknown.param.is_empty()),
            ("--fix", !unknown.fix.is_empty()),
            ("--tie", !unknown.tie.is_empty()),
            ("--time", search.time.is_some()),
            ("--tolerance", search.tolerance.is_some()),
        ];
        let judged = self.idle().into_iter().map(|[option, _]| option);
        said.into_iter().filter_map(|(option, said)| said.then_some(option)).chain(judged).next()
    }

    /// What was said of the way to search that is of no use where no candidate is judged, as in a recovery from a picture, and what it is for.
    pub fn idle(&self) -> Vec<[&'static str; 2]> {
        let SearchOptions { steps, stages, residuals, loss, no_polish, .. } = &self.search;
        let groups = self.unknown.groups.is_some();
        let said = [
            (["--groups", JUDGED], groups),
            (["--steps", JUDGED], steps.is_some()),
            (["--stages", "--exec"], *stages > 1),
            (["--residuals", JUDGED], residuals.is_some()),
            (["--loss", "--direct"], loss.is_some()),
            (["--no-polish", JUDGED], *no_polish),
        ];
        said.into_iter().filter_map(|(option, said)| said.then_some(option)).collect()
    }

    /// How long to search.
    pub fn time(&self) -> Option<Duration> {
        self.search.time.map(|seconds| Duration::from_secs_f64(seconds.min(1e9)))
    }

    /// What a search by renderings makes small.
    pub fn loss(&self) -> Loss {
        self.search.loss.unwrap_or_default()
    }

    /// How to search.
    pub fn options(&self) -> Result<Options> {
        let search = &self.search;
        for (name, value) in [("--time", search.time), ("--tolerance", search.tolerance), ("--residuals", search.residuals)] {
            if value.is_some_and(|value| value <= 0.0) {
                return Err(Error::new(format!("{name} takes a number greater than 0")));
            }
        }
        if search.steps == Some(0) || search.stages == 0 {
            return Err(Error::new("--steps and --stages take a whole number greater than 0"));
        }
        if search.no_polish && search.tolerance.is_some() {
            return Err(Error::new("--tolerance needs the standard errors that --no-polish leaves out; give one of them"));
        }
        Ok(Options {
            seed: self.common.seed,
            steps: search.steps.unwrap_or(Options::default().steps),
            groups: vec![],
            stages: vec![1.0; usize::from(search.stages)],
            polish: !search.no_polish,
            tolerance: search.tolerance,
            residuals: search.residuals,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Typed, parse};

    fn typed(line: &str) -> Result<Arguments> {
        let none = |name: &str| Err(Error::new(format!("{name}: no such file")));
        match parse::<Arguments>(line.split(' ').map(Into::into).collect(), &none)? {
            Typed::Run(arguments, _) => Ok(arguments),
            Typed::Print(text) => panic!("{}", String::from_utf8_lossy(&text)),
        }
    }

    #[test]
    fn a_step_is_told_from_a_file() {
        let job = |line: &str| typed(line).unwrap().job();
        assert_eq!(job("anneal start.rad").unwrap(), Job::Search("start.rad".into()));
        assert_eq!(job("anneal propose s start.rad --fix rough").unwrap(), Job::Propose("s".into(), Some("start.rad".into())));
        assert_eq!(job("anneal tell s -0.25").unwrap(), Job::Tell("s".into(), Some(-0.25)));
        assert_eq!(job("anneal tell s").unwrap(), Job::Tell("s".into(), None));
        assert_eq!(job("anneal best s").unwrap(), Job::Best("s".into()));
        assert!(job("anneal tell s x").unwrap_err().message.contains("`x` is not a number"));
        assert!(job("anneal --scene s.rad --predict --filter auto a.rad").unwrap_err().message.contains("give its radius"));
        assert!(job("anneal a.rad b.rad").unwrap_err().message.contains("one START.rad only, not `a.rad` and `b.rad`"));
        assert!(job("anneal propose").unwrap_err().message.contains("propose takes the file"));
    }

    #[test]
    fn what_would_do_nothing_is_refused_with_a_remedy() {
        let said = |line: &str| typed(&format!("anneal {line}")).and_then(|a| a.job()).err().map(|e| e.message).unwrap_or_default();
        for option in ["--state s", "--log l", "--report r.html"] {
            assert!(said(&format!("--scene s.rad --predict {option} a.rad")).contains("cannot be used with"));
        }
        assert!(said("propose s --state s2").contains("leave --state and --log out") && said("best s --log l").contains("leave --state"));
        assert!(said("propose s --fix red").contains("leave --fix out") && said("tell s 3 --steps 9").contains("leave --steps out"));
        assert!(said("best s --param red=.5:0:1").starts_with("s keeps what was said when its search began: leave --param out"));
        assert_eq!(said("propose s a.rad --fix red --steps 9"), "");
        assert_eq!(said("--scene s.rad --target a.hdr --groups rgb/spec --state s --log l --report r.html a.rad"), "");
    }

    #[test]
    fn wishes_and_options_are_as_typed() {
        let line =
            "anneal s.rad --param rough=.1:0:.3 --param a4=:0:1 --fix red,green --tie red=green=blue --groups rgb/spec,rough --steps 9";
        let arguments = typed(line).unwrap();
        let wishes = arguments.wishes();
        assert_eq!((wishes.bounds[0].start, wishes.bounds[1].start), (Some(0.1), None));
        assert_eq!(wishes.fixed, ["red", "green"]);
        assert_eq!(wishes.tied, [["red", "green", "blue"]]);
        assert_eq!(wishes.groups, [vec!["rgb"], vec!["spec", "rough"]]);
        assert_eq!(arguments.options().unwrap().steps, 9);
        assert_eq!((arguments.idle(), typed("anneal s.rad").unwrap().idle()), (vec![["--groups", JUDGED], ["--steps", JUDGED]], vec![]));
        assert!(typed("anneal s.rad --param rough=1").unwrap_err().message.contains("write NAME=START:LOW:HIGH"));
        assert!(typed("anneal s.rad --no-polish --tolerance .1").unwrap().options().unwrap_err().message.contains("give one of them"));
    }
}
