//! A recovery that is kept in a file, so that the same command answers at once.
//!
//! A recovery takes seconds and is the same every time: killed, it is done again by the same command, to the same bytes. So what is kept is
//! what was found at the end, and what was asked; of anything else that is asked a file that keeps it knows nothing, and says so.

use super::Outcome;
use super::report::Trail;
use super::stream::{Output, file};
use crate::args::anneal::Arguments;
use crate::error::{Error, Result};
use crate::recover::Recovery;
use crate::recover::answer::warning;
use crate::report::{Moment, VERSION};
use crate::unknown::Unknown;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What a file keeps of a recovery.
#[derive(Serialize, Deserialize)]
pub struct Kept {
    asked: Asked,
    /// The type that the unknown was taken for, and of how many numbers.
    kind: (String, usize),
    /// What is to be said of it.
    pub said: Said,
    /// What was found.
    pub found: Found,
    /// How.
    pub rounds: Vec<Moment>,
}

/// What is to be said besides the answer.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Said {
    /// Before it, line by line.
    pub title: Vec<String>,
    /// What there is to doubt.
    pub doubts: Vec<String>,
}

impl Said {
    /// A doubt, which stands before the answer too.
    pub fn doubt(&mut self, doubt: String) {
        self.title.push(warning(&doubt));
        self.doubts.push(doubt);
    }
}

/// What was found in a photograph.
#[derive(Clone, Serialize, Deserialize)]
pub struct Found {
    /// What it says.
    pub recovery: Recovery,
    /// The pixels that were left out as they are black where there is light.
    pub dead: Vec<usize>,
}

/// What was asked: all that an answer depends on.
#[derive(Clone, Serialize, Deserialize, PartialEq, Eq)]
pub struct Asked {
    /// Whom: the version of the program.
    #[serde(default)]
    version: String,
    /// The options.
    options: String,
    /// A number that any change of the files that were read changes.
    read: u64,
}

impl Asked {
    /// What these arguments ask of files with that number.
    pub fn new(start: &str, arguments: &Arguments, read: u64) -> Self {
        let Arguments { photo, unknown, light, reading, scene_options, common, search, .. } = arguments;
        let options = format!(
            "{start:?} {photo:?} {unknown:?} {light:?} {reading:?} {scene_options:?} {} {:?} {:?}",
            common.seed, search.tolerance, search.time
        );
        Self { version: VERSION.into(), options, read }
    }

    /// What these arguments ask of a search by renderings, besides what that keeps itself.
    pub fn judged(arguments: &Arguments, read: u64) -> Self {
        let Arguments { photo, light, reading, scene_options, .. } = arguments;
        Self { version: VERSION.into(), options: format!("{photo:?} {light:?} {reading:?} {scene_options:?}"), read }
    }
}

impl Kept {
    /// What `path` keeps of what is asked, and which of some unknowns it was taken for; `None` if there is no such file. Errors if it keeps
    /// something else.
    pub fn load(path: &Path, asked: &Asked, unknowns: &[Unknown]) -> Result<Option<(Self, usize)>> {
        if !path.exists() {
            return Ok(None);
        }
        let trouble = |what: &str, remedy: &str| Error::new(format!("{}: {what}; {remedy}", path.display()));
        let stranger = |why: &str| trouble(&format!("not a recovery that anneal keeps ({why})"), "name another state");
        let kept: Self = serde_json::from_slice(&file(path)?).map_err(|e| stranger(&e.to_string()))?;
        let Asked { version, options, read } = &kept.asked;
        for (same, what) in [
            (*version == asked.version, "by another version of this program"),
            (*options == asked.options, "with other options"),
            (*read == asked.read, "from other files"),
        ] {
            if !same {
                return Err(trouble(&format!("it keeps a recovery {what}"), "remove it to begin anew, or name another state"));
            }
        }
        let unknown = unknowns.iter().position(|unknown| kind(unknown) == kept.kind);
        match unknown.filter(|&unknown| kept.is_of(unknowns[unknown].parameters().len())) {
            Some(unknown) => Ok(Some((kept, unknown))),
            None => Err(stranger("its parts contradict each other")),
        }
    }

    /// What was asked, and what was found and said of an unknown.
    pub fn new(asked: Asked, unknown: &Unknown, said: &Said, found: &Found, trail: &Trail) -> Self {
        let (kind, rounds) = (kind(unknown), trail.moments().clone());
        Self { asked, kind, said: said.clone(), found: found.clone(), rounds }
    }

    /// Keeps it in a file.
    pub fn save(&self, path: &Path) -> Outcome<()> {
        let text = serde_json::to_vec(self).map_err(|e| Error::new(format!("{}: {e}", path.display())))?;
        // What is infinite no file keeps: then the same command does it again.
        if serde_json::from_slice::<Self>(&text).is_err() {
            return Ok(());
        }
        Output::whole(Some(path), &text)
    }

    /// Whether all it knows is of that many parameters.
    fn is_of(&self, parameters: usize) -> bool {
        let Recovery { values, covariance, own, common, .. } = &self.found.recovery;
        let fits =
            |round: &Moment| round.values.len() == parameters && round.errors.as_ref().is_none_or(|errors| errors.len() == parameters);
        values.len() == parameters
            && [covariance, own, common].iter().all(|matrix| matrix.is_finite_of(parameters))
            && self.rounds.iter().all(fits)
    }
}

/// The type of an unknown, and of how many numbers it is.
fn kind(unknown: &Unknown) -> (String, usize) {
    (unknown.material().kind.clone(), unknown.material().reals.len())
}
