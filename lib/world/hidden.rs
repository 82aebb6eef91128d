//! Which lamps are hidden from what a view shows: few samples are for these.
//!
//! A lamp is chosen by how bright it would be ([`Lamp::importance`](crate::light::Lamp::importance)). The sun outside a room takes nearly all samples
//! by that, and lights nothing, or a patch. Where a lamp lights a part v of the places that are looked at, and these by f, the variance of the whole is least
//! if it is chosen in proportion to the root of the mean square, f √v (Owen 2013, "Monte Carlo theory, methods and examples", section 9.11).

use super::World;
use crate::accel::Hit;
use crate::geometry::Ray;
use crate::material::Material;
use crate::sampling::{cosine_hemisphere, lattice};
use crate::scene::ChainId;
use crate::vector::{Frame, Vec3};

/// Shadow rays to all lamps together, at the most: few milliseconds.
const MOST_RAYS: usize = 16_000;
/// Panes and the like that light may pass.
const MOST_PASSED: usize = 8;

/// A place of a surface that is looked at.
pub struct Lit {
    /// Where it is.
    pub place: Vec3,
    /// Its unit normal on the side it is seen from, unless it lets light on.
    pub normal: Option<Vec3>,
}

impl World {
    /// Finds out which lamps the surfaces that rays see, and what these are lit by, have in sight.
    pub(super) fn look_for_lamps(&mut self, rays: &[Ray]) {
        if self.lamps.len() < 2 {
            return;
        }
        let places: Vec<Lit> = rays.iter().enumerate().flat_map(|(i, ray)| self.looked_at(ray, i)).collect();
        // An odd step: every other place is lit by what is seen.
        let step = (places.len() * self.lamps.len()).div_ceil(MOST_RAYS).max(1) | 1;
        let chances: Vec<f64> = (0..self.lamps.len())
            .map(|lamp| {
                let asked = places.iter().step_by(step).enumerate();
                let lights: Vec<bool> = asked.filter_map(|(i, place)| self.lights(lamp, place, i)).collect();
                // Half a place more than were seen: what is hidden from these may light others.
                let seen = lights.iter().filter(|seen| **seen).count() as f64;
                ((seen + 0.5) / (lights.len() as f64 + 0.5)).sqrt()
            })
            .collect();
        self.lamps.iter_mut().zip(chances).for_each(|(lamp, chance)| lamp.chance = chance);
    }

    /// Where a ray ends, and where one of the rays from there does.
    fn looked_at(&self, ray: &Ray, number: usize) -> impl Iterator<Item = Lit> {
        let first = self.met(ray);
        let second = first.as_ref().and_then(|lit| {
            let direction = Frame::around(lit.normal?).to_world(cosine_hemisphere(lattice(number)));
            self.met(&Ray { origin: lit.place, direction })
        });
        first.into_iter().chain(second)
    }

    /// Where a ray ends.
    pub fn met(&self, ray: &Ray) -> Option<Lit> {
        let hit = self.nearest(ray, f64::INFINITY)?;
        let facing = if hit.normal.dot(ray.direction) < 0.0 { hit.normal } else { -hit.normal };
        Some(Lit { place: hit.point, normal: (!self.lets_on(&hit)).then_some(facing) })
    }

    /// Whether what was hit lets light on somewhere.
    pub fn lets_on(&self, hit: &Hit) -> bool {
        self.ends_in(self.find(hit).chain, Material::nominally_transparent)
    }

    /// Whether a lamp lights a place, in some direction to it; `None` where it never does, wherever other things are.
    fn lights(&self, lamp: usize, lit: &Lit, number: usize) -> Option<bool> {
        if self.lamps[lamp].importance(lit.place) <= 0.0 {
            return None;
        }
        let Some(to) = self.lamps[lamp].sample(lit.place, lattice(number)) else { return Some(false) };
        Some(
            lit.normal.is_none_or(|normal| normal.dot(to.direction) > 0.0)
                && self.is_in_sight(lamp, Ray { origin: lit.place, direction: to.direction }, to.distance),
        )
    }

    /// Whether a ray toward a lamp, so far away, may get there.
    fn is_in_sight(&self, lamp: usize, mut ray: Ray, mut distance: f64) -> bool {
        // What is seen in a mirror stands behind it.
        let mirror = self.lamps[lamp].relay.map(|relay| relay.mirror);
        for _ in 0..MOST_PASSED {
            let Some(hit) = self.nearest(&ray, distance * (1.0 - 1e-6)) else { return true };
            let found = self.find(&hit);
            if found.lamp == Some(lamp) || mirror == Some(hit.surface) {
                return true;
            }
            if !self.ends_in(found.chain, |material| !material.shades()) {
                return false;
            }
            distance -= hit.t;
            ray.origin = hit.point;
        }
        true
    }

    /// Whether what a chain ends in, if it is anything, is so somewhere.
    fn ends_in(&self, chain: ChainId, so: impl Fn(&Material) -> bool) -> bool {
        let mut ends = Vec::new();
        self.ends(chain, &mut ends);
        ends.iter().any(|end| end.is_none_or(|material| so(&self.materials[material].material)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::Rules;

    /// The chances of the sun and of a bulb, seen from between them and a floor, with these walls.
    fn chances(walls: &str) -> [f64; 2] {
        let text = format!(
            "void light solar 0 0 3 1e6 1e6 1e6 solar source sun 0 0 4 .1 .2 1 .5
             void light bulb 0 0 3 9 9 9 bulb sphere lamp 0 0 4 1 2 2.5 .05
             void plastic wall 0 0 5 .5 .5 .5 0 0 void glass pane 0 0 3 .9 .9 .9
             wall ring floor 0 0 8 2 2 0 0 0 1 0 3
             {walls}\n"
        );
        let mut world = World::of(&text);
        let direction = |i: usize| Frame::around(-Vec3::Z).to_world(cosine_hemisphere(lattice(i)));
        let rays: Vec<Ray> = (0..200).map(|i| Ray::new(Vec3::new(2.0, 2.0, 1.5), direction(i))).collect();
        world.survey(&rays, &Rules::default());
        let chance = |is_sun: bool| world.lamps().iter().find(|lamp| (lamp.brightness > 1e3) == is_sun).unwrap().chance;
        [chance(true), chance(false)]
    }

    #[test]
    fn few_samples_are_for_a_sun_that_no_surface_sees() {
        for (walls, sees) in [("!genbox wall room 4 4 3 -i", false), ("# none", true), ("pane ring roof 0 0 8 2 2 3 0 0 1 0 9", true)] {
            let [sun, bulb] = chances(walls);
            assert!(if sees { sun > 0.9 } else { sun < 0.1 } && bulb > 0.8, "{walls}: {sun} {bulb}");
        }
    }
}
