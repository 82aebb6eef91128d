//! Scene → World: surfaces into the hierarchy, lights into the list of lamps, mirrors into more lamps.

use super::field::Probes;
use super::globes::Globe;
use super::{Body, Source, Surface, World};
use crate::accel::{self, Accel, Geometry, Rank};
use crate::color::{Rgb, bright};
use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::geometry::{Facing, LightShape, Plane, Shape, Sphere, TINY, tolerance};
use crate::light::{self, Lamp, Relay, Window};
use crate::material::Material;
use crate::rules::Rules;
use crate::scene::{self, Chain, ChainId, Distant, End, Form, Link, Named, Scene};
use crate::vector::Vec3;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

/// The rows of the table of an environment.
pub(super) const ENVIRONMENT_ROWS: usize = 256;

/// The most lamps, those seen in mirrors included.
const LAMP_LIMIT: usize = 100_000;

/// The surfaces of octrees that were built already, with and without a modifier for all that is in them.
type Groups = HashMap<(*const Vec<scene::Surface>, bool), (Arc<Accel>, Arc<Vec<Surface>>)>;

/// A flat mirror.
struct Mirror {
    surface: u32,
    plane: Plane,
    outline: Window,
    /// Which part of the light it reflects, without patterns.
    reflectance: f64,
}

impl World {
    /// The world of a scene. Surfaces without a material are not there; `rules` say whether backs are.
    pub fn new(scene: Scene, rules: &Rules) -> Result<Self> {
        let Scene { mut surfaces, sources, chains, materials, probes, .. } = scene;
        let mut world = Self {
            accel: Accel::build(Vec::new())?,
            surfaces: Vec::new(),
            chains,
            materials,
            sources: Vec::new(),
            lamps: Vec::new(),
            environment: None,
            probes: None,
            open: None,
            pools: Vec::new(),
            transparent: !rules.back_visible,
            bends: false,
            gathers: Vec::new(),
            removable: Vec::new(),
            tolerance: TINY,
            unknown: None,
        };
        if let Some((field, lamps)) = Probes::new(&world, &probes, rules.field, ENVIRONMENT_ROWS) {
            world.probes = Some(field);
            surfaces.extend(lamps.iter().filter_map(|lamp| world.globe(lamp, probes[0].1)));
        }
        if let Some((included, names)) = &rules.gathering {
            world.gathers = world.chains.iter().map(|chain| names.contains(&chain.name) == *included).collect();
        }
        if world.materials.iter().any(|m| !m.removes.is_empty()) {
            world.removable = vec![false; world.chains.len()];
            world.materials.iter().flat_map(|m| &m.removes).for_each(|&chain| world.removable[chain] = true);
        }
        let (mut groups, mut bodies, mut relays) = (Groups::new(), Vec::new(), Vec::new());
        for surface in &surfaces {
            let Some((body, mut built)) = world.surface(surface, false, &mut groups)? else { continue };
            if let Form::Shape(shape) = &surface.form {
                // What may be no light need not be taken apart for one.
                let form = || shape.light().map(|light| (light::Form::of(shape.clone()), light));
                let form = || form().map_err(|e: &str| surface.place.error(format!("`{}`: {e}", surface.name)));
                built.lamp = world.lamp(surface.chains[0], form)?;
                if let Some(color) = world.mirror(surface.chains[0])
                    && let Some(plane) = shape.plane()
                {
                    let (surface, reflectance) = (world.surfaces.len() as u32, bright(color).abs());
                    relays.push(Mirror { surface, plane, outline: Window::new(shape), reflectance });
                }
            }
            bodies.push(body);
            world.surfaces.push(built);
        }
        for source in sources {
            world.distant(source)?;
        }
        world.hide_overlaps();
        world.relay(&relays, rules.mirror_levels)?;
        world.accel = Accel::build(bodies)?;
        let bounds = world.accel.bounds();
        if !bounds.is_empty() {
            world.tolerance = tolerance(bounds.size());
        }
        let middle = world.middle();
        if world.probes.is_some() {
            world.make_room(probes[0].1);
        } else if let Some(glow) = world.sources.iter().find(|s| s.lamp.is_none())
            && !(glow.spread >= 2.0 && world.chains[glow.chain].links.is_empty())
        {
            // The first one that is all around, without a pattern, is all there is: nothing stands out.
            world.environment = Environment::new(ENVIRONMENT_ROWS, &|d| world.glow(middle, d));
        }
        Ok(world)
    }

    /// A lamp that a field shows, as a surface; `glow` is a part of that field.
    fn globe(&mut self, globe: &Globe, glow: ChainId) -> Option<scene::Surface> {
        let Chain { name, end: End::Material(glow), .. } = &self.chains[glow] else { return None };
        let (name, place) = (name.clone(), self.materials[*glow].place.clone());
        let (material, orientation, alternate, removes) = (Material::Light(globe.radiance), None, None, Vec::new());
        self.materials.push(Named { name: name.clone(), place: place.clone(), material, orientation, alternate, removes });
        self.chains.push(Chain { name: name.clone(), end: End::Material(self.materials.len() - 1), ..Chain::default() });
        let form = Form::Shape(Shape::Sphere(Sphere { center: globe.center, radius: globe.radius, inward: false }));
        Some(scene::Surface { name: name.clone(), modifier: name, place, form, chains: vec![self.chains.len() - 1] })
    }

    /// A surface, for the hierarchy and for what is hit; `None` if nothing of it is visible. The modifier of an instance around it, if there
    /// is one, stands for its own: then it is `covered`, and there even if that is void.
    fn surface(&mut self, surface: &scene::Surface, covered: bool, groups: &mut Groups) -> Result<Option<(accel::Surface, Surface)>> {
        let chains = &surface.chains;
        if !covered {
            if !chains.is_empty() && chains.iter().all(|&c| self.is_void(c)) {
                return Ok(None);
            }
            self.transparent |= chains.iter().any(|&c| self.passes(c));
            // What an octree holds may be a smooth mesh.
            let smooth = match &surface.form {
                Form::Shape(_) => false,
                Form::Mesh(mesh, _) => !mesh.normals.is_empty(),
                Form::Group(..) => true,
            };
            self.bends |= chains.iter().any(|&c| !self.chains[c].smooths() && self.bends_passing(c, smooth));
        }
        let ranks = chains.iter().map(|&c| self.rank(c)).collect();
        let (geometry, body) = match &surface.form {
            Form::Shape(shape) => (Geometry::Shape(shape.clone()), Body::Shape(shape.flat())),
            Form::Mesh(mesh, transform) => {
                (Geometry::Mesh(mesh.clone(), transform.affine), Body::Mesh(mesh.clone(), *transform, surface.modifier != super::VOID))
            }
            Form::Group(inside, transform) => {
                let covered = covered || !chains.is_empty();
                let key = (Arc::as_ptr(inside), covered);
                let (accel, surfaces) = match groups.get(&key) {
                    Some(known) => known.clone(),
                    None => {
                        let (mut bodies, mut surfaces) = (Vec::new(), Vec::new());
                        for surface in inside.iter() {
                            if let Some((body, surface)) = self.surface(surface, covered, groups)? {
                                bodies.push(body);
                                surfaces.push(surface);
                            }
                        }
                        let built = (Arc::new(Accel::build(bodies)?), Arc::new(surfaces));
                        groups.insert(key, built.clone());
                        built
                    }
                };
                (Geometry::Group(accel, transform.affine), Body::Group(surfaces, *transform))
            }
        };
        let built = Surface { name: surface.name.clone(), chains: chains.clone(), lamp: None, body };
        Ok(Some((accel::Surface { geometry, ranks }, built)))
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
    fn passes(&self, chain: ChainId) -> bool {
        match self.chains[chain].end {
            End::Void => true,
            End::Material(m) => self.materials[m].material.passes(),
            End::Mixture(_, fore, back) => self.passes(fore) || self.passes(back),
        }
    }

    /// Whether a surface of this chain, `textured` or with a texture of its own, bends what passes.
    fn bends_passing(&self, chain: ChainId, textured: bool) -> bool {
        let Chain { links, end, .. } = &self.chains[chain];
        let textured = textured || links.iter().any(|link| !matches!(link, Link::Pattern(_)));
        match end {
            End::Void => false,
            End::Material(m) => {
                let named = &self.materials[*m];
                textured && named.material.bends() || named.alternate.is_some_and(|chain| self.bends_passing(chain, false))
            }
            End::Mixture(_, fore, back) => [fore, back].into_iter().any(|&side| self.bends_passing(side, textured)),
        }
    }

    /// What a flat surface of this chain reflects of the virtual lamps that it shows, if it does: a mirror, also one that an illum stands before.
    fn mirror(&self, chain: ChainId) -> Option<Rgb> {
        let named = |chain: ChainId| if let End::Material(m) = self.chains[chain].end { Some(&self.materials[m]) } else { None };
        let color = |chain| named(chain).and_then(|named| if let Material::Mirror(color) = named.material { Some(color) } else { None });
        let illum = named(chain).filter(|named| matches!(named.material, Material::Illum(_)));
        color(chain).or_else(|| color(illum?.alternate?))
    }

    /// What decides between coincident surfaces.
    fn rank(&self, chain: ChainId) -> Rank {
        match self.chains[chain].end {
            End::Void => Rank::default(),
            End::Material(m) => {
                Rank { class: if self.materials[m].material.nominally_transparent() { 1 } else { 2 }, order: self.chains[chain].order }
            }
            End::Mixture(..) => Rank { class: 2, order: self.chains[chain].order },
        }
    }

    /// Adds a lamp if the chain makes its bearer one; returns its number.
    fn lamp(&mut self, chain: ChainId, form: impl FnOnce() -> Result<(light::Form, LightShape)>) -> Result<Option<usize>> {
        let End::Material(m) = self.chains[chain].end else { return Ok(None) };
        let material = &self.materials[m].material;
        let (radiance, radius, focus) = match material {
            Material::Light(radiance) | Material::Illum(radiance) => (radiance, f64::INFINITY, 0.0),
            Material::Spotlight(radiance, _, aim) => (radiance, f64::INFINITY, aim.length()),
            Material::Glow(radiance, radius) if *radius > TINY => (radiance, *radius, 0.0),
            _ => return Ok(None),
        };
        let (brightness, largest) = (bright(*radiance).abs(), radiance.max_element());
        let (illum, glow) = (matches!(material, Material::Illum(_)), matches!(material, Material::Glow(..)));
        let (form, extent) = form()?;
        let distant = matches!(form, light::Form::Distant(..));
        // RADIANCE takes a flat spotlight that does not aim to its front for no lamp.
        let averted = match (material, extent.facing) {
            (Material::Spotlight(_, _, aim), Facing::Front(normal)) => aim.normalize().dot(normal) <= TINY,
            _ => false,
        };
        // A light without light is dropped; a distant glow is never a lamp.
        if largest <= TINY || distant && glow || averted {
            return Ok(None);
        }
        let shared = focus == 0.0 && !(illum && distant);
        self.lamps.push(Lamp {
            form,
            extent,
            brightness,
            chance: 1.0,
            radius,
            focus,
            shared,
            weak: illum || glow,
            relay: None,
            windows: vec![],
        });
        Ok(Some(self.lamps.len() - 1))
    }

    /// Adds a distant source if it shines.
    fn distant(&mut self, source: Distant) -> Result<()> {
        let End::Material(m) = self.chains[source.chain].end else { return Ok(()) };
        let Distant { name, direction, spread, chain } = source;
        let form = || Ok((light::Form::Distant(direction, spread), LightShape::distant(direction, 2.0 * PI * spread)));
        let lamp = self.lamp(chain, form)?;
        let Some(named) = self.materials.get(m) else { return Ok(()) };
        if lamp.is_some() || matches!(named.material, Material::Glow(..)) {
            let clear = named.alternate.is_none_or(|chain| self.is_void(chain));
            let illum = matches!(named.material, Material::Illum(_)) && clear;
            self.sources.push(Source { name, direction, spread, chain, lamp, illum });
        }
        Ok(())
    }

    /// Puts one source all around, which stands for the illumination field, in the place of all distant glows; of `glow` if there is none.
    fn make_room(&mut self, glow: ChainId) {
        let own = self.sources.iter().find(|s| s.lamp.is_none()).map(|s| (s.name.clone(), s.chain));
        let (name, chain) = own.unwrap_or_else(|| (self.chains[glow].name.clone(), glow));
        self.sources.retain(|s| s.lamp.is_some());
        self.sources.push(Source { name, direction: Vec3::Z, spread: 2.0, chain, lamp: None, illum: false });
    }

    /// A light that an earlier one may hide is not found by chance: what is seen in its direction is the earlier one.
    fn hide_overlaps(&mut self) {
        for (i, later) in self.sources.iter().enumerate() {
            let hidden = self.sources[..i]
                .iter()
                .any(|s| s.lamp.is_some() && s.direction.angle_between(later.direction) <= s.half() + later.half() + TINY);
            if let (Some(lamp), true) = (later.lamp, hidden) {
                self.lamps[lamp].shared = false;
            }
        }
    }

    /// Adds the lamps that are seen in flat mirrors, and in these in others, up to `levels` deep.
    fn relay(&mut self, mirrors: &[Mirror], levels: u32) -> Result<()> {
        let mut first = 0;
        for _ in 0..levels {
            let last = self.lamps.len();
            if first == last {
                break;
            }
            for (lamp, mirror) in (first..last).flat_map(|lamp| mirrors.iter().map(move |mirror| (lamp, mirror))) {
                let before = self.lamps[lamp].relay;
                // A mirror does not see its own images, nor does it see through another one what is wholly behind that.
                if before.is_some_and(|b| b.mirror == mirror.surface || b.plane.height(mirror.outline.center) <= -mirror.outline.radius) {
                    continue;
                }
                let relay = Relay { mirror: mirror.surface, plane: mirror.plane, lamp };
                let seen = self.lamps[lamp].reflected(relay, &mirror.outline, mirror.reflectance);
                self.lamps.extend(seen);
                if self.lamps.len() > LAMP_LIMIT {
                    return Err(Error::new(format!(
                        "more than {LAMP_LIMIT} lights are seen in the mirrors; -dr 1 leaves out those seen in two, -dr 0 all of them"
                    )));
                }
            }
            first = last;
        }
        Ok(())
    }
}

#[cfg(test)]
impl World {
    /// The world of a text.
    pub fn of(text: &str) -> Self {
        use crate::error::Source;
        use crate::expand::expand;
        use crate::rad::Document;
        use crate::resolve::Files;
        use crate::scene::Reading;
        let document = Document::parse(Source::new("scene.rad", text.to_string())).unwrap();
        let files = Files::default();
        let scene = Scene::new(&expand(vec![document], &files).unwrap(), &files, &Reading::default()).unwrap();
        Self::new(scene, &Rules::default()).unwrap()
    }
}
