//! All pixels of a picture: which rays, how many samples, on how many threads, how large the error is.
//!
//! A pixel's samples are dealt to [`SETS`] sequences that are scrambled independently; over all pixels, how far these are apart tells the
//! error. What a pixel gets depends on the seed, the pixel, its neighbours and the budget only, so any number of threads gives the same
//! picture. Only time as a budget, and being interrupted, leave traces.

mod features;
mod filter;
mod part;
mod pixel;
mod plan;
mod suns;
mod variance;

pub use features::{Features, coverage, features};
pub use filter::{Filter, WIDEST};
pub use part::{join, part, range};
pub use pixel::{GROUPS, Pixel, SETS};

use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::geometry::Ray;
use crate::integrator::{Integrator, Radiance};
use crate::picture::{pixel_count, reserve};
use crate::rules::Rules;
use crate::sampling::{Sampler, disk, lattice};
use crate::vector::Vec3;
use crate::view::{Camera, View};
use crate::world::World;
use pixel::{MOST, dealt};
use plan::{FEWEST, Noise, PILOT, next_level, noise, reached, shares, wanted};
use rayon::prelude::*;
use std::time::{Duration, Instant};
use suns::{SUN, Suns};

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

impl Budget {
    /// What is left of it once some time is spent, for a rendering that is done `twice`, the second time for its features.
    pub fn after(self, spent: Duration, twice: bool) -> Self {
        match self {
            Self::Time(time) => Self::Time(time.saturating_sub(spent).mul_f64(if twice { 0.45 } else { 1.0 })),
            other => other,
        }
    }
}

/// The relative standard error that is asked for when nothing is.
pub const DEFAULT_ERROR: f64 = 0.05;

/// Origin, unit direction and length limit of the ray of a sample of a pixel, for two uniform numbers in [0, 1), which [`Film::filter`] takes to a
/// place in the pixel or beside it; `None` outside the view.
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
    /// Which of the light around its centre a pixel takes in.
    pub filter: Filter,
}

impl Film {
    /// The largest picture of a view that fits into `x` × `y` pixels of the aspect `pa` (height over width; 0: any), each of which takes in the
    /// light of its area. Errors if it has more pixels than any picture.
    pub fn new(view: &View, x: usize, y: usize, pa: f64) -> Result<Self> {
        if x == 0 || y == 0 {
            return Err(Error::new("a picture needs at least one pixel: -x and -y must be above 0"));
        }
        let camera = view.ready()?;
        let (width, height) = camera.resolution(x, y, pa);
        pixel_count(width, height)?;
        Ok(Self { camera, width, height, filter: Filter::boxed(1.0) })
    }

    /// The same with so few pixels in a row and in a column at most, each in the place of as many as are too many.
    pub fn at_most(&self, most: usize) -> Self {
        match self.width.max(self.height).div_ceil(most) {
            ..=1 => self.clone(),
            times => {
                Self { width: self.width.div_ceil(times), height: self.height.div_ceil(times), filter: Filter::boxed(1.0), ..self.clone() }
            }
        }
    }

    /// The same with pixels that take in light by another filter.
    pub fn through(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// Errors if there is no memory for a rendering of it.
    pub fn fits_memory(&self) -> Result<()> {
        reserve(&mut Vec::<Pixel>::new(), self.width * self.height)
    }

    /// The numbers of about so many pixels, spread over its rows and columns alike; of all, if it has no more.
    pub fn some(&self, count: usize) -> impl Iterator<Item = usize> {
        let (width, height) = (self.width, self.height);
        let all = width * height <= count;
        (0..count.min(width * height)).map(move |i| {
            let [x, y] = lattice(i + 1);
            if all { i } else { (y * height as f64) as usize * width + (x * width as f64) as usize }
        })
    }

    /// The numbers of the pixels at most `reach` columns and rows from one, and its own.
    pub fn around(&self, n: usize, reach: usize) -> impl Iterator<Item = usize> + use<> {
        around(n, [self.width, self.height], reach)
    }

    /// Rays of about a thousand of the pixels, spread over all.
    pub fn some_rays(&self) -> impl Iterator<Item = Ray> {
        let lens = self.lens();
        self.some(1000).filter_map(move |number| {
            let (origin, direction, _) = lens(number, [0.5; 2])?;
            Some(Ray { origin, direction })
        })
    }

    /// What a lens of this diameter blurs, focused at the length of `-vd`.
    pub fn blur(&self, diameter: f64) -> Option<Blur> {
        let (axes, flat) = self.camera.axes();
        (diameter > 0.0).then(|| Blur { diameter, focus: self.camera.focus(), axes, flat })
    }

    /// The rays of the pixels, numbered row by row from the top, each row from the left.
    pub fn lens(&self) -> impl Fn(usize, [f64; 2]) -> Option<(Vec3, Vec3, f64)> + Sync {
        |number, at| {
            let [u, v] = self.filter.place(at);
            let (x, y) = ((number % self.width) as f64, (number / self.width) as f64);
            self.camera.ray((x + u) / self.width as f64, 1.0 - (y + v) / self.height as f64)
        }
    }
}

/// The numbers of the pixels at most `reach` columns and rows from one in a picture so wide and high, and its own.
fn around(n: usize, [width, height]: [usize; 2], reach: usize) -> impl Iterator<Item = usize> {
    let near = |at: usize, most: usize| at.saturating_sub(reach)..(at + reach + 1).min(most);
    let columns = near(n % width, width);
    near(n / width, height).flat_map(move |row| columns.clone().map(move |column| row * width + column))
}

/// A picture in the making, and its error.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Pixels in the order of their numbers.
    pub pixels: Vec<Pixel>,
    /// Its error.
    noise: Noise,
}

impl Rendering {
    /// A picture of these pixels.
    fn of(pixels: Vec<Pixel>) -> Self {
        let noise = noise(&pixels);
        Self { pixels, noise }
    }

    /// Estimated relative standard error: the root mean square, over the pixels that show a surface, of the standard error of their
    /// luminance, divided by the mean luminance of those pixels. 0 for a picture without surfaces.
    pub fn noise(&self) -> f64 {
        self.noise.error
    }

    /// Samples of a pixel, on the average.
    pub fn samples(&self) -> f64 {
        self.pixels.iter().map(|p| p.samples() as f64).sum::<f64>() / self.pixels.len().max(1) as f64
    }

    /// The estimated variance of the mean of each pixel, of each channel, where a row has `width` of them. Infinite where there are fewer than two samples.
    pub fn variances(&self, width: usize) -> Vec<Rgb> {
        variance::variances(&self.pixels, width)
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
    /// How many of them are in a row.
    pub width: usize,
    /// The rays of each.
    pub lens: Lens<'a>,
    /// Whether all samples of a pixel are of its centre.
    pub centred: bool,
    /// What blurs things out of focus.
    pub blur: Option<Blur>,
    /// When it is good enough.
    pub budget: Budget,
    /// The index of each pixel's first sample; 0 unless a budget of samples is only a part of all.
    pub first: u32,
    /// Fixes every random choice.
    pub seed: u64,
}

/// Renders until the budget is spent, or `stop` says so; then the picture so far is the result. `show` is shown it after each round.
pub fn render(task: &Task, stop: &(dyn Fn() -> bool + Sync), show: &mut dyn FnMut(&Rendering)) -> Rendering {
    let start = Instant::now();
    let mut rendering = Rendering::of(vec![Pixel::from(task.first); task.count]);
    // So many pixels are finished, and made a picture of, in about the time it takes to begin them (measured: 1 and 4 million, in 0.17 and 0.7 s).
    let rest = start.elapsed();
    let suns = Suns::of(task);
    let over = || stop() || matches!(task.budget, Budget::Time(time) if start.elapsed() + rest >= time);
    let fixed = if let Budget::Samples(samples) = task.budget { Some(samples) } else { None };
    let mut round = |rendering: &mut Rendering, wanted: Wanted| {
        let least = |number| if fixed.is_none() && suns.shows(number) { task.among_first(SUN) } else { [0; SETS] };
        let wanted = |number| {
            let (wanted, least) = (wanted(number), least(number));
            std::array::from_fn(|set| wanted[set].max(least[set]))
        };
        task.round(&mut rendering.pixels, &suns, &wanted, &over);
        rendering.noise = noise(&rendering.pixels);
        show(rendering);
        !over() && rendering.pixels.iter().any(|p| !p.exact)
    };

    // Should there be no time for every pixel, a coarser picture is better than a part of one, or none.
    let coarse = |pixels: &mut [Pixel], step: usize, over: &(dyn Fn() -> bool + Sync)| {
        task.round(pixels, &suns, &|number| task.among_first(task.is_on_grid(number, step) as u32), over);
    };
    coarse(&mut rendering.pixels, COARSE[0], stop);
    COARSE[1..].iter().for_each(|&step| coarse(&mut rendering.pixels, step, &over));
    let good = |rendering: &Rendering| matches!(task.budget, Budget::Error(error) if reached(&rendering.noise, error));
    let uniform = fixed.unwrap_or(PILOT);
    let mut samples = 1;
    while round(&mut rendering, &|_| task.among_first(samples)) && samples < uniform && !(samples >= FEWEST && good(&rendering)) {
        // Only an error is first known at FEWEST; where time may end in any round, pixels never differ by more than twice.
        let leaps = matches!(task.budget, Budget::Error(_)) && samples < FEWEST;
        samples = if leaps { FEWEST } else { samples.saturating_mul(2).min(uniform) };
    }
    if fixed.is_none() && samples == PILOT {
        let shares = shares(&rendering.pixels, task.width);
        let mut level = PILOT as f64;
        while !good(&rendering) && level < 8.0 * MOST as f64 {
            level = if let Budget::Error(error) = task.budget { next_level(&rendering, level, error) } else { 1.25 * level };
            if !round(&mut rendering, &|number| wanted(&shares[number], level, number)) {
                break;
            }
        }
    }
    task.fill(&mut rendering.pixels);
    rendering
}

/// How many samples of each sequence are wanted of a pixel.
type Wanted<'a> = &'a (dyn Fn(usize) -> [u32; SETS] + Sync);

/// Steps of the grids of pixels that come before all the others.
const COARSE: [usize; 3] = [8, 4, 2];

/// About how many samples are taken before it is asked whether time is over.
const AT_ONCE: usize = 64;

/// Pixels that a thread takes at a time.
const CHUNK: usize = 64;

/// A lens that is sharp at one distance only.
#[derive(Clone, Copy, Debug)]
pub struct Blur {
    /// Diameter of the lens, in the scene's unit of length.
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

/// A sample to be taken.
struct Sample {
    /// Of which pixel of some.
    i: usize,
    /// Of which sequence.
    set: usize,
    /// Its ray, as far as it goes, and what is left of its random numbers; `None` outside the view.
    sight: Option<((Ray, f64), Sampler)>,
    /// How much it counts.
    weight: f64,
}

impl<'a> Task<'a> {
    /// All pixels of a film, whose lens is `lens`, seen sharply.
    pub fn new(world: &'a World, rules: &'a Rules, film: &Film, lens: Lens<'a>, budget: Budget, seed: u64) -> Self {
        let (count, centred) = (film.width * film.height, film.filter.is_point());
        Self { world, rules, count, width: film.width, lens, centred, blur: None, budget, first: 0, seed }
    }

    /// A sample of pixel `i` of some, which has this number.
    fn sample(&self, suns: &Suns, number: usize, i: usize, set: usize, index: u32) -> Sample {
        let mut sampler = Sampler::new(self.seed, number as u64, set as u32, index);
        let (at, weight) = if self.centred { ([0.5; 2], 1.0) } else { suns.place(number, sampler.pair()) };
        let sight = (self.lens)(number, at).map(|(mut origin, mut direction, limit)| {
            if let Some(blur) = &self.blur {
                (origin, direction) = blur.bend(origin, direction, sampler.pair());
            }
            ((Ray { origin, direction }, limit), sampler)
        });
        Sample { i, set, sight, weight }
    }

    /// Whether all samples of a pixel have the same ray.
    fn fixed(&self) -> bool {
        self.centred && self.blur.is_none()
    }

    /// Takes samples of each pixel until it has as many as are wanted, or it is all over.
    fn round(&self, pixels: &mut [Pixel], suns: &Suns, wanted: Wanted, over: &(dyn Fn() -> bool + Sync)) {
        pixels.par_chunks_mut(CHUNK).enumerate().with_max_len(1).for_each(|(chunk, pixels)| {
            let mut integrator = Integrator::new(self.world, self.rules);
            let mut samples = Vec::new();
            while !over() && self.gather(chunk * CHUNK, pixels, suns, wanted, &mut samples) {
                self.take(&mut integrator, pixels, &mut samples);
            }
        });
    }

    /// Gathers some samples that are wanted of pixels, whose numbers begin with `first`; whether there are any.
    fn gather(&self, first: usize, pixels: &[Pixel], suns: &Suns, wanted: Wanted, samples: &mut Vec<Sample>) -> bool {
        for (i, pixel) in pixels.iter().enumerate().filter(|(_, pixel)| !pixel.exact) {
            let number = first + i;
            let (counts, wanted) = (pixel.counts(), wanted(number));
            // Where all its rays are the same, the first says whether a pixel needs others.
            let most = if self.fixed() && pixel.samples() == 0 { 1 } else { AT_ONCE };
            let missing = (0..SETS).flat_map(|set| (0..wanted[set].saturating_sub(counts[set])).map(move |n| (set, pixel.next(set) + n)));
            samples.extend(missing.take(most).map(|(set, index)| self.sample(suns, number, i, set, index)));
            if samples.len() >= AT_ONCE {
                break;
            }
        }
        !samples.is_empty()
    }

    /// Takes samples of pixels: the rays of all of them find together what they meet first.
    fn take(&self, integrator: &mut Integrator<Rgb>, pixels: &mut [Pixel], samples: &mut Vec<Sample>) {
        let mut hits = Vec::with_capacity(samples.len());
        let sights = samples.iter().filter_map(|sample| sample.sight.as_ref());
        self.world.nearest_each(sights.map(|((ray, limit), _)| (ray, *limit)), |_, hit| hits.push(hit));
        let mut hits = hits.iter();
        for Sample { i, set, sight, weight } in samples.drain(..) {
            let pixel = &mut pixels[i];
            let (mut light, mut random) = (Rgb::ZERO, false);
            if let Some(((ray, limit), sampler)) = sight {
                let mut transport = Radiance { rules: self.rules, sum: Rgb::ZERO };
                let outcome = integrator.trace_on(&mut transport, ray, limit, hits.next().and_then(Option::as_ref), sampler);
                (light, random) = (transport.sum, outcome.random);
                pixel.surface |= outcome.surface;
            }
            pixel.add(set, light * weight);
            pixel.exact = !random && self.fixed();
        }
    }

    /// How many samples of each sequence are among the first of this task.
    fn among_first(&self, samples: u32) -> [u32; SETS] {
        let (before, end) = (dealt(self.first), dealt(self.first + samples));
        std::array::from_fn(|set| end[set] - before[set])
    }

    /// Whether a pixel is on a grid of every `step`-th row and column.
    fn is_on_grid(&self, number: usize, step: usize) -> bool {
        (number % self.width).is_multiple_of(step) && (number / self.width).is_multiple_of(step)
    }

    /// Shows in a pixel that there was no time for the pixel of the finest grid that there was time for.
    fn fill(&self, pixels: &mut [Pixel]) {
        for number in 0..pixels.len() {
            if pixels[number].samples() == 0 {
                let (x, y) = (number % self.width, number / self.width);
                let places = COARSE.iter().rev().map(|step| (y - y % step) * self.width + x - x % step);
                if let Some(near) = places.into_iter().find(|&place| pixels[place].samples() > 0) {
                    pixels[number] = pixels[near].clone();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_pixels_are_of_all_rows_and_columns() {
        for (width, height) in [(400, 300), (1001, 1000), (40, 300), (300, 7)] {
            let film = Film::new(&View::default(), width, height, 0.0).unwrap();
            let some: Vec<[usize; 2]> = film.some(300).map(|n| [n % width, n / width]).collect();
            assert_eq!(some.len(), 300);
            for (axis, size) in [width, height].into_iter().enumerate() {
                for tenth in 0..10.min(size) {
                    let parts = 10.min(size);
                    let count = some.iter().filter(|place| place[axis] * parts / size == tenth).count();
                    assert!((300 / parts * 4 / 5..=300 / parts * 6 / 5 + 1).contains(&count), "{width} x {height}: {count} in {tenth}");
                }
            }
        }
        let film = Film::new(&View::default(), 20, 10, 0.0).unwrap();
        assert!(film.some(300).eq(0..200));
    }
}
