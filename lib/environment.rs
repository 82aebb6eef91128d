//! Where distant light comes from: importance sampling of the radiance of the sky of a scene, as a function of direction.
//!
//! The radiance itself is exact (a pattern on a source); only the density with which directions are drawn is tabulated.

mod spots;

pub use spots::{CELL, Cap, Spot, spots};

use crate::color::{Rgb, bright};
use crate::panorama::Place;
use crate::sampling::Steps;
use crate::vector::Vec3;
use crate::vector::angle::sin_cos;
use rayon::prelude::*;
use std::f64::consts::PI;

/// A density over directions, proportional to how much an environment's brightness exceeds its mean: what is below the mean is left to the
/// sampling of the material (Karlík et al. 2019, "MIS Compensation"). A uniform environment therefore has none.
#[derive(Debug)]
pub struct Environment {
    /// Rows of equal polar angle from +z.
    rows: Steps,
    /// For each row, its columns of equal azimuth; `None` for a row that is never drawn.
    columns: Vec<Option<Steps>>,
    width: usize,
    /// Cosines of the polar angles between rows, from 1 to −1.
    cosines: Vec<f64>,
}

impl Environment {
    /// The density for the radiance `radiance` of a direction of travel, tabulated in `height` × 2·`height` cells of polar angle and azimuth.
    /// `None` if nothing stands out from the mean.
    pub fn new(height: usize, radiance: &(dyn Fn(Vec3) -> Rgb + Sync)) -> Option<Self> {
        let width = 2 * height;
        // Brightness at the corners of the cells, row by row.
        let corners: Vec<Vec<f32>> = (0..=height)
            .into_par_iter()
            .map(|y| {
                let (sin, cos) = (PI * y as f64 / height as f64).sin_cos();
                (0..width)
                    .map(|x| {
                        let (s, c) = (2.0 * PI * x as f64 / width as f64).sin_cos();
                        let value = bright(radiance(Vec3::new(sin * c, sin * s, cos))) as f32;
                        if value.is_finite() { value.max(0.0) } else { 0.0 }
                    })
                    .collect()
            })
            .collect();
        let cosines: Vec<f64> = (0..=height).map(|y| (PI * y as f64 / height as f64).cos()).collect();
        let area = |y: usize| (cosines[y] - cosines[y + 1]) / 2.0;
        let mean_of = |y: usize, x: usize| {
            let next = (x + 1) % width;
            [corners[y][x], corners[y][next], corners[y + 1][x], corners[y + 1][next]].map(|c| c / 4.0).iter().sum::<f32>()
        };
        let mean: f64 = (0..height).map(|y| area(y) / width as f64 * (0..width).map(|x| mean_of(y, x) as f64).sum::<f64>()).sum();
        let mean = (mean * (1.0 + 1e-6)) as f32;
        let rows: Vec<Option<(Steps, f64)>> = (0..height)
            .into_par_iter()
            .map(|y| Steps::new(&(0..width).map(|x| (mean_of(y, x) - mean).max(0.0)).collect::<Vec<_>>()))
            .collect();
        let weights: Vec<f32> =
            rows.iter().enumerate().map(|(y, row)| row.as_ref().map_or(0.0, |(_, sum)| (sum * area(y)) as f32)).collect();
        let (steps, _) = Steps::new(&weights)?;
        Some(Self { rows: steps, columns: rows.into_iter().map(|row| row.map(|(steps, _)| steps)).collect(), width, cosines })
    }

    /// A direction (of travel, away from the viewer) and its density per solid angle.
    pub fn sample(&self, [u, v]: [f64; 2]) -> Option<(Vec3, f64)> {
        let (y, dy) = self.rows.sample(v);
        let columns = self.columns[y].as_ref()?;
        let (x, dx) = columns.sample(u);
        let z = self.cosines[y] + (self.cosines[y + 1] - self.cosines[y]) * dy;
        let (s, c) = sin_cos((x as f64 + dx) / self.width as f64);
        let r = (1.0 - z * z).max(0.0).sqrt();
        Some((Vec3::new(r * c, r * s, z), self.density(y, columns.probability(x))))
    }

    /// The density of the direction at a place, per solid angle.
    pub fn pdf(&self, place: Place) -> f64 {
        let x = (place.turn * self.width as f64) as usize;
        let y = ((place.way * self.columns.len() as f64) as usize).min(self.columns.len() - 1);
        self.columns[y].as_ref().map_or(0.0, |columns| self.density(y, columns.probability(x.min(self.width - 1))))
    }

    fn density(&self, y: usize, in_row: f64) -> f64 {
        self.rows.probability(y) * in_row * self.width as f64 / (2.0 * PI * (self.cosines[y] - self.cosines[y + 1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(d: Vec3) -> Rgb {
        Rgb::splat(if d.dot(Vec3::new(0.6, 0.0, 0.8)) > 0.95 { 10.0 } else { 0.5 })
    }

    #[test]
    fn sampled_directions_have_the_density_that_pdf_says_and_it_integrates_to_one() {
        let environment = Environment::new(64, &lamp).unwrap();
        let n = 200;
        let mut total = 0.0;
        for i in 0..n {
            for j in 0..n {
                let u = [(i as f64 + 0.5) / n as f64, (j as f64 + 0.5) / n as f64];
                let (d, p) = environment.sample(u).unwrap();
                assert!((d.length() - 1.0).abs() < 1e-12);
                assert!((environment.pdf(Place::of(d)) / p - 1.0).abs() < 1e-6);
                let z = 1.0 - 2.0 * u[0];
                let (s, c) = (2.0 * PI * u[1]).sin_cos();
                let r = (1.0 - z * z).sqrt();
                total += environment.pdf(Place::of(Vec3::new(r * c, r * s, z))) * 4.0 * PI / (n * n) as f64;
            }
        }
        assert!((total - 1.0).abs() < 0.02, "{total}");
    }

    #[test]
    fn a_uniform_environment_is_left_to_the_material() {
        assert!(Environment::new(16, &|_| Rgb::ONE).is_none());
        assert!(Environment::new(16, &|_| Rgb::ZERO).is_none());
    }
}
