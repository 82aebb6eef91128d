#[path = "../../tests/skipped/mod.rs"]
mod skipped;

use super::*;
use crate::cal::{FileId, Library};
use crate::error::Source;
use crate::rad::Document;
use crate::resolve::{Files, Resolve};
use crate::transform::Transform;
use skipped::skipped;

fn primitive(text: &str) -> Primitive {
    Document::parse(Source::new("p.rad", text)).unwrap().primitives().next().unwrap().clone()
}

/// 3 × 2 pixels; a value m stands for (m + ½)/128.
fn picture() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 3\n".to_vec();
    for [r, g, b] in [[10, 20, 30], [40, 50, 60], [70, 80, 90], [15, 25, 35], [200, 100, 50], [5, 6, 7]] {
        bytes.extend([r, g, b, 129]);
    }
    bytes
}

fn files() -> Files {
    Files::of([
        ("a.hdr", picture().as_slice()),
        ("f.cal", b"two(a,b)=a+10*b; one(a)=100*a; three(a,b,c)=a+10*b+100*c;"),
        ("d1.dat", b"1\n0 4 3\n10 20 40\n"),
        ("d3.dat", b"1\n0 4 3\n.1 .3 .2\n"),
        ("d2.dat", b"2\n0 2 3\n0 0 4\n1 2 4 8\n1 2 3 4\n5 6 7 9\n11 10 13 17\n"),
        ("xyz.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\x80\x80\x80\x80"),
    ])
}

/// The ray `1 2 3 .6 0 .8` that meets a source of 360°.
fn at() -> At<'static> {
    At::distant(Vec3::new(0.6, 0.0, 0.8), Vec3::new(1.0, 2.0, 3.0))
}

fn color(text: &str) -> Vec3 {
    let files = files();
    let pattern = Pattern::compile(&primitive(text), &mut Sources::new(&files)).unwrap_or_else(|e| panic!("{text}: {e}"));
    pattern.unwrap().evaluate(&at()).unwrap_or(Vec3::NAN)
}

fn near(found: Vec3, expected: [f64; 3], what: &str) {
    for k in 0..3 {
        assert!((found[k] - expected[k]).abs() <= 2e-6 * expected[k].abs().max(1e-3), "{what}: {found}, not {expected:?}");
    }
}

// Where nothing else is said, numbers are those of `echo 1 2 3 .6 0 .8 | rtrace -h -faa` (Radiance 6.0a) toward a glow source of 360°
// with the pattern.

#[test]
fn ray_variables_in_a_moved_frame() {
    for (expression, expected) in [
        ("Ix", 1.0),
        ("Jx", 0.0),
        ("Jy", 8.660254e-1),
        ("Jz", -0.5),
        ("Ky", 0.5),
        ("Kz", 8.660254e-1),
        ("Dx", 0.6),
        ("Dy", 0.4),
        ("Dz", 6.928203e-1),
        ("Px", 0.0),
        ("Py", 6.160254e-1),
        ("Pz", -7.009619e-1),
        ("S", 0.5),
        ("Tx", -0.5),
        ("Ty", -1.0),
        ("Tz", -1.5),
        ("Ny", -0.4),
        ("T", 5e9),
        ("Ts", 5e9),
        ("Rdot", 1.0),
    ] {
        let found = color(&format!("void brightfunc p 10 {expression} . -s 2 -t 1 2 3 -rx 30 0 0"));
        near(found, [expected; 3], expression);
    }
    for (expression, expected) in [("Jy", 8.660254e-1), ("Kx", -3.420202e-1), ("Dx", 2.901995e-1), ("Px", -8.636781e-2)] {
        near(color(&format!("void brightfunc p 6 {expression} . -rx 30 -ry 20 0 0")), [expected; 3], expression);
    }
    for (expression, expected) in [("tilt_ang", 35.53135), ("tilt_xang", 60.0), ("tilt_ang2", 35.53135)] {
        near(color(&format!("void brightfunc p 6 {expression} tilt.cal -rx 30 -ry 20 0 0")), [expected; 3], expression);
    }
}

#[test]
fn functions_of_a_picture_take_all_channels_or_their_own() {
    let expected: [(&str, [f64; 3]); 5] = [
        ("three three three", [34.17916; 3]),
        ("one one one", [39.79167, 31.56250, 30.62500]),
        ("sqrt sqrt sqrt", [6.308064e-1, 5.618051e-1, 5.533986e-1]),
        ("two one grey", [3.554167, 31.56250, 3.368308e-1]),
        ("min max min", [3.062500e-1, 3.156250e-1, 3.062500e-1]),
    ];
    for (functions, expected) in expected {
        near(color(&format!("void colorpict p 7 {functions} a.hdr f.cal .2 .3 0 0")), expected, functions);
    }
    near(color("void colorpict p 7 noop noop noop a.hdr . .5 1.9 0 0"), [-5.234375e-1, 7.031250e-2, 4.296875e-1], "noop");
    near(color("void colorpict p 7 red green blue a.hdr . .5 1.9 0 0"), [0.0, 7.031250e-2, 4.296875e-1], "red");
}

#[test]
fn functions_that_change_nothing_are_not_evaluated() {
    let files = files();
    let mut sources = Sources::new(&files);
    let mut apply = |functions: &str| {
        let text = format!("void colorpict p 7 {functions} a.hdr f.cal .2 .3 0 0");
        match Pattern::compile(&primitive(&text), &mut sources).unwrap().unwrap().0.kind {
            Kind::Picture(_, Mapping::Constant(_), apply) => apply,
            kind => panic!("{kind:?}"),
        }
    };
    assert!(matches!(apply("noop noop noop"), Apply::Keep));
    assert!(matches!(apply("red green blue"), Apply::AtLeastZero));
    assert!(matches!(apply("noneg noneg noneg"), Apply::AtLeastZero));
    assert!(matches!(apply("red blue green"), Apply::Three(_)));
    assert!(matches!(apply("one one one"), Apply::Three(_)));
}

#[test]
fn data_files() {
    near(color("void brightdata p 4 noop d1.dat . 3.5 0 0"), [35.0; 3], "brightdata");
    near(color("void brightdata p 5 one d2.dat f.cal Dx-.1 Px+.5 0 0"), [350.0; 3], "brightdata");
    near(color("void brightdata p 5 noop d1.dat . 1 2 0 0"), [15.0; 3], "words that mean nothing");
    near(color("void colordata p 9 noop three one d2.dat d2.dat d2.dat f.cal .5 1.5 0 0"), [3.5, 388.5, 350.0], "colordata");
}

#[test]
fn constants_are_known() {
    let files = files();
    let mut sources = Sources::new(&files);
    let mut constant = |text: &str| match Pattern::compile(&primitive(text), &mut sources).unwrap().unwrap().0.kind {
        Kind::Constant(values) => Some(values),
        _ => None,
    };
    assert_eq!(constant("void brightfunc p 2 A1*PI/PI . 0 1 .25"), Some(Vec3::splat(0.25)));
    assert_eq!(constant("void colorfunc p 4 1 2 if(-1,Px,3) . 0 0"), Some(Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(constant("void colorfunc p 4 1 2 Px . 0 0"), None);
}

#[test]
fn what_has_no_value_changes_nothing() {
    let files = files();
    let mut sources = Sources::new(&files);
    let pattern = Pattern::compile(&primitive("void colorfunc p 4 .5 .5 1/(Dx-.6) . 0 0"), &mut sources).unwrap().unwrap();
    assert_eq!(pattern.expressions().failure(), None);
    assert_eq!((pattern.color(&at()), pattern.evaluate(&at())), (Vec3::ONE, Err(Failed)));
    assert!(pattern.expressions().failure().is_some_and(|said| said.contains("`p` has no value for some rays")));
    let texture = Texture::compile(&primitive("void texfunc p 4 .5 .5 1/(Dx-.6) . 0 0"), &mut sources).unwrap().unwrap();
    assert_eq!(texture.perturbation(&at()), Vec3::ZERO);
}

/// `echo 1 2 3 0 0 -1 | rtrace -h -on -faa` (Radiance 6.0a) toward a plastic ring at z = 0 that faces up, with the texture.
#[test]
fn textures_turn_but_do_not_scale() {
    let files = files();
    let mut sources = Sources::new(&files);
    let down = -Vec3::Z;
    let at = At { t: 3.0, ts: 3.0, ..At::surface(down, Vec3::Z, Vec3::new(1.0, 2.0, 0.0)) };
    let mut normal = |text: &str, at: &At| {
        let texture = Texture::compile(&primitive(text), &mut sources).unwrap().unwrap();
        (at.normal + texture.perturbation(at)).normalize()
    };
    let expected: [(&str, [f64; 3]); 9] = [
        ("texfunc p 4 .1 .2 0 .", [9.759001e-2, 1.951800e-1, 9.759001e-1]),
        ("texfunc p 6 .1 .2 0 . -s 2", [9.759001e-2, 1.951800e-1, 9.759001e-1]),
        ("texfunc p 8 .1 .2 0 . -s 2 -rz 90", [-1.951800e-1, 9.759001e-2, 9.759001e-1]),
        ("texfunc p 12 .1*Px .2*Py 0 . -s 2 -rz 90 -t 1 0 0", [0.0, 9.950372e-2, 9.950372e-1]),
        ("texfunc p 7 .1 .2 .3 . -mx -s 2", [-7.580980e-2, 1.516196e-1, 9.855275e-1]),
        ("texfunc p 6 Nx+.1 Ny Nz . -rx 30", [4.993762e-2, 0.0, 9.987523e-1]),
        ("texfunc p 6 S Ts/10 Rdot/5 . -s 2", [3.820804e-1, 1.146241e-1, 9.169929e-1]),
        ("texdata p 8 three three three d1.dat d1.dat d1.dat f.cal Px/1000", [5.771770e-1, 5.771770e-1, 5.776967e-1]),
        // Each of its functions is given all three, however many it has parameters for.
        ("texdata p 8 three two one d3.dat d1.dat d3.dat f.cal Px/2000", [7.379030e-1, 6.708666e-1, 7.373667e-2]),
    ];
    for (text, expected) in expected {
        near(normal(&format!("void {text} 0 0"), &at), expected, text);
    }
    // From below, before the normal is flipped; the recorded one is flipped after.
    let below = At::surface(Vec3::Z, Vec3::Z, Vec3::new(1.0, 2.0, 0.0));
    near(-normal("void texfunc p 4 Nz/10 Rdot/10 0 . 0 0", &below), [-9.901475e-2, 9.901475e-2, -9.901475e-1], "below");
}

/// `echo 1 2 3 0 0 -1 | rtrace -h -faa` (Radiance 6.0a) toward a ring of a mixture of the glows 1 2 3 and 10 20 30.
#[test]
fn coefficients_of_mixtures() {
    let files = files();
    let mut sources = Sources::new(&files);
    let at = At::surface(-Vec3::Z, Vec3::Z, Vec3::new(1.0, 2.0, 0.0));
    let mut red = |text: &str| {
        let mixture = Mixture::compile(&primitive(text), &mut sources).unwrap().unwrap();
        mixture.coefficient(&at).map(|c| 1.0 * c + 10.0 * (1.0 - c))
    };
    for (text, expected) in [
        ("mixfunc M 4 A B .3 .", 7.3),
        ("mixfunc M 4 A B 2 .", 1.0),
        ("mixfunc M 4 A B -1 .", 10.0),
        ("mixpict M 7 A B grey a.hdr . .2 .3", 6.968523),
        ("mixpict M 7 A B noop a.hdr f.cal .2 .3", 6.418750),
        ("mixdata M 6 A B noop d1.dat . -.96", 1.0),
    ] {
        let found = red(&format!("void {text} 0 0")).unwrap();
        assert!((found - expected).abs() < 1e-5, "{text}: {found}");
    }
    assert_eq!(red("void mixfunc M 4 A B 1/(Px-1) . 0 0"), Err(Failed));
}

#[test]
fn an_instance_moves_what_is_in_it() {
    let files = files();
    let mut sources = Sources::new(&files);
    let (outer, _) = Transform::parse(&["-rz", "40", "-s", "3", "-t", "1", "2", "3"]).unwrap();
    let alone = primitive("void colorfunc p 12 Px+S*Dx Py*Nz Tz+Kz*Jx . -rx 30 -s 2 -t 1 0 0 0 0");
    let whole = primitive("void colorfunc p 20 Px+S*Dx Py*Nz Tz+Kz*Jx . -rx 30 -s 2 -t 1 0 0 -rz 40 -s 3 -t 1 2 3 0 0");
    let [alone, whole] = [alone, whole].map(|p| Pattern::compile(&p, &mut sources).unwrap().unwrap());
    let at = At::surface(Vec3::new(0.6, 0.48, -0.64), Vec3::new(0.36, 0.48, 0.8), Vec3::new(3.0, 5.0, 7.0));
    let difference = alone.color(&At { instance: Some(&outer), ..at }) - whole.color(&at);
    assert!(difference.length() < 1e-12);
    let textures = ["10 Px*Dx Py Nz . -rx 30 -t 1 0 0", "18 Px*Dx Py Nz . -rx 30 -t 1 0 0 -rz 40 -s 3 -t 1 2 3"];
    let [alone, whole] =
        textures.map(|words| Texture::compile(&primitive(&format!("void texfunc t {words} 0 0")), &mut sources).unwrap().unwrap());
    let difference = alone.perturbation(&At { instance: Some(&outer), ..at }) - whole.perturbation(&at);
    assert!(difference.length() < 1e-12);
}

#[test]
fn errors_point_at_the_word() {
    let files = files();
    let mut sources = Sources::new(&files);
    for (text, expected) in [
        ("void brightfunc p 2 noise3(Px,mx,Py) . 0 0", "mx"),
        ("void brightfunc p 1 2 0 0", "p.rad:1:6: error: brightfunc needs more than 1 string arguments: expression, function file"),
        ("void brightfunc p 2 Px*zz . 0 0", "p.rad:1:24: error: undefined variable 'zz'"),
        ("void brightfunc p 2 \"Px * zz\" . 0 0", "undefined variable 'zz'"),
        ("void brightfunc p 2 1 none.cal 0 0", "p.rad:1:23: error: none.cal: no such file"),
        ("void brightfunc p 2 A2 . 0 1 5", "real argument 2 is missing; there are 1"),
        ("void brightfunc p 2 1/0 . 0 0", "p.rad:1:21: error: this has no value"),
        ("void brightfunc p 5 Px . -t 1 0 0 0", "p.rad:1:26: error: `-t` needs three numbers"),
        ("void brightfunc p 5 Px . -rx 1 z 0 0", "p.rad:1:32: error: `z` is no part of a transform"),
        ("void colorpict p 7 noop noop nope a.hdr . 0 0 0 0", "p.rad:1:30: error: undefined function 'nope'"),
        ("void colorpict p 7 two two two a.hdr f.cal 0 0 0 0", "too few arguments"),
        ("void colorpict p 7 noop noop noop none.hdr . 0 0 0 0", "p.rad:1:35: error: none.hdr: no such file"),
        ("void colorpict p 7 noop noop noop xyz.hdr . 0 0 0 0", "p.rad:1:35: error: xyz.hdr: a pattern cannot use a picture in XYZ"),
        ("void brightdata p 4 noop d2.dat . 1 0 0", "brightdata needs more than 4 string arguments"),
    ] {
        let error = Pattern::compile(&primitive(text), &mut sources).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    assert!(Pattern::compile(&primitive("void plastic p 0 0 5 1 1 1 0 0"), &mut sources).unwrap().is_none());
}

/// The mapping of two expressions, recognized, and their program.
fn mapping(u: &str, v: &str) -> (Mapping, Program) {
    let mut library = Library::new();
    let mut compile = || library.compile(FileId::GLOBAL, &[(u, None), (v, None)], &[]).unwrap();
    (Mapping::recognize(compile()), compile())
}

/// Standard mappings as people write them, and look-alikes that are none.
const MAPPINGS: [(&str, &str, &str); 19] = [
    ("1+Atan2(Dx,Dz)/PI", "1-Acos(Dy)/PI", "latlong"),
    ("1+atan2(Dx,Dz)/PI", "1-acos(Dy)/PI", "latlong"),
    ("1 + atan2(Dx,Dy)/PI", ".5 + asin(Dz)/PI", "latlong"),
    ("1+Atan2(Dy,Dx)/PI", "1-if(Dz-1,0,if(-1-Dz,PI,acos(Dz)))/PI", "latlong"),
    ("1-Atan2(Dy,-Dx)/PI", "Acos(-Dz)/PI", "latlong"),
    ("1+atan2(-Dy,-Dx)/PI", "Acos(-Dz)/PI", "latlong"),
    ("(PI-atan2(Dy,-Dx))/PI", "Acos(-Dz)/PI", "latlong"),
    ("2*(.5+atan2(-Dx,-Dz)/(2*PI))", "(PI-acos(Dy))/PI", "latlong"),
    ("Atan2(Dz,Dy)/DEGREE", "Asin(Dx)/DEGREE", "latlong"),
    ("1+atan2(Dx,Dy)/PI", ".5+atan2(Dz,sqrt(Dx*Dx+Dy*Dy))/PI", "latlong"),
    (
        ".5+Dx*if(sq(Dx)+sq(Dy),acos(Dz)/(2*PI*sqrt(sq(Dx)+sq(Dy))),0)",
        ".5+Dy*if(sq(Dx)+sq(Dy),acos(Dz)/(2*PI*sqrt(sq(Dx)+sq(Dy))),0)",
        "angular",
    ),
    (
        "0.5+Dx*if(sqrt(Dx^2+Dz^2),0.159154943*acos(-Dy)/sqrt(Dx^2+Dz^2),0)",
        "0.5-Dz*if(sqrt(Dx^2+Dz^2),0.159154943*acos(-Dy)/sqrt(Dx^2+Dz^2),0)",
        "angular",
    ),
    (".25", "PI/4", "constant"),
    ("mod(1.5+Atan2(Dx,Dz)/PI,2)", "1-Acos(Dy)/PI", "program"),
    ("1+Atan2(Dx,Dz)/PI", "1-Acos(Dy)/3.14159265", "latlong"),
    ("1+Atan2(Dx,Dz)/PI", "1-Acos(Dx)/PI", "program"),
    ("1+Atan2(Dx,Dz)/PI+1e-11*Dx", "1-Acos(Dy)/PI", "program"),
    ("1+Atan2(Px,Pz)/PI", "1-Acos(Dy)/PI", "program"),
    ("Lu", "Lv", "program"),
];

#[test]
fn standard_mappings_are_recognized() {
    for (u, v, expected) in MAPPINGS {
        let found = match mapping(u, v).0 {
            Mapping::LatLong(_) => "latlong",
            Mapping::Angular(_) => "angular",
            Mapping::Constant(_) => "constant",
            Mapping::Program(_) => "program",
        };
        assert_eq!(found, expected, "{u} {v}");
    }
}

#[test]
fn a_recognized_mapping_gives_what_its_expressions_give() {
    for (u, v, _) in MAPPINGS {
        let (mapping, program) = mapping(u, v);
        let check = |d: Vec3| {
            let ray = Ray::new(d, -d, d);
            // A direction may be longer than 1 by rounding; there `acos` has no value, and the recognized mapping goes on.
            let Ok([x, y]) = program.eval_all::<2>(&ray.context()) else { return };
            let found = mapping.place(d, || ray).unwrap();
            assert!((found[0] - x).abs() <= 1e-12 && (found[1] - y).abs() <= 1e-12, "{u} {v} at {d}: {found:?}, not {x} {y}");
        };
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        for _ in 0..20_000 {
            check(Vec3::new(random(), random(), random()).normalize());
        }
        // Poles and seams, and their surroundings, other than those that recognition tries.
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                for a in [0.0, -0.0, 3e-7, -3e-7, 0.02, -0.7] {
                    for b in [0.0, -0.0, 5e-11, -5e-11, 0.3, -1.9] {
                        let mut d = [a, a, a];
                        d[axis] = sign;
                        d[(axis + 1) % 3] = b;
                        check(Vec3::from_array(d).normalize());
                    }
                }
            }
        }
    }
}

#[test]
fn an_environment_is_looked_up_by_direction() {
    let files = files();
    let mut sources = Sources::new(&files);
    let text = "void colorpict env 9 red green blue a.hdr . 1.5*(1+Atan2(Dx,Dz)/PI)/2 1-Acos(Dy)/PI -rz 90 0 0";
    let pattern = Pattern::compile(&primitive(text), &mut sources).unwrap().unwrap();
    assert!(matches!(pattern.0.kind, Kind::Picture(_, Mapping::LatLong(_), _)));
    // World -x is +y there, so this looks up, a little toward z: the middle column, not quite at the top.
    let found = pattern.color(&At::distant(Vec3::new(-0.8, 0.0, 0.6), Vec3::ZERO));
    let v = 1.0 - 0.8f64.acos() / std::f64::consts::PI;
    near(found, [[200.5, 40.5], [100.5, 50.5], [50.5, 60.5]].map(|[low, high]| (low + v * (high - low)) / 128.0), "near the top");
}

/// A brightfunc with the arguments 2 .3 .4 .5 on a glow ring at the origin with normal 0 .6 .8, `echo .1 .2 .7 0 0 -1 | rtrace -h -faa`
/// (Radiance 6.0a): it is met at z = -.15.
#[test]
fn luminaires_seen_from_near() {
    let files = files();
    let mut sources = Sources::new(&files);
    let at = At::surface(-Vec3::Z, Vec3::new(0.0, 0.6, 0.8), Vec3::new(0.1, 0.2, -0.15));
    let at = At { t: 0.85, ts: 0.85, ..at };
    for (words, expected) in [
        ("2 source_corr(7,1) .", 17.5),
        ("2 source_corr(7,2) .", 116.6667),
        ("2 source_corr(7,3) .", 220.3704),
        ("2 source_corr(7,4) .", 198.0595),
        ("4 source_corr(7,3) . -s 2", 495.8333),
        ("2 lboxcorr(7) source.cal", 220.3704),
    ] {
        let text = format!("void brightfunc p {words} 0 4 2 .3 .4 .5");
        let found = Pattern::compile(&primitive(&text), &mut sources).unwrap().unwrap().color(&at);
        near(found, [expected; 3], words);
    }
}

proptest::proptest! {
    #[test]
    fn no_words_panic(
        kind in 0..TYPES.len(),
        words in proptest::collection::vec(proptest::sample::select(WORDS), 0..12),
        reals in proptest::collection::vec(-3.0..3.0f64, 0..4),
    ) {
        let files = files();
        let mut sources = Sources::new(&files);
        let mut primitive = primitive("void brightfunc p 0 0 0");
        primitive.kind = TYPES[kind].to_string();
        primitive.strings = words.iter().map(|word| word.to_string()).collect();
        primitive.reals = reals;
        let _ = Pattern::compile(&primitive, &mut sources).map(|p| p.map(|p| p.color(&at())));
        let _ = Texture::compile(&primitive, &mut sources).map(|t| t.map(|t| t.perturbation(&at())));
        let _ = Mixture::compile(&primitive, &mut sources).map(|m| m.map(|m| m.coefficient(&at())));
    }
}

const TYPES: [&str; 10] =
    ["brightfunc", "colorfunc", "texfunc", "mixfunc", "colorpict", "mixpict", "brightdata", "mixdata", "colordata", "texdata"];
const WORDS: &[&str] = &[
    "noop", "red", "one", "three", "Px", "Dx*Dy", "1", "1/0", "a.hdr", "d1.dat", "d2.dat", "f.cal", ".", ".", "-t", "1", "-rx", "-s", "-i",
    "A2", "",
];

/// Every function file, and every pattern, texture and mixture whose files are there.
#[test]
fn the_corpus_compiles() {
    let own = || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let shared = std::env::var_os("INVERAD_SHARED").map_or_else(own, std::path::PathBuf::from);
    let Ok(repositories) = std::fs::read_dir(shared.join("corpus")) else {
        skipped("no corpus of scene files (INVERAD_SHARED, ../shared)");
        return;
    };
    let (mut compiled, mut texts, mut missing, mut wrong) = (0, 0, Vec::new(), Vec::new());
    for repository in repositories.flatten() {
        let (mut open, mut all) = (vec![repository.path()], Repository::default());
        while let Some(directory) = open.pop() {
            for path in std::fs::read_dir(directory).into_iter().flatten().flatten().map(|entry| entry.path()) {
                if path.is_dir() {
                    open.push(path);
                } else if let Some(name) = path.file_name() {
                    all.0.insert(name.to_string_lossy().into_owned(), path);
                }
            }
        }
        for path in all.0.values() {
            let (name, bytes) = (path.to_string_lossy(), std::fs::read(path).unwrap());
            match path.extension().and_then(|e| e.to_str()) {
                Some("cal") => match Library::new().define(Source::new(name, String::from_utf8_lossy(&bytes)), FileId::GLOBAL) {
                    Ok(()) => texts += 1,
                    Err(error) => wrong.push(error.to_string()),
                },
                Some("rad" | "mat" | "sky") => {
                    let Ok(document) = Document::read(&name, bytes) else { continue };
                    let mut sources = Sources::new(&all);
                    for primitive in document.primitives() {
                        let found = Pattern::compile(primitive, &mut sources).map(|p| p.map(|p| p.color(&at()))).and_then(|pattern| {
                            let texture = Texture::compile(primitive, &mut sources)?.map(|t| t.perturbation(&at()));
                            let mixture =
                                Mixture::compile(primitive, &mut sources)?.map(|m| Vec3::splat(m.coefficient(&at()).unwrap_or(0.0)));
                            Ok(pattern.or(texture).or(mixture))
                        });
                        match found {
                            Ok(one) => compiled += usize::from(one.is_some()),
                            Err(error) if error.message.ends_with("not in the repository") => missing.push(error.to_string()),
                            Err(error) => wrong.push(error.to_string()),
                        }
                    }
                }
                _ => (),
            }
        }
    }
    eprintln!("{texts} function files and {compiled} primitives compile, {} lack files", missing.len());
    missing.iter().chain(&wrong).for_each(|error| eprintln!("{error}"));
    assert!(compiled > 1000 && texts > 200 && wrong.is_empty(), "{wrong:?}");
}

/// The files of a repository by their names, wherever they are.
#[derive(Default)]
struct Repository(std::collections::BTreeMap<String, std::path::PathBuf>);

impl Resolve for Repository {
    fn scene(&self, path: &str) -> crate::error::Result<Vec<u8>> {
        self.library(path)
    }

    fn library(&self, name: &str) -> crate::error::Result<Vec<u8>> {
        let path = self.0.get(name.rsplit('/').next().unwrap_or(name));
        path.and_then(|path| std::fs::read(path).ok()).ok_or_else(|| crate::error::Error::new(format!("{name} is not in the repository")))
    }

    fn command(&self, command: &str) -> crate::error::Result<Vec<u8>> {
        Err(crate::error::Error::new(format!("command not run: {command}")))
    }
}
