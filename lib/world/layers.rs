//! What a ray meets: the layers of a surface, and what shines behind everything.

use super::{Clip, Found, Source, World};
use crate::accel::Hit;
use crate::bsdf::{Bsdf, Point};
use crate::color::Rgb;
use crate::error::{Source as Text, Span};
use crate::geometry::{FAR, Ray, TINY};
use crate::material::{Inside, Material, Reflectance};
use crate::pattern::At;
use crate::rules::Rules;
use crate::scene::{Chain, ChainId, End, Link, MaterialId, Named};
use crate::vector::Vec3;
use std::f64::consts::PI;
use std::sync::LazyLock;

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
    /// The hit as expressions see it.
    pub at: At<'a>,
    /// What it emits, if it emits.
    pub emission: Option<Emission>,
    /// What filled the way here, where the surface says so: the body that the ray leaves.
    pub behind: Option<Inside>,
    /// Whether it gathers indirect light (if not, a given value stands for it).
    pub gathers: bool,
    /// Where it relays a shadow ray that was aimed at it: the lamp to aim at from here.
    pub relay: Option<usize>,
    /// Whether it is a back that is not there but for what is aimed at lamps: these do not light what is behind it.
    pub shades: bool,
    /// What becomes of a ray among antimatter that passes; `None` where nothing changes.
    pub clip: Option<Box<Clip>>,
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
    /// Whether it gathers indirect light: a diffuse or rough scattering was on its way.
    pub gathered: bool,
    /// Whether it gathers diffuse light, which goes straight through textures.
    pub ambient: bool,
    /// Its state among antimatter.
    pub clip: Option<&'a Clip>,
}

impl<'a> Coming<'a> {
    /// The viewer's own ray, where it first meets something.
    pub fn viewer(ray: &'a Ray) -> Self {
        Self { ray, travelled: 0.0, aim: None, primary: true, gathered: false, ambient: false, clip: None }
    }

    /// The lamp that it was aimed at.
    fn lamp(&self) -> Option<usize> {
        if let Some(Emitter::Lamp(lamp)) = self.aim { Some(lamp) } else { None }
    }

    /// Its state among antimatter, to be changed.
    fn clip(&self) -> Clip {
        self.clip.cloned().unwrap_or_default()
    }
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

/// Whether a glow that far away is beyond its radius. One without any, below 0, is not; as in RADIANCE, which takes it for a lamp there.
fn is_beyond(distance: f64, radius: f64) -> bool {
    radius >= -TINY && distance > radius
}

impl Emission {
    /// No light.
    const BLACK: Self = Self { radiance: Rgb::ZERO, emitter: Emitter::Hidden, beyond: false };
}

impl World {
    /// What shines from a direction behind everything, for a ray aimed at `aim`, or that gathers indirect light or not.
    pub fn sky(&self, origin: Vec3, direction: Vec3, aim: Option<Emitter>, gathered: bool) -> Option<Emission> {
        let aimed = matches!(aim, Some(Emitter::Lamp(_)));
        self.source(direction, aim, gathered).and_then(|source| self.shine(source, origin, direction, aimed, gathered))
    }

    /// The radiance of the first glow that contains a direction.
    pub(super) fn glow(&self, origin: Vec3, direction: Vec3) -> Rgb {
        let source = self.sources.iter().find(|s| s.lamp.is_none() && s.contains(direction));
        source.and_then(|s| self.shine(s, origin, direction, false, false)).map_or(Rgb::ZERO, |e| e.radiance)
    }

    /// What a distant source emits. An illum that was not aimed at is its alternate.
    fn shine(&self, source: &Source, origin: Vec3, direction: Vec3, aimed: bool, gathered: bool) -> Option<Emission> {
        if let (None, Some(probes)) = (source.lamp, &self.probes) {
            return probes.emission(self, origin, direction);
        }
        let (mut chain, mut lamp) = (source.chain, source.lamp);
        let material = self.material_of(&self.chains[chain])?;
        if let (Material::Illum(_), false) = (&material.material, aimed) {
            if gathered {
                return None;
            }
            (chain, lamp) = (material.alternate?, None);
        }
        self.emitted(chain, lamp, origin, direction)
    }

    /// What a chain emits as a distant source, which is `lamp` if it is one.
    pub(super) fn emitted(&self, chain: ChainId, lamp: Option<usize>, origin: Vec3, direction: Vec3) -> Option<Emission> {
        let chain = &self.chains[chain];
        let material = self.material_of(chain)?;
        let (pattern, _) = apply(&chain.links, &At::distant(direction, origin), Rgb::ONE, Vec3::ZERO);
        Some(match &material.material {
            Material::Glow(radiance, radius) => {
                let seen = if *radius < -TINY || *radius >= FAR { Emitter::Hidden } else { Emitter::Environment };
                Emission { radiance: *radiance * pattern, emitter: seen, beyond: is_beyond(FAR, *radius) }
            }
            material => {
                let emitter = lamp.map_or(Emitter::Hidden, Emitter::Lamp);
                Emission { radiance: material.emitted(direction) * pattern, emitter, beyond: false }
            }
        })
    }

    /// The material at the end of a chain.
    fn material_of(&self, chain: &Chain) -> Option<&Named> {
        if let End::Material(m) = chain.end { Some(&self.materials[m]) } else { None }
    }

    /// Shows `out` the layers of what a ray hit.
    pub fn layers(&self, hit: &Hit, coming: &Coming, rules: &Rules, out: &mut dyn FnMut(&Layer)) {
        let found = self.find(hit);
        let direction = coming.ray.direction;
        let mut place = Place {
            world: self,
            surface: hit.surface,
            found: &found,
            rules,
            coming,
            distance: hit.t,
            at: At {
                t: coming.travelled + hit.t,
                ts: hit.t,
                instance: found.frame.as_ref(),
                ..At::surface(direction, hit.normal, hit.point)
            },
            clip: None,
            out,
        };
        let mut perturbation = Vec3::ZERO;
        if let Some((mesh, transform)) = &found.mesh {
            if let Some(uv) = mesh.uv(hit.triangle, hit.barycentric) {
                place.at.uv = uv;
            }
            if let Some(normal) = mesh.normal(hit.triangle, hit.barycentric) {
                perturbation = transform.vector(normal).normalize() - hit.normal;
            }
        }
        if coming.clip.is_some_and(|clip| clip.removes(found.chain)) {
            let nothing = (Rgb::ONE, Vec3::ZERO);
            return place.show(1.0, None, nothing, nothing);
        }
        place.walk(found.chain, 1.0, Rgb::ONE, perturbation);
    }

    /// What `-i` and `-I` gather light with: a surface at `point` that faces against the ray.
    pub fn collector(&self, ray: &Ray, point: Vec3) -> Layer<'static> {
        let normal = -ray.direction;
        let point_there = Point {
            to_viewer: normal,
            geometric: normal,
            shading: normal,
            perturbation: Vec3::ZERO,
            front: true,
            flat: true,
            orientation: Vec3::ZERO,
            bends: false,
        };
        Layer {
            fraction: 1.0,
            material: Some(&*COLLECTOR),
            id: MaterialId::MAX,
            pattern: Rgb::ONE,
            point: point_there,
            at: At::surface(ray.direction, normal, point),
            emission: None,
            behind: None,
            gathers: true,
            relay: None,
            shades: false,
            clip: None,
        }
    }
}

/// A hit on its way down the chains of its modifier.
struct Place<'a> {
    world: &'a World,
    surface: u32,
    found: &'a Found<'a>,
    rules: &'a Rules,
    coming: &'a Coming<'a>,
    distance: f64,
    at: At<'a>,
    /// What becomes of a ray that passes, among antimatter.
    clip: Option<Box<Clip>>,
    out: &'a mut dyn FnMut(&Layer),
}

impl Place<'_> {
    /// Shows the layers of a chain that has the share `fraction`.
    fn walk(&mut self, chain: ChainId, fraction: f64, pattern: Rgb, perturbation: Vec3) {
        let chain = &self.world.chains[chain];
        let irradiance = self.rules.irradiance && self.coming.primary;
        // Irradiance is gathered before the material and what is behind it are looked at.
        let (links, behind) = chain.links.split_at(chain.before);
        let before = apply(links, &self.at, pattern, perturbation);
        let emits = || self.world.material_of(chain).is_some_and(|named| named.material.emits());
        let (pattern, perturbation) = if irradiance && !emits() { before } else { apply(behind, &self.at, before.0, before.1) };
        match &chain.end {
            End::Void => self.show(fraction, None, before, (pattern, perturbation)),
            End::Material(id) => self.show(fraction, Some(*id), before, (pattern, perturbation)),
            End::Mixture(coefficient, fore, back) => match coefficient.coefficient(&self.at) {
                Ok(c) => {
                    for (share, chain) in [(c, *fore), (1.0 - c, *back)] {
                        if share > TINY {
                            self.walk(chain, fraction * share, pattern, perturbation);
                        }
                    }
                }
                Err(_) => self.show(fraction, None, before, (pattern, perturbation)),
            },
        }
    }

    /// Shows one layer: its pattern and perturbation, and those `before` its material, which an alternate in its place has too.
    fn show(&mut self, fraction: f64, id: Option<MaterialId>, before: (Rgb, Vec3), (pattern, perturbation): (Rgb, Vec3)) {
        let world = self.world;
        let front = self.at.rdot > 0.0;
        let named = id.map(|id| &world.materials[id]);
        let mut layer = Layer {
            fraction,
            material: named,
            id: id.unwrap_or(0),
            pattern,
            point: self.point(named, front, perturbation),
            at: self.at,
            emission: None,
            behind: None,
            gathers: world.gathers.get(self.found.chain).is_none_or(|&gathers| gathers),
            relay: None,
            shades: false,
            clip: self.clip.clone(),
        };
        if world.removable.get(self.found.chain).is_some_and(|&removable| removable) {
            let mut clip = self.coming.clip();
            clip.cross(self.found.chain, front);
            layer.clip = Some(Box::new(clip));
        }
        let Some(named) = named else { return (self.out)(&layer) };
        let backless = !front && !self.rules.back_visible && named.material.backless();
        if self.rules.irradiance && self.coming.primary && !named.material.emits() && !matches!(named.material, Material::Antimatter) {
            if backless || named.material.nominally_transparent() {
                return (self.out)(&Layer { material: None, ..layer });
            }
            return (self.out)(&Layer { material: Some(&*COLLECTOR), pattern: Rgb::ONE, ..layer });
        }
        let aimed = self.coming.lamp();
        match &named.material {
            // The back of a surface that does not use its side is not there.
            material if backless && (aimed.is_none() || !material.shades()) => {
                layer.material = None;
                layer.shades = material.shades();
            }
            Material::Illum(_) if !self.shines(front) => return self.illum(layer, named, before),
            Material::Mirror(_) => return self.mirror(layer, named, before),
            Material::Antimatter => return self.antimatter(layer, named, before),
            Material::Light(_) | Material::Illum(_) | Material::Spotlight(..) if front => {
                let emitter = self.found.lamp.map_or(Emitter::Hidden, Emitter::Lamp);
                layer.emission = Some(Emission { radiance: named.material.emitted(self.at.direction) * pattern, emitter, beyond: false });
            }
            Material::Glow(radiance, radius) if front => {
                let emitter = match self.found.lamp {
                    Some(lamp) if aimed == Some(lamp) || world.lamps[lamp].lights(self.coming.ray.origin, self.distance) => {
                        Emitter::Lamp(lamp)
                    }
                    _ if *radius < -TINY || self.distance <= *radius => Emitter::Hidden,
                    _ => Emitter::Glow,
                };
                layer.emission = Some(Emission { radiance: *radiance * pattern, emitter, beyond: is_beyond(self.at.t, *radius) });
            }
            // A ray that meets the surface from inside has come through the body.
            Material::Dielectric(inside) | Material::Interface(inside, _) if !front => {
                layer.behind = Some(match world.unknown == id {
                    true => Inside { extinction: Rgb::ZERO, unknown: Some(inside.cleared().extinction(pattern)) },
                    false => Inside::of(inside.extinction(pattern)),
                });
            }
            Material::Interface(_, outside) => layer.behind = Some(Inside::of(outside.extinction(pattern))),
            _ => {}
        }
        (self.out)(&layer);
    }

    /// Whether an illum is a lamp to the ray: one that is aimed at it, or that may have been, as its direction was drawn from a rough surface.
    fn shines(&self, front: bool) -> bool {
        match self.coming.aim {
            Some(aim) => self.found.lamp.is_some_and(|lamp| aim == Emitter::Lamp(lamp)),
            None => self.coming.gathered && front,
        }
    }

    /// Shows an illum where it is no lamp: as its alternate.
    fn illum(&mut self, mut layer: Layer, named: &Named, before: (Rgb, Vec3)) {
        // What gathers light has the illum's own light already; nor may one weak source light through another.
        if layer.point.front && self.coming.lamp().map_or(self.coming.gathered, |lamp| self.world.lamps[lamp].weak) {
            layer.emission = Some(Emission::BLACK);
            return (self.out)(&layer);
        }
        match named.alternate {
            Some(chain) => self.walk(chain, layer.fraction, before.0, before.1),
            None => (self.out)(&Layer { material: None, ..layer }),
        }
    }

    /// Shows a mirror: as its alternate, but to what is relayed by it to a lamp.
    fn mirror(&mut self, mut layer: Layer, named: &Named, before: (Rgb, Vec3)) {
        let (world, front) = (self.world, layer.point.front);
        let relay = self.coming.lamp().and_then(|lamp| world.lamps[lamp].relay).filter(|r| r.mirror == self.surface);
        // What gathers light has the mirror's own already, if its alternate holds back the light beyond.
        let clear = |&chain: &ChainId| world.material_of(&world.chains[chain]).is_some_and(|named| named.material.nominally_transparent());
        let own = self.coming.gathered && front;
        if let Some(chain) = named.alternate.filter(|chain| relay.is_none() && (!own || clear(chain))) {
            return self.walk(chain, layer.fraction, before.0, before.1);
        }
        layer.relay = relay.map(|r| r.lamp);
        if layer.relay.is_some() || self.coming.ambient {
            layer.point = self.point(Some(named), front, Vec3::ZERO);
        }
        (self.out)(&layer);
    }

    /// Shows antimatter: nothing, or what it shows of the bodies it cuts.
    fn antimatter(&mut self, layer: Layer, named: &Named, before: (Rgb, Vec3)) {
        let mut clip = self.coming.clip();
        let inside = clip.is_inside(&named.removes);
        clip.cut(&named.removes, layer.point.front);
        self.clip = Some(Box::new(clip));
        if let Some(chain) = named.alternate.filter(|_| inside) {
            // It is shaded as if it faced the other way.
            (self.at.normal, self.at.rdot) = (-self.at.normal, -self.at.rdot);
            return self.walk(chain, layer.fraction, before.0, before.1);
        }
        (self.out)(&Layer { material: None, clip: self.clip.clone(), ..layer });
    }

    /// The hit as a material needs to know it.
    fn point(&self, named: Option<&Named>, front: bool, perturbation: Vec3) -> Point {
        // The side of the viewer, and of what is shaded.
        let side = if self.at.rdot > 0.0 { 1.0 } else { -1.0 };
        let (to_viewer, geometric) = (-self.at.direction, self.at.normal * side);
        // It goes by the side of the viewer, which textures do not.
        let turned = || At { normal: geometric, rdot: self.at.rdot.abs(), ..self.at };
        let orientation = named.and_then(|n| n.orientation.as_ref()).map_or(Vec3::ZERO, |o| o.perturbation(&turned()));
        let mut point = Point {
            to_viewer,
            geometric,
            shading: geometric,
            perturbation: Vec3::ZERO,
            front,
            flat: self.found.flat,
            orientation,
            bends: false,
        };
        if perturbation.length_squared() > 1e-12 {
            point.perturbation = perturbation * side;
            point.flat = false;
            // Light that is gathered by all of a hemisphere, or looked for, goes straight through a texture.
            point.bends = !self.coming.ambient && self.coming.aim.is_none() && !self.world.chains[self.found.chain].smooths();
            if let Some(mut shading) = (geometric + point.perturbation).try_normalize() {
                // A normal that is bent away from the viewer is turned back.
                if shading.dot(to_viewer) <= 0.0 {
                    shading -= to_viewer * (2.0 * shading.dot(to_viewer));
                }
                point.shading = shading;
            }
        }
        point
    }
}

/// What `-i` puts in the place of a surface: Lambertian, of reflectance π, so that its radiance is the irradiance.
static COLLECTOR: LazyLock<Named> = LazyLock::new(|| Named {
    name: String::new(),
    place: Span::new(&Text::new("-i", ""), 0, 0),
    material: Material::Reflectance(Reflectance::diffuse(Rgb::splat(PI))),
    orientation: None,
    alternate: None,
    removes: Vec::new(),
});

/// The pattern and perturbation behind a list of links.
fn apply(links: &[Link], at: &At, mut pattern: Rgb, mut perturbation: Vec3) -> (Rgb, Vec3) {
    for link in links {
        match link {
            Link::Pattern(p) => pattern *= p.color(at),
            Link::Texture(t) => perturbation += t.perturbation(at),
            Link::Mixture(mixture) => {
                let (coefficient, fore, back) = &**mixture;
                if let Ok(c) = coefficient.coefficient(at) {
                    let mix = |links: &[Link], share: f64| {
                        if share > TINY { apply(links, at, pattern, perturbation) } else { (pattern, perturbation) }
                    };
                    let (a, b) = (mix(fore, c), mix(back, 1.0 - c));
                    (pattern, perturbation) = (a.0 * c + b.0 * (1.0 - c), a.1 * c + b.1 * (1.0 - c));
                }
            }
        }
    }
    (pattern, perturbation)
}

impl Layer<'_> {
    /// What it does to light that it does not emit.
    pub fn bsdf(&self, rules: &Rules) -> Bsdf {
        match self.material {
            Some(Named { material: Material::Functions(m), .. }) => Bsdf::functions(m, &self.at, &self.point, self.pattern),
            Some(named) if self.emission.is_none() => Bsdf::new(&named.material, &self.point, self.pattern, rules),
            _ => Bsdf::black(&self.point),
        }
    }
}
