//! A recovery from a picture, from the command line to the answer.

use super::auto::{Taken, take};
use super::kept::{Found, Kept};
use super::photo::Photo;
use super::report::{self, Trail};
use super::{Answer, Console, Outcome, Output, interrupted, say_failures};
use crate::args::anneal::Arguments;
use crate::error::Result;
use crate::recover::words::list;
use crate::recover::{self, Effort, Evidence, Recovery, answer, dead};
use std::time::Instant;

/// Recovers the material from the picture by the basis of its transport.
pub fn recover(start: &str, target: &str, arguments: &Arguments, console: &Console) -> Outcome<Answer> {
    let options = arguments.options()?;
    arguments.idle().iter().for_each(|[option, what]| console.note(&format!("{option} is for {what}; it does nothing here")));
    let (begin, stopped) = (Instant::now(), interrupted());
    let until = || if stopped() { Some(begin) } else { arguments.time().map(|time| begin + time) };
    let effort = Effort::new(options.seed, options.tolerance, &until);
    let Taken { mut photo, mut said, around, asked, found } = take(start, target, effort, arguments, console)?;
    let unknown = &photo.unknown().clone();
    let (found, rounds) = found.unzip();
    let trail = Trail::new(unknown, rounds, arguments.search.log.as_deref())?;
    let mut cut = false;
    let found = match found {
        Some(found) => {
            photo.leave_out(&found.dead);
            photo.blur(&found.recovery);
            found
        }
        None => {
            let effort = Effort { around: around.as_deref(), told: &|found| trail.hear(found, console), ..effort };
            let (found, doubts) = found_in(&mut photo, effort, &stopped, console)?;
            doubts.into_iter().for_each(|doubt| said.doubt(doubt));
            trail.hear(&found.recovery, console);
            cut = stopped();
            if let Some(path) = arguments.search.state.as_ref().filter(|_| !cut) {
                Kept::new(asked, unknown, &said, &found, &trail).save(path)?;
            }
            found
        }
    };
    let found = found.recovery;
    say_failures(photo.world(), &arguments.light, console);
    cut.then(|| console.note("interrupted: the values are those of the samples taken by then"));
    let answer = answer::Answer::new(unknown, &found.values, Some(&found.known()));
    said.title.extend(photo.remarks().iter().map(|remark| answer::warning(remark)));
    said.title.extend(found.filter());
    said.title.push(format!("chi2 {} over {} pixels", answer::six(found.chi2), found.pixels));
    let answered = Output::whole(arguments.common.output.as_deref(), &answer.file(&said.title)?);
    said.doubts.extend_from_slice(answer.doubts());
    if answered.is_ok() {
        said.doubts.iter().for_each(|doubt| console.warn(doubt));
    }
    // The page is written even if nobody reads the answer.
    let page = arguments.search.report.as_ref();
    let doubts = [photo.remarks(), &said.doubts].concat();
    let reported = page.map_or(Ok(()), |path| report::of_recovery(path, &found, &answer, &doubts, &photo, &trail, console));
    answered.and(reported).and(trail.written())?;
    let asked = options.tolerance.zip(answer.errors());
    let missed = asked.and_then(|(tolerance, errors)| answer::missed(unknown.parameters(), errors, tolerance));
    missed.iter().for_each(|missed| console.warn(missed));
    Ok(if missed.is_none() && !cut { Answer::Yes } else { Answer::No })
}

/// What the picture says, and what there is to doubt about it: looked at once more, if there is time, without the pixels that turn out to tell nothing,
/// and with those that tell something after all.
fn found_in(photo: &mut Photo, effort: Effort, stopped: &dyn Fn() -> bool, console: &Console) -> Result<(Found, Vec<String>)> {
    let begin = Instant::now();
    let mut recovery = recovered(photo, effort, console)?;
    let (saturated, dead) = (photo.saturated(&recovery)?, photo.dead(&recovery)?);
    // A flat surface that all is seen of tells more.
    let wary = saturated.is_some() || recovery.saturated.is_empty() || recovery.counts_saturated();
    let mut left_out = false;
    if (!dead.is_empty() || !wary) && effort.affords_another(begin, 1) {
        let counted = photo.leave_out(&dead);
        let again = recovered(photo, Effort { around: Some(&recovery.values), wary, ..effort }, console)?;
        // Cut short, it says less than the one before.
        left_out = !stopped();
        if left_out {
            recovery = again;
        } else {
            photo.count(counted);
        }
    }
    photo.blur(&recovery);
    let hurried = (effort.until)().is_some() && recovery.pixels < FEW;
    let there = if hurried && recovery.explained() { photo.otherwise_there(&recovery)? } else { None };
    let others =
        [there, saturated, dead::said(&dead, photo.width(), left_out), strays(&recovery, photo.width()), photo.inside_out(&recovery)];
    let around = photo.otherwise_around(&recovery)?;
    recovery.misfit.around = around.as_ref().map_or(0.0, |around| around.off).max(photo.guessed());
    let doubts = around.map(|around| around.said).into_iter().chain(others.into_iter().flatten()).collect();
    Ok((Found { recovery, dead: if left_out { dead } else { vec![] } }, doubts))
}

/// What the picture says, looked at once.
fn recovered(photo: &Photo, effort: Effort, console: &Console) -> Result<Recovery> {
    let otherwise = photo.otherwise()?;
    let evidence = Evidence { otherwise: otherwise.as_ref(), ..photo.evidence() };
    recover::recover(&evidence, photo.unknown(), photo.material(), effort, &|so_far| console.progress(|| so_far.into()))
}

/// Fewer pixels, looked at in a hurry, may not show that nothing explains the picture.
const FEW: usize = 300;
/// So many pixels that nothing explains may be faults of a camera; more are something else.
const FAULTS: usize = 12;

/// What is to be said of single pixels, of a picture so wide, that are far brighter than anything explains.
fn strays(found: &Recovery, width: usize) -> Option<String> {
    let places: Vec<String> = found.strays.iter().map(|n| format!("{},{}", n % width, n / width)).collect();
    let what = "far brighter than anything explains, and one alone may spoil an answer; leave out with --mask what the camera made so";
    (1..=FAULTS).contains(&places.len()).then(|| format!("pixels (column,row from the upper left, from 0) {} are {what}", list(&places)))
}
