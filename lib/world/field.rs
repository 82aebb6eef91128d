//! The illumination field: around each point, the sky that was measured nearest to it.
//!
//! Each probe is a whole environment, measured at a place. A point is lit by the nearest one, or by its two nearest ones in proportion to
//! 1/distance². Directions are drawn from the tables of the same probes with the same weights, so that a field costs what one environment does.
//! Lamps that are seen to stand in the room are no part of a blended field ([`super::globes`]).

use super::globes::{Globe, globes};
use super::{Emission, World};
use crate::color::Rgb;
use crate::environment::{Cap, Environment, spots};
use crate::panorama::{Panorama, Place};
use crate::rules::Field;
use crate::scene::ChainId;
use crate::vector::Vec3;

/// The measured environments.
pub(super) struct Probes {
    probes: Vec<Probe>,
    /// The glows that probes name.
    glows: Vec<Glow>,
    /// The density with which directions are drawn, for each of them.
    tables: Vec<Option<Environment>>,
    field: Field,
}

/// An environment at its place.
struct Probe {
    place: Vec3,
    /// The place of its glow among all.
    table: usize,
}

/// What a probe names.
struct Glow {
    /// The first place that names it.
    place: Vec3,
    chain: ChainId,
    /// Where lamps are taken out of it.
    caps: Vec<Cap>,
}

/// A probe and its share in the light at a point.
type Share<'a> = (&'a Probe, f64);

/// The fewest rows of the table of a probe.
const FEWEST_ROWS: usize = 64;

/// The rows of each of `count` tables that have together as many cells as one of `rows` rows.
fn shared(rows: usize, count: usize) -> usize {
    ((rows as f64 / (count.max(1) as f64).sqrt()) as usize).max(FEWEST_ROWS)
}

impl Glow {
    /// What shines on a point from a direction.
    fn emission(&self, world: &World, point: Vec3, direction: Vec3) -> Option<Emission> {
        let emission = world.emitted(self.chain, None, point, direction)?;
        let instead = self.caps.iter().find_map(|cap| cap.radiance(direction));
        Some(Emission { radiance: instead.unwrap_or(emission.radiance), ..emission })
    }

    /// The radiance seen from its place.
    fn radiance(&self, world: &World, direction: Vec3) -> Rgb {
        self.emission(world, self.place, direction).map_or(Rgb::ZERO, |emission| emission.radiance)
    }
}

impl Probes {
    /// The probes of a world, with tables that have together as many cells as one of `rows` rows, and the lamps that are no part of them;
    /// `None` if there are none.
    pub(super) fn new(world: &World, places: &[(Vec3, ChainId)], field: Field, rows: usize) -> Option<(Self, Vec<Globe>)> {
        let mut glows: Vec<Glow> = Vec::new();
        let mut probes = Vec::new();
        for &(place, chain) in places {
            let table = glows.iter().position(|g| g.chain == chain).unwrap_or(glows.len());
            if table == glows.len() {
                glows.push(Glow { place, chain, caps: Vec::new() });
            }
            probes.push(Probe { place, table });
        }
        let mut lamps = Vec::new();
        if field == Field::Blend {
            let places: Vec<Vec3> = glows.iter().map(|glow| glow.place).collect();
            lamps = globes(&places, |i| spots(|direction| glows[i].radiance(world, direction)));
            for (i, glow) in glows.iter_mut().enumerate() {
                glow.caps = lamps.iter().map(|lamp| lamp.spots[i].cap(|direction| glow.radiance(world, direction))).collect();
            }
        }
        let rows = shared(rows, glows.len());
        let tables = glows.iter().map(|glow| Environment::new(rows, &|direction| glow.radiance(world, direction))).collect();
        (!probes.is_empty()).then_some((Self { probes, glows, tables, field }, lamps))
    }

    /// The panoramas of the glows, with as many cells together as one of `rows` rows.
    pub(super) fn panoramas(&self, world: &World, rows: usize) -> Vec<Panorama> {
        let rows = shared(rows, self.glows.len());
        self.glows.iter().map(|glow| Panorama::new(rows, &|direction| glow.radiance(world, direction))).collect()
    }

    /// The mean of a number of each environment of a point, given by the place of its glow.
    pub(super) fn mean(&self, point: Vec3, of: impl Fn(usize) -> Rgb) -> Rgb {
        let ((probe, share), other) = self.near(point);
        of(probe.table) * share + other.map_or(Rgb::ZERO, |(other, rest)| of(other.table) * rest)
    }

    /// Which probes light a point, and their shares, which add up to 1.
    fn near(&self, point: Vec3) -> (Share<'_>, Option<Share<'_>>) {
        let mut first = (&self.probes[0], f64::INFINITY);
        let mut second = None;
        for probe in &self.probes {
            let near = (probe, probe.place.distance_squared(point));
            if near.1 < first.1 {
                (first, second) = (near, Some(first).filter(|f| f.1 < f64::INFINITY));
            } else if second.is_none_or(|s: Share| near.1 < s.1) && !std::ptr::eq(probe, first.0) {
                second = Some(near);
            }
        }
        match second {
            // 1/a : 1/b is b : a, also where the point is at a probe.
            Some((other, far)) if self.field == Field::Blend && far > 0.0 && far < f64::INFINITY => {
                let share = far / (first.1 + far);
                ((first.0, share), Some((other, 1.0 - share)))
            }
            _ => ((first.0, 1.0), None),
        }
    }

    /// What shines on a point from a direction.
    pub(super) fn emission(&self, world: &World, point: Vec3, direction: Vec3) -> Option<Emission> {
        let ((probe, share), other) = self.near(point);
        let emitted = |probe: &Probe| self.glows[probe.table].emission(world, point, direction);
        let first = emitted(probe)?;
        let Some((other, rest)) = other.filter(|o| o.0.table != probe.table) else { return Some(first) };
        Some(Emission { radiance: first.radiance * share + emitted(other)?.radiance * rest, ..first })
    }

    /// Whether directions are aimed at any of the environments.
    pub(super) fn are_aimed_at(&self) -> bool {
        self.tables.iter().any(Option::is_some)
    }

    /// A direction aimed at the environment of a point, and its density.
    pub(super) fn sample(&self, point: Vec3, [u, v]: [f64; 2]) -> Option<(Vec3, f64)> {
        let ((probe, share), other) = self.near(point);
        let (table, u) = match other.filter(|o| o.0.table != probe.table) {
            Some((other, rest)) if u >= share => (other.table, (u - share) / rest),
            Some(_) => (probe.table, u / share),
            None => (probe.table, u),
        };
        let (direction, _) = self.tables[table].as_ref()?.sample([u.min(1.0 - f64::EPSILON), v])?;
        Some((direction, self.pdf(point, Place::of(direction))))
    }

    /// The density of [`Probes::sample`].
    pub(super) fn pdf(&self, point: Vec3, place: Place) -> f64 {
        let of = |(probe, share): Share| self.tables[probe.table].as_ref().map_or(0.0, |t| share * t.pdf(place));
        let (first, other) = self.near(point);
        of(first) + other.map_or(0.0, of)
    }
}
