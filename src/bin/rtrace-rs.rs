//! rtrace-rs: renders RADIANCE scenes, with environment maps as light.

use inverad::args::rtrace::{Arguments, FEATURES, defaults, explain, has};
use inverad::cli::rays::{Stream, answer};
use inverad::cli::{self, Answer, Console, Disk, Outcome, Output, film, picture};
use inverad::error::{Error, Result};
use inverad::rays::{Fields, Format, Teller};
use inverad::rules::Rules;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    cli::main("rtrace-rs", run)
}

fn run(args: Arguments, console: &Console) -> Outcome<Answer> {
    let start = Instant::now();
    if args.defaults || args.features {
        let text = if args.features { FEATURES.into() } else { defaults(&args)? };
        let answer = if args.features && !has(&args.scenes) { Answer::No } else { Answer::Yes };
        return Output::whole(args.common.output.as_deref(), text.as_bytes()).map(|()| answer);
    }
    args.check()?;
    let sources: Vec<&str> = args.scenes.iter().map(String::as_str).chain(args.view.files()).collect();
    Output::check(args.files(), &sources)?;
    if args.merge {
        return film::merge(&args).map(|()| Answer::Yes);
    }
    if args.explain {
        explain(&args).lines().for_each(|line| console.note(line));
        if args.scenes.is_empty() && args.view.words.is_empty() {
            return Ok(Answer::Yes);
        }
    }
    let disk = Disk::new(args.scene_options.commands, console);
    let list = |file: &str| cli::list(&disk, file);
    let rules = args.light.rules(&list)?;
    if args.view.words.is_empty() {
        rays(&args, &rules, &disk, &list, console)
    } else {
        picture::rendered(&args, &rules, &disk, start, console)
    }
}

/// Answers the rays on standard input.
fn rays(args: &Arguments, rules: &Rules, disk: &Disk, list: &dyn Fn(&str) -> Result<Vec<String>>, console: &Console) -> Outcome<Answer> {
    let options = &args.rays;
    if args.scenes().iter().any(|name| name == "-") {
        return Err(Error::new("standard input holds the rays; name the files of the scene, or give a view (-vf FILE, -vp …)").into());
    }
    let format = Format::of(options.format())?;
    let mut fields = Fields::of(options.specifiers(), format.output)?;
    fields.among = options.among(list)?;
    let world = cli::world(args, rules, disk, console)?;
    disk.spares(args.files())?;
    let teller = Teller {
        world: &world,
        rules,
        fields: &fields,
        format,
        space: args.picture.space(),
        budget: args.accuracy.budget()?,
        seed: args.common.seed,
        limited: options.limited(),
        irradiance: options.point_irradiance(),
    };
    let (x, y) = args.picture.lines();
    let stream = Stream { x, y, header: options.header(), output: args.common.output.as_deref() };
    answer(teller, &stream, console)?;
    cli::say_failures(&world, &args.light, console);
    Ok(Answer::Yes)
}
