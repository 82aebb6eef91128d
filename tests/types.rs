//! `anneal --type`: which type of material it is, and the file with the material of that type.

use crate::photograph::run;
use std::fs;
use std::process::Output;

/// The unknown, between other things that stay as they are.
const START: &str = "# what is it?\nvoid plastic thing\n0\n0\n5 .50 .5 .5 .1 .1 # start\nvoid alias it thing\n";

/// A ball or a pane between walls, under a patterned sky and a lamp.
const SCENE: &str = "void brightfunc wave 2 1+.8*sin(9*Dx)*sin(7*Dz+Dy) . 0 0\nwave glow sky 0 0 4 1 1.1 1.2 0\nsky source sky 0 0 4 0 0 1 360\n\
                     void light bulb 0 0 3 30 30 30\nbulb sphere lamp 0 0 4 -3 -4 4 .3\n";
const BALL: &str = "it sphere s 0 0 4 0 0 0 1\n";
const PANE: &str = "void plastic red 0 0 5 .7 .1 .1 0 0\nred polygon behind 0 0 12 0 2 -2 2 2 -2 2 2 2 0 2 2\n\
                    it polygon p 0 0 12 -1 0 -1 1 0 -1 1 0 1 -1 0 1\n";

/// What `anneal` makes, with these options, of a picture of something made of `material`.
fn annealed(material: &str, shape: &str, options: &str) -> Output {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path();
    fs::write(path.join("start.rad"), START).unwrap();
    fs::write(path.join("true.rad"), format!("void {material}\nvoid alias it thing\n")).unwrap();
    fs::write(path.join("scene.rad"), format!("{SCENE}{shape}")).unwrap();
    let view = "-vp 0 -5 1 -vd 0 1 -.2 -vh 26 -vv 26 -x 40 -y 40 --spp 200 --seed 5 -ab 1 -o target.hdr true.rad scene.rad";
    assert!(run(env!("CARGO_BIN_EXE_rtrace-rs"), path, view).status.success());
    run(env!("CARGO_BIN_EXE_anneal"), path, &format!("-ab 1 --scene scene.rad --target target.hdr {options} start.rad"))
}

/// What `--type` makes of it: the comment lines, the file, and what was said on standard error.
fn taken(material: &str, shape: &str, options: &str) -> (String, String, String) {
    let done = annealed(material, shape, options);
    let (out, said) = (String::from_utf8(done.stdout).unwrap(), String::from_utf8(done.stderr).unwrap());
    assert_eq!(done.status.code(), Some(0), "{said}");
    let (comments, file) = out.split_once("# what is it?\n").unwrap();
    println!("{comments}{file}");
    (comments.into(), file.into(), said)
}

/// The real arguments of what was found.
fn reals(file: &str) -> Vec<f64> {
    let line = file.lines().nth(3).unwrap().split(" #").next().unwrap();
    line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect()
}

fn near(found: &[f64], truth: &[f64], within: f64) {
    assert!(found.len() == truth.len() && found.iter().zip(truth).all(|(a, b)| (a - b).abs() < within), "{found:?} is not {truth:?}");
}

#[test]
fn a_coloured_metal_is_no_plastic() {
    let (comments, file, said) = taken("metal thing 0 0 5 .8 .6 .3 .6 .1", BALL, "--type auto");
    assert!(comments.starts_with("# type metal; plastic excluded by ") && said.is_empty(), "{comments}{said}");
    assert!(file.starts_with("void metal thing\n0\n0\n5 0.") && file.ends_with(" # start\nvoid alias it thing\n"), "{file}");
    near(&reals(&file), &[0.8, 0.6, 0.3, 0.6, 0.1], 0.01);
}

#[test]
fn a_grey_metal_is_a_plastic() {
    // .8 · .7 reflected in a lobe, .8 · .3 diffusely: of plastic, specularity .56 and a grey of .24 / .44.
    let (comments, file, _) = taken("metal thing 0 0 5 .8 .8 .8 .7 .1", BALL, "--type auto");
    assert!(comments.starts_with("# type plastic (as good: metal, the same reflectance"), "{comments}");
    near(&reals(&file), &[0.545, 0.545, 0.545, 0.56, 0.1], 0.02);
}

#[test]
fn a_pane_of_glass_is_known_by_what_is_behind_it() {
    let (comments, file, _) = taken("glass thing 0 0 3 .9 .7 .6", PANE, "--type auto");
    assert!(comments.starts_with("# type glass") && file.starts_with("void glass thing\n0\n0\n3 "), "{comments}");
    near(&reals(&file), &[0.9, 0.7, 0.6], 0.01);
}

#[test]
fn a_pane_of_heavy_glass_is_no_trans() {
    let (comments, file, _) = taken("glass thing 0 0 4 .9 .7 .6 1.8", PANE, "--type auto");
    assert!(comments.starts_with("# type glass") && file.starts_with("void glass thing\n0\n0\n4 "), "{comments}");
    near(&reals(&file), &[0.9, 0.7, 0.6, 1.8], 0.02);
}

#[test]
fn a_type_that_is_named_is_taken() {
    let (comments, file, _) = taken("metal thing 0 0 5 .8 .6 .3 .6 .1", BALL, "--type metal --fix trans --param spec=:.3:1");
    assert!(comments.starts_with("# chi2 "), "{comments}");
    near(&reals(&file), &[0.8, 0.6, 0.3, 0.6, 0.1], 0.01);
}

#[test]
fn an_index_of_refraction_is_sought_within_reason() {
    let done = annealed("glass thing 0 0 3 .9 .7 .6", PANE, "--type dielectric --param ior=1.5:1:1e8");
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.code() == Some(2) && said.contains("is sought up to 10; give it nearer bounds"), "{said}");
}

#[test]
fn what_lets_nothing_through_is_not_sought() {
    let done = annealed("plastic thing 0 0 5 .5 .5 .5 .05 .1", BALL, "--type dielectric --param red=0:0:1e-300");
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.code() == Some(2) && said.contains("with such a red nothing comes through "), "{said}");
}

#[test]
fn what_cannot_be_tried_is_said() {
    let directory = tempfile::tempdir().unwrap();
    fs::write(directory.path().join("start.rad"), START).unwrap();
    let trouble = |arguments: &str| {
        let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), arguments);
        assert_eq!((done.status.code(), done.stdout.len()), (Some(2), 0));
        String::from_utf8(done.stderr).unwrap()
    };
    assert!(trouble("--type auto --exec true start.rad").contains("it needs --scene and --target"));
    assert!(trouble("--type wood --exec true start.rad").contains("'wood'"));
    assert!(trouble("--type metal --fix gloss --exec true start.rad").contains("start.rad:2:6: error: no type of material that is tried"));
}
