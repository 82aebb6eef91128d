//! What is left of the picture that is not noise.
//!
//! Noise differs from pixel to pixel. What whole areas are off by, or neighbours together, the model does not explain: the light, the shape or the
//! type of the material are not those of the photograph, and standard errors, which go by the noise, do not count it.

use super::sheet::{COMMON, Half, Sheet, glints};
use crate::transport::Basis;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What is left of a picture that no noise is: parts of its light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Misfit {
    /// By which whole areas are off, on the average; 0 where noise may be all of it.
    pub areas: f64,
    /// By which neighbours are off together besides, on the average, as along the edges of what is not where it should be; 0 where noise may be all of it.
    pub neighbours: f64,
    /// Which single pixels lack, or hold beyond what the model says; 0 where those are few, or that is little.
    pub singles: f64,
    /// By which the light of the unknown may be off as what is around it is, or as its renderer left it; 0 where that is as it should be, or not looked at.
    pub around: f64,
}

impl Misfit {
    /// Of a model that throws much light into few pixels by chance only areas are looked at.
    pub fn new(sheet: &Sheet, basis: &Basis, halves: &[Half], chancy: bool) -> Self {
        // What is too dark by chance counts for more by its own noise: what one half leaves is weighed by how the other's samples differ.
        let weights = [1, 0].map(|other| by_noise(sheet, basis, other));
        let areas = areas(sheet, &weights, halves);
        Self {
            areas,
            // What areas are off by neighbours are too.
            neighbours: (neighbours(sheet, &weights, halves).powi(2) - areas * areas).max(0.0).sqrt(),
            around: 0.0,
            singles: if chancy { 0.0 } else { singles(&sheet.target, |p| sheet.brightest(p), halves) },
        }
    }

    /// Whether noise may be all that is left of the picture.
    pub fn is_noise(&self) -> bool {
        self.off() <= COMMON
    }

    /// By which part of its light the picture is off.
    pub fn off(&self) -> f64 {
        self.alike().max(self.neighbours)
    }

    /// By which all pixels may be off alike, as far as that moves values.
    pub fn alike(&self) -> f64 {
        self.areas.max(self.around).max(HARM * self.singles)
    }
}

/// Which single pixels hold too little light, they and those beside them, or too much: those of which both halves say so, by this factor; and how many
/// they are at the least, half of all at the most, and the part of all light that they lack, or hold beyond what the model says, at the least, where that
/// is no accident. Of 20 pictures with highlights that were recovered right, such pixels lacked less than 3 %, or held 4.3 % at the most; of 10 whose sun
/// few samples had found, they lacked 8 to 32 %, or held 4 to 74 %; of 18 recoveries from pictures of 64 ambient samples and 4 or 8 rough ones in a map with
/// lamps, 15 held 6.8 to 11.8 %.
const FACTOR: f64 = 3.0;
const SEVERAL: usize = 3;
const LACKING: f64 = 0.05;
const HELD: f64 = 0.06;
/// What such light does to values, in terms of an error of as much that all pixels have in common: in those pictures they were off by a fifth of that
/// on the average, and by three fifths at the most, but roughnesses.
const HARM: f64 = 1.0 / 3.0;

/// The part of all light that single pixels lack, or hold beyond what the model says. Where few samples seldom find a small bright light, most pixels lack
/// its light, and few hold it all: a model that is too smooth explains that best, but for its own highlights.
fn singles(target: &[[f32; 3]], brightest: impl Fn(usize) -> f64, halves: &[Half]) -> f64 {
    let (mut light, mut lacking, mut held) = (0.0, (0, 0.0), (0, 0.0));
    for (p, photographed) in target.iter().enumerate() {
        let photographed = photographed.iter().copied().map(f64::from).sum::<f64>();
        let [a, b]: [f64; 2] = [0, 1].map(|half| halves[half][p].iter().sum());
        let found = 0.5 * (a + b);
        light += found;
        if a.min(b) > FACTOR * photographed && a.min(b) > FACTOR * brightest(p) {
            lacking = (lacking.0 + 1, lacking.1 + found - photographed);
        } else if photographed > FACTOR * a.max(b) {
            held = (held.0 + 1, held.1 + photographed - found);
        }
    }
    let few = SEVERAL..=target.len() / 2;
    let part =
        |(count, sum): (usize, f64), least: f64| if few.contains(&count) && light > 0.0 && sum > least * light { sum / light } else { 0.0 };
    part(lacking, LACKING).max(part(held, HELD))
}

/// The side of an area, in pixels, at the least.
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
/// have in common, whatever the noise. Where a filter lets neighbours share theirs, the fields are columns so far apart that they do not.
fn areas(sheet: &Sheet, weights: &[Half; 2], halves: &[Half]) -> f64 {
    let spacing = sheet.spacing();
    // As many columns of one colour as of the other.
    let side = AREA.next_multiple_of(2 * spacing);
    let field = |x: usize, y: usize| match spacing {
        1 => Some((x + y) % 2),
        _ => x.is_multiple_of(spacing).then_some(x / spacing % 2),
    };
    let mut areas: BTreeMap<(usize, usize), [[[Field; 2]; 2]; 3]> = BTreeMap::new();
    for (p, &number) in sheet.numbers.iter().enumerate() {
        let (x, y) = sheet.place(number);
        let Some(colour) = field(x, y) else { continue };
        let area = areas.entry((x / side, y / side)).or_default();
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

/// By how much of their light neighbours are off together, on the average; 0 where noise may be all of it: what one half leaves of a pixel and the other
/// of the next shares no noise.
fn neighbours(sheet: &Sheet, weights: &[Half; 2], halves: &[Half]) -> f64 {
    let (mut common, mut squares, mut light) = (0.0, 0.0, 0.0);
    for (p, next) in (0..sheet.numbers.len()).flat_map(|p| sheet.next(p).map(move |next| (p, next))) {
        for c in 0..3 {
            let products = [[0, 1], [1, 0]].map(|[here, there]| {
                let weight = (weights[here][p][c] * weights[there][next][c]).sqrt();
                let (value, beside) = (halves[here][p][c], halves[there][next][c]);
                light += weight * value * beside;
                weight * (f64::from(sheet.target[p][c]) - value) * (f64::from(sheet.target[next][c]) - beside)
            });
            // Both hold the noise of the picture.
            let product = products[0] + products[1];
            common += product;
            squares += product * product;
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_that_single_pixels_lack_or_hold_is_told_where_it_is_no_accident() {
        // Of a hundred pixels, `count` are not as bright as 1 in the picture, or in the halves of what is found.
        let among = |beside: f32, count: usize, picture: f32, found: [f64; 2]| {
            let target: Vec<[f32; 3]> = (0..100).map(|p| [if p < count { picture } else { 1.0 }; 3]).collect();
            let halves = found.map(|found| (0..100).map(|p| [if p < count { found } else { 1.0 }; 3]).collect::<Half>());
            singles(&target, |p| f64::from(beside.max(target[p][0])) * 3.0, &halves)
        };
        let told = |count: usize, picture: f32, found: [f64; 2]| among(0.0, count, picture, found);
        assert_eq!(told(0, 1.0, [1.0; 2]), 0.0);
        // Highlights that are not there, and others that are there too.
        assert!((told(10, 1.0, [20.0; 2]) - 190.0 / 290.0).abs() < 1e-9);
        assert_eq!(told(10, 20.0, [20.0; 2]), 0.0);
        // Or beside them.
        assert_eq!(among(20.0, 10, 1.0, [20.0; 2]), 0.0);
        // Light that nothing explains.
        assert!((told(10, 20.0, [1.0; 2]) - 190.0 / 100.0).abs() < 1e-9);
        // Noise of the rendering, a few pixels, and a little light, are no more than that.
        for (count, picture, found) in [(10, 1.0, [20.0, 1.0]), (10, 20.0, [1.0, 20.0]), (2, 1.0, [20.0; 2]), (2, 20.0, [1.0; 2])] {
            assert_eq!(told(count, picture, found), 0.0);
        }
        assert_eq!(told(5, 2.9, [1.0; 2]), 0.0);
        // What most pixels are, single ones are not; nor is any part of nothing told.
        assert_eq!(told(60, 20.0, [1.0; 2]), 0.0);
        assert_eq!(singles(&[[1.0; 3]; 9], |_| 3.0, &[vec![[0.0; 3]; 9], vec![[0.0; 3]; 9]]), 0.0);
    }
}
