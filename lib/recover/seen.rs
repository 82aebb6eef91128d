//! What a look has seen of the picture: which pixels come first, and what more of them, or of their samples, add.

use super::enough::More;
use super::look::{Look, Model};
use super::tile;
use crate::sampling::mix64;
use crate::transport::Basis;
use std::ops::Range;
use std::time::Instant;

/// What a first round looks at.
pub struct First {
    /// So many pixels.
    pub pixels: usize,
    /// So many samples of each in each half.
    pub samples: u32,
    /// Whether whole squares are taken, in which neighbours say how far a pixel is to be trusted, or the single pixels that tell most.
    pub squares: bool,
    /// Whether errors that satisfy are to be found so again: small errors of few samples may be small by chance.
    pub again: bool,
}

/// Where it cannot be foreseen which pixels tell most: samples in each half of the first round, and of each pixel in it at the most.
const FIRST: f64 = 80_000.0;
const EACH: f64 = 64.0;

/// Where it can: how many pixels are asked, and how many of those that tell most come before each other one, which may tell of what else is to be known.
const ASKED: usize = 10_000;
const TELLING: usize = 2;

/// Where there is only one round: samples in each half of it, and of each pixel at the least.
const QUICK: f64 = 20_000.0;
const QUICK_EACH: f64 = 32.0;

/// Where time is limited: the part of the pixels of the first round, or of their samples, that is always looked at, and that of the time left which
/// tracing may take.
const TRIED: f64 = 0.1;
const TRACED: f64 = 0.8;

/// Some of the pixels that count, and the samples of them.
pub struct Seen {
    /// All pixels that count, in the order in which they are looked at.
    pixels: Vec<usize>,
    /// How many of them are seen.
    count: f64,
    /// By so many samples of each in each half, on the average.
    pub each: f64,
    /// What comes first, if those that tell most were foreseen.
    foreseen: Option<First>,
    /// One for all rounds: what they add to a pixel fills it evenly with what it has.
    seed: u64,
    /// What they show.
    pub basis: Basis,
    /// When the first of them was looked at.
    begin: Instant,
}

impl Seen {
    /// The numbers of the pixels that are seen.
    pub fn pixels(&self) -> &[usize] {
        &self.pixels[..self.count as usize]
    }

    /// How many pixels are seen, and how many count.
    pub fn counts(&self) -> [f64; 2] {
        [self.count, self.pixels.len() as f64]
    }

    /// Whether those that tell most were foreseen.
    pub fn foreseen(&self) -> bool {
        self.foreseen.is_some()
    }

    /// Whether what a first round finds had better be found again.
    pub fn again(&self) -> bool {
        self.foreseen.as_ref().is_some_and(|first| first.again)
    }

    /// The time until then, in terms of the time that it took to see so much.
    pub fn time_left(&self, until: Option<Instant>) -> f64 {
        time_left(self.begin, until)
    }

    /// Looks at more: `growth` makes of how many times as much is wanted what is added, in terms of what there is. Samples go to pixels by their
    /// `influence`.
    pub fn add(&mut self, more: More, growth: impl Fn(f64) -> f64, influence: &[f64], model: &dyn Model) {
        match more {
            More::Pixels(times) => self.go_on((self.count * (1.0 + growth(times))).floor().min(self.counts()[1]), model),
            More::Samples(times) => {
                let mean = self.each * growth(times);
                self.each += mean;
                let samples = shared(mean, influence, &self.basis.samples);
                self.basis.join(&model.trace(self.pixels(), &samples, self.seed));
            }
        }
    }

    /// Looks at as many pixels as that.
    fn go_on(&mut self, count: f64, model: &dyn Model) {
        let next = &self.pixels[self.count as usize..count as usize];
        self.basis.append(model.trace_all(next, self.each as u32, self.seed));
        self.count = count;
    }
}

/// The time until then, in terms of the time since some other.
fn time_left(begin: Instant, until: Option<Instant>) -> f64 {
    let left = |until: Instant| until.saturating_duration_since(Instant::now()).as_secs_f64() / begin.elapsed().as_secs_f64();
    until.map_or(f64::INFINITY, left)
}

/// What so many samples of each of these pixels in each half show, or as many of those as a part of them tells that there is time for.
pub fn traced_in_time(model: &dyn Model, pixels: &[usize], samples: u32, until: Option<Instant>, seed: u64) -> Basis {
    let begin = Instant::now();
    let tried = if until.is_some() { (TRIED * f64::from(samples)).ceil() as u32 } else { samples };
    let mut basis = model.trace_all(pixels, tried, seed);
    let more = (TRACED * time_left(begin, until) * f64::from(tried)).min(f64::from(samples - tried)) as u32;
    if more > 0 {
        basis.join(&model.trace(pixels, &vec![tried..tried + more; 2 * pixels.len()], seed));
    }
    basis
}

impl Look<'_> {
    /// What is seen first.
    pub fn first(&self, model: &dyn Model, seed: u64) -> Seen {
        let (mut pixels, foreseen) = self.order(model);
        let begin = Instant::now();
        let all = pixels.len() as f64;
        let until = (self.effort.until)();
        if self.effort.quick {
            let each = (QUICK / all).clamp(QUICK_EACH, EACH) as u32;
            let basis = traced_in_time(model, &pixels, each, until, seed);
            return Seen { pixels, count: all, each: basis.samples[0].into(), foreseen, seed, basis, begin };
        }
        let (first, each) = match &foreseen {
            Some(first) => (first.pixels as f64, f64::from(first.samples)),
            None => {
                let first = (FIRST / model.least()).floor().min(all);
                (first, (FIRST / first).min(EACH).floor())
            }
        };
        // Where time is limited, some of the pixels tell how many of them there is time for.
        let count = if until.is_some() { (first * TRIED).ceil() } else { first };
        let basis = model.trace_all(&pixels[..count as usize], each as u32, seed);
        pixels.truncate((MOST_BYTES / (6.0 * 4.0 * basis.columns as f64)).max(count) as usize);
        let mut seen = Seen { pixels, count, each, foreseen, seed, basis, begin };
        if until.is_some() {
            let next = (count * (1.0 + TRACED * seen.time_left(until))).floor().min(first);
            seen.go_on(next, model);
        }
        seen
    }

    /// The pixels in the order in which they are looked at, and what of them comes first if those that tell most were foreseen.
    fn order(&self, model: &dyn Model) -> (Vec<usize>, Option<First>) {
        let width = self.evidence.film.width;
        if self.effort.quick {
            let all = self.pixels.len() <= GLANCED;
            return (if all { self.pixels.to_vec() } else { scattered(self.pixels, width)[..GLANCED].to_vec() }, None);
        }
        let pixels = scattered(self.pixels, width);
        let (asked, others) = pixels.split_at(pixels.len().min(ASKED));
        let first = model.first();
        let foreseen = (asked.len() > first.pixels && !self.effort.late()).then(|| model.telling(asked, mix64(self.effort.seed)));
        let Some(telling) = foreseen.flatten() else { return (pixels, None) };
        let places: Vec<&[usize]> = asked.chunk_by(|a, b| first.squares && tile(*a, width, SQUARE) == tile(*b, width, SQUARE)).collect();
        let mut telling = telling.into_iter();
        let means: Vec<f64> = places.iter().map(|place| telling.by_ref().take(place.len()).sum::<f64>() / place.len() as f64).collect();
        let mut falling: Vec<usize> = (0..places.len()).collect();
        falling.sort_by(|a, b| means[*b].total_cmp(&means[*a]));
        let (mut best, mut each) = (falling.into_iter(), 0..places.len());
        let mut taken = vec![false; places.len()];
        let next = |turn: usize| {
            let untaken = |i: &usize| !taken[*i];
            let i = if turn % (TELLING + 1) < TELLING { best.find(untaken) } else { each.find(untaken) }?;
            taken[i] = true;
            Some(places[i])
        };
        ((0..places.len()).filter_map(next).flatten().chain(others).copied().collect(), Some(first))
    }
}

/// The most samples of a pixel in each half of a round, whatever its share.
const MOST: f64 = 1024.0;

/// The part of the samples that all pixels share evenly: what few samples say of a pixel may be wrong.
const EVEN: f64 = 0.3;

/// The samples that come after those that the halves of pixels `have`, `mean` on the average, so that all are shared among pixels in proportion
/// to how much their errors disturb (Neyman 1934).
fn shared(mean: f64, influence: &[f64], have: &[f32]) -> Vec<Range<u32>> {
    let level = influence.iter().sum::<f64>() / influence.len() as f64;
    let share = |i: &f64| if level > 0.0 && level.is_finite() { EVEN + (1.0 - EVEN) * i / level } else { 1.0 };
    let shares: Vec<f64> = influence.iter().flat_map(|i| [share(i); 2]).collect();
    let add = |total: f64| shares.iter().zip(have).map(move |(share, have)| (total * share - *have as f64).clamp(0.0, MOST));
    // The mean number of all samples that leaves so many to add.
    let wanted = mean * have.len() as f64;
    let (mut low, mut high) = (0.0, wanted + have.iter().map(|n| *n as f64).sum::<f64>());
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if add(middle).sum::<f64>() > wanted { high = middle } else { low = middle }
    }
    let next = |(have, more): (&f32, f64)| *have as u32..*have as u32 + more as u32;
    have.iter().zip(add(low)).map(next).collect()
}

/// Pixels in an order in which each first part of them is spread over the picture, in squares that keep neighbours together.
pub fn scattered(pixels: &[usize], width: usize) -> Vec<usize> {
    let mut pixels = pixels.to_vec();
    pixels.sort_by_key(|n| mix64(tile(*n, width, SQUARE) as u64));
    pixels
}

/// No more pixels are seen, round by round, than a basis of this size holds.
const MOST_BYTES: f64 = 1e9;
/// And no more than these are glanced at, each time the same.
const GLANCED: usize = 20_000;

/// The side of a square, in pixels.
const SQUARE: usize = 4;
