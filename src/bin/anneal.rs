//! anneal: what material it is, by simulated annealing.

use inverad::args::anneal::{Arguments, Job, SearchOptions};
use inverad::cli::auto::opened;
use inverad::cli::exec::{self, Exec};
use inverad::cli::kept::Asked;
use inverad::cli::photo::{Direct, Photo};
use inverad::cli::predict::predict;
use inverad::cli::recovery::recover;
use inverad::cli::report;
use inverad::cli::search::{Objective, Search, Watch};
use inverad::cli::{self, Answer, Console, Outcome, Output};
use inverad::error::Error;
use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main("anneal", run)
}

fn run(arguments: Arguments, console: &Console) -> Outcome<Answer> {
    let (output, job) = (arguments.common.output.as_deref(), arguments.job()?);
    let pages = || job.driven().into_iter().chain(arguments.pages());
    Output::check(pages().chain([arguments.common.output()]), &arguments.photo.files())?;
    // The answer may take START.rad's place.
    Output::check(pages(), &Vec::from_iter(job.start()))?;
    match job {
        Job::Search(start) => search(&start, &arguments, console),
        Job::Propose(state, start) => {
            let mut search = match start {
                Some(start) => begin(&start, &arguments)?.taken_up(&state, arguments.search.steps)?,
                None => Search::kept(&state)?,
            };
            let candidate = search.proposal()?;
            search.ask();
            search.save(&state)?;
            match candidate {
                Some(candidate) => Output::whole(output, &candidate).map(|()| Answer::Yes),
                None => found(&search, None, &arguments, console).map(|()| Answer::No),
            }
        }
        Job::Tell(state, chi2) => {
            let mut search = Search::kept(&state)?;
            let chi2 = match chi2 {
                Some(chi2) => chi2,
                None => exec::chi2(&String::from_utf8_lossy(&cli::input("-")?.1))
                    .ok_or_else(|| Error::new("tell: no number on standard input; pipe the program into it that prints chi-squared"))?,
            };
            search.hear(chi2, &state)?;
            search.save(&state).map(|()| Answer::Yes)
        }
        Job::Best(state) => found(&Search::kept(&state)?, None, &arguments, console).map(|()| Answer::Yes),
    }
}

fn search(start: &str, arguments: &Arguments, console: &Console) -> Outcome<Answer> {
    let photo = &arguments.photo;
    match (&arguments.judge.exec, &photo.target) {
        (Some(command), _) => {
            let search = begin(start, arguments)?.told_by(command);
            let unknown = search.unknown().clone();
            anneal(search, &mut Exec::new(command, &unknown)?, None, arguments, console)
        }
        (None, Some(target)) if photo.direct => {
            let search = begin(start, arguments)?;
            let photo = Photo::new(search.unknown(), Some(target), arguments, console)?;
            let search = search.judged_by(Asked::judged(arguments, photo.digest()));
            anneal(search, &mut Direct::new(&photo, arguments.loss())?, Some(&photo), arguments, console)
        }
        (None, Some(target)) => recover(start, target, arguments, console),
        (None, None) if photo.predict => predict(start, arguments, console),
        (None, None) => {
            let message = "what shows the unknown? give --scene SCENE -vf VIEW --target PICTURE (or --predict), or --exec 'COMMAND that prints chi-squared'";
            Err(Error::new(message).into())
        }
    }
}

/// Searches for the unknown with someone who judges each candidate; where the state keeps the search, from as far as it got.
fn anneal(search: Search, judge: &mut dyn Objective, photo: Option<&Photo>, arguments: &Arguments, console: &Console) -> Outcome<Answer> {
    let SearchOptions { state, log, steps, .. } = &arguments.search;
    let mut search = match state {
        Some(state) => search.taken_up(state, *steps)?,
        None => search,
    };
    let watch = Watch { state: state.as_deref(), log: log.as_deref(), time: arguments.time(), steps: *steps, console };
    let reached = search.run(judge, &watch)?;
    found(&search, photo, arguments, console)?;
    search.lack().iter().for_each(|lack| console.warn(lack));
    Ok(if reached { Answer::Yes } else { Answer::No })
}

/// The search for the unknown of a file.
fn begin(start: &str, arguments: &Arguments) -> Outcome<Search> {
    let (document, wishes) = opened(start, arguments)?;
    Ok(Search::new(&document.source.name, document.bytes(), wishes, arguments.loss(), arguments.options()?)?)
}

fn found(search: &Search, photo: Option<&Photo>, arguments: &Arguments, console: &Console) -> Outcome<()> {
    let (bytes, doubts) = search.found()?;
    let answered = Output::whole(arguments.common.output.as_deref(), &bytes);
    if answered.is_ok() {
        doubts.iter().for_each(|doubt| console.warn(doubt));
    }
    // The page is written even if nobody reads the answer.
    let reported = arguments.search.report.as_ref().map_or(Ok(()), |path| report::of_search(path, search, photo, console));
    answered.and(reported)
}
