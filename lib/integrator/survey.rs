//! What there is to know of a world before a picture of it: the world's own survey, and where in it light gathers.

use super::{Integrator, Radiance};
use crate::color::{Rgb, bright};
use crate::geometry::Ray;
use crate::rules::Rules;
use crate::sampling::{Sampler, cosine_hemisphere, lattice};
use crate::vector::{Frame, Vec3};
use crate::world::{MOST_POOLS, Pool, World};

/// Directions that are looked in at first, and where these show something bright.
const LOOKS: [usize; 2] = [2000, 40_000];
/// The most, times the lamps that what they show may be lit by.
const MOST_LOOKS: usize = 1_000_000;
/// The part of the surfaces that must be in the shade.
const SHADE: f64 = 0.02;
/// How many times as bright as the mean of all directions a pool of light is.
const BRIGHT: f64 = 8.0;
/// How far the light of pools that a sample finds must spread, in terms of the mean of all light, for directions to be aimed at them.
const SPREAD: f64 = 1.0;
/// Fewer directions are no pool.
const FEW: usize = 3;

/// Finds out what the surfaces that `rays` see are lit by: how open they are to the environment, which lamps they have in sight, and whether much of
/// their light comes from small places that these shine on. Directions are aimed at such from then on.
pub fn survey(world: &mut World, rays: impl Iterator<Item = Ray>, rules: &Rules) {
    let rays: Vec<Ray> = rays.collect();
    world.survey(&rays, rules);
    // Gloss shows few samples what lies in its lobe, far brighter than it is.
    let direct = Rules { ambient_bounces: 0, ambient_value: Rgb::ZERO, lights_visible: false, specular_threshold: 1.0, ..rules.clone() };
    let shade = shade(world, &rays, &direct);
    if (shade.len() as f64) < SHADE * rays.len() as f64 {
        return;
    }
    let look = |count| found(world, &shade, count, &direct);
    let glance = look(LOOKS[0]);
    // Where all is dark at a glance, it may be too few directions.
    let pools = if spread(&bright_ones(&glance), &glance) { pools(&look(LOOKS[1])) } else { Vec::new() };
    world.aim_at(pools);
}

/// The places that rays see where no lamp shines, with the unit normals on the sides they are seen from.
fn shade(world: &World, rays: &[Ray], direct: &Rules) -> Vec<(Vec3, Vec3)> {
    let mut integrator = Integrator::new(world, direct);
    let places = rays.iter().filter_map(|ray| world.met(ray).and_then(|lit| Some((lit.place, lit.normal?))));
    let dark = |(i, (place, normal)): (usize, (Vec3, Vec3))| {
        let mut transport = Radiance { rules: direct, sum: Rgb::ZERO };
        integrator.irradiance(&mut transport, place, normal, Sampler::new(0, i as u64, 0, 0));
        (transport.sum == Rgb::ZERO).then_some((place, normal))
    };
    places.enumerate().filter_map(dark).collect()
}

/// What a direction shows by the light that surfaces do not get from each other.
#[derive(Clone, Copy)]
struct Found {
    place: Vec3,
    radiance: f64,
    /// The square of how far that is; 0 where it is no surface, or one that lets light on.
    far: f64,
}

/// What about so many directions of the hemispheres of places show, in proportion to the cosines.
fn found(world: &World, places: &[(Vec3, Vec3)], count: usize, direct: &Rules) -> Vec<Found> {
    let mut integrator = Integrator::new(world, direct);
    let each = count.min(MOST_LOOKS / (1 + world.lamps().len())).div_ceil(places.len().max(1));
    let look = |number: usize| {
        let (place, normal) = places[number / each];
        let ray = Ray { origin: place, direction: Frame::around(normal).to_world(cosine_hemisphere(lattice(number))) };
        let hit = world.nearest(&ray, f64::INFINITY);
        let there = hit.as_ref().filter(|hit| !world.lets_on(hit)).map_or(place, |hit| hit.point);
        let mut transport = Radiance { rules: direct, sum: Rgb::ZERO };
        integrator.trace_on(&mut transport, ray, f64::INFINITY, hit.as_ref(), Sampler::new(0, number as u64, 0, 1));
        Found { place: there, radiance: bright(transport.sum), far: there.distance_squared(place) }
    };
    (0..each * places.len()).map(look).collect()
}

/// The mean radiance that directions show.
fn mean(looks: &[Found]) -> f64 {
    looks.iter().map(|look| look.radiance).sum::<f64>() / looks.len() as f64
}

/// The surfaces among what directions show that are bright.
fn bright_ones(looks: &[Found]) -> Vec<Found> {
    let least = BRIGHT * mean(looks);
    looks.iter().filter(|look| look.far > 0.0 && look.radiance > least).copied().collect()
}

/// Whether these, of what directions show, make the light of a sample spread.
fn spread(some: &[Found], looks: &[Found]) -> bool {
    let squares: f64 = some.iter().map(|look| look.radiance * look.radiance).sum();
    (squares / looks.len() as f64).sqrt() >= SPREAD * mean(looks)
}

/// The pools of light among what directions show; none if they do not make the light of a sample spread.
fn pools(looks: &[Found]) -> Vec<Pool> {
    let mut groups = Vec::new();
    apart(bright_ones(looks), &mut groups);
    let (mut pools, mut members) = (Vec::new(), Vec::new());
    for group in groups.into_iter().filter(|group| group.len() >= FEW) {
        let (low, high) = bounds(&group);
        let middle = low.midpoint(high);
        let reach = group.iter().map(|look| look.place.distance(middle)).fold(0.0, f64::max);
        // Those at the rim were hardly found.
        let radius = reach * (1.0 + 1.0 / group.len() as f64);
        let within = looks.iter().filter(|look| look.far > 0.0 && look.place.distance(middle) <= radius).copied();
        if mean(&within.collect::<Vec<_>>()) > BRIGHT * mean(looks) {
            pools.push(Pool { middle, radius, power: group.iter().map(|look| look.radiance * look.far).sum() });
            members.extend(group);
        }
    }
    if spread(&members, looks) { pools } else { Vec::new() }
}

/// The corners of the box around some places.
fn bounds(group: &[Found]) -> (Vec3, Vec3) {
    let corner = |of: fn(Vec3, Vec3) -> Vec3| group.iter().map(|look| look.place).reduce(of).unwrap_or(Vec3::ZERO);
    (corner(Vec3::min), corner(Vec3::max))
}

/// Takes a group apart where it is two or more, and what is long into what is round.
fn apart(mut group: Vec<Found>, groups: &mut Vec<Vec<Found>>) {
    let (low, high) = bounds(&group);
    let extent = (high - low).to_array();
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| extent[*b].total_cmp(&extent[*a]));
    let [longest, next, _] = axes;
    let count = group.len();
    if count < 2 * FEW || groups.len() + 1 >= MOST_POOLS {
        return groups.push(group);
    }
    group.sort_by(|a, b| a.place[longest].total_cmp(&b.place[longest]));
    let gap = |i: &usize| group[*i].place[longest] - group[i - 1].place[longest];
    let widest = (1..count).max_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap_or(1);
    // Of as many places at random the widest gap is rarely wider than that.
    let by_chance = (3.0 * (count as f64).ln() / count as f64).max(0.25);
    let cut = if gap(&widest) > by_chance * extent[longest] {
        widest
    } else if extent[longest] > 2.0 * extent[next] {
        count / 2
    } else {
        return groups.push(group);
    };
    let rest = group.split_off(cut);
    apart(group, groups);
    apart(rest, groups);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// A world of a text, surveyed from above a floor.
    fn world(text: &str) -> World {
        let mut world = World::of(text);
        let rays = (0..1000).map(|i| Ray::new(Vec3::new(0.0, 0.0, 0.5), Frame::around(-Vec3::Z).to_world(cosine_hemisphere(lattice(i)))));
        survey(&mut world, rays, &Rules::default());
        world
    }

    /// The mean of so many samples of the irradiance at a point of the floor, and that of their squares.
    fn irradiance(world: &World, at: Vec3, count: u32) -> (f64, f64) {
        let rules = Rules::default();
        let mut integrator = Integrator::new(world, &rules);
        let samples = (0..count).map(|index| {
            let mut transport = Radiance { rules: &rules, sum: Rgb::ZERO };
            integrator.irradiance(&mut transport, at, Vec3::Z, Sampler::new(7, 0, 0, index));
            transport.sum.x
        });
        let (sum, squares) = samples.fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        (sum / f64::from(count), squares / f64::from(count))
    }

    #[test]
    fn a_small_glow_is_a_pool_that_gives_the_light_of_a_disc() {
        // A disc of radiance 9 and radius r, h above a point: its irradiance there is 9 π r²/(r² + h²). The floor is black.
        let lit = |radius: f64| {
            world(&format!(
                "void glow panel 0 0 4 9 9 9 0  panel ring disc 0 0 8 0 0 2  0 0 -1  0 {radius}
                 void plastic black 0 0 5 0 0 0 0 0  black ring floor 0 0 8 0 0 0  0 0 1  0 3"
            ))
        };
        let world = lit(0.1);
        assert!(world.has_pools() && !lit(2.0).has_pools());
        let (mean, _) = irradiance(&world, Vec3::ZERO, 1 << 14);
        assert!((mean * (0.01 + 4.0) / (9.0 * PI * 0.01) - 1.0).abs() < 0.02, "{mean}");
    }

    #[test]
    fn the_density_of_directions_toward_pools_integrates_to_one() {
        let mut world = world("void plastic black 0 0 5 0 0 0 0 0  black ring floor 0 0 8 0 0 0  0 0 1  0 3");
        assert!(!world.has_pools(), "nothing is lit");
        let pool = |x: f64, radius| Pool { middle: Vec3::new(x, 0.0, 2.0), radius, power: 1.0 + x };
        world.aim_at(vec![pool(0.0, 0.5), pool(0.3, 0.6), pool(2.0, 0.1)]);
        let (count, mut sum) = (400, 0.0);
        for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
            let z: f64 = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count);
            let (sin, cos) = (2.0 * PI * (f64::from(j) + 0.5) / f64::from(count)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            sum += world.pool_pdf(Vec3::ZERO, Vec3::new(r * cos, r * sin, z)) * 4.0 * PI / f64::from(count * count);
        }
        assert!((sum - 1.0).abs() < 0.01, "{sum}");
        // What is within a pool aims at the others.
        let (direction, density) = world.sample_pool(Vec3::new(0.0, 0.0, 1.8), 0.5, [0.5; 2]).unwrap();
        assert!(direction.x > 0.9 && density > 0.0);
    }

    #[test]
    fn pools_change_the_noise_of_light_and_not_the_light() {
        // The sun through a hole in the roof of a box shines on one wall.
        let mut world = world(
            "void light solar 0 0 3 1e6 1e6 1e6  solar source sun 0 0 4 2 0 1 .5  void plastic wall 0 0 5 .5 .5 .5 .05 .1
             wall ring floor 0 0 8 0 0 0  0 0 1  0 3  wall ring roof 0 0 8 0 0 2  0 0 -1  .15 3  wall cylinder round 0 0 7 0 0 0  0 0 2  3",
        );
        assert!(world.has_pools());
        let at = Vec3::new(1.0, 1.0, 0.0);
        let (mean, squares) = irradiance(&world, at, 1 << 13);
        world.aim_at(Vec::new());
        let (plain, plain_squares) = irradiance(&world, at, 1 << 17);
        let error = ((plain_squares - plain * plain) / f64::from(1 << 17)).sqrt();
        assert!((mean - plain).abs() < 4.0 * error, "{mean} {plain} ± {error}");
        assert!(squares - mean * mean < 0.3 * (plain_squares - plain * plain), "{squares} {plain_squares}");
    }
}
