//! Scene → World: what is ready for rays, specialised to what the scene contains.
//!
//! Here a hit becomes the layers it is made of, a direction into the distance becomes what shines there, and lamps become a list to choose
//! from. What the scene does not use is not built: no table for a uniform environment, no shadow paths where nothing is transparent.

mod build;
mod clip;
mod field;
mod globes;
mod hidden;
mod layers;
mod open;
mod pools;

pub use clip::Clip;
pub use hidden::Lit;
pub use layers::{Coming, Emission, Emitter, Layer};
pub use open::Open;
pub use pools::{MOST_POOLS, Pool};

use crate::accel::{Accel, Hit};
use crate::environment::Environment;
use crate::geometry::{Mesh, Ray};
use crate::light::{Lamp, ToLamp};
use crate::material::Material;
use crate::panorama::Place;
use crate::scene::{Chain, ChainId, End, Link, MaterialId, Named};
use crate::transform::Transform;
use crate::vector::Vec3;
use field::Probes;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::sync::Arc;

/// A scene that rays can be sent through.
pub struct World {
    accel: Accel,
    surfaces: Vec<Surface>,
    chains: Vec<Chain>,
    materials: Vec<Named>,
    sources: Vec<Source>,
    lamps: Vec<Lamp>,
    environment: Option<Environment>,
    /// Environments that were measured at places: they are the sky then.
    probes: Option<Probes>,
    /// What the view that it was surveyed for has of the environment, if that is much.
    open: Option<Open>,
    /// Where much of the light of what it shows comes from, if that is from small places.
    pools: Vec<Pool>,
    transparent: bool,
    /// Whether there are surfaces that bend what passes them, but not what is aimed.
    bends: bool,
    /// For each chain, whether the surfaces that bear it gather indirect light; empty if all do.
    gathers: Vec<bool>,
    /// For each chain, whether antimatter removes it; empty without antimatter.
    removable: Vec<bool>,
    /// Distances that differ by less are one place ([`crate::geometry::tolerance`]).
    tolerance: f64,
    /// The material that is not known, if one is: what it fills has no known extinction.
    pub unknown: Option<MaterialId>,
}

/// What a hit surface is.
struct Surface {
    name: String,
    chains: Vec<ChainId>,
    lamp: Option<usize>,
    body: Body,
}

/// What makes up a surface.
enum Body {
    /// One shape, and whether it is flat.
    Shape(bool),
    /// Triangles, and whether the mesh has a modifier of its own. Lights on a mesh are mere appearance: it is never a light source.
    Mesh(Arc<Mesh>, Transform, bool),
    /// Other surfaces, placed.
    Group(Arc<Vec<Surface>>, Transform),
}

/// A distant source that shines.
struct Source {
    name: String,
    direction: Vec3,
    spread: f64,
    chain: ChainId,
    lamp: Option<usize>,
    /// An illum that shows what is behind it.
    illum: bool,
}

/// Which surface was hit, inside instances and meshes.
struct Found<'a> {
    name: &'a str,
    chain: ChainId,
    lamp: Option<usize>,
    /// Whether RADIANCE takes it for flat.
    flat: bool,
    /// The triangles, and where they are.
    mesh: Option<(&'a Mesh, Transform)>,
    /// What its modifiers take for the world.
    frame: Option<Transform>,
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

/// What a ray meets, by name. A mesh without a modifier of its own shows what its triangles have.
#[derive(Clone, Copy, Debug)]
pub struct Names<'a> {
    /// The identifier of the surface.
    pub surface: &'a str,
    /// The name of its modifier.
    pub modifier: &'a str,
    /// The name of the material, or mixture, among the modifiers behind it.
    pub material: &'a str,
}

/// So many panes and mirrors are looked through and into, one behind the other.
const MOST_PANES: usize = 16;

/// What RADIANCE calls a triangle of a mesh.
const TRIANGLE: &str = "M-Tri";

/// What has no modifier or no material.
const VOID: &str = "void";

impl World {
    /// The nearest surface along a ray, within `limit`.
    pub fn nearest(&self, ray: &Ray, limit: f64) -> Option<Hit> {
        self.accel.nearest(ray, self.epsilon(ray.origin), limit)
    }

    /// What [`World::nearest`] finds for each of some rays and limits, told in their order with their numbers: quicker where rays are beside those
    /// before them.
    pub fn nearest_each<'r>(&self, rays: impl IntoIterator<Item = (&'r Ray, f64)>, found: impl FnMut(usize, Option<Hit>)) {
        self.accel.nearest_each(rays.into_iter().map(|(ray, limit)| (ray, [self.epsilon(ray.origin), limit])), found);
    }

    /// Whether what a ray that goes so far shows is made of a material: what it meets first, but for panes of glass, which it looks through, and mirrors,
    /// which it looks into.
    pub fn shows(&self, ray: &Ray, limit: f64, material: MaterialId) -> bool {
        self.shown(ray, limit, material).is_some()
    }

    /// The rest of a ray, straight on, from where it shows a material; `None` if it does not.
    pub fn behind(&self, ray: &Ray, material: MaterialId) -> Option<Ray> {
        self.shown(ray, f64::INFINITY, material).map(|(rest, _)| rest)
    }

    /// That, and the normal of what it shows there.
    pub fn shown(&self, ray: &Ray, limit: f64, material: MaterialId) -> Option<(Ray, Vec3)> {
        let (mut ray, mut left) = (*ray, limit);
        for _ in 0..MOST_PANES {
            let hit = self.nearest(&ray, left)?;
            let mut ends = Vec::new();
            self.ends(self.find(&hit).chain, &mut ends);
            if ends.contains(&Some(material)) {
                return Some((Ray::new(hit.point, ray.direction), hit.normal));
            }
            let direction = ends.iter().find_map(|end| self.onward(*end, ray.direction, hit.normal))?;
            // What is seen in a mirror may lie anywhere, as in RADIANCE.
            left = if direction == ray.direction { left - hit.t } else { f64::INFINITY };
            ray = Ray::new(hit.point, direction);
        }
        None
    }

    /// The materials at the ends of a chain, with what an illum or a mirror stands for; `None` for each end without one.
    fn ends(&self, chain: ChainId, out: &mut Vec<Option<MaterialId>>) {
        match self.chains[chain].end {
            End::Material(m) => match self.materials[m] {
                // It mirrors lamps alone.
                Named { material: Material::Mirror(_), alternate: Some(chain), .. } => self.ends(chain, out),
                Named { material: Material::Illum(_), alternate: Some(chain), .. } => {
                    out.push(Some(m));
                    self.ends(chain, out);
                }
                _ => out.push(Some(m)),
            },
            End::Mixture(_, fore, back) => [fore, back].into_iter().for_each(|chain| self.ends(chain, out)),
            End::Void => out.push(None),
        }
    }

    /// Where a look goes on from a material that is looked through or into.
    fn onward(&self, material: Option<MaterialId>, direction: Vec3, normal: Vec3) -> Option<Vec3> {
        match material.map(|m| &self.materials[m].material) {
            None | Some(Material::Glass(_)) => Some(direction),
            Some(Material::Mirror(_)) if direction.dot(normal) < 0.0 => Some(direction.reflect(normal)),
            _ => None,
        }
    }

    /// Whether there is any surface along a ray.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.accel.occluded(ray, self.epsilon(ray.origin), f64::INFINITY)
    }

    /// The middle of all surfaces.
    fn middle(&self) -> Vec3 {
        let bounds = self.accel.bounds();
        if bounds.is_empty() { Vec3::ZERO } else { bounds.center() }
    }

    /// The distance within which a ray does not see the surface it starts from: never less than what positions are exact to.
    fn epsilon(&self, origin: Vec3) -> f64 {
        self.tolerance.max(origin.abs().max_element() * 1e-14)
    }

    /// What is to be said of patterns, textures and mixtures that had no value for some ray so far, once each.
    pub fn failures(&self) -> BTreeSet<String> {
        let mut links: Vec<&Link> = self.chains.iter().flat_map(|chain| &chain.links).collect();
        let mut said = BTreeSet::new();
        while let Some(link) = links.pop() {
            said.extend(match link {
                Link::Pattern(pattern) => pattern.expressions().failure(),
                Link::Texture(texture) => texture.expressions().failure(),
                Link::Mixture(mixed) => {
                    let (mixture, fore, back) = &**mixed;
                    links.extend(fore.iter().chain(back));
                    mixture.expressions().failure()
                }
            });
        }
        for chain in &self.chains {
            if let End::Mixture(mixture, ..) = &chain.end {
                said.extend(mixture.expressions().failure());
            }
        }
        said.extend(self.materials.iter().filter_map(|named| named.orientation.as_ref()?.expressions().failure()));
        said
    }

    /// Whether anything lets light through in a single direction, so that shadow rays are paths.
    pub fn transparent(&self) -> bool {
        self.transparent
    }

    /// Whether some surfaces bend what passes them, but not what is aimed through them.
    pub fn bends(&self) -> bool {
        self.bends
    }

    /// The materials by name.
    pub fn materials(&self) -> &[Named] {
        &self.materials
    }

    /// The names of what was hit.
    pub fn names(&self, hit: &Hit) -> Names<'_> {
        let found = self.find(hit);
        self.names_of(found.name, found.chain)
    }

    /// The names of the distant source that shines from a direction.
    pub fn source_names(&self, direction: Vec3) -> Option<Names<'_>> {
        self.source(direction, None, false).map(|source| self.names_of(&source.name, source.chain))
    }

    fn names_of<'a>(&'a self, surface: &'a str, chain: ChainId) -> Names<'a> {
        let known = |name: &'a str| if name.is_empty() { VOID } else { name };
        let chain = &self.chains[chain];
        let material = match &chain.end {
            End::Void => VOID,
            End::Material(m) => &self.materials[*m].name,
            End::Mixture(..) => known(&chain.name),
        };
        Names { surface, modifier: known(&chain.name), material }
    }

    /// The surface that was hit.
    fn find(&self, hit: &Hit) -> Found<'_> {
        let mut surface = &self.surfaces[hit.surface as usize];
        if let Body::Shape(flat) = surface.body {
            let Surface { name, chains, lamp, .. } = surface;
            return Found { name, chain: chains[0], lamp: *lamp, flat, mesh: None, frame: None };
        }
        // The first instance with a modifier stands for all that is in it.
        let (mut placed, mut frame, mut instead) = (None::<Transform>, None, None);
        let mut path = hit.path.surfaces().iter();
        while let Body::Group(surfaces, transform) = &surface.body {
            placed = Some(placed.map_or(*transform, |outer| transform.then(&outer)));
            if instead.is_none() {
                match surface.chains.first() {
                    Some(&chain) => instead = Some((surface, chain)),
                    None => frame = placed,
                }
            }
            let Some(&inner) = path.next() else { break };
            surface = &surfaces[inner as usize];
        }
        let mut found = Found { name: &surface.name, chain: 0, lamp: None, flat: false, mesh: None, frame };
        match &surface.body {
            Body::Mesh(mesh, transform, own) => {
                let here = placed.map_or(*transform, |outer| transform.then(&outer));
                let material = mesh.material(hit.triangle) as usize;
                found.chain = surface.chains[material.min(surface.chains.len() - 1)];
                found.mesh = Some((mesh, here));
                if !own {
                    (found.name, found.flat) = (TRIANGLE, true);
                    found.frame = if instead.is_none() { Some(here) } else { frame };
                }
            }
            Body::Shape(flat) => (found.chain, found.flat) = (surface.chains[0], *flat),
            Body::Group(..) => {}
        }
        if let Some((surface, chain)) = instead {
            (found.name, found.chain, found.flat) = (&surface.name, chain, false);
        }
        found
    }

    /// The distant sources: direction, and the angle from there to the rim, radians.
    pub fn sources(&self) -> impl Iterator<Item = (Vec3, f64)> {
        self.sources.iter().map(|s| (s.direction, s.half()))
    }

    /// The lamps, those seen in mirrors included.
    pub fn lamps(&self) -> &[Lamp] {
        &self.lamps
    }

    /// One of the lamps, and a direction to it. `choice` and `u` are uniform in [0, 1).
    pub fn sample_lamp(&self, from: Vec3, choice: f64, u: [f64; 2]) -> Option<Aimed> {
        let (mut few, mut many) = ([0.0; 16], Vec::new());
        let importances = match self.lamps.len() {
            count @ 0..=16 => &mut few[..count],
            count => {
                many.resize(count, 0.0);
                &mut many[..]
            }
        };
        importances.iter_mut().zip(&self.lamps).for_each(|(importance, lamp)| *importance = lamp.importance(from));
        let total: f64 = importances.iter().sum();
        let mut left = choice * total;
        let lamp = importances.iter().position(|importance| {
            left -= importance;
            left < 0.0
        })?;
        let to = self.lamps[lamp].sample(from, u)?;
        Some(Aimed { lamp, to, pdf: importances[lamp] / total / to.omega, shared: self.lamps[lamp].shared })
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
        self.environment.is_some() || self.probes.as_ref().is_some_and(Probes::are_aimed_at)
    }

    /// Whether the environment differs from place to place, as it was measured at some.
    pub fn has_field(&self) -> bool {
        self.probes.is_some()
    }

    /// A direction aimed at the environment of a point, and its density.
    pub fn sample_environment(&self, from: Vec3, u: [f64; 2]) -> Option<(Vec3, f64)> {
        match &self.probes {
            Some(probes) => probes.sample(from, u),
            None => self.environment.as_ref()?.sample(u),
        }
    }

    /// The density of [`World::sample_environment`].
    pub fn environment_pdf(&self, from: Vec3, direction: Vec3) -> f64 {
        self.aimed(from, Place::of(direction))
    }

    /// The same of the direction at a place.
    fn aimed(&self, from: Vec3, place: Place) -> f64 {
        match &self.probes {
            Some(probes) => probes.pdf(from, place),
            None => self.environment.as_ref().map_or(0.0, |e| e.pdf(place)),
        }
    }

    /// The source that a ray sees behind everything: what it was aimed at, else the first light that contains the direction, else the first
    /// glow. `gathered` is whether the ray gathers indirect light: it must not count twice what an illum stands for.
    fn source(&self, direction: Vec3, aim: Option<Emitter>, gathered: bool) -> Option<&Source> {
        if let Some(Emitter::Lamp(lamp)) = aim {
            return self.sources.iter().find(|s| s.lamp == Some(lamp) && s.contains(direction));
        }
        let (mut glow, mut illum) = (None, false);
        for source in self.sources.iter().filter(|s| s.contains(direction)) {
            if source.lamp.is_none() {
                glow = glow.or(Some(source));
            } else if source.illum {
                illum = true;
            } else {
                return Some(source);
            }
        }
        glow.filter(|_| !(illum && gathered))
    }
}

impl Source {
    /// The angle from its middle to its rim, radians.
    fn half(&self) -> f64 {
        2.0 * (0.5 * self.spread).clamp(0.0, 1.0).sqrt().asin()
    }

    /// Whether the direction lies in its cone.
    fn contains(&self, direction: Vec3) -> bool {
        // RADIANCE keeps the solid angle in single precision. Half the square of a chord is 1 − cos.
        PI * direction.distance_squared(self.direction) <= (2.0 * PI * self.spread) as f32 as f64
    }
}
