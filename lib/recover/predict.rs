//! How sure a photograph would make the values, before any is taken: from the scene, the view, the light, and the noise that a photograph has.

use super::doubts::Known;
use super::look::Model;
use super::misfit::Misfit;
use super::model::Kind;
use super::polished::{Mirror, NEARLY, SPREAD, smoothed, with_one_more};
use super::rough::{self, Sought};
use super::scores::{Evaluation, Scores};
use super::seen::scattered;
use super::sheet::{COMMON, Channels, Sheet, Weights, mean};
use super::{Evidence, clear, supported};
use crate::anneal::linear::Symmetric;
use crate::error::Result;
use crate::picture::{Header, Picture};
use crate::scene::MaterialId;
use crate::unknown::Unknown;

/// The noise of a photograph: the part of its value in each pixel and channel, independent of all others, and the part of the mean value that
/// it has where nothing shines.
const NOISE: f64 = 0.02;
const DARK: f64 = 0.001;

/// Samples of a pixel in each half, and of all pixels.
const EACH: (f64, f64) = (4.0, 128.0);
const SAMPLES: f64 = 400_000.0;
/// So many pixels are looked at, at the most; others tell as much.
const MOST: usize = 4000;

/// What a photograph would tell.
pub struct Prediction {
    covariance: Symmetric,
    common: Symmetric,
    /// How many pixels would count.
    pub pixels: usize,
    /// The mean radiance that they would show.
    pub level: f64,
}

impl Prediction {
    /// What would be known of the errors of the values.
    pub fn known(&self) -> Known<'_> {
        Known { covariance: self.covariance.clone(), common: Some(&self.common), pressed: &[], misfit: Misfit::default(), blur: None }
    }
}

/// What is assumed of the photograph.
pub fn assumed() -> String {
    let percent = |x: f64| 100.0 * x;
    format!(
        "noise of {} % of its value in each pixel and channel, and of {} % of the mean; errors that pixels have in common up to {} %",
        percent(NOISE),
        percent(DARK),
        percent(COMMON)
    )
}

/// What a photograph would tell of an unknown that has its starting values. The target of `evidence` does not matter.
pub fn predict(evidence: &Evidence, unknown: &Unknown, material: MaterialId, seed: u64) -> Result<Prediction> {
    supported(unknown)?;
    let all = evidence.pixels(unknown, material)?;
    let pixels = &scattered(&all, evidence.film.width)[..all.len().min(MOST)];
    match Kind::named(&unknown.material().kind) {
        Some(kind) => {
            let sought = Sought { evidence, unknown, material, kind, pixels };
            match Mirror::at_start(unknown, kind) {
                Some(mirror) => of_a_mirror(&sought, &mirror, &all, seed),
                None => by(&mut rough::near_start(&sought), evidence, unknown, [pixels, &all], seed),
            }
        }
        None => {
            let through = clear::Through::new(evidence, unknown, material);
            let found = by(&mut clear::near_start(&through), evidence, &through.unknown, [pixels, &all], seed)?;
            let rates = through.rates(&through.unknown.start(), &found.covariance);
            Ok(Prediction { covariance: found.covariance.scaled(&rates), common: found.common.scaled(&rates), ..found })
        }
    }
}

/// What all pixels would tell of what starts polished.
fn of_a_mirror(sought: &Sought, mirror: &Mirror, all: &[usize], seed: u64) -> Result<Prediction> {
    let predicted = |unknown: &Unknown, kind: Kind| {
        let sought = Sought { unknown, kind, ..*sought };
        by(&mut rough::near_start(&sought), sought.evidence, unknown, [sought.pixels, all], seed)
    };
    let found = predicted(&mirror.unknown, Kind { polished: true, ..sought.kind })?;
    let Some(slot) = mirror.slot else { return Ok(found) };
    let lobe = predicted(&sought.unknown.at_least(slot, NEARLY), sought.kind)?;
    let moved = |matrix: &Symmetric| smoothed(NEARLY, matrix.at(slot, slot));
    let covariance = with_one_more(&found.covariance, slot, SPREAD + moved(&lobe.covariance));
    Ok(Prediction { covariance, common: with_one_more(&found.common, slot, moved(&lobe.common)), ..found })
}

/// What all pixels would tell, by some of them.
fn by(model: &mut dyn Model, evidence: &Evidence, unknown: &Unknown, [pixels, all]: [&[usize]; 2], seed: u64) -> Result<Prediction> {
    let (values, bounds) = (unknown.start(), unknown.bounds());
    model.tune(&values, None);
    let each = (SAMPLES / (pixels.len() as f64)).clamp(EACH.0, EACH.1);
    let basis = model.trace_all(pixels, each as u32, seed);
    let here = Evaluation::new(model, &basis, &values, &bounds);
    let halves = &here.halves;
    // What would be photographed is what is rendered.
    let mut target = Picture::new(evidence.film.width, evidence.film.height, Header::default())?;
    for (i, &n) in pixels.iter().enumerate() {
        target.pixels[n] = std::array::from_fn(|c| mean(halves, i, c).max(0.0) as f32);
    }
    let evidence = Evidence { target: &target, steps: None, ..*evidence };
    let sheet = Sheet::new(&evidence, pixels);
    let dark = DARK * sheet.level;
    let count = all.len() as f64 / pixels.len() as f64;
    let weights: Channels = sheet
        .target
        .iter()
        .map(|t| t.map(|v| (count / ((NOISE * v as f64).powi(2) + dark * dark).max(f64::MIN_POSITIVE)) as f32))
        .collect();
    let scores = Scores::new(&sheet, Weights::new([weights.clone(), weights]), here, &bounds);
    Ok(Prediction { covariance: scores.expected(), common: scores.common(&Misfit::default()), pixels: all.len(), level: sheet.level })
}
