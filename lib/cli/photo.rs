//! A photograph, the scene it was taken in, and what is unknown there, from what was typed.

mod direct;

pub use direct::Direct;

use super::remarks::{elsewhere, of_rendering, remarks};
use super::stream::input;
use super::{Console, Disk, Outcome, scene};
use crate::args::anneal::{Arguments, Photo as PhotoOptions, Sharpness};
use crate::args::rtrace::Light;
use crate::color::Rgb;
use crate::error::{Error, Result};
use crate::expand::{Flat, expand};
use crate::integrator::survey;
use crate::metric::{self, Named};
use crate::picture::{Header, Picture, shrunk};
use crate::rad::{Class, Document, Number, Primitive};
use crate::recover::around::{Around, otherwise_around, otherwise_there};
use crate::recover::{Evidence, Recovery, cut_out, dead, inside_out, otherwise, saturated};
use crate::render::{Film, Filter};
use crate::report::{Setting, Views};
use crate::rules::Rules;
use crate::rules::rendered::{Reckoning, Typed};
use crate::scene::{MaterialId, Reading, Scene};
use crate::unknown::Unknown;
use crate::view::View;
use crate::world::World;
use std::collections::{BTreeSet, HashSet};
use std::f64::consts::PI;
use std::sync::Arc;

/// A photograph and all that is known of it.
pub struct Photo<'a> {
    unknown: Unknown,
    flat: Flat,
    disk: Disk<'a>,
    reading: Reading,
    /// The place of the unknown material in the description.
    place: usize,
    material: MaterialId,
    rules: Rules,
    world: World,
    film: Film,
    target: Picture,
    steps: Vec<[f32; 3]>,
    mask: Option<Vec<f32>>,
    alone: bool,
    blurred: bool,
    seed: u64,
    digest: u64,
    remarks: Vec<String>,
}

/// The most pixels in a row or column of a picture that is predicted, and of one on a page.
const PREDICTED: usize = 160;
const SHOWN: usize = 800;

impl<'a> Photo<'a> {
    /// The photograph `target` of the scene that the arguments name, with the unknown in it; without one, what could be photographed there.
    pub fn new(unknown: &Unknown, target: Option<&str>, arguments: &Arguments, console: &'a Console) -> Outcome<Self> {
        let photo = &arguments.photo;
        let disk = Disk::new(arguments.scene_options.commands, console);
        let read = |name: &str| -> Result<(String, Picture)> {
            let (name, bytes) = input(name)?;
            disk.count(&name, &bytes);
            Ok((name.clone(), Picture::read(&bytes, &name)?))
        };
        let taken = target.map(read).transpose()?;
        let view = view_of(taken.as_ref(), photo, console)?;
        let film = film_of(taken.as_ref(), &view, photo)?;
        let light = &arguments.light;
        let mut rules = light.rules(&|file| scene::list(&disk, file))?;
        let reckoning = Reckoning::of(trail(taken.as_ref()));
        let typed = typed(light, &rules);
        if let Some(reckoning) = &reckoning {
            rules = reckoning.taken_into(rules, typed);
        }
        disk.count("the view", view.header_line().as_bytes());
        let (name, target) = match taken {
            Some(taken) => taken,
            None => (String::new(), Picture::new(film.width, film.height, Header::default())?),
        };
        let mut said = remarks(&name, &target, &film);
        said.extend(reckoning.as_ref().and_then(|reckoning| reckoning.bounces_otherwise(&rules)));
        let steps = target.steps();
        let target = target.into_radiance();
        let mask = photo.mask.as_deref().map(read).transpose()?;
        let mask = mask.map(|(mask_name, mask)| {
            metric::weights(Named { name: &mask_name, picture: &mask.into_radiance() }, Named { name: &name, picture: &target })
        });

        let mut documents = vec![unknown.source().clone()];
        documents.extend(scene::documents(&photo.scene, &disk)?);
        documents.iter().for_each(|document| disk.count(&document.source.name, &document.bytes()));
        let mut flat = expand(documents, &disk)?;
        let place = placed(&mut flat, unknown)?;
        let reading = Reading { unknown: Some(unknown.material().name.clone()), ..scene::reading(&arguments.reading, &disk)? };
        let scene = scene::built(&flat, &disk, &reading, &arguments.light, console)?;
        let material = scene.material(&flat.primitives[place]);
        let material = material.ok_or_else(|| {
            unknown
                .material()
                .error("no surface of the scene is made of it; give the object's file, which names it, too: --scene OBJECT.rad")
        })?;
        if rules.ambient_value == Rgb::ZERO && !scene.materials.iter().any(|named| named.material.emits()) {
            let remedy = "give --scene the file with the lamps or the sky too (or -av, light from everywhere)";
            return Err(Error::new(format!("the scene has no light, so that every rendering is black: {remedy}")).into());
        }
        let world = surveyed(scene, &rules, material, &film)?;
        said.extend(of_rendering(&target, unknown, light, world.lamps().len()));
        said.iter().for_each(|remark| console.warn(remark));
        let mirrors = typed.mirrors || !world.lamps().iter().any(|lamp| lamp.relay.is_some());
        let dark = world.lamps().is_empty();
        let typed = Typed { jitter: typed.jitter || dark, division: typed.division || dark, mirrors, ..typed };
        reckoning.and_then(|reckoning| reckoning.note(&name, &rules, typed)).iter().for_each(|note| console.note(note));
        let photographed = !name.is_empty();
        let mut photo = Self {
            digest: disk.digest(),
            unknown: unknown.clone(),
            flat,
            disk,
            reading,
            place,
            material,
            rules,
            world,
            film,
            target,
            steps,
            mask: mask.transpose()?,
            alone: false,
            blurred: photo.filter == Some(Sharpness::Unknown),
            seed: arguments.common.seed,
            remarks: said,
        };
        photo.alone = photographed && cut_out::alone(&photo.evidence(), material, photo.seed);
        if photo.alone {
            console.note(&format!(
                "{name} is black around `{}`, where the scene is not, as if cut out: only pixels that it fills count",
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
        surveyed(Scene::new(flat, &self.disk, &self.reading)?, &self.rules, self.material, &self.film)
    }

    /// What there is to go by, but for [`Self::otherwise`].
    pub fn evidence(&self) -> Evidence<'_> {
        Evidence {
            world: &self.world,
            otherwise: None,
            rules: &self.rules,
            film: &self.film,
            target: &self.target,
            steps: Some(&self.steps),
            mask: self.mask.as_deref(),
            alone: self.alone,
            blurred: self.blurred,
        }
    }

    /// A number that any change of the files that it was made of changes.
    pub fn digest(&self) -> u64 {
        self.digest
    }

    /// What its file says of itself that does not go with what was typed, as was said when it was read.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Its columns.
    pub fn width(&self) -> usize {
        self.film.width
    }

    /// What is unknown in it.
    pub fn unknown(&self) -> &Unknown {
        &self.unknown
    }

    /// The scene, for any numbers of the unknown.
    fn setting(&self) -> Setting<'_> {
        Setting { flat: &self.flat, place: self.place, rules: &self.rules, resolve: &self.disk, reading: &self.reading, seed: self.seed }
    }

    /// The world with the unknown as it was found.
    fn as_found(&self, found: &Recovery) -> Result<World> {
        self.setting().world(&self.unknown.reals(&found.values))
    }

    /// What there is to see when the parameters have these values.
    pub fn views(&self, values: &[f64]) -> Result<Views> {
        let (setting, reals) = (self.setting(), self.unknown.reals(values));
        let film = self.film.at_most(SHOWN);
        let (width, height) = (film.width, film.height);
        let target = Picture {
            width,
            height,
            header: self.target.header.clone(),
            pixels: shrunk(&self.target.pixels, self.film.width, width, height),
        };
        let mask = self.mask.as_ref().map(|mask| {
            let mask: Vec<[f32; 1]> = mask.iter().map(|&m| [m]).collect();
            shrunk(&mask, self.film.width, width, height).into_iter().flatten().collect::<Vec<f32>>()
        });
        let evidence = Evidence { film: &film, target: &target, mask: mask.as_deref(), ..self.evidence() };
        // What is thin may fill no pixel of that size: those are shown then that its own are in.
        let pixels = evidence.pixels(&self.unknown, self.material).or_else(|_| {
            let own = self.evidence().enough_pixels(&self.unknown, self.material)?;
            let scaled = |at: usize, from: usize, to: usize| at * to / from;
            let shown =
                |n: usize| scaled(n / self.width(), self.film.height, height) * width + scaled(n % self.width(), self.width(), width);
            Ok::<_, Error>(own.into_iter().map(shown).collect::<BTreeSet<usize>>().into_iter().collect())
        })?;
        let exposures = self.unknown.exposures(values);
        let mut rendering = setting.picture(&setting.world(&reals)?, &self.rules, &film, None);
        rendering.pixels.iter_mut().for_each(|p| (0..3).for_each(|c| p[c] *= exposures[c] as f32));
        let mut counts = vec![0.0; target.pixels.len()];
        pixels.iter().for_each(|&n| counts[n] = mask.as_ref().map_or(1.0, |mask| mask[n]));
        let there = setting.in_its_place(&reals, &self.world, self.material, &film, &pixels)?;
        Ok(Views { rendering, counts, lamp: setting.under_a_lamp(&reals)?, there, target })
    }

    /// How the picture is otherwise around the unknown than the scene, where that is what was found: it may light what is there.
    pub fn otherwise_around(&self, found: &Recovery) -> Result<Option<Around>> {
        let exposures = self.unknown.seeks_exposure().then(|| self.unknown.exposures(&found.values));
        let by = |world: &World| otherwise_around(&self.evidence(), world, exposures, self.material, self.seed);
        // Mostly nothing is to be said by what is there already.
        by(&self.world).map_or(Ok(None), |_| Ok(by(&self.as_found(found)?)))
    }

    /// What is to be said if the unknown is otherwise in the picture than as it was found by the few of its pixels that there was time for.
    pub fn otherwise_there(&self, found: &Recovery) -> Result<Option<String>> {
        let world = self.as_found(found)?;
        Ok(otherwise_there(&self.evidence(), &world, self.unknown.exposures(&found.values), self.material, self.seed))
    }

    /// What is to be said where nothing explains the picture, if the unknown is inside out.
    pub fn inside_out(&self, found: &Recovery) -> Option<String> {
        if found.explained() { None } else { inside_out::said(&self.evidence(), &self.unknown, self.material) }
    }

    /// The pixels that are black where by what was found there is light.
    pub fn dead(&self, found: &Recovery) -> Result<Vec<usize>> {
        let evidence = self.evidence();
        // Mostly there are none.
        if !(0..self.target.pixels.len()).any(|n| dead::black(&evidence, n)) {
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
        let before = self.mask.clone();
        for &n in pixels {
            let mask = self.mask.get_or_insert_with(|| vec![1.0; self.target.pixels.len()]);
            mask.get_mut(n).into_iter().for_each(|counts| *counts = 0.0);
        }
        before
    }

    /// Takes each pixel to count so much.
    pub fn count(&mut self, mask: Option<Vec<f32>>) {
        self.mask = mask;
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
        let ([forward, right, up], _) = self.film.camera.axes();
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

    /// Which material of the scene is the unknown.
    pub fn material(&self) -> MaterialId {
        self.material
    }

    /// Takes its pixels to be blurred as they were found to be, where that was sought.
    pub fn blur(&mut self, found: &Recovery) {
        if let Some(blur) = found.sharpness().filter(|blur| blur.taken != self.film.filter.variance()) {
            self.film.filter = Filter::blurring(blur.taken);
        }
    }

    /// Puts another unknown into the place of its own.
    pub fn take_for(&mut self, unknown: Unknown) -> Result<()> {
        self.flat.primitives[self.place].clone_from(unknown.material());
        self.unknown = unknown;
        self.world = self.surveyed(&self.flat)?;
        Ok(())
    }
}

/// A picture that was read, and what messages call it.
type Taken = (String, Picture);

/// What the header of a picture says, line by line.
fn trail(taken: Option<&Taken>) -> impl Iterator<Item = &str> + Clone {
    taken.into_iter().flat_map(|(_, target)| target.header.lines.iter().map(String::as_str))
}

/// What was typed of how light is reckoned with.
fn typed(light: &Light, rules: &Rules) -> Typed {
    Typed {
        bounces: light.ab.is_some() || rules.ambient_bounces == 0,
        ambient: light.av.is_some(),
        jitter: light.dj.is_some(),
        division: light.ds.is_some(),
        mirrors: light.dr.is_some(),
        medium: light.me.is_some(),
        backs: light.bv.is_some(),
        lobe: light.ward.is_some(),
        fresnel: light.fresnel_offset.is_some(),
    }
}

/// The view that was asked for, else the picture's own.
fn view_of(taken: Option<&Taken>, asked: &PhotoOptions, console: &Console) -> Outcome<View> {
    let own = View::said(trail(taken));
    if asked.view.words.is_empty() {
        let picture = taken.map_or_else(String::new, |(name, _)| format!(", and {name} does not say its own"));
        return Ok(own.ok_or_else(|| Error::new(format!("no view{picture}; give the view it is taken from with -vf FILE")))?);
    }
    let view = scene::view(&asked.view)?;
    if let (Some(own), Some((name, _))) = (own, taken) {
        elsewhere(name, &own, &view).iter().for_each(|remark| console.warn(remark));
    }
    Ok(view)
}

/// The film of the picture, or of one of the size that was asked for, with the filter that was, else with the picture's own.
fn film_of(taken: Option<&Taken>, view: &View, asked: &PhotoOptions) -> Result<Film> {
    let film = match taken {
        Some((_, target)) => Film::new(view, target.width, target.height, 0.0)?,
        None => Film::new(view, asked.x.unwrap_or(PREDICTED), asked.y.unwrap_or(PREDICTED), 1.0)?,
    };
    Ok(match (asked.filter, Filter::said(trail(taken))) {
        (Some(Sharpness::Radius(radius)), _) => film.through(Filter::gaussian(radius, None)),
        (_, Some(said)) => film.through(said),
        _ => film,
    })
}

/// The place of the unknown in a description, whose own definition of it does not count.
fn placed(flat: &mut Flat, unknown: &Unknown) -> Result<usize> {
    let material = unknown.material();
    let is_it = |p: &Primitive| p.name == material.name && p.type_of().is_some_and(|t| t.class == Class::Material);
    flat.primitives.retain(|p| !is_it(p) || Arc::ptr_eq(&p.span.source, &unknown.source().source));
    let place = flat.primitives.iter().rposition(is_it).ok_or_else(|| material.error("it is not in the scene"))?;
    if let Some(other) = undefined_instead(flat, &material.name) {
        let remedy = "call the material so if that is what is unknown (START.rad stands alone, each file of the scene behind a --scene)";
        let problem = format!("nothing in the scene is made of it, and `{other}`, which something is made of, is not defined: {remedy}");
        return Err(material.error(problem));
    }
    let modifier = &material.modifier;
    let defined = |of: &[Primitive]| of.iter().any(|p| p.name == *modifier);
    if !defined(&flat.primitives[..place]) && defined(&flat.primitives[place..]) {
        let problem =
            format!("the scene defines `{modifier}`, but what is unknown stands before it: put `{modifier}` into this file, above");
        return Err(material.modifier_error(problem));
    }
    Ok(place)
}

/// A modifier that a description has and does not define, if nothing there has `name` for its own.
fn undefined_instead<'f>(flat: &'f Flat, name: &str) -> Option<&'f str> {
    let uses = |p: &Primitive| p.modifier == name || p.strings.iter().any(|word| word == name);
    if flat.primitives.iter().any(uses) {
        return None;
    }
    let defined: HashSet<&str> = flat.primitives.iter().map(|p| p.name.as_str()).chain(["void"]).collect();
    flat.primitives.iter().map(|p| p.modifier.as_str()).find(|modifier| !defined.contains(modifier))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::resolve::Files;

    #[test]
    fn a_material_of_another_name_than_the_scene_has_is_told() {
        let said = |scene: &str| {
            let documents = ["void plastic it 0 0 5 .5 .5 .5 0 0", scene].map(|text| Document::parse(Source::new("a.rad", text)).unwrap());
            let flat = expand(documents.into(), &Files::of([])).unwrap();
            undefined_instead(&flat, "it").map(String::from)
        };
        assert_eq!(said("finish sphere s 0 0 4 0 0 0 1"), Some("finish".into()));
        assert_eq!(said("it sphere s 0 0 4 0 0 0 1\nfinish sphere s 0 0 4 0 0 0 1"), None);
        assert_eq!(said("void mirror pane 1 it 0 3 .9 .9 .9\nvoid sphere s 0 0 4 0 0 0 1"), None);
        assert_eq!(said("void alias finish void\nfinish sphere s 0 0 4 0 0 0 1"), None);
    }
}
