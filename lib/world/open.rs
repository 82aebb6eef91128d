//! How much of the environment a view is open to.
//!
//! Where little hides the environment, what all of it does to a diffuse surface is looked up, and only what is hidden of it is left to chance
//! (a control variate: Owen 2013, "Monte Carlo theory, methods and examples", section 8.9).

use super::build::ENVIRONMENT_ROWS;
use super::{Coming, World};
use crate::bsdf::Part;
use crate::color::{Rgb, bright};
use crate::geometry::Ray;
use crate::panorama::{Panorama, Place};
use crate::rules::Rules;
use crate::sampling::lattice;
use crate::vector::Vec3;

/// What a view has of the environment.
pub struct Open {
    /// The part of the light of the environment that reaches the surfaces, about.
    pub share: f64,
    /// The environment; of a field, each in the order of its tables.
    panoramas: Vec<Panorama>,
}

/// A view that is less open is not worth its tables.
const LEAST: f64 = 0.1;

/// Rows of a panorama: those of a picture of a thousand columns, as environments mostly are.
const ROWS: usize = 2 * ENVIRONMENT_ROWS;

impl World {
    /// Finds out how open the surfaces that `rays` see are to the environment, and which lamps these have in sight.
    pub fn survey(&mut self, rays: &[Ray], rules: &Rules) {
        self.look_for_lamps(rays);
        if self.has_environment() {
            let share = self.reached(rays, rules);
            self.open = (share >= LEAST).then(|| Open { share, panoramas: self.panoramas() });
        }
    }

    /// The part of the light of the environment that reaches the diffuse surfaces that rays see.
    fn reached(&self, rays: &[Ray], rules: &Rules) -> f64 {
        let (mut reached, mut all) = (0.0, 0.0);
        for (i, ray) in rays.iter().enumerate() {
            let Some(hit) = self.nearest(ray, f64::INFINITY) else { continue };
            let u = lattice(i);
            let coming = Coming::viewer(ray);
            self.layers(&hit, &coming, rules, &mut |layer| {
                let bsdf = layer.bsdf(rules);
                for part in [Part::DiffuseReflection, Part::DiffuseTransmission] {
                    let onward = Ray { origin: hit.point, direction: bsdf.to_world(part.lambert(u)) };
                    let light = bsdf.weights()[part as usize] * layer.fraction * bright(self.glow(hit.point, onward.direction));
                    if light > 0.0 {
                        all += light;
                        reached += if self.occluded(&onward) { 0.0 } else { light };
                    }
                }
            });
        }
        reached / all
    }

    fn panoramas(&self) -> Vec<Panorama> {
        let middle = self.middle();
        match &self.probes {
            Some(probes) => probes.panoramas(self, ROWS),
            None => vec![Panorama::new(ROWS, &|direction| self.glow(middle, direction))],
        }
    }

    /// What the view that was surveyed has of the environment; `None` if that is little.
    pub fn open(&self) -> Option<&Open> {
        self.open.as_ref()
    }

    /// What the environment of a point does by itself to a diffuse surface with this unit normal: its irradiance over π.
    pub fn irradiance(&self, open: &Open, from: Vec3, normal: Vec3) -> Rgb {
        let normal = Place::of(normal);
        self.mean(from, |i| open.panoramas[i].irradiance(normal))
    }

    /// The radiance of the same environment in a direction, and the density with which directions are aimed at that.
    pub fn unhidden(&self, open: &Open, from: Vec3, direction: Vec3) -> (Rgb, f64) {
        let place = Place::of(direction);
        (self.mean(from, |i| open.panoramas[i].radiance(place)), self.aimed(from, place))
    }

    /// The mean of a number of each environment of a point.
    fn mean(&self, from: Vec3, of: impl Fn(usize) -> Rgb) -> Rgb {
        match &self.probes {
            Some(probes) => probes.mean(from, of),
            None => of(0),
        }
    }
}
