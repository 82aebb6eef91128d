//! All pixels of a picture: which rays, how many samples, on how many threads, how large the error is.
//!
//! A pixel's samples fall into [`GROUPS`] independently scrambled sequences; the spread of their means is the pixel's error. What a pixel
//! gets depends on the seed, the pixel and the number of samples only, so any number of threads gives the same picture.

mod features;

pub use features::{Features, coverage, features};

use crate::color::{Rgb, bright};
use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::integrator::{Integrator, Outcome, Radiance};
use crate::picture::{pixel_count, reserve};
use crate::rules::Rules;
use crate::sampling::{Sampler, disk};
use crate::vector::Vec3;
use crate::view::{Camera, View};
use crate::world::World;
use rayon::prelude::*;
use std::ops::Range;
use std::time::{Duration, Instant};

/// The number of independent sequences of a pixel.
pub const GROUPS: usize = 16;

/// When a picture is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Budget {
    /// When the estimated relative standard error is this.
    Error(f64),
    /// After this many samples in each pixel.
    Samples(u32),
    /// As good as this much time allows.
    Time(Duration),
}

/// The relative standard error that is asked for when nothing is.
pub const DEFAULT_ERROR: f64 = 0.05;

/// Origin, unit direction and length limit of the ray of sample point `(x, y)` of a pixel's area, each in [0, 1); `None` outside the view.
pub type Lens<'a> = &'a (dyn Fn(usize, [f64; 2]) -> Option<(Vec3, Vec3, f64)> + Sync);

/// A camera and the pixels behind it.
#[derive(Clone, Debug)]
pub struct Film {
    /// The camera.
    pub camera: Camera,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Film {
    /// The largest picture of a view that fits into `x` × `y` pixels of the aspect `pa` (height over width; 0: any). Errors if it has
    /// more pixels than any picture, or than there is memory for.
    pub fn new(view: &View, x: usize, y: usize, pa: f64) -> Result<Self> {
        if x == 0 || y == 0 {
            return Err(Error::new("a picture needs at least one pixel: -x and -y must be above 0"));
        }
        let camera = view.ready()?;
        let (width, height) = camera.resolution(x, y, pa);
        reserve(&mut Vec::<Pixel>::new(), pixel_count(width, height)?)?;
        Ok(Self { camera, width, height })
    }

    /// What a lens of this diameter blurs, focused at the length of `-vd`.
    pub fn blur(&self, diameter: f64) -> Option<Blur> {
        let (axes, flat) = self.camera.axes();
        (diameter > 0.0).then(|| Blur { diameter, focus: self.camera.focus(), axes, flat })
    }

    /// The rays of the pixels, numbered row by row from the top, each row from the left.
    pub fn lens(&self) -> impl Fn(usize, [f64; 2]) -> Option<(Vec3, Vec3, f64)> + Sync {
        |number, [u, v]| {
            let (x, y) = ((number % self.width) as f64, (number / self.width) as f64);
            self.camera.ray((x + u) / self.width as f64, 1.0 - (y + v) / self.height as f64)
        }
    }
}

/// What is known of a pixel: sums of its samples, group by group.
#[derive(Clone, Debug, Default)]
pub struct Pixel {
    sums: [[f32; 3]; GROUPS],
    counts: [u32; GROUPS],
    /// Whether a sample met a surface.
    pub surface: bool,
    /// Whether the pixel is exact: no sample was left to chance.
    exact: bool,
}

/// A picture in the making, and its error.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Pixels in the order of their numbers.
    pub pixels: Vec<Pixel>,
    /// Samples taken of each pixel.
    pub samples: u32,
    /// Estimated relative standard error: the root mean square, over the pixels that show a surface, of the standard error of their
    /// luminance, divided by the mean luminance of those pixels. 0 for a picture without surfaces.
    pub noise: f64,
}

/// The most samples of a pixel that has an error of its own to reach.
const MOST: u32 = 1 << 20;

/// The fewest such samples of a pixel that is left to chance: fewer may all miss what matters.
const FEWEST: u32 = 4 * GROUPS as u32;

impl Pixel {
    /// Takes samples until the pixel by itself is what the budget asks for. `pixel` is its number; `sample` gives the light of one sample.
    pub fn converged(budget: Budget, seed: u64, pixel: u64, mut sample: impl FnMut(Sampler) -> (Rgb, Outcome)) -> Self {
        let (start, mut so_far) = (Instant::now(), Self::default());
        for index in 0..MOST {
            let done = match budget {
                Budget::Samples(samples) => index >= samples,
                Budget::Time(time) => index > 0 && start.elapsed() >= time,
                Budget::Error(error) => {
                    index >= FEWEST
                        && index.is_multiple_of(GROUPS as u32)
                        && so_far.variance().1.sqrt() <= error * bright(so_far.mean()).abs()
                }
            };
            if done {
                break;
            }
            let group = index as usize % GROUPS;
            let (light, outcome) = sample(Sampler::new(seed, pixel, group as u32, index / GROUPS as u32));
            so_far.add(group, light);
            so_far.surface |= outcome.surface;
            so_far.exact = !outcome.random;
            if so_far.exact {
                break;
            }
        }
        so_far
    }

    /// How many samples were taken.
    pub fn samples(&self) -> u32 {
        self.counts.iter().sum()
    }

    fn add(&mut self, group: usize, value: Rgb) {
        self.sums[group].iter_mut().zip(value.to_array()).for_each(|(sum, v)| *sum += v as f32);
        self.counts[group] += 1;
    }

    /// The estimated radiance.
    pub fn mean(&self) -> Rgb {
        let count: u32 = self.counts.iter().sum();
        let sum: Rgb = self.sums.iter().map(|s| Rgb::from(s.map(f64::from))).sum();
        sum / count.max(1) as f64
    }

    /// The estimated variance of [`Pixel::mean`], of each channel and of the luminance. Infinite while there are fewer than two groups.
    pub fn variance(&self) -> (Rgb, f64) {
        let used = self.counts.iter().filter(|&&c| c > 0).count() as f64;
        if self.exact {
            return (Rgb::ZERO, 0.0);
        }
        if used < 2.0 {
            return (Rgb::splat(f64::INFINITY), f64::INFINITY);
        }
        let mean = self.mean();
        let (mut channels, mut luminance, mut total) = (Rgb::ZERO, 0.0, 0.0);
        for (sum, &count) in self.sums.iter().zip(&self.counts).filter(|(_, c)| **c > 0) {
            let n = count as f64;
            let off = Rgb::from(sum.map(f64::from)) / n - mean;
            channels += off * off * (n * n);
            luminance += bright(off).powi(2) * n * n;
            total += n;
        }
        let scale = used / (used - 1.0) / (total * total);
        (channels * scale, luminance * scale)
    }
}

/// What to render.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The scene.
    pub world: &'a World,
    /// The rules of its light.
    pub rules: &'a Rules,
    /// The number of pixels.
    pub count: usize,
    /// The rays of each.
    pub lens: Lens<'a>,
    /// Over which fraction of its width a pixel is sampled (box filter); 0 samples its centre.
    pub jitter: f64,
    /// What blurs things out of focus.
    pub blur: Option<Blur>,
    /// When it is good enough.
    pub budget: Budget,
    /// Fixes every random choice.
    pub seed: u64,
}

/// Renders until the budget is spent. `goes_on` is shown the picture after each round; when it says no, the picture so far is the result.
pub fn render(task: &Task, goes_on: &mut dyn FnMut(&Rendering) -> bool) -> Rendering {
    let start = Instant::now();
    let mut rendering = Rendering { pixels: vec![Pixel::default(); task.count], samples: 0, noise: f64::INFINITY };
    loop {
        let passes = plan(&rendering, task.budget, start.elapsed());
        if passes == 0 {
            return rendering;
        }
        let range = rendering.samples..rendering.samples + passes;
        rendering.pixels.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, pixels)| {
            let mut integrator = Integrator::new(task.world, task.rules);
            for (i, pixel) in pixels.iter_mut().enumerate().filter(|(_, p)| !p.exact) {
                task.sample(&mut integrator, chunk * CHUNK + i, pixel, range.clone());
            }
        });
        rendering.samples += passes;
        rendering.noise = noise(&rendering.pixels);
        if !goes_on(&rendering) {
            return rendering;
        }
    }
}

/// Pixels that a thread takes at a time.
const CHUNK: usize = 64;

/// A lens that is sharp at one distance only.
#[derive(Clone, Copy, Debug)]
pub struct Blur {
    /// Diameter of the lens.
    pub diameter: f64,
    /// Where it is sharp: a distance along the view direction; for round views, from the viewpoint.
    pub focus: f64,
    /// Unit vectors: where the camera looks to, to the right and to the top of its picture.
    pub axes: [Vec3; 3],
    /// Whether all that is equally far from the plane of the picture is equally sharp, rather than from the viewpoint.
    pub flat: bool,
}

impl Blur {
    /// The ray through another point of the lens.
    fn bend(&self, origin: Vec3, direction: Vec3, u: [f64; 2]) -> (Vec3, Vec3) {
        let [forward, right, up] = self.axes;
        let reach = if self.flat { self.focus / direction.dot(forward) } else { self.focus };
        let [x, y] = disk(u).map(|v| v * self.diameter / 2.0);
        let moved = origin + right * x + up * y;
        (moved, (origin + direction * reach - moved).normalize())
    }
}

impl Task<'_> {
    /// The ray of a sample, as far as it goes, and what is left of the random numbers; `None` outside the view.
    fn sight(&self, number: usize, mut sampler: Sampler) -> Option<((Ray, f64), Sampler)> {
        let at = if self.jitter > 0.0 { sampler.pair().map(|u| 0.5 + self.jitter * (u - 0.5)) } else { [0.5; 2] };
        let (mut origin, mut direction, limit) = (self.lens)(number, at)?;
        if let Some(blur) = &self.blur {
            (origin, direction) = blur.bend(origin, direction, sampler.pair());
        }
        Some(((Ray { origin, direction }, limit), sampler))
    }

    /// Whether all samples of a pixel have the same ray.
    fn fixed(&self) -> bool {
        self.jitter == 0.0 && self.blur.is_none()
    }

    /// Takes some samples of a pixel.
    fn sample(&self, integrator: &mut Integrator<Rgb>, number: usize, pixel: &mut Pixel, samples: Range<u32>) {
        for index in samples {
            let group = index as usize % GROUPS;
            let sampler = Sampler::new(self.seed, number as u64, group as u32, index / GROUPS as u32);
            let Some(((ray, limit), sampler)) = self.sight(number, sampler) else {
                pixel.add(group, Rgb::ZERO);
                pixel.exact = self.fixed();
                continue;
            };
            let mut transport = Radiance { rules: self.rules, sum: Rgb::ZERO };
            let outcome = integrator.trace(&mut transport, ray, limit, sampler);
            pixel.add(group, transport.sum);
            pixel.surface |= outcome.surface;
            if !outcome.random && self.fixed() {
                pixel.exact = true;
                return;
            }
        }
    }
}

/// The error of a picture, as [`Rendering::noise`] defines it.
fn noise(pixels: &[Pixel]) -> f64 {
    let (mut variance, mut light) = (0.0, 0.0);
    for pixel in pixels.iter().filter(|p| p.surface) {
        variance += pixel.variance().1;
        light += bright(pixel.mean());
    }
    let shown = pixels.iter().filter(|p| p.surface).count() as f64;
    if shown == 0.0 || variance == 0.0 { 0.0 } else { (variance / shown).sqrt() / (light / shown).abs() }
}

/// How many more samples to take of each pixel.
fn plan(rendering: &Rendering, budget: Budget, elapsed: Duration) -> u32 {
    let done = rendering.samples;
    if done > 0 && rendering.pixels.iter().all(|p| p.exact) {
        return 0;
    }
    let round = GROUPS as u32;
    match budget {
        Budget::Samples(wanted) => (wanted - done).min(done.max(round)),
        Budget::Error(_) if done == 0 => round,
        Budget::Error(error) if rendering.noise <= error => 0,
        Budget::Error(error) => {
            // Error falls at least as the root of the number of samples; ask for a little more, but never for more than twice as much again.
            let factor = (rendering.noise / error).powi(2) * 1.05 - 1.0;
            let more = (factor.clamp(0.05, 2.0) * done as f64) as u32;
            more.div_ceil(round) * round
        }
        Budget::Time(_) if done == 0 => 1,
        Budget::Time(time) => {
            // Leave a tenth of what is left, for what follows.
            let left = time.saturating_sub(elapsed).as_secs_f64() * 0.9;
            let fits = (left / (elapsed.as_secs_f64() / done as f64)) as u32;
            // Early rounds are short, so that the pace is known before much is risked.
            fits.min(done.max(1))
        }
    }
}
