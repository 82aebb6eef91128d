//! The picture that was taken: what its file holds and says, from where it was taken, and how its light is reckoned with.

use crate::args::anneal::{Arguments, Photo as PhotoOptions, Sharpness};
use crate::args::rtrace::Light;
use crate::cli::remarks::{elsewhere, remarks};
use crate::cli::stream::input;
use crate::cli::{Console, Disk, Outcome, scene};
use crate::error::{Error, Result};
use crate::metric::{self, Named};
use crate::picture::{Header, Picture};
use crate::render::{Film, Filter};
use crate::rules::Rules;
use crate::rules::rendered::{Reckoning, Typed};
use crate::view::View;
use crate::world::World;

/// A picture, or the room for one.
pub struct Shot {
    /// What messages call it; empty where there is none yet.
    pub name: String,
    /// The picture, in radiance; black where there is none yet.
    pub target: Picture,
    /// The distance between each of its values and the next that its file could have held.
    pub steps: Vec<[f32; 3]>,
    /// How much each pixel counts.
    pub mask: Option<Vec<f32>>,
    /// What it was taken on.
    pub film: Film,
    /// The rules of its light.
    pub rules: Rules,
    /// What its file says that does not go with what was typed.
    pub remarks: Vec<String>,
    reckoning: Option<Reckoning>,
    typed: Typed,
}

/// The most pixels in a row or column of a picture that is predicted.
const PREDICTED: usize = 160;

impl Shot {
    /// The picture `target`; without one, room for what could be taken. The disk counts what was read.
    pub fn new(target: Option<&str>, arguments: &Arguments, disk: &Disk, console: &Console) -> Outcome<Self> {
        let (photo, light) = (&arguments.photo, &arguments.light);
        let read = |name: &str| -> Result<Taken> {
            let (name, bytes) = input(name)?;
            disk.count(&name, &bytes);
            Ok((name.clone(), Picture::read(&bytes, &name)?))
        };
        let taken = target.map(read).transpose()?;
        let view = view_of(taken.as_ref(), photo, console)?;
        let film = film_of(taken.as_ref(), &view, photo)?;
        let mut rules = light.rules(&|file| scene::list(disk, file))?;
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
        said.extend(reckoning.as_ref().and_then(|reckoning| reckoning.otherwise(&rules)));
        let steps = target.steps();
        let target = target.into_radiance();
        let mask = photo.mask.as_deref().map(read).transpose()?;
        let mask = mask.map(|(mask_name, mask)| {
            metric::weights(Named { name: &mask_name, picture: &mask.into_radiance() }, Named { name: &name, picture: &target })
        });
        Ok(Self { mask: mask.transpose()?, name, target, steps, film, rules, remarks: said, reckoning, typed })
    }

    /// Whether there is one.
    pub fn taken(&self) -> bool {
        !self.name.is_empty()
    }

    /// What was taken over from its header, as far as that says something of this world.
    pub fn note(&self, world: &World) -> Option<String> {
        let mirrors = self.typed.mirrors || !world.lamps().iter().any(|lamp| lamp.relay.is_some());
        let dark = world.lamps().is_empty();
        let (jitter, division) = (self.typed.jitter || dark, self.typed.division || dark);
        self.reckoning.as_ref()?.note(&self.name, &self.rules, Typed { jitter, division, mirrors, ..self.typed })
    }
}

/// A picture that was read, and what messages call it.
type Taken = (String, Picture);

/// What the header of a picture says, line by line.
fn trail(taken: Option<&Taken>) -> impl Iterator<Item = &str> + Clone {
    taken.into_iter().flat_map(|(_, target)| target.header.trail())
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
        lamps: light.dv.is_some(),
        reflections: light.lr.is_some(),
        sampling: light.ss.is_some(),
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
