//! The page that tells of a recovery or of a search, written where the user wants it.

use super::photo::Photo;
use super::search::{Log, Search};
use super::{Console, Outcome, Output};
use crate::error::Error;
use crate::metric::Loss;
use crate::rad::decode;
use crate::recover::Recovery;
use crate::recover::answer::Answer;
use crate::recover::words::digits;
use crate::report::{Moment, Report};
use crate::unknown::Unknown;
use std::path::Path;
use std::sync::{Mutex, MutexGuard};

/// What a recovery told on its way.
pub struct Trail {
    moments: Mutex<Vec<Moment>>,
    /// Where each round is written, and what went wrong there.
    log: Option<Mutex<(Log, Outcome<()>)>>,
    names: Vec<String>,
}

impl Trail {
    /// The trail of a recovery that begins at the start of an unknown, or went through some `rounds` already. Each round is a line of `log`.
    pub fn new(unknown: &Unknown, rounds: Option<Vec<Moment>>, log: Option<&Path>) -> Outcome<Self> {
        let start = || vec![Moment { values: unknown.start(), errors: None, chi2: None, pixels: None }];
        let log = log.map(|path| Log::open(path, 0)).transpose()?.map(|log| Mutex::new((log, Ok(()))));
        let names = unknown.parameters().iter().map(|p| p.name.clone()).collect();
        let trail = Self { moments: Mutex::new(rounds.unwrap_or_else(start)), log, names };
        let moments = trail.moments();
        moments.iter().enumerate().skip(1).for_each(|(round, moment)| trail.write(round, moment));
        drop(moments);
        Ok(trail)
    }

    /// Keeps what a round found, and shows it; or what was found in the end, where that is something else.
    pub fn hear(&self, found: &Recovery, console: &Console) {
        let (errors, mut moments) = (found.errors(), self.moments());
        if moments.last().is_some_and(|last| last.values == found.values && last.errors.as_ref() == Some(&errors)) {
            return;
        }
        console.progress(|| {
            let number = |((name, &value), &error): ((&String, &f64), &f64)| {
                let (value, error) = digits(value, error);
                format!(" {name} {value} ± {error}")
            };
            let numbers: Vec<String> = self.names.iter().zip(&found.values).zip(&errors).map(number).collect();
            format!("round {}:{}", moments.len(), numbers.join(","))
        });
        let (values, chi2, pixels) = (found.values.clone(), Some(found.chi2), Some(found.pixels));
        let moment = Moment { values, errors: Some(errors), chi2, pixels };
        self.write(moments.len(), &moment);
        moments.push(moment);
    }

    /// The rounds so far, after the start.
    pub fn moments(&self) -> MutexGuard<'_, Vec<Moment>> {
        self.moments.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    fn write(&self, round: usize, moment: &Moment) {
        let Some(log) = &self.log else { return };
        let mut log = log.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let named =
            |numbers: &[f64]| self.names.iter().cloned().zip(numbers.iter().map(|x| (*x).into())).collect::<serde_json::Map<_, _>>();
        let line = serde_json::json!({
            "round": round, "chi2": moment.chi2, "pixels": moment.pixels,
            "values": named(&moment.values), "errors": moment.errors.as_deref().map(named),
        });
        if log.1.is_ok() {
            log.1 = log.0.write(&format!("{line}\n"));
        }
    }

    /// Errors if a round could not be written.
    pub fn written(self) -> Outcome<()> {
        self.log.map_or(Ok(()), |log| log.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()).1)
    }
}

/// Writes the page of a recovery from a photograph, of which there is all this to doubt.
pub fn of_recovery(
    path: &Path,
    found: &Recovery,
    answer: &Answer,
    doubts: &[String],
    photo: &Photo,
    trail: &Trail,
    console: &Console,
) -> Outcome<()> {
    let told = Report {
        own: Some(found.own.deviations()),
        pixels: Some(found.pixels),
        filter: found.filter(),
        doubts,
        trail: &trail.moments(),
        unit: "round",
        ..told(answer, (Loss::Chi2, found.chi2))
    };
    write(path, told, photo.unknown(), Some(photo), console)
}

/// Writes the page of a search, and of the photograph it was for, if it was for one.
pub fn of_search(path: &Path, search: &Search, photo: Option<&Photo>, console: &Console) -> Outcome<()> {
    let annealer = search.annealer();
    let (Some(best), Some(measure)) = (annealer.best(), search.measured()) else {
        return Err(Error::new("nothing was evaluated yet: there is nothing to report").into());
    };
    let answer = search.answer(&best.values);
    let past = annealer.past().map(|(values, chi2)| Moment { values: values.to_vec(), errors: None, chi2, pixels: None });
    let told = Report { trail: &past.collect::<Vec<_>>(), followed: search.loss(), unit: "evaluation", ..told(&answer, measure) };
    write(path, told, search.unknown(), photo, console)
}

/// A report of an answer and how far it is off, and of nothing else yet.
fn told<'a>(answer: &'a Answer, measure: (Loss, f64)) -> Report<'a> {
    Report {
        name: "",
        kind: "",
        parameters: &[],
        reals: &[],
        values: answer.values(),
        errors: answer.errors().map(<[f64]>::to_vec),
        own: None,
        correlations: answer.correlations().cloned(),
        measure,
        pixels: None,
        filter: None,
        doubts: answer.doubts(),
        trail: &[],
        followed: Loss::Chi2,
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
