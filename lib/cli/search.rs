//! A search with the outside: kept in a file, logged, shown, interrupted, limited in time.

use super::interrupted;
use super::kept::Asked;
use super::stream::{Output, file, plain};
use super::{Console, Outcome};
use crate::anneal::linear::Symmetric;
use crate::anneal::{Annealer, End, Options, is_possible};
use crate::error::{Error, Result};
use crate::metric::Loss;
use crate::rad::{Document, Number, decode};
use crate::recover::answer::{Answer, missed, six};
use crate::recover::doubts::Known;
use crate::recover::misfit::Misfit;
use crate::recover::words::count;
use crate::unknown::{Unknown, Wishes};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// A search and all that is needed to take it up again.
pub struct Search {
    kept: Kept,
    unknown: Unknown,
}

/// What a state file holds.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// The start file's name and text.
    name: String,
    start: String,
    wishes: Wishes,
    /// What it takes for chi-squared.
    #[serde(default)]
    loss: Loss,
    /// What the renderings are compared with, if it is no command that does it.
    #[serde(default)]
    judged: Option<Asked>,
    /// The command that does it, if it is one.
    #[serde(default)]
    command: Option<String>,
    /// The chi-squared of the best, at the end, if that is not what was made small; nothing once there is more to tell.
    #[serde(default)]
    chi2: Option<f64>,
    /// The covariance of the errors of the best, at the end, where who judges knows it.
    #[serde(default)]
    covariance: Option<Symmetric>,
    annealer: Annealer,
    /// Whether `propose` has given out the proposal that `tell` tells of.
    #[serde(default)]
    asked: bool,
}

/// What is to be made small: chi-squared as a function of a vector.
pub trait Objective {
    /// Chi-squared at `values`, by the means of the stage (from 0, coarse, to the last, fine). It may be noisy, and negative where an
    /// unbiased estimate is; not finite means that these values are impossible.
    fn chi2(&mut self, values: &[f64], stage: usize) -> Result<f64>;

    /// What to ask where it says the same of all values.
    fn indifferent(&self) -> &'static str;

    /// The covariance of the errors of `values` at the end, if more is known of it than what is made small shows.
    fn covariance(&self, _values: &[f64]) -> Result<Option<Symmetric>> {
        Ok(None)
    }

    /// Chi-squared at `values`, if what is made small is something else.
    fn told(&self, _values: &[f64]) -> Result<Option<f64>> {
        Ok(None)
    }
}

/// What accompanies a search.
pub struct Watch<'a> {
    /// Where it is kept.
    pub state: Option<&'a Path>,
    /// Where each evaluation is written.
    pub log: Option<&'a Path>,
    /// How long it may take.
    pub time: Option<Duration>,
    /// How many evaluations it may take within that time.
    pub steps: Option<usize>,
    /// Who is shown how far it is.
    pub console: &'a Console,
}

/// Time between two savings: what is lost is done again, with the same result.
const PAUSE: Duration = Duration::from_millis(500);
/// Evaluations that show whether the command looks at the material at all.
const ENOUGH: usize = 12;

impl Search {
    /// A search for the unknown of a file that was read under that name.
    pub fn new(name: &str, bytes: Vec<u8>, wishes: Wishes, loss: Loss, mut options: Options) -> Result<Self> {
        let start = decode(bytes.clone());
        let unknown = Unknown::new(Document::read(name, bytes)?, &wishes)?;
        options.groups = unknown.groups().to_vec();
        let annealer = Annealer::new(unknown.parameters().to_vec(), options)?;
        Ok(Self {
            kept: Kept {
                name: name.into(),
                start,
                wishes,
                loss,
                judged: None,
                command: None,
                chi2: None,
                covariance: None,
                annealer,
                asked: false,
            },
            unknown,
        })
    }

    /// The same by renderings of what is asked.
    pub fn judged_by(mut self, judged: Asked) -> Self {
        self.kept.judged = Some(judged);
        self
    }

    /// The same by what a command says.
    pub fn told_by(mut self, command: &str) -> Self {
        self.kept.command = Some(command.into());
        self
    }

    /// The search that is kept in a file; `None` if there is no such file.
    pub fn load(path: &Path) -> Result<Option<Self>> {
        if !path.exists() {
            return Ok(None);
        }
        let damaged = |why: String| Error::new(format!("{}: not a search that anneal keeps ({why}); name another state", path.display()));
        let kept: Kept = serde_json::from_slice(&file(path)?).map_err(|e| damaged(e.to_string()))?;
        let start = Document::read(&kept.name, crate::rad::encode(&kept.start));
        let unknown = start.and_then(|start| Unknown::new(start, &kept.wishes)).map_err(|e| damaged(e.remark()))?;
        if !kept.annealer.is_consistent() || kept.annealer.parameters() != unknown.parameters() {
            return Err(damaged("its parts contradict each other".into()));
        }
        Ok(Some(Self { kept, unknown }))
    }

    /// The search that is kept in a file.
    pub fn kept(path: &Path) -> Result<Self> {
        Self::load(path)?.ok_or_else(|| Error::new(format!("{0}: no such file; begin with anneal propose {0} START.rad", path.display())))
    }

    /// The search that `state` keeps if it is the same as `self`, else `self`; with the number of evaluations, if `steps` says one.
    pub fn taken_up(self, state: &Path, steps: Option<usize>) -> Result<Self> {
        let Some(mut found) = Self::load(state)? else { return Ok(self) };
        let other = |what: &str| {
            let remedy = "remove it to begin anew, or name another state";
            Err(Error::new(format!("{}: it keeps a search with {what}; {remedy}", state.display())))
        };
        if found.kept.start != self.kept.start {
            return other("another start file");
        }
        let (was, is) = (found.kept.annealer.options().clone(), self.kept.annealer.options());
        if (&found.kept.wishes, found.kept.loss) != (&self.kept.wishes, self.kept.loss) || (Options { steps: is.steps, ..was }) != *is {
            return other("other options");
        }
        if found.kept.judged != self.kept.judged {
            return other("another picture, scene or view");
        }
        if found.kept.command.as_ref().is_some_and(|command| self.kept.command.as_ref() != Some(command)) {
            return other("another command");
        }
        found.kept.command = self.kept.command;
        if let Some(steps) = steps {
            found.kept.annealer.set_steps(steps);
        }
        Ok(found)
    }

    /// Keeps the search in a file.
    pub fn save(&self, path: &Path) -> Outcome<()> {
        let text = serde_json::to_vec(&self.kept).map_err(|e| Error::new(format!("{}: {e}", path.display())))?;
        Output::whole(Some(path), &text)
    }

    /// What it makes small.
    pub fn loss(&self) -> Loss {
        self.kept.loss
    }

    /// What is searched for.
    pub fn unknown(&self) -> &Unknown {
        &self.unknown
    }

    /// The search itself.
    pub fn annealer(&self) -> &Annealer {
        &self.kept.annealer
    }

    /// Takes the chi-squared of the proposal.
    pub fn tell(&mut self, chi2: f64) -> Result<()> {
        let annealer = &mut self.kept.annealer;
        if annealer.told() == 0 && !is_possible(chi2) {
            return Err(Error::new(format!("the chi-squared of the start is {chi2:?}: the start must be possible")));
        }
        annealer.tell(chi2);
        (self.kept.chi2, self.kept.covariance, self.kept.asked) = (None, None, false);
        Ok(())
    }

    /// Notes that the proposal is given out.
    pub fn ask(&mut self) {
        self.kept.asked = true;
    }

    /// Takes the chi-squared of the proposal that was given out; an error if none is, for the search that `state` keeps.
    pub fn hear(&mut self, chi2: f64, state: &Path) -> Result<()> {
        let lacking = match (self.kept.annealer.propose(), self.kept.asked) {
            (None, _) => "the search is over and asked for nothing".to_string(),
            (_, false) => format!("all it asked for has been told; get a candidate with anneal propose {}", state.display()),
            _ => return self.tell(chi2),
        };
        Err(Error::new(format!("{}: {lacking}", state.display())))
    }

    /// The file with the values of the proposal; `None` when the search is over.
    pub fn proposal(&self) -> Result<Option<Vec<u8>>> {
        self.unknown.told_by_file()?;
        self.kept.annealer.propose().map(|values| Ok(self.unknown.document(values)?.bytes())).transpose()
    }

    /// The measure of the best values so far and its value: chi-squared if that is known, else the loss that the search goes by.
    pub fn measured(&self) -> Option<(Loss, f64)> {
        match self.kept.chi2 {
            Some(chi2) => Some((Loss::Chi2, chi2)),
            None => Some((self.kept.loss, self.kept.annealer.best()?.chi2)),
        }
    }

    /// The file with the best values so far, after what is known of them; and what to warn of.
    pub fn found(&self) -> Result<(Vec<u8>, Vec<String>)> {
        let annealer = &self.kept.annealer;
        let (Some(best), Some((measure, value))) = (annealer.best(), self.measured()) else {
            return Err(Error::new("nothing was evaluated yet: there is no best"));
        };
        let title = format!("{} {} after {}", measure.name(), six(value), count(annealer.told(), "evaluation"));
        let answer = self.answer(&best.values);
        Ok((answer.file(&[title])?, answer.doubts().to_vec()))
    }

    /// What is lacking at the end in the standard errors that were wished for, if anything is.
    pub fn lack(&self) -> Option<String> {
        let (annealer, options) = (&self.kept.annealer, self.kept.annealer.options());
        match self.covariance() {
            Some(covariance) => missed(annealer.parameters(), &covariance.deviations(), options.tolerance?),
            None => options.polish.then(|| "the search ended before there were standard errors: give it more --steps or --time".into()),
        }
    }

    /// The covariance of the errors of the best: by who judges, where he knows it, else by what he said.
    fn covariance(&self) -> Option<Symmetric> {
        let (annealer, size) = (&self.kept.annealer, self.kept.annealer.parameters().len());
        let nothing = || Symmetric::diagonal(&vec![f64::INFINITY; size]);
        let known = self.kept.covariance.clone().filter(|known| known.is_finite_of(size));
        known.or_else(|| if annealer.is_flat() { Some(nothing()) } else { annealer.covariance() })
    }

    /// What there is to say of some values.
    pub fn answer(&self, values: &[f64]) -> Answer<'_> {
        let known =
            self.covariance().map(|covariance| Known { covariance, common: None, pressed: &[], misfit: Misfit::default(), blur: None });
        Answer::new(&self.unknown, values, known.as_ref()).and(self.jumps())
    }

    /// What is to be said of a chi-squared that jumps, unless who judges knows its noise.
    fn jumps(&self) -> Option<String> {
        let jumps = Some(self.kept.annealer.jumps()).filter(|jumps| *jumps > 0.0 && self.kept.covariance.is_none())?;
        let noise = "so noisy a rendering also adds to it, more where it is brighter, which errors do not hold";
        let remedy = "render with more samples, or twice with other noise for imgdiff --unbiased";
        Some(format!("chi-squared jumps by {} from one candidate to the next: {noise}; {remedy}", Number::rounded(jumps, 2)))
    }

    /// Searches to the end: of the search, of the time, or until the user interrupts. Says whether it got to the end that was wished for.
    pub fn run(&mut self, objective: &mut dyn Objective, watch: &Watch) -> Outcome<bool> {
        let annealer = &mut self.kept.annealer;
        // More time goes on where the last ended.
        if watch.time.is_some() && annealer.end() == Some(End::Budget) {
            annealer.set_steps(watch.steps.unwrap_or(annealer.told() + 1));
        }
        let mut log = watch.log.map(|path| Log::open(path, annealer.told())).transpose()?;
        let interrupted = interrupted();
        let (begin, already) = (Instant::now(), annealer.told());
        let mut saved = begin;
        while let Some(values) = self.kept.annealer.propose().map(<[f64]>::to_vec) {
            if interrupted() {
                let hint =
                    if watch.state.is_some() { "the same command goes on from here" } else { "with --state it could be taken up again" };
                watch.console.note(&format!("interrupted after {}; {hint}", count(self.kept.annealer.told(), "evaluation")));
                break;
            }
            let chi2 = match objective.chi2(&values, self.kept.annealer.stage()) {
                Ok(chi2) => chi2,
                Err(error) => {
                    // A command dies of the same Ctrl-C, perhaps a moment before we hear of it.
                    std::thread::sleep(Duration::from_millis(50));
                    if interrupted() {
                        continue;
                    }
                    watch.state.map_or(Ok(()), |path| self.save(path))?;
                    return Err(error.into());
                }
            };
            let annealer = &mut self.kept.annealer;
            let line = log.is_some().then(|| line(annealer, &self.unknown, self.kept.loss, chi2));
            self.tell(chi2)?;
            let annealer = &mut self.kept.annealer;
            if let (Some(log), Some(line)) = (&mut log, line) {
                log.write(&line)?;
            }
            if annealer.told() == ENOUGH && annealer.is_flat() {
                watch.console.warn(&format!("chi-squared is the same for every candidate: {}", objective.indifferent()));
            }
            if let Some(time) = watch.time {
                let (done, each) = (annealer.told() - already, begin.elapsed() / (annealer.told() - already).max(1) as u32);
                let left = time.saturating_sub(begin.elapsed()).as_secs_f64() / each.as_secs_f64().max(1e-9);
                annealer.set_steps((already + done).saturating_add(left as usize).min(watch.steps.unwrap_or(usize::MAX)));
            }
            watch.console.progress(|| progress(&self.kept.annealer, self.kept.loss));
            if let Some(path) = watch.state.filter(|_| saved.elapsed() > PAUSE) {
                self.save(path)?;
                saved = Instant::now();
            }
        }
        if let Some(best) = self.kept.annealer.best().filter(|_| !interrupted()) {
            self.kept.chi2 = objective.told(&best.values)?;
            let polished = self.kept.annealer.options().polish;
            self.kept.covariance = if polished { objective.covariance(&best.values)? } else { None };
        }
        watch.state.map_or(Ok(()), |path| self.save(path))?;
        let annealer = &self.kept.annealer;
        Ok(annealer.end().is_some() && (annealer.options().tolerance.is_none() || self.lack().is_none()))
    }
}

/// The log of a search or of a recovery.
pub struct Log {
    file: File,
    name: String,
}

impl Log {
    /// Opens the log after its first `lines` lines; what follows them was not kept in the state.
    pub fn open(path: &Path, lines: usize) -> Outcome<Self> {
        let name = path.display().to_string();
        let failed = |e: std::io::Error| Error::new(format!("{name}: {}", plain(&e)));
        let mut log = File::options().create(true).write(true).truncate(false).open(path).map_err(failed)?;
        // A pipe or a device has no lines to keep.
        if path.is_file() {
            let old = if lines > 0 { file(path)? } else { vec![] };
            let kept: usize = old.split_inclusive(|&b| b == b'\n').take(lines).map(<[u8]>::len).sum();
            log.set_len(kept as u64).and_then(|()| log.seek(SeekFrom::End(0))).map_err(failed)?;
        }
        Ok(Self { file: log, name })
    }

    /// Writes a line, whose end it holds.
    pub fn write(&mut self, line: &str) -> Outcome<()> {
        self.file.write_all(line.as_bytes()).map_err(|e| Error::new(format!("{}: {}", self.name, plain(&e))).into())
    }
}

/// An evaluation as one line of JSON.
fn line(annealer: &Annealer, unknown: &Unknown, loss: Loss, value: f64) -> String {
    let values = unknown.parameters().iter().zip(annealer.propose().unwrap_or_default());
    let values: serde_json::Map<String, serde_json::Value> = values.map(|(p, value)| (p.name.clone(), (*value).into())).collect();
    let line = serde_json::json!({
        "step": annealer.told() + 1, "stage": annealer.stage() + 1, "phase": annealer.phase(), loss.name(): value, "values": values,
    });
    format!("{line}\n")
}

/// How far the search is, on a line.
fn progress(annealer: &Annealer, loss: Loss) -> String {
    let Some(best) = annealer.best() else { return String::new() };
    let names = annealer.parameters().iter().zip(&best.values).map(|(p, value)| format!("{} {}", p.name, six(*value)));
    let phase = annealer.phase().map_or_else(String::new, |phase| format!("{phase:?}").to_lowercase());
    let (told, steps, measure) = (annealer.told(), annealer.options().steps, loss.name());
    format!("{told}/{steps} {phase} {measure} {} {}", six(best.chi2), names.collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chi_squared_of_an_end_is_not_that_of_what_is_found_later() {
        let start = b"void plastic it 0 0 5 .2 .4 .6 0 0\n".to_vec();
        let mut search = Search::new("start.rad", start, Wishes::default(), Loss::Log, Options::default()).unwrap();
        search.tell(5.0).unwrap();
        assert_eq!(search.measured(), Some((Loss::Log, 5.0)));
        search.kept.chi2 = Some(2.0);
        assert_eq!(search.measured(), Some((Loss::Chi2, 2.0)));
        search.tell(4.0).unwrap();
        assert_eq!(search.measured(), Some((Loss::Log, 4.0)));
    }
}
