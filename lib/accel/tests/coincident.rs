//! Surfaces in the same place.

use super::*;

/// What `rtrace -w -h -os` answers for two unit squares at z = 0, a before b in the file, with modifiers of these ranks; "-" marks a square
/// given clockwise seen from above, "~x" one lowered by x. Rays from above, from below and slanting from above.
///
///   void glow first 0 0 4 1 1 1 0      void glass clear 0 0 3 .5 .5 .5      void glow second 0 0 4 2 2 2 0
///   oconv -w c.rad > c.oct; printf ".3 .4 1 0 0 -1\n.3 .4 -1 0 0 1\n.3 .4 1 .2 .1 -1\n" | rtrace -w -h -os c.oct
const COINCIDENT: [(&str, &str, &str); 15] = [
    ("first", "second", "b b b"),
    ("second", "first", "a a a"),
    ("clear", "first", "b b b"),
    ("first", "clear", "a a a"),
    ("clear", "-first", "b b b"),
    ("void", "first", "b b b"),
    ("void", "clear", "b b b"),
    ("clear", "void", "a a a"),
    ("-second", "first", "b a b"),
    ("second", "-first", "a b a"),
    ("first", "-first", "a b a"),
    ("first", "first", "b b b"),
    ("first", "second~5e-7", "b b b"),
    ("first", "second~9e-7", "b b b"),
    ("first", "second~1.1e-6", "a b a"),
];

#[test]
fn of_coincident_surfaces_the_one_radiance_shows_is_first() {
    for as_mesh in [false, true] {
        for (a, b, answers) in COINCIDENT {
            let surface = |word: &str| {
                let (word, lower) = word.split_once('~').unwrap_or((word, "0"));
                let z = -lower.parse::<f64>().unwrap();
                let mut corners = vec![[0., 0., z], [1., 0., z], [1., 1., z], [0., 1., z]];
                if word.starts_with('-') {
                    corners.reverse();
                }
                let rank = match word.trim_start_matches('-') {
                    "first" => Rank { class: 2, order: 1 },
                    "clear" => Rank { class: 1, order: 2 },
                    "second" => Rank { class: 2, order: 3 },
                    _ => Rank { class: 0, order: 0 },
                };
                let geometry = if as_mesh {
                    let positions = corners.into_iter().map(Vec3::from).collect();
                    mesh(Mesh { positions, triangles: vec![[0, 1, 2], [2, 3, 0]], ..Mesh::default() })
                } else {
                    Geometry::Shape(shape("polygon", corners.as_flattened()))
                };
                Surface { geometry, ranks: vec![rank] }
            };
            let accel = Accel::build(vec![surface(a), surface(b)]).unwrap();
            let rays = [([0.3, 0.4, 1.0], [0., 0., -1.]), ([0.3, 0.4, -1.0], [0., 0., 1.]), ([0.3, 0.4, 1.0], [0.2, 0.1, -1.])];
            let seen = rays.map(|(o, d)| accel.nearest(&Ray::new(o.into(), Vec3::from(d).normalize()), TINY, 1e10).unwrap().surface);
            assert_eq!(seen.map(|s| ["a", "b"][s as usize]).join(" "), answers, "{a} {b} {as_mesh}");
        }
    }
}

#[test]
fn coincident_surfaces_tile_without_noise_at_grazing_angles() {
    // The same plane, divided differently: whatever single precision says, the later surface is seen everywhere.
    let slope = |p: Vec3| Vec3::new(p.x, p.y, 0.3 * p.x + 0.1 * p.y);
    let plane = |corners: &[[f64; 2]], triangles: &[[u32; 3]]| Mesh {
        positions: corners.iter().map(|c| slope(Vec3::new(c[0], c[1], 0.0))).collect(),
        triangles: triangles.to_vec(),
        ..Mesh::default()
    };
    let a = plane(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]], &[[0, 1, 2], [0, 2, 3]]);
    let b = plane(&[[-0.1, -0.2], [1.3, -0.4], [1.2, 1.7], [-0.3, 1.1], [0.37, 0.41]], &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]);
    let ranks = |order| vec![Rank { class: 2, order }];
    let accel = Accel::build(vec![Surface { geometry: mesh(b), ranks: ranks(2) }, Surface { geometry: mesh(a), ranks: ranks(1) }]).unwrap();
    let mut random = Random(17);
    for _ in 0..20000 {
        let target = slope(Vec3::new(random.next(), random.next(), 0.0));
        let from = slope(Vec3::new(random.next(), random.next(), 0.0)) + Vec3::Z * (1e-4 + 0.03 * random.next());
        if (target - from).length() > 0.1 {
            let hit = accel.nearest(&Ray::new(from, (target - from).normalize()), TINY, 1e10).unwrap();
            assert_eq!(hit.surface, 0);
        }
    }
}
