//! Lamps that an illumination field shows: where they stand, told from the directions that its probes see them in.
//!
//! Blended of two probes, a near lamp is seen twice, and from a place beside the probes in a wrong direction and too bright or too dark. But what
//! all of three or more probes see, small, round and as bright, stands where their lines of sight meet: there it is put, a sphere, and taken out
//! of their environments. (What some do not see has something before it, which is not in the scene.)

use crate::color::{Rgb, bright};
use crate::environment::{CELL, Spot};
use crate::vector::{Mat3, Vec3};

/// The fewest probes that see a lamp.
const FEWEST: usize = 3;
/// How many times as bright, or as large, as to all the same lamp may seem to a probe.
const ALIKE: f64 = 1.4;
/// The least angle between two lines of sight that tells a distance, radians.
const PARALLAX: f64 = 0.02;
/// How many times that angle must be the one by which the lines miss each other.
const CLEAR: f64 = 6.0;

/// A lamp in the room.
#[derive(Clone, Debug)]
pub(super) struct Globe {
    /// Its middle.
    pub center: Vec3,
    /// Its radius.
    pub radius: f64,
    /// What it emits.
    pub radiance: Rgb,
    /// For each probe, the spot that it is there.
    pub spots: Vec<Spot>,
    /// The largest angle between one of those and where it stands.
    missed: f64,
}

/// The lamps that are seen from all these places, among the spots that `seen` finds from each of them.
pub(super) fn globes(places: &[Vec3], seen: impl Fn(usize) -> Vec<Spot>) -> Vec<Globe> {
    if places.len() < FEWEST {
        return Vec::new();
    }
    // What one does not see is not looked for from the others.
    let spots = (0..places.len()).map(|i| Some(seen(i)).filter(|spots| !spots.is_empty()));
    let Some(spots) = spots.collect::<Option<Vec<_>>>() else { return Vec::new() };
    let pairs = (0..places.len()).flat_map(|j| (0..j).map(move |i| [i, j]));
    // The two that are farthest apart tell best where lines meet.
    let apart = |&[i, j]: &[usize; 2]| places[i].distance(places[j]);
    let Some([i, j]) = pairs.max_by(|a, b| apart(a).total_cmp(&apart(b))) else { return Vec::new() };
    let both = spots[i].iter().flat_map(|a| spots[j].iter().map(move |b| [(places[i], a.direction), (places[j], b.direction)]));
    let mut found: Vec<Globe> = both.filter_map(|lines| Globe::near(meet(&lines)?, places, &spots)).collect();
    found.sort_by(|a, b| a.missed.total_cmp(&b.missed));
    // No spot is two lamps.
    let mut globes: Vec<Globe> = Vec::new();
    for globe in found {
        let shared = |other: &Globe| other.spots.iter().zip(&globe.spots).any(|(a, b)| a.direction == b.direction);
        if !globes.iter().any(shared) {
            globes.push(globe);
        }
    }
    globes
}

impl Globe {
    /// The lamp at about `center`, if all probes see one there and tell how far it is.
    fn near(center: Vec3, places: &[Vec3], spots: &[Vec<Spot>]) -> Option<Self> {
        let off = |spot: &Spot, place: Vec3, center: Vec3| spot.direction.angle_between(center - place);
        let nearest = |(&place, spots): (&Vec3, &Vec<Spot>)| {
            let there = spots.iter().filter(|spot| off(spot, place, center) < 0.5 * spot.angle + CELL);
            there.min_by(|a, b| off(a, place, center).total_cmp(&off(b, place, center))).copied()
        };
        let spots: Vec<Spot> = places.iter().zip(spots).map(nearest).collect::<Option<_>>()?;
        let lines: Vec<(Vec3, Vec3)> = places.iter().zip(&spots).map(|(&place, spot)| (place, spot.direction)).collect();
        let center = meet(&lines)?;
        let missed = places.iter().zip(&spots).map(|(&place, spot)| off(spot, place, center)).fold(0.0, f64::max);
        let parallax = lines.iter().flat_map(|a| lines.iter().map(|b| a.1.angle_between(b.1))).fold(0.0, f64::max);
        let radii: Vec<f64> = places.iter().zip(&spots).map(|(place, spot)| place.distance(center) * spot.angle.sin()).collect();
        let count = places.len() as f64;
        let radius = radii.iter().sum::<f64>() / count;
        let radiance = spots.iter().map(|spot| spot.radiance).sum::<Rgb>() / count;
        let alike = |a: f64, b: f64| a < ALIKE * b && b < ALIKE * a;
        let one = radii.iter().all(|r| alike(*r, radius)) && spots.iter().all(|spot| alike(bright(spot.radiance), bright(radiance)));
        (one && parallax > PARALLAX.max(CLEAR * missed)).then_some(Self { center, radius, radiance, spots, missed })
    }
}

/// The point nearest to lines through places along unit directions, in front of all of them; `None` for parallel ones.
fn meet(lines: &[(Vec3, Vec3)]) -> Option<Vec3> {
    let (mut across, mut sum) = (Mat3::ZERO, Vec3::ZERO);
    for &(place, d) in lines {
        let project = Mat3::IDENTITY - Mat3::from_cols(d * d.x, d * d.y, d * d.z);
        across += project;
        sum += project * place;
    }
    let point = across.inverse() * sum;
    (point.is_finite() && lines.iter().all(|(place, d)| (point - *place).dot(*d) > 0.0)).then_some(point)
}
