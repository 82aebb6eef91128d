//! The page that tells of a recovery or of a search, written where the user wants it.

use super::photo::Photo;
use super::search::Search;
use super::{Console, Outcome, Output};
use crate::error::Error;
use crate::rad::decode;
use crate::recover::Recovery;
use crate::recover::answer::Answer;
use crate::report::{Moment, Report};
use crate::unknown::Unknown;
use std::path::Path;
use std::sync::{Mutex, MutexGuard};

/// What a recovery told on its way.
pub struct Trail(Mutex<Vec<Moment>>);

impl Trail {
    /// The trail of a recovery that begins at the start of an unknown.
    pub fn new(unknown: &Unknown) -> Self {
        let values = unknown.parameters().iter().map(|p| p.start).collect();
        Self(Mutex::new(vec![Moment { values, errors: None, chi2: None }]))
    }

    /// Keeps what a round found.
    pub fn hear(&self, found: &Recovery) {
        self.moments().push(Moment { values: found.values.clone(), errors: Some(found.errors()), chi2: Some(found.chi2) });
    }

    fn moments(&self) -> MutexGuard<'_, Vec<Moment>> {
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// Writes the page of a recovery from a photograph.
pub fn of_recovery(path: &Path, found: &Recovery, answer: &Answer, photo: &Photo, trail: &Trail, console: &Console) -> Outcome<()> {
    let told = Report {
        own: Some(found.own.deviations()),
        pixels: Some(found.pixels),
        trail: &trail.moments(),
        unit: "round",
        ..told(answer, found.chi2)
    };
    write(path, told, photo.unknown(), Some(photo), console)
}

/// Writes the page of a search, and of the photograph it was for, if it was for one.
pub fn of_search(path: &Path, search: &Search, photo: Option<&Photo>, console: &Console) -> Outcome<()> {
    let annealer = search.annealed();
    let Some(best) = annealer.best() else { return Err(Error::new("nothing was evaluated yet: there is nothing to report").into()) };
    let answer = search.answer(&best.values);
    let past = annealer.past().map(|(values, chi2)| Moment { values: values.to_vec(), errors: None, chi2 });
    let told = Report { trail: &past.collect::<Vec<_>>(), unit: "evaluation", ..told(&answer, best.chi2) };
    write(path, told, search.unknown(), photo, console)
}

/// A report of an answer and its χ², and of nothing else yet.
fn told<'a>(answer: &'a Answer, chi2: f64) -> Report<'a> {
    Report {
        name: "",
        kind: "",
        parameters: &[],
        reals: &[],
        values: answer.values(),
        errors: answer.errors().map(<[f64]>::to_vec),
        own: None,
        correlations: answer.correlations().cloned(),
        chi2,
        pixels: None,
        doubts: answer.doubts(),
        trail: &[],
        unit: "",
        views: None,
        file: "",
        command: "",
    }
}

/// Writes a report of an unknown, with what can be seen of it.
fn write(path: &Path, told: Report, unknown: &Unknown, photo: Option<&Photo>, console: &Console) -> Outcome<()> {
    console.progress(|| "rendering the report".into());
    let views = photo.map(|photo| photo.views(told.values)).transpose()?;
    let material = unknown.material();
    let report = Report {
        name: &material.name,
        kind: &material.kind,
        parameters: unknown.parameters(),
        reals: &unknown.reals(told.values),
        views: views.as_ref(),
        file: &decode(unknown.document(told.values)?.bytes()),
        command: console.trail(),
        ..told
    };
    Output::whole(Some(path), report.page()?.as_bytes())
}
