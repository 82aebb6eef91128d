//! Which type of material it is, by trying them.

use super::photo::Photo;
use super::{Console, Outcome};
use crate::error::Error;
use crate::rad::Document;
use crate::recover::types::{Sample, Trial, choose};
use crate::recover::{Effort, Evidence, recover};
use crate::unknown::{TYPES, Unknown, Wishes};

/// The type that a picture supports best.
pub struct Choice {
    /// The unknown, taken for it.
    pub unknown: Unknown,
    /// What is to be said of it, on a line.
    pub title: String,
    /// What there is to doubt.
    pub doubts: Vec<String>,
}

/// Takes the unknown of `document` for each type in turn; then the photograph is for the one chosen. A type that what was wished leaves without
/// anything unknown is left out.
pub fn auto(document: &Document, wishes: &Wishes, photo: &mut Photo, effort: Effort, console: &Console) -> Outcome<Choice> {
    let effort = Effort { quick: true, ..effort };
    let mut trials = Vec::new();
    let mut sample = None;
    for (kind, _) in TYPES {
        let unknown = match Unknown::taken_for(kind, document, wishes) {
            Ok(unknown) => unknown,
            Err(error) => {
                console.note(&format!("{kind} is not tried: {}", error.message));
                continue;
            }
        };
        photo.take_for(unknown.material())?;
        let evidence = photo.evidence();
        if sample.is_none() {
            sample = Some(Sample::of(&evidence, &evidence.pixels(&unknown, photo.material())?));
        }
        let evidence = Evidence { mask: sample.as_ref().map(|s| &s.mask[..]), ..evidence };
        let found = recover(&evidence, &unknown, photo.material(), effort, &|so_far| console.progress(|| format!("{kind}: {so_far}")))?;
        trials.push(Trial::new(&unknown, found));
    }
    let Some(sample) = sample else {
        return Err(Error::new("--type auto: no type has a free parameter; give bounds with --param NAME=START:LOW:HIGH").into());
    };
    let verdict = choose(&trials, &sample);
    let unknown = Unknown::taken_for(&trials[verdict.chosen].kind, document, wishes)?;
    photo.take_for(unknown.material())?;
    Ok(Choice { unknown, title: verdict.title(&trials), doubts: verdict.doubts(&trials) })
}
