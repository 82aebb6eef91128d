//! anneal: what material it is, by simulated annealing.

use inverad::args::anneal::{Arguments, Job, SearchOptions};
use inverad::cli::auto::{Taken, opened, take};
use inverad::cli::exec::{Exec, last_number};
use inverad::cli::kept::Kept;
use inverad::cli::photo::{Direct, Photo};
use inverad::cli::predict::predict;
use inverad::cli::report::{self, Trail};
use inverad::cli::search::{Objective, Search, Watch};
use inverad::cli::{self, Answer, Console, Input, Outcome, Output, interrupted};
use inverad::error::Error;
use inverad::recover::{Effort, answer, recover};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    cli::main("anneal", run)
}

fn run(arguments: Arguments, console: &Console) -> Outcome<Answer> {
    let (output, job) = (arguments.common.output.as_deref(), arguments.job()?);
    let SearchOptions { state, report, log, .. } = &arguments.search;
    Output::possible([output, state.as_deref(), report.as_deref(), log.as_deref()].into_iter().flatten())?;
    match job {
        Job::Search(start) => search(&start, &arguments, console),
        Job::Propose(state, start) => {
            let search = match start {
                Some(start) => begin(&start, &arguments, Some(&state))?,
                None => Search::kept(&state)?,
            };
            search.save(&state)?;
            match search.proposal()? {
                Some(candidate) => Output::whole(output, &candidate).map(|()| Answer::Yes),
                None => found(&search, None, &arguments, console).map(|()| Answer::No),
            }
        }
        Job::Tell(state, chi2) => {
            let mut search = Search::kept(&state)?;
            let chi2 = match chi2 {
                Some(chi2) => chi2,
                None => last_number(&String::from_utf8_lossy(&Input::default().read("-")?.1))
                    .ok_or_else(|| Error::new("tell: no number on standard input; pipe the program into it that prints chi-squared"))?,
            };
            if search.annealer().propose().is_none() {
                return Err(Error::new(format!("{}: the search is over and asked for nothing", state.display())).into());
            }
            search.tell(chi2)?;
            search.save(&state).map(|()| Answer::Yes)
        }
        Job::Best(state) => found(&Search::kept(&state)?, None, &arguments, console).map(|()| Answer::Yes),
    }
}

fn search(start: &str, arguments: &Arguments, console: &Console) -> Outcome<Answer> {
    let photo = &arguments.photo;
    match (&arguments.judge.exec, &photo.target) {
        (Some(command), _) => {
            let search = begin(start, arguments, arguments.search.state.as_deref())?;
            let unknown = search.unknown().clone();
            anneal(search, &mut Exec::new(command, &unknown)?, None, arguments, console)
        }
        (None, Some(target)) if photo.direct => {
            let search = begin(start, arguments, arguments.search.state.as_deref())?;
            let unknown = search.unknown().clone();
            let photo = Photo::new(&unknown, Some(target), arguments, console)?;
            anneal(search, &mut Direct::new(&photo, arguments.loss())?, Some(&photo), arguments, console)
        }
        (None, Some(target)) => look(start, target, arguments, console),
        (None, None) if photo.predict => predict(start, arguments, console),
        (None, None) => {
            let message = "what shows the unknown? give --scene SCENE -vf VIEW --target PICTURE (or --predict), or --exec 'COMMAND that prints chi-squared'";
            Err(Error::new(message).into())
        }
    }
}

/// Recovers the material from the picture by the basis of its transport.
fn look(start: &str, target: &str, arguments: &Arguments, console: &Console) -> Outcome<Answer> {
    let options = arguments.options()?;
    arguments.idle().iter().for_each(|option| console.note(&format!("{option} is for --exec and --direct; it does nothing here")));
    let (begin, stopped) = (Instant::now(), interrupted());
    let until = || if stopped() { Some(begin) } else { arguments.time().map(|time| begin + time) };
    let effort = Effort::new(options.seed, options.tolerance, &until);
    let Taken { mut photo, mut title, mut doubts, around, asked, found } = take(start, target, effort, arguments, console)?;
    let unknown = &photo.unknown().clone();
    let (found, rounds) = found.unzip();
    let trail = Trail::new(unknown, rounds, arguments.search.log.as_deref())?;
    let effort = Effort { around: around.as_deref(), told: &|found| trail.hear(found, console), ..effort };
    let (found, cut) = match found {
        Some(found) => (found, false),
        None => {
            let found = recover(&photo.evidence(), unknown, photo.material(), effort, &|so_far| console.progress(|| so_far.into()))?;
            trail.hear(&found, console);
            let cut = stopped();
            if let Some(path) = arguments.search.state.as_ref().filter(|_| !cut) {
                Kept::save(path, asked, &unknown.material().kind, &title, &doubts, &found, &trail)?;
            }
            (found, cut)
        }
    };
    cut.then(|| console.note("interrupted: the values are those of the samples taken by then"));
    let answer = answer::Answer::new(unknown, &found.values, Some(&found.known()));
    title.extend(photo.blurred(&found));
    title.push(format!("chi2 {} over {} pixels", answer::six(found.chi2), found.pixels));
    Output::whole(arguments.common.output.as_deref(), &answer.file(&title)?)?;
    doubts.extend_from_slice(answer.doubts());
    doubts.iter().for_each(|doubt| console.warn(doubt));
    if let Some(path) = &arguments.search.report {
        report::of_recovery(path, &found, &answer, &photo, &trail, console)?;
    }
    trail.written()?;
    let missed = options.tolerance.and_then(|tolerance| answer::missed(unknown.parameters(), &found.errors(), tolerance));
    missed.iter().for_each(|missed| console.warn(missed));
    Ok(if missed.is_none() && !cut { Answer::Yes } else { Answer::No })
}

/// Searches for the unknown with someone who judges each candidate.
fn anneal(
    mut search: Search,
    judge: &mut dyn Objective,
    photo: Option<&Photo>,
    arguments: &Arguments,
    console: &Console,
) -> Outcome<Answer> {
    let SearchOptions { state, log, steps, .. } = &arguments.search;
    let watch = Watch { state: state.as_deref(), log: log.as_deref(), time: arguments.time(), steps: *steps, console };
    let reached = search.run(judge, &watch)?;
    found(&search, photo, arguments, console)?;
    search.lack().iter().for_each(|lack| console.warn(lack));
    Ok(if reached { Answer::Yes } else { Answer::No })
}

/// The search for the unknown of a file; where the state keeps it, as far as it got.
fn begin(start: &str, arguments: &Arguments, state: Option<&Path>) -> Outcome<Search> {
    let (document, wishes) = opened(start, arguments)?;
    let search = Search::new(&document.source.name, document.bytes(), wishes, arguments.loss(), arguments.options()?)?;
    Ok(match state {
        Some(state) => search.taken_up(state, arguments.search.steps)?,
        None => search,
    })
}

fn found(search: &Search, photo: Option<&Photo>, arguments: &Arguments, console: &Console) -> Outcome<()> {
    let (bytes, doubts) = search.found()?;
    Output::whole(arguments.common.output.as_deref(), &bytes)?;
    doubts.iter().for_each(|doubt| console.warn(doubt));
    arguments.search.report.as_ref().map_or(Ok(()), |path| report::of_search(path, search, photo, console))
}
