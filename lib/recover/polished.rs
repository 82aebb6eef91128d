//! Whether what seems smooth is polished: up to a roughness of .001 RADIANCE takes a surface for a mirror with a Fresnel term,
//! which no lobe becomes, however narrow.

use super::doubts::{Standing, judge};
use super::misfit::Misfit;
use super::model::{Kind, SPECULARITY};
use super::rough::{self, SMOOTHEST, Sought, faint};
use super::{Effort, Evidence, Recovery};
use crate::anneal::linear::Symmetric;
use crate::error::Result;
use crate::material::{FRESNEL_FROM, PURE};
use crate::unknown::Unknown;

/// By how many standard errors a roughness must be more than the least that a lobe is looked at with for a lobe to be certain; and from which
/// roughness on it is, however large its error. Nor is a mirror likely where the error is larger, or where hardly anything specular is seen: of blinds
/// of trans that told nothing of a roughness of .15, one of six recoveries said 0 ± .007.
const SURE: f64 = 3.0;
const ROUGH: f64 = 0.02;

/// By how many standard errors pixels must be farther from a mirror than from a lobe that seems smooth, which has a roughness more to fit them with,
/// for it to be none; and nearer to it than to a lobe that may be of any roughness for it to be one. From three times that on there is no doubt of a lobe.
const FARTHER: f64 = 1.0;
const FAR: f64 = 3.0 * FARTHER;

/// The roughness at which what moves that of a mirror is judged before there is a picture.
pub const NEARLY: f64 = ROUGH;

/// The variance of a roughness that may be any up to [`PURE`].
pub const SPREAD: f64 = PURE * PURE / 3.0;

/// The place of the roughness among the real arguments.
const ROUGHNESS: usize = 4;

/// The real arguments that a scene is built with: shadow rays go on through what is polished there and lets light through, and end at all else.
pub fn begun(unknown: &Unknown) -> Vec<f64> {
    unknown.reals(&through(unknown))
}

/// The same of trans that is polished, if it does not start so, or rough, if it does; `None` where it cannot be otherwise than it starts.
pub fn otherwise(unknown: &Unknown) -> Option<Vec<f64>> {
    Kind::named(&unknown.material().kind).filter(|kind| kind.transmits && !kind.anisotropic)?;
    let slot = unknown.slots()[ROUGHNESS]?;
    let (low, high) = unknown.bounds()[slot];
    let mut values = through(unknown);
    values[slot] = if is_polished(unknown, &values) { high } else { 0.0 };
    (low <= PURE && high > PURE).then(|| unknown.reals(&values))
}

/// The values that an unknown starts with, but letting light through if it may.
fn through(unknown: &Unknown) -> Vec<f64> {
    let mut values = unknown.start();
    if let Some(kind) = Kind::named(&unknown.material().kind).filter(|kind| kind.transmits) {
        let shares = kind.roughnesses().end..unknown.material().reals.len();
        for slot in shares.filter_map(|argument| unknown.slots()[argument]) {
            values[slot] = values[slot].max(0.5 * unknown.bounds()[slot].1);
        }
    }
    values
}

/// Whether the unknown is polished, its parameters having these values.
fn is_polished(unknown: &Unknown, values: &[f64]) -> bool {
    unknown.reals(values)[ROUGHNESS].abs() <= PURE
}

/// Recovers the numbers of plastic, metal, trans and their anisotropic kin, polished or not.
pub fn recover(sought: &Sought, effort: Effort, tell: &dyn Fn(&str)) -> Result<Recovery> {
    let Evidence { world, otherwise, .. } = *sought.evidence;
    let other = otherwise.unwrap_or(world);
    let worlds = if is_polished(sought.unknown, &sought.unknown.start()) { [other, world] } else { [world, other] };
    let [rough, smooth] = worlds.map(|world| Evidence { world, ..*sought.evidence });
    let sought = &Sought { evidence: &rough, ..*sought };
    let open = |found: &Recovery| Mirror::of(sought.unknown, sought.kind, found);
    let seems = |found: &Recovery| open(found).is_some_and(|mirror| mirror.seems);
    // What was found to be one by pixels that are blurred otherwise is glanced at.
    let again =
        effort.around.filter(|around| is_polished(sought.unknown, around)).map(|around| sought.glance(effort, around)).filter(seems);
    let found = again.map_or_else(|| rough::recover(sought, effort, &seems, tell), Ok)?;
    let Some(Mirror { unknown, slot, likely, seems }) = open(&found).filter(|_| !effort.late()) else { return Ok(found) };
    tell("polished");
    let mut near = found.values.clone();
    if let Some(slot) = slot {
        near.remove(slot);
    }
    let near: Vec<f64> = near.iter().zip(unknown.bounds()).map(|(value, (low, high))| value.clamp(low, high)).collect();
    let mirror = Sought { evidence: &smooth, unknown: &unknown, kind: Kind { polished: true, ..sought.kind }, ..*sought };
    // What one has looked at longer are the pixels that tell most of a roughness, which are few and the noisiest: both are glanced at, as
    // a quick look has.
    let lobe = if effort.quick { found.clone() } else { sought.glance(effort, &found.values) };
    let seen = mirror.glance(effort, &near);
    let excess = seen.excess_alike(&lobe);
    let rough = |mirror: Recovery| match slot {
        Some(slot) => with_roughness(mirror, slot, sought.unknown.bounds()[slot].0, &lobe, excess),
        None => mirror,
    };
    // Where few samples made the picture, a mirror is nearer as whatever is smoother is: it lacks what single pixels hold.
    let nearer = match (likely, seen.misfit.singles > 0.0) {
        (true, false) => FARTHER,
        (false, false) => -FARTHER,
        (true, true) => -FAR,
        (false, true) => f64::NEG_INFINITY,
    };
    if excess < nearer {
        let whole = |mirror: Recovery| if likely { rough(mirror) } else { or_else(rough(mirror), &found, odds(excess)) };
        let told = |found: &Recovery| (effort.told)(&whole(found.clone()));
        // Light that meets it more often than products tell is that of the values it is looked at with, which those of a lobe are not: of a ball that
        // light goes through, colours came out .3 to .8 % too bright, which tells no type from another.
        let looked = if effort.quick { seen.clone() } else { mirror.look(Effort { told: &told, ..effort }, &seen.values) };
        // Where in a mirror a small light is seen few samples of a pixel tell.
        let looked = Recovery { misfit: Misfit { singles: 0.0, ..looked.misfit }, ..looked };
        // One that mirrors as little as it can may be one that does not.
        let least = sought.unknown.slots()[SPECULARITY].map_or(0.0, |slot| sought.unknown.bounds()[slot].0);
        let at_least = || unknown.slots()[SPECULARITY].is_some_and(|slot| looked.values[slot] <= unknown.bounds()[slot].0);
        let dullest = slot.is_some() && least < FRESNEL_FROM && at_least();
        if !dullest {
            return Ok(whole(looked));
        }
    }
    if !seems {
        return Ok(found);
    }
    let found = rough::recover(sought, Effort { around: Some(&lobe.values), ..effort }, &|_| false, tell)?;
    Ok(if (FARTHER..FAR).contains(&excess) { or_else(found, &rough(seen), odds(-excess)) } else { found })
}

/// An unknown as one that is polished.
pub struct Mirror {
    /// It, its roughness known.
    pub unknown: Unknown,
    /// The place of the roughness among its parameters before, if it was one.
    pub slot: Option<usize>,
    /// Whether it may well be so: else what was found of the roughness only leaves it open.
    likely: bool,
    /// Whether that, or what no lobe explains, is worth a glance before more is known.
    seems: bool,
}

impl Mirror {
    /// The unknown so, unless what was found of it as a lobe excludes that.
    fn of(unknown: &Unknown, kind: Kind, found: &Recovery) -> Option<Self> {
        if kind.anisotropic {
            return None;
        }
        let slots = unknown.slots();
        let roughness = unknown.reals(&found.values)[ROUGHNESS].abs();
        let (mirror, likely, seems) = match slots[ROUGHNESS] {
            None => ((roughness <= PURE).then(|| unknown.clone())?, true, true),
            Some(slot) => {
                let error = found.errors()[slot];
                let perhaps = roughness - SURE * error <= SMOOTHEST;
                let smooth = perhaps && roughness.max(error) <= ROUGH && !faint(kind, unknown, found);
                // Where trans that is rough does not explain the picture, its shadows may not be those of one that is.
                let likely = smooth || kind.transmits && !found.explained();
                let open = || judge(unknown, &found.values, &found.known()).standings[slot] == Standing::Open;
                // What no lobe explains may be a mirror that a few bright pixels made a narrow one of.
                let unlike = roughness <= ROUGH && found.misfit.off() > 0.0;
                // A mirror may be nearer to a picture whose single pixels hold the light of a sun, as whatever is smoother is.
                let few = found.misfit.singles > 0.0;
                let seems = likely || unlike && !few;
                let alone = slots.iter().filter(|s| **s == Some(slot)).count() == 1;
                if !alone || unknown.bounds()[slot].0 > PURE || !seems && (few || !perhaps && !open()) {
                    return None;
                }
                (unknown.knowing(slot, 0.0)?, likely, seems)
            }
        };
        Some(Self { unknown: mirroring(mirror)?, slot: slots[ROUGHNESS], likely, seems })
    }

    /// The unknown so, if that is how it starts, and it mirrors so much that there is a Fresnel term.
    pub fn at_start(unknown: &Unknown, kind: Kind) -> Option<Self> {
        let dull = unknown.reals(&unknown.start())[SPECULARITY] < FRESNEL_FROM;
        if kind.anisotropic || dull || !is_polished(unknown, &unknown.start()) {
            return None;
        }
        let slot = unknown.slots()[ROUGHNESS];
        let mirror = slot.map_or_else(|| Some(unknown.clone()), |slot| unknown.knowing(slot, 0.0))?;
        Some(Self { unknown: mirroring(mirror)?, slot, likely: true, seems: true })
    }
}

/// What is polished, and mirrors as much as there is a Fresnel term from; `None` if it mirrors less.
fn mirroring(polished: Unknown) -> Option<Unknown> {
    match polished.slots()[SPECULARITY] {
        Some(slot) => (polished.bounds()[slot].1 > FRESNEL_FROM).then(|| polished.at_least(slot, FRESNEL_FROM)),
        None => (polished.reals(&polished.start())[SPECULARITY] >= FRESNEL_FROM).then_some(polished),
    }
}

/// A covariance with that of one value more at a place, which goes with no other.
pub fn with_one_more(matrix: &Symmetric, slot: usize, own: f64) -> Symmetric {
    let place = |i: usize| if i < slot { Some(i) } else { i.checked_sub(1).filter(|i| *i >= slot) };
    Symmetric::of(matrix.size() + 1, |i, j| match (place(i), place(j)) {
        (Some(i), Some(j)) => matrix.at(i, j),
        _ if i == j => own,
        _ => 0.0,
    })
}

/// The variance of the roughness of a mirror by what moves that of a lobe, of this roughness, by this variance. Lobes blur by the square of their
/// roughness: what seems to move it by e, in proportion to what a change does there, moves it from 0 to √(2 r e).
pub fn smoothed(roughness: f64, variance: f64) -> f64 {
    variance.min(2.0 * roughness * variance.sqrt())
}

/// The odds of a lobe where pixels are by `excess` standard errors farther from a mirror, and of a mirror where they are so much farther from a lobe.
fn odds(excess: f64) -> f64 {
    (-0.5 * excess.min(0.0).powi(2)).exp()
}

/// What was found, its errors holding that it may be another by these odds: quite another one, where a lobe was taken for a mirror.
fn or_else(found: Recovery, other: &Recovery, odds: f64) -> Recovery {
    let away: Vec<f64> = found.values.iter().zip(&other.values).map(|(one, other)| other - one).collect();
    let part = odds / (1.0 + odds);
    // What cannot be may have errors without end.
    let held = |i: usize, j: usize| if part > 0.0 { part * (other.covariance.at(i, j) + away[i] * away[j]) } else { 0.0 };
    let covariance = Symmetric::of(away.len(), |i, j| (1.0 - part) * found.covariance.at(i, j) + held(i, j));
    Recovery { covariance, ..found }
}

/// What was found of a mirror, with a roughness among its values, the `least` there may be: any up to [`PURE`], or that of the lobe, as likely as
/// that is where pixels are by `excess` standard errors farther from the mirror. Errors that pixels have in common may make one of a lobe, and move it
/// as far as that one's.
fn with_roughness(found: Recovery, slot: usize, least: f64, lobe: &Recovery, excess: f64) -> Recovery {
    let moved = |matrix: &Symmetric| smoothed(lobe.values[slot], matrix.at(slot, slot));
    let variance = SPREAD + odds(excess) * (lobe.values[slot].powi(2) + moved(&lobe.covariance));
    let with = |matrix: &Symmetric, own: f64| with_one_more(matrix, slot, own);
    let (covariance, own, common) = (with(&found.covariance, variance), with(&found.own, 0.0), with(&found.common, moved(&lobe.common)));
    let (values, clarity) = (inserted(&found.values, slot, least.max(0.0)), inserted(&found.clarity, slot, 1.0));
    Recovery { values, clarity, pressed: inserted(&found.pressed, slot, false), covariance, own, common, ..found }
}

/// A row with one more at a place.
fn inserted<T: Clone>(row: &[T], place: usize, one: T) -> Vec<T> {
    [&row[..place], &[one], &row[place..]].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::rad::Document;
    use crate::unknown::Wishes;

    #[test]
    fn a_mirror_is_likely_where_it_is_seen_that_there_is_hardly_a_roughness() {
        let document = Document::parse(Source::new("m.rad", "void trans m 0 0 7 .7 .7 .7 .1 .1 .4 .3")).unwrap();
        let unknown = Unknown::new(document, &Wishes::default()).unwrap();
        let kind = Kind::named("trans").unwrap();
        // A specularity, a roughness, and what is let through, each with its error.
        let likely = |spec: [f64; 2], rough: [f64; 2], trans: [f64; 2]| {
            let all = [[0.7, 0.01], [0.7, 0.01], [0.7, 0.01], spec, rough, trans, [0.3, 0.1]];
            let found = Recovery::plain(&all.map(|[value, _]| value), &all.map(|[_, error]| error));
            Mirror::of(&unknown, kind, &found).map(|mirror| mirror.likely)
        };
        assert_eq!(likely([0.05, 0.01], [0.004, 0.003], [0.4, 0.01]), Some(true));
        assert_eq!(likely([0.05, 0.01], [0.1, 0.003], [0.4, 0.01]), None);
        // It may be of any roughness, and nothing specular is certain, neither mirrored nor seen through it.
        assert_eq!(likely([0.05, 0.01], [0.004, 0.2], [0.4, 0.01]), Some(false));
        assert_ne!(likely([0.05, 0.1], [0.004, 0.01], [0.4, 0.3]), Some(true));
    }
}
