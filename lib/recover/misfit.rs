//! What is left of the picture that is not noise.
//!
//! Noise differs from pixel to pixel. What whole areas are off by, the model does not explain: the light, the shape or the type of the
//! material are not those of the photograph, and standard errors, which go by the noise, do not count it.

use super::sheet::{COMMON, Half, Sheet, glints};
use crate::transport::Basis;
use std::collections::BTreeMap;

/// The side of an area, in pixels.
const AREA: usize = 8;
/// Areas with fewer pixels of a colour on the chessboard say nothing.
const LEAST: usize = 4;
/// What is left counts beyond so many standard errors of its square.
const SURE: f64 = 4.0;

/// One colour of the chessboard in an area and channel, as one half has it.
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
/// have in common, whatever the noise. Where a filter lets neighbours share theirs, the fields are columns so far apart that they do not. But both may
/// have been weighed by the same noise, by which what is too dark by chance counts for more: what one half of the samples leaves is weighed by how the
/// other's differ.
pub fn misfit(sheet: &Sheet, basis: &Basis, halves: &[Half]) -> f64 {
    let weights = [1, 0].map(|other| by_noise(sheet, basis, other));
    let spacing = sheet.spacing();
    let field = |x: usize, y: usize| match spacing {
        1 => Some((x + y) % 2),
        _ => x.is_multiple_of(spacing).then_some(x / spacing % 2),
    };
    let mut areas: BTreeMap<(usize, usize), [[[Field; 2]; 2]; 3]> = BTreeMap::new();
    for (p, &number) in sheet.numbers.iter().enumerate() {
        let (x, y) = sheet.place(number);
        let Some(colour) = field(x, y) else { continue };
        let area = areas.entry((x / AREA, y / AREA)).or_default();
        for (c, each) in area.iter_mut().enumerate() {
            for (half, fields) in each.iter_mut().enumerate() {
                let (field, w, value) = (&mut fields[colour], weights[half][p][c], halves[half][p][c]);
                field.pixels += 1;
                field.weight += w;
                field.rest += w * (sheet.target[p][c] as f64 - value);
                field.value += w * value;
            }
        }
    }
    // The standard error of the product of two fields' means, by how these differ.
    let error = |[a, b]: &[Field; 2]| {
        let (weight, a, b) = (a.weight + b.weight, a.rest / a.weight, b.rest / b.weight);
        let (middle, noise) = (0.5 * (a + b), 0.5 * (a - b) * (a - b));
        weight * (2.0 * middle * middle * noise + noise * noise).sqrt()
    };
    let (mut common, mut squares, mut light) = (0.0, 0.0, 0.0);
    let says = |fields: &[Field; 2]| fields.iter().all(|f| f.pixels >= LEAST && f.weight > 0.0);
    for each in areas.values().flatten().filter(|each| each.iter().all(says)) {
        let sum = |of: &dyn Fn(&Field) -> f64| -> f64 {
            each.iter().map(|[a, b]| (a.weight + b.weight) / (a.weight * b.weight) * of(a) * of(b)).sum()
        };
        common += sum(&|field| field.rest);
        // Both halves share the noise of the picture.
        squares += each.iter().map(error).sum::<f64>().powi(2);
        light += sum(&|field| field.value);
    }
    if common > SURE * squares.sqrt() && light > 0.0 { (common / light).sqrt() } else { 0.0 }
}

/// Weights that go by the noise of one half, in each pixel and those beside it, and by what the target's file may round all pixels of an area by;
/// none where one half alone has caught a glint, as it may have in pixels of both colours.
fn by_noise(sheet: &Sheet, basis: &Basis, half: usize) -> Vec<[f64; 3]> {
    let glint = |p: usize| {
        let both = [0, 1].map(|half| basis.variances[2 * p + half].iter().copied().map(f64::from).sum());
        both.iter().all(|variance| *variance > 0.0) && glints(both)
    };
    let noise = |p: usize| {
        let (variances, samples) = (basis.variances[2 * p + half], basis.samples[2 * p + half] as f64);
        std::array::from_fn(|c| variances[c] as f64 / samples + sheet.step(p, c).powi(2))
    };
    let noise: Vec<[f64; 3]> = (0..sheet.numbers.len()).map(noise).collect();
    let blurred = sheet.blurred(&noise, 1);
    let weigh = |p: usize| {
        std::array::from_fn(|c| {
            let relative = if glint(p) { 0.0 } else { f64::from(sheet.relative[p][c]) };
            relative / (COMMON * COMMON + relative * blurred[p][c])
        })
    };
    (0..sheet.numbers.len()).map(weigh).collect()
}
