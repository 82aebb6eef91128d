//! What is left of the picture that is not noise.
//!
//! Noise differs from pixel to pixel. What whole areas are off by, the model does not explain: the light, the shape or the type of the
//! material are not those of the photograph, and standard errors, which go by the noise, do not count it.

use super::sheet::{Channels, Half, Sheet, weight};
use std::collections::BTreeMap;

/// The side of an area, in pixels.
const AREA: usize = 8;
/// Areas with fewer pixels of a colour on the chessboard say nothing.
const LEAST: usize = 4;
/// What is left counts beyond so many standard errors of its square.
const SURE: f64 = 4.0;

/// One colour of the chessboard in an area and channel.
#[derive(Clone, Copy, Default)]
struct Field {
    pixels: usize,
    weight: f64,
    /// Weighted sums of what the model leaves, and of what it says.
    rest: f64,
    value: f64,
}

/// By how much of their light whole areas are off, on the average; 0 where noise may be all of it.
///
/// White and black fields of an area share no pixel, so no noise: the mean product of what is left of either is the square of what they
/// have in common, whatever the noise.
pub fn misfit(sheet: &Sheet, weights: &[Channels; 2], halves: &[Half]) -> f64 {
    let mut areas: BTreeMap<(usize, usize), [[Field; 2]; 3]> = BTreeMap::new();
    for (p, &number) in sheet.numbers.iter().enumerate() {
        let (x, y) = sheet.place(number);
        let area = areas.entry((x / AREA, y / AREA)).or_default();
        for (c, fields) in area.iter_mut().enumerate() {
            let (field, w, value) = (&mut fields[(x + y) % 2], weight(weights, p, c), 0.5 * (halves[0][p][c] + halves[1][p][c]));
            field.pixels += 1;
            field.weight += w;
            field.rest += w * (sheet.target[p][c] as f64 - value);
            field.value += w * value;
        }
    }
    let (mut common, mut squares, mut light) = (0.0, 0.0, 0.0);
    for [a, b] in areas.values().flatten().filter(|fields| fields.iter().all(|f| f.pixels >= LEAST && f.weight > 0.0)) {
        let counts = (a.weight + b.weight) / (a.weight * b.weight);
        common += counts * a.rest * b.rest;
        squares += (counts * a.rest * b.rest).powi(2);
        light += counts * a.value * b.value;
    }
    if common > SURE * squares.sqrt() && light > 0.0 { (common / light).sqrt() } else { 0.0 }
}
