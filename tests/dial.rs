//! The dial: the error that is told is the true one, what is asked for is delivered, time is kept, and parts join to the whole.

use inverad::color::{Rgb, bright};
use inverad::picture::Picture;
use std::path::Path;
use std::process::{Command, Output};

/// Shiny and dull things under a bright lamp, a dim sky and a wall of light.
const SCENE: &str = "void light bright 0 0 3 20 18 15
void glow dim 0 0 4 1 1.2 1.5 0
void plastic dull 0 0 5 .6 .5 .4 0 0
void plastic shiny 0 0 5 .4 .5 .6 .08 .1
void metal brass 0 0 5 .8 .6 .3 .9 .15
void dielectric glass 0 0 5 .9 .95 .9 1.5 0
dim source sky 0 0 4 0 0 1 360
bright sphere lamp 0 0 4 2 -2 5 1
dull ring floor 0 0 8 0 0 0 0 0 1 0 5
";

/// What stands on the floor in each of the scenes.
const THINGS: [&str; 4] = [
    "dull sphere a 0 0 4 0 0 1 1",
    "shiny sphere a 0 0 4 0 0 1 1",
    "brass sphere a 0 0 4 0 0 1 1",
    "glass sphere a 0 0 4 -.8 0 .7 .7\nbrass cylinder b 0 0 7 .8 0 0 .8 0 1.5 .4",
];

const VIEW: [&str; 14] = ["-vp", "0", "-6", "2.5", "-vd", "0", "6", "-1.8", "-vh", "26", "-vv", "26", "-x", "32"];

fn scene(directory: &Path, thing: usize) -> String {
    let path = directory.join(format!("{thing}.rad"));
    std::fs::write(&path, format!("{SCENE}{}\n", THINGS[thing])).unwrap();
    path.to_str().unwrap().into()
}

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rtrace-rs")).args(arguments).output().unwrap()
}

/// A picture of the scene as `OpenEXR`.
fn picture(scene: &str, options: &[&str]) -> Picture {
    let output = run(&[&VIEW, options, &["--exr", scene]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Picture::read(&output.stdout, "<stdout>").unwrap()
}

fn told(picture: &Picture) -> f64 {
    picture.header.values("NOISE").last().unwrap().trim().parse().unwrap()
}

/// The true error of a picture by a much better one, over the pixels that show a surface.
fn truth(picture: &Picture, better: &Picture, surface: &[bool]) -> f64 {
    let light = |p: &[f32; 3]| bright(Rgb::from(p.map(f64::from)));
    let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
    for ((a, b), _) in picture.pixels.iter().zip(&better.pixels).zip(surface).filter(|(_, s)| **s) {
        squares += (light(a) - light(b)).powi(2);
        sum += light(b);
        count += 1.0;
    }
    (squares / count).sqrt() / (sum / count)
}

#[test]
fn the_error_that_is_told_is_the_true_one_and_what_was_asked_for() {
    let directory = tempfile::tempdir().unwrap();
    let (mut pairs, mut off, mut asked, mut missed) = (0, Vec::new(), 0, Vec::new());
    for thing in 0..THINGS.len() {
        let scene = scene(directory.path(), thing);
        let better = picture(&scene, &["--spp", "2048", "--seed", "99"]);
        // Sky alone does not count.
        let surface: Vec<bool> = ["dull", "shiny", "brass", "glass"].iter().fold(vec![false; better.pixels.len()], |mut all, name| {
            let output = run(&[&VIEW[..], &["--coverage", name, "--exr", &scene]].concat());
            if let Ok(covered) = Picture::read(&output.stdout, "<stdout>") {
                all.iter_mut().zip(covered.pixels).for_each(|(s, c)| *s |= c[0] > 0.0);
            }
            all
        });
        for option in [
            ["--spp", "4"],
            ["--spp", "16"],
            ["--spp", "32"],
            ["--spp", "64"],
            ["--spp", "256"],
            ["--error", ".2"],
            ["--error", ".1"],
            ["--error", ".05"],
            ["--error", ".03"],
            ["--error", ".3"],
        ] {
            let made = picture(&scene, &option);
            let (told, truth) = (told(&made), truth(&made, &better, &surface));
            pairs += 1;
            if !(1.0 / 1.33..=1.33).contains(&(told / truth)) {
                off.push(format!("{} {option:?}: told {told:.4}, true {truth:.4}", THINGS[thing]));
            }
            if option[0] == "--error" {
                let wanted: f64 = option[1].parse().unwrap();
                asked += 1;
                assert!(told <= wanted, "{told} {wanted}");
                if truth > wanted {
                    missed.push(format!("{} {option:?}: true {truth:.4}", THINGS[thing]));
                }
            }
        }
    }
    assert!(off.len() * 20 <= pairs, "of {pairs}:\n{}", off.join("\n"));
    assert!(missed.len() * 20 <= asked, "of {asked}:\n{}", missed.join("\n"));
}

#[test]
fn parts_join_to_the_bytes_of_the_whole() {
    let directory = tempfile::tempdir().unwrap();
    let at = |name: &str| directory.path().join(name).to_str().unwrap().to_string();
    let scene = scene(directory.path(), 3);
    for jitter in ["1", "0"] {
        let options = |which: &[&str], out: &str| {
            let output = run(&[&VIEW[..], &["-pj", jitter], which, &["-o", out, &scene]].concat());
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        };
        options(&["--spp", "41"], &at("whole.exr"));
        let cuts = ["0..3", "3..4", "4..29", "29..41"];
        let parts = cuts.map(|range| at(&format!("{range}.exr")));
        cuts.iter().zip(&parts).for_each(|(range, part)| options(&["-n", "1", "--samples", range], part));
        let joined = |parts: &[&String], out: &str| {
            run(&[&["--merge", "-o", out][..], &parts.iter().map(|p| p.as_str()).collect::<Vec<_>>()].concat())
        };
        for order in [[2, 0, 3, 1], [1, 3, 0, 2]] {
            let output = joined(&order.map(|part| &parts[part]), &at("joined.exr"));
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            assert!(std::fs::read(at("joined.exr")).unwrap() == std::fs::read(at("whole.exr")).unwrap(), "-pj {jitter}, {order:?}");
        }

        let refused = |parts: &[&String], why: &str| {
            let output = joined(parts, &at("no.exr"));
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.code() == Some(2) && said.contains(why), "{said}");
        };
        refused(&[&parts[0], &parts[2]], "the samples 3..4 are in no part");
        refused(&[&parts[1], &parts[2]], "the samples 0..3 are in no part");
        refused(&[&parts[0], &parts[0]], "the samples 0..3 are in another part too");
        refused(&[&parts[0], &at("whole.exr")], "not a part of a picture");
        options(&["--seed", "1", "--samples", "3..41"], &at("other.exr"));
        refused(&[&parts[0], &at("other.exr")], "not of the same picture");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let directory = tempfile::tempdir().unwrap();
    let scene = scene(directory.path(), 2);
    let bytes = |threads: &str| run(&[&VIEW[..], &["--error", ".1", "-n", threads, &scene]].concat()).stdout;
    assert!(!bytes("1").is_empty() && bytes("1") == bytes("2") && bytes("1") == bytes("5"));
}

#[test]
fn time_is_kept() {
    let directory = tempfile::tempdir().unwrap();
    let scene = scene(directory.path(), 3);
    // Time is used, and ends.
    assert!(told(&picture(&scene, &["--time", "1"])) < 0.2);
    // A picture that would take much longer than there is time is coarse, but whole.
    let output = run(&[&VIEW[..12], &["-x", "500", "-y", "500", "--time", ".1", "--exr", &scene]].concat());
    let made = Picture::read(&output.stdout, "<stdout>").unwrap();
    // A sample may find no light, but few do not.
    let dark = made.pixels.iter().filter(|p| p[0] == 0.0).count();
    assert!(dark * 5 < made.pixels.len(), "{dark} of {}", made.pixels.len());
}
