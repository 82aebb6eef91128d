//! anneal: what material it is, by simulated annealing.

use inverad::args::anneal::{Arguments, Job};
use inverad::cli::exec::{Exec, last_number};
use inverad::cli::search::{Search, Watch};
use inverad::cli::{self, Answer, Console, Input, Outcome, Output};
use inverad::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    cli::main("anneal", run)
}

fn run(arguments: Arguments, console: &Console) -> Outcome<Answer> {
    let output = arguments.common.output.as_deref();
    match arguments.job()? {
        Job::Search(start) => search(&start, &arguments, console),
        Job::Propose(state, start) => {
            let search = match start {
                Some(start) => begin(&start, &arguments, Some(&state))?,
                None => kept(&state)?,
            };
            search.save(&state)?;
            match search.proposal()? {
                Some(candidate) => Output::whole(output, &candidate).map(|()| Answer::Yes),
                None => found(&search, &arguments, console).map(|()| Answer::No),
            }
        }
        Job::Tell(state, chi2) => {
            let mut search = kept(&state)?;
            let chi2 = match chi2 {
                Some(chi2) => chi2,
                None => last_number(&String::from_utf8_lossy(&Input::default().read("-")?.1))
                    .ok_or_else(|| Error::new("tell: no number on standard input; pipe the program into it that prints chi-squared"))?,
            };
            if search.annealer().propose().is_none() {
                return Err(Error::new(format!("{}: the search is over and asked for nothing", state.display())).into());
            }
            search.annealer().tell(chi2);
            search.save(&state).map(|()| Answer::Yes)
        }
        Job::Best(state) => found(&kept(&state)?, &arguments, console).map(|()| Answer::Yes),
    }
}

fn search(start: &str, arguments: &Arguments, console: &Console) -> Outcome<Answer> {
    let Some(command) = &arguments.judge.exec else {
        return Err(Error::new("who judges the candidates? give --exec 'COMMAND that prints chi-squared'").into());
    };
    let options = &arguments.search;
    let mut search = begin(start, arguments, options.state.as_deref())?;
    let unknown = search.unknown().clone();
    let mut objective = Exec::new(command, &unknown)?;
    let time = options.time.map(|seconds| Duration::from_secs_f64(seconds.min(1e9)));
    let watch = Watch { state: options.state.as_deref(), log: options.log.as_deref(), time, steps: options.steps, console };
    let reached = search.run(&mut objective, &watch)?;
    found(&search, arguments, console)?;
    Ok(if reached { Answer::Yes } else { Answer::No })
}

/// The search for the unknown of a file; where the state keeps it, as far as it got.
fn begin(start: &str, arguments: &Arguments, state: Option<&Path>) -> Outcome<Search> {
    let (name, bytes) = Input::default().read(start)?;
    let search = Search::new(&name, bytes, arguments.wishes(), arguments.options()?)?;
    Ok(match state {
        Some(state) => search.taken_up(state, arguments.search.steps)?,
        None => search,
    })
}

fn kept(state: &Path) -> Outcome<Search> {
    let begin = || Error::new(format!("{0}: no such file; begin with anneal propose {0} START.rad", state.display()));
    Ok(Search::load(state)?.ok_or_else(begin)?)
}

fn found(search: &Search, arguments: &Arguments, console: &Console) -> Outcome<()> {
    let (bytes, doubts) = search.found()?;
    Output::whole(arguments.common.output.as_deref(), &bytes)?;
    doubts.iter().for_each(|doubt| console.warn(doubt));
    Ok(())
}
