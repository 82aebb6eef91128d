//! An environment as tables know it: its radiance by direction, and what all of it does to a diffuse surface that nothing hides it from.
//!
//! The second is the integral of the first, so that what is taken for granted with one and left to chance with the other agrees on the average.

use crate::color::Rgb;
use crate::vector::Vec3;
use crate::vector::angle::polar;
use rayon::prelude::*;
use std::f64::consts::PI;
use wide::f32x8;

/// Where a direction of travel lies in a panorama.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The part of a turn about +z from +x, in [0, 1).
    pub turn: f64,
    /// The part of the way from +z down to −z, in [0, 1].
    pub way: f64,
}

impl Place {
    /// The place of a unit direction.
    pub fn of(direction: Vec3) -> Self {
        let [azimuth, angle] = polar([direction.y, direction.x], direction.z);
        let turn = azimuth / (2.0 * PI);
        // A turn that is less than nothing by next to nothing is a whole one.
        Self { turn: (turn - turn.floor()).min(1.0 - f64::EPSILON), way: angle / PI }
    }
}

/// The tables of an environment.
#[derive(Debug)]
pub struct Panorama {
    /// Radiance in the middles of the cells, in W/(sr·m²).
    radiance: Table,
    /// Irradiance over π, by normals that are the corners of cells, in the same unit.
    irradiance: Table,
}

impl Panorama {
    /// The tables of the radiance `radiance` of a direction of travel, taken at `height` × 2·`height` places. A sun is dimmed: at the
    /// horizon its irradiance would be coarse, and directions that are aimed there find it anyway.
    pub fn new(height: usize, radiance: &(dyn Fn(Vec3) -> Rgb + Sync)) -> Self {
        let finite = |v: f64| if v.is_finite() { v.max(0.0) } else { 0.0 };
        let mut radiance = Table::new(height, 0.5, &|direction| Rgb::from(radiance(direction).to_array().map(finite)));
        radiance.dim(MOST);
        let moments = moments(&radiance);
        let irradiance = Table::new(NORMALS, 0.0, &|normal| irradiance(&moments, normal));
        Self { radiance, irradiance }
    }

    /// The radiance at a place.
    pub fn radiance(&self, place: Place) -> Rgb {
        self.radiance.at(place)
    }

    /// The irradiance over π, by all of [`Panorama::radiance`] above its horizon, of a surface whose unit normal is there.
    pub fn irradiance(&self, normal: Place) -> Rgb {
        self.irradiance.at(normal)
    }
}

/// The most of all light that may come from one block.
const MOST: f64 = 0.02;

/// Rows of the table of irradiance, and of the blocks that it is made from. Errors are about a thousandth.
const NORMALS: usize = 64;
const BLOCKS: usize = 32;

/// Eight blocks in one channel: the integral of radiance × direction; the length of that times how far light reaches above and below its middle;
/// and a quarter of one over the last.
type Moments = [f32x8; 5];

/// The blocks of an environment.
fn moments(radiance: &Table) -> Vec<[Moments; 3]> {
    let mut sums = vec![[Vec3::ZERO; 3]; 2 * BLOCKS * BLOCKS];
    let (height, half) = (radiance.height(), PI / radiance.width as f64);
    let (chord, turns) = (2.0 * half.sin(), (0..radiance.width).map(|x| (half * (2 * x + 1) as f64).sin_cos()));
    let turns: Vec<(f64, f64)> = turns.collect();
    for (y, row) in radiance.nodes.chunks_exact(radiance.width).enumerate() {
        let [(top, upper), (bottom, lower)] = [y, y + 1].map(|y| (PI * y as f64 / height as f64).sin_cos());
        // The integrals of sin² and of sin × cos over the polar angle.
        let across = 0.5 * (PI / height as f64 - bottom * lower + top * upper);
        let along = 0.5 * (bottom * bottom - top * top);
        let up = along * half / half.sin();
        for (x, (light, (s, c))) in row.iter().zip(&turns).enumerate() {
            let directions = Vec3::new(c * across, s * across, up) * chord;
            sums[radiance.block(x, y)].iter_mut().zip(light).for_each(|(sum, light)| *sum += directions * *light as f64);
        }
    }
    let five = |block: usize, channel: usize| {
        let (sum, sin) = (sums[block][channel], (PI * ((block / (2 * BLOCKS)) as f64 + 0.5) / BLOCKS as f64).sin());
        // Half the height of what is spread as far as the block in the mean of all directions across it.
        let reach = 0.5 * PI / BLOCKS as f64 * (0.5 * (1.0 + sin * sin)).sqrt();
        let reach = (reach * sum.length()).max(f32::MIN_POSITIVE as f64);
        [sum.x, sum.y, sum.z, reach, 0.25 / reach].map(|v| v as f32)
    };
    let eight = |first: usize, channel: usize| {
        let blocks: [[f32; 5]; 8] = std::array::from_fn(|lane| five(first + lane, channel));
        std::array::from_fn(|k| f32x8::from(blocks.map(|block| block[k])))
    };
    (0..sums.len()).step_by(8).map(|first| [0, 1, 2].map(|channel| eight(first, channel))).collect()
}

/// The irradiance over π of a surface: what is above its horizon, along its normal. Blocks that the horizon cuts count as if their light were
/// spread evenly over their height.
fn irradiance(moments: &[[Moments; 3]], normal: Vec3) -> Rgb {
    let normal = normal.to_array().map(|v| f32x8::splat(v as f32));
    let mut sums = [f32x8::ZERO; 3];
    for blocks in moments {
        for (sum, [x, y, z, reach, share]) in sums.iter_mut().zip(blocks) {
            let height = normal[0] * *x + normal[1] * *y + normal[2] * *z;
            let cut = (*reach - height.abs()).max(f32x8::ZERO);
            *sum += height.max(f32x8::ZERO) + cut * cut * *share;
        }
    }
    Rgb::from(sums.map(|sum| sum.reduce_add() as f64 / PI))
}

/// Values on a grid of places, and between its nodes by their distance to them.
#[derive(Debug)]
struct Table {
    width: usize,
    /// How far the first nodes are from turn and way 0, in steps of the grid.
    first: f64,
    /// Row by row from +z.
    nodes: Vec<[f32; 3]>,
}

impl Table {
    /// A table of `rows` steps of way and 2·`rows` of turn.
    fn new(rows: usize, first: f64, value: &(dyn Fn(Vec3) -> Rgb + Sync)) -> Self {
        let width = 2 * rows;
        let last = if first == 0.0 { rows } else { rows - 1 };
        let angle = |step: usize| (PI * (step as f64 + first) / rows as f64).sin_cos();
        let turns: Vec<(f64, f64)> = (0..width).map(angle).collect();
        let mut nodes = vec![[0.0; 3]; (last + 1) * width];
        nodes.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            let (sin, cos) = angle(y);
            for (node, (s, c)) in row.iter_mut().zip(&turns) {
                *node = value(Vec3::new(sin * c, sin * s, cos)).to_array().map(|v| v as f32);
            }
        });
        Self { width, first, nodes }
    }

    fn height(&self) -> usize {
        self.nodes.len() / self.width
    }

    /// The block of the cell in a column and row.
    fn block(&self, x: usize, y: usize) -> usize {
        y * BLOCKS / self.height() * 2 * BLOCKS + x * 2 * BLOCKS / self.width
    }

    /// Dims each block that more than this part of all light comes from to that part.
    fn dim(&mut self, most: f64) {
        let mut blocks = vec![0.0; 2 * BLOCKS * BLOCKS];
        for (y, row) in self.nodes.chunks_exact(self.width).enumerate() {
            let size = (PI * (y as f64 + self.first) / self.height() as f64).sin();
            for (x, node) in row.iter().enumerate() {
                blocks[self.block(x, y)] += size * node.iter().map(|v| *v as f64).sum::<f64>();
            }
        }
        let limit = most * blocks.iter().sum::<f64>();
        for cell in 0..self.nodes.len() {
            let block = blocks[self.block(cell % self.width, cell / self.width)];
            if block > limit {
                self.nodes[cell] = self.nodes[cell].map(|v| v * (limit / block) as f32);
            }
        }
    }

    fn at(&self, place: Place) -> Rgb {
        let x = place.turn * self.width as f64 - self.first + self.width as f64;
        let y = (place.way * (self.width / 2) as f64 - self.first).clamp(0.0, (self.height() - 1) as f64);
        let (column, row) = (x as usize, y as usize);
        let (right, down) = ((x - column as f64) as f32, (y - row as f64) as f32);
        let (left, next) = (column % self.width, (column + 1) % self.width);
        let (above, below) = (row * self.width, (row + 1).min(self.height() - 1) * self.width);
        let mix = |a: f32, b: f32, part: f32| a + (b - a) * part;
        Rgb::from(std::array::from_fn(|c| {
            let across = |row: usize| mix(self.nodes[row + left][c], self.nodes[row + next][c], right);
            mix(across(above), across(below), down) as f64
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::mix64;

    fn directions() -> impl Iterator<Item = Vec3> {
        let u = |i: u64| mix64(i + 1) as f64 / u64::MAX as f64;
        let sphere = move |i: u64| {
            let (z, (s, c)) = (1.0 - 2.0 * u(2 * i), (2.0 * PI * u(2 * i + 1)).sin_cos());
            let r = (1.0 - z * z).sqrt();
            Vec3::new(r * c, r * s, z)
        };
        (0..100).map(sphere).chain([Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z, Vec3::new(1.0, -1e-300, 0.0)])
    }

    #[test]
    fn a_place_is_that_of_its_direction() {
        for d in directions() {
            let Place { turn, way } = Place::of(d);
            assert!((0.0..1.0).contains(&turn) && (0.0..=1.0).contains(&way), "{d}: {turn} {way}");
            let ((sin, cos), (s, c)) = ((PI * way).sin_cos(), (2.0 * PI * turn).sin_cos());
            assert!(Vec3::new(sin * c, sin * s, cos).distance(d) < 1e-12, "{d}: {turn} {way}");
        }
    }

    /// Closed forms: π over π under a uniform sky, 2/3 n + 1 under 1 + n, (1 + cos)/2 under half a sky.
    #[test]
    fn the_irradiance_is_the_integral_of_the_radiance() {
        let half = |d: Vec3| if d.z > 0.0 { 1.0 } else { 0.0 };
        let panorama = Panorama::new(256, &|d| Rgb::new(1.0, 1.0 + d.x, half(d)));
        for n in directions() {
            let (found, right) = (panorama.irradiance(Place::of(n)), Rgb::new(1.0, 1.0 + 2.0 / 3.0 * n.x, (1.0 + n.z) / 2.0));
            assert!((found - right).abs().max_element() < 5e-4, "{n}: {found} instead of {right}");
        }
    }

    #[test]
    fn between_places_the_radiance_is_linear_and_does_not_end_where_a_turn_does() {
        let panorama = Panorama::new(128, &|d| Rgb::new(2.0 + d.x, 2.0 + d.y, 2.0 + d.z));
        for d in directions() {
            let off = panorama.radiance(Place::of(d)) - Rgb::new(2.0 + d.x, 2.0 + d.y, 2.0 + d.z);
            assert!(off.abs().max_element() < 1e-3 + if d.z.abs() > 0.999 { 0.02 } else { 0.0 }, "{d}: {off}");
        }
    }
}
