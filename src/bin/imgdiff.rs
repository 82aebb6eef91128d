//! imgdiff: how far one picture is from another.

use inverad::args::imgdiff::{Args, DOF, SCALE};
use inverad::cli::{self, Answer, Console, Outcome, Output, Stop};
use inverad::error::Result;
use inverad::metric::{self, Comparison, Measures, Named};
use inverad::picture::exr::{self, Planes};
use inverad::picture::{Picture, png};
use serde_json::{Map, Value, json};
use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main("imgdiff", run)
}

fn run(args: Args, console: &Console) -> Outcome<Answer> {
    let metrics = args.metrics()?;
    let files = [Some(args.common.output()), args.heatmap.as_deref(), args.side_by_side.as_deref()];
    let others = [&args.unbiased, &args.mask, &args.variance].into_iter().flatten();
    let sources: Vec<&str> = [&args.a, &args.b].into_iter().chain(others).map(String::as_str).collect();
    Output::check(files.into_iter().flatten(), &sources)?;
    let (a, b) = (radiance(&args.a)?, radiance(&args.b)?);
    let c = args.unbiased.as_ref().map(|name| radiance(name)).transpose()?;
    let mask = args.mask.as_ref().map(|name| radiance(name)).transpose()?;
    let variance = args.variance.as_ref().map(|name| variance(name)).transpose()?;
    if a.1.header.primaries().is_some_and(|of_a| b.1.header.primaries().is_some_and(|of_b| of_a != of_b)) {
        console.warn(&format!("{} and {} have different PRIMARIES; their colours are compared as they are", a.0, b.0));
    }
    if let Some((name, _)) = c.as_ref().filter(|(_, c)| c.pixels == b.1.pixels) {
        console.warn(&format!(
            "{} and {name} are the same, noise and all: what it adds is not taken off (that of rpict -u+ is another each second)",
            b.0
        ));
    }

    let weights = mask.as_ref().map(|mask| metric::weights(named(mask), named(&a))).transpose()?;
    let mut comparison = Comparison::new(named(&a), named(&b), c.as_ref().map(named), weights.as_deref())?;
    if let Some(variance) = &variance {
        comparison = comparison.with_variance(named(variance))?;
    }
    let mut facts = Vec::new();
    if args.fit_exposure {
        let (fitted, factor) = comparison.fit_exposure()?;
        comparison = fitted;
        facts.push((SCALE, factor));
    }
    let measures = comparison.measure();
    if variance.is_some() {
        facts.push((DOF, measures.degrees_of_freedom - f64::from(args.fit_exposure)));
        if measures.without_variance > 0 {
            console.warn(&format!("{} values have no variance and are left out of chi2", measures.without_variance));
        }
    }

    if let Some(path) = &args.heatmap {
        Output::whole(Some(path), &png::write(a.1.width, a.1.height, &comparison.heatmap())?)?;
    }
    if let Some(path) = &args.side_by_side {
        let (width, height, pixels) = comparison.side_by_side();
        Output::whole(Some(path), &png::write(width, height, &pixels)?)?;
    }
    let values: Vec<_> = metrics.iter().map(|metric| metric.of(&measures)).collect();
    let text = if args.json { json_line(&values, &facts, &measures) } else { plain(&values, &facts) };
    let answer = if args.fail_above.is_some_and(|limit| values[0].1 > limit) { Answer::No } else { Answer::Yes };
    match Output::whole(args.common.output.as_deref(), text.as_bytes()) {
        // The answer stands even if nobody reads the number.
        Ok(()) | Err(Stop::Closed) => Ok(answer),
        Err(stop) => Err(stop),
    }
}

fn radiance(name: &str) -> Result<(String, Picture)> {
    let (name, bytes) = cli::input(name)?;
    Ok((name.clone(), Picture::read(&bytes, &name)?.into_radiance()))
}

/// Variances: the planes of that name, or the picture itself; as stored.
fn variance(name: &str) -> Result<(String, Picture)> {
    let (name, bytes) = cli::input(name)?;
    if bytes.starts_with(&exr::MAGIC) {
        let planes = Planes::read(&bytes, &name)?;
        let what = if planes.plane("variance.R").is_some() { "variance" } else { "" };
        return Ok((name.clone(), planes.into_picture(what, &name)?));
    }
    Ok((name.clone(), Picture::read(&bytes, &name)?))
}

fn named((name, picture): &(String, Picture)) -> Named<'_> {
    Named { name, picture }
}

/// One measure bare, several by name; then what else there is to know. Numbers are as short as they can be and still exact.
fn plain(values: &[(&str, f64)], facts: &[(&str, f64)]) -> String {
    let lines = |list: &[(&str, f64)]| list.iter().map(|(name, value)| format!("{name} {value:?}\n")).collect::<String>();
    match values {
        [(_, value)] => format!("{value:?}\n{}", lines(facts)),
        _ => lines(values) + &lines(facts),
    }
}

/// One object; what is not finite is null.
fn json_line(values: &[(&str, f64)], facts: &[(&str, f64)], m: &Measures) -> String {
    let mut object: Map<String, Value> = values.iter().chain(facts).map(|&(name, value)| (name.to_string(), json!(value))).collect();
    let (x, y, channel) = m.max_at;
    let channel = ["red", "green", "blue"][channel];
    object.insert("pixels".into(), json!(m.pixels));
    object.insert("max_at".into(), json!({"x": x, "y": y, "channel": channel}));
    format!("{}\n", Value::from(object))
}
