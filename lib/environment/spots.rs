//! What is small, round and bright in an environment: lamps, as far as can be seen from one place.

use crate::color::{Rgb, bright};
use crate::vector::{Frame, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Rows of cells that an environment is searched by, and the cells of each.
const ROWS: usize = 256;
const WIDTH: usize = 2 * ROWS;
/// The angle between rows.
pub const CELL: f64 = PI / ROWS as f64;
/// How many times as bright as the mean of the environment a spot is.
const BRIGHT: f64 = 8.0;
/// The greatest angle of a spot from its middle to its rim.
const WIDEST: f64 = 0.15;
/// How many times as far as a disc of its size it may be spread (the square of that).
const SPREAD: f64 = 1.3;
/// The most spots: an environment with more of them glitters.
const MOST: usize = 32;

/// Something small and bright.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// The unit direction of travel to its middle.
    pub direction: Vec3,
    /// Its radiance, in W/(sr·m²).
    pub radiance: Rgb,
    /// The angle from its middle to the rim of a disc of this radiance.
    pub angle: f64,
    /// The angle within which all of it lies.
    reach: f64,
}

/// A part of an environment that a spot is taken out of: what surrounds it goes on there.
#[derive(Clone, Debug)]
pub struct Cap {
    direction: Vec3,
    cosine: f64,
    /// Directions all around it, and what shines there.
    ring: Vec<(Vec3, Rgb)>,
}

impl Cap {
    /// What shines in a direction, if that is within: most of it what is near on the ring.
    pub fn radiance(&self, direction: Vec3) -> Option<Rgb> {
        if self.direction.dot(direction) <= self.cosine {
            return None;
        }
        let near = |ring: &(Vec3, Rgb)| direction.distance_squared(ring.0).max(f64::MIN_POSITIVE).recip();
        let light: Rgb = self.ring.iter().map(|ring| ring.1 * near(ring)).sum();
        Some(light / self.ring.iter().map(near).sum::<f64>())
    }
}

/// The spots of an environment of the radiance `radiance` of a direction of travel.
pub fn spots(radiance: impl Fn(Vec3) -> Rgb + Sync) -> Vec<Spot> {
    let cells: Vec<Rgb> = (0..ROWS * WIDTH).into_par_iter().with_min_len(WIDTH).map(|cell| radiance(direction(cell))).collect();
    let mean = cells.iter().enumerate().map(|(cell, light)| bright(*light) * size(cell)).sum::<f64>() / (4.0 * PI);
    let mut left: Vec<bool> = cells.iter().map(|light| bright(*light) > BRIGHT * mean).collect();
    let found = (0..cells.len()).filter_map(|cell| Spot::of(&cells, &joined(cell, &mut left)));
    let found: Vec<Spot> = found.take(MOST + 1).collect();
    if found.len() > MOST { Vec::new() } else { found }
}

/// The direction to the middle of a cell.
fn direction(cell: usize) -> Vec3 {
    let [(sin, cos), (s, c)] = [cell / WIDTH, cell % WIDTH].map(|step| (CELL * (step as f64 + 0.5)).sin_cos());
    Vec3::new(sin * c, sin * s, cos)
}

/// The solid angle of a cell.
fn size(cell: usize) -> f64 {
    CELL * CELL * (CELL * ((cell / WIDTH) as f64 + 0.5)).sin()
}

/// The cell, and all of those left that hang together with it; they are left no more.
fn joined(cell: usize, left: &mut [bool]) -> Vec<usize> {
    let mut take = |cell: &usize| std::mem::take(&mut left[*cell]);
    let mut members: Vec<usize> = Some(cell).into_iter().filter(&mut take).collect();
    let mut next = 0;
    while let Some(&cell) = members.get(next) {
        let (row, column) = (cell - cell % WIDTH, cell % WIDTH);
        let beside = [1, WIDTH - 1].map(|step| Some(row + (column + step) % WIDTH));
        let above = [cell.checked_sub(WIDTH), Some(cell + WIDTH).filter(|cell| *cell < ROWS * WIDTH)];
        members.extend(beside.into_iter().chain(above).flatten().filter(&mut take));
        next += 1;
    }
    members
}

impl Spot {
    /// These cells as a spot, if they are one.
    fn of(cells: &[Rgb], members: &[usize]) -> Option<Self> {
        let mut members: Vec<(f64, usize)> = members.iter().map(|&cell| (bright(cells[cell]), cell)).collect();
        members.sort_by(|a, b| b.0.total_cmp(&a.0));
        let sum = |of: &dyn Fn(usize) -> f64| members.iter().map(|&(bright, cell)| bright * size(cell) * of(cell)).sum::<f64>();
        let power = sum(&|_| 1.0);
        // A disc as bright as what half of the light comes from is: cells at the rim are partly dark.
        let mut half = 0.5 * power;
        let (bright, _) = members.iter().find(|&&(bright, cell)| {
            half -= bright * size(cell);
            half <= 0.0
        })?;
        let solid = power / bright;
        let angle = (1.0 - solid / (2.0 * PI)).clamp(-1.0, 1.0).acos();
        let middle = Vec3::from([0, 1, 2].map(|axis| sum(&|cell| direction(cell)[axis]))).normalize();
        let spread = sum(&|cell| direction(cell).distance_squared(middle)) / power;
        let round = spread <= SPREAD * 0.5 * angle * angle + CELL * CELL;
        let reach = members.iter().map(|&(_, cell)| direction(cell).angle_between(middle)).fold(0.0, f64::max) + 1.5 * CELL;
        let radiance = members.iter().map(|&(_, cell)| cells[cell] * size(cell)).sum::<Rgb>() / solid;
        (round && angle <= WIDEST).then_some(Self { direction: middle, radiance, angle, reach })
    }

    /// The part of its environment, of this radiance, that it is taken out of.
    pub fn cap(&self, radiance: impl Fn(Vec3) -> Rgb) -> Cap {
        const ROUND: usize = 32;
        let (frame, (sin, cosine)) = (Frame::around(self.direction), (1.2 * self.reach).sin_cos());
        let around = |step: usize| {
            let (s, c) = (2.0 * PI * step as f64 / ROUND as f64).sin_cos();
            let direction = frame.to_world(Vec3::new(c * sin, s * sin, cosine));
            (direction, radiance(direction))
        };
        Cap { direction: self.direction, cosine, ring: (0..ROUND).map(around).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sky of radiance 1 with discs: a direction, the angle to the rim, and the radiance.
    fn sky(discs: &[(Vec3, f64, f64)]) -> impl Fn(Vec3) -> Rgb + Sync {
        move |d| {
            let disc = discs.iter().find(|(middle, angle, _)| d.angle_between(middle.normalize()) < *angle);
            Rgb::new(1.0, 1.0, 0.5) * disc.map_or(1.0, |disc| disc.2)
        }
    }

    #[test]
    fn discs_are_found_wherever_they_are_with_their_power() {
        let discs =
            [(Vec3::new(1.0, -1e-3, 0.2), 0.05, 60.0), (Vec3::new(-0.1, 0.05, 1.0), 0.03, 200.0), (Vec3::new(-1.0, 1.0, -0.4), 0.12, 30.0)];
        let found = spots(sky(&discs));
        assert_eq!(found.len(), 3);
        for (middle, angle, radiance) in discs {
            let spot = found.iter().min_by(|a, b| a.direction.angle_between(middle).total_cmp(&b.direction.angle_between(middle))).unwrap();
            assert!(spot.direction.angle_between(middle) < 0.2 * CELL, "{spot:?}");
            assert!((spot.angle - angle).abs() < 0.5 * CELL && (spot.radiance.z - 0.5 * radiance).abs() < 1e-9 * radiance, "{spot:?}");
            // It is taken out, and the sky goes on.
            let cap = spot.cap(sky(&discs));
            assert_eq!(cap.radiance(Vec3::from(middle.normalize())), Some(Rgb::new(1.0, 1.0, 0.5)));
            assert_eq!(cap.radiance(-middle.normalize()), None);
        }
    }

    #[test]
    fn what_is_wide_long_or_one_of_many_is_no_spot() {
        let bar: Vec<_> = (0..30).map(|i| (Vec3::new(1.0, 0.01 * i as f64, 0.3), 0.02, 50.0)).collect();
        let stars: Vec<_> = (0..40).map(|i| (Vec3::new((i as f64).cos(), (i as f64).sin(), 0.05 * i as f64 - 1.0), 0.015, 90.0)).collect();
        for discs in [&[(Vec3::X, 0.3, 60.0)][..], &bar, &stars, &[(Vec3::X, 0.05, 5.0)]] {
            assert!(spots(sky(discs)).is_empty());
        }
        assert!(spots(|_| Rgb::new(f64::NAN, f64::INFINITY, 0.0)).is_empty());
    }
}
