//! A photograph, the scene it was taken in, and what is unknown there, from what was typed.

mod direct;
mod setup;
mod shot;

pub use direct::Direct;

use super::remarks::of_rendering;
use super::{Console, Disk, Outcome};
use crate::args::anneal::{Arguments, Sharpness};
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::expand::Flat;
use crate::integrator::survey;
use crate::picture::{Picture, shrunk};
use crate::rad::{Document, Number};
use crate::recover::around::{Around, GUESSED, otherwise_around, otherwise_there};
use crate::recover::{Evidence, Recovery, begun, cut_out, dead, inside_out, otherwise, saturated};
use crate::render::{Film, Filter};
use crate::report::{Setting, Views};
use crate::rules::Rules;
use crate::rules::rendered::guesses_bounces;
use crate::scene::{MaterialId, Reading, Scene};
use crate::unknown::Unknown;
use crate::world::World;
use setup::Setup;
use shot::Shot;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// A photograph and all that is known of it.
pub struct Photo<'a> {
    unknown: Unknown,
    flat: Flat,
    disk: Disk<'a>,
    reading: Reading,
    /// The place of the unknown material in the description.
    place: usize,
    material: MaterialId,
    world: World,
    shot: Shot,
    alone: bool,
    blurred: bool,
    seed: u64,
    digest: u64,
}

/// The most pixels in a row or column of a picture on a page.
const SHOWN: usize = 800;

impl<'a> Photo<'a> {
    /// The photograph `target` of the scene that the arguments name, with the unknown in it; without one, what could be photographed there.
    pub fn new(unknown: &Unknown, target: Option<&str>, arguments: &Arguments, console: &'a Console) -> Outcome<Self> {
        let disk = Disk::new(arguments.scene_options.commands, console);
        let mut shot = Shot::new(target, arguments, &disk, console)?;
        let Setup { flat, place, reading, scene, material } = Setup::new(unknown, arguments, &disk, console)?;
        disk.spares(arguments.pages().chain([arguments.common.output()]))?;
        if shot.rules.ambient_value == Rgb::ZERO && !scene.materials.iter().any(|named| named.material.emits()) {
            let remedy = "give --scene the file with the lamps or the sky too (or -av, light from everywhere)";
            return Err(Error::new(format!("the scene has no light, so that every rendering is black: {remedy}")).into());
        }
        let world = surveyed(scene, &shot.rules, material, &shot.film)?;
        shot.remarks.extend(of_rendering(&shot.target, unknown, &arguments.light, world.lamps().len()));
        shot.remarks.iter().for_each(|remark| console.warn(remark));
        shot.note(&world).iter().for_each(|note| console.note(note));
        let mut photo = Self {
            digest: disk.digest(),
            unknown: unknown.clone(),
            flat,
            disk,
            reading,
            place,
            material,
            world,
            shot,
            alone: false,
            blurred: arguments.photo.filter == Some(Sharpness::Unknown),
            seed: arguments.common.seed,
        };
        photo.alone = photo.shot.taken() && cut_out::alone(&photo.evidence(), material, photo.seed);
        if photo.alone {
            console.note(&format!(
                "{} is black around `{}`, where the scene is not, as if cut out: only pixels that it fills count",
                photo.shot.name,
                unknown.material().name
            ));
        }
        Ok(photo)
    }

    /// The world with the unknown as it may be otherwise than it starts, which a recovery goes by too ([`Evidence::otherwise`]).
    pub fn otherwise(&self) -> Result<Option<World>> {
        otherwise(&self.unknown).map(|reals| self.surveyed(&self.setting().with(&reals))).transpose()
    }

    /// The world of a description like its own, ready for its picture.
    fn surveyed(&self, flat: &Flat) -> Result<World> {
        surveyed(Scene::new(flat, &self.disk, &self.reading)?, &self.shot.rules, self.material, &self.shot.film)
    }

    /// What there is to go by, but for [`Self::otherwise`].
    pub fn evidence(&self) -> Evidence<'_> {
        Evidence {
            world: &self.world,
            otherwise: None,
            rules: &self.shot.rules,
            film: &self.shot.film,
            target: &self.shot.target,
            steps: Some(&self.shot.steps),
            mask: self.shot.mask.as_deref(),
            alone: self.alone,
            blurred: self.blurred,
        }
    }

    /// Counts START.rad as it is, where the unknown was taken for another type.
    pub fn counting(&mut self, start: &Document) {
        self.disk.count(&start.source.name, &start.bytes());
        self.digest = self.disk.digest();
    }

    /// A number that any change of the files that it was made of changes.
    pub fn digest(&self) -> u64 {
        self.digest
    }

    /// What its file says of itself that does not go with what was typed, as was said when it was read.
    pub fn remarks(&self) -> &[String] {
        &self.shot.remarks
    }

    /// Its columns.
    pub fn width(&self) -> usize {
        self.shot.film.width
    }

    /// What is unknown in it.
    pub fn unknown(&self) -> &Unknown {
        &self.unknown
    }

    /// The scene, for any numbers of the unknown.
    fn setting(&self) -> Setting<'_> {
        Setting {
            flat: &self.flat,
            place: self.place,
            rules: &self.shot.rules,
            resolve: &self.disk,
            reading: &self.reading,
            seed: self.seed,
        }
    }

    /// The world with the unknown as it was found.
    fn as_found(&self, found: &Recovery) -> Result<World> {
        self.setting().world(&self.unknown.reals(&found.values))
    }

    /// What there is to see when the parameters have these values.
    pub fn views(&self, values: &[f64]) -> Result<Views> {
        let (setting, reals) = (self.setting(), self.unknown.reals(values));
        let film = self.shot.film.at_most(SHOWN);
        let (width, height) = (film.width, film.height);
        let target = Picture {
            width,
            height,
            header: self.shot.target.header.clone(),
            pixels: shrunk(&self.shot.target.pixels, self.shot.film.width, width, height),
        };
        let mask = self.shot.mask.as_ref().map(|mask| {
            let mask: Vec<[f32; 1]> = mask.iter().map(|&m| [m]).collect();
            shrunk(&mask, self.shot.film.width, width, height).into_iter().flatten().collect::<Vec<f32>>()
        });
        let evidence = Evidence { film: &film, target: &target, mask: mask.as_deref(), ..self.evidence() };
        // What is thin may fill no pixel of that size: those are shown then that its own are in.
        let pixels = evidence.pixels(&self.unknown, self.material).or_else(|_| {
            let own = self.evidence().enough_pixels(&self.unknown, self.material)?;
            let scaled = |at: usize, from: usize, to: usize| at * to / from;
            let shown =
                |n: usize| scaled(n / self.width(), self.shot.film.height, height) * width + scaled(n % self.width(), self.width(), width);
            Ok::<_, Error>(own.into_iter().map(shown).collect::<BTreeSet<usize>>().into_iter().collect())
        })?;
        let exposures = self.unknown.exposures(values);
        let mut rendering = setting.picture(&setting.world(&reals)?, &self.shot.rules, &film, None);
        rendering.pixels.iter_mut().for_each(|p| (0..3).for_each(|c| p[c] *= exposures[c] as f32));
        let mut counts = vec![0.0; target.pixels.len()];
        pixels.iter().for_each(|&n| counts[n] = mask.as_ref().map_or(1.0, |mask| mask[n]));
        let there = setting.in_its_place(&reals, &self.world, self.material, &film, &pixels)?;
        Ok(Views { rendering, counts, lamp: setting.under_a_lamp(&reals)?, there, target })
    }

    /// How the picture is otherwise around the unknown than the scene, where that is what was found: it may light what is there.
    pub fn otherwise_around(&self, found: &Recovery) -> Result<Option<Around>> {
        let by = |world: &World| otherwise_around(&self.evidence(), world, &self.unknown, found, self.material, self.seed);
        // Mostly nothing is to be said by what is there already.
        by(&self.world).map_or(Ok(None), |_| Ok(by(&self.as_found(found)?)))
    }

    /// By which part of itself its light may be off as its renderer left it, by its header.
    pub fn guessed(&self) -> f64 {
        if guesses_bounces(self.shot.target.header.trail()) { GUESSED } else { 0.0 }
    }

    /// What is to be said if the unknown is otherwise in the picture than as it was found by the few of its pixels that there was time for.
    pub fn otherwise_there(&self, found: &Recovery) -> Result<Option<String>> {
        let world = self.as_found(found)?;
        Ok(otherwise_there(&self.evidence(), &world, &self.unknown, found, self.material, self.seed))
    }

    /// What is to be said where nothing explains the picture, if the unknown is inside out.
    pub fn inside_out(&self, found: &Recovery) -> Option<String> {
        if found.explained() { None } else { inside_out::said(&self.evidence(), &self.unknown, self.material) }
    }

    /// The pixels that are black where by what was found there is light.
    pub fn dead(&self, found: &Recovery) -> Result<Vec<usize>> {
        let evidence = self.evidence();
        // Mostly there are none.
        if !(0..self.shot.target.pixels.len()).any(|n| dead::black(&evidence, n)) {
            return Ok(vec![]);
        }
        let mut black = evidence.enough_pixels(&self.unknown, self.material)?;
        // Or they are of what is behind it, at an edge.
        black.retain(|&n| dead::black(&evidence, n) && (dead::alone(&evidence, n) || evidence.filled(n, self.material)));
        if black.is_empty() {
            return Ok(black);
        }
        let world = self.as_found(found)?;
        Ok(dead::dead(&evidence, &world, found, black, self.seed))
    }

    /// Leaves pixels out, and says how much each counted before.
    pub fn leave_out(&mut self, pixels: &[usize]) -> Option<Vec<f32>> {
        let before = self.shot.mask.clone();
        for &n in pixels {
            let mask = self.shot.mask.get_or_insert_with(|| vec![1.0; self.shot.target.pixels.len()]);
            mask.get_mut(n).into_iter().for_each(|counts| *counts = 0.0);
        }
        before
    }

    /// Takes each pixel to count so much.
    pub fn count(&mut self, mask: Option<Vec<f32>>) {
        self.shot.mask = mask;
    }

    /// What is to be said of pixels that were left out as they seem saturated, if by what was found most of them should be brighter.
    pub fn saturated(&self, found: &Recovery) -> Result<Option<String>> {
        if found.saturated.is_empty() {
            return Ok(None);
        }
        let world = self.as_found(found)?;
        Ok(saturated::confirmed(&self.evidence(), &world, found, self.unknown.exposures(&found.values), self.seed))
    }

    /// The scene with one more lamp, small and far, over the camera's shoulder, that lights as much as light of `radiance` from all around.
    pub fn with_a_lamp(&self, radiance: f64) -> Result<World> {
        let ([forward, right, up], _) = self.shot.film.camera.axes();
        let to = 0.4 * up - 0.4 * right - forward;
        let solid = 2.0 * PI * (1.0 - (0.5 * LAMP.to_radians()).cos());
        let bright = Number((radiance.max(0.0) * PI / solid).max(f64::MIN_POSITIVE));
        let lamp = format!(
            "void light {ADDED} 0 0 3 {bright} {bright} {bright}\n{ADDED} source {ADDED} 0 0 4 {} {} {} {LAMP}\n",
            to.x, to.y, to.z
        );
        let mut flat = self.flat.clone();
        flat.primitives.extend(Document::read("the lamp", lamp.into_bytes())?.primitives().cloned());
        self.surveyed(&flat)
    }

    /// What it is seen in.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Which material of the scene is the unknown.
    pub fn material(&self) -> MaterialId {
        self.material
    }

    /// Takes its pixels to be blurred as they were found to be, where that was sought.
    pub fn blur(&mut self, found: &Recovery) {
        if let Some(blur) = found.sharpness().filter(|blur| blur.taken != self.shot.film.filter.variance()) {
            self.shot.film.filter = Filter::blurring(blur.taken);
        }
    }

    /// Puts another unknown into the place of its own.
    pub fn take_for(&mut self, unknown: Unknown) -> Result<()> {
        self.flat.primitives[self.place].clone_from(unknown.material());
        self.flat.primitives[self.place].reals = begun(&unknown);
        self.unknown = unknown;
        self.world = self.surveyed(&self.flat)?;
        Ok(())
    }
}

/// The world of a scene with an unknown material, ready for the picture of a film.
fn surveyed(scene: Scene, rules: &Rules, unknown: MaterialId, film: &Film) -> Result<World> {
    let mut world = World::new(scene, rules)?;
    world.unknown = Some(unknown);
    survey(&mut world, film.some_rays(), rules);
    Ok(world)
}

/// What a lamp that is added is called, and its width in degrees.
const ADDED: &str = "predicted_lamp";
const LAMP: f64 = 2.0;
