//! anneal --predict: the standard errors that a photograph would give are those that one gives.

use crate::photograph;
use inverad::picture::Picture;
use inverad::sampling::mix64;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const SKY: &str =
    "void brightfunc wave 2 1+.8*sin(9*Dx)*sin(7*Dz+Dy) . 0 0\nwave glow sky 0 0 4 1 1.1 1.2 0\nsky source sky 0 0 4 0 0 1 360\n";
const BULB: &str = "void light bulb 0 0 3 200 200 200\nbulb sphere lamp 0 0 4 -3 -4 4 .3\n";
const BALL: &str = "it sphere s 0 0 4 0 0 0 1\n";
const VIEW: &str = "-vp 0 -5 1 -vd 0 1 -.2 -vh 26 -vv 26 -ab 2";

fn run(program: &str, directory: &Path, arguments: &str) -> Output {
    let done = photograph::run(program, directory, arguments);
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    done
}

fn anneal(directory: &Path, arguments: &str) -> String {
    let out = String::from_utf8(run(env!("CARGO_BIN_EXE_anneal"), directory, arguments).stdout).unwrap();
    println!("{out}");
    out
}

/// Values and standard errors, as they are told.
fn told(out: &str) -> Vec<(String, f64, f64)> {
    let lines = out.lines().filter_map(|line| line.strip_prefix("# ")?.split_once(" ± ").filter(|(start, _)| !start.contains(':')));
    let number = |text: &str| text.split([' ', ':']).next().unwrap().parse().unwrap();
    lines.map(|(start, error)| (start.split(' ').next().unwrap().into(), number(start.split(' ').nth(1).unwrap()), number(error))).collect()
}

/// A number with standard deviation 1 (Box and Muller 1958).
fn normal(index: u64) -> f64 {
    let uniform = |i: u64| (mix64(i) >> 11) as f64 / (1u64 << 53) as f64;
    (-2.0 * (1.0 - uniform(2 * index)).ln()).sqrt() * (std::f64::consts::TAU * uniform(2 * index + 1)).cos()
}

/// The errors predicted for a picture of something made of `material` are within a factor 2 of those that its recovery from one with the
/// noise assumed tells, and cover how far it is off.
fn predicted_as_recovered(material: &str, start: &str) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("true.rad"), format!("void {material}\n")).unwrap();
    fs::write(path.join("start.rad"), format!("void {start}\n")).unwrap();
    fs::write(path.join("scene.rad"), format!("{SKY}{BULB}{BALL}")).unwrap();
    let printed = anneal(path, &format!("{VIEW} --predict -x 48 -y 48 --scene scene.rad true.rad"));
    assert!(
        printed.contains("# predicted for a picture of 48 x 48 pixels, ") && printed.ends_with(&format!("void {material}\n")),
        "{printed}"
    );
    assert!(printed.contains("# assumed: noise of 2 % of its value in each pixel and channel"), "{printed}");
    run(env!("CARGO_BIN_EXE_rtrace-rs"), path, &format!("{VIEW} -x 48 -y 48 --spp 1000 --seed 5 -o target.exr true.rad scene.rad"));
    let mut picture = Picture::read(&fs::read(path.join("target.exr")).unwrap(), "target.exr").unwrap();
    let values = picture.pixels.iter_mut().flatten().enumerate();
    values.for_each(|(i, value)| *value *= (1.0 + 0.02 * normal(i as u64)) as f32);
    fs::write(path.join("target.exr"), picture.write_exr().unwrap()).unwrap();
    let recovered = anneal(path, &format!("{VIEW} --target target.exr --scene scene.rad start.rad"));
    let (found, predicted) = (told(&recovered), told(&printed));
    assert_eq!(found.len(), predicted.len());
    // Of all pixels, which a recovery does not look at where fewer are enough.
    let pixels = |text: &str, before: &str| -> f64 { text.split(before).nth(1).unwrap().split(' ').next().unwrap().parse().unwrap() };
    let fewer = (pixels(&printed, "48 x 48 pixels, ") / pixels(&recovered, " over ")).sqrt();
    for ((name, value, error), (_, truth, expected)) in found.iter().zip(&predicted) {
        assert!((0.5..2.0).contains(&(error / (fewer * expected))), "{name}: ± {error}, predicted ± {expected}");
        assert!((value - truth).abs() < 4.0 * fewer * expected, "{name}: {value}, not {truth} ± {expected}");
    }
}

#[test]
fn of_a_plastic() {
    predicted_as_recovered("plastic it 0 0 5 .6 .4 .2 .1 .15", "plastic it 0 0 5 .5 .5 .5 .05 .1");
}

#[test]
fn of_a_metal() {
    predicted_as_recovered("metal it 0 0 5 .8 .6 .3 .7 .1", "metal it 0 0 5 .5 .5 .5 .5 .2");
}

#[test]
fn of_a_dielectric() {
    predicted_as_recovered("dielectric it 0 0 5 .7 .5 .3 1.5 0", "dielectric it 0 0 5 .5 .5 .5 1.4 0");
}

#[test]
fn of_a_mirror() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("start.rad"), "void metal it 0 0 5 .8 .6 .3 .9 0\n").unwrap();
    fs::write(path.join("scene.rad"), format!("{SKY}{BALL}")).unwrap();
    let printed = anneal(path, &format!("{VIEW} --predict -x 40 -y 40 --scene scene.rad start.rad"));
    run(env!("CARGO_BIN_EXE_rtrace-rs"), path, &format!("{VIEW} -x 40 -y 40 --spp 300 --seed 5 -o target.exr start.rad scene.rad"));
    let found = told(&anneal(path, &format!("{VIEW} --target target.exr --scene scene.rad start.rad")));
    let predicted = told(&printed);
    // Any up to .001, of standard deviation .001/√3, and a little more by what a lobe may be.
    for told in [&found, &predicted] {
        let (name, rough, error) = told.last().unwrap();
        assert!(name == "rough" && *rough == 0.0 && (0.0005..0.001).contains(error), "{told:?}");
    }
    assert!(found.iter().zip(&predicted).all(|(found, predicted)| (found.1 - predicted.1).abs() < 4.0 * predicted.2), "{found:?}");
    // Where bounds leave no room for a lobe that tells anything, too.
    let narrow = told(&anneal(path, &format!("{VIEW} --predict -x 20 -y 20 --scene scene.rad --param rough=:0:.01 start.rad")));
    assert!((0.0005..0.001).contains(&narrow.last().unwrap().2), "{narrow:?}");
}

#[test]
fn what_a_recovery_does_not_wait_for_is_said() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("start.rad"), "void plastic it 0 0 5 .6 .4 .2 .1 .15\n").unwrap();
    fs::write(path.join("scene.rad"), format!("{SKY}{BULB}{BALL}")).unwrap();
    let earlier = |size: &str| {
        let printed = anneal(path, &format!("{VIEW} --predict {size} --scene scene.rad start.rad"));
        printed
            .lines()
            .find_map(|line| line.strip_prefix("# unless --tolerance asks for more, a recovery ends earlier: ").map(String::from))
    };
    assert_eq!(earlier("-x 160 -y 160").as_deref(), Some("red ± 0.0018, green ± 0.0018, blue ± 0.0018, spec ± 0.0018 and rough ± 0.0024"));
    assert_eq!(earlier("-x 8 -y 8"), None);
}

#[test]
fn a_lamp_would_help_where_the_light_is_even() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("start.rad"), "void metal it 0 0 5 .8 .6 .3 .7 .2\n").unwrap();
    fs::write(path.join("scene.rad"), format!("void glow even 0 0 4 1 1 1 0\neven source sky 0 0 4 0 0 1 360\n{BALL}")).unwrap();
    let printed = anneal(path, &format!("{VIEW} --predict -x 40 -y 40 --scene scene.rad start.rad"));
    let lamp = printed.lines().find(|line| line.starts_with("# with a small lamp over the camera's shoulder")).unwrap();
    assert!(lamp.contains("spec ± 0.00") && lamp.contains("rough ± 0.00"), "{lamp}");
    assert!(
        printed.contains("# warning: rough is not determined: ") && printed.contains("# warning: spec is not determined: "),
        "{printed}"
    );
}

#[test]
fn what_is_missing_is_said() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("start.rad"), "void metal it 0 0 5 .8 .6 .3 .7 .2\n").unwrap();
    fs::write(directory.path().join("scene.rad"), format!("{SKY}{BULB}{BALL}")).unwrap();
    let trouble = |arguments: &str| {
        let done = Command::new(env!("CARGO_BIN_EXE_anneal")).current_dir(directory.path()).args(arguments.split(' ')).output().unwrap();
        assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0));
        String::from_utf8(done.stderr).unwrap()
    };
    assert!(trouble("--predict --scene scene.rad start.rad").contains("no view; give the view it is taken from with -vf FILE"));
    assert!(trouble("--predict --scene scene.rad --target a.hdr start.rad").contains("cannot be used with"));
    assert!(trouble("-x 40 --scene scene.rad --target a.hdr start.rad").contains("--predict"));
    fs::write(directory.path().join("dark.rad"), BALL).unwrap();
    assert!(trouble("--predict --scene dark.rad -vp 0 -5 0 start.rad").contains("the scene has no light"));
    let black = [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\n".as_slice(), &[0; 64]].concat();
    fs::write(directory.path().join("black.hdr"), black).unwrap();
    assert!(trouble("--scene scene.rad --target black.hdr -vp 0 -5 0 start.rad").contains("the picture is black wherever it shows `it`"));
    assert!(trouble("--direct --scene scene.rad --target black.hdr -vp 0 -5 0 start.rad").contains("the picture is black wherever"));
    assert!(trouble("--predict --type auto --scene scene.rad -vp 0 -5 0 start.rad").contains("--type auto"));
}
