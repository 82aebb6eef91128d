//! The light of the environment on a diffuse surface, as if nothing hid it: known by itself, and as the directions taken there find it.

use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::vector::Vec3;
use crate::world::{Open, World};
use std::f64::consts::PI;

/// The environment by itself, at a point.
pub(super) struct Unhidden<'a> {
    world: &'a World,
    open: &'a Open,
    from: Vec3,
    /// The expected number of samples of the diffuse part on each side.
    counts: [f64; 2],
    /// What they, and those aimed at the environment, find: irradiance over π.
    found: [Rgb; 2],
}

/// The part of what a surface gathers that must be diffuse.
const LEAST: f64 = 0.25;

impl<'a> Unhidden<'a> {
    /// That of a point where each part gathers so much by so many samples; `None` where it does not pay.
    pub fn new(world: &'a World, from: Vec3, weights: &[f64; 4], counts: &[f64; 4]) -> Option<Self> {
        let open = world.open()?;
        let (counts, diffuse) = ([counts[0], counts[1]], weights[0] + weights[1]);
        (counts != [0.0; 2] && diffuse > LEAST * weights.iter().sum::<f64>()).then_some(Self {
            world,
            open,
            from,
            counts,
            found: [Rgb::ZERO; 2],
        })
    }

    /// Takes in a local direction, aimed at the environment or drawn from a diffuse part: by the balance heuristic. One along the horizon brings
    /// nothing, and may have no density either.
    pub fn take(&mut self, bsdf: &Bsdf, wi: Vec3) {
        let (side, lambert) = ((wi.z < 0.0) as usize, wi.z.abs() / PI);
        if self.counts[side] > 0.0 && lambert > 0.0 {
            let (radiance, aimed) = self.world.unhidden(self.open, self.from, bsdf.to_world(wi));
            self.found[side] += radiance * (lambert / (aimed + self.counts[side] * lambert));
        }
    }

    /// What the directions that were taken left out of the irradiance over π on one side, or had too much of it. It vanishes on the average
    /// (a control variate); the less is hidden, the more of what they miss of the light that arrives is this.
    pub fn missed(&self, bsdf: &Bsdf, side: usize) -> Option<Rgb> {
        let normal = Vec3::new(0.0, 0.0, [1.0, -1.0][side]);
        let whole = || self.world.irradiance(self.open, self.from, bsdf.to_world(normal));
        (self.counts[side] > 0.0).then(|| (whole() - self.found[side]) * self.open.share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Ray;
    use crate::rules::Rules;
    use crate::world::Coming;

    #[test]
    fn a_direction_along_the_horizon_brings_nothing() {
        // No direction is aimed there: the light is brighter elsewhere.
        let text = "void brightfunc above 2 if(Dz-.9,9,1) . 0 0 above glow sky 0 0 4 1 1 1 0 sky source all 0 0 4 0 0 1 360
                    void plastic white 0 0 5 .5 .5 .5 0 0 white ring floor 0 0 8 0 0 0 0 0 1 0 1";
        let (mut world, rules) = (World::of(text), Rules::default());
        let ray = Ray::new(Vec3::new(0.1, 0.2, 3.0), -Vec3::Z);
        world.survey(&[ray; 16], &rules);
        let hit = world.nearest(&ray, f64::INFINITY).unwrap();
        let coming = Coming::viewer(&ray);
        world.layers(&hit, &coming, &rules, &mut |layer| {
            let (bsdf, ones) = (layer.bsdf(&rules), [1.0, 0.0, 0.0, 0.0]);
            let missed = |directions: &[Vec3]| {
                let mut unhidden = Unhidden::new(&world, hit.point, &ones, &ones).unwrap();
                directions.iter().for_each(|wi| unhidden.take(&bsdf, *wi));
                unhidden.missed(&bsdf, 0).unwrap()
            };
            assert!(missed(&[]).min_element() > 0.5);
            assert_eq!(missed(&[Vec3::X, -Vec3::Y]), missed(&[]));
        });
    }
}
