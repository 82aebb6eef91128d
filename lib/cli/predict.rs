//! What a photograph would tell of an unknown, before any is taken.

use super::auto::opened;
use super::photo::Photo;
use super::{Answer as Done, Console, Outcome, Output};
use crate::args::anneal::Arguments;
use crate::recover::answer::Answer;
use crate::recover::predict::{assumed, predict as predicted};
use crate::recover::words::{digits, list};
use crate::recover::{Effort, Evidence};
use crate::unknown::Unknown;

/// An error that becomes less than this part of what it was is worth telling of.
const WORTH: f64 = 0.5;

/// Writes START.rad as it is, after the standard errors that a photograph of it would give, and what would make them smaller.
pub fn predict(start: &str, arguments: &Arguments, console: &Console) -> Outcome<Done> {
    let (document, wishes) = opened(start, arguments)?;
    let unknown = Unknown::new(document, &wishes)?;
    let photo = Photo::new(&unknown, None, arguments, console)?;
    let (evidence, seed) = (photo.evidence(), arguments.common.seed);
    console.progress(|| "predicting".into());
    let told = predicted(&evidence, &unknown, photo.material(), seed)?;
    let values = unknown.start();
    let answer = Answer::new(&unknown, &values, Some(&told.known()));
    let (width, height) = (evidence.film.width, evidence.film.height);
    let mut title = vec![
        format!("predicted for a picture of {width} x {height} pixels, {} of which show the unknown", told.pixels),
        format!("assumed: {}", assumed()),
    ];

    let parameters = unknown.parameters();
    let told_of = |i: usize, error: f64| format!("{} ± {}", parameters[i].name, digits(values[i], error).1);

    // See what one more lamp would do.
    console.progress(|| "predicting with one more lamp".into());
    let world = photo.with_a_lamp(told.level)?;
    let lit = predicted(&Evidence { world: &world, ..evidence }, &unknown, photo.material(), seed)?;
    let lit = Answer::new(&unknown, &values, Some(&lit.known()));
    if let (Some(before), Some(after)) = (answer.errors(), lit.errors()) {
        let better = (0..values.len()).filter(|&i| after[i] < WORTH * before[i]);
        let better = better.map(|i| told_of(i, after[i])).collect::<Vec<_>>();
        if !better.is_empty() {
            title.push(format!("with a small lamp over the camera's shoulder, as bright as all light there is: {}", better.join(", ")));
        }
    }
    title.push("four times as many pixels halve what is noise in these errors".into());
    let effort = Effort::new(seed, None, &|| None);
    let ends = |i: usize| effort.near(i, &parameters[i], values[i]);
    let errors = answer.errors().unwrap_or_default();
    let earlier: Vec<String> = (0..errors.len()).filter(|&i| errors[i] < ends(i)).map(|i| told_of(i, ends(i))).collect();
    if !earlier.is_empty() {
        title.push(format!("unless --tolerance asks for more, a recovery ends earlier: {}", list(&earlier)));
    }
    Output::whole(arguments.common.output.as_deref(), &answer.file(&title)?)?;
    answer.doubts().iter().for_each(|doubt| console.warn(doubt));
    Ok(Done::Yes)
}
