//! What `rtrace-rs` writes beside a picture, or instead of it: lengths, normals, depths, albedos, kinds of light and coverage, of a ball whose
//! geometry gives them in closed form.

use inverad::picture::Picture;
use inverad::picture::exr::{Planes, Samples};
use std::f64::consts::PI;
#[cfg(unix)]
use std::ffi::OsStr;
use std::fs;
use std::process::Command;

/// Pixels in a row, and how wide what is seen is: a ball of radius 1 from far away, in front of a sky of radiance 1.
const SIDE: usize = 9;
const WIDE: f64 = 4.0;
const BALL: &str = "void plastic it 0 0 5 .5 .4 .3 0 0\nit sphere ball 0 0 4 0 0 0 1\n";
const SKY: &str = "void glow even 0 0 4 1 1 1 0\neven source sky 0 0 4 0 0 1 360\n";

/// Renders the ball with these options in a directory of its own, and gives the bytes of what it is asked for there.
fn rendered(options: &str, scene: &str, wanted: &str) -> Vec<u8> {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("scene.rad"), scene).unwrap();
    let view = format!("-vtl -vp 0 -5 0 -vd 0 1 0 -vu 0 0 1 -vh {WIDE} -vv {WIDE} -x {SIDE} -y {SIDE}");
    let line = format!("{view} --spp 256 -o picture.hdr {options} scene.rad");
    let done = Command::new(env!("CARGO_BIN_EXE_rtrace-rs")).current_dir(directory.path()).args(line.split(' ')).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    fs::read(directory.path().join(wanted)).unwrap()
}

/// The numbers of a plane.
fn numbers<'p>(planes: &'p Planes, name: &str) -> &'p [f32] {
    let Some(Samples::F32(numbers)) = planes.plane(name).map(|plane| &plane.samples) else { panic!("no {name}") };
    numbers
}

/// The middle of each pixel, as (x, z) in the scene, row by row from the upper left.
fn middles() -> impl Iterator<Item = (f64, f64)> {
    let at = |k: usize| WIDE * ((k as f64 + 0.5) / SIDE as f64 - 0.5);
    (0..SIDE * SIDE).map(move |n| (at(n % SIDE), -at(n / SIDE)))
}

/// The distance from the viewer's plane to the ball at a place of the picture.
fn distance((x, z): (f64, f64)) -> Option<f64> {
    let square = 1.0 - x * x - z * z;
    (square > 0.0).then(|| 5.0 - square.sqrt())
}

#[test]
fn the_length_of_each_central_ray_is_kept() {
    let bytes = rendered("-z lengths", &format!("{BALL}{SKY}"), "lengths");
    let lengths: Vec<f32> = bytes.chunks_exact(4).map(|b| f32::from_ne_bytes(b.try_into().unwrap())).collect();
    assert_eq!(lengths.len(), SIDE * SIDE);
    for (length, place) in lengths.iter().zip(middles()) {
        match distance(place) {
            Some(distance) => assert!((*length as f64 - distance).abs() < 1e-5, "{place:?}: {length}, not {distance}"),
            // `rpict -z` of RADIANCE 6.0a has 1e10 where nothing but the sky is.
            None => assert_eq!(*length, 1e10),
        }
    }
}

#[test]
fn normals_depths_albedos_and_kinds_of_light_are_kept() {
    let scene = format!("{BALL}{SKY}");
    let planes =
        Planes::read(&rendered("--aov normal,depth,albedo,direct,indirect beside.exr", &scene, "beside.exr"), "beside.exr").unwrap();
    let plane = |name: &str| numbers(&planes, name);
    let middle = SIDE * SIDE / 2;
    // In the middle pixel, of half width w, the mean of √(1 - x² - z²) is 1 - w²/3 to second order; normals are as symmetric as the ball.
    let half = WIDE / SIDE as f64 / 2.0;
    let mean = 1.0 - half * half / 3.0;
    for (name, expected) in [("normal.X", 0.0), ("normal.Y", -mean), ("normal.Z", 0.0), ("depth.Z", 5.0 - mean)] {
        assert!((plane(name)[middle] as f64 - expected).abs() < 2e-3, "{name}: {}", plane(name)[middle]);
    }
    // No light of the sky reaches a ball by way of itself: all is direct, and the albedo's part of it comes back.
    for (channel, albedo) in [("R", 0.5), ("G", 0.4), ("B", 0.3)] {
        let value = |what: &str| plane(&format!("{what}.{channel}"))[middle];
        assert!((value("albedo") - albedo).abs() < 1e-6 && (value("direct") - albedo).abs() < 0.02, "{channel}: {}", value("direct"));
        assert_eq!(value("indirect"), 0.0);
    }
    assert!(plane("depth.Z")[0].is_infinite() && plane("normal.Y")[0] == 0.0);
}

#[test]
fn light_that_was_scattered_twice_is_indirect() {
    // Inside a ball of radius 8 around a lamp of radius .8 the wall is lit alike everywhere; (.8/8)² of what it scatters meets the lamp, .6 of the rest
    // is scattered again: each scattering leaves .594 of the one before, and so all but the first make .594 of the whole.
    let room = "void plastic it 0 0 5 .6 .6 .6 0 0\nit bubble room 0 0 4 0 0 0 8\n";
    let scene = format!("{room}void light on 0 0 3 10 10 10\non sphere lamp 0 0 4 0 0 0 .8\n");
    let planes = Planes::read(&rendered("--aov direct,indirect beside.exr", &scene, "beside.exr"), "beside.exr").unwrap();
    // The first row does not show the lamp.
    let light = |what: &str| numbers(&planes, what)[..SIDE].iter().map(|v| *v as f64).sum::<f64>();
    let (direct, indirect) = (light("direct.G"), light("indirect.G"));
    assert!((indirect / (direct + indirect) - 0.594).abs() < 0.01, "{direct} {indirect}");
}

#[test]
fn few_samples_have_a_variance_too() {
    // Whether a scattered ray meets the half of the sky that shines is left to chance.
    let scene = "void trans it 0 0 7 .9 .9 .9 0 0 .5 0\nit sphere ball 0 0 4 0 0 0 1\nvoid glow half 0 0 4 1 1 1 0\nhalf source sky 0 0 4 0 0 1 180\n";
    for samples in 2..6 {
        let bytes = rendered(&format!("--spp {samples} --variance v.exr"), scene, "v.exr");
        let planes = Planes::read(&bytes, "v.exr").unwrap();
        let variances = numbers(&planes, "variance.G");
        assert!(variances.iter().all(|v| v.is_finite() && *v >= 0.0) && variances.iter().any(|v| *v > 0.0), "{samples}: {variances:?}");
    }
}

#[test]
fn what_a_scene_reads_is_not_overwritten() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name);
    fs::write(at("ball.rad"), BALL).unwrap();
    fs::write(at("scene.rad"), format!("!xform ball.rad\n{SKY}")).unwrap();
    let line = "-vp 0 -5 0 -vd 0 1 0 -x 4 -y 4 -o ball.rad scene.rad";
    let done = Command::new(env!("CARGO_BIN_EXE_rtrace-rs")).current_dir(directory.path()).args(line.split(' ')).output().unwrap();
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.code() == Some(2) && said.contains("ball.rad: read here, and would be lost"), "{said}");
    assert_eq!(fs::read_to_string(at("ball.rad")).unwrap(), BALL);
    // Nor is what has a name that is no UTF-8.
    #[cfg(unix)]
    {
        let name: &OsStr = std::os::unix::ffi::OsStrExt::from_bytes(b"caf\xe9.rad");
        fs::write(directory.path().join(name), format!("{BALL}{SKY}")).unwrap();
        let line = ["-vp", "0", "-5", "0", "-vd", "0", "1", "0", "-x", "4", "-y", "4", "-o"].map(OsStr::new);
        let mut command = Command::new(env!("CARGO_BIN_EXE_rtrace-rs"));
        let done = command.current_dir(directory.path()).args(line).args([name, name]).output().unwrap();
        assert_eq!(done.status.code(), Some(2), "{}", String::from_utf8_lossy(&done.stderr));
    }
}

#[test]
fn coverage_is_the_part_of_each_pixel() {
    let picture = Picture::read(&rendered("--coverage it", &format!("{BALL}{SKY}"), "picture.hdr"), "picture.hdr").unwrap();
    let covered: Vec<f64> = picture.pixels.iter().map(|p| p[1] as f64).collect();
    let area = covered.iter().sum::<f64>() * (WIDE / SIDE as f64).powi(2);
    assert!((area / PI - 1.0).abs() < 0.01, "{area}");
    assert!(covered[SIDE * SIDE / 2] > 0.99 && covered[0] == 0.0);
}
