//! Metropolis chains that cool together, the worst of them ending on the way.

use super::random::Random;
use super::{Parameter, Trial};
use serde::{Deserialize, Serialize};

/// Chains that take turns.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Walk {
    chains: Vec<Chain>,
    /// How many there were at first.
    begun: usize,
    turn: usize,
    /// The temperature at the beginning, in units of chi-squared.
    temperature: f64,
    /// Trials of the stage before that wait to be evaluated in this one, and those that were: old and new.
    waiting: Vec<usize>,
    carried: Vec<(usize, usize)>,
}

/// One chain. Trials are known by their index.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Chain {
    now: usize,
    best: usize,
    /// Proposals refused since the last that was accepted.
    refused: u32,
    turn: usize,
    /// Step size of each parameter, in parts of its range.
    sizes: Vec<f64>,
}

/// A proposal of a chain.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Step {
    chain: usize,
    /// The squared moves, in step sizes; all zero for a jump.
    moves: Vec<f64>,
}

/// One chain for so many evaluations, and so many chains at most.
pub const CHAIN: usize = 60;
const MOST: usize = 8;
/// The first temperature in parts of the survey's middle value above its best, and by what power of ten it falls.
const TEMPERATURE: (f64, f64) = (0.15, 4.0);
/// When the last chain but one has ended.
const LAST: f64 = 0.7;
/// The chance of a jump at the beginning; it falls to 0.
const JUMP: f64 = 0.15;
/// The chance that a single parameter of the group moves.
const ALONE: f64 = 0.4;
/// Step sizes grow and shrink toward this rate of acceptance, this fast; none is below the smallest.
const ACCEPTANCE: f64 = 0.25;
const ADAPTATION: f64 = 0.5;
const SMALLEST: f64 = 1e-4;
/// After so many refusals in a row the value that refuses them is measured again, so often in all.
const REFUSALS: u32 = 12;
const REPEATS: u32 = 4;

impl Walk {
    /// About `count` chains from the best trials that are far from each other.
    pub fn start(count: usize, trials: &[Trial], parameters: &[Parameter]) -> Self {
        let unit = |i: usize| parameters.iter().zip(&trials[i].values).map(|(p, x)| p.unit(*x)).collect::<Vec<_>>();
        let mut order: Vec<usize> = (0..trials.len()).collect();
        order.sort_by(|&a, &b| trials[a].chi2.total_cmp(&trials[b].chi2));
        let count = count.clamp(1, MOST).min(trials.len());
        let mut chosen: Vec<usize> = vec![order[0]];
        let mut distance = 0.5;
        while chosen.len() < count && distance > 1e-3 {
            for &i in &order {
                let here = unit(i);
                let apart = |&j: &usize| here.iter().zip(unit(j)).map(|(a, b)| (a - b).powi(2)).sum::<f64>() > distance * distance;
                if chosen.len() < count && chosen.iter().all(apart) {
                    chosen.push(i);
                }
            }
            distance *= 0.5;
        }
        // The middle value above the best; a part of the best where there is no other.
        let possible: Vec<f64> = order.iter().map(|&i| trials[i].chi2).filter(|&x| x < f64::MAX).collect();
        let rise = possible.get(possible.len() / 2).map_or(0.0, |middle| middle - possible[0]);
        let rise = if rise > 0.0 { rise } else { possible.first().map_or(1.0, |x| x.abs().max(f64::MIN_POSITIVE)) };
        let chain = |i| Chain { now: i, best: i, refused: 0, turn: 0, sizes: vec![0.2; parameters.len()] };
        let chains: Vec<Chain> = chosen.into_iter().map(chain).collect();
        Self { begun: chains.len(), chains, turn: 0, temperature: TEMPERATURE.0 * rise, waiting: vec![], carried: vec![] }
    }

    /// Whether its parts are those of a walk with that many parameters and trials.
    pub fn is_consistent(&self, parameters: usize, trials: usize) -> bool {
        let chain = |chain: &Chain| {
            let sizes = chain.sizes.len() == parameters && chain.sizes.iter().all(|size| *size > 0.0 && *size <= 1.0);
            chain.now < trials && chain.best < trials && sizes
        };
        let known = |trial: &usize| *trial < trials;
        self.temperature.is_finite()
            && !self.chains.is_empty()
            && self.chains.iter().all(chain)
            && self.waiting.iter().all(known)
            && self.carried.iter().all(|(old, new)| known(old) && known(new))
    }

    /// Whether the step is one of this walk's.
    pub fn has(&self, step: &Step, parameters: usize) -> bool {
        step.chain < self.chains.len() && step.moves.len() == parameters
    }

    /// Ends the worst chains, so that one is left when the walk is done to a good part.
    pub fn limit(&mut self, progress: f64, trials: &[Trial]) {
        let left = ((self.begun as f64 * (1.0 - progress / LAST)).ceil() as usize).max(1);
        while self.chains.len() > left {
            let value = |i: usize| trials[self.chains[i].best].chi2;
            let worst = (0..self.chains.len()).max_by(|&a, &b| value(a).total_cmp(&value(b)));
            if let Some(worst) = worst {
                self.chains.remove(worst);
            }
        }
    }

    /// The trial of the chain whose turn it is, if it refuses so much that it may stand on a lucky value.
    pub fn doubtful(&mut self, trials: &[Trial]) -> Option<usize> {
        let next = self.turn % self.chains.len();
        let chain = &mut self.chains[next];
        if chain.refused < REFUSALS || trials[chain.now].times >= REPEATS {
            return None;
        }
        chain.refused = 0;
        Some(chain.now)
    }

    /// A proposal, in the unit cube, of the chain whose turn it is, for the group whose turn it is in that chain.
    pub fn step(
        &mut self,
        trials: &[Trial],
        parameters: &[Parameter],
        groups: &[Vec<usize>],
        progress: f64,
        random: &mut Random,
    ) -> (Vec<f64>, Step) {
        let index = self.turn % self.chains.len();
        self.turn += 1;
        let chain = &mut self.chains[index];
        let group = &groups[chain.turn % groups.len()];
        chain.turn += 1;
        let mut unit: Vec<f64> = parameters.iter().zip(&trials[chain.now].values).map(|(p, x)| p.unit(*x)).collect();
        let mut moves = vec![0.0; unit.len()];
        let one = group[random.below(group.len())];
        if random.uniform() < JUMP * (1.0 - progress) {
            unit[one] = random.uniform();
        } else {
            let alone = random.uniform() < ALONE;
            // Steps of all sizes over a power of ten.
            let size = 1.5 * 10f64.powf(-random.uniform());
            for &i in group.iter().filter(|&&i| !alone || i == one) {
                let x = random.normal();
                moves[i] = x * x;
                unit[i] = reflect(unit[i] + x * chain.sizes[i] * size);
            }
        }
        (unit, Step { chain: index, moves })
    }

    /// Accepts or refuses the step's trial (Metropolis et al. 1953), and adapts the sizes of what moved.
    pub fn judge(&mut self, step: &Step, trial: usize, trials: &[Trial], progress: f64, random: &mut Random) {
        let temperature = self.temperature * 10f64.powf(-TEMPERATURE.1 * progress);
        let chain = &mut self.chains[step.chain];
        let rise = trials[trial].chi2 - trials[chain.now].chi2;
        let accepted = rise <= 0.0 || random.uniform() < (-rise / temperature).exp();
        // A parameter that moved much has much to do with the outcome. Large steps are for the beginning.
        let largest = 0.4 * (1.0 - progress) + 0.02;
        let total: f64 = step.moves.iter().sum();
        for (size, moved) in chain.sizes.iter_mut().zip(&step.moves).filter(|_| total > 0.0) {
            let gain = ADAPTATION * (f64::from(u8::from(accepted)) - ACCEPTANCE) * moved / total;
            *size = (*size * gain.exp()).clamp(SMALLEST, largest);
        }
        if accepted {
            chain.now = trial;
            chain.refused = 0;
        } else {
            chain.refused += 1;
        }
        if trials[trial].chi2 < trials[chain.best].chi2 {
            chain.best = trial;
        }
    }

    /// Puts the best of each chain, and of all, in line for the next stage.
    pub fn carry(&mut self, trials: &[Trial], stage: usize) {
        let best = (0..trials.len()).filter(|&i| trials[i].stage == stage).min_by(|&a, &b| trials[a].chi2.total_cmp(&trials[b].chi2));
        self.waiting = self.chains.iter().map(|chain| chain.best).chain(best).collect();
        self.waiting.sort_unstable();
        self.waiting.dedup();
    }

    /// The trial to carry over next; `None` when all are.
    pub fn to_carry(&self) -> Option<usize> {
        self.waiting.last().copied()
    }

    /// Takes note that trial `old` became trial `new`; with the last of them the chains go over, and the temperature with the values.
    pub fn carried(&mut self, old: usize, new: usize, trials: &[Trial]) {
        self.waiting.retain(|&i| i != old);
        self.carried.push((old, new));
        if !self.waiting.is_empty() {
            return;
        }
        let pairs = std::mem::take(&mut self.carried);
        let possible = |p: &&(usize, usize)| trials[p.0].chi2 < f64::MAX && trials[p.1].chi2 < f64::MAX;
        let sum = |pick: fn(&(usize, usize)) -> usize| pairs.iter().filter(possible).map(|p| trials[pick(p)].chi2.abs()).sum::<f64>();
        let ratio = sum(|p| p.1) / sum(|p| p.0);
        if ratio.is_finite() && ratio > 0.0 {
            self.temperature *= ratio;
        }
        for chain in &mut self.chains {
            let to = pairs.iter().find(|p| p.0 == chain.best).map_or(chain.best, |p| p.1);
            *chain = Chain { now: to, best: to, refused: 0, turn: chain.turn, sizes: std::mem::take(&mut chain.sizes) };
        }
    }
}

/// A coordinate folded back into 0 … 1.
fn reflect(x: f64) -> f64 {
    let x = x.rem_euclid(2.0);
    if x > 1.0 { 2.0 - x } else { x }
}
