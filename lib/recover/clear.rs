//! Recovery of dielectric and glass: an index of refraction and a transmissivity.
//!
//! A search over all its range finds about where the index is (`indices`); looks at the pixels say the rest (`look`).

mod indices;
mod stage;
mod through;

use super::look::{Look, Looked, Model};
use super::sheet::Sheet;
use super::{Effort, Recovery, Seeds};
use crate::anneal::{Parameter, anywhere};
use crate::error::Result;
use indices::Search;
use stage::Stage;
use std::time::Instant;
use through::LEAST_INDEX;
pub use through::Through;

/// The types of material that are recovered so.
pub const KINDS: [&str; 2] = ["dielectric", "glass"];

/// The most that an index is sought to.
const MOST_INDEX: f64 = 10.0;

/// How far the two indices that the pixels are looked at with lie to either side: where the change between them is mostly noise, or the index may lie
/// anywhere between them, `WIDER` times as far, up to the last. (Of a bunny of index 2.4 a thirtieth is not: wherever a look began, .05 off too, it was
/// sure to .005.) Through what bends light less things are seen sharper, and change otherwise than in proportion, so they begin nearer below an index of
/// 1.5, down to the last: of Venus at 1.1 all colours came out .004 too bright by .003, and are right by .001 and less.
const SPREAD: f64 = 0.003;
const NEAREST: f64 = 0.0005;
const WIDER: f64 = 4.0;
const WIDEST: f64 = 0.048;

/// By how many standard errors a look must find the pixels farther off than another to have gone too far.
const SURE: f64 = 1.0;

/// Looks before the search gives up to keep the answer inside the indices.
const MOST_LOOKS: u32 = 8;

/// A model near the starting values.
pub fn near_start<'a>(through: &'a Through<'a>) -> impl Model + 'a {
    Stage::new(through, close(through, through.index(&through.unknown.start()), SPREAD))
}

/// Indices to look at the pixels with: the index itself where it is known.
fn close(through: &Through, index: f64, aside: f64) -> Vec<f64> {
    if through.slot().is_some() { vec![index - aside, index + aside] } else { vec![index] }
}

/// Recovers the numbers.
pub fn recover(through: &Through, pixels: &[usize], effort: Effort, tell: &dyn Fn(&str)) -> Result<Recovery> {
    let told = |found: &Recovery| (effort.told)(&through.found(found.clone()));
    let around = effort.around.map(|values| through.values(values));
    let rate = |i: usize, value: f64| through.rate(i, value);
    let effort = Effort { around: around.as_deref(), rate: &rate, told: &told, ..effort };
    Ok(through.found(looked(through, pixels, effort, tell)?))
}

/// What is found of an unknown by what paths through it let through.
fn looked(through: &Through, pixels: &[usize], effort: Effort, tell: &dyn Fn(&str)) -> Result<Recovery> {
    let Through { evidence, unknown, .. } = through;
    let (parameters, bounds, slot) = (unknown.parameters(), through.bounds(), through.slot());
    let mut seeds = Seeds::new(effort.seed);
    let fixed = through.index(&unknown.start());
    let (low, high) = slot.map_or((fixed, fixed), |i| bounds[i]);
    if slot.is_some() && low >= high {
        return Err(unknown
            .material()
            .error(format!("an index of refraction is sought from {LEAST_INDEX} on; give it higher bounds: --param ior=1.5:1:2.5")));
    }
    if slot.is_some() && high > MOST_INDEX {
        return Err(unknown
            .material()
            .error(format!("an index of refraction is sought up to {MOST_INDEX}; give it nearer bounds: --param ior=1.5:1:2.5")));
    }
    if let Some(i) = through.dark() {
        let Parameter { name, .. } = &parameters[i];
        let remedy = format!("give it bounds nearer to 1: --param {name}=.9999:.999:1");
        return Err(unknown
            .material()
            .error(format!("with such a {name} nothing comes through {:.3} units of length; {remedy}", through.length)));
    }
    let search = Search { through, range: (low, high), effort: &effort };
    let (mut best, known) = match effort.around {
        Some(values) => (values.to_vec(), (low, high)),
        None => search.best(&Sheet::new(evidence, pixels), &mut seeds, tell)?,
    };

    let begin = Instant::now();
    let bends = (through.index(&best) - 1.0).abs() / 0.5;
    let (mut pursuit, mut aside) = (Pursuit::default(), (SPREAD * bends).clamp(NEAREST, SPREAD));
    for look in 1.. {
        tell(&format!("look {look}"));
        let mut stage = Stage::new(through, close(through, through.index(&best), aside));
        let another = || look < MOST_LOOKS && effort.affords_another(begin, look);
        let closer = Look { evidence, pixels, parameters, bounds: &bounds, effort: &effort, another: &another, enough: &|_| false };
        let Looked { found, held, .. } = closer.at(&mut stage, &best, &mut seeds);
        let Some(i) = slot.filter(|_| !held && found.amiss().is_none()) else { return Ok(found) };
        let open = found.errors()[i] > aside && aside < WIDEST;
        if (open || !stage.tells(&found)) && another() {
            (best, aside) = (found.values, (WIDER * aside).min(WIDEST));
            continue;
        }
        let (mut here, next) = pursuit.next(found, i, best[i]);
        if !another() {
            // It was not got hold of: the index may be anywhere where the search has it.
            let range = if (known.0..=known.1).contains(&here.values[i]) { known } else { (low, high) };
            here.covariance.set(i, i, anywhere(range).powi(2).max(here.covariance.at(i, i)));
            return Ok(here);
        }
        best.clone_from(&here.values);
        best[i] = next.clamp(low, high);
        pursuit.lowest = Some(here);
    }
    unreachable!("the last look ends")
}

/// Looks after an index that lies beyond what each of them can see. One that finds it farther on in the same direction is followed by one twice as
/// far; one that went too far, by one just beside the lowest place so far.
#[derive(Default)]
struct Pursuit {
    /// What was found where the pixels were nearest.
    lowest: Option<Recovery>,
    /// How far on the last look went.
    stride: f64,
}

impl Pursuit {
    /// The better of what a look from the index `from` found and the lowest place, and where to look next for the index, which is parameter `i`.
    fn next(&mut self, found: Recovery, i: usize, from: f64) -> (Recovery, f64) {
        match self.lowest.take_if(|lowest| found.excess(lowest) > SURE) {
            Some(lower) => {
                self.stride = 0.0;
                let beside = lower.values[i];
                (lower, beside)
            }
            None => {
                let way = found.values[i] - from;
                self.stride = if self.stride * way > 0.0 { 2.0 * self.stride } else { way };
                (found, from + self.stride)
            }
        }
    }
}
