//! Whether what seems smooth is polished: up to a roughness of .001 RADIANCE takes a surface for a mirror with a Fresnel term,
//! which no lobe becomes, however narrow.

use super::model::Kind;
use super::rough::{self, SMOOTHEST, Sought};
use super::{Effort, Recovery};
use crate::anneal::linear::Symmetric;
use crate::error::Result;
use crate::material::{FRESNEL_FROM, PURE};
use crate::unknown::Unknown;

/// By how many standard errors a roughness must be more than the least that a lobe is looked at with for a lobe to be certain; and from which
/// roughness on it is, however large its error.
const SURE: f64 = 3.0;
const ROUGH: f64 = 0.02;

/// By how many standard errors pixels must be farther from a mirror than from a lobe, which has a roughness more to fit them with.
const FARTHER: f64 = 1.0;

/// The places of specularity and roughness among the real arguments.
const SPECULARITY: usize = 3;
const ROUGHNESS: usize = 4;

/// Recovers the numbers of plastic, metal, trans and their anisotropic kin, polished or not.
pub fn recover(sought: &Sought, effort: Effort, tell: &dyn Fn(&str)) -> Result<Recovery> {
    let open = |found: &Recovery| polished(sought.unknown, sought.kind, found);
    let found = rough::recover(sought, effort, &|found| open(found).is_some(), tell)?;
    let Some((slot, mirror)) = open(&found).filter(|_| !effort.late()) else { return Ok(found) };
    tell("polished");
    let mut near = found.values.clone();
    slot.map(|slot| near.remove(slot));
    let near: Vec<f64> = near.iter().zip(mirror.bounds()).map(|(value, (low, high))| value.clamp(low, high)).collect();
    let whole = |found: Recovery| if let Some(slot) = slot { with_roughness(found, slot) } else { found };
    let told = |found: &Recovery| (effort.told)(&whole(found.clone()));
    let other = whole(rough::polished(&Sought { unknown: &mirror, ..*sought }, Effort { told: &told, ..effort }, &near));
    if other.excess(&found) < FARTHER {
        return Ok(other);
    }
    let effort = Effort { around: Some(&found.values), ..effort };
    rough::recover(sought, effort, &|_| false, tell)
}

/// The unknown as one that is polished, if what was found of it leaves that open, with the place of the roughness among its parameters.
fn polished(unknown: &Unknown, kind: Kind, found: &Recovery) -> Option<(Option<usize>, Unknown)> {
    let starts_polished = unknown.reals(&unknown.start())[ROUGHNESS].abs() <= PURE;
    // Shadow rays pass what is polished, or not, by what the scene was built with.
    if kind.anisotropic || kind.transmits && !starts_polished {
        return None;
    }
    let slots = unknown.slots();
    let roughness = unknown.reals(&found.values)[ROUGHNESS].abs();
    let mirror = match slots[ROUGHNESS] {
        None => (roughness <= PURE).then(|| unknown.clone()),
        Some(slot) => {
            let open = roughness - SURE * found.errors()[slot] <= SMOOTHEST && roughness <= ROUGH;
            let alone = slots.iter().filter(|s| **s == Some(slot)).count() == 1;
            if open && alone && unknown.bounds()[slot].0 <= PURE { unknown.knowing(slot, 0.0) } else { None }
        }
    }?;
    let mirror = match mirror.slots()[SPECULARITY] {
        Some(slot) => (mirror.bounds()[slot].1 > FRESNEL_FROM).then(|| mirror.at_least(slot, FRESNEL_FROM)),
        None => (mirror.reals(&mirror.start())[SPECULARITY] >= FRESNEL_FROM).then_some(mirror),
    };
    Some((slots[ROUGHNESS], mirror?))
}

/// What was found of a mirror, with a roughness among its values: any up to [`PURE`].
fn with_roughness(found: Recovery, slot: usize) -> Recovery {
    let with = |matrix: &Symmetric, own: f64| {
        let place = |i: usize| if i < slot { Some(i) } else { i.checked_sub(1).filter(|i| *i >= slot) };
        Symmetric::of(matrix.size() + 1, |i, j| match (place(i), place(j)) {
            (Some(i), Some(j)) => matrix.at(i, j),
            _ if i == j => own,
            _ => 0.0,
        })
    };
    let (covariance, own, common) = (with(&found.covariance, PURE * PURE / 3.0), with(&found.own, 0.0), with(&found.common, 0.0));
    let inserted = |values: &[f64], value: f64| [&values[..slot], &[value], &values[slot..]].concat();
    let (values, clarity) = (inserted(&found.values, 0.0), inserted(&found.clarity, 1.0));
    Recovery { values, clarity, covariance, own, common, ..found }
}
