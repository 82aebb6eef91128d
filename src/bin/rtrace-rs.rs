//! rtrace-rs: renders RADIANCE scenes, with environment maps as light.

use inverad::args::rtrace::{Arguments, FEATURES, defaults, explain, has};
use inverad::cal;
use inverad::cli::rays::{Stream, answer};
use inverad::cli::{self, Answer, Console, Disk, Outcome, Output, film, interrupted};
use inverad::error::{Error, Result, Source};
use inverad::expand::expand;
use inverad::rays::{Fields, Format, Teller, lengths};
use inverad::render::{Film, Task, coverage, features, part, render};
use inverad::resolve::Resolve;
use inverad::rules::Rules;
use inverad::scene::{MaterialId, Scene};
use inverad::vector::Vec3;
use inverad::world::World;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

fn main() -> ExitCode {
    cli::main("rtrace-rs", run)
}

fn run(args: Arguments, console: &Console) -> Outcome<Answer> {
    let start = Instant::now();
    if args.defaults || args.features {
        let text = if args.features { FEATURES.into() } else { defaults(&args)? };
        let answer = if args.features && !has(&args.scenes) { Answer::No } else { Answer::Yes };
        return Output::whole(None, text.as_bytes()).map(|()| answer);
    }
    args.possible()?;
    Output::possible(args.files())?;
    if args.merge {
        return film::merge(&args).map(|()| Answer::Yes);
    }
    if args.explain {
        explain(&args).lines().for_each(|line| console.note(line));
        if args.scenes.is_empty() {
            return Ok(Answer::Yes);
        }
    }
    let disk = Disk::new(args.scene_options.commands, cal::shipped, console);
    let list = |file: &str| cli::list(&disk, file);
    let rules = args.light.rules(&list)?;
    if args.view.words.is_empty() { rays(&args, &rules, &disk, &list, console) } else { picture(&args, &rules, &disk, start, console) }
}

/// The world of the scene that was named.
fn world(args: &Arguments, rules: &Rules, disk: &Disk, console: &Console) -> Outcome<World> {
    let flat = expand(cli::documents(&args.scenes(), disk)?, disk)?;
    let mut definitions: Vec<Arc<Source>> = args.definitions.iter().map(|text| Source::new("-e", text.as_str())).collect();
    for name in &args.function_files {
        definitions.push(Source::new(name.as_str(), String::from_utf8_lossy(&disk.library(name)?)));
    }
    let scene = Scene::with(&flat, disk, args.skip_unsupported, definitions)?;
    if args.light.tuning.w != Some(false) {
        scene.warnings.iter().for_each(|w| console.warn(w));
    }
    Ok(World::new(scene, rules)?)
}

/// Answers the rays on standard input.
fn rays(args: &Arguments, rules: &Rules, disk: &Disk, list: &dyn Fn(&str) -> Result<Vec<String>>, console: &Console) -> Outcome<Answer> {
    let options = &args.rays;
    if args.scenes().iter().any(|name| name == "-") {
        return Err(Error::new("standard input holds the rays; name the files of the scene, or give a view (-vf FILE, -vp …)").into());
    }
    let format = Format::of(options.format.as_deref().unwrap_or("a"))?;
    let mut fields = Fields::of(options.specifiers.as_deref().unwrap_or("v"), format.output)?;
    fields.among = options.among(list)?;
    let world = world(args, rules, disk, console)?;
    let teller = Teller {
        world: &world,
        rules,
        fields: &fields,
        format,
        space: args.picture.space(),
        budget: args.accuracy.budget()?,
        seed: args.common.seed,
        limited: options.limit.unwrap_or(false),
        irradiance: options.point_irradiance.unwrap_or(false),
    };
    let stream = Stream {
        x: args.picture.x.unwrap_or(0),
        y: args.picture.y.unwrap_or(0),
        header: options.header.unwrap_or(true),
        output: args.common.output.as_deref(),
    };
    answer(teller, &stream, console)?;
    Ok(Answer::Yes)
}

/// Renders the picture of a view, within the time since `start` where time is limited.
fn picture(args: &Arguments, rules: &Rules, disk: &Disk, start: Instant, console: &Console) -> Outcome<Answer> {
    let options = &args.picture;
    let view = cli::view(&args.view)?;
    let film = Film::new(&view, options.x.unwrap_or(512), options.y.unwrap_or(512), options.pa.unwrap_or(1.0))?.through(options.filter());
    let size = (film.width, film.height);
    let budget = args.accuracy.budget()?;
    let aovs = options.aov.as_ref().map(|words| film::aovs(&words[0])).transpose()?;
    let mut world = world(args, rules, disk, console)?;
    world.survey(film.some_rays(), rules);

    let task = Task {
        world: &world,
        rules,
        count: film.width * film.height,
        width: film.width,
        lens: &film.lens(),
        centred: film.filter.is_point(),
        blur: film.blur(options.pd.unwrap_or(0.0)),
        budget: budget.after(start.elapsed(), aovs.is_some()),
        first: args.accuracy.first(),
        seed: args.common.seed,
    };
    let header = film::header(console.trail(), &view, &film);
    let output = args.common.output.as_deref();
    if let Some(path) = &options.z {
        Output::whole(Some(path), &film::depths(&lengths(&task)))?;
    }
    if let Some(name) = &options.coverage {
        let materials: Vec<MaterialId> = (0..world.materials().len()).filter(|&m| world.materials()[m].name == *name).collect();
        if materials.is_empty() {
            return Err(Error::new(format!("--coverage {name}: no surface has a material of this name")).into());
        }
        let covered = film::picture(size, header, coverage(&task, &materials).into_iter().map(Vec3::splat));
        return film::write(&covered, output, options.exr).map(|()| Answer::Yes);
    }
    let stop = interrupted();
    let rendering = render(&task, &stop, &mut |so_far| {
        console.progress(|| film::reached(so_far));
    });
    let interrupted = stop();
    if let Some(range) = &args.accuracy.samples {
        if interrupted {
            return Err(Error::new("interrupted: a part of the samples of a part is of no use").into());
        }
        let planes = part(film.width, film.height, header, range, &rendering);
        return Output::whole(output, &planes.write()?).map(|()| Answer::Yes);
    }
    if let (Some(names), Some([_, path])) = (aovs, options.aov.as_deref()) {
        Output::whole(Some(path.as_ref()), &film::features(&film, &header, &names, &features(&task, &rendering))?)?;
    }
    film::finish(args, size, header, &rendering)?;
    if interrupted {
        console.note(&format!("interrupted at {}; the picture is the best so far", film::reached(&rendering)));
        return Ok(Answer::No);
    }
    Ok(Answer::Yes)
}
