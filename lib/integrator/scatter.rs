//! How a path goes on from a surface: in single directions, by samples of its rough parts, aimed at lamps and at the environment.

use super::unhidden::Unhidden;
use super::{EXACT_ROULETTE, Integrator, Kind, MANY, PATIENCE, Path, ROULETTE, Scattered, Scattering, Segment, Transport};
use crate::bsdf::{Arriving, Delta, Part, lobe};
use crate::color::Rgb;
use crate::geometry::Ray;
use crate::rules::single;
use crate::sampling::Sampler;
use crate::vector::Vec3;
use crate::world::{Emitter, Layer};

/// A surface that a path has come to.
struct Vertex<'v, T: Transport> {
    surface: &'v mut T::Surface,
    layer: &'v Layer<'v>,
    /// The path, as if it began here, with the direction it came with.
    at: &'v Path,
    /// What it carries.
    beta: &'v T::Beta,
    /// What decides how it goes on.
    sampler: Sampler,
    /// Whether no direction was random, here neither.
    exact: bool,
}

/// How paths go on from a surface. The ways are: its two deltas, its four parts.
struct Ways {
    /// What each part gathers; 0 for a part that gathers nothing here.
    weights: [f64; 4],
    /// The expected number of samples of each part, per way to sample it; 0 for a part that is not integrated.
    counts: [f64; 4],
    /// The same, without the parts whose samples may go another way than what is aimed in their direction.
    aims: [f64; 4],
    /// The expected number of directions of each part that are aimed at pools of light.
    pools: [f64; 4],
    /// The probability of each way, 1 if all are taken.
    share: [f64; 6],
    /// The one that is taken; all if `None`.
    chosen: Option<usize>,
}

/// How often a direction is aimed at a pool of light instead of drawn from a part, where one is taken.
const POOLS: f64 = 0.5;

impl Ways {
    fn take(&self, way: usize) -> bool {
        self.chosen.is_none_or(|c| c == way)
    }
}

impl<B: Clone> Integrator<'_, B> {
    /// Scattering at a surface: `at` begins there, with the direction it came with.
    pub(super) fn scatter<T: Transport<Beta = B>>(&mut self, transport: &mut T, at: &Path, beta: &B, layer: &Layer) {
        let mut surface = transport.surface(layer, self.rules);
        let mut vertex: Vertex<T> = Vertex { surface: &mut surface, layer, at, beta, sampler: at.sampler, exact: at.exact };
        if at.aim.is_some() {
            let way = layer.relay.is_none() as usize;
            if let Some(delta) = vertex.surface.deltas()[way] {
                let (mut path, beta) = self.after(transport, &mut vertex, &delta);
                path.weight *= delta.coefficient.max_element().min(1.0);
                if let Some(lamp) = layer.relay {
                    path.aim = Some(Emitter::Lamp(lamp));
                }
                self.stack.push(Segment { path, beta });
            }
            return;
        }
        let ways = self.ways(transport, &mut vertex);
        self.aim_at_lamps(transport, &mut vertex, &ways.aims);
        let mut unhidden = if vertex.exact { Unhidden::new(self.world, at.ray.origin, &ways.weights, &ways.counts) } else { None };
        self.aim_at_environment(transport, &mut vertex, &ways, &mut unhidden);
        for part in Part::ALL {
            if ways.weights[part as usize] > 0.0 && ways.take(2 + part as usize) {
                self.gather(transport, &mut vertex, part, &ways, &mut unhidden);
            }
        }
        for side in 0..2 {
            if let Some(missed) = unhidden.as_ref().and_then(|unhidden| unhidden.missed(vertex.surface.bsdf(), side)) {
                transport.collect(&transport.unhidden(vertex.beta, vertex.surface, side), missed);
            }
        }
        for side in 0..2 {
            if let Some(delta) = vertex.surface.deltas()[side].as_ref().filter(|_| ways.take(side)).copied() {
                self.follow(transport, &mut vertex, &delta, ways.share[side]);
            }
        }
    }

    /// How to go on from a surface: in every way there is while nothing was left to chance, else in one, chosen in proportion to what it carries.
    fn ways<T: Transport<Beta = B>>(&mut self, transport: &mut T, vertex: &mut Vertex<T>) -> Ways {
        let (surface, at) = (&*vertex.surface, vertex.at);
        let mut ways =
            Ways { weights: surface.weights(), counts: [0.0; 4], aims: [0.0; 4], pools: [0.0; 4], share: [1.0; 6], chosen: None };
        // What would end at once is not drawn, nor does what is aimed at leave it a share.
        let last = at.bounces >= self.rules.ambient_bounces || !vertex.layer.gathers;
        for part in Part::ALL {
            let weight = &mut ways.weights[part as usize];
            let ends = self.ends(at.level + i32::from(part.side() == 0), at.weight * weight.min(1.0));
            let cut = (ends || last && part.diffuse()) && std::mem::take(weight) > 0.0;
            if cut && part.diffuse() && self.rules.ambient_value != Rgb::ZERO {
                transport.collect(&transport.ambient(vertex.beta, surface, part.side()), self.rules.ambient_value);
            }
        }
        if !vertex.exact {
            let deltas = surface.deltas().map(|d| d.map_or(0.0, |d| d.coefficient.max_element()));
            let carried = std::array::from_fn(|i| if i < 2 { deltas[i] } else { ways.weights[i - 2] });
            let total: f64 = carried.iter().sum();
            if total > 0.0 {
                ways.share = carried.map(|c| c / total);
                ways.chosen = Some(self.choose(&mut vertex.sampler, &ways.share));
            }
        }
        let pools = if self.world.has_pools() { POOLS } else { 0.0 };
        for part in Part::ALL {
            let k = part as usize;
            if ways.weights[k] > 0.0 && self.spread(part, surface).is_none() {
                (ways.counts[k], ways.pools[k]) = if vertex.exact {
                    (1.0, f64::from(self.world.has_pools()))
                } else {
                    (ways.share[2 + k] * (1.0 - pools) / surface.ways(part) as f64, ways.share[2 + k] * pools)
                };
            }
        }
        ways.aims = ways.counts;
        // Rough samples go through panes bent, shadow rays straight: what lies behind is not found by both.
        if at.bounces == 0 && self.world.bends() {
            for part in [Part::SpecularReflection, Part::SpecularTransmission] {
                ways.aims[part as usize] = 0.0;
            }
        }
        ways
    }

    /// One of several ways, with these probabilities.
    fn choose(&mut self, sampler: &mut Sampler, share: &[f64; 6]) -> usize {
        let mut u = self.draw(sampler)[0];
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
    fn draw(&mut self, sampler: &mut Sampler) -> [f64; 2] {
        self.outcome.random = true;
        sampler.pair()
    }

    /// The narrowing of a lobe that RADIANCE's unweighted rule samples; `None` where the lobe itself is integrated.
    fn spread(&self, part: Part, surface: &impl Scattering) -> Option<f64> {
        if surface.bsdf().is_unweighted(part) {
            return Some(self.rules.specular_sampling.map_or(1.0, |s| f64::from(s > 0.0)));
        }
        let s = self.rules.specular_sampling.filter(|_| surface.is_known())?;
        match part {
            Part::SpecularReflection if s < 1.0 || single(s) => Some(s.min(1.0)),
            Part::SpecularTransmission if s < 1.0 => Some(s),
            _ => None,
        }
    }

    /// Samples one part, and sends paths on.
    fn gather<T: Transport<Beta = B>>(
        &mut self,
        transport: &mut T,
        vertex: &mut Vertex<T>,
        part: Part,
        ways: &Ways,
        unhidden: &mut Option<Unhidden>,
    ) {
        let k = part as usize;
        let weight = self.factor(ways.weights[k], ways.share[2 + k]);
        let origin = vertex.at.ray.origin;
        let mut from = Scattered::from(origin);
        if let Some(spread) = self.spread(part, vertex.surface) {
            let mut sampler = vertex.sampler.fork();
            self.outcome.random |= spread > 0.0;
            if let Some((wi, color)) = vertex.surface.bsdf().unweighted(part, spread, &mut sampler) {
                let mut beta = vertex.beta.clone();
                transport.scale(&mut beta, color / ways.share[2 + k]);
                from.direction = vertex.surface.bsdf().to_world(wi);
                let next = Next { part, weight, exact: vertex.exact && spread == 0.0 };
                self.send(transport, vertex, beta, from, &next);
            }
            return;
        }
        let next = Next { part, weight, exact: false };
        let count = vertex.surface.ways(part);
        let only = if vertex.exact || count == 1 {
            None
        } else {
            Some(((self.draw(&mut vertex.sampler)[0] * count as f64) as usize).min(count - 1))
        };
        from.shared = ways.aims[k] > 0.0;
        if ways.pools[k] > 0.0 && (vertex.exact || self.draw(&mut vertex.sampler)[0] < POOLS) {
            self.aim_at_pool(transport, vertex, &next, ways);
            if !vertex.exact {
                return;
            }
        }
        let mut other = None;
        for way in (0..count).filter(|&w| only.is_none_or(|o| o == w)) {
            // Two ways look to opposite sides of the lobe: what only tilts across it cancels (Hammersley and Morton 1956).
            let u = other.take().unwrap_or_else(|| {
                let u = self.draw(&mut vertex.sampler);
                other = Some(lobe::opposite(u));
                u
            });
            if let (true, Some(unhidden)) = (part.diffuse(), &mut *unhidden) {
                unhidden.take(vertex.surface.bsdf(), part.lambert(u));
            }
            let Some(wi) = vertex.surface.sample(part, way, u) else { continue };
            from.direction = vertex.surface.bsdf().to_world(wi);
            from.lamps = if self.rules.light_jitter.is_none() && ways.aims[k] > 0.0 {
                vertex.surface.lamp_ratio(part, wi).unwrap_or(0.0)
            } else {
                0.0
            };
            let carried;
            (carried, from.density) = transport.drawn(vertex.beta, vertex.surface, wi, part, way, ways.counts[k]);
            if ways.pools[k] > 0.0 {
                from.places = from.density / (from.density + ways.pools[k] * self.world.pool_pdf(origin, from.direction));
            }
            self.send(transport, vertex, carried, from, &next);
        }
        if vertex.exact
            && let Some((carried, wi, density)) = transport.control(vertex.beta, vertex.surface, part, ways.counts[k])
        {
            (from.direction, from.density, from.lamps, from.places) = (vertex.surface.bsdf().to_world(wi), density, 0.0, 1.0);
            self.send(transport, vertex, carried, from, &next);
        }
    }

    /// Sends a path toward a pool of light.
    fn aim_at_pool<T: Transport<Beta = B>>(&mut self, transport: &mut T, vertex: &mut Vertex<T>, next: &Next, ways: &Ways) {
        let (origin, k) = (vertex.at.ray.origin, next.part as usize);
        let (u, v) = (self.draw(&mut vertex.sampler), self.draw(&mut vertex.sampler));
        let Some((direction, pdf)) = self.world.sample_pool(origin, v[0], u) else { return };
        let wi = vertex.surface.bsdf().to_local(direction);
        let mut counts = [0.0; 4];
        counts[k] = ways.counts[k];
        let carried = transport.aimed(vertex.beta, vertex.surface, wi, Arriving::Indirect, ways.pools[k] * pdf, &counts);
        if transport.size(&carried) > 0.0 {
            let from = Scattered { direction, others: 0.0, ..Scattered::from(origin) };
            self.send(transport, vertex, carried, from, next);
        }
    }

    /// What a way that carries `carried` and is taken with probability `share` multiplies the weight of a path with: where RADIANCE's limits
    /// are given, what it does there; else what the throughput is on the average multiplied with.
    fn factor(&self, carried: f64, share: f64) -> f64 {
        if self.rules.limited() { carried } else { carried / share }
    }

    /// Sends a path on from a rough surface.
    fn send<T: Transport<Beta = B>>(&mut self, transport: &mut T, vertex: &mut Vertex<T>, beta: B, from: Scattered, next: &Next) {
        let at = vertex.at;
        let path = Path {
            ray: Ray { origin: at.ray.origin, direction: from.direction },
            sampler: vertex.sampler.fork(),
            bounces: at.bounces + next.part.diffuse() as u32,
            scattered: Some(from),
            exact: next.exact,
            kind: Kind::Scattered,
            ..*at
        };
        let reflected = next.part.side() == 0;
        let path = if reflected { path.free() } else { self.beyond(path, vertex.layer) };
        self.push(transport, path, beta, next.weight, reflected);
    }

    /// The path behind a direction that is scattered into alone, and what it carries.
    fn after<T: Transport<Beta = B>>(&mut self, transport: &T, vertex: &mut Vertex<T>, delta: &Delta) -> (Path, B) {
        let kind = if delta.reflected { Kind::Reflected } else { Kind::Transmitted };
        let beta = transport.follow(vertex.beta, vertex.surface, delta);
        let at = vertex.at;
        let ray = Ray { origin: at.ray.origin, direction: delta.direction };
        let path =
            Path { ray, sampler: vertex.sampler.fork(), medium: delta.medium.unwrap_or(at.medium), exact: vertex.exact, kind, ..*at };
        (if delta.reflected { path.free() } else { self.beyond(path, vertex.layer) }, beta)
    }

    /// Follows a direction that is scattered into alone, taken with probability `share`.
    fn follow<T: Transport<Beta = B>>(&mut self, transport: &mut T, vertex: &mut Vertex<T>, delta: &Delta, share: f64) {
        let (mut path, mut beta) = self.after(transport, vertex, delta);
        if share != 1.0 {
            transport.scale(&mut beta, Rgb::splat(1.0 / share));
        }
        // Lamps and environment were not aimed at by way of a mirror.
        if delta.reflected
            && let Some(s) = &mut path.scattered
        {
            (s.lamps, s.shared) = (0.0, false);
        }
        let weight = self.factor(delta.coefficient.max_element(), share);
        self.push(transport, path, beta, weight, delta.reflected);
    }

    /// Whether RADIANCE's limits end a path after so many reflections, with this weight.
    fn ends(&self, level: i32, weight: f64) -> bool {
        self.rules.limit_reflections.is_some_and(|most| {
            most != 0 && level.unsigned_abs() > most.unsigned_abs()
                || most > 0 && self.rules.limit_weight.is_some_and(|least| weight < least)
        })
    }

    /// Sends a path on if RADIANCE's limits, or roulette, let it live.
    fn push<T: Transport<Beta = B>>(&mut self, transport: &T, mut path: Path, mut beta: B, coefficient: f64, reflected: bool) {
        path.level += reflected as i32;
        path.weight *= coefficient.min(1.0);
        if self.ends(path.level, path.weight) {
            return;
        }
        if self.rules.limit_reflections.is_some_and(|most| most > 0) {
            return self.stack.push(Segment { path, beta });
        }
        let least = self.rules.limit_weight.unwrap_or(if path.exact { EXACT_ROULETTE } else { ROULETTE });
        let patience = if reflected && path.level > MANY { PATIENCE } else { 1.0 };
        let survival = patience * (path.weight / least).min(1.0);
        if survival < 1.0 {
            self.outcome.random = true;
            if !(path.sampler.single() < survival) {
                return;
            }
            transport.scale(&mut beta, Rgb::splat(1.0 / survival));
            path.weight = path.weight.max(least);
        }
        self.stack.push(Segment { path, beta });
    }

    /// Direct light of lamps.
    fn aim_at_lamps<T: Transport<Beta = B>>(&mut self, transport: &mut T, vertex: &mut Vertex<T>, counts: &[f64; 4]) {
        let (world, at) = (self.world, vertex.at);
        if world.lamps().is_empty() {
            return;
        }
        if let Some(jitter) = self.rules.light_jitter {
            // RADIANCE's ambient rays share the weight of one, so that next to nothing is left of it for each.
            let fraction = if at.bounces == 0 { self.rules.light_division / at.weight } else { f64::INFINITY };
            for (lamp, form) in world.lamps().iter().enumerate() {
                let mut sampler = vertex.sampler.fork();
                form.parts(at.ray.origin, jitter, fraction, &mut || sampler.pair(), &mut |sample| {
                    let wi = vertex.surface.bsdf().to_local(sample.direction);
                    let beta =
                        transport.aimed(vertex.beta, vertex.surface, wi, Arriving::Lamp(sample.omega), 1.0 / sample.omega, &[0.0; 4]);
                    self.shadow(transport, vertex, beta, (sample.direction, sample.distance), Emitter::Lamp(lamp));
                });
            }
            self.outcome.random |= jitter > 0.0;
            return;
        }
        let (u, v) = (self.draw(&mut vertex.sampler), self.draw(&mut vertex.sampler));
        let Some(sample) = world.sample_lamp(at.ray.origin, v[0], u) else { return };
        let wi = vertex.surface.bsdf().to_local(sample.to.direction);
        let counts = std::array::from_fn(|k| match counts[k] {
            count if count > 0.0 && sample.shared && vertex.surface.lamp_ratio(Part::ALL[k], wi).is_some() => count,
            _ => 0.0,
        });
        let beta = transport.aimed(vertex.beta, vertex.surface, wi, Arriving::Lamp(0.0), sample.pdf, &counts);
        self.shadow(transport, vertex, beta, (sample.to.direction, sample.to.distance), Emitter::Lamp(sample.lamp));
    }

    /// Light of the environment, for the parts that gather it.
    fn aim_at_environment<T: Transport<Beta = B>>(
        &mut self,
        transport: &mut T,
        vertex: &mut Vertex<T>,
        ways: &Ways,
        unhidden: &mut Option<Unhidden>,
    ) {
        if ways.aims == [0.0; 4] || !self.world.has_environment() {
            return;
        }
        let u = self.draw(&mut vertex.sampler);
        let Some((direction, pdf)) = self.world.sample_environment(vertex.at.ray.origin, u) else { return };
        let wi = vertex.surface.bsdf().to_local(direction);
        if let Some(unhidden) = unhidden {
            unhidden.take(vertex.surface.bsdf(), wi);
        }
        let beta = transport.aimed(vertex.beta, vertex.surface, wi, Arriving::Indirect, pdf, &ways.aims);
        self.shadow(transport, vertex, beta, (direction, f64::INFINITY), Emitter::Environment);
    }

    /// Sends a shadow ray in a direction, to something at a distance, and follows it at once, as far as the first surface.
    fn shadow<T: Transport<Beta = B>>(
        &mut self,
        transport: &mut T,
        vertex: &Vertex<T>,
        beta: B,
        (direction, distance): (Vec3, f64),
        aim: Emitter,
    ) {
        if transport.size(&beta) == 0.0 {
            return;
        }
        let at = vertex.at;
        let ray = Ray { origin: at.ray.origin, direction };
        let path = Path { ray, sampler: vertex.sampler, exact: vertex.exact, aim: Some(aim), kind: Kind::Shadow, ..*at };
        let path = if direction.dot(vertex.layer.point.geometric) < 0.0 { self.beyond(path, vertex.layer) } else { path.free() };
        if T::WATCHES || self.world.transparent() || distance < f64::INFINITY || path.limit < f64::INFINITY {
            let hit = self.world.nearest(&path.ray, path.limit);
            self.arrive(transport, &path, beta, hit.as_ref());
        } else if !self.world.occluded(&path.ray) {
            self.escape(transport, &path, beta);
        }
    }
}

/// How a path leaves a rough surface: by which part, with which factor on its weight, and whether its direction is not random.
struct Next {
    part: Part,
    weight: f64,
    exact: bool,
}
