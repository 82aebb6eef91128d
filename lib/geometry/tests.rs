use super::*;
use crate::sampling::mix64;
use crate::vector::Vec3;
use std::f64::consts::PI;

fn shape(kind: &str, reals: &[f64]) -> Shape {
    Shape::new(kind, reals, &mut Vec::new()).unwrap().unwrap()
}

fn ray(o: [f64; 3], d: [f64; 3]) -> Ray {
    Ray::new(o.into(), Vec3::from(d).normalize())
}

fn distance(s: &Shape, o: [f64; 3], d: [f64; 3]) -> Option<f64> {
    s.intersect(&ray(o, d), TINY, 1e10)
}

const SQUARE_WITH_HOLE: [f64; 30] = [
    0., 0., 0., 4., 0., 0., 4., 4., 0., 0., 4., 0., 0., 0., 0., // The rim,
    1., 1., 0., 1., 3., 0., 3., 3., 0., 3., 1., 0., 1., 1., 0., // a seam to the hole, and back by closing.
];

#[test]
fn the_tolerance_is_radiances_between_a_thousandth_and_a_thousand_and_scales_beyond() {
    assert_eq!(tolerance(1e-3), 1e-6);
    assert_eq!(tolerance(1e3), 1e-6);
    assert!((tolerance(1e6) - 1e-3).abs() < 1e-15 && (tolerance(1e-6) - 1e-9).abs() < 1e-20);
}

#[test]
fn a_polygon_is_hit_inside_from_both_sides() {
    let p = shape("polygon", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    assert_eq!(distance(&p, [0.25, 0.25, 1.0], [0., 0., -1.]), Some(1.0));
    assert_eq!(distance(&p, [0.25, 0.25, -2.0], [0., 0., 1.]), Some(2.0));
    assert_eq!(distance(&p, [0.75, 0.75, 1.0], [0., 0., -1.]), None);
    assert_eq!(distance(&p, [-1.0, 0.25, 0.0], [1., 0., 0.]), None, "along the plane");
    assert_eq!((p.area(), p.normal_at(Vec3::ZERO)), (0.5, Vec3::Z));
}

#[test]
fn holes_made_by_a_seam_are_open_and_take_area_off() {
    let p = shape("polygon", &SQUARE_WITH_HOLE);
    assert_eq!(p.area(), 12.0);
    for x in 0..8 {
        for y in 0..8 {
            let (x, y) = (x as f64 * 0.5 + 0.25, y as f64 * 0.5 + 0.25);
            let hole = (1.0..3.0).contains(&x) && (1.0..3.0).contains(&y);
            assert_eq!(distance(&p, [x, y, 1.], [0., 0., -1.]).is_none(), hole, "{x} {y}");
        }
    }
}

#[test]
fn hits_of_an_uneven_polygon_are_on_its_mean_plane() {
    let mut warnings = Vec::new();
    let p = Shape::new("polygon", &[0., 0., 0., 1., 0., 0.1, 1., 1., 0., 0., 1., 0.1], &mut warnings).unwrap().unwrap();
    assert!(warnings[0].contains("not planar"));
    let t = distance(&p, [0.5, 0.5, 1.0], [0., 0., -1.]).unwrap();
    assert!((t - 0.95).abs() < 1e-12, "the mean of the corners' heights is .05");
    assert!(p.bounds().contains(Vec3::new(0.5, 0.5, 0.05)));
}

#[test]
fn an_edge_belongs_to_the_polygon_with_a_millionth_more() {
    let p = shape("polygon", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
    for (x, hit) in [(0.0, true), (-0.9e-6, true), (-1.1e-6, false), (1.0, true), (1.0 + 0.9e-6, true), (1.0 + 1.1e-6, false)] {
        assert_eq!(distance(&p, [x, 0.5, 1.], [0., 0., -1.]).is_some(), hit, "{x}");
        assert_eq!(distance(&p, [0.5, x, 1.], [0., 0., -1.]).is_some(), hit, "{x}");
    }
}

#[test]
fn degenerate_surfaces_are_ignored_with_a_reason_and_malformed_ones_refused() {
    let ignored = |kind: &str, reals: &[f64]| {
        let mut warnings = Vec::new();
        Shape::new(kind, reals, &mut warnings).unwrap().is_none() && warnings.len() == 1
    };
    assert!(ignored("polygon", &[0., 0., 0., 1., 1., 1., 2., 2., 2.]));
    assert!(ignored("sphere", &[0., 0., 0., 0.]));
    assert!(ignored("cone", &[0., 0., 0., 0., 0., 1., 1., -1.]) && ignored("cone", &[0., 0., 0., 0., 0., 1., 0., 0.]));
    assert!(ignored("cylinder", &[0., 0., 1., 0., 0., 1., 1.]));
    assert!(ignored("ring", &[0., 0., 0., 0., 0., 1., 1., 1.]));
    let refused = |kind: &str, reals: &[f64]| Shape::new(kind, reals, &mut Vec::new()).is_err();
    assert!(refused("polygon", &[0.; 6]) && refused("polygon", &[0.; 10]) && refused("sphere", &[0.; 3]));
    assert!(refused("sphere", &[0., 0., f64::NAN, 1.]) && refused("plastic", &[0.; 5]));
}

#[test]
fn a_primitive_is_read_with_places_for_its_warnings_and_errors() {
    let source = crate::error::Source::new("a.rad", "void sphere ball\n0\n0\n4 0 0 0 -1\nvoid ring disk\n0\n0\n3 1 2 3\n");
    let document = crate::rad::Document::parse(source).unwrap();
    let primitives: Vec<_> = document.primitives().collect();
    let mut warnings = Vec::new();
    assert!(matches!(Shape::read(primitives[0], &mut warnings), Ok(Some(Shape::Sphere(Sphere { inward: true, .. })))));
    assert!(warnings[0].to_string().starts_with("a.rad:1:6: "));
    assert!(Shape::of(primitives[1]).unwrap_err().to_string().starts_with("a.rad:5:6: error: ring needs 8 real arguments, not 3"));
}

#[test]
fn negative_radii_turn_surfaces_inside_out() {
    for (kind, reals, twin) in [
        ("sphere", vec![0., 0., 0., -1.], "bubble"),
        ("cylinder", vec![0., 0., 0., 0., 0., 1., -1.], "tube"),
        ("cone", vec![0., 0., 0., 0., 0., 1., -1., -2.], "cup"),
    ] {
        let mut warnings = Vec::new();
        let turned = Shape::new(kind, &reals, &mut warnings).unwrap().unwrap();
        assert_eq!(warnings.len(), 1);
        let positive: Vec<f64> = reals.iter().map(|r| r.abs()).collect();
        let point = Vec3::new(1.0, 0.0, 0.0);
        assert_eq!(turned.normal_at(point), shape(twin, &positive).normal_at(point));
        assert!(turned.normal_at(point).x < 0.0);
    }
}

#[test]
fn a_sphere_far_away_and_a_point_on_it_lose_no_digits() {
    let s = shape("sphere", &[0., 0., 0., 1.]);
    let t = distance(&s, [1e6, 0.6, 0.0], [-1., 0., 0.]).unwrap();
    assert!((t - (1e6 - 0.8)).abs() < 1e-9);
    // From the surface inward: the far side, not the start.
    let t = distance(&s, [0.6, 0.0, 0.8], [-0.6, 0.0, -0.8]).unwrap();
    assert!((t - 2.0).abs() < 1e-12);
    assert_eq!(distance(&s, [0.6, 0.0, 0.8], [0.6, 0.0, 0.8]), None);
}

#[test]
fn cones_are_open_and_end_at_their_ends() {
    let c = shape("cone", &[0., 0., 0., 0., 0., 2., 1., 0.]);
    assert_eq!(distance(&c, [0., 0., -1.], [0., 0., 1.]), Some(3.0), "through the open base to the tip");
    let t = distance(&c, [5., 0., 1.], [-1., 0., 0.]).unwrap();
    assert!((t - 4.5).abs() < 1e-12);
    assert_eq!(distance(&c, [5., 0., 2.1], [-1., 0., 0.]), None);
    assert_eq!(distance(&c, [5., 0., -0.1], [-1., 0., 0.]), None);
    let n = c.normal_at(Vec3::new(0.5, 0., 1.));
    assert!((n - Vec3::new(2., 0., 1.).normalize()).length() < 1e-12);
    let tube = shape("tube", &[0., 0., 0., 0., 0., 2., 1.]);
    assert_eq!(distance(&tube, [0., 0., 1.], [1., 0., 0.]), Some(1.0));
    assert_eq!(tube.normal_at(Vec3::new(1., 0., 1.)), Vec3::NEG_X);
}

#[test]
fn a_ring_has_a_hole_and_its_radii_come_in_any_order() {
    for radii in [[1., 2.], [2., 1.]] {
        let r = shape("ring", &[0., 0., 0., 0., 0., 5., radii[0], radii[1]]);
        assert_eq!(distance(&r, [0.9, 0., 1.], [0., 0., -1.]), None);
        assert_eq!(distance(&r, [1.5, 0., 1.], [0., 0., -1.]), Some(1.0));
        assert_eq!(distance(&r, [2.1, 0., 1.], [0., 0., -1.]), None);
        assert_eq!(r.normal_at(Vec3::X), Vec3::Z);
    }
}

/// Surfaces of every kind, with a slanted or concave one where the kind has such.
fn samples() -> Vec<Shape> {
    vec![
        shape("polygon", &[0., 0., 0., 1., 0., 1., 0., 1., 0.]),
        shape("polygon", &[0., 0., 0., 2., 0., 1., 2., 1., 1., 0., 1., 0.]),
        shape("polygon", &[0., 0., 0., 4., 0., 1., 4., 4., 1., 2., 1., 0.5, 0., 4., 0.]),
        shape("polygon", &SQUARE_WITH_HOLE),
        shape("sphere", &[1., 2., 3., 2.]),
        shape("cone", &[0., 0., 0., 1., 1., 1., 1., 3.]),
        shape("cylinder", &[0., 0., 0., 1., 0., 1., 0.5]),
        shape("ring", &[0., 0., 0., 1., 1., 0., 1., 2.]),
    ]
}

#[test]
fn samples_are_on_the_surface_and_uniform_in_area() {
    const N: usize = 200;
    for s in samples() {
        let sampler = AreaSampler::new(&s);
        assert!((sampler.area() - s.area()).abs() < 1e-12 * s.area());
        let points: Vec<Vec3> =
            (0..N * N).map(|i| sampler.sample([(i % N) as f64 + 0.5, (i / N) as f64 + 0.5].map(|u| u / N as f64))).collect();
        for &p in points.iter().step_by(17) {
            let n = s.normal_at(p);
            let t = s.intersect(&Ray::new(p + n * 0.1, -n), 0.0, 1.0).unwrap();
            assert!((t - 0.1).abs() < 1e-9, "{s:?}");
        }
        // The mean of a linear function over a uniform grid equals the surface's: compare two halves split by a plane through the mean
        // with what rays find from a dense grid of directions.
        let bounds = s.bounds();
        assert!(points.iter().all(|&p| bounds.grow(1e-9).contains(p)));
        for axis in 0..3 {
            let rows = projected(&s, axis);
            if rows.1 < 1e-3 {
                continue;
            }
            // Each sample stands for area/N² of surface, which projects to |n·axis| of that.
            let each = s.area() / (N * N) as f64;
            let seen: f64 = points.iter().map(|&p| s.normal_at(p)[axis].abs() * each).sum();
            let moment: f64 =
                points.iter().map(|&p| s.normal_at(p)[axis].abs() * each * (p[(axis + 1) % 3] - bounds.min[(axis + 1) % 3])).sum();
            assert!((seen / rows.1 - 1.0).abs() < 0.02, "{s:?} {axis}: {seen} {}", rows.1);
            assert!((moment / rows.0 - 1.0).abs() < 0.02, "{s:?} {axis}: {moment} {}", rows.0);
        }
    }
}

#[test]
fn where_an_outline_crosses_itself_its_loops_are_sampled() {
    // An outline that goes to and fro by chance would be millions of trapezoids.
    let chance = |i: u64| (mix64(i) >> 40) as f64 / (1 << 24) as f64 - 0.5;
    let tangle: Vec<f64> = (0..2000).flat_map(|i| [chance(2 * i), chance(2 * i + 1), 0.0]).collect();
    assert!(shape("polygon", &tangle).light().is_err_and(|e| e.contains("divide it")));
    // An hourglass: a triangle of 2 by 2 on one of 10 by 10.
    let hourglass = shape("polygon", &[1., 2., 0., -1., 2., 0., 5., -10., 0., -5., -10., 0.]);
    let sampler = AreaSampler::new(&hourglass);
    assert!((sampler.area() - 52.0).abs() < 1e-9, "{}", sampler.area());
    let points = (0..400).map(|i| sampler.sample([i % 20, i / 20].map(|k| (k as f64 + 0.5) / 20.0)));
    assert!(points.into_iter().all(|p| hourglass.intersect(&Ray::new(p + Vec3::Z, -Vec3::Z), 0.0, 2.0).is_some()));
    // A star of five points, whose middle is outside by the even-odd rule: the area of its points alone.
    let star: Vec<f64> = (0..5).flat_map(|k| [(0.8 * PI * k as f64).sin(), (0.8 * PI * k as f64).cos(), 0.0]).collect();
    let points = AreaSampler::new(&shape("polygon", &star)).area();
    // Ten triangles between the centre, a point, and an inner corner, without the five of the pentagon inside.
    let inner = f64::cos(0.4 * PI) / f64::cos(0.2 * PI);
    let expected = 5.0 * inner * f64::sin(0.2 * PI) - 2.5 * inner * inner * f64::sin(0.4 * PI);
    assert!((points - expected).abs() < 1e-12, "{points} {expected}");
}

/// By brute force with rays along an axis: the first moment across the next axis, and the area, of all that is hit, projected.
fn projected(s: &Shape, axis: usize) -> (f64, f64) {
    const N: usize = 400;
    let b = s.bounds();
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (du, dv) = ((b.max[u] - b.min[u]) / N as f64, (b.max[v] - b.min[v]) / N as f64);
    let (mut moment, mut area) = (0.0, 0.0);
    for i in 0..N * N {
        let mut origin = Vec3::ZERO;
        origin[axis] = b.min[axis] - 1.0;
        origin[u] = b.min[u] + ((i % N) as f64 + 0.5) * du;
        origin[v] = b.min[v] + ((i / N) as f64 + 0.5) * dv;
        let mut direction = Vec3::ZERO;
        direction[axis] = 1.0;
        let r = Ray::new(origin, direction);
        let mut t = 0.0;
        while let Some(next) = s.intersect(&r, t, 1e10) {
            t = next;
            area += du * dv;
            moment += du * dv * (origin[u] - b.min[u]);
        }
    }
    (moment, area)
}

#[test]
fn lights_are_sampled_where_radiance_samples_them() {
    let square = shape("polygon", &[0., 0., 2., 2., 0., 2., 2., 4., 2., 0., 4., 2.]).light().unwrap();
    assert_eq!((square.center, square.size), (Vec3::new(1., 2., 2.), 8.0));
    assert_eq!(square.half_edges, [Vec3::X, Vec3::Y * 2.0, Vec3::ZERO]);
    let sphere = shape("sphere", &[0., 0., 0., 2.]).light().unwrap();
    assert!((sphere.size - 4.0 * std::f64::consts::PI).abs() < 1e-12);
    let cylinder = shape("cylinder", &[0., 0., 0., 0., 0., 4., 0.5]).light().unwrap();
    assert_eq!((cylinder.center, cylinder.size), (Vec3::Z * 2.0, 4.0));
    // A horseshoe does not contain its vertex average; a ring may have no hole; cones and bubbles are illegal.
    assert!(
        shape("polygon", &[0., 0., 0., 3., 0., 0., 3., 3., 0., 2., 3., 0., 2., 0.1, 0., 1., 0.1, 0., 1., 3., 0., 0., 3., 0.])
            .light()
            .is_err()
    );
    assert!(shape("ring", &[0., 0., 0., 0., 0., 1., 1., 2.]).light().is_err());
    assert!(shape("cone", &[0., 0., 0., 0., 0., 1., 1., 2.]).light().is_err());
    assert!(shape("bubble", &[0., 0., 0., 1.]).light().is_err());
}
