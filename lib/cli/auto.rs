//! The unknown of a file as the type that `--type` says, or as the one that the picture supports best.

use super::kept::{Asked, Found, Kept, Said};
use super::photo::Photo;
use super::{Console, Outcome, input};
use crate::args::anneal::{AUTO, Arguments};
use crate::error::{Error, Result};
use crate::rad::Document;
use crate::recover::model::Kind;
use crate::recover::saturated::apart;
use crate::recover::types::{SAMPLES, Sample, Trial, Verdict, choose};
use crate::recover::{Effort, Evidence, recover};
use crate::report::Moment;
use crate::unknown::{GLASS, Unknown, Wishes, retyped};
use crate::view::View;
use std::slice::from_ref;

/// A photograph whose unknown has been taken for a type.
pub struct Taken<'a> {
    /// The photograph.
    pub photo: Photo<'a>,
    /// What is to be said of the type.
    pub said: Said,
    /// About where the values are, if types were compared.
    pub around: Option<Vec<f64>>,
    /// What was asked.
    pub asked: Asked,
    /// What was found before, and how, where `--state` keeps it.
    pub found: Option<(Found, Vec<Moment>)>,
}

/// START.rad as it is, and what is wished of its material.
fn read(start: &str, arguments: &Arguments) -> Outcome<(Document, Wishes)> {
    // Where one of its numbers is missing, START.rad's name is taken for it.
    View::check(&arguments.photo.view.words)?;
    let (name, bytes) = input(start)?;
    Ok((Document::read(&name, bytes)?, arguments.wishes()))
}

/// START.rad, its material taken for the type that was named, and what is wished of it.
pub fn opened(start: &str, arguments: &Arguments) -> Outcome<(Document, Wishes)> {
    let (document, wishes) = read(start, arguments)?;
    match arguments.unknown.kind.as_deref() {
        None => Ok((document, wishes)),
        Some(AUTO) => Err(Error::new("--type auto compares pictures: it needs --scene and --target, without --exec or --direct").into()),
        Some(kind) => Ok(retyped(kind, &document, &wishes)?),
    }
}

/// The photograph `target`, its unknown taken for the type that was named, or with `--type auto` for the best.
pub fn take<'a>(start: &str, target: &str, effort: Effort, arguments: &Arguments, console: &'a Console) -> Outcome<Taken<'a>> {
    if arguments.unknown.kind.as_deref() != Some(AUTO) {
        let (document, wishes) = opened(start, arguments)?;
        let photo = Photo::new(&Unknown::new(document, &wishes)?, Some(target), arguments, console)?;
        let asked = Asked::new(start, arguments, photo.digest());
        let kept = kept(&asked, from_ref(photo.unknown()), arguments)?;
        let (said, found) = kept.map(|(kept, _)| (kept.said, (kept.found, kept.rounds))).unzip();
        return Ok(Taken { photo, said: said.unwrap_or_default(), around: None, asked, found });
    }
    let (document, wishes) = read(start, arguments)?;
    // A type that what was wished leaves without anything unknown is left out.
    let mut unknowns = Vec::new();
    for (kind, unknown) in Unknown::of_each_type(&document, &wishes)? {
        match unknown {
            Ok(unknown) => unknowns.push(unknown),
            Err(error) => console.note(&format!("{kind} is not tried: {}", error.message)),
        }
    }
    let Some(first) = unknowns.first() else {
        return Err(Error::new("--type auto: no type can be tried; give bounds with --param NAME=START:LOW:HIGH").into());
    };
    let mut photo = Photo::new(first, Some(target), arguments, console)?;
    photo.counting(&document);
    let asked = Asked::new(start, arguments, photo.digest());
    let glass = Unknown::as_glass_of_any_index(&document, &wishes).ok();
    let tried: Vec<Unknown> = unknowns.iter().chain(&glass).cloned().collect();
    if let Some((Kept { said, found, rounds, .. }, unknown)) = kept(&asked, &tried, arguments)? {
        photo.take_for(tried[unknown].clone())?;
        return Ok(Taken { photo, said, around: None, asked, found: Some((found, rounds)) });
    }
    let (verdict, unknown, around) = Comparison::new(&mut photo, effort, console)?.best(unknowns, glass)?;
    photo.take_for(unknown)?;
    let said = Said { title: vec![verdict.title()], doubts: verdict.doubts() };
    Ok(Taken { photo, said, around, asked, found: None })
}

/// Unknowns compared by how near pictures of them come to a photograph.
struct Comparison<'c, 'a> {
    photo: &'c mut Photo<'a>,
    pixels: Vec<usize>,
    effort: Effort<'c>,
    console: &'c Console,
}

impl<'c, 'a> Comparison<'c, 'a> {
    fn new(photo: &'c mut Photo<'a>, effort: Effort<'c>, console: &'c Console) -> Result<Self> {
        let pixels = photo.evidence().enough_pixels(photo.unknown(), photo.material())?;
        let (_, pixels) = apart(&photo.evidence(), pixels);
        Ok(Self { photo, pixels, effort: Effort { quick: true, wary: false, ..effort }, console })
    }

    /// Some of the unknowns, at their places, tried on a sample; what they were found to be before lies `around`.
    fn tried(&mut self, unknowns: &[Unknown], places: &[usize], around: &[Vec<f64>], sample: &Sample) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for (tried, &i) in places.iter().enumerate() {
            let unknown = &unknowns[i];
            self.photo.take_for(unknown.clone())?;
            let otherwise = self.photo.otherwise()?;
            let evidence = Evidence { mask: Some(&sample.mask), otherwise: otherwise.as_ref(), ..self.photo.evidence() };
            let tell = |so_far: &str| self.console.progress(|| format!("{}: {so_far}", unknown.material().kind));
            // An even share of half the time that is left: the other half is to recover the best in.
            let end = self.effort.part(2 * (places.len() - tried) as u32);
            let until = || (self.effort.until)().into_iter().chain(end).min();
            let effort = Effort { around: around.get(i).and_then(|values| near(unknown, values)), until: &until, ..self.effort };
            trials.push(Trial::new(unknown, recover(&evidence, unknown, self.photo.material(), effort, &tell)?));
        }
        Ok(trials)
    }

    /// The one that the photograph supports best, and about where its values are, if that helps. `glass` is one whose index is unknown.
    fn best(mut self, mut unknowns: Vec<Unknown>, glass: Option<Unknown>) -> Result<(Verdict, Unknown, Option<Vec<f64>>)> {
        let [few, more] = SAMPLES;
        let count = unknowns.len();
        let those = |wanted: &dyn Fn(usize) -> bool| -> Vec<usize> { (0..count).filter(|&i| wanted(i)).collect() };
        let mut sample = Sample::of(&self.photo.evidence(), &self.pixels, few);
        let mut places = those(&|_| true);
        let mut trials = self.tried(&unknowns, &places, &[], &sample)?;
        let mut verdict = choose(&trials, &sample);
        // What light goes through may be glass of another index than most.
        let usual = |i: &usize| unknowns[*i].material().kind == GLASS && unknowns[*i].material().reals.len() == 3;
        let out = (0..count).find(|i| usual(i) && verdict.rivals[*i].1.is_out()).filter(|_| THROUGH.contains(&verdict.kind()));
        if let (Some(i), Some(glass)) = (out, glass) {
            let usual = std::mem::replace(&mut unknowns[i], glass);
            let other = self.tried(&unknowns, &[i], &[], &sample)?;
            let former: Vec<Trial> = trials.splice(i..=i, other).collect();
            let again = choose(&trials, &sample);
            if again.kind() == GLASS {
                verdict = again;
            } else {
                unknowns[i] = usual;
                trials.splice(i..=i, former);
            }
        }
        if !verdict.is_sure() && self.pixels.len() > few && !self.effort.late() {
            let (first, around) = (verdict, found(&trials));
            let possible = those(&|i| !first.rivals[i].1.is_out());
            sample = Sample::of(&self.photo.evidence(), &self.pixels, more);
            // More pixels would hardly say otherwise of the rest, unless they say another type.
            places = those(&|i| i == first.chosen || !first.sure[i]);
            trials = self.tried(&unknowns, &places, &around, &sample)?;
            verdict = choose(&trials, &sample);
            if verdict.kind() != first.kind() && places != possible {
                places = possible;
                trials = self.tried(&unknowns, &places, &around, &sample)?;
                verdict = choose(&trials, &sample);
            }
            verdict.rivals.extend(those(&|i| !places.contains(&i)).into_iter().map(|i| first.rivals[i].clone()));
        }
        let (unknown, values) = (unknowns.swap_remove(places[verdict.chosen]), found(&trials).swap_remove(verdict.chosen));
        let around = near(&unknown, &values).map(<[f64]>::to_vec);
        Ok((verdict, unknown, around))
    }
}

/// The values that trials found.
fn found(trials: &[Trial]) -> Vec<Vec<f64>> {
    trials.iter().map(|trial| trial.recovery.values.clone()).collect()
}

/// What may seem to be what is glass of an index that was not tried.
const THROUGH: [&str; 2] = ["trans", "dielectric"];

/// About where values are that a few pixels have found. An index is, and takes long to find; a lobe is sought anew, since those few may miss a highlight.
fn near<'v>(unknown: &Unknown, values: &'v [f64]) -> Option<&'v [f64]> {
    Kind::named(&unknown.material().kind).is_none().then_some(values)
}

/// What `--state` keeps of what is asked, and which of the unknowns it is of.
fn kept(asked: &Asked, unknowns: &[Unknown], arguments: &Arguments) -> Result<Option<(Kept, usize)>> {
    arguments.search.state.as_deref().map_or(Ok(None), |path| Kept::load(path, asked, unknowns))
}
