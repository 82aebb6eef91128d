//! A recovery that is kept in a file, so that the same command answers at once.
//!
//! A recovery takes seconds and is the same every time: killed, it is done again by the same command, to the same bytes. So what is kept is
//! what was found at the end, and what was asked; of anything else that is asked a file that keeps it knows nothing, and says so.

use super::Outcome;
use super::report::Trail;
use super::stream::{Output, file};
use crate::anneal::linear::Symmetric;
use crate::args::anneal::Arguments;
use crate::error::{Error, Result};
use crate::recover::{Blur, Recovery};
use crate::report::Moment;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What a file keeps of a recovery.
#[derive(Serialize, Deserialize)]
pub struct Kept {
    asked: Asked,
    /// The type that the unknown was taken for.
    pub kind: String,
    /// What is to be said of the type.
    pub title: Vec<String>,
    /// What there is to doubt about it.
    pub doubts: Vec<String>,
    values: Vec<f64>,
    covariance: Symmetric,
    own: Symmetric,
    common: Symmetric,
    misfit: f64,
    blur: Option<Blur>,
    chi2: f64,
    pixels: usize,
    rounds: Vec<Moment>,
}

/// What was asked: all that an answer depends on.
#[derive(Clone, Serialize, Deserialize, PartialEq, Eq)]
pub struct Asked {
    /// The options.
    options: String,
    /// A number that any change of the files that were read changes.
    read: u64,
}

impl Asked {
    /// What these arguments ask of files with that number.
    pub fn new(start: &str, arguments: &Arguments, read: u64) -> Self {
        let Arguments { photo, unknown, light, scene_options, common, search, .. } = arguments;
        let options =
            format!("{start:?} {photo:?} {unknown:?} {light:?} {scene_options:?} {} {:?} {:?}", common.seed, search.tolerance, search.time);
        Self { options, read }
    }
}

impl Kept {
    /// What `path` keeps of what is asked; `None` if there is no such file. Errors if it keeps something else.
    pub fn load(path: &Path, asked: &Asked) -> Result<Option<Self>> {
        if !path.exists() {
            return Ok(None);
        }
        let remedy = "remove it to begin anew, or name another state";
        let trouble = |what: &str| Error::new(format!("{}: {what}; {remedy}", path.display()));
        let kept: Self = serde_json::from_slice(&file(path)?).map_err(|e| trouble(&format!("not a recovery that anneal keeps ({e})")))?;
        let n = kept.values.len();
        let fits = |round: &Moment| round.values.len() == n && round.errors.as_ref().is_none_or(|errors| errors.len() == n);
        if !kept.is_finite() || !kept.rounds.iter().all(fits) {
            return Err(trouble("not a recovery that anneal keeps (its parts contradict each other)"));
        }
        match (kept.asked.options == asked.options, kept.asked.read == asked.read) {
            (true, true) => Ok(Some(kept)),
            (true, false) => Err(trouble("it keeps a recovery from other files")),
            (false, _) => Err(trouble("it keeps a recovery with other options")),
        }
    }

    /// Keeps what was found in a file.
    pub fn save(
        path: &Path,
        asked: Asked,
        kind: &str,
        title: &[String],
        doubts: &[String],
        found: &Recovery,
        trail: &Trail,
    ) -> Outcome<()> {
        let kept = Self {
            asked,
            kind: kind.into(),
            title: title.to_vec(),
            doubts: doubts.to_vec(),
            values: found.values.clone(),
            covariance: found.covariance.clone(),
            own: found.own.clone(),
            common: found.common.clone(),
            misfit: found.misfit,
            blur: found.blur,
            chi2: found.chi2,
            pixels: found.pixels,
            rounds: trail.moments().clone(),
        };
        // What is infinite no file keeps: then the same command does it again.
        if !kept.is_finite() {
            return Ok(());
        }
        let text = serde_json::to_vec(&kept).map_err(|e| Error::new(format!("{}: {e}", path.display())))?;
        Output::whole(Some(path), &text)
    }

    /// Whether what is known of the errors of the values is of as many of them, and finite.
    fn is_finite(&self) -> bool {
        [&self.covariance, &self.own, &self.common].iter().all(|matrix| matrix.is_finite_of(self.values.len()))
    }

    /// What was found, and how.
    pub fn found(self) -> (Recovery, Vec<Moment>) {
        let Self { values, covariance, own, common, misfit, blur, chi2, pixels, rounds, .. } = self;
        (Recovery { values, covariance, own, common, misfit, blur, chi2, pixels, losses: vec![], clarity: vec![] }, rounds)
    }
}
