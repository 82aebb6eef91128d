//! Simulated annealing of a vector inside bounds: what to try next, given what came of what was tried.
//!
//! It knows no graphics. [`Annealer`] is a state machine: it proposes a vector, is told the chi-squared of it, and so on to
//! the end; whoever evaluates may be a function, a command or a person, and between two evaluations the whole state can be
//! written down (serde) and taken up again with the same proposals to follow.
//!
//! 1. Survey: the start and points spread evenly over the box. Their chi-squared values set the temperature.
//! 2. Walk: Metropolis chains from the best of them, cooling; the worst chains end on the way. Stages change
//!    the objective from coarse to fine; what was best under the old one is evaluated anew under the next. Sun and Wu (2002) accept a change only if
//!    it is an improvement: that is this at temperature 0.
//! 3. Polish: local quadratics through all that was measured near the best.
//!
//! Evaluations may be noisy. A value that repeats differently is averaged before it is believed, one that repeats is no better where values jump from
//! vector to vector, and the answer is the minimum of the quadratic, not the luckiest value.

mod check;
pub mod linear;
mod parameter;
mod past;
mod polish;
mod random;
mod rugged;
mod shares;
mod walk;

pub use check::is_possible;
pub use parameter::{Parameter, anywhere};

use crate::error::{Error, Result};
use polish::{Fit, Polish, Seen};
use random::Random;
use rugged::Lines;
use serde::{Deserialize, Serialize};
use shares::{stage_at, survey, walk_end, walk_progress};
use walk::Walk;

/// How to search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// Fixes every random choice.
    pub seed: u64,
    /// Evaluations in all.
    pub steps: usize,
    /// Parameters that move together, by index; the groups take turns. Empty: all move together.
    pub groups: Vec<Vec<usize>>,
    /// What part of the walk each stage gets, coarse first. Empty: one stage.
    pub stages: Vec<f64>,
    /// Whether to finish with local quadratics; standard errors come from them.
    pub polish: bool,
    /// End as soon as every standard error is below this.
    pub tolerance: Option<f64>,
    /// How many independent squares chi-squared is the sum of, if that is known: then standard errors hold the picture's own noise too.
    pub residuals: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 0, steps: 400, groups: vec![], stages: vec![], polish: true, tolerance: None, residuals: None }
    }
}

/// Why a search is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum End {
    /// Every standard error is below the tolerance.
    Tolerance,
    /// The minimum is known as exactly as its values are told apart.
    Converged,
    /// All evaluations are used up, but for those kept to measure the best again that were not needed.
    Budget,
}

/// What a proposal is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Phase {
    /// To see the whole box.
    Survey,
    /// A step of a chain.
    Walk,
    /// To see whether a good value was luck, or what it is in the next stage.
    Again,
    /// To learn where the minimum is.
    Polish,
}

/// The best vector so far.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// Its coordinates.
    pub values: Vec<f64>,
    /// The chi-squared told for it, or the mean of those told again.
    pub chi2: f64,
    /// How often it was evaluated.
    pub times: u32,
}

/// A search for the vector with the smallest chi-squared.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Annealer {
    parameters: Vec<Parameter>,
    options: Options,
    trials: Vec<Trial>,
    /// Evaluations so far.
    told: usize,
    stage: usize,
    walk: Option<Walk>,
    /// Whether the same vector gives the same value again; unknown before one was evaluated twice.
    exact: Option<bool>,
    /// Where it does, what tells before the polish whether it jumps.
    lines: Option<Lines>,
    polish: Option<Polish>,
    /// The trial of the quadratic's minimum.
    answer: Option<usize>,
    next: Option<Next>,
    end: Option<End>,
}

/// A vector and what was told of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Trial {
    values: Vec<f64>,
    /// What was told, or the mean of what was told again; `f64::MAX` for what is impossible.
    chi2: f64,
    times: u32,
    stage: usize,
}

/// What waits for its chi-squared.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Next {
    values: Vec<f64>,
    purpose: Purpose,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
enum Purpose {
    Survey,
    Step(walk::Step),
    /// The same trial once more.
    Again(usize),
    /// A trial of the stage before, by the means of this one.
    Carry(usize),
    /// A place on the [`Lines`].
    Line,
    Polish,
}

/// How many standard deviations lower than the quadratic's minimum a value must be to be believed instead; if it repeats, by which part of it.
const LUCK: (f64, f64) = (4.0, 0.5);
/// How often the lowest value of a walk must have been measured before it is believed.
const BELIEVED: u32 = 3;

impl Annealer {
    /// A search that has not begun. Fails if there is nothing to search for or a bound is not a number.
    pub fn new(parameters: Vec<Parameter>, mut options: Options) -> Result<Self> {
        let wrong = |p: &Parameter| Error::new(format!("{}: bounds {}:{} with start {} make no sense", p.name, p.low, p.high, p.start));
        let sound = |p: &Parameter| p.low < p.high && (p.low..=p.high).contains(&p.start) && p.range().is_finite();
        if let Some(p) = parameters.iter().find(|p| !sound(p)) {
            return Err(wrong(p));
        }
        let count = parameters.len();
        if count == 0 || options.steps == 0 {
            return Err(Error::new("a search needs a free parameter and at least one step"));
        }
        if options.groups.is_empty() {
            options.groups = vec![(0..count).collect()];
        }
        let mut members: Vec<usize> = options.groups.concat();
        members.sort_unstable();
        if members != (0..count).collect::<Vec<_>>() || options.groups.iter().any(Vec::is_empty) {
            return Err(Error::new("each free parameter must be in one group"));
        }
        if options.stages.is_empty() {
            options.stages = vec![1.0];
        }
        if options.stages.iter().any(|share| !(*share > 0.0 && share.is_finite())) {
            return Err(Error::new("each stage needs a part of the walk"));
        }
        let mut new = Self {
            parameters,
            options,
            trials: vec![],
            told: 0,
            stage: 0,
            walk: None,
            exact: None,
            lines: None,
            polish: None,
            answer: None,
            next: None,
            end: None,
        };
        new.plan(&mut new.random());
        Ok(new)
    }

    /// Drives the search to its end with a function that says the chi-squared of a vector under a stage's objective.
    pub fn drive(&mut self, mut chi2: impl FnMut(&[f64], usize) -> f64) {
        while let Some(values) = self.propose() {
            let told = chi2(values, self.stage());
            self.tell(told);
        }
    }

    /// The vector to evaluate next, the same until its chi-squared is told; `None` when the search is over. Its coordinates are
    /// decimal numbers of about seven digits, so that what is printed is what was evaluated.
    pub fn propose(&self) -> Option<&[f64]> {
        self.next.as_ref().map(|next| &next.values[..])
    }

    /// By the means of which stage the proposal is to be evaluated, from 0.
    pub fn stage(&self) -> usize {
        self.stage
    }

    /// What the proposal is for; `None` when the search is over.
    pub fn phase(&self) -> Option<Phase> {
        self.next.as_ref().map(|next| match next.purpose {
            Purpose::Survey => Phase::Survey,
            Purpose::Step(_) => Phase::Walk,
            Purpose::Again(_) | Purpose::Carry(_) => Phase::Again,
            Purpose::Line | Purpose::Polish => Phase::Polish,
        })
    }

    /// Takes the chi-squared of the proposal, which may be one that [is not possible](is_possible). Does nothing when the search is over.
    pub fn tell(&mut self, chi2: f64) {
        let Some(Next { values, purpose }) = self.next.take() else { return };
        let chi2 = if is_possible(chi2) { chi2 } else { f64::MAX };
        let mut random = self.random();
        self.told += 1;
        let index = self.trials.len();
        if let Purpose::Again(index) = purpose {
            self.tell_again(index, chi2);
        } else {
            let minimum = self.fit().is_some_and(|fit| self.values(&fit.minimum) == values);
            self.trials.push(Trial { values, chi2, times: 1, stage: self.stage });
            if minimum && matches!(purpose, Purpose::Polish) {
                self.answer = Some(index);
            }
        }
        if let (Purpose::Line, Some(lines)) = (&purpose, &mut self.lines) {
            lines.tell(chi2);
        }
        if let Some(walk) = &mut self.walk {
            match purpose {
                Purpose::Step(step) => {
                    let progress = walk_progress(self.told, &self.options, self.parameters.len());
                    walk.judge(&step, index, &self.trials, progress, &mut random);
                }
                Purpose::Carry(old) => walk.carried(old, index, &self.trials),
                _ => {}
            }
        }
        self.plan(&mut random);
    }

    /// The best vector so far; `None` before the first was told.
    pub fn best(&self) -> Option<Best> {
        let mut chosen = (0..=self.stage).rev().find_map(|stage| self.lowest(stage, 1))?;
        // At the end of a noisy walk the lowest of many values that were seen once is mostly luck.
        if self.end.is_some() && self.exact == Some(false) {
            chosen = self.lowest(self.stage, 2).unwrap_or(chosen);
        }
        // Prefer the quadratic's minimum to a value that is lower by no more than luck can make it.
        if let (Some(answer), Some(fit)) = (self.answer, self.fit()) {
            let (a, c) = (&self.trials[answer], &self.trials[chosen]);
            let luck = LUCK.0 * fit.scatter * (1.0 / a.weight() + 1.0 / c.weight()).sqrt();
            let luck = if self.exact == Some(true) { luck.min(LUCK.1 * c.chi2.abs()) } else { luck };
            if c.chi2 > a.chi2 - luck || self.jumps() > 0.0 {
                chosen = answer;
            }
        }
        let Trial { values, chi2, times, .. } = self.trials[chosen].clone();
        Some(Best { values, chi2, times })
    }

    /// The standard error of each parameter, `f64::INFINITY` for one that nothing determines; `None` before the polish knows them.
    ///
    /// They hold what the scatter of the evaluations about the quadratic leaves open and, where [`Options::residuals`] says of how many
    /// squares chi-squared consists, what the picture's own noise does: covariance 2 s² H⁻¹ with s² = χ²/ν and H the second derivatives
    /// of χ² (Press et al. 2007, section 15.6).
    pub fn standard_errors(&self) -> Option<Vec<f64>> {
        let fit = self.fit()?;
        let own = self.options.residuals.map_or(0.0, |count| 2.0 * fit.value.max(0.0) / (count - self.parameters.len() as f64).max(1.0));
        let inverse = fit.hessian.inverse();
        let errors = self.parameters.iter().enumerate().map(|(i, p)| {
            let curvature = inverse.as_ref().map_or(f64::INFINITY, |m| m.at(i, i));
            let unit = if own > 0.0 { (fit.errors[i].powi(2) + own * curvature).sqrt() } else { fit.errors[i] };
            Some(unit * p.range()).filter(|&error| error < p.anywhere()).unwrap_or(f64::INFINITY)
        });
        Some(errors.collect())
    }

    /// Why the search is over; `None` while it is not.
    pub fn end(&self) -> Option<End> {
        self.end
    }

    /// Evaluations so far.
    pub fn told(&self) -> usize {
        self.told
    }

    /// What is searched for.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// How the search is done, as it is now: with groups and stages filled in.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Changes the number of evaluations, for a budget of time or to go on where the old budget ended. What was done stays done: the cooling
    /// goes on from the same fraction of the new number.
    pub fn set_steps(&mut self, steps: usize) {
        self.options.steps = steps.max(1);
        let more = self.end == Some(End::Budget) && steps > self.told;
        let less = self.end.is_none() && steps <= self.told;
        if more || less {
            self.end = None;
            self.next = None;
            self.plan(&mut self.random());
        }
    }

    /// Takes a repeated value into the trial's mean.
    fn tell_again(&mut self, index: usize, chi2: f64) {
        let trial = &mut self.trials[index];
        self.exact = Some(self.exact != Some(false) && trial.chi2 == chi2);
        // The first value is why the trial was chosen, so it is too low in the mean: only the others count.
        let (count, possible) = (f64::from(trial.times - 1), chi2 < f64::MAX && trial.chi2 < f64::MAX);
        trial.chi2 = if possible { (trial.chi2 * count + chi2) / (count + 1.0) } else { f64::MAX };
        trial.times += 1;
    }

    /// Decides what to evaluate next, or that the search is over.
    fn plan(&mut self, random: &mut Random) {
        if self.told >= self.options.steps {
            self.end = Some(End::Budget);
            return;
        }
        if self.walk.is_none() && self.told < survey(&self.options, self.parameters.len()) {
            self.next = Some(Next { values: self.spread(), purpose: Purpose::Survey });
            return;
        }
        let mut walk = self.walk.take().unwrap_or_else(|| {
            let chains = walk_end(&self.options, self.parameters.len()) / walk::CHAIN;
            Walk::start(chains, &self.trials, &self.parameters)
        });
        self.next = self.choose(&mut walk, random);
        self.walk = Some(walk);
    }

    /// The next evaluation after the survey; `None` when the search is over.
    fn choose(&mut self, walk: &mut Walk, random: &mut Random) -> Option<Next> {
        let progress = walk_progress(self.told, &self.options, self.parameters.len());
        let walking = progress < 1.0 && self.lines.is_none() && self.polish.is_none();
        // Carry what is best over to the next stage.
        let stage = if walking { stage_at(&self.options.stages, progress) } else { self.options.stages.len() - 1 };
        if stage > self.stage && walk.to_carry().is_none() {
            walk.carry(&self.trials, self.stage);
            self.stage = stage;
        }
        if let Some(old) = walk.to_carry() {
            return Some(Next { values: self.trials[old].values.clone(), purpose: Purpose::Carry(old) });
        }
        // Believe no low value at once, unless values repeat exactly.
        let repeats = self.exact == Some(true);
        if walking {
            walk.limit(progress, &self.trials);
            if let Some(trial) = walk.doubtful(&self.trials).filter(|_| !repeats) {
                return Some(self.again(trial));
            }
            let (unit, step) = walk.step(&self.trials, &self.parameters, &self.options.groups, progress, random);
            return Some(Next { values: self.values(&unit), purpose: Purpose::Step(step) });
        }
        // The last evaluation is the answer's own.
        let spared = repeats || self.is_last() && self.fit().is_some();
        if let Some(trial) = self.lowest(self.stage, 1).filter(|&trial| !spared && self.trials[trial].times < BELIEVED) {
            return Some(self.again(trial));
        }
        if self.options.polish {
            return self.refine(random);
        }
        self.end = Some(End::Budget);
        None
    }

    /// The next point of the polish, or the end of it.
    fn refine(&mut self, random: &mut Random) -> Option<Next> {
        let seen: Vec<Seen> = (self.trials.iter())
            .filter(|t| t.stage == self.stage && t.chi2 < f64::MAX)
            .map(|t| Seen { at: self.unit(&t.values), value: t.chi2, weight: t.weight() })
            .collect();
        if self.lines.is_none() && self.exact == Some(true) && self.polish.is_none() && rugged::pays(self.options.steps - self.told) {
            self.lines = seen.iter().min_by(|a, b| a.value.total_cmp(&b.value)).map(|start| Lines::from(start, random));
        }
        if let Some(point) = self.lines.as_ref().and_then(Lines::next) {
            return Some(Next { values: self.values(&point), purpose: Purpose::Line });
        }
        let measured = self.answer.is_some_and(|answer| answer + 1 == self.trials.len());
        // Where values repeat, a minimum that is none when it is measured shows the quadratic to be wrong: begin anew about the lowest.
        let wrong = |(a, c): (usize, usize)| self.trials[a].chi2 - self.trials[c].chi2 > LUCK.1 * self.trials[c].chi2.abs();
        let astray = measured && self.exact == Some(true) && self.answer.zip(self.lowest(self.stage, 1)).is_some_and(wrong);
        let jumps = self.jumps();
        let mut polish = self.polish.take().filter(|_| !astray).unwrap_or_else(|| Polish::about(&seen, self.parameters.len(), jumps));
        let (next, minimum) = (polish.next(&seen, jumps, random), polish.minimum());
        self.polish = Some(polish);
        let tight = self.options.tolerance.is_some_and(|t| self.standard_errors().is_some_and(|errors| errors.iter().all(|&e| e < t)));
        if next.is_none() || (tight && measured) {
            self.end = Some(if tight { End::Tolerance } else { End::Converged });
            return None;
        }
        // The answer is to be measured itself: before the tolerance ends the search, and with the last evaluation.
        let unit = if tight || self.is_last() { minimum.or(next) } else { next };
        unit.map(|unit| Next { values: self.values(&unit), purpose: Purpose::Polish })
    }

    /// The start, then points of Roberts's R sequence (2018), whose steps are powers of the root of xⁿ⁺¹ = x + 1.
    fn spread(&self) -> Vec<f64> {
        if self.told == 0 {
            return self.parameters.iter().map(|p| p.start).collect();
        }
        let count = self.parameters.len() as i32;
        let root = (0..64).fold(2.0f64, |x, _| (1.0 + x).powf(1.0 / f64::from(count + 1)));
        // The same shift for all points of a search.
        let mut shift = Random::new(self.options.seed, 0);
        let unit: Vec<f64> = (1..=count).map(|i| (shift.uniform() + self.told as f64 * root.powi(-i)).fract()).collect();
        self.values(&unit)
    }

    fn again(&self, trial: usize) -> Next {
        Next { values: self.trials[trial].values.clone(), purpose: Purpose::Again(trial) }
    }

    /// The trial with the smallest value among those of the stage that were measured so often.
    fn lowest(&self, stage: usize, times: u32) -> Option<usize> {
        (0..self.trials.len())
            .filter(|&i| self.trials[i].stage == stage && self.trials[i].times >= times)
            .min_by(|&a, &b| self.trials[a].chi2.total_cmp(&self.trials[b].chi2))
    }

    /// Whether no more than one evaluation is left.
    fn is_last(&self) -> bool {
        self.told + 1 >= self.options.steps
    }

    fn fit(&self) -> Option<&Fit> {
        self.polish.as_ref()?.fit.as_ref()
    }

    /// The vector of a point of the unit cube.
    fn values(&self, unit: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(unit).map(|(p, u)| p.value(*u)).collect()
    }

    /// The point of the unit cube of a vector.
    fn unit(&self, values: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(values).map(|(p, x)| p.unit(*x)).collect()
    }

    /// The random numbers of this evaluation, so that no generator has to be kept.
    fn random(&self) -> Random {
        Random::new(self.options.seed, 1 + self.told as u64)
    }
}

impl Trial {
    /// How many values its chi-squared is the mean of.
    fn weight(&self) -> f64 {
        f64::from((self.times - 1).max(1))
    }
}

#[cfg(test)]
mod tests;
