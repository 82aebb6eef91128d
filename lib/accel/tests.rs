mod coincident;

use super::*;
use crate::geometry::TINY;
use proptest::prelude::*;
use std::collections::HashMap;

/// A generator of numbers in [0, 1) (Steele et al. 2014, SplitMix).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * 2.0 - Vec3::ONE
    }

    fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.next();
        let (sin, cos) = (std::f64::consts::TAU * self.next()).sin_cos();
        Vec3::new(cos, sin, 0.0) * (1.0 - z * z).max(0.0).sqrt() + Vec3::Z * z
    }
}

fn build(surfaces: Vec<Geometry>) -> Accel {
    Accel::build(surfaces.into_iter().map(Surface::from).collect()).unwrap()
}

fn mesh(mesh: Mesh) -> Geometry {
    Geometry::Mesh(Arc::new(mesh), Affine::IDENTITY)
}

fn shape(kind: &str, reals: &[f64]) -> Shape {
    Shape::new(kind, reals, &mut Vec::new()).unwrap().unwrap()
}

/// A closed ball of triangles: an octahedron divided `levels` times, its vertices moved off the sphere by up to `bumps`.
fn ball(levels: u32, bumps: f64) -> Mesh {
    let mut positions = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut triangles: Vec<[u32; 3]> = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
            })
            .collect();
    }
    let mut random = Random(1);
    positions.iter_mut().for_each(|p| *p *= 1.0 + bumps * random.next());
    Mesh { positions, triangles, ..Mesh::default() }
}

/// A closed cube from 0 to 1, `n` × `n` squares of two triangles a face, corners at multiples of 1/n.
fn lattice(n: u32) -> Mesh {
    let mut m = Mesh::default();
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let first = m.positions.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let mut p = Vec3::ZERO;
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    m.positions.push(p);
                }
            }
            for i in 0..n {
                for j in 0..n {
                    let a = first + i * (n + 1) + j;
                    m.triangles.extend([[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]]);
                }
            }
        }
    }
    m
}

/// The distance of the nearest hit on a mesh, over all its triangles, in double precision (Möller and Trumbore 1997).
fn by_force(mesh: &Mesh, ray: &Ray, t_min: f64) -> Option<f64> {
    let hit = |t: u32| {
        let [a, b, c] = mesh.corners(t);
        let (e1, e2, s) = (b - a, c - a, ray.origin - a);
        let p = ray.direction.cross(e2);
        let q = s.cross(e1);
        let det = e1.dot(p);
        let (u, v, t) = (s.dot(p) / det, ray.direction.dot(q) / det, e2.dot(q) / det);
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > t_min).then_some(t)
    };
    (0..mesh.triangles.len() as u32).filter_map(hit).min_by(f64::total_cmp)
}

/// Compares with brute force; single precision may decide otherwise only at a silhouette.
fn compare(mesh_in: Mesh, rays: usize, size: f64, center: Vec3) {
    let accel = build(vec![mesh(mesh_in.clone())]);
    let mut random = Random(7);
    let mut different = 0;
    for _ in 0..rays {
        let origin = center + random.point() * 3.0 * size;
        let ray = Ray::new(origin, (center + random.point() * size - origin).normalize());
        let (found, expected) = (accel.nearest(&ray, TINY * size.min(1.0), 1e10), by_force(&mesh_in, &ray, TINY * size.min(1.0)));
        assert_eq!(accel.occluded(&ray, TINY * size.min(1.0), 1e10), found.is_some());
        match (found, expected) {
            (Some(hit), Some(t)) if (hit.t - t).abs() <= 1e-9 * size.max(hit.t) => {
                let [a, b, c] = mesh_in.corners(hit.triangle);
                let [v, w] = hit.barycentric;
                let error = (a * (1.0 - v - w) + b * v + c * w - hit.point).length().max((ray.at(hit.t) - hit.point).length());
                assert!(error <= 1e-9 * size + 1e-14 * center.length(), "{error}");
                assert!((hit.normal - (b - a).cross(c - a).normalize()).length() < 1e-12);
            }
            (None, None) => {}
            _ => different += 1,
        }
    }
    assert!(different <= (rays / 10000).max(1), "{different} of {rays} differ");
}

#[test]
fn the_nearest_hit_is_that_of_brute_force() {
    compare(ball(3, 0.2), 20000, 1.0, Vec3::ZERO);
}

#[test]
fn far_away_and_scaled_scenes_lose_nothing() {
    for (size, center) in [(1e-6, Vec3::ZERO), (1e6, Vec3::ZERO), (1.0, Vec3::new(1e5, -2e5, 3e4)), (1e-3, Vec3::splat(1e3))] {
        let mut m = ball(2, 0.2);
        m.positions.iter_mut().for_each(|p| *p = *p * size + center);
        compare(m, 5000, size, center);
    }
}

#[test]
fn a_small_mesh_in_a_large_scene_keeps_its_detail() {
    let center = Vec3::new(9e4, 9e4, 1.0);
    let mut m = ball(3, 0.2);
    m.positions.iter_mut().for_each(|p| *p = *p * 0.1 + center);
    let ground = shape("polygon", &[-1e5, -1e5, 0., 1e5, -1e5, 0., 1e5, 1e5, 0., -1e5, 1e5, 0.]);
    let accel = build(vec![mesh(m.clone()), Geometry::Shape(ground)]);
    let mut random = Random(3);
    for _ in 0..5000 {
        let origin = center + random.point();
        let ray = Ray::new(origin, (center + random.point() * 0.07 - origin).normalize());
        let Some(t) = by_force(&m, &ray, TINY) else { continue };
        let hit = accel.nearest(&ray, TINY, 1e10).unwrap();
        assert!((hit.t - t).abs() < 1e-9 && hit.surface == 0, "{} {t}", hit.t);
    }
}

#[test]
fn no_ray_leaves_a_closed_mesh_through_edges_or_vertices() {
    let m = ball(4, 0.3);
    let accel = build(vec![mesh(m.clone())]);
    let mut random = Random(5);
    for i in 0..200_000 {
        let origin = random.point() * 0.3;
        let [a, b, c] = m.corners((random.next() * m.triangles.len() as f64) as u32);
        let to = [a, a.lerp(b, random.next()), c.lerp(a, 0.5)][i % 3];
        let ray = Ray::new(origin, (to - origin).normalize());
        assert!(accel.nearest(&ray, TINY, 1e10).is_some() && accel.occluded(&ray, TINY, 1e10), "{ray:?}");
    }
}

#[test]
fn rays_along_the_lattice_of_an_axis_aligned_box_do_not_leak() {
    let n = 16;
    let accel = build(vec![mesh(lattice(n))]);
    let mut random = Random(9);
    for _ in 0..100_000 {
        let mut place = || (1.0 + (random.next() * f64::from(n - 1)).floor()) / f64::from(n);
        let origin = Vec3::new(place(), place(), place());
        let step = |x: f64| (x * 3.0).floor() - 1.0;
        let d = Vec3::new(step(random.next()), step(random.next()), step(random.next()));
        if d != Vec3::ZERO {
            let ray = Ray::new(origin, d.normalize());
            let hit = accel.nearest(&ray, TINY, 1e10).expect("inside a closed box");
            let wall = (0..3).map(|i| {
                if d[i] > 0.0 {
                    (1.0 - origin[i]) / ray.direction[i]
                } else if d[i] < 0.0 {
                    -origin[i] / ray.direction[i]
                } else {
                    9.0
                }
            });
            assert!((hit.t - wall.fold(9.0, f64::min)).abs() < 1e-12);
            assert!(accel.occluded(&ray, TINY, 1e10));
        }
    }
}

#[test]
fn a_ray_from_a_surface_does_not_meet_it_again() {
    let m = ball(4, 0.1);
    for scale in [1e-3, 1.0, 1e3] {
        let mut m = m.clone();
        m.positions.iter_mut().for_each(|p| *p *= scale);
        let accel = build(vec![mesh(m.clone())]);
        let mut random = Random(11);
        for _ in 0..20_000 {
            let hit = accel.nearest(&Ray::new(random.point() * 0.5 * scale, random.direction()), TINY, 1e10).unwrap();
            let (d, n) = (random.direction(), hit.normal);
            let out = if d.dot(n) > 0.0 { d } else { -d };
            // Whatever the ball's bumps let it meet, it is not the triangle it starts on, and that is found in double precision.
            let ray = Ray::new(hit.point, out);
            let next = accel.nearest(&ray, 1e-6 * scale.min(1.0), 1e10);
            assert!(next.is_none_or(|next| next.triangle != hit.triangle), "{scale} {next:?}");
            assert_eq!(next.is_some(), accel.occluded(&ray, 1e-6 * scale.min(1.0), 1e10));
        }
    }
}

#[test]
fn the_ends_of_the_range_are_exact() {
    let m = lattice(4);
    let square = shape("polygon", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    for geometry in [mesh(m), Geometry::Shape(square)] {
        let accel = build(vec![geometry, Geometry::Shape(shape("sphere", &[0., 0., 50., 1.]))]);
        let ray = Ray::new(Vec3::new(0.3, 0.4, -1.0), Vec3::Z);
        for (low, high, hit) in
            [(0.0, 1.0, false), (0.0, 1.0 + 1e-12, true), (1.0, 1.5, false), (1.0 - 1e-12, 1.5, true), (0.9, 1.1, true), (1.1, 1.2, false)]
        {
            assert_eq!(accel.nearest(&ray, low, high).is_some(), hit, "{low} {high}");
            assert_eq!(accel.occluded(&ray, low, high), hit, "{low} {high}");
        }
    }
}

#[test]
fn shapes_and_meshes_share_a_tree() {
    let mut random = Random(13);
    let mut surfaces = vec![mesh(ball(3, 0.0))];
    for i in 0..300 {
        let (p, q) = (random.point() * 2.0, random.point());
        let r = 0.02 + 0.1 * random.next();
        let mut numbers = p.to_array().to_vec();
        surfaces.push(Geometry::Shape(match i % 4 {
            0 => shape("sphere", &[numbers, vec![r]].concat()),
            1 => shape("cylinder", &[numbers, (p + q * 0.3).to_array().to_vec(), vec![r]].concat()),
            2 => shape("ring", &[numbers, q.to_array().to_vec(), vec![r, 0.0]].concat()),
            _ => {
                numbers.extend((p + q * 0.3).to_array());
                numbers.extend((p + random.point() * 0.3).to_array());
                shape("polygon", &numbers)
            }
        }));
    }
    let accel = build(surfaces.clone());
    for _ in 0..20000 {
        let ray = Ray::new(random.point() * 3.0, random.direction());
        let expected = surfaces
            .iter()
            .filter_map(|s| match s {
                Geometry::Shape(s) => s.intersect(&ray, TINY, 1e10),
                Geometry::Mesh(m, _) => by_force(m, &ray, TINY),
                Geometry::Group(..) => None,
            })
            .min_by(f64::total_cmp);
        let found = accel.nearest(&ray, TINY, 1e10).map(|hit| hit.t);
        assert!(found == expected || (found.unwrap() - expected.unwrap()).abs() < 1e-9, "{found:?} {expected:?}");
        assert_eq!(accel.occluded(&ray, TINY, 1e10), expected.is_some());
    }
}

/// What [`Accel::nearest_each`] finds must be what [`Accel::nearest`] does.
fn assert_same_together(accel: &Accel, rays: &[Ray], range: [f64; 2]) -> usize {
    let mut together = Vec::new();
    accel.nearest_each(rays.iter().map(|ray| (ray, range)), |_, hit| together.push(hit));
    let alone: Vec<_> = rays.iter().map(|ray| accel.nearest(ray, range[0], range[1])).collect();
    assert_eq!(format!("{together:?}"), format!("{alone:?}"));
    alone.iter().flatten().count()
}

#[test]
fn rays_beside_one_another_meet_what_each_meets_alone() {
    let mut random = Random(17);
    let one = Arc::new(build(vec![mesh(ball(2, 0.1))]));
    let moved = |p: Vec3| Affine::from_translation(p) * Affine::from_scale(Vec3::splat(0.3));
    let shapes = (0..100).map(|_| {
        let p = random.point();
        Geometry::Shape(shape("sphere", &[p.x, p.y, p.z, 0.05]))
    });
    let mut surfaces: Vec<Geometry> = shapes.collect();
    surfaces.extend([mesh(ball(5, 0.1)), mesh(lattice(20))]);
    surfaces.extend((0..5).map(|_| Geometry::Group(one.clone(), moved(random.point()))));
    let scenes = [build(surfaces), build(vec![mesh(ball(6, 0.02))]), build(vec![mesh(lattice(1))])];
    let mut hits = 0;
    for accel in &scenes {
        for i in 0..2000 {
            // As of a camera outside or inside, near or far, and as of the sun: along any axis, sometimes exactly.
            let (eye, forward) = (random.point() * [0.5, 3.0, 1e5][i % 3], random.direction());
            let target = random.point();
            let forward = if i % 3 == 0 { forward } else { (target - eye).normalize() };
            let forward = if i % 10 == 0 { Vec3::X } else { forward };
            let spread = [1e-9, 1e-5, 1e-3, 0.1, 1.0][i % 5];
            let rays: Vec<Ray> = (0..1 + i % 40)
                .map(|_| {
                    let off = random.point() * spread;
                    let (from, along) = if i % 2 == 0 { (eye, (forward + off).normalize()) } else { (eye + off, forward) };
                    Ray::new(from, along)
                })
                .collect();
            let far = if i % 7 == 0 { eye.length() } else { f64::INFINITY };
            hits += assert_same_together(accel, &rays, [TINY, far]);
        }
    }
    assert!(hits > 20_000, "{hits}");
}

#[test]
fn groups_and_repeated_meshes_hit_as_if_copied() {
    let m = Arc::new(ball(2, 0.2));
    let place = |i: usize| {
        let angle = i as f64;
        let mirror = [1.0, -1.0][i % 2];
        Affine::from_translation(Vec3::new(angle * 2.5, 0.0, 0.0))
            * Affine::from_rotation_y(angle)
            * Affine::from_scale(Vec3::new(mirror, 1.0, 1.0) * (0.5 + 0.1 * angle))
    };
    let copies = (0..6).map(|i| {
        let mut copy = (*m).clone();
        copy.positions.iter_mut().for_each(|p| *p = place(i).transform_point3(*p));
        if i % 2 == 1 {
            copy.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        mesh(copy)
    });
    let copied = build(copies.collect());
    let repeated = build((0..6).map(|i| Geometry::Mesh(m.clone(), place(i))).collect());
    let inner = Arc::new(build(vec![Geometry::Shape(shape("sphere", &[0., 99., 0., 1.])), Geometry::Mesh(m.clone(), Affine::IDENTITY)]));
    let middle = Arc::new(build(vec![Geometry::Group(inner, Affine::from_scale(Vec3::splat(2.0)))]));
    let grouped = build((0..6).map(|i| Geometry::Group(middle.clone(), place(i) * Affine::from_scale(Vec3::splat(0.5)))).collect());
    let mut random = Random(19);
    let mut hits = 0;
    for _ in 0..20000 {
        let origin = Vec3::new(random.next() * 16.0 - 2.0, 5.0, random.next() * 6.0 - 3.0);
        let target = Vec3::new(random.next() * 13.0, 0.0, 0.0) + random.point() * 0.5;
        let ray = Ray::new(origin, (target - origin).normalize());
        let expected = copied.nearest(&ray, TINY, 1e10);
        hits += usize::from(expected.is_some());
        for (accel, path) in [(&repeated, &[][..]), (&grouped, &[0, 1][..])] {
            let found = accel.nearest(&ray, TINY, 1e10);
            assert_eq!(found.is_some(), expected.is_some());
            assert_eq!(accel.occluded(&ray, TINY, 1e10), expected.is_some());
            if let (Some(found), Some(expected)) = (found, expected) {
                assert_eq!((found.surface, found.path.surfaces()), (expected.surface, path));
                // Beside an edge single precision may choose the neighbour.
                let [v, w] = expected.barycentric;
                assert!(found.triangle == expected.triangle || v.min(w).min(1.0 - v - w) < 1e-4);
                assert!((found.t - expected.t).abs() < 1e-12 * 20.0 && (found.point - expected.point).length() < 1e-12);
                assert!((found.normal - expected.normal).length() < 1e-10);
            }
        }
    }
    assert!(hits > 5000);
}

#[test]
fn a_rank_given_to_a_group_stands_for_all_in_it() {
    let square = |z: f64| Geometry::Shape(shape("polygon", &[0., 0., z, 1., 0., z, 1., 1., z, 0., 1., z]));
    let rank = |order| Rank { class: 2, order };
    let inside = |order| Arc::new(Accel::build(vec![Surface { geometry: square(0.0), ranks: vec![rank(order)] }]).unwrap());
    let ray = Ray::new(Vec3::new(0.5, 0.5, 1.0), -Vec3::Z);
    for (own, seen) in [(vec![], 0), (vec![rank(1)], 1)] {
        let group = Surface { geometry: Geometry::Group(inside(9), Affine::IDENTITY), ranks: own };
        let accel = Accel::build(vec![group, Surface { geometry: square(0.0), ranks: vec![rank(5)] }]).unwrap();
        assert_eq!(accel.nearest(&ray, TINY, 1e10).unwrap().surface, seen);
    }
}

#[test]
fn nothing_is_hit_in_an_empty_scene() {
    let accel = build(vec![]);
    let ray = Ray::new(Vec3::ZERO, Vec3::Z);
    assert!(accel.nearest(&ray, 0.0, 1e10).is_none() && !accel.occluded(&ray, 0.0, 1e10) && accel.bounds().is_empty());
    assert!(build(vec![mesh(Mesh::default())]).nearest(&ray, 0.0, 1e10).is_none());
}

#[test]
fn triangles_that_cannot_be_hit_are_left_out_and_harm_no_others() {
    let bad = [[f64::NAN, 0., 0.], [f64::INFINITY, 0., 0.], [1e300, 0., 0.]].map(Vec3::from);
    let mut m = lattice(8);
    let first = m.positions.len() as u32;
    m.positions.extend(bad);
    let sound = m.triangles.len();
    m.triangles.extend([[0, 1, first], [first + 1, 0, 9], [first + 2, 5, 9], [3, 3, 4], [7, 7, 7]]);
    let accel = build(vec![mesh(m)]);
    assert_eq!(accel.tree().details.len(), sound);
    assert!((accel.nearest(&Ray::new(Vec3::splat(0.5), Vec3::Z), TINY, 1e10).unwrap().t - 0.5).abs() < 1e-12);
}

#[test]
fn a_hundred_thousand_coincident_triangles_are_built_and_hit() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let n = 100_000;
    let same = Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]; n], ..Mesh::default() };
    // A quadratic build would take minutes.
    let accel = build(vec![mesh(same)]);
    assert_eq!(accel.nearest(&Ray::new(Vec3::new(0.2, 0.3, 1.0), -Vec3::Z), TINY, 1e10).unwrap().triangle, 0);
}

#[test]
fn the_build_does_not_depend_on_the_number_of_threads() {
    let m = ball(6, 0.2);
    let trees = [1, 2, 5].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let accel = pool.install(|| build(vec![mesh(m.clone())]));
        accel.tree().details.iter().map(|d| d.triangle).collect::<Vec<_>>()
    });
    assert!(trees[0] == trees[1] && trees[0] == trees[2]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_input_makes_it_panic(numbers in proptest::collection::vec(prop_oneof![any::<f64>(), -1.0..1.0f64], 9..300), d in proptest::array::uniform3(any::<f64>())) {
        let positions: Vec<Vec3> = numbers.chunks_exact(3).map(|c| Vec3::new(c[0], c[1], c[2])).collect();
        let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let first = positions[0];
        let accel = build(vec![mesh(Mesh { positions, triangles, ..Mesh::default() })]);
        for ray in [Ray::new(first, d.into()), Ray::new(Vec3::ZERO, Vec3::from(d).normalize_or(Vec3::X))] {
            let hit = accel.nearest(&ray, 0.0, f64::INFINITY);
            prop_assert!(hit.is_none() || !accel.tree().details.is_empty());
            accel.occluded(&ray, -1.0, 1.0);
            assert_same_together(&accel, &[ray; 3], [0.0, f64::INFINITY]);
        }
    }
}
