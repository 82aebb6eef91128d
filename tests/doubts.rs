//! anneal says what a picture cannot tell: values with the digits that they deserve, and a warning for what is not determined.

use crate::photograph::said::{recovered, said};
use crate::photograph::waves::SCENE;
use crate::photograph::{photographed, run};
use inverad::picture::Picture;

/// A ball alone, and one that a box and a cone shade and are mirrored in.
const BALL: &str = "it sphere s 0 0 4 0 0 0 1\n";
const STILL: &str = "it sphere s 0 0 4 0 0 0 .6\n!genbox it b 1 1 .5 | xform -t .5 -.6 -.5\nit cone c 0 0 8 -.8 0 -.5 -.8 0 .7 .4 .1\n";

/// Light that is the same from everywhere, and a lamp.
const UNIFORM: &str = "void glow even 0 0 4 1 1 1 0\neven source sky 0 0 4 0 0 1 360\n";
const LAMP: &str = "void light bulb 0 0 3 300 300 300\nbulb sphere lamp 0 0 4 -3 -4 4 .3\n";

/// What is said of a picture of `scene` made of `material`: the comment lines, and the warnings on standard error.
fn told(material: &str, scene: &str) -> (Vec<String>, Vec<String>) {
    told_in(material, scene, scene)
}

/// The same where the scene is taken for another than it was.
fn told_in(material: &str, scene: &str, other: &str) -> (Vec<String>, Vec<String>) {
    let directory = photographed(material, scene, "-x 48 -y 48 --spp 128 --seed 5 -ab 2 -o target.hdr");
    std::fs::write(directory.path().join("scene.rad"), other).unwrap();
    let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), "-ab 2 --scene scene.rad --target target.hdr --log log.jsonl start.rad");
    assert_eq!(done.status.code(), Some(0));
    let lines = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().lines().map(String::from).collect::<Vec<_>>();
    let (out, said) = (lines(done.stdout), lines(done.stderr));
    println!("{}", out.join("\n"));
    // The log ends with the answer, which has as many digits as it deserves.
    let log = std::fs::read_to_string(directory.path().join("log.jsonl")).unwrap();
    let last: serde_json::Value = serde_json::from_str(log.lines().last().unwrap()).unwrap();
    let numbers = out.last().unwrap().rsplit(' ').map(|word| word.parse::<f64>().unwrap());
    for (name, number) in ["rough", "spec", "blue", "green", "red"].iter().zip(numbers) {
        let (logged, error) = (last["values"][name].as_f64().unwrap(), last["errors"][name].as_f64().unwrap());
        assert!((logged - number).abs() <= 0.01 * error.max(0.01), "{name}: {logged} at the end of the log, {number} in the answer");
    }
    (out.into_iter().filter_map(|line| line.strip_prefix("# ").map(String::from)).collect(), said)
}

/// The value and the standard error on the line of a parameter, and what is said of it.
fn line(lines: &[String], name: &str) -> (f64, f64, String) {
    let line = lines.iter().find(|line| line.starts_with(&format!("{name} "))).unwrap();
    let (numbers, standing) = line.split_once(':').unwrap_or((line, ""));
    let words: Vec<&str> = numbers.split(' ').collect();
    assert_eq!((words.len(), words[2]), (4, "±"), "{line}");
    // Two digits of the error, and as many decimals of the value.
    let digits = words[3].trim_start_matches(['0', '.']);
    let decimals = |word: &str| word.split_once('.').unwrap().1.len();
    assert!(digits.replace('.', "").len() == 2 && decimals(words[1]) == decimals(words[3]), "{line}");
    (words[1].parse().unwrap(), words[3].parse().unwrap(), standing.trim().into())
}

#[test]
fn even_light_does_not_tell_how_rough_and_how_specular() {
    for (material, truth) in
        [("plastic it 0 0 5 .6 .4 .2 .1 .2", [0.6, 0.4, 0.2, 0.1, 0.2]), ("metal it 0 0 5 .8 .6 .3 .7 .2", [0.8, 0.6, 0.3, 0.7, 0.2])]
    {
        let (lines, said) = told(material, &format!("{UNIFORM}{BALL}"));
        for (name, truth) in ["red", "green", "blue", "spec", "rough"].iter().zip(truth) {
            let (value, error, standing) = line(&lines, name);
            assert!((value - truth).abs() < 3.0 * error + 0.002, "{name}: {value} ± {error}, not {truth}");
            let doubted = ["spec", "rough"].contains(name);
            if doubted || material.starts_with("metal") {
                assert_eq!(standing.starts_with("not determined"), doubted, "{name}");
            }
            assert!(
                !doubted || said.iter().any(|line| line.contains(name) && line.contains("not determined") && line.contains("a small lamp"))
            );
        }
        // What is said on standard error stands in the file too.
        assert_eq!(lines.iter().filter(|line| line.starts_with("warning: ")).count(), said.len());
    }
}

#[test]
fn of_a_plastic_it_tells_what_colour_and_specularity_make_together() {
    let (lines, _) = told("plastic it 0 0 5 .6 .4 .2 .1 .2", &format!("{UNIFORM}{BALL}"));
    let together = lines.iter().find(|line| line.contains("blue and spec are not determined by themselves, only together: ")).unwrap();
    // Seen from the front everything is reflected: .2 · .9 + .1 = .28.
    let sum: f64 = together.split("blue + ").nth(1).unwrap().split(" = ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((sum - 0.28).abs() < 0.015, "{together}");
}

#[test]
fn of_what_does_not_shine_no_roughness_is_told() {
    let (lines, _) = told("plastic it 0 0 5 .6 .4 .2 0 0", &format!("{UNIFORM}{LAMP}{STILL}"));
    let ((spec, error, _), (_, _, standing)) = (line(&lines, "spec"), line(&lines, "rough"));
    assert!(spec < 3.0 * error && standing == "not determined", "spec {spec} ± {error}, rough: {standing}");
}

#[test]
fn a_lamp_tells() {
    let (lines, said) = told("plastic it 0 0 5 .6 .4 .2 .1 .2", &format!("{UNIFORM}{LAMP}{STILL}"));
    assert!(said.is_empty() && lines.iter().all(|line| !line.contains("not determined")), "{said:?}");
    assert!(lines.iter().any(|line| line.starts_with("correlations: ")), "{lines:?}");
    for (name, truth) in ["red", "green", "blue", "spec", "rough"].iter().zip([0.6, 0.4, 0.2, 0.1, 0.2]) {
        let (value, error, _) = line(&lines, name);
        assert!(error < 0.01 && (value - truth).abs() < 4.0 * error, "{name}: {value} ± {error}, not {truth}");
    }
}

#[test]
fn in_less_time_it_is_less_sure() {
    let scene = format!("{UNIFORM}{LAMP}{STILL}");
    let directory = photographed("plastic it 0 0 5 .6 .4 .2 .1 .2", &scene, "-x 64 -y 64 --spp 64 --seed 5 -ab 2 -o target.hdr");
    let lines = |time: &str| {
        let arguments = format!("-ab 2 {time} --scene scene.rad --target target.hdr start.rad");
        let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), &arguments);
        String::from_utf8(done.stdout).unwrap().lines().filter_map(|l| l.strip_prefix("# ")).map(String::from).collect::<Vec<_>>()
    };
    let (hurried, whole) = (lines("--time .001"), lines(""));
    for (name, truth) in ["red", "green", "blue", "spec", "rough"].iter().zip([0.6, 0.4, 0.2, 0.1, 0.2]) {
        let ((value, error, _), (_, least, _)) = (line(&hurried, name), line(&whole, name));
        assert!(error > least && (value - truth).abs() < 3.0 * error, "{name}: {value} ± {error}, not {truth} ± {least}");
    }
    // Of another type it is doubted even so, however few pixels there was time for.
    let doubted = ["the picture is not what this makes", "whole areas"];
    let told = |time: &str| doubted.iter().any(|doubt| lines(time).iter().any(|line| line.contains(doubt)));
    assert!(!told("--time .001") && told("--time .001 --type glass"));
}

#[test]
fn a_view_that_is_not_the_pictures_is_told() {
    let directory = photographed("plastic it 0 0 5 .6 .4 .2 .1 .2", &format!("{UNIFORM}{BALL}"), "-x 16 -y 16 --spp 4 -o target.hdr");
    let [elsewhere, misshapen, bounces] =
        ["target.hdr says that it was taken from elsewhere (VIEW= ", "each 0.75 times as high as wide by this view", "leave -ab out"];
    for (options, told) in [
        ("-vh 30 -vv 30", vec![elsewhere]),
        ("-vh 26 -vv 26", vec![]),
        ("-vh 26 -vv 19.64", vec![elsewhere, misshapen]),
        ("-vh 26 -vv 26 -ab 1", vec![bounces]),
    ] {
        let arguments = format!("--time .01 --scene scene.rad -vp 0 -5 1 -vd 0 1 -.2 {options} --target target.hdr start.rad");
        let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), &arguments);
        let said = String::from_utf8(done.stderr).unwrap();
        for message in [elsewhere, misshapen, bounces] {
            assert_eq!(said.contains(message), told.contains(&message), "{options}: {message}: {said}");
        }
    }
}

#[test]
fn a_picture_in_another_light_is_doubted() {
    let material = "plastic it 0 0 5 .6 .4 .2 .1 .2";
    let scene = format!("{LAMP}{UNIFORM}{STILL}");
    let doubted =
        |other: &str| told_in(material, &scene, other).0.iter().any(|line| line.starts_with("warning: whole areas of the picture"));
    assert!(!doubted(&scene));
    // The lamp a sixth of its distance to the side; the lamp alone.
    assert!(doubted(&scene.replace("-3 -4 4 .3", "-2.2 -4.4 4 .3")));
    assert!(doubted(&format!("{LAMP}{STILL}")));
}

#[test]
fn so_is_a_small_one_that_a_held_value_does_not_explain() {
    let scene = format!("{LAMP}{UNIFORM}{STILL}");
    let directory = photographed("plastic it 0 0 5 .6 .3 .2 .1 .2", &scene, "-x 24 -y 24 --spp 128 --seed 5 -ab 2 -o target.hdr");
    for (held, doubted) in [("", false), ("--fix green", true)] {
        let arguments = format!("-ab 2 {held} --scene scene.rad --target target.hdr start.rad");
        let done = run(env!("CARGO_BIN_EXE_anneal"), directory.path(), &arguments);
        let said = String::from_utf8(done.stderr).unwrap();
        assert_eq!(said.contains("whole areas of the picture"), doubted, "{said}");
    }
}

/// Of a material that a bound keeps a value from, that bound is named, and the errors of all hold the truth.
fn bounded(material: &str, truth: [f64; 5], bounds: &str, named: &str) {
    let directory = photographed(material, SCENE, "-x 40 -y 40 --spp 300 --seed 5 -ab 1 -o target.exr");
    let out = recovered(directory.path(), &format!("-ab 1 --scene scene.rad --target target.exr --param {bounds} start.rad"));
    assert!(out.contains(&format!("{named}; if it may lie beyond, give --param ")), "{out}");
    for (name, truth) in ["red", "green", "blue", "spec", "rough"].iter().zip(truth) {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error && error < 0.05, "{name}: {value} ± {error}, not {truth}");
    }
}

/// Specularity was 7 standard errors off, and nothing was said of the bound: within so narrow ones not much is determined.
#[test]
fn a_bound_that_keeps_a_value_from_the_truth_is_named_and_errors_hold_it() {
    for (bounds, named) in [("red=.7:.6:.78", "red is at its upper bound 0.78"), ("spec=.6:.5:.68", "spec is at its upper bound 0.68")] {
        bounded("metal it 0 0 5 .8 .6 .4 .7 .12", [0.8, 0.6, 0.4, 0.7, 0.12], bounds, named);
    }
    // Even where all that a roughness may be within its bounds is looked at.
    bounded("plastic it 0 0 5 .6 .3 .2 .05 .1", [0.6, 0.3, 0.2, 0.05, 0.1], "rough=.2:.14:.3", "rough is at its lower bound 0.14");
}

#[test]
fn where_a_renderer_guessed_light_errors_hold_it() {
    let scene = format!("{LAMP}{UNIFORM}{STILL}");
    let directory = photographed("plastic it 0 0 5 .6 .3 .2 .1 .2", &scene, "-x 24 -y 24 --spp 128 --seed 5 -ab 2 -o target.hdr");
    let target = directory.path().join("target.hdr");
    let taken = Picture::read(&std::fs::read(&target).unwrap(), "target.hdr").unwrap();
    let red = |options: &str| {
        let mut picture = taken.clone();
        picture.header.push(&format!("rpict -ab 2 -st 0 -ss 1 -dt 0 {options}"));
        std::fs::write(&target, picture.write_hdr().unwrap()).unwrap();
        let out = recovered(directory.path(), "-ab 2 --scene scene.rad --target target.hdr start.rad");
        assert_eq!(
            out.contains("may be off by 1.6 % too, as what is around it is, or as its renderer left it; "),
            options.is_empty(),
            "{out}"
        );
        said(&out, "red").1
    };
    let (guessed, sampled) = (red(""), red("-aa 0 -as 0"));
    assert!(guessed > 0.0096 && guessed > 2.0 * sampled, "{guessed}, {sampled}");
}
