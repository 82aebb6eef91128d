//! A look at the picture: samples where they tell most, the values that explain it best near some others, and how sure they are.

use super::drift::{LATE, PICTURES};
use super::enough::More;
use super::misfit::Misfit;
use super::scores::{Evaluation, Way, influence, pictures};
use super::seen::First;
use super::settle::Settled;
use super::sheet::{COMMON, Half, Sheet};
use super::{Effort, Evidence, Recovery, Seeds};
use crate::anneal::Parameter;
use crate::anneal::linear::Symmetric;
use crate::transport::Basis;
use std::ops::Range;

/// A model of the picture near some values of the parameters.
pub trait Model: Sync {
    /// Prepares to trace where the values are, as far as is known: its columns stay what they are.
    fn tune(&mut self, values: &[f64], errors: Option<&[f64]>);

    /// Traces two independent estimates of the basis of some pixels, by some of the samples that a seed makes.
    fn trace(&self, pixels: &[usize], samples: &[Range<u32>], seed: u64) -> Basis;

    /// The same by the first samples of each in each half, as many for all.
    fn trace_all(&self, pixels: &[usize], samples: u32, seed: u64) -> Basis {
        self.trace(pixels, &vec![0..samples; 2 * pixels.len()], seed)
    }

    /// The coefficients of the columns of each channel for values of the parameters.
    fn coefficients(&self, values: &[f64]) -> [Vec<f64>; 3];

    /// The nearest values at which the model can be trusted.
    fn trusted(&self, values: &[f64]) -> Vec<f64>;

    /// The parameters whose standard errors say little, their derivatives being so much noise, or that of another value being by one of all that they
    /// may be: the place of each, and all values that it may have, rising, as far as the model goes.
    fn doubtful(&self, found: &Recovery) -> Vec<(usize, Vec<f64>)>;

    /// How much each pixel tells of what is to be known, as far as that can be foreseen; a seed fixes what is left to chance.
    fn telling(&self, pixels: &[usize], seed: u64) -> Option<Vec<f64>>;

    /// What the first round looks at, where those pixels are foreseen that tell most.
    fn first(&self) -> First;

    /// Whether few samples hold much of the light of a pixel: what is held back is then missed.
    fn glints(&self) -> bool;

    /// How much of a standard error one pixel may make: while the values are only near, and in the end.
    fn pulls(&self) -> [f64; 2];

    /// Samples of each pixel in each half of the first round, at the least. Rather few pixels that say something than many that are all
    /// noise, which the bottom of χ² takes for signal; derivatives are noise too, and noise is multiplied with noise.
    fn least(&self) -> f64;

    /// Whether what was found with a basis lies well inside of where the model can be trusted: if not, it had better be looked at by one around it.
    fn holds(&self, found: &Recovery, basis: &Basis) -> bool;

    /// By which part of itself all light may be off as a basis goes by values that were found to be others since; 0 where that is next to nothing.
    fn presumed(&self, found: &Recovery, basis: &Basis) -> f64;
}

/// By how much a round adds to all samples before it, at the least and at the most: errors fall faster than samples grow while the derivatives
/// are noise too.
const GROWTH: (f64, f64) = (0.2, 0.8);

/// The most rounds; and how many samples of all pixels, in each half, are enough where no tolerance is asked for.
const ROUNDS: usize = 12;
const BUDGET: f64 = 500_000.0;

/// What a round finds.
pub struct Fit {
    /// The values.
    pub found: Recovery,
    /// How much the error of a sample in each pixel disturbs the values.
    pub influence: Vec<f64>,
    /// Whether pixels were held back.
    pub held: bool,
    /// Where the pixels that were held back would move the values, where there is more than chance in it.
    pub withheld: Option<Way>,
}

/// What a look comes to.
pub struct Looked {
    /// What was found.
    pub found: Recovery,
    /// How far that was moved from where pixels have it that are not held back.
    pub aside: Way,
    /// Whether the model held there.
    pub held: bool,
}

/// Pixels, and what a model traced of them.
#[derive(Clone, Copy)]
pub struct Traced<'a> {
    /// The pixels.
    pub sheet: &'a Sheet<'a>,
    /// The model.
    pub model: &'a dyn Model,
    /// What it traced.
    pub basis: &'a Basis,
}

impl Traced<'_> {
    /// The picture of each half at some values.
    pub fn halves(&self, values: &[f64]) -> Vec<Half> {
        pictures(self.basis, &[self.model.coefficients(values)]).swap_remove(0)
    }

    /// The same, with its derivatives, inside bounds.
    pub fn evaluation(&self, values: &[f64], bounds: &[(f64, f64)]) -> Evaluation {
        Evaluation::new(self.model, self.basis, values, bounds)
    }
}

/// What is looked at, and with what in mind.
pub struct Look<'a> {
    /// The picture.
    pub evidence: &'a Evidence<'a>,
    /// The pixels that count.
    pub pixels: &'a [usize],
    /// The parameters.
    pub parameters: &'a [Parameter],
    /// Their bounds, as far as the model goes.
    pub bounds: &'a [(f64, f64)],
    /// When it is enough, and who is told what each round finds.
    pub effort: &'a Effort<'a>,
    /// Whether there is time for another look, if this one strays.
    pub another: &'a (dyn Fn() -> bool + Sync),
    /// Whether what two rounds or more found is enough, as it seems to be what another model is of.
    pub enough: &'a (dyn Fn(&Recovery) -> bool + Sync),
}

impl Look<'_> {
    /// Traces and fits, round by round, until what was found is enough, or lies where the model is not to be trusted. More and more pixels are
    /// seen, as long as they tell of what is wanted most; among those seen, what one round finds says where the next samples are worth most.
    pub fn at(&self, model: &mut dyn Model, near: &[f64], seeds: &mut Seeds) -> Looked {
        model.tune(near, None);
        let mut seen = self.first(model, seeds.next());
        let (mut best, mut before) = (near.to_vec(), [(); 2].map(|()| vec![0.0; near.len()]));
        for round in 1.. {
            let sheet = Sheet::new(self.evidence, seen.pixels());
            let traced = Traced { sheet: &sheet, model, basis: &seen.basis };
            let mut fit = self.fit(traced, &best);
            let untempered = fit.found.errors();
            self.temper(&mut fit.found, &before);
            let found = &fit.found;
            before = [found.errors(), untempered];
            (self.effort.told)(found);
            if self.evidence.blurred {
                let blurred = self.blurred(found.clone(), traced);
                if blurred.amiss().is_some() {
                    return Looked { aside: aside(found, &blurred), held: model.holds(&blurred, &seen.basis), found: blurred };
                }
            }
            let strayed = !model.holds(found, &seen.basis);
            let budget = if self.effort.tolerance.is_none() { BUDGET / seen.each / seen.counts()[0] } else { f64::INFINITY };
            let time = seen.time_left((self.effort.until)());
            let drifts = fit.held && model.glints() && !strayed && !self.effort.quick;
            let spared = if drifts { PICTURES } else { 0.0 };
            // So many times as many samples as before may still be taken.
            let most = GROWTH.1.min(budget - 1.0).min((time - spared) / (1.0 + spared));
            let wanted = self.effort.more(self.parameters, found, seen.counts(), seen.each, seen.foreseen());
            let wanted = wanted.or_else(|| (round == 1 && seen.again()).then_some(More::Samples(2.0)));
            let go_on = !strayed && round < ROUNDS && !self.effort.quick && most >= GROWTH.0;
            let Some(more) = wanted.filter(|_| go_on && !(round > 1 && (self.enough)(found))) else {
                let share = drifts.then_some(time.min(PICTURES)).filter(|share| *share > LATE);
                return self.last(fit, strayed, traced, share, seeds);
            };
            best.clone_from(&found.values);
            model.tune(&best, Some(&found.errors()));
            seen.add(more, |times| (times - 1.0).max(GROWTH.0).min(most), &fit.influence, model);
        }
        unreachable!("a look has rounds")
    }

    /// What a look comes to that ends with a fit: moved by what was held back if it did not stray, by how far such a fit leads astray, if a `share` of
    /// the samples may be taken to see that, and by all that values may be where the pixels hardly tell them.
    fn last(&self, fit: Fit, strayed: bool, traced: Traced, share: Option<f64>, seeds: &mut Seeds) -> Looked {
        let Fit { found, withheld, .. } = fit;
        let moved = self.moved(found.clone(), withheld.filter(|_| !strayed), traced.model);
        let drift = share.map(|share| self.drift(traced, &moved.values, share, seeds));
        let moved = self.blurred(self.moved(moved, drift, traced.model), traced);
        let aside = aside(&found, &moved);
        if self.effort.quick || strayed && (self.another)() {
            return Looked { aside, held: !strayed, found: presuming(moved, traced) };
        }
        let averaged = self.averaged(moved, &aside, traced);
        let last = if averaged.values == found.values { averaged } else { self.again(averaged, traced) };
        Looked { aside, held: traced.model.holds(&last, traced.basis), found: presuming(last, traced) }
    }

    /// Takes the errors of a round for no smaller than a part of those taken before: few more samples make none so much surer but by chance, as where
    /// a pixel or two tell a value and follow it. One that was seen so small before, is.
    fn temper(&self, found: &mut Recovery, [taken, seen]: &[Vec<f64>; 2]) {
        for (i, parameter) in self.parameters.iter().enumerate() {
            let least = (SURER * taken[i].min(parameter.anywhere())).min(seen[i]).powi(2);
            if found.covariance.at(i, i) < least {
                // What more samples would make of it is not known either.
                found.own.set(i, i, least * found.own_part(i));
                found.covariance.set(i, i, least);
            }
        }
    }

    /// The values that explain the picture best, near some.
    pub fn fit(&self, traced: Traced, near: &[f64]) -> Fit {
        let Traced { sheet, model, basis } = traced;
        let Settled { scores: mut now, variances } = self.settled(traced, near);
        let values = now.here.values.clone();
        let wished: Vec<f64> =
            self.parameters.iter().zip(&values).enumerate().map(|(i, (p, value))| self.effort.near(i, p, *value)).collect();
        let (influence, clarity) = (influence(&now, &variances, &wished), now.clarity());
        // If a bound is not right that keeps one value from going on, all others are off too.
        let (pressed, beyond) = now.pressed(self.bounds).unwrap_or_else(|| (vec![false; values.len()], vec![0.0; values.len()]));
        now.covariance = Symmetric::of(values.len(), |i, j| now.covariance.at(i, j) + beyond[i] * beyond[j]);
        let losses = now.losses();
        let strays = now.strays(&losses);
        // What moved as far as the model can be trusted would have moved on.
        let ways: Vec<f64> = values.iter().zip(near).map(|(value, near)| value - near).collect();
        let ahead = model.trusted(&values.iter().zip(&ways).map(|(value, way)| value + way).collect::<Vec<_>>());
        for (i, way) in ways.iter().enumerate().filter(|(i, way)| **way != 0.0 && ahead[*i] == values[*i]) {
            now.covariance.set(i, i, now.covariance.at(i, i) + way * way);
        }
        // A box gives none of a pixel's noise to others.
        if let Some(variance) = self.evidence.film.filter.beyond() {
            now.covariance = now.spread(variance);
        }
        let misfit = Misfit::new(sheet, basis, &now.here.halves, model.glints());
        let common = now.common(&misfit);
        let (held, withheld) = (now.weights.kept.iter().any(|kept| *kept < 1.0), now.withheld());
        let (chi2, pixels) = (sheet.chi2(&now.here.halves), sheet.numbers.len());
        let found = Recovery {
            values,
            covariance: now.covariance,
            own: now.own,
            common,
            misfit,
            blur: None,
            chi2,
            pixels,
            losses,
            strays,
            saturated: vec![],
            clarity,
            pressed,
        };
        Fit { found, influence, held, withheld }
    }

    /// What was found, with how far the pixels are off, and how they are blurred, where its values were moved to since.
    fn again(&self, found: Recovery, traced: Traced) -> Recovery {
        let (sheet, halves) = (traced.sheet, traced.halves(&found.values));
        let again =
            Recovery { chi2: sheet.chi2(&halves), misfit: Misfit::new(sheet, traced.basis, &halves, traced.model.glints()), ..found };
        if self.evidence.blurred { again } else { self.blurred(again, traced) }
    }

    /// What was found, moved on if there is a way to go.
    pub fn moved(&self, mut found: Recovery, way: Option<Way>, model: &dyn Model) -> Recovery {
        let Some((way, covariance)) = way else { return found };
        let asked: Vec<f64> = found.values.iter().zip(&way).zip(self.bounds).map(|((v, w), b)| (v + w).clamp(b.0, b.1)).collect();
        found.values = model.trusted(&asked);
        found.covariance = Symmetric::of(way.len(), |i, j| found.covariance.at(i, j) + covariance.at(i, j));
        found
    }
}

/// What was found, with errors that hold what the basis presumed: there may be no time for another look.
fn presuming(mut found: Recovery, traced: Traced) -> Recovery {
    let off = traced.model.presumed(&found, traced.basis) / COMMON;
    if off > 0.0 {
        found.covariance = Symmetric::of(found.values.len(), |i, j| found.covariance.at(i, j) + off * off * found.common.at(i, j));
    }
    found
}

/// How far what was found was moved since.
fn aside(found: &Recovery, moved: &Recovery) -> Way {
    // What was not known before is not known better now.
    let more = |i, j| Some(moved.covariance.at(i, j) - found.covariance.at(i, j)).filter(|more| more.is_finite()).unwrap_or(0.0);
    let way: Vec<f64> = moved.values.iter().zip(&found.values).map(|(there, here)| there - here).collect();
    let covariance = Symmetric::of(way.len(), more);
    (way, covariance)
}

/// The least part of its standard error that a round may leave of the one before.
const SURER: f64 = 0.125;
