//! Pictures of a recovery: the photograph again, and a sphere of what was found.

use crate::color::to_pixel;
use crate::error::{Result, Source};
use crate::expand::Flat;
use crate::geometry::Ray;
use crate::picture::{Header, Picture};
use crate::rad::{Class, Document, Primitive};
use crate::render::{Budget, Film, Task, render};
use crate::resolve::Resolve;
use crate::rules::Rules;
use crate::scene::{MaterialId, Reading, Scene};
use crate::vector::Vec3;
use crate::view::View;
use crate::world::World;

/// A description with an unknown material in it, and the light it is seen in.
pub struct Setting<'a> {
    /// The description.
    pub flat: &'a Flat,
    /// The place of the material among its primitives.
    pub place: usize,
    /// The rules of its light.
    pub rules: &'a Rules,
    /// Who reads files.
    pub resolve: &'a dyn Resolve,
    /// How it is read.
    pub reading: &'a Reading,
    /// Fixes every random choice.
    pub seed: u64,
}

/// What is to be seen on the page.
pub struct Views {
    /// What was photographed, in radiance.
    pub target: Picture,
    /// The same with what was found.
    pub rendering: Picture,
    /// How much each pixel counted.
    pub counts: Vec<f32>,
    /// A sphere of the material under a lamp.
    pub lamp: Picture,
    /// The same where the photographed object was.
    pub there: Picture,
}

/// Samples of a picture in all, and between how many of a pixel.
const SAMPLES: f64 = 1e6;
const EACH: (f64, f64) = (4.0, 256.0);

/// Pixels in a row and in a column of the picture of a sphere, samples of each, and by how much more than the sphere it shows.
const SPHERE: usize = 260;
const SPHERE_SAMPLES: u32 = 32;
const SPHERE_ROOM: f64 = 1.3;

/// A studio: a tiled floor, a lamp at the upper left, light from above all around; the sphere is at the origin.
const STUDIO: &str = "\
void brightfunc tiles 2 if(floor(Px*1.25)+floor(Py*1.25)-2*floor((floor(Px*1.25)+floor(Py*1.25))/2)-.5,.45,1) .
0
0
tiles plastic floor 0 0 5 .55 .55 .55 0 0
floor ring ground 0 0 8 0 0 -1 0 0 1 0 14
void light lamp 0 0 3 20 20 20
lamp sphere lamp 0 0 4 -2.6 -2.4 3.6 .8
void brightfunc above 2 .12+.5*if(Dz,Dz,0) .
0
0
above glow surround 0 0 4 1 1 1 0
surround source sky 0 0 4 0 0 1 360
";

impl Setting<'_> {
    /// The world with these real arguments of the material.
    pub fn world(&self, reals: &[f64]) -> Result<World> {
        self.world_of(self.with(reals), self.rules)
    }

    /// The description with these real arguments of the material.
    pub fn with(&self, reals: &[f64]) -> Flat {
        let mut flat = self.flat.clone();
        flat.primitives[self.place].reals = reals.to_vec();
        flat
    }

    fn world_of(&self, flat: Flat, rules: &Rules) -> Result<World> {
        World::new(Scene::new(&flat, self.resolve, self.reading)?, rules)
    }

    /// A picture of a world.
    pub fn picture(&self, world: &World, rules: &Rules, film: &Film, samples: Option<u32>) -> Picture {
        let count = film.width * film.height;
        let samples = samples.unwrap_or((SAMPLES / count as f64).clamp(EACH.0, EACH.1) as u32);
        let lens = film.lens();
        let task = Task::new(world, rules, film, &lens, Budget::Samples(samples), self.seed);
        let pixels = render(&task, &|| false, &mut |_| {}).pixels;
        let pixels = pixels.iter().map(|p| to_pixel(p.mean())).collect();
        Picture { width: film.width, height: film.height, header: Header::default(), pixels }
    }

    /// A sphere of the material under a lamp: whatever else the scene holds is left out.
    pub fn under_a_lamp(&self, reals: &[f64]) -> Result<Picture> {
        let mut flat = self.with(reals);
        flat.primitives.truncate(self.place + 1);
        flat.primitives.retain(|p| p.type_of().is_none_or(|t| t.class != Class::Surface));
        flat.annotations.clear();
        let name = self.name().to_string();
        flat.primitives.push(sphere(&name, Vec3::ZERO, 1.0)?);
        flat.primitives.extend(parsed(STUDIO)?);
        let rules = Rules { lobe: self.rules.lobe, fresnel_offset: self.rules.fresnel_offset, ..Rules::default() };
        let film = portrait(Vec3::new(0.0, -6.0, 1.6), Vec3::ZERO, 1.0, Vec3::Z)?;
        Ok(self.picture(&self.world_of(flat, &rules)?, &rules, &film, Some(SPHERE_SAMPLES)))
    }

    /// A sphere of the material in the place of what is made of it, which some `pixels` of a film show where it is `shows` in `world`.
    pub fn in_its_place(&self, reals: &[f64], world: &World, shows: MaterialId, film: &Film, pixels: &[usize]) -> Result<Picture> {
        let lens = film.lens();
        let (mut low, mut high, mut eye) = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO);
        for (origin, direction, limit) in pixels.iter().filter_map(|&n| lens(n, [0.5; 2])) {
            let ray = Ray { origin, direction };
            if let Some((Ray { origin: point, .. }, _)) = world.shown(&ray, limit, shows) {
                (low, high, eye) = (low.min(point), high.max(point), origin);
            }
        }
        let mut extents = (high - low).to_array();
        extents.sort_by(f64::total_cmp);
        let (center, radius) = ((low + high) / 2.0, extents[1] / 2.0);
        if !(radius > 0.0 && radius.is_finite()) {
            return self.under_a_lamp(reals);
        }
        let mut flat = self.with(reals);
        // What follows and bears the name is made of nothing.
        let mut nothing = parsed("void brightfunc nothing 2 1 .\n0\n0\n")?.remove(0);
        nothing.name = self.name().into();
        let instead = [sphere(self.name(), center, radius)?, nothing];
        flat.primitives.splice(self.place + 1..self.place + 1, instead);
        let [_, _, up] = film.camera.axes().0;
        let film = portrait(eye, center, radius, up)?;
        Ok(self.picture(&self.world_of(flat, self.rules)?, self.rules, &film, Some(SPHERE_SAMPLES)))
    }

    fn name(&self) -> &str {
        &self.flat.primitives[self.place].name
    }
}

/// A sphere of a material.
fn sphere(material: &str, center: Vec3, radius: f64) -> Result<Primitive> {
    let mut sphere = parsed("void sphere sphere 0 0 4 0 0 0 1")?.remove(0);
    sphere.modifier = material.into();
    sphere.reals = vec![center.x, center.y, center.z, radius];
    Ok(sphere)
}

fn parsed(text: &str) -> Result<Vec<Primitive>> {
    Ok(Document::parse(Source::new("report", text))?.primitives().cloned().collect())
}

/// A film that a sphere fills, seen from `eye`.
fn portrait(eye: Vec3, center: Vec3, radius: f64, up: Vec3) -> Result<Film> {
    let away = center - eye;
    // From inside, or from nearby, it is seen from further away.
    let distance = away.length().max(radius * 2.5);
    let direction = away.try_normalize().unwrap_or(Vec3::Y);
    let angle = 2.0 * (SPHERE_ROOM * (radius / distance).asin()).min(1.4).to_degrees();
    let words = |name: &str, v: Vec3| [name.to_string(), v.x.to_string(), v.y.to_string(), v.z.to_string()];
    let mut view = View::default();
    let up = if up.cross(direction).length() > 1e-3 { up } else { direction.any_orthonormal_vector() };
    let mut line = [words("-vp", center - direction * distance), words("-vd", direction), words("-vu", up)].concat();
    line.extend(["-vh", "-vv"].into_iter().flat_map(|name| [name.to_string(), angle.to_string()]));
    view.apply(&line, &|_| Ok(Vec::new()))?;
    Film::new(&view, SPHERE, SPHERE, 1.0)
}
