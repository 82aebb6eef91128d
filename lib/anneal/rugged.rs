//! Whether a function that repeats its values is smooth, or jumps from place to place, as a rendering does that draws the same random numbers again.
//!
//! Within a pit of what jumps it is smooth, and has a curvature, which says nothing of where its minimum is. Along a line what is smooth is foretold the
//! better the nearer the neighbours are that foretell it; what jumps is not, but within a pit.

use super::polish::Seen;
use super::random::Random;
use serde::{Deserialize, Serialize};

/// What is told along some lines from a low place.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Lines {
    /// The low place in the unit cube, and what was told there.
    start: (Vec<f64>, f64),
    /// How far its first place lies along each line.
    ways: Vec<Vec<f64>>,
    /// What was told, line by line: at each place half as far as at the one before.
    told: Vec<f64>,
}

/// Lines, places on each, and how far the first lies out, in parts of the unit cube.
const LINES: usize = 3;
const PLACES: usize = 10;
const FARTHEST: f64 = 0.3;
/// They pay where they are such a part of the evaluations that are left.
const PART: f64 = 0.2;
/// The parabola through the start and the next two places foretells the value at one: what it makes of the start, and of the nearer and the nearest.
const PARABOLA: [f64; 3] = [3.0, 6.0, -8.0];
/// What is off by more than these parts where it is foretold from half as far and from a quarter is not smooth: a third derivative leaves an eighth each
/// time. (The second alone, where those of higher orders cancel the third, took one of 20 smooth functions for a rugged one.)
const SMOOTH: [f64; 2] = [0.25, 0.05];
/// A start that is lower than this part of all values around it lies in no pit, but at the minimum.
const DEEP: f64 = 0.5;
/// Jumps by less than this part of the value at the start are none.
const LEAST: f64 = 1e-4;

/// Whether so many evaluations are enough to look for jumps first.
pub fn pays(left: usize) -> bool {
    (LINES * PLACES) as f64 <= PART * left as f64
}

impl Lines {
    /// Lines from there, each toward the farther side of the unit cube.
    pub fn from(start: &Seen, random: &mut Random) -> Self {
        let mut way = |s: &f64| FARTHEST * (1.0 - 0.7 * random.uniform()) * if *s > 0.5 { -1.0 } else { 1.0 };
        let ways = (0..LINES).map(|_| start.at.iter().map(&mut way).collect()).collect();
        Self { start: (start.at.clone(), start.value), ways, told: vec![] }
    }

    /// The next place to measure; `None` when all were.
    pub fn next(&self) -> Option<Vec<f64>> {
        let (line, place) = (self.told.len() / PLACES, self.told.len() % PLACES);
        let along = |(s, w): (&f64, &f64)| s + w * 0.5f64.powi(place as i32);
        self.ways.get(line).map(|way| self.start.0.iter().zip(way).map(along).collect())
    }

    /// Takes the value at that place.
    pub fn tell(&mut self, value: f64) {
        self.told.push(value);
    }

    /// By how much values jump: a standard deviation; 0 where they do not, and before all were told.
    pub fn jumps(&self) -> f64 {
        if self.told.len() < LINES * PLACES {
            return 0.0;
        }
        let (start, lines) = (self.start.1, || self.told.chunks_exact(PLACES));
        // By how much a value is off that is foretold, in terms of what values are off by that are independent of each other.
        let spread = 1.0 + PARABOLA.iter().map(|part| part * part).sum::<f64>();
        let off = |k: usize| {
            let square = |y: &[f64]| (y[k] - PARABOLA[0] * start - PARABOLA[1] * y[k + 1] - PARABOLA[2] * y[k + 2]).powi(2) / spread;
            // What is impossible says nothing.
            lines().map(square).filter(|square| square.is_finite()).sum::<f64>() / LINES as f64
        };
        let squares: Vec<f64> = (0..PLACES - 2).map(off).collect();
        let jump = |(k, three): (usize, &[f64])| {
            let lowest = lines().flat_map(|line| &line[k..k + 3]).copied().fold(f64::INFINITY, f64::min);
            let smooth = three[2] <= SMOOTH[0].powi(2) * three[1] || three[2] <= SMOOTH[1].powi(2) * three[0];
            if smooth || start <= DEEP * lowest { 0.0 } else { (three.iter().sum::<f64>() / 3.0).sqrt() }
        };
        let most = squares.windows(3).enumerate().map(jump).fold(0.0, f64::max);
        if most > LEAST * start.abs() { most } else { 0.0 }
    }

    /// Whether its parts are those of a search in that many variables.
    pub fn is_consistent(&self, variables: usize) -> bool {
        let vector = |x: &Vec<f64>| x.len() == variables && x.iter().all(|x| x.is_finite());
        vector(&self.start.0) && self.ways.len() == LINES && self.ways.iter().all(vector) && self.told.len() <= LINES * PLACES
    }
}
