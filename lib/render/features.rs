//! Other pictures of the same pixels: what stands there, how it is lit.

use super::suns::Suns;
use super::{Rendering, Task};
use crate::bsdf::{Arriving, Bsdf, Delta, Part};
use crate::color::Rgb;
use crate::integrator::{Integrator, Kind, Radiance, Transport, Visit};
use crate::material::Inside;
use crate::rules::Rules;
use crate::scene::MaterialId;
use crate::vector::Vec3;
use crate::world::Layer;
use rayon::prelude::*;

/// What the samples of a pixel showed, on the average.
#[derive(Clone, Copy, Debug, Default)]
pub struct Features {
    /// The normal of the first surface, bent by textures, on the viewer's side; not a unit vector where normals differ, zero where nothing is.
    pub normal: Vec3,
    /// The distance to the first surface in the scene's unit of length, over the samples that met one; infinite if none did.
    pub depth: f64,
    /// The part of uniform light that the first surface reflects and transmits toward the viewer, by the coefficients of its material.
    pub albedo: Rgb,
    /// Light that was scattered roughly at most once.
    pub direct: Rgb,
    /// Light that was scattered roughly more often, and what `-av` adds.
    pub indirect: Rgb,
}

/// The features of the pixels of a finished rendering, seen by the same samples: direct and indirect light add up to the rendering,
/// but in pixels that it had no time for. `None` once `stop`
/// says so.
pub fn features(task: &Task, rendering: &Rendering, stop: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Features>> {
    let suns = Suns::of(task);
    (0..task.count)
        .into_par_iter()
        .map_init(
            || Integrator::new(task.world, task.rules),
            |integrator, number| {
                if stop() {
                    return None;
                }
                let taken = rendering.pixels[number].counts();
                let sets = taken.iter().filter(|&&count| count > 0).count().max(1) as f64;
                let (mut whole, mut depth, mut met) = (Features::default(), 0.0, 0.0);
                for (set, &count) in taken.iter().enumerate() {
                    for sample in (0..count).map(|index| task.sample(&suns, number, 0, set, index)) {
                        let Some(((ray, limit), sampler)) = sample.sight else { continue };
                        let mut watch = Watch { colors: Radiance { rules: task.rules, sum: Rgb::ZERO }, sum: Features::default(), met: 0 };
                        integrator.trace(&mut watch, ray, limit, sampler);
                        let share = sample.weight / (sets * count as f64);
                        whole.normal += watch.sum.normal * share;
                        whole.albedo += watch.sum.albedo * share;
                        whole.direct += watch.sum.direct * share;
                        whole.indirect += watch.sum.indirect * share;
                        (depth, met) = (depth + watch.sum.depth * sample.weight, met + watch.met as f64 * sample.weight);
                    }
                }
                Some(Features { depth: if met > 0.0 { depth / met } else { f64::INFINITY }, ..whole })
            },
        )
        .collect()
}

/// The fraction of each pixel that is covered by surfaces of one of these materials.
pub fn coverage(task: &Task, materials: &[MaterialId]) -> Vec<f64> {
    let evenly = Suns::default();
    let shows = |number: usize, index: u32| {
        task.sample(&evenly, number, 0, 0, index)
            .sight
            .is_some_and(|((ray, limit), _)| materials.iter().any(|&m| task.world.shows(&ray, limit, m)))
    };
    (0..task.count)
        .into_par_iter()
        .map(|number| {
            let count = |samples: std::ops::Range<u32>| samples.filter(|&index| shows(number, index)).count() as u32;
            let first = count(0..COVERAGE_FIRST);
            // Only an edge is worth more.
            if task.fixed() || first == 0 || first == COVERAGE_FIRST {
                return first as f64 / COVERAGE_FIRST as f64;
            }
            (first + count(COVERAGE_FIRST..COVERAGE_ALL)) as f64 / COVERAGE_ALL as f64
        })
        .collect()
}

/// Samples of the coverage of a pixel: of every one, and of those that are partly covered.
const COVERAGE_FIRST: u32 = 64;
const COVERAGE_ALL: u32 = 1024;

/// A transport that watches first surfaces and counts rough scatterings.
struct Watch<'a> {
    colors: Radiance<'a>,
    sum: Features,
    met: u32,
}

/// A throughput, and how often it was scattered roughly.
#[derive(Clone, Copy)]
struct Beta {
    color: Rgb,
    scattered: u32,
    /// Whether it is that of the viewer's own ray, so far.
    first: bool,
}

impl Watch<'_> {
    fn scattered(&self, beta: &Beta, color: Rgb) -> Beta {
        Beta { color, scattered: beta.scattered + 1, first: false }
    }
}

impl Transport for Watch<'_> {
    type Beta = Beta;
    type Surface = Bsdf;

    fn start(&self) -> Beta {
        Beta { color: Rgb::ONE, scattered: 0, first: true }
    }

    fn scale(&self, beta: &mut Beta, by: Rgb) {
        self.colors.scale(&mut beta.color, by);
    }

    fn size(&self, beta: &Beta) -> f64 {
        self.colors.size(&beta.color)
    }

    fn surface(&self, layer: &Layer, rules: &Rules) -> Bsdf {
        self.colors.surface(layer, rules)
    }

    fn aimed(&self, beta: &Beta, surface: &Bsdf, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> Beta {
        self.scattered(beta, self.colors.aimed(&beta.color, surface, wi, arriving, pdf, counts))
    }

    fn drawn(&self, beta: &Beta, surface: &Bsdf, wi: Vec3, part: Part, way: usize, count: f64) -> (Beta, f64) {
        let (color, density) = self.colors.drawn(&beta.color, surface, wi, part, way, count);
        (self.scattered(beta, color), density)
    }

    fn ambient(&self, beta: &Beta, surface: &Bsdf, side: usize) -> Beta {
        // What stands for all the bounces that are left out is indirect.
        Beta { color: self.colors.ambient(&beta.color, surface, side), scattered: u32::MAX, first: false }
    }

    fn unhidden(&self, beta: &Beta, surface: &Bsdf, side: usize) -> Beta {
        self.scattered(beta, self.colors.ambient(&beta.color, surface, side))
    }

    fn follow(&self, beta: &Beta, surface: &Bsdf, delta: &Delta) -> Beta {
        Beta { color: self.colors.follow(&beta.color, surface, delta), ..*beta }
    }

    fn absorb(&self, beta: &mut Beta, medium: &Inside, length: f64) {
        self.colors.absorb(&mut beta.color, medium, length);
    }

    fn collect(&mut self, beta: &Beta, radiance: Rgb) {
        *if beta.scattered <= 1 { &mut self.sum.direct } else { &mut self.sum.indirect } += beta.color * radiance;
    }

    fn visit(&mut self, beta: &mut Beta, visit: &Visit) {
        beta.first = visit.kind == Kind::Primary;
        if let (Kind::Primary, Some(hit)) = (visit.kind, visit.hit) {
            self.sum.depth += hit.t;
            self.met += 1;
        }
    }

    fn meet(&mut self, beta: &Beta, layer: &Layer) {
        if beta.first {
            self.sum.normal += layer.point.shading * layer.fraction;
            self.sum.albedo += layer.bsdf(self.colors.rules).albedo() * layer.fraction;
        }
    }
}
