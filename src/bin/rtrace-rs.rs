//! rtrace-rs: renders RADIANCE scenes, with environment maps as light.

use inverad::args::rtrace::Arguments;
use inverad::cal;
use inverad::cli::{self, Answer, Console, Disk, Outcome, Output, interrupted};
use inverad::error::Error;
use inverad::picture::exr::{Plane, Planes};
use inverad::picture::{Header, Picture};
use inverad::render::{Film, Rendering, Task, render};
use inverad::resolve::Resolve;
use inverad::scene::Scene;
use inverad::world::World;
use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main("rtrace-rs", run)
}

fn run(args: Arguments, console: &Console) -> Outcome<Answer> {
    let budget = args.accuracy.budget()?;
    if args.view.words.is_empty() {
        return Err(Error::new("no view; give one with -vf FILE or -vp, -vd … (--help lists all options)").into());
    }
    let view = cli::view(&args.view)?;
    let size = |given: Option<usize>| given.unwrap_or(512);
    let film = Film::new(&view, size(args.picture.x), size(args.picture.y), args.picture.pa.unwrap_or(1.0))?;

    let disk = Disk::new(args.scene_options.commands, cal::shipped, console);
    let rules = args.light.rules(&|list| Ok(words(&disk.library(list)?)))?;
    let flat = cli::flat(&args.scenes, &args.scene_options, &disk)?;
    let scene = Scene::new(&flat, &disk, args.skip_unsupported)?;
    if args.light.tuning.w != Some(false) {
        scene.warnings.iter().for_each(|w| console.warn(w));
    }
    let world = World::new(scene, &rules)?;

    let stop = interrupted();
    let task = Task {
        world: &world,
        rules: &rules,
        count: film.width * film.height,
        lens: &film.lens(),
        jitter: args.picture.pj.unwrap_or(1.0),
        budget,
        seed: args.common.seed,
    };
    let rendering = render(&task, &mut |so_far| {
        console.progress(|| format!("{} samples a pixel, error {:.2} %", so_far.samples, 100.0 * so_far.noise));
        !stop()
    });

    let mut header = Header::new(console.trail());
    header.push(&view.header_line());
    header.push(&format!("NOISE= {:.6}", rendering.noise));
    let aspect = film.camera.pixel_aspect(film.width, film.height);
    if !(0.995..=1.005).contains(&aspect) {
        header.push(&format!("PIXASPECT= {aspect:.6}"));
    }
    if let Some(path) = &args.picture.variance {
        Output::whole(Some(path), &variance(&film, &header, &rendering).write()?)?;
    }
    let picture = Picture {
        width: film.width,
        height: film.height,
        header,
        pixels: rendering.pixels.iter().map(|p| p.mean().to_array().map(|v| v as f32)).collect(),
    };
    let output = args.common.output.as_deref();
    let exr = args.picture.exr || output.is_some_and(|path| path.extension().is_some_and(|e| e == "exr"));
    let png = output.is_some_and(|path| path.extension().is_some_and(|e| e == "png"));
    let bytes = if exr {
        picture.write_exr()
    } else if png {
        picture.write_png()
    } else {
        picture.write_hdr()
    }?;
    Output::whole(output, &bytes)?;
    Ok(Answer::Yes)
}

/// The variance of each pixel of a rendering.
fn variance(film: &Film, header: &Header, rendering: &Rendering) -> Planes {
    let variances: Vec<[f32; 3]> = rendering.pixels.iter().map(|p| p.variance().0.to_array().map(|v| v as f32)).collect();
    let plane = |(c, name): (usize, &str)| Plane::new(&format!("variance.{name}"), variances.iter().map(|v| v[c]).collect());
    Planes {
        width: film.width,
        height: film.height,
        header: header.clone(),
        planes: ["R", "G", "B"].into_iter().enumerate().map(plane).collect(),
    }
}

/// The words of a text.
fn words(text: &[u8]) -> Vec<String> {
    String::from_utf8_lossy(text).split_whitespace().map(str::to_string).collect()
}
