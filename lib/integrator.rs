//! The radiance along one ray: paths from the viewer to whatever emits light.
//!
//! A path carries a throughput and hands each emission it meets to a [`Transport`], which says what the two make together: a colour
//! ([`Radiance`]) or a term of the transport basis. Roughness is gathered part by part (diffuse or specular, reflected or transmitted):
//! each part has samples of its own, weighted against those aimed at lamps and at the environment by the balance heuristic
//! (Veach 1997, equation 9.8). Until the first random direction, all directions that a surface scatters into are followed; after that, one.

use crate::bsdf::{Arriving, Bsdf, Delta, Part};
use crate::color::Rgb;
use crate::geometry::Ray;
use crate::material::Inside;
use crate::rules::Rules;
use crate::sampling::Sampler;
use crate::vector::Vec3;
use crate::world::{Coming, Emission, Emitter, Layer, World};

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
    /// The throughput behind a direction that was drawn from a part in one way, and the density it was drawn with, `count` samples of each
    /// way being expected.
    fn drawn(&self, beta: &Self::Beta, surface: &Self::Surface, wi: Vec3, part: Part, way: usize, count: f64) -> (Self::Beta, f64);
    /// The throughput of light that reaches one side of the surface from all directions alike, through the diffuse part.
    fn ambient(&self, beta: &Self::Beta, surface: &Self::Surface, side: usize) -> Self::Beta;
    /// The throughput behind a direction that is scattered into alone.
    fn follow(&self, beta: &Self::Beta, surface: &Self::Surface, delta: &Delta) -> Self::Beta;
    /// Dims a throughput by `length` in a medium.
    fn absorb(&self, beta: &mut Self::Beta, medium: &Inside, length: f64);
    /// Takes the light that a path found.
    fn collect(&mut self, beta: &Self::Beta, radiance: Rgb);
}

/// Scattering at a point, as far as the choice of directions goes: a material's own, unless it is unknown. Directions are local.
pub trait Scattering {
    /// The material at the point; for an unknown one, a stand-in with the same frame.
    fn bsdf(&self) -> &Bsdf;

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
    fn sample(&self, part: Part, _way: usize, u: [f64; 2]) -> Option<Vec3> {
        self.bsdf().sample(part, u)
    }

    /// The expected number of samples of each part, and of directions aimed at the environment, while all ways on are followed: 1, unless
    /// there is better use for the time.
    fn rates(&self) -> ([f64; 4], f64) {
        ([1.0; 4], 1.0)
    }

    /// Whether lamps must not be found by sampling this part.
    fn lamps_differ(&self, part: Part) -> bool {
        self.bsdf().lamps_differ(part)
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

/// A path, from its last vertex on.
#[derive(Clone)]
struct Segment<B> {
    ray: Ray,
    /// How far it may go.
    limit: f64,
    beta: B,
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
}

/// How paths go on from a surface. The ways are: its two deltas, its four parts.
struct Ways {
    /// What each part gathers; 0 for a part that gathers nothing here.
    weights: [f64; 4],
    /// The expected number of samples of each part, per way to sample it; 0 for a part that is not integrated.
    counts: [f64; 4],
    /// The probability of each way, 1 if all are taken.
    share: [f64; 6],
    /// The one that is taken; all if `None`.
    chosen: Option<usize>,
    /// The expected number of directions aimed at the environment.
    aimed: f64,
}

impl Ways {
    fn take(&self, way: usize) -> bool {
        self.chosen.is_none_or(|c| c == way)
    }
}

/// How a path left the last rough surface it met.
#[derive(Clone, Copy)]
struct Scattered {
    origin: Vec3,
    direction: Vec3,
    /// Density with which its directions are drawn from the surface, per solid angle.
    density: f64,
    /// Whether lamps found on this path count: they do not where they are summed by RADIANCE's rule, or behind a mirror.
    lamps: bool,
    /// The expected number of samples aimed at the environment that share it.
    shared: f64,
}

/// Below this weight a path goes on by roulette.
const ROULETTE: f64 = 0.1;

impl<'a, B: Clone> Integrator<'a, B> {
    /// An integrator for a world and rules.
    pub fn new(world: &'a World, rules: &'a Rules) -> Self {
        Self { world, rules, stack: Vec::new(), outcome: Outcome::default() }
    }

    /// Follows one sample of `ray` as far as `limit`, and all it leads to.
    pub fn trace<T: Transport<Beta = B>>(&mut self, transport: &mut T, ray: Ray, limit: f64, sampler: Sampler) -> Outcome {
        self.outcome = Outcome::default();
        self.stack.push(Segment {
            ray,
            limit,
            beta: transport.start(),
            sampler,
            weight: 1.0,
            level: 0,
            bounces: 0,
            travelled: 0.0,
            medium: Inside::of(self.rules.extinction),
            exact: true,
            scattered: None,
            aim: None,
        });
        while let Some(segment) = self.stack.pop() {
            match self.world.nearest(&segment.ray, segment.limit) {
                Some(hit) => {
                    let coming = Coming {
                        ray: &segment.ray,
                        travelled: segment.travelled,
                        aim: segment.aim,
                        primary: segment.exact && segment.level == 0 && segment.scattered.is_none(),
                    };
                    self.outcome.surface |= segment.travelled == 0.0;
                    self.world.layers(&hit, &coming, self.rules, &mut |layer| self.meet(transport, &segment, hit.t, hit.point, layer));
                }
                None if segment.limit < f64::INFINITY => {}
                None => self.escape(transport, segment),
            }
        }
        self.outcome
    }

    /// What lies behind everything.
    fn escape<T: Transport<Beta = B>>(&mut self, transport: &mut T, mut segment: Segment<B>) {
        if let Some(emission) = self.world.sky(segment.ray.origin, segment.ray.direction) {
            transport.absorb(&mut segment.beta, &segment.medium, f64::INFINITY);
            self.emit(transport, &segment, &segment.beta, &emission);
        }
    }

    /// One layer of what a segment hit.
    fn meet<T: Transport<Beta = B>>(&mut self, transport: &mut T, segment: &Segment<B>, t: f64, point: Vec3, layer: &Layer) {
        let mut beta = segment.beta.clone();
        if layer.fraction != 1.0 {
            transport.scale(&mut beta, Rgb::splat(layer.fraction));
        }
        transport.absorb(&mut beta, layer.behind.as_ref().unwrap_or(&segment.medium), t);
        let onward = Segment {
            ray: Ray { origin: point, direction: segment.ray.direction },
            limit: segment.limit - t,
            travelled: segment.travelled + t,
            beta,
            ..segment.clone()
        };
        match (&layer.emission, layer.material.is_some()) {
            (Some(emission), _) => self.emit(transport, segment, &onward.beta, emission),
            (None, false) => self.stack.push(onward),
            (None, true) => self.scatter(transport, onward, layer),
        }
    }

    /// Light at the end of a path.
    fn emit<T: Transport<Beta = B>>(&mut self, transport: &mut T, segment: &Segment<B>, beta: &B, emission: &Emission) {
        let weight = match (segment.aim, segment.scattered) {
            (Some(aim), _) => (aim == emission.emitter) as u8 as f64,
            (None, None) => (self.rules.lights_visible || emission.beyond) as u8 as f64,
            (None, Some(s)) => match emission.emitter {
                Emitter::Lamp(_) if !s.lamps => 0.0,
                Emitter::Lamp(lamp) => match self.world.lamp_pdf(lamp, s.origin, s.direction) {
                    0.0 => 0.0,
                    aimed => s.density / (s.density + aimed),
                },
                Emitter::Environment if s.shared > 0.0 => s.density / (s.density + s.shared * self.world.environment_pdf(s.direction)),
                Emitter::Environment | Emitter::Glow => 1.0,
                Emitter::Hidden => 0.0,
            },
        };
        if weight == 1.0 {
            transport.collect(beta, emission.radiance);
        } else if weight > 0.0 {
            transport.collect(beta, emission.radiance * weight);
        }
    }

    /// Scattering at a surface: `at` begins there, with the direction it came with.
    fn scatter<T: Transport<Beta = B>>(&mut self, transport: &mut T, mut at: Segment<B>, layer: &Layer) {
        let surface = transport.surface(layer, self.rules);
        at.limit = f64::INFINITY;
        if at.aim.is_some() {
            if let Some(delta) = &surface.deltas()[1] {
                self.follow(transport, &mut at, &surface, delta, 1.0);
            }
            return;
        }
        let ways = self.ways(transport, &mut at, &surface);
        self.aim_at_lamps(transport, &mut at, &surface, &ways.counts);
        self.aim_at_environment(transport, &mut at, &surface, &ways);
        for part in Part::ALL {
            if ways.weights[part as usize] > 0.0 && ways.take(2 + part as usize) {
                self.gather(transport, &mut at, &surface, part, &ways);
            }
        }
        for side in 0..2 {
            if let Some(delta) = surface.deltas()[side].as_ref().filter(|_| ways.take(side)) {
                self.follow(transport, &mut at, &surface, delta, ways.share[side]);
            }
        }
    }

    /// How to go on from a surface: in every way there is while nothing was left to chance, else in one, chosen in proportion to what it carries.
    fn ways<T: Transport<Beta = B>>(&mut self, transport: &mut T, at: &mut Segment<B>, surface: &T::Surface) -> Ways {
        let mut ways = Ways { weights: surface.weights(), counts: [0.0; 4], share: [1.0; 6], chosen: None, aimed: 1.0 };
        if at.bounces >= self.rules.ambient_bounces {
            for side in 0..2 {
                if std::mem::take(&mut ways.weights[side]) > 0.0 && self.rules.ambient_value != Rgb::ZERO {
                    transport.collect(&transport.ambient(&at.beta, surface, side), self.rules.ambient_value);
                }
            }
        }
        if !at.exact {
            let deltas = surface.deltas().map(|d| d.map_or(0.0, |d| d.coefficient.max_element()));
            let carried = std::array::from_fn(|i| if i < 2 { deltas[i] } else { ways.weights[i - 2] });
            let total: f64 = carried.iter().sum();
            if total > 0.0 {
                ways.share = carried.map(|c| c / total);
                ways.chosen = Some(self.choose(at, &ways.share));
            }
        }
        let (rates, aimed) = surface.rates();
        ways.aimed = if at.exact { aimed } else { 1.0 };
        for part in Part::ALL {
            let k = part as usize;
            if ways.weights[k] > 0.0 && self.spread(part).is_none() {
                ways.counts[k] = if at.exact { rates[k] } else { ways.share[2 + k] / surface.ways(part) as f64 };
            }
        }
        ways
    }

    /// One of several ways, with these probabilities.
    fn choose(&mut self, at: &mut Segment<B>, share: &[f64; 6]) -> usize {
        let mut u = self.draw(at)[0];
        let last = share.iter().rposition(|&s| s > 0.0).unwrap_or(0);
        share[..last]
            .iter()
            .position(|s| {
                u -= s;
                u < 0.0
            })
            .unwrap_or(last)
    }

    /// Two random numbers.
    fn draw(&mut self, at: &mut Segment<B>) -> [f64; 2] {
        self.outcome.random = true;
        at.sampler.pair()
    }

    /// The narrowing of a lobe that RADIANCE's unweighted rule samples; `None` where the lobe itself is integrated.
    fn spread(&self, part: Part) -> Option<f64> {
        let s = self.rules.specular_sampling?;
        match part {
            Part::SpecularReflection if s <= 1.5 => Some(s.min(1.0)),
            Part::SpecularTransmission if s < 1.0 => Some(s),
            _ => None,
        }
    }

    /// Samples one part, and sends paths on.
    fn gather<T: Transport<Beta = B>>(&mut self, transport: &mut T, at: &mut Segment<B>, surface: &T::Surface, part: Part, ways: &Ways) {
        let k = part as usize;
        let weight = self.factor(ways.weights[k], ways.share[2 + k]);
        let mut from = Scattered { origin: at.ray.origin, direction: Vec3::ZERO, density: 0.0, lamps: false, shared: 0.0 };
        if let Some(spread) = self.spread(part) {
            let mut sampler = at.sampler.fork();
            if let Some((wi, color)) = surface.bsdf().unweighted(part, spread, &mut sampler) {
                let mut beta = at.beta.clone();
                transport.scale(&mut beta, color / ways.share[2 + k]);
                from.direction = surface.bsdf().to_world(wi);
                self.outcome.random |= spread > 0.0;
                at.exact &= spread == 0.0;
                self.send(transport, at, beta, from, part, weight);
            }
            return;
        }
        let count = surface.ways(part);
        let only = if at.exact || count == 1 { None } else { Some(((self.draw(at)[0] * count as f64) as usize).min(count - 1)) };
        (from.lamps, from.shared) = (self.rules.light_jitter.is_none() && !surface.lamps_differ(part), ways.aimed);
        for way in (0..count).filter(|&w| only.is_none_or(|o| o == w)) {
            // A part that is not worth a sample each time gets one now and then.
            if at.exact && ways.counts[k] < 1.0 && self.draw(at)[0] >= ways.counts[k] {
                continue;
            }
            let u = self.draw(at);
            let Some(wi) = surface.sample(part, way, u) else { continue };
            from.direction = surface.bsdf().to_world(wi);
            let beta;
            (beta, from.density) = transport.drawn(&at.beta, surface, wi, part, way, ways.counts[k]);
            let exact = std::mem::take(&mut at.exact);
            self.send(transport, at, beta, from, part, weight);
            at.exact = exact;
        }
    }

    /// What a way that carries `carried` and is taken with probability `share` multiplies the weight of a path with: where RADIANCE's limits
    /// are given, what it does there; else what the throughput is on the average multiplied with.
    fn factor(&self, carried: f64, share: f64) -> f64 {
        if self.rules.limit_weight.is_some() || self.rules.limit_reflections.is_some() { carried } else { carried / share }
    }

    /// Sends a path on from a rough surface.
    fn send<T: Transport<Beta = B>>(&mut self, transport: &mut T, at: &mut Segment<B>, beta: B, from: Scattered, part: Part, weight: f64) {
        let sampler = at.sampler.fork();
        let ray = Ray { origin: at.ray.origin, direction: from.direction };
        let bounces = at.bounces + part.diffuse() as u32;
        let next = Segment { ray, beta, sampler, bounces, scattered: Some(from), ..at.clone() };
        self.push(transport, next, weight, part.side() == 0);
    }

    /// Follows a direction that is scattered into alone, taken with probability `share`.
    fn follow<T: Transport<Beta = B>>(&mut self, transport: &mut T, at: &mut Segment<B>, surface: &T::Surface, delta: &Delta, share: f64) {
        let mut next = Segment { sampler: at.sampler.fork(), beta: transport.follow(&at.beta, surface, delta), ..at.clone() };
        if share != 1.0 {
            transport.scale(&mut next.beta, Rgb::splat(1.0 / share));
        }
        next.ray.direction = delta.direction;
        if let Some(medium) = delta.medium {
            next.medium = medium;
        }
        // Lamps and environment were not aimed at by way of a mirror.
        if delta.reflected
            && let Some(s) = &mut next.scattered
        {
            (s.lamps, s.shared) = (false, 0.0);
        }
        let weight = self.factor(delta.coefficient.max_element(), share);
        self.push(transport, next, weight, delta.reflected);
    }

    /// Sends a path on if RADIANCE's limits, or roulette, let it live.
    fn push<T: Transport<Beta = B>>(&mut self, transport: &mut T, mut next: Segment<B>, coefficient: f64, reflected: bool) {
        next.level += reflected as i32;
        next.weight *= coefficient.min(1.0);
        let least = match (self.rules.limit_reflections, self.rules.limit_weight) {
            (Some(most), least) if most > 0 => {
                if next.level <= most && next.weight >= least.unwrap_or(0.0) {
                    self.stack.push(next);
                }
                return;
            }
            (most, least) => {
                if most.is_some_and(|m| m < 0 && next.level > -m) {
                    return;
                }
                least.unwrap_or(ROULETTE)
            }
        };
        if next.weight < least {
            let survival = next.weight / least;
            self.outcome.random = true;
            if !(next.sampler.single() < survival) {
                return;
            }
            transport.scale(&mut next.beta, Rgb::splat(1.0 / survival));
            next.weight = least;
        }
        self.stack.push(next);
    }

    /// Direct light of lamps.
    fn aim_at_lamps<T: Transport<Beta = B>>(&mut self, transport: &mut T, at: &mut Segment<B>, surface: &T::Surface, counts: &[f64; 4]) {
        let world = self.world;
        if world.lamps().is_empty() {
            return;
        }
        if let Some(jitter) = self.rules.light_jitter {
            for lamp in 0..world.lamps().len() {
                let u = if jitter > 0.0 { self.draw(at) } else { [0.5; 2] };
                let w = if jitter > 0.0 { self.draw(at)[0] } else { 0.5 };
                if let Some(sample) = world.lamps()[lamp].centre(at.ray.origin, jitter, [u[0], u[1], w]) {
                    let wi = surface.bsdf().to_local(sample.direction);
                    let beta = transport.aimed(&at.beta, surface, wi, Arriving::Lamp(sample.omega), 1.0 / sample.omega, &[0.0; 4]);
                    self.shadow(transport, at, beta, sample.direction, sample.distance, Emitter::Lamp(lamp));
                }
            }
            return;
        }
        let (u, v) = (self.draw(at), self.draw(at));
        let Some(sample) = world.sample_lamp(at.ray.origin, v[0], u) else { return };
        let wi = surface.bsdf().to_local(sample.to.direction);
        let counts = std::array::from_fn(|k| if sample.shared && !surface.lamps_differ(Part::ALL[k]) { counts[k] } else { 0.0 });
        let beta = transport.aimed(&at.beta, surface, wi, Arriving::Lamp(0.0), sample.pdf, &counts);
        self.shadow(transport, at, beta, sample.to.direction, sample.to.distance, Emitter::Lamp(sample.lamp));
    }

    /// Light of the environment, for the parts that gather it.
    fn aim_at_environment<T: Transport<Beta = B>>(&mut self, transport: &mut T, at: &mut Segment<B>, surface: &T::Surface, ways: &Ways) {
        if ways.counts == [0.0; 4] || !self.world.has_environment() {
            return;
        }
        if ways.aimed < 1.0 && self.draw(at)[0] >= ways.aimed {
            return;
        }
        let u = self.draw(at);
        let Some((direction, pdf)) = self.world.sample_environment(u) else { return };
        let wi = surface.bsdf().to_local(direction);
        let beta = transport.aimed(&at.beta, surface, wi, Arriving::Indirect, ways.aimed * pdf, &ways.counts);
        self.shadow(transport, at, beta, direction, f64::INFINITY, Emitter::Environment);
    }

    /// Sends a shadow ray. Where nothing is transparent it is settled at once.
    fn shadow<T: Transport<Beta = B>>(
        &mut self,
        transport: &mut T,
        at: &mut Segment<B>,
        beta: B,
        direction: Vec3,
        distance: f64,
        aim: Emitter,
    ) {
        if transport.size(&beta) == 0.0 {
            return;
        }
        let ray = Ray { origin: at.ray.origin, direction };
        let next = Segment { ray, beta, sampler: at.sampler.clone(), aim: Some(aim), ..at.clone() };
        if self.world.transparent() || distance < f64::INFINITY {
            self.stack.push(next);
        } else if !self.world.occluded(&next.ray) {
            self.escape(transport, next);
        }
    }
}

/// The transport of a picture: the throughput is a colour, the light found adds up.
pub struct Radiance<'a> {
    /// The rules of the picture.
    pub rules: &'a Rules,
    /// The sum of what was found, in W/(sr·m²).
    pub sum: Rgb,
}

impl Transport for Radiance<'_> {
    type Beta = Rgb;
    type Surface = Bsdf;

    fn start(&self) -> Rgb {
        Rgb::ONE
    }

    fn scale(&self, beta: &mut Rgb, by: Rgb) {
        *beta *= by;
    }

    fn size(&self, beta: &Rgb) -> f64 {
        beta.abs().max_element()
    }

    fn surface(&self, layer: &Layer, rules: &Rules) -> Bsdf {
        layer.bsdf(rules)
    }

    fn aimed(&self, beta: &Rgb, surface: &Bsdf, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> Rgb {
        *beta * surface.value(wi, arriving, &surface.balance(wi, arriving, pdf, counts), self.rules)
    }

    fn drawn(&self, beta: &Rgb, surface: &Bsdf, wi: Vec3, part: Part, _: usize, count: f64) -> (Rgb, f64) {
        let density = count * surface.pdf(part, wi);
        (*beta * surface.value(wi, Arriving::Indirect, &part.alone(1.0 / density), self.rules), density)
    }

    fn ambient(&self, beta: &Rgb, surface: &Bsdf, side: usize) -> Rgb {
        *beta * surface.ambient[side]
    }

    fn follow(&self, beta: &Rgb, _: &Bsdf, delta: &Delta) -> Rgb {
        *beta * delta.coefficient
    }

    fn absorb(&self, beta: &mut Rgb, medium: &Inside, length: f64) {
        *beta *= medium.transmittance(length);
    }

    fn collect(&mut self, beta: &Rgb, radiance: Rgb) {
        self.sum += *beta * radiance;
    }
}
