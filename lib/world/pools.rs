//! Pools of light: small places that are lit so brightly that they light the rest. Few directions find them by chance.

use super::World;
use crate::light::subtended;
use crate::sampling::cone;
use crate::vector::{Frame, Vec3};
use std::f64::consts::PI;

/// A ball around a small and bright place.
#[derive(Clone, Copy, Debug)]
pub struct Pool {
    /// Its middle.
    pub middle: Vec3,
    /// Its radius.
    pub radius: f64,
    /// How much light it sends on, for choosing among pools: radiance times square distance times solid angle.
    pub power: f64,
}

/// Where there are about so many pools, none is taken apart any more: where there are more, light comes from everywhere.
pub const MOST_POOLS: usize = 16;

impl World {
    /// Aims directions at these places from now on.
    pub fn aim_at(&mut self, pools: Vec<Pool>) {
        self.pools = pools;
    }

    /// Whether directions are aimed at pools.
    pub fn has_pools(&self) -> bool {
        !self.pools.is_empty()
    }

    /// A direction aimed at one of the pools from a point outside it, and its density per solid angle. `choice` and `u` are uniform in [0, 1).
    pub fn sample_pool(&self, from: Vec3, choice: f64, u: [f64; 2]) -> Option<(Vec3, f64)> {
        let mut left = choice * self.pools.iter().map(|pool| pool.importance(from)).sum::<f64>();
        let chosen = self.pools.iter().find(|pool| {
            left -= pool.importance(from);
            left < 0.0
        })?;
        let direction = Frame::around((chosen.middle - from).normalize()).to_world(cone(u, chosen.spread(from)?));
        let density = self.pool_pdf(from, direction);
        // A direction at the very rim may miss the ball by rounding.
        (density > 0.0).then_some((direction, density))
    }

    /// The density with which [`World::sample_pool`] finds a direction.
    pub fn pool_pdf(&self, from: Vec3, direction: Vec3) -> f64 {
        let (mut all, mut found) = (0.0, 0.0);
        for pool in &self.pools {
            let Some(spread) = pool.spread(from) else { continue };
            let importance = pool.importance(from);
            all += importance;
            if (pool.middle - from).normalize().distance_squared(direction) <= 2.0 * spread {
                found += importance / (2.0 * PI * spread);
            }
        }
        if found > 0.0 { found / all } else { 0.0 }
    }
}

impl Pool {
    /// 1 − cos of half the angle it subtends; `None` from within.
    fn spread(&self, from: Vec3) -> Option<f64> {
        subtended(self.middle, self.radius, from)
    }

    /// How much it may light a point; 0 from within, where no direction is aimed at it.
    fn importance(&self, from: Vec3) -> f64 {
        self.spread(from).map_or(0.0, |_| self.power / self.middle.distance_squared(from))
    }
}
