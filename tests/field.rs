//! The illumination field: environments measured at several places, `#@probe X Y Z GLOW_ID`, light each point by those near it.

use crate::fed::fed;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Two uniform environments of radiance 1 and 3 (in red; less in the others), at x = 0 and x = 1, and the sky they share.
const UNIFORM: &str =
    "void glow a 0 0 4 1 .5 0 0\nvoid glow b 0 0 4 3 .5 1 0\na source sky 0 0 4 0 0 1 360\n#@probe 0 0 0 a\n#@probe 1 0 0 b\n";

/// A sky of radiance 1 + z/2, and one of 20 within a cone of cosine .9 about the zenith and .5 elsewhere, at x = 0 and x = 1.
const SHAPED: &str = "void brightfunc pa 2 1+Dz/2 . 0 0 pa glow a 0 0 4 1 1 1 0\n\
                      void brightfunc pb 2 if(Dz-.9,20,.5) . 0 0 pb glow b 0 0 4 1 1 1 0\n\
                      b source sky 0 0 4 0 0 1 360\n#@probe 0 0 0 a\n#@probe 1 0 0 b\n";

/// A white floor, a millimetre wide, under each of some points.
fn floors(at: &[f64]) -> String {
    let ring = |x: &f64| format!("white ring r{x} 0 0 8 {x} 0 0 0 0 1 0 .001\n");
    format!("void plastic white 0 0 5 .5 .5 .5 0 0\n{}", at.iter().map(ring).collect::<String>())
}

fn run(directory: &Path, program: &str, arguments: &[&str], input: &str) -> Output {
    fed(Command::new(program).args(arguments).current_dir(directory), input.as_bytes())
}

/// What `rtrace-rs` writes for rays in a scene.
fn written(scene: &str, arguments: &[&str], rays: &str) -> String {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("scene.rad"), scene).unwrap();
    let arguments: Vec<&str> = ["-h"].iter().chain(arguments).chain(&["scene.rad"]).copied().collect();
    let output = run(directory.path(), env!("CARGO_BIN_EXE_rtrace-rs"), &arguments, rays);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The radiances of rays in a scene.
fn radiances(scene: &str, arguments: &[&str], rays: &str) -> Vec<[f64; 3]> {
    let numbers = |line: &str| line.split_whitespace().map(|v| v.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap();
    let radiances: Vec<_> = written(scene, arguments, rays).lines().map(numbers).collect();
    assert_eq!(radiances.len(), rays.lines().count());
    radiances
}

/// What refuses a scene.
fn refused(scene: &str) -> String {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("scene.rad"), scene).unwrap();
    let output = run(directory.path(), env!("CARGO_BIN_EXE_rtrace-rs"), &["scene.rad"], "0 0 0 0 0 1\n");
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8(output.stderr).unwrap()
}

/// Rays down on points of the x axis.
fn down(at: &[f64]) -> String {
    at.iter().map(|x| format!("{x} 0 1 0 0 -1\n")).collect()
}

fn close(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance * wanted.abs().max(1e-3), "{found} instead of {wanted}");
}

/// The share of the probe at x = 1 by 1/distance², for a point of the x axis.
fn share(x: f64) -> f64 {
    x * x / (x * x + (1.0 - x) * (1.0 - x))
}

#[test]
fn two_uniform_probes_light_each_point_by_their_distances() {
    // A point in between, beyond either, and at each probe itself.
    let at = [0.0, 0.2, 0.5, 0.9, 1.0, 4.0, -2.0];
    let scene = format!("{UNIFORM}{}", floors(&at));
    let blend = radiances(&scene, &["--spp", "16"], &down(&at));
    let nearest = radiances(&scene, &["--spp", "16", "--field", "nearest"], &down(&at));
    for ((x, blend), nearest) in at.iter().zip(blend).zip(nearest) {
        // The radiosity of a Lambertian floor under a uniform sky, times its reflectance, over π.
        let b = share(*x);
        close(blend[0], 0.5 * (1.0 - b + 3.0 * b), 1e-5);
        close(blend[1], 0.25, 1e-5);
        close(blend[2], 0.5 * b, 1e-5);
        if *x != 0.5 {
            close(nearest[0], if *x > 0.5 { 1.5 } else { 0.5 }, 1e-5);
            close(nearest[2], if *x > 0.5 { 0.5 } else { 0.0 }, 1e-5);
        }
    }
}

#[test]
fn what_a_ray_sees_behind_everything_is_the_sky_of_where_it_comes_from() {
    let from = |points: &[&str]| points.iter().map(|p| format!("{p} 0 1 0\n")).collect::<String>();
    let rays = from(&["0 0 0", ".25 0 0", ".75 0 1e9", "0 .5 0", "1 0 0"]);
    let seen: Vec<f64> = radiances(UNIFORM, &[], &rays).iter().map(|c| c[0]).collect();
    let wanted = [1.0, 1.0 + 2.0 * share(0.25), 2.0, 1.0 + 2.0 * 0.25 / 1.5, 3.0];
    seen.iter().zip(wanted).for_each(|(s, w)| close(*s, w, 1e-5));
    let seen: Vec<f64> = radiances(UNIFORM, &["--field", "nearest"], &from(&[".49 0 0", ".51 7 0"])).iter().map(|c| c[0]).collect();
    assert_eq!(seen, [1.0, 3.0]);
}

#[test]
fn of_many_probes_the_two_nearest_are_blended() {
    let probes = "#@probe 9 0 0 c\n#@probe 0 0 0 a\n#@probe 3 0 0 b\n#@probe -5 0 0 c\n#@probe 0 50 0 c";
    let scene = format!("void glow a 0 0 4 1 0 0 0 void glow b 0 0 4 0 1 0 0 void glow c 0 0 4 0 0 1 0\n{probes}");
    let seen = radiances(&scene, &[], "1 0 0 0 0 1\n6.5 0 0 0 0 1\n-20 0 0 0 0 1\n");
    for (found, wanted) in seen.iter().zip([[0.8, 0.2, 0.0], [0.0, 1.0 / 12.25, 1.0 / 6.25], [1.0 / 400.0, 0.0, 1.0 / 225.0]]) {
        let sum: f64 = wanted.iter().sum();
        (0..3).for_each(|c| close(found[c], wanted[c] / sum, 1e-5));
    }
}

#[test]
fn directions_are_drawn_from_the_skies_of_the_probes_without_bias() {
    // Irradiance over π of 1 + z/2 is 1 + 1/3, of the cone .5 + 19.5 (1 − .9²).
    let (a, b) = (4.0 / 3.0, 0.5 + 19.5 * 0.19);
    let at = [0.0, 0.3, 0.5, 0.8, 1.0];
    let scene = format!("{SHAPED}{}", floors(&at));
    for (field, tolerance) in [("blend", 0.003), ("nearest", 0.003)] {
        let found = radiances(&scene, &["--spp", "20000", "--field", field], &down(&at));
        for (x, found) in at.iter().zip(found) {
            let share = if field == "blend" { share(*x) } else { (*x > 0.5) as u8 as f64 };
            close(found[0], 0.5 * (a + share * (b - a)), tolerance);
        }
    }
}

#[test]
fn equal_probes_are_one_environment() {
    let at = [0.0, 0.3, 0.5, 2.0];
    let sky = "void brightfunc p 2 if(Dz-.9,20,.5) . 0 0 p glow g 0 0 4 1 1 1 0\ng source sky 0 0 4 0 0 1 360\n";
    let alone = format!("{sky}{}", floors(&at));
    let one = written(&alone, &["--spp", "50"], &down(&at));
    // The same glow twice: the same bytes.
    for field in ["blend", "nearest"] {
        let twice = format!("{alone}#@probe 0 0 0 g\n#@probe 1 0 0 sky\n");
        assert_eq!(written(&twice, &["--spp", "50", "--field", field], &down(&at)), one, "{field}");
    }
    // Another glow that shines the same: the same expectation.
    let scene = format!("{alone}p glow h 0 0 4 1 1 1 0\n#@probe 0 0 0 g\n#@probe 1 0 0 h\n");
    for value in radiances(&scene, &["--spp", "20000"], &down(&at)) {
        close(value[0], 0.5 * (0.5 + 19.5 * 0.19), 0.003);
    }
}

/// Environments of radiance 1, measured at these places, in which a sphere of radius .2 and radiance 50 is seen from all but the last `blind`.
fn room(lamp: [f64; 3], places: &[[f64; 3]], blind: usize) -> String {
    let probe = |(i, place): (usize, &[f64; 3])| {
        let to: Vec<f64> = (0..3).map(|k| lamp[k] - place[k]).collect();
        let distance = to.iter().map(|v| v * v).sum::<f64>().sqrt();
        let [x, y, z] = [to[0] / distance, to[1] / distance, to[2] / distance];
        let rim = if i + blind < places.len() { (1.0 - (0.2 / distance).powi(2)).sqrt() } else { 2.0 };
        format!(
            "void brightfunc p{i} 2 if(Dx*{x}+Dy*{y}+Dz*{z}-{rim},50,1) . 0 0 p{i} glow g{i} 0 0 4 1 1 1 0\n#@probe {} {} {} g{i}\n",
            place[0], place[1], place[2]
        )
    };
    places.iter().enumerate().map(probe).collect()
}

#[test]
fn a_lamp_that_all_probes_see_stands_where_their_lines_of_sight_meet() {
    let (lamp, at) = ([1.0, 0.5, 3.0], [0.0, 1.0, 2.5, -1.5]);
    let places = [[0.0, 0.0, 0.2], [0.6, -0.3, 0.3], [0.3, 0.4, 0.6]];
    let scene = format!("{}{}", room(lamp, &places, 0), floors(&at));
    // Irradiance over π of a sphere above a floor is its radiance times sin² of its angle times the cosine toward it.
    for (x, found) in at.iter().zip(radiances(&scene, &["--spp", "4000", "-ab", "1"], &down(&at))) {
        let square = (x - lamp[0]).powi(2) + lamp[1].powi(2) + lamp[2].powi(2);
        close(found[0], 0.5 * (1.0 + 49.0 * 0.04 / square * lamp[2] / square.sqrt()), 0.01);
    }
    // It is seen from beside and from a probe; and where a probe saw it, but from elsewhere, is what surrounds it.
    let words = |v: [f64; 3]| v.map(|x| x.to_string()).join(" ");
    let away = words(std::array::from_fn(|k| lamp[k] - places[0][k]));
    let rays = format!("2 .5 3 -1 0 0\n{} {away}\n3 3 .2 {away}\n", words(places[0]));
    let seen = |scene: &str, field: &str| radiances(scene, &["--field", field], &rays).iter().map(|v| v[0].round()).collect::<Vec<_>>();
    assert_eq!(seen(&scene, "blend"), [50.0, 50.0, 1.0]);
    // What one of three does not see may have something before it; where but two look, lines may meet by chance.
    for room in [room(lamp, &places, 1), room(lamp, &places[..2], 0)] {
        assert_eq!(seen(&room, "blend")[..2], [1.0, 50.0]);
    }
    assert_eq!(seen(&scene, "nearest")[..2], [1.0, 50.0]);
}

#[test]
fn lamps_shine_beside_the_field_and_glows_below_it_do_not() {
    let others = "void light l 0 0 3 7 7 7\nl source sun 0 0 4 0 0 1 5\nvoid glow g 0 0 4 9 9 9 0\ng source ground 0 0 4 0 0 -1 180\n";
    let seen = radiances(&format!("{others}{UNIFORM}"), &[], "0 0 0 0 0 1\n0 0 0 0 0 -1\n");
    assert_eq!(seen, [[7.0, 7.0, 7.0], [1.0, 0.5, 0.0]]);
}

#[test]
fn a_probe_that_names_no_glow_is_refused_where_it_stands() {
    let message = refused("void light l 0 0 3 1 1 1\nl source s 0 0 4 0 0 1 360\n#@probe 0 0 0 s\n");
    assert!(message.starts_with("rtrace-rs: scene.rad:3:1: error: `s` is no glow: a probe names the glow of"), "{message}");
    let message = refused("void glow g 0 0 4 1 1 1 0\n#@probe 0 0 g\n");
    assert!(message.starts_with("rtrace-rs: scene.rad:2:1: error: a probe is written #@probe X Y Z GLOW_ID"), "{message}");
    assert!(refused("#@probe 0 0 0 missing\n").contains("`missing` is no glow"));
}

#[test]
fn a_material_is_recovered_from_the_pixels_it_covers_wholly() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    let wave = |x: &str| format!("void brightfunc p{x} 2 1+.7*sin(9*Dx+{x})*sin(7*Dz) . 0 0 p{x} glow g{x} 0 0 4 1 {x} .5 0\n");
    let probes = "#@probe -1 -.2 0 g1\n#@probe 1 -.2 .3 g2\n";
    let field = format!("{}{}g1 source sky 0 0 4 0 0 1 360\nm sphere s 0 0 4 0 0 0 1\n", wave("1"), wave("2"));
    let write = |name: &str, text: &str| fs::write(path.join(name), text).unwrap();
    write("field.rad", &format!("{field}{probes}"));
    write("plain.rad", &field);
    write("true.rad", "void plastic m 0 0 5 .6 .4 .2 .08 .15\n");
    write("start.rad", "void plastic m 0 0 5 .5 .5 .5 .05 .1\n");
    let view = ["-vp", "0", "-5", "0", "-vd", "0", "1", "0", "-vh", "30", "-vv", "30", "-x", "32", "-y", "32"];
    let mut arguments = view.to_vec();
    arguments.extend(["--spp", "1600", "-o", "target.hdr", "true.rad", "field.rad"]);
    assert!(run(path, env!("CARGO_BIN_EXE_rtrace-rs"), &arguments, "").status.success());
    let recovered = |scene: &str| {
        let output = run(path, env!("CARGO_BIN_EXE_anneal"), &["--scene", scene, "--target", "target.hdr", "start.rad"], "");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let pixels = |text: &str| text.split("over ").nth(1).unwrap().split(' ').next().unwrap().parse::<usize>().unwrap();
    let found = recovered("field.rad");
    let line = found.lines().find(|line| line.starts_with("void plastic")).unwrap();
    let values = line.split_whitespace().skip(6).map(|v| v.parse::<f64>().unwrap());
    for (value, wanted) in values.zip([0.6, 0.4, 0.2, 0.08, 0.15]) {
        assert!((value - wanted).abs() < 0.005, "{found}");
    }
    // The disk of the sphere has a rim of pixels, of which the field leaves out all.
    let (within, all) = (pixels(&found), pixels(&recovered("plain.rad")));
    assert!(within + 50 < all, "{within} {all}");
}
