//! An exposure, or a white balance, as one more unknown of anneal; and what it leaves open.

use crate::photograph::said::{recovered, said};
use crate::photograph::waves::SCENE;
use crate::photograph::{photographed, run};
use inverad::picture::Picture;
use std::fs;

/// What is said of a picture of something made of `material` that is brighter than the scene by `factors`.
fn told(material: &str, factors: [f32; 3], options: &str) -> String {
    let view = "-x 40 -y 40 --spp 300 --seed 5 -ab 1 -o target.exr";
    let directory = photographed(material, SCENE, view);
    let path = directory.path();
    let mut picture = Picture::read(&fs::read(path.join("target.exr")).unwrap(), "target.exr").unwrap();
    picture.pixels.iter_mut().for_each(|p| (0..3).for_each(|c| p[c] *= factors[c]));
    fs::write(path.join("target.exr"), picture.write_exr().unwrap()).unwrap();
    // Pixels that the ball covers wholly.
    let covered = photographed(material, SCENE, &view.replace("target.exr", "mask.exr --coverage it"));
    let mut mask = Picture::read(&fs::read(covered.path().join("mask.exr")).unwrap(), "mask.exr").unwrap();
    mask.pixels.iter_mut().flatten().for_each(|v| *v = (*v > 0.999) as u8 as f32);
    fs::write(path.join("mask.exr"), mask.write_exr().unwrap()).unwrap();
    recovered(path, &format!("-ab 1 --scene scene.rad --target target.exr {options} start.rad"))
}

/// Fails unless each of these values was found, with an error that covers how far it is off and is below `most`.
fn found(out: &str, values: &[(&str, f64)], most: f64) {
    for (name, truth) in values {
        let (value, error) = said(out, name);
        assert!((value - truth).abs() < 4.0 * error && error < most, "{name}: {value} ± {error}, not {truth}");
    }
}

#[test]
fn with_a_known_specularity_the_exposure_is_found() {
    let out = told("plastic it 0 0 5 .6 .4 .2 .1 .15", [1.3; 3], "--param exposure=1:.5:2 --fix spec");
    found(&out, &[("exposure", 1.3), ("red", 0.6), ("green", 0.4), ("blue", 0.2), ("rough", 0.15)], 0.02);
    assert!(!out.contains("not determined"), "{out}");
    // It is no number of the file.
    assert_eq!(out.lines().last().unwrap().split_whitespace().count(), 11, "{out}");
}

#[test]
fn another_exposure_is_said_and_a_bound_of_another_size_does_not_hide_it() {
    let plastic = "plastic it 0 0 5 .6 .4 .2 .1 .15";
    let out = told(plastic, [0.3; 3], "");
    assert!(out.contains("# warning: around the unknown the picture is 0.3 times as bright as the scene is"), "{out}");
    assert!(told(plastic, [179.0; 3], "").contains("as one in cd/m² is: divided by 179 it is in radiance"));
    assert!(!told(plastic, [1.0; 3], "").contains("around the unknown"));
    let out = told(plastic, [0.3; 3], "--param exposure=.3:.001:1e5 --fix spec");
    found(&out, &[("exposure", 0.3), ("red", 0.6)], 0.02);
    assert!(!out.contains("around the unknown") && !out.contains("bound"), "{out}");
}

#[test]
fn another_white_balance_is_said_and_another_light() {
    let out = told_of(SCENE, |pixels| pixels.iter_mut().for_each(|p| p[2] *= 1.3));
    let said = "around the unknown red, green and blue of the picture are 1, 1 and 1.3 times as bright as the scene is, as by another white balance";
    assert!(out.contains(said) && out.contains(" --param exposure-blue=1.3:0.13:13 finds that"), "{out}");
    assert!(out.contains("the light that the unknown is found by may be off by 30"), "{out}");
    found(&out, &[("red", 0.6), ("green", 0.4), ("blue", 0.2)], 0.3);
    // The scene is lit by the same sky turned by 20 degrees: no factor makes up for that, and a fit of one does not hide it.
    let turned = SCENE.replace("brightfunc wave 2 ", "brightfunc wave 4 ").replace(" . 0 0\nwave", " . -rz 20 0 0\nwave");
    for options in ["", "--param exposure=1:.1:10 --fix spec"] {
        let out = told_in(&turned, options);
        assert!(out.contains("around the unknown the picture is not as the scene is there, neighbours together by "), "{out}");
        assert!(!out.contains("another exposure"), "{out}");
    }
}

/// In a closed room light is noisier than in the open, and what the object throws at its walls is of its colour: nothing was said of as much.
#[test]
fn a_small_error_of_the_exposure_or_the_white_balance_is_said_in_a_room_too() {
    let room = "void plastic wall 0 0 5 .6 .58 .5 0 0\n!genbox wall room 8 9 6 -i | xform -t -4 -6 -1\nvoid light lamp 0 0 3 120 110 90\n\
                lamp sphere one 0 0 4 -1.8 -2 2.6 .12\nlamp sphere two 0 0 4 2 -1.4 2.2 .09\nit sphere ball 0 0 4 0 0 0 1\n";
    let told = |factors: [f32; 3]| told_of(room, |pixels| pixels.iter_mut().for_each(|p| (0..3).for_each(|c| p[c] *= factors[c])));
    assert!(!told([1.0; 3]).contains("warning"));
    for (factors, what) in [([1.05, 1.0, 0.95], "another white balance"), ([1.05; 3], "another exposure")] {
        let out = told(factors);
        assert!(out.contains(what), "{out}");
        found(&out, &[("red", 0.6), ("green", 0.4), ("blue", 0.2)], 0.1);
    }
}

#[test]
fn what_is_a_little_elsewhere_is_said_and_errors_hold_it() {
    let directory = photographed("dielectric it 0 0 5 .8 .6 .9 1.5 0", SCENE, "-x 60 -y 60 --spp 64 --seed 5 -ab 1 -o target.exr");
    let radius = |radius: &str| {
        fs::write(directory.path().join("scene.rad"), SCENE.replace(" 0 0 0 1\n", &format!(" 0 0 0 {radius}\n"))).unwrap();
        recovered(directory.path(), "-ab 1 --scene scene.rad --target target.exr start.rad")
    };
    let (out, smaller) = (radius("1"), radius(".98"));
    assert!(!out.contains("warning"), "{out}");
    assert!(smaller.contains("# warning: neighbouring pixels are "), "{smaller}");
    for (out, most) in [(out, 0.01), (smaller, 0.1)] {
        found(&out, &[("ior", 1.5), ("red", 0.8), ("green", 0.6), ("blue", 0.9)], most);
    }
}

#[test]
fn black_pixels_where_there_is_light_are_left_out_and_named() {
    // Every eleventh pixel is dead.
    let out = told_of(SCENE, |pixels| pixels.iter_mut().step_by(11).for_each(|p| *p = [0.0; 3]));
    assert!(out.contains(" are black where there is light, as a camera's dead ones are"), "{out}");
    found(&out, &[("red", 0.6), ("green", 0.4), ("blue", 0.2), ("spec", 0.1), ("rough", 0.15)], 0.001);
}

#[test]
fn an_object_cut_out_on_black_is_told_by_what_it_fills() {
    let directory = photographed("plastic it 0 0 5 .6 .4 .2 .1 .15", SCENE, "-x 40 -y 40 --spp 300 --seed 5 -ab 1 -o target.hdr");
    let covered = "-vp 0 -5 1 -vd 0 1 -.2 -vh 26 -vv 26 -x 40 -y 40 --coverage it -o cover.hdr true.rad scene.rad";
    assert!(run(env!("CARGO_BIN_EXE_rtrace-rs"), directory.path(), covered).status.success());
    let read = |name: &str| Picture::read(&fs::read(directory.path().join(name)).unwrap(), name).unwrap();
    let (whole, cover) = (read("target.hdr"), read("cover.hdr"));
    for matte in [0.1, 0.5, 0.95] {
        let mut cut = whole.clone();
        cut.pixels.iter_mut().zip(&cover.pixels).filter(|(_, cover)| cover[0] < matte).for_each(|(pixel, _)| *pixel = [0.0; 3]);
        fs::write(directory.path().join("target.hdr"), cut.write_hdr().unwrap()).unwrap();
        let out = recovered(directory.path(), "--scene scene.rad --target target.hdr start.rad");
        assert!(!out.contains("warning"), "{matte}: {out}");
        found(&out, &[("red", 0.6), ("green", 0.4), ("blue", 0.2), ("spec", 0.1), ("rough", 0.15)], 0.002);
    }
}

/// What is said of a picture of a plastic in `SCENE` as one in `scene`.
fn told_in(scene: &str, options: &str) -> String {
    let directory = photographed("plastic it 0 0 5 .6 .4 .2 .1 .15", SCENE, "-x 40 -y 40 --spp 300 --seed 5 -ab 1 -o target.exr");
    fs::write(directory.path().join("scene.rad"), scene).unwrap();
    recovered(directory.path(), &format!("-ab 1 --scene scene.rad --target target.exr {options} start.rad"))
}

/// What is said of a picture of a plastic in `scene`, changed so.
fn told_of(scene: &str, change: impl Fn(&mut [[f32; 3]])) -> String {
    let directory = photographed("plastic it 0 0 5 .6 .4 .2 .1 .15", scene, "-x 40 -y 40 --spp 300 --seed 5 -ab 1 -o target.exr");
    let path = directory.path();
    let mut picture = Picture::read(&fs::read(path.join("target.exr")).unwrap(), "target.exr").unwrap();
    change(&mut picture.pixels);
    fs::write(path.join("target.exr"), picture.write_exr().unwrap()).unwrap();
    recovered(path, "-ab 1 --scene scene.rad --target target.exr start.rad")
}

#[test]
fn a_pixel_that_nothing_explains_is_named() {
    let out = told_of(SCENE, |pixels| pixels[22 * 40 + 18] = [50.0; 3]);
    assert!(out.contains("# warning: pixels (column,row from the upper left, from 0) 18,22 are far brighter"), "{out}");
}

#[test]
fn a_saturated_camera_is_found_out() {
    let most = |pixels: &[[f32; 3]]| pixels.iter().fold(0.0, |most: f32, p| most.max(p[0]));
    let out = told_of(SCENE, |pixels| {
        let most = most(pixels);
        pixels.iter_mut().flatten().for_each(|v| *v = v.min(0.7 * most));
    });
    assert!(out.contains("as where a camera is saturated"), "{out}");
    found(&out, &[("red", 0.6), ("green", 0.4), ("blue", 0.2)], 0.02);
    // In one channel only.
    let out = told_of(SCENE, |pixels| {
        let most = most(pixels);
        pixels.iter_mut().for_each(|p| p[0] = p[0].min(0.7 * most));
    });
    assert!(out.contains("as where a camera is saturated"), "{out}");
    found(&out, &[("red", 0.6), ("green", 0.4), ("blue", 0.2)], 0.02);
    // Nearly everywhere.
    let out = told_of(SCENE, |pixels| pixels.iter_mut().flatten().for_each(|v| *v = v.min(0.01)));
    assert!(out.contains("nearly all there are: if the camera is saturated there, nothing that is found holds"), "{out}");
    // The side of a box in the sun has one value too, and is as it should be.
    let boxed = "void light sun 0 0 3 3e4 3e4 3e4\nsun source sun 0 0 4 -1 -3 2 .5\nvoid glow sky 0 0 4 .1 .1 .1 0\nsky source sky 0 0 4 0 0 1 360\n\
                 !genbox it box 1 1 1 | xform -t -.5 -.5 -.5 -rz 30\n";
    let rounded = |v: &mut f32| *v = f32::from_bits((v.to_bits() + 0x8000) & 0xffff_0000);
    let out = told_of(boxed, |pixels| pixels.iter_mut().flatten().for_each(rounded));
    assert!(!out.contains("saturated") && out.contains("over 483 pixels"), "{out}");
}

#[test]
fn so_is_the_white_balance() {
    let balance = "--param exposure-red=1:.5:2 --param exposure-green=1:.5:2 --param exposure-blue=1:.5:2 --fix spec";
    let out = told("plastic it 0 0 5 .6 .4 .2 .1 .15", [1.3, 1.0, 0.8], balance);
    found(&out, &[("exposure-red", 1.3), ("exposure-green", 1.0), ("exposure-blue", 0.8), ("red", 0.6), ("blue", 0.2)], 0.03);
}

#[test]
fn one_that_is_known_is_reckoned_with() {
    let out = told("plastic it 0 0 5 .6 .4 .2 .1 .15", [1.3; 3], "--param exposure=1.3:.5:2 --fix exposure");
    found(&out, &[("red", 0.6), ("green", 0.4), ("blue", 0.2), ("rough", 0.15)], 0.01);
    assert!(!out.contains("warning"), "{out}");
}

#[test]
fn what_it_leaves_open_is_said() {
    // Where no edge shows what is behind it, a plastic twice as bright is one that is lit by half as much, and a metal too.
    for material in ["plastic it 0 0 5 .4 .3 .2 .1 .15", "metal it 0 0 5 .5 .4 .3 .7 .15"] {
        let out = told(material, [1.3; 3], "--param exposure=1:.5:2 --mask mask.exr");
        let doubt =
            out.lines().find(|line| line.starts_with("# warning: ") && line.contains("not determined") && line.contains("exposure"));
        let doubt = doubt.unwrap();
        assert!(doubt.contains("red") && doubt.contains("only together") && doubt.contains("a grey card"), "{doubt}");
    }
}

#[test]
fn a_command_cannot_use_it() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("start.rad"), "void metal m 0 0 5 .5 .5 .5 .5 .1\n").unwrap();
    let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), "--exec true --param exposure=1:.5:2 start.rad");
    assert_eq!(done.status.code(), Some(2));
    assert!(String::from_utf8(done.stderr).unwrap().contains("so a command cannot use it; let it fit the exposure"));
}
