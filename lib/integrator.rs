//! The radiance along one ray: paths from the viewer to whatever emits light.
//!
//! A path carries a throughput and hands each emission it meets to a [`Transport`], which says what the two make together: a colour
//! ([`Radiance`]) or a term of the transport basis. Roughness is gathered part by part (diffuse or specular, reflected or transmitted):
//! each part has samples of its own, weighted against those aimed at lamps, at the environment and at pools of light by the balance heuristic
//! (Veach 1997, equation 9.8). Until the first random direction, all directions that a surface scatters into are followed; after that, one.

mod radiance;
mod scatter;
mod survey;
mod unhidden;

pub use radiance::Radiance;
pub use survey::survey;

use crate::accel::Hit;
use crate::bsdf::{Arriving, Bsdf, Delta, Part};
use crate::color::Rgb;
use crate::geometry::Ray;
use crate::material::Inside;
use crate::rules::Rules;
use crate::sampling::Sampler;
use crate::vector::Vec3;
use crate::world::{Clip, Coming, Emission, Emitter, Layer, World};

/// What paths carry, and what becomes of the light they find.
pub trait Transport {
    /// The throughput of a path: what the radiance at its end is multiplied with.
    type Beta: Clone;
    /// Scattering at a point.
    type Surface: Scattering;

    /// The throughput at the viewer.
    fn start(&self) -> Self::Beta;
    /// Multiplies a throughput by a known coefficient.
    fn scale(&self, beta: &mut Self::Beta, by: Rgb);
    /// The largest channel of a throughput: what limits and roulette go by. Must not depend on what is unknown.
    fn size(&self, beta: &Self::Beta) -> f64;
    /// What a layer does at a point.
    fn surface(&self, layer: &Layer, rules: &Rules) -> Self::Surface;
    /// The throughput of light from a direction that was aimed at a light with density `pdf`: `beta` times the sum of the parts of f·|cos θ|,
    /// each weighted against the samples of its own that might have found the light (`counts`, per way to sample it).
    fn aimed(&self, beta: &Self::Beta, surface: &Self::Surface, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> Self::Beta;
    /// The throughput behind the direction that was just drawn from a part in one way, and the density it was drawn with, `count` samples of
    /// each way being expected.
    fn drawn(&self, beta: &Self::Beta, surface: &Self::Surface, wi: Vec3, part: Part, way: usize, count: f64) -> (Self::Beta, f64);
    /// One more direction, its density as in [`Transport::drawn`], and a throughput for its light that vanishes on the average: what the
    /// directions that were drawn from a part, one in each way, left too much or too little of it (a control variate). `None` where none is of use.
    fn control(&self, _beta: &Self::Beta, _surface: &Self::Surface, _part: Part, _count: f64) -> Option<(Self::Beta, Vec3, f64)> {
        None
    }
    /// The throughput of light that reaches one side of the surface from all directions alike, through the diffuse part.
    fn ambient(&self, beta: &Self::Beta, surface: &Self::Surface, side: usize) -> Self::Beta;
    /// The same of light that reaches it straight from the environment.
    fn unhidden(&self, beta: &Self::Beta, surface: &Self::Surface, side: usize) -> Self::Beta {
        self.ambient(beta, surface, side)
    }
    /// The throughput behind a direction that is scattered into alone.
    fn follow(&self, beta: &Self::Beta, surface: &Self::Surface, delta: &Delta) -> Self::Beta;
    /// Dims a throughput by `length` in a medium.
    fn absorb(&self, beta: &mut Self::Beta, medium: &Inside, length: f64);
    /// The extinction of a medium, as far as limits and roulette go by it. Must not depend on what is unknown.
    fn extinction(&self, medium: &Inside) -> Rgb {
        medium.extinction
    }
    /// Takes the light that a path found.
    fn collect(&mut self, beta: &Self::Beta, radiance: Rgb);
    /// Whether it must hear of all rays, those aimed at lights too.
    const WATCHES: bool = false;
    /// Hears of each ray of a path as it is followed.
    fn visit(&mut self, _beta: &mut Self::Beta, _visit: &Visit) {}
    /// Hears of each layer that a ray meets, and what the ray carries there.
    fn meet(&mut self, _beta: &Self::Beta, _layer: &Layer) {}
}

/// A ray on its way, as far as it is known to those who only watch.
pub struct Visit<'a> {
    /// The ray.
    pub ray: &'a Ray,
    /// What it met; `None` if it left the scene.
    pub hit: Option<&'a Hit>,
    /// How far it may go.
    pub limit: f64,
    /// What fills it, as far as is known before what it hits is.
    pub medium: &'a Inside,
    /// RADIANCE's weight of the ray.
    pub weight: f64,
    /// How it came to be.
    pub kind: Kind,
    /// Whether it looks for a light.
    pub shadow: bool,
}

/// How a ray comes from the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It is the viewer's.
    Primary,
    /// Reflected in a single direction.
    Reflected,
    /// Let through, or refracted, in a single direction.
    Transmitted,
    /// Gone on, as nothing was there.
    Passed,
    /// Scattered.
    Scattered,
    /// Aimed at a light.
    Shadow,
}

/// Scattering at a point, as far as the choice of directions goes: a material's own, unless it is unknown. Directions are local.
pub trait Scattering {
    /// The material at the point; for an unknown one, a stand-in with the same frame.
    fn bsdf(&self) -> &Bsdf;

    /// Whether the material is known, so that RADIANCE's single samples of its rough parts can be drawn as RADIANCE draws them.
    fn is_known(&self) -> bool {
        true
    }

    /// Directions scattered into alone.
    fn deltas(&self) -> &[Option<Delta>; 2] {
        &self.bsdf().deltas
    }

    /// How much indirect light each part gathers; 0 for a part that gathers none.
    fn weights(&self) -> [f64; 4] {
        self.bsdf().weights()
    }

    /// In how many ways a part is sampled.
    fn ways(&self, _: Part) -> usize {
        1
    }

    /// A direction drawn from a part in one way.
    fn sample(&mut self, part: Part, _way: usize, u: [f64; 2]) -> Option<Vec3> {
        self.bsdf().sample(part, u)
    }

    /// By how much more a part scatters lamps than indirect light; `None` where lamps must not be found by sampling it.
    fn lamp_ratio(&self, part: Part, wi: Vec3) -> Option<f64> {
        self.bsdf().lamp_ratio(part, wi)
    }
}

impl Scattering for Bsdf {
    fn bsdf(&self) -> &Bsdf {
        self
    }
}

/// Follows paths through a world by its rules. Keeps its stack between rays.
pub struct Integrator<'a, B> {
    world: &'a World,
    rules: &'a Rules,
    stack: Vec<Segment<B>>,
    /// The states among antimatter of the paths of a sample.
    clips: Vec<Clip>,
    outcome: Outcome,
}

/// What tracing a sample was like.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Whether anything was left to chance: if not, another sample of the same ray would say the same.
    pub random: bool,
    /// Whether the ray met a surface.
    pub surface: bool,
}

/// A path that is to be followed, and what it carries.
struct Segment<B> {
    path: Path,
    beta: B,
}

/// A path, from its last vertex on.
#[derive(Clone, Copy)]
struct Path {
    ray: Ray,
    /// How far it may go.
    limit: f64,
    sampler: Sampler,
    /// RADIANCE's weight of the ray: the product of the coefficients so far, each at most 1.
    weight: f64,
    /// Reflections so far.
    level: i32,
    /// Diffuse bounces so far.
    bounces: u32,
    /// Length of the path before this segment.
    travelled: f64,
    /// What fills the segment.
    medium: Inside,
    /// Whether no direction so far was random.
    exact: bool,
    /// The last rough scattering; `None` while the path is seen as it is.
    scattered: Option<Scattered>,
    /// What a shadow ray was aimed at: it counts only if it ends there.
    aim: Option<Emitter>,
    /// Its state among antimatter, by its place in the list; `None` where there is none.
    clip: Option<usize>,
    kind: Kind,
}

/// How a path left the last rough surface it met.
#[derive(Clone, Copy)]
struct Scattered {
    origin: Vec3,
    direction: Vec3,
    /// Density with which its directions are drawn from the surface, per solid angle.
    density: f64,
    /// How much lamps found on this path count: not at all where they are summed by RADIANCE's rule, or behind a mirror.
    lamps: f64,
    /// Whether directions aimed at the environment share it.
    shared: bool,
    /// How much what shines first on the path counts that pools of light may be made of, surfaces and glows: less than all where directions are
    /// aimed at pools too.
    places: f64,
    /// And how much other light does: none where the direction is aimed at a pool.
    others: f64,
}

/// Below this weight a path goes on by roulette; one that nothing was left to chance for yet, below the second.
const ROULETTE: f64 = 0.1;
const EXACT_ROULETTE: f64 = 0.05;
/// After this many reflections each further one is survived with this probability only: light can be caught in glass for good.
const MANY: i32 = 24;
const PATIENCE: f64 = 0.8;

impl<'a, B: Clone> Integrator<'a, B> {
    /// An integrator for a world and rules.
    pub fn new(world: &'a World, rules: &'a Rules) -> Self {
        Self { world, rules, stack: Vec::new(), clips: Vec::new(), outcome: Outcome::default() }
    }

    /// Follows one sample of `ray` as far as `limit`, and all it leads to.
    pub fn trace<T: Transport<Beta = B>>(&mut self, transport: &mut T, ray: Ray, limit: f64, sampler: Sampler) -> Outcome {
        let hit = self.world.nearest(&ray, limit);
        self.trace_on(transport, ray, limit, hit.as_ref(), sampler)
    }

    /// The same, where it is known what the ray meets first.
    pub fn trace_on<T: Transport<Beta = B>>(
        &mut self,
        transport: &mut T,
        ray: Ray,
        limit: f64,
        hit: Option<&Hit>,
        sampler: Sampler,
    ) -> Outcome {
        let path = self.primary(ray, limit, sampler);
        self.arrive(transport, &path, transport.start(), hit);
        self.run(transport)
    }

    /// One sample of the irradiance at a point on the side that `normal` points to.
    pub fn irradiance<T: Transport<Beta = B>>(&mut self, transport: &mut T, point: Vec3, normal: Vec3, sampler: Sampler) -> Outcome {
        let ray = Ray { origin: point, direction: -normal };
        let layer = self.world.collector(&ray, point);
        let path = self.primary(ray, f64::INFINITY, sampler);
        self.scatter(transport, &path, &transport.start(), &layer);
        self.run(transport)
    }

    /// The first ray of a path.
    fn primary(&mut self, ray: Ray, limit: f64, sampler: Sampler) -> Path {
        self.outcome = Outcome::default();
        self.clips.clear();
        Path {
            ray,
            limit,
            sampler,
            weight: 1.0,
            level: 0,
            bounces: 0,
            travelled: 0.0,
            medium: Inside::of(self.rules.extinction),
            exact: true,
            scattered: None,
            aim: None,
            clip: None,
            kind: Kind::Primary,
        }
    }

    /// Follows what is on the stack, and all it leads to.
    fn run<T: Transport<Beta = B>>(&mut self, transport: &mut T) -> Outcome {
        while let Some(Segment { path, beta }) = self.stack.pop() {
            let hit = self.world.nearest(&path.ray, path.limit);
            self.arrive(transport, &path, beta, hit.as_ref());
        }
        self.outcome
    }

    /// The end of a path's ray: what it hit, if anything.
    fn arrive<T: Transport<Beta = B>>(&mut self, transport: &mut T, path: &Path, mut beta: B, hit: Option<&Hit>) {
        let Path { ray, limit, medium, weight, kind, aim, .. } = path;
        transport.visit(&mut beta, &Visit { ray, hit, limit: *limit, medium, weight: *weight, kind: *kind, shadow: aim.is_some() });
        match hit {
            Some(hit) => {
                let clip = path.clip.map(|clip| self.clips[clip].clone());
                let coming = Coming {
                    ray,
                    travelled: path.travelled,
                    aim: path.aim,
                    primary: path.exact && path.level == 0 && path.scattered.is_none() && path.aim.is_none(),
                    gathered: path.gathers(),
                    ambient: path.bounces > 0 || path.aim == Some(Emitter::Environment),
                    clip: clip.as_ref(),
                };
                self.outcome.surface |= path.travelled == 0.0;
                self.world.layers(hit, &coming, self.rules, &mut |layer| self.meet(transport, path, &beta, hit, layer));
            }
            None if path.limit < f64::INFINITY => {}
            None => self.escape(transport, path, beta),
        }
    }

    /// What lies behind everything.
    fn escape<T: Transport<Beta = B>>(&self, transport: &mut T, path: &Path, mut beta: B) {
        if let Some(emission) = self.world.sky(path.ray.origin, path.ray.direction, path.aim, path.gathers()) {
            transport.absorb(&mut beta, &path.medium, f64::INFINITY);
            self.emit(transport, path, &beta, &emission);
        }
    }

    /// One layer of what a path hit.
    fn meet<T: Transport<Beta = B>>(&mut self, transport: &mut T, path: &Path, beta: &B, hit: &Hit, layer: &Layer) {
        let mut beta = beta.clone();
        let mut weight = path.weight;
        if layer.fraction != 1.0 {
            transport.scale(&mut beta, Rgb::splat(layer.fraction));
            weight *= layer.fraction;
        }
        let medium = layer.behind.as_ref().unwrap_or(&path.medium);
        transport.absorb(&mut beta, medium, hit.t);
        transport.meet(&beta, layer);
        // RADIANCE's weight reckons with a strong medium only.
        let dimmed = transport.extinction(medium).min_element() * hit.t;
        if dimmed > 0.1 || dimmed > 0.0 && !self.rules.limited() {
            weight *= (-dimmed).exp();
        }
        if let Some(emission) = &layer.emission {
            return self.emit(transport, path, &beta, emission);
        }
        let mut onward = Path {
            ray: Ray { origin: hit.point, direction: path.ray.direction },
            limit: path.limit - hit.t,
            travelled: path.travelled + hit.t,
            weight,
            medium: *medium,
            ..*path
        };
        if let Some(named) = layer.material {
            let lets_on = named.material.nominally_transparent();
            let share = onward.scattered.as_mut().map_or(1.0, |scattered| scattered.settle(lets_on));
            if share == 0.0 {
                return;
            }
            if share != 1.0 {
                transport.scale(&mut beta, Rgb::splat(share));
            }
            return self.scatter(transport, &onward, &beta, layer);
        }
        let path = self.beyond(Path { kind: Kind::Passed, ..onward }, layer);
        self.stack.push(Segment { path, beta });
    }

    /// The same path on the other side of what it met.
    fn beyond(&mut self, mut path: Path, layer: &Layer) -> Path {
        if let Some(clip) = &layer.clip {
            path.clip = Some(self.clips.len());
            self.clips.push((**clip).clone());
        }
        if let Some(scattered) = path.scattered.as_mut().filter(|_| layer.shades) {
            scattered.lamps = 0.0;
        }
        path
    }

    /// Light at the end of a path.
    fn emit<T: Transport<Beta = B>>(&self, transport: &mut T, path: &Path, beta: &B, emission: &Emission) {
        let weight = match (path.aim, &path.scattered) {
            (Some(aim), _) => (aim == emission.emitter) as u8 as f64,
            (None, None) => (self.rules.lights_visible || emission.beyond) as u8 as f64,
            (None, Some(s)) => match emission.emitter {
                Emitter::Lamp(_) if s.lamps == 0.0 => 0.0,
                Emitter::Lamp(lamp) => match self.world.lamp_pdf(lamp, s.origin, s.direction) {
                    0.0 => 0.0,
                    aimed => s.lamps * s.density / (s.density + aimed),
                },
                Emitter::Environment if s.shared => s.others * s.density / (s.density + self.world.environment_pdf(s.origin, s.direction)),
                Emitter::Environment => s.others,
                Emitter::Glow => s.places,
                Emitter::Hidden => 0.0,
            },
        };
        if weight == 1.0 {
            transport.collect(beta, emission.radiance);
        } else if weight > 0.0 {
            transport.collect(beta, emission.radiance * weight);
        }
    }
}

impl Scattered {
    /// Leaves a point in no direction yet, so that nothing else is aimed at what it finds.
    fn from(origin: Vec3) -> Self {
        Self { origin, direction: Vec3::ZERO, density: 0.0, lamps: 0.0, shared: false, places: 1.0, others: 1.0 }
    }

    /// What the path counts from the first surface on: as others do where that lets light on, and no more is aimed at pools then.
    fn settle(&mut self, lets_on: bool) -> f64 {
        let share = if lets_on { self.others } else { self.places };
        (self.places, self.others) = (1.0, 1.0);
        share
    }
}

impl Path {
    /// Whether it gathers indirect light.
    fn gathers(&self) -> bool {
        self.scattered.is_some() || self.aim == Some(Emitter::Environment)
    }

    /// The same path with no end: what is reflected is not held by the limit of the ray before it.
    fn free(self) -> Self {
        Self { limit: f64::INFINITY, ..self }
    }
}
