//! A picture of a view, from the command line to the files that are written.

use super::{Answer, Console, Disk, Outcome, Output, film, interrupted, say_failures, view, world};
use crate::args::rtrace::Arguments;
use crate::error::Error;
use crate::integrator::survey;
use crate::rays::lengths;
use crate::render::{Film, Task, coverage, features, part, render};
use crate::rules::Rules;
use crate::scene::MaterialId;
use crate::vector::Vec3;
use std::time::Instant;

/// Renders the picture of a view, within the time since `start` where time is limited.
pub fn rendered(args: &Arguments, rules: &Rules, disk: &Disk, start: Instant, console: &Console) -> Outcome<Answer> {
    let options = &args.picture;
    let (view, (width, height)) = (view(&args.view)?, options.size());
    let film = Film::new(&view, width, height, options.aspect())?.through(options.filter());
    film.fits_memory()?;
    let size = (film.width, film.height);
    let budget = args.accuracy.budget()?;
    let aovs = options.aov.as_ref().map(|words| film::aovs(&words[0])).transpose()?;
    let mut world = world(args, rules, disk, console)?;
    disk.spares(args.files())?;
    survey(&mut world, film.some_rays(), rules);

    let lens = film.lens();
    let task = Task {
        blur: film.blur(options.aperture()),
        first: args.accuracy.first(),
        ..Task::new(&world, rules, &film, &lens, budget.after(start.elapsed(), aovs.is_some()), args.common.seed)
    };
    let header = film::header(console.trail(), &view, &film);
    let output = args.common.output.as_deref();
    let wanted = options.coverage.as_ref().map(|name| {
        let materials: Vec<MaterialId> = (0..world.materials().len()).filter(|&m| world.materials()[m].name == *name).collect();
        let missing = || Error::new(format!("--coverage {name}: no surface has a material of this name"));
        if materials.is_empty() { Err(missing()) } else { Ok(materials) }
    });
    let wanted = wanted.transpose()?;
    if let Some(path) = &options.z {
        Output::whole(Some(path), &film::depths(&lengths(&task)))?;
    }
    if let Some(materials) = wanted {
        let covered = film::picture(size, header, coverage(&task, &materials).into_iter().map(Vec3::splat));
        return film::write(&covered, output, options.exr).map(|()| Answer::Yes);
    }
    let stop = interrupted();
    let rendering = render(&task, &stop, &mut |so_far| {
        console.progress(|| film::reached(so_far));
    });
    let (mut interrupted, mut left) = (stop(), "");
    if let Some(range) = &args.accuracy.samples {
        if interrupted {
            return Err(Error::new("interrupted: a part of the samples of a part is of no use").into());
        }
        let planes = part(film.width, film.height, header, range, &rendering);
        return Output::whole(output, &planes.write()?).map(|()| Answer::Yes);
    }
    if let (Some(names), Some([_, path])) = (aovs, options.aov.as_deref()) {
        match features(&task, &rendering, &stop) {
            Some(features) => Output::whole(Some(path.as_ref()), &film::features(&film, &header, &names, &features)?)?,
            None => (interrupted, left) = (true, "; the pictures of --aov are not written"),
        }
    }
    film::finish(args, size, header, &rendering)?;
    say_failures(&world, &args.light, console);
    if interrupted {
        console.note(&format!("interrupted at {}; the picture is the best so far{left}", film::reached(&rendering)));
        return Ok(Answer::No);
    }
    Ok(Answer::Yes)
}
