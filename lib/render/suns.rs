//! Where in a picture the sun is, and other small sources: a pixel that shows one is looked at there too.
//!
//! A sun covers a hundredth of a pixel of a fisheye, and is as bright as all the others together. So half of the samples of such a pixel are of
//! the part of it that may show the sun, and each counts by the density of both (the balance heuristic: Veach 1997, equation 9.8).

use super::{Lens, Task};
use crate::vector::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// A part of a pixel: its least and greatest numbers, as a lens takes them.
#[derive(Clone, Copy)]
struct Part([[f64; 2]; 2]);

/// The pixels that a small source is seen in, and where in them.
#[derive(Default)]
pub(super) struct Suns(HashMap<usize, Part>);

/// The greatest angle from the middle of a source to its rim, radians: chance finds larger ones.
const WIDEST: f64 = 0.05;
/// The largest part of a pixel that is worth while.
const LARGEST: f64 = 0.5;
/// Samples of a pixel that shows one, where the budget does not say how many: the sun is then known to 1 %.
pub(super) const SUN: u32 = 1024;
/// Cells of a part in each direction, by which it is made smaller, how often, and to which part of itself as long as that goes on.
const CELLS: usize = 16;
const ROUNDS: usize = 6;
const WORTH: f64 = 0.9;
/// How many times as far as a corner seems to be from the middle what is between them may be.
const SLACK: f64 = 1.2;

impl Suns {
    /// Those of a picture.
    pub fn of(task: &Task) -> Self {
        let suns: Vec<(Vec3, f64)> = task.world.sources().filter(|(_, half)| *half < WIDEST).collect();
        if suns.is_empty() || task.centred || task.blur.is_some() || !task.rules.lights_visible {
            return Self::default();
        }
        let part = |number: usize| {
            let parts = suns.iter().filter_map(|sun| Part::of(task.lens, number, sun));
            Some((number, parts.reduce(Part::join)?))
        };
        Self((0..task.count).into_par_iter().filter_map(part).collect())
    }

    /// Whether a pixel shows one.
    pub fn shows(&self, number: usize) -> bool {
        self.0.contains_key(&number)
    }

    /// A place in a pixel for two uniform numbers, and how much it counts.
    pub fn place(&self, number: usize, [u, v]: [f64; 2]) -> ([f64; 2], f64) {
        let part = self.0.get(&number).filter(|part| part.area() < LARGEST);
        let Some(part @ Part([low, high])) = part else { return ([u, v], 1.0) };
        let at = match u < 0.5 {
            true => [2.0 * u, v],
            false => [low[0] + (2.0 * u - 1.0) * (high[0] - low[0]), low[1] + v * (high[1] - low[1])],
        };
        let inside = (0..2).all(|i| at[i] >= low[i] && at[i] < high[i]);
        (at, 2.0 / (1.0 + if inside { 1.0 / part.area() } else { 0.0 }))
    }
}

impl Part {
    /// The part of a pixel that may show a sun, given by its direction and the angle from there to its rim; `None` also of a pixel that shows
    /// nothing else.
    fn of(lens: Lens, number: usize, &(sun, half): &(Vec3, f64)) -> Option<Self> {
        let apart = |a: [f64; 2], to: Vec3| lens(number, a).map(|(_, direction, _)| (direction - to).length());
        // Most pixels are far from any sun.
        if apart([0.5; 2], sun)? > half + 2.0 * SLACK * apart([0.01; 2], lens(number, [0.99; 2])?.1)? {
            return None;
        }
        let corners = [[0.01, 0.01], [0.01, 0.99], [0.99, 0.01], [0.99, 0.99]];
        if corners.iter().all(|&at| apart(at, sun).is_some_and(|apart| apart < half)) {
            return None;
        }
        let mut part = Self([[0.0; 2], [1.0; 2]]);
        for _ in 0..ROUNDS {
            let Self([low, high]) = part;
            let size = [0, 1].map(|i| (high[i] - low[i]) / CELLS as f64);
            let corner = |cell: [f64; 2]| [low[0] + cell[0] * size[0], low[1] + cell[1] * size[1]];
            let shows = |cell: [usize; 2]| {
                let cell = cell.map(|c| c as f64);
                let middle = lens(number, corner(cell.map(|c| c + 0.5)))?.1;
                let reach = apart(corner(cell.map(|c| c + 0.01)), middle)?.max(apart(corner(cell.map(|c| c + 0.99)), middle)?);
                ((middle - sun).length() <= half + SLACK * reach).then(|| Self([corner(cell), corner(cell.map(|c| c + 1.0))]))
            };
            let smaller = (0..CELLS * CELLS).filter_map(|i| shows([i % CELLS, i / CELLS])).reduce(Self::join)?;
            let worth = smaller.area() < WORTH * part.area();
            part = smaller;
            if !worth {
                break;
            }
        }
        Some(part)
    }

    fn area(&self) -> f64 {
        let Self([low, high]) = self;
        (high[0] - low[0]) * (high[1] - low[1])
    }

    fn join(self, other: Self) -> Self {
        let (Self([a, b]), Self([c, d])) = (self, other);
        Self([[0, 1].map(|i| a[i].min(c[i])), [0, 1].map(|i| b[i].max(d[i]))])
    }
}
