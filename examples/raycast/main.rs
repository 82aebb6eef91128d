//! How many rays a second are cast against a mesh: the half of `compare.py` that is ours.
//!
//! `raycast MESH.obj RAYS [TWIN]` or `raycast knots:TRIANGLES RAYS [TWIN]` builds the tree, makes three sets of RAYS rays (primary, bounced,
//! shadow) and says what that cost. With TWIN it writes triangles and rays to that file, for another ray caster. Then, for each line
//! with the name of a set on standard input, it casts that set and prints nanoseconds a ray and how many rays hit.
//!
//! `raycast leaks RAYS` counts the rays that find a gap between the triangles of a closed surface.

use inverad::accel::{Accel, Geometry, Surface};
use inverad::geometry::{Mesh, Ray};
use inverad::import;
use inverad::sampling::{Sampler, cosine_hemisphere};
use inverad::vector::{Affine, Frame, Vec3};
use std::f64::consts::TAU;
use std::io::{self, BufRead, Write};
use std::sync::Arc;
use std::time::Instant;

/// A ray and its range.
struct Cast {
    ray: Ray,
    t_min: f64,
    t_max: f64,
}

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [leaking, count] = words.as_slice()
        && leaking == "leaks"
    {
        println!("{} of {count} rays found a gap", leaks(count.parse()?)?);
        return Ok(());
    }
    let (scene, count) = match words.as_slice() {
        [scene, count] | [scene, count, _] => (scene, count.parse()?),
        _ => return Err("usage: raycast MESH.obj|knots:TRIANGLES RAYS [TWIN], or raycast leaks RAYS".into()),
    };
    let mesh = Arc::new(match scene.strip_prefix("knots:") {
        Some(triangles) => knots(triangles.parse()?),
        None => import::mesh(std::fs::read(scene)?, scene)?.mesh,
    });
    let start = Instant::now();
    let accel = Accel::build(vec![Surface::from(Geometry::Mesh(mesh.clone(), Affine::IDENTITY))])?;
    let built = start.elapsed().as_secs_f64();
    let sets = rays(&accel, count, scene.starts_with("knots:"));
    if let Some(twin) = words.get(2) {
        std::fs::write(twin, twins(&mesh, &sets))?;
    }
    println!("{} triangles, built in {built:.3} s, {:.1} MB", mesh.triangles.len(), accel.bytes() as f64 / 1e6);
    for line in io::stdin().lock().lines() {
        let line = line?;
        let set = ["primary", "bounced", "shadow"].iter().position(|name| *name == line);
        let set = set.ok_or("not a set of rays; the sets are primary, bounced and shadow")?;
        let start = Instant::now();
        let mut hits = 0;
        match set {
            // Those of a picture are beside one another.
            0 => accel.nearest_each(sets[0].iter().map(|c| (&c.ray, [c.t_min, c.t_max])), |_, hit| hits += usize::from(hit.is_some())),
            1 => hits = sets[1].iter().filter(|c| accel.nearest(&c.ray, c.t_min, c.t_max).is_some()).count(),
            _ => hits = sets[2].iter().filter(|c| accel.occluded(&c.ray, c.t_min, c.t_max)).count(),
        }
        println!("{:.3} {hits}", start.elapsed().as_secs_f64() * 1e9 / sets[set].len() as f64);
        io::stdout().flush()?;
    }
    Ok(())
}

/// Trefoil knots on a grid in a closed room of twelve triangles: about so many triangles in all. Every ray hits.
fn knots(triangles: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let size = Vec3::new(6.0, 3.0, 6.0);
    mesh.positions.extend((0..8).map(|i| Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * size));
    for [a, b, c, d] in [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]] {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    for knot in 0..12 {
        let middle = Vec3::new((knot % 3) as f64 * 2.0 + 1.0, (knot / 3 % 2) as f64 * 1.4 + 0.8, (knot / 6) as f64 * 3.0 + 1.5);
        add_knot(&mut mesh, middle, triangles / 12);
    }
    mesh
}

/// The middle of the rope of a knot.
fn axis(t: f64) -> Vec3 {
    Vec3::new((3.0 * t).sin(), t.sin() + 2.0 * (2.0 * t).sin(), 2.0 * (2.0 * t).cos() - t.cos()) * 0.2
}

/// Adds a knot of about so many triangles.
fn add_knot(mesh: &mut Mesh, middle: Vec3, triangles: usize) {
    // Four points around the rope for 25 along it.
    let points = ((triangles as f64 / 2.0 * 0.16).sqrt() as u32).max(3);
    let rings = (triangles as u32 / (2 * points)).max(3);
    let first = mesh.positions.len() as u32;
    for i in 0..rings {
        let t = TAU * f64::from(i) / f64::from(rings);
        let along = (axis(t + 1e-4) - axis(t - 1e-4)).normalize();
        let across = Vec3::X.cross(along).normalize();
        for j in 0..points {
            let (sin, cos) = (TAU * f64::from(j) / f64::from(points)).sin_cos();
            mesh.positions.push(middle + axis(t) + (across * cos + along.cross(across) * sin) * 0.13);
        }
    }
    let vertex = |i: u32, j: u32| first + i % rings * points + j % points;
    for (i, j) in (0..rings).flat_map(|i| (0..points).map(move |j| (i, j))) {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
}

/// How many of `count` rays leave a knot of 10⁵ triangles from inside its rope, two thirds aimed at its edges and one at its vertices: of each
/// sixteen that are aimed at neighbouring triangles from one place, alone or together.
fn leaks(count: usize) -> Result<usize> {
    let mut mesh = Mesh::default();
    add_knot(&mut mesh, Vec3::ZERO, 100_000);
    let mesh = Arc::new(mesh);
    let accel = Accel::build(vec![Surface::from(Geometry::Mesh(mesh.clone(), Affine::IDENTITY))])?;
    let mut leaks = 0;
    for first in (0..count).step_by(16) {
        let mut sampler = Sampler::new(1, first as u64, 0, 0);
        let ([turn, at], mut rays) = (sampler.pair(), Vec::new());
        let origin = axis(TAU * turn);
        for i in first..(first + 16).min(count) {
            let triangle = (at * mesh.triangles.len() as f64) as usize + i - first;
            let [a, b, _] = mesh.corners((triangle % mesh.triangles.len()) as u32);
            let target = if i % 3 == 0 { a } else { a + (b - a) * sampler.pair()[0] };
            rays.push(Ray::new(origin, (target - origin).normalize()));
        }
        leaks += rays.iter().filter(|ray| accel.nearest(ray, 0.0, f64::INFINITY).is_none()).count();
        accel.nearest_each(rays.iter().map(|ray| (ray, [0.0, f64::INFINITY])), |_, hit| leaks += usize::from(hit.is_none()));
    }
    Ok(leaks)
}

/// Primary rays of a pinhole camera in tiles of 4 × 4 pixels; one bounced ray, distributed by the cosine, from every place they hit; and
/// from the same places one shadow ray, uniform over the hemisphere and half as long as the scene. The room is seen from `inside`.
fn rays(accel: &Accel, count: usize, inside: bool) -> [Vec<Cast>; 3] {
    let (bounds, side) = (accel.bounds(), ((count as f64).sqrt() as u32 / 4).max(1) * 4);
    let (size, target) = (bounds.size(), bounds.center());
    let eye = target + Vec3::new(0.31, 0.17, 1.0) * size * if inside { 0.4 } else { 1.3 };
    let eye = if inside { eye.clamp(bounds.min + 0.05 * size, bounds.max - 0.05 * size) } else { eye };
    let frame = Frame::around((target - eye).normalize());
    let width = if inside { 0.8 } else { 0.42 };
    let mut sets = [const { Vec::new() }; 3];
    let single = |v: Vec3| Vec3::from(v.to_array().map(|x| f64::from(x as f32)));
    let mut add = |set: usize, origin: Vec3, direction: Vec3, t_min: f64, t_max: f64| {
        sets[set].push(Cast {
            ray: Ray::new(single(origin), single(direction)),
            t_min: f64::from(t_min as f32),
            t_max: f64::from(t_max as f32),
        });
    };
    for i in 0..side * side {
        let (tile, within) = (i / 16, i % 16);
        let (x, y) = (tile % (side / 4) * 4 + within % 4, tile / (side / 4) * 4 + within / 4);
        let at = |p: u32| (f64::from(p) + 0.5) / f64::from(side) * 2.0 - 1.0;
        let direction = frame.to_world(Vec3::new(at(x) * width, at(y) * width, 1.0).normalize());
        add(0, eye, direction, 0.0, f64::INFINITY);
        let Some(hit) = accel.nearest(&Ray::new(eye, direction), 0.0, f64::INFINITY) else { continue };
        let normal = if hit.normal.dot(direction) < 0.0 { hit.normal } else { -hit.normal };
        let mut sampler = Sampler::new(0, u64::from(i), 0, 0);
        let onward = Frame::around(normal);
        add(1, hit.point, onward.to_world(cosine_hemisphere(sampler.pair())), 1e-4 * size, f64::INFINITY);
        let [z, turn] = sampler.pair();
        let (sin, cos) = (TAU * turn).sin_cos();
        let r = (1.0 - z * z).sqrt();
        add(2, hit.point, onward.to_world(Vec3::new(r * cos, r * sin, z)), 1e-4 * size, 0.5 * size);
    }
    sets
}

/// Triangles and rays in single precision, in the byte order of the machine: the numbers of vertices, triangles and rays of each set; vertices;
/// triangles; of each ray origin, direction, range.
fn twins(mesh: &Mesh, sets: &[Vec<Cast>; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let counts = [mesh.positions.len(), mesh.triangles.len(), sets[0].len(), sets[1].len(), sets[2].len()];
    counts.iter().for_each(|&n| bytes.extend((n as u32).to_ne_bytes()));
    let mut put = |x: f64| bytes.extend((x as f32).to_ne_bytes());
    mesh.positions.iter().for_each(|p| p.to_array().into_iter().for_each(&mut put));
    mesh.triangles.iter().flatten().for_each(|v| bytes.extend(v.to_ne_bytes()));
    let mut put = |x: f64| bytes.extend((x as f32).to_ne_bytes());
    for c in sets.iter().flatten() {
        c.ray.origin.to_array().into_iter().chain(c.ray.direction.to_array()).chain([c.t_min, c.t_max]).for_each(&mut put);
    }
    bytes
}
