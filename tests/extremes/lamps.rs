//! Light sources and environment maps: what they shine on a Lambertian surface of albedo 1/2.

use super::table::{Room, Table};
use inverad::geometry::Ray;
use inverad::picture::hdr::{decode, encode};
use inverad::picture::{Header, Picture};
use inverad::vector::Vec3;
use std::f64::consts::PI;

const SAMPLES: u32 = 256;

/// The ground that is lit at the origin, seen from above.
fn lit(lamp: &str) -> f64 {
    Room::of(&format!("void plastic p 0 0 5 .5 .5 .5 0 0\np ring r 0 0 8 0 0 0 0 0 1 0 1e-3\n{lamp}")).seen(1e-3, SAMPLES)
}

pub fn fill(table: &mut Table) {
    // Seen itself, a light is what it says.
    for radiance in [1e-30, 1e-5, 1.0, 1e9, 1e30] {
        for kind in ["light g 0 0 3 R R R", "glow g 0 0 4 R R R 0", "spotlight g 0 0 7 R R R 90 0 0 1"] {
            let room = Room::of(&format!("void {}\ng ring r 0 0 8 0 0 0 0 0 1 0 1\n", kind.replace('R', &format!("{radiance:e}"))));
            table.near(format!("{} of {radiance:e}, seen", kind.split(' ').next().unwrap()), radiance, room.seen(1.0, 1), 1e-12);
        }
    }
    // A distant disk overhead: E = π L sin²(angle/2).
    for angle in [1e-6, 1e-4, 0.01, 0.533, 10.0, 90.0, 180.0] {
        let sine = f64::to_radians(angle / 2.0).sin();
        let expected = 0.5 * 1e9 * sine * sine;
        let found = lit(&format!("void light l 0 0 3 1e9 1e9 1e9\nl source s 0 0 4 0 0 1 {angle:e}\n"));
        table.near(format!("sun of 1e9, {angle:e} degrees wide"), expected, found, if angle < 1.0 { 1e-3 } else { 0.02 });
    }
    // Low above the horizon: cosine times solid angle.
    for elevation in [1.0, 1e-2, 1e-3] {
        let height = f64::sin(elevation);
        let found = lit(&format!("void light l 0 0 3 1e9 1e9 1e9\nl source s 0 0 4 {} 0 {height} 1e-3\n", f64::cos(elevation)));
        let sine = f64::to_radians(0.5e-3).sin();
        table.near(format!("sun of 1e9, {elevation:e} above the horizon"), 0.5 * 1e9 * sine * sine * height, found, 1e-5);
    }
    // A sphere of radius r at the distance 1 overhead: E = π L r².
    for radius in [1e-6, 1e-3, 0.5, 0.999, 1.0 - 1e-6] {
        let found = lit(&format!("void light l 0 0 3 1 1 1\nl sphere s 0 0 4 0 0 1 {radius}\n"));
        table.near(format!("spherical light of radius {radius} at distance 1"), 0.5 * radius * radius, found, 0.02);
    }
    // A disk of radius r at the height h: E = π L r² / (r² + h²).
    for (radius, height) in [(1e-6, 1.0), (1.0, 1.0), (1.0, 0.1), (1e-3, 1e-3), (1e3, 1e4), (1e6, 1e7)] {
        let found = lit(&format!("void light l 0 0 3 1 1 1\nl ring d 0 0 8 0 0 {height} 0 0 -1 0 {radius}\n"));
        let expected = 0.5 * radius * radius / (radius * radius + height * height);
        table.near(format!("disk light of radius {radius:e} at height {height:e}"), expected, found, 0.02);
    }
    // A square of half side a at the height 1: E = 4 L a/√(1 + a²) atan(a/√(1 + a²)).
    for half in [1e-6, 1e-3, 1.0, 10.0] {
        let corners = [[-1, 1], [1, 1], [1, -1], [-1, -1]].map(|[x, y]| format!("{} {} 1", f64::from(x) * half, f64::from(y) * half));
        let found = lit(&format!("void light l 0 0 3 1 1 1\nl polygon d 0 0 12 {}\n", corners.join(" ")));
        let slant = half / f64::hypot(1.0, half);
        table.near(format!("square light of half side {half:e}"), 0.5 * 4.0 * slant * slant.atan() / PI, found, 0.05);
    }
    maps(table);
}

/// An environment map of these pixels, 16 rows of 32, and the ground or nothing in it.
fn map(pixel: impl Fn(usize, usize) -> f64, ground: bool) -> Room {
    let (width, height) = (32, 16);
    let pixels = (0..width * height).map(|i| [pixel(i % width, i / width) as f32; 3]).collect();
    let bytes = Picture { width, height, header: Header::new("made"), pixels }.write_hdr().unwrap();
    let text =
        "void colorpict map 7 red green blue map.hdr latlong.cal ll_u ll_v 0 0\nmap glow e 0 0 4 1 1 1 0\ne source sky 0 0 4 0 0 1 360\n";
    let ground = if ground { "void plastic p 0 0 5 .5 .5 .5 0 0\np ring r 0 0 8 0 0 0 0 0 1 0 1\n" } else { "" };
    Room::with(&format!("{text}{ground}"), &[("map.hdr", &bytes)])
}

fn maps(table: &mut Table) {
    for value in [1e-30, 1e-9, 1.0, 1e9, 1e30, 1.5e38] {
        let stored = f64::from(decode(encode([value as f32; 3]).unwrap())[0]);
        let found = map(|_, _| value, true).seen(1.0, 64);
        table.near(format!("environment of pixels {value:e}"), 0.5 * stored, found, 1e-6);
    }
    // The sun in one pixel, from row to row and across the seam. Its irradiance is summed from the radiance seen, around that pixel.
    for (sun, rest) in [(1e9, 1.0), (1e9, 0.0), (1e30, 1e-30), (1e30, 1.0), (1.5e38, 1.0), (1e-20, 1e-30)] {
        for (column, row) in [(0, 5), (7, 0), (16, 3), (31, 6)] {
            let at = |x: usize, y: usize| if (x, y) == (column, row) { sun } else { rest };
            let sky = map(at, false);
            // The outermost pixels lie at the ends: at −x, and at the poles.
            let (steps, wide, high) = (64, 2.0 * PI / 31.0, PI / 15.0);
            let mut sum = 0.0;
            for i in 0..2 * steps {
                for j in 0..2 * steps {
                    let off = |k: usize| (k as f64 + 0.5) / steps as f64 - 1.0;
                    let (polar, azimuth) = ((row as f64 + off(i)) * high, (column as f64 + off(j)) * wide - PI);
                    if polar > 0.0 && azimuth.abs() < PI {
                        let (sin, cos) = polar.sin_cos();
                        let direction = Vec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
                        let excess = sky.light(Ray::new(Vec3::ZERO, direction), 1).y - rest;
                        sum += excess * sin * cos.max(0.0) * wide * high / (steps * steps) as f64;
                    }
                }
            }
            let found = map(at, true).seen(1.0, 4096);
            let expected = 0.5 * (rest + sum / PI);
            table.near(format!("environment of {rest:e} with {sun:e} in pixel {column},{row}"), expected, found, 0.02);
        }
    }
}
