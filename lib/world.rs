//! Scene → World: what is ready for rays, specialised to what the scene contains.
//!
//! Here a hit becomes the layers it is made of, a direction into the distance becomes what shines there, and lamps become a list to choose
//! from. What the scene does not use is not built: no table for a uniform environment, no shadow paths where nothing is transparent.

use crate::accel::{self, Accel, Geometry, Hit, Rank};
use crate::bsdf::{Bsdf, Point};
use crate::color::{Rgb, bright};
use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::geometry::{Mesh, Ray};
use crate::light::{self, Lamp, ToLamp};
use crate::material::{Inside, Material, Reflectance};
use crate::pattern::At;
use crate::rules::Rules;
use crate::scene::{Chain, ChainId, Distant, End, Form, Link, MaterialId, Named, Scene};
use crate::transform::Transform;
use crate::vector::Vec3;
use std::f64::consts::PI;
use std::sync::{Arc, LazyLock};

/// A scene that rays can be sent through.
pub struct World {
    accel: Accel,
    surfaces: Vec<Surface>,
    chains: Vec<Chain>,
    materials: Vec<Named>,
    sources: Vec<Source>,
    lamps: Vec<Lamp>,
    environment: Option<Environment>,
    transparent: bool,
    /// How RADIANCE's absolute thresholds are scaled.
    scale: f64,
    /// The material that is not known, if one is: what it fills has no known extinction.
    pub unknown: Option<MaterialId>,
}

/// What a hit surface is.
struct Surface {
    chains: Vec<ChainId>,
    lamp: Option<usize>,
    flat: bool,
    /// Its triangles, if it is a mesh. Lights on a mesh are mere appearance: it is never a light source.
    mesh: Option<(Arc<Mesh>, Transform)>,
}

/// A distant source that shines.
struct Source {
    direction: Vec3,
    spread: f64,
    chain: ChainId,
    lamp: Option<usize>,
}

/// One layer of what a hit is made of: a mixture has several.
pub struct Layer<'a> {
    /// Its share.
    pub fraction: f64,
    /// The material; `None` where there is none, and the ray goes on.
    pub material: Option<&'a Named>,
    /// The place of the material.
    pub id: MaterialId,
    /// What the patterns multiply its colour with.
    pub pattern: Rgb,
    /// Where the hit is, as a material needs to know it.
    pub point: Point,
    /// What it emits, if it emits.
    pub emission: Option<Emission>,
    /// What filled the way here, where the surface says so: the body that the ray leaves.
    pub behind: Option<Inside>,
}

/// How a ray comes to a surface.
pub struct Coming<'a> {
    /// The ray.
    pub ray: &'a Ray,
    /// Length of the path before it.
    pub travelled: f64,
    /// What it was aimed at.
    pub aim: Option<Emitter>,
    /// Whether it is the viewer's own, or has only gone straight on since.
    pub primary: bool,
}

/// Light that a path ends in.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// Radiance toward the viewer.
    pub radiance: Rgb,
    /// What emits it.
    pub emitter: Emitter,
    /// Whether it is a glow seen from beyond its radius, which is visible even where light sources are not.
    pub beyond: bool,
}

/// What emits light, as far as sampling goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Emitter {
    /// A lamp: rays are aimed at it.
    Lamp(usize),
    /// A distant glow: rays are aimed at it if it has a table.
    Environment,
    /// A glow that is no lamp: found by chance.
    Glow,
    /// Something that only the viewer sees, directly or in mirrors and glass.
    Hidden,
}

/// A direction aimed at one of the lamps.
#[derive(Clone, Copy, Debug)]
pub struct Aimed {
    /// Which lamp.
    pub lamp: usize,
    /// Where it is.
    pub to: ToLamp,
    /// The density of the direction, per solid angle, with the probability of choosing the lamp.
    pub pdf: f64,
    /// Whether the lamp is also found by sampling the surface.
    pub shared: bool,
}

/// The rows of the table of an environment.
const ENVIRONMENT_ROWS: usize = 512;

/// The largest distance: RADIANCE's infinity, which patterns see.
const FAR: f64 = 1e10;

impl World {
    /// The world of a scene. Surfaces without a material are not there; `rules` say whether backs are.
    pub fn new(scene: Scene, rules: &Rules) -> Result<Self> {
        let Scene { surfaces, sources, chains, materials, .. } = scene;
        let mut world = Self {
            accel: Accel::build(Vec::new())?,
            surfaces: Vec::new(),
            chains,
            materials,
            sources: Vec::new(),
            lamps: Vec::new(),
            environment: None,
            transparent: false,
            scale: 1.0,
            unknown: None,
        };
        let mut bodies = Vec::new();
        for surface in surfaces {
            if surface.chains.iter().all(|&c| world.is_void(c)) {
                continue;
            }
            world.transparent |= !rules.back_visible || surface.chains.iter().any(|&c| world.transmits(c));
            let (geometry, flat, mesh, lamp) = match surface.form {
                Form::Shape(shape) => {
                    let form = || light::Form::of(&shape).map_err(|e| Error::new(format!("{}: {e}", surface.name)));
                    let lamp = world.lamp(surface.chains[0], form)?;
                    let flat = shape.flat();
                    (Geometry::Shape(shape), flat, None, lamp)
                }
                Form::Mesh(mesh, transform) => (Geometry::Mesh(mesh.clone(), transform.affine), true, Some((mesh, transform)), None),
            };
            bodies.push(accel::Surface { geometry, ranks: surface.chains.iter().map(|&c| world.rank(c)).collect() });
            world.surfaces.push(Surface { chains: surface.chains, lamp, flat, mesh });
        }
        for source in sources {
            world.source(source)?;
        }
        world.accel = Accel::build(bodies)?;
        let bounds = world.accel.bounds();
        if !bounds.is_empty() {
            world.scale = if bounds.size() < 1e-3 { bounds.size() / 1e-3 } else { (bounds.size() / 1e3).max(1.0) };
        }
        let middle = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
        if world.sources.iter().any(|s| s.lamp.is_none()) {
            world.environment = Environment::new(ENVIRONMENT_ROWS, |d| world.glow(middle, d).map_or(Rgb::ZERO, |e| e.radiance));
        }
        Ok(world)
    }

    /// Whether there is nothing at the end of a chain.
    fn is_void(&self, chain: ChainId) -> bool {
        match self.chains[chain].end {
            End::Void => true,
            End::Material(_) => false,
            End::Mixture(_, fore, back) => self.is_void(fore) && self.is_void(back),
        }
    }

    /// Whether light may pass through a surface of this chain in a single direction.
    fn transmits(&self, chain: ChainId) -> bool {
        match self.chains[chain].end {
            End::Void => true,
            End::Material(m) => self.materials[m].material.transparent(),
            End::Mixture(_, fore, back) => self.transmits(fore) || self.transmits(back),
        }
    }

    /// What decides between coincident surfaces (semantics 2.1).
    fn rank(&self, chain: ChainId) -> Rank {
        match self.chains[chain].end {
            End::Void => Rank::default(),
            End::Material(m) => Rank { class: if self.transmits(chain) { 1 } else { 2 }, order: self.materials[m].order },
            End::Mixture(_, fore, back) => self.rank(fore).max(self.rank(back)),
        }
    }

    /// Adds a lamp if the chain makes its bearer one; returns its number.
    fn lamp(&mut self, chain: ChainId, form: impl FnOnce() -> Result<light::Form>) -> Result<Option<usize>> {
        let End::Material(m) = self.chains[chain].end else { return Ok(None) };
        let (radiance, radius, focus) = match self.materials[m].material {
            Material::Light(radiance) | Material::Illum(radiance) => (radiance, f64::INFINITY, 0.0),
            Material::Spotlight(radiance, _, aim) => (radiance, f64::INFINITY, aim.length()),
            Material::Glow(radiance, radius) if radius > 1e-6 => (radiance, radius, 0.0),
            _ => return Ok(None),
        };
        let form = form()?;
        let distant = matches!(form, light::Form::Distant(..));
        // A light without light is dropped; a distant glow is never a lamp (semantics 2.2, 3.8).
        if radiance.max_element() <= 1e-6 || distant && matches!(self.materials[m].material, Material::Glow(..)) {
            return Ok(None);
        }
        let shared = focus == 0.0 && !matches!(self.materials[m].material, Material::Illum(_));
        self.lamps.push(Lamp { form, brightness: bright(radiance).abs(), radius, focus, shared });
        Ok(Some(self.lamps.len() - 1))
    }

    /// Adds a distant source if it shines.
    fn source(&mut self, source: Distant) -> Result<()> {
        let End::Material(m) = self.chains[source.chain].end else { return Ok(()) };
        let lamp = self.lamp(source.chain, || Ok(light::Form::Distant(source.direction, source.spread)))?;
        if lamp.is_some() || matches!(self.materials[m].material, Material::Glow(..)) {
            self.sources.push(Source { direction: source.direction, spread: source.spread, chain: source.chain, lamp });
        }
        Ok(())
    }

    /// The nearest surface along a ray, within `limit`.
    pub fn nearest(&self, ray: &Ray, limit: f64) -> Option<Hit> {
        self.accel.nearest(ray, self.epsilon(ray.origin), limit)
    }

    /// Whether what a ray meets first is made of a material.
    pub fn shows(&self, ray: &Ray, material: MaterialId) -> bool {
        let Some(hit) = self.nearest(ray, f64::INFINITY) else { return false };
        let surface = &self.surfaces[hit.surface as usize];
        let mut chains = vec![self.chain_of(surface, &hit)];
        while let Some(chain) = chains.pop() {
            match self.chains[chain].end {
                End::Material(m) if m == material => return true,
                End::Mixture(_, fore, back) => chains.extend([fore, back]),
                _ => {}
            }
        }
        false
    }

    /// The chain of the part of a surface that was hit.
    fn chain_of(&self, surface: &Surface, hit: &Hit) -> ChainId {
        let material = surface.mesh.as_ref().map_or(0, |(mesh, _)| mesh.material(hit.triangle) as usize);
        surface.chains[material.min(surface.chains.len() - 1)]
    }

    /// Whether there is any surface along a ray.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.accel.occluded(ray, self.epsilon(ray.origin), f64::INFINITY)
    }

    /// The distance within which a ray does not see the surface it starts from: RADIANCE's 1e-6 for scenes of 1e-3 to 1e3 in size, in
    /// proportion to the size beyond, and never less than what positions are exact to.
    fn epsilon(&self, origin: Vec3) -> f64 {
        (1e-6 * self.scale).max(origin.abs().max_element() * 1e-14)
    }

    /// Whether anything lets light through in a single direction, so that shadow rays are paths.
    pub fn transparent(&self) -> bool {
        self.transparent
    }

    /// The lamps.
    pub fn lamps(&self) -> &[Lamp] {
        &self.lamps
    }

    /// One of the lamps, and a direction to it. `choice` and `u` are uniform in [0, 1).
    pub fn sample_lamp(&self, from: Vec3, choice: f64, u: [f64; 2]) -> Option<Aimed> {
        let total: f64 = self.lamps.iter().map(|l| l.importance(from)).sum();
        let mut left = choice * total;
        let lamp = self.lamps.iter().position(|l| {
            left -= l.importance(from);
            left < 0.0
        })?;
        let to = self.lamps[lamp].sample(from, u)?;
        let pdf = self.lamps[lamp].importance(from) / total / to.omega;
        Some(Aimed { lamp, to, pdf, shared: self.lamps[lamp].shared })
    }

    /// The density with which [`World::sample_lamp`] finds `lamp` in a direction; 0 if it is not there.
    pub fn lamp_pdf(&self, lamp: usize, from: Vec3, direction: Vec3) -> f64 {
        let l = &self.lamps[lamp];
        if !l.shared {
            return 0.0;
        }
        let choice =
            if self.lamps.len() == 1 { 1.0 } else { l.importance(from) / self.lamps.iter().map(|l| l.importance(from)).sum::<f64>() };
        choice * l.pdf(from, direction)
    }

    /// Whether directions are aimed at the environment.
    pub fn has_environment(&self) -> bool {
        self.environment.is_some()
    }

    /// A direction aimed at the environment, and its density.
    pub fn sample_environment(&self, u: [f64; 2]) -> Option<(Vec3, f64)> {
        self.environment.as_ref()?.sample(u)
    }

    /// The density of [`World::sample_environment`].
    pub fn environment_pdf(&self, direction: Vec3) -> f64 {
        self.environment.as_ref().map_or(0.0, |e| e.pdf(direction))
    }

    /// What shines from a direction behind everything: the first light that contains it, else the first glow (semantics 2.2).
    pub fn sky(&self, origin: Vec3, direction: Vec3) -> Option<Emission> {
        self.sources
            .iter()
            .filter(|s| s.lamp.is_some())
            .find(|s| s.contains(direction))
            .and_then(|s| self.shine(s, origin, direction))
            .or_else(|| self.glow(origin, direction))
    }

    /// The first glow that contains a direction.
    fn glow(&self, origin: Vec3, direction: Vec3) -> Option<Emission> {
        let source = self.sources.iter().filter(|s| s.lamp.is_none()).find(|s| s.contains(direction))?;
        self.shine(source, origin, direction)
    }

    /// What a distant source emits.
    fn shine(&self, source: &Source, origin: Vec3, direction: Vec3) -> Option<Emission> {
        let chain = &self.chains[source.chain];
        let End::Material(m) = chain.end else { return None };
        let at = At::distant(direction, origin);
        let (pattern, _) = apply(&chain.links, &at, Rgb::ONE, Vec3::ZERO);
        let emitter = |glow: Emitter| source.lamp.map_or(glow, Emitter::Lamp);
        Some(match &self.materials[m].material {
            Material::Glow(radiance, radius) => {
                let seen = if *radius < -1e-6 || *radius >= FAR { Emitter::Hidden } else { Emitter::Environment };
                Emission { radiance: *radiance * pattern, emitter: seen, beyond: FAR > *radius }
            }
            material => Emission { radiance: material.emitted(direction) * pattern, emitter: emitter(Emitter::Hidden), beyond: false },
        })
    }

    /// Shows `out` the layers of what a ray hit.
    pub fn layers(&self, hit: &Hit, coming: &Coming, rules: &Rules, out: &mut dyn FnMut(&Layer)) {
        let surface = &self.surfaces[hit.surface as usize];
        let direction = coming.ray.direction;
        let mut place = Place {
            world: self,
            surface,
            rules,
            coming,
            distance: hit.t,
            at: At {
                direction,
                normal: hit.normal,
                point: hit.point,
                t: coming.travelled + hit.t,
                ts: hit.t,
                rdot: (-direction.dot(hit.normal)).clamp(-1.0, 1.0),
                uv: [0.0; 2],
                instance: None,
            },
            out,
        };
        let mut perturbation = Vec3::ZERO;
        if let Some((mesh, transform)) = &surface.mesh {
            if let Some(uv) = mesh.uv(hit.triangle, hit.barycentric) {
                place.at.uv = uv;
            }
            if let Some(normal) = mesh.normal(hit.triangle, hit.barycentric) {
                perturbation = transform.vector(normal).normalize() - hit.normal;
            }
        }
        place.walk(self.chain_of(surface, hit), 1.0, Rgb::ONE, perturbation);
    }
}

/// A hit on its way down the chains of its modifier.
struct Place<'a> {
    world: &'a World,
    surface: &'a Surface,
    rules: &'a Rules,
    coming: &'a Coming<'a>,
    distance: f64,
    at: At<'a>,
    out: &'a mut dyn FnMut(&Layer),
}

impl Place<'_> {
    /// Shows the layers of a chain that has the share `fraction`.
    fn walk(&mut self, chain: ChainId, fraction: f64, pattern: Rgb, perturbation: Vec3) {
        let chain = &self.world.chains[chain];
        let (pattern, perturbation) = apply(&chain.links, &self.at, pattern, perturbation);
        match &chain.end {
            End::Void => self.show(fraction, None, pattern, perturbation),
            End::Material(id) => self.show(fraction, Some(*id), pattern, perturbation),
            End::Mixture(coefficient, fore, back) => {
                let c = coefficient.coefficient(&self.at).unwrap_or(0.0);
                for (share, chain) in [(c, *fore), (1.0 - c, *back)] {
                    if share > 1e-6 {
                        self.walk(chain, fraction * share, pattern, perturbation);
                    }
                }
            }
        }
    }

    /// Shows one layer.
    fn show(&mut self, fraction: f64, id: Option<MaterialId>, pattern: Rgb, perturbation: Vec3) {
        let front = self.at.rdot > 0.0;
        let named = id.map(|id| &self.world.materials[id]);
        let mut layer = Layer {
            fraction,
            material: named,
            id: id.unwrap_or(0),
            pattern,
            point: self.point(named, front, perturbation),
            emission: None,
            behind: None,
        };
        let Some(named) = named else { return (self.out)(&layer) };
        if self.rules.irradiance && self.coming.primary && !named.material.transparent() {
            layer.material = Some(&*COLLECTOR);
            return (self.out)(&layer);
        }
        match &named.material {
            // The back of a surface that does not use its side is not there.
            material if !front && !self.rules.back_visible && material.backless() => layer.material = None,
            // What is not aimed at sees the alternate of an illum.
            Material::Illum(_) if self.coming.aim.is_none() || self.coming.aim != self.surface.lamp.map(Emitter::Lamp) => {
                return match named.alternate {
                    Some(chain) => self.walk(chain, fraction, Rgb::ONE, Vec3::ZERO),
                    None => (self.out)(&Layer { material: None, ..layer }),
                };
            }
            Material::Mirror(_) => {
                if let Some(chain) = named.alternate {
                    return self.walk(chain, fraction, Rgb::ONE, Vec3::ZERO);
                }
            }
            Material::Light(_) | Material::Illum(_) | Material::Spotlight(..) if front => {
                let emitter = self.surface.lamp.map_or(Emitter::Hidden, Emitter::Lamp);
                layer.emission = Some(Emission { radiance: named.material.emitted(self.at.direction) * pattern, emitter, beyond: false });
            }
            Material::Glow(radiance, radius) if front => {
                let emitter = match self.surface.lamp {
                    Some(lamp) if self.distance <= *radius => Emitter::Lamp(lamp),
                    _ if *radius < -1e-6 => Emitter::Hidden,
                    _ => Emitter::Glow,
                };
                layer.emission = Some(Emission { radiance: *radiance * pattern, emitter, beyond: self.at.t > *radius });
            }
            // A ray that meets the surface from inside has come through the body.
            Material::Dielectric(inside) | Material::Interface(inside, _) if !front => {
                layer.behind = Some(Inside { extinction: inside.extinction(pattern), unknown: self.world.unknown == id });
            }
            Material::Interface(_, outside) => layer.behind = Some(Inside::of(outside.extinction(Rgb::ONE))),
            _ => {}
        }
        (self.out)(&layer);
    }

    /// The hit as a material needs to know it.
    fn point(&self, named: Option<&Named>, front: bool, perturbation: Vec3) -> Point {
        let sign = if front { 1.0 } else { -1.0 };
        let (to_viewer, geometric) = (-self.at.direction, self.at.normal * sign);
        let orientation = named.and_then(|n| n.orientation.as_ref()).map_or(Vec3::ZERO, |o| o.perturbation(&self.at));
        if perturbation.length_squared() <= 1e-12 {
            return Point {
                to_viewer,
                geometric,
                shading: geometric,
                perturbation: Vec3::ZERO,
                front,
                flat: self.surface.flat,
                orientation,
            };
        }
        let perturbation = perturbation * sign;
        let mut shading = (geometric + perturbation).normalize();
        // A normal that is bent away from the viewer is turned back (semantics 3.2).
        if shading.dot(to_viewer) <= 0.0 {
            shading -= to_viewer * (2.0 * shading.dot(to_viewer));
        }
        Point { to_viewer, geometric, shading, perturbation, front, flat: false, orientation }
    }
}

/// What `-i` puts in the place of a surface: Lambertian, of reflectance π, so that its radiance is the irradiance.
static COLLECTOR: LazyLock<Named> = LazyLock::new(|| Named {
    name: String::new(),
    material: Material::Reflectance(Reflectance::diffuse(Rgb::splat(PI))),
    orientation: None,
    alternate: None,
    order: 0,
});

/// The pattern and perturbation behind a list of links.
fn apply(links: &[Link], at: &At, mut pattern: Rgb, mut perturbation: Vec3) -> (Rgb, Vec3) {
    for link in links {
        match link {
            Link::Pattern(p) => pattern *= p.color(at),
            Link::Texture(t) => perturbation += t.perturbation(at),
        }
    }
    (pattern, perturbation)
}

impl Source {
    /// Whether the direction lies in its cone.
    fn contains(&self, direction: Vec3) -> bool {
        // RADIANCE keeps the solid angle in single precision.
        2.0 * PI * (1.0 - direction.dot(self.direction)) <= (2.0 * PI * self.spread) as f32 as f64
    }
}

impl Layer<'_> {
    /// What it does to light that it does not emit.
    pub fn bsdf(&self, rules: &Rules) -> Bsdf {
        match self.material {
            Some(named) if self.emission.is_none() => Bsdf::new(&named.material, &self.point, self.pattern, rules),
            _ => Bsdf::black(&self.point),
        }
    }
}
