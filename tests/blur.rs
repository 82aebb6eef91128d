//! A picture whose pixels hold light of their neighbours: what filtered it is known from its header, or told, or found.

mod photograph;
#[path = "photograph/said.rs"]
mod said;
#[path = "photograph/waves.rs"]
mod waves;

use inverad::picture::Picture;
use photograph::{photographed, run};
use said::{recovered, said};
use std::fs;
use std::path::Path;
use waves::SCENE;

const RADIUS: f64 = 0.7;
const TRUTH: [(&str, f64); 5] = [("red", 0.8), ("green", 0.6), ("blue", 0.3), ("spec", 0.9), ("rough", 0.03)];

fn filtered() -> tempfile::TempDir {
    let view = format!("-x 64 -y 64 --spp 256 --seed 5 --filter {RADIUS} -ab 1 -o target.hdr");
    photographed("metal it 0 0 5 .8 .6 .3 .9 .03", SCENE, &view)
}

/// What anneal writes and says of the picture.
fn told(directory: &Path, options: &str) -> (String, String) {
    let arguments = format!("-ab 1 --scene scene.rad --target target.hdr {options} start.rad");
    let said = String::from_utf8(run(env!("CARGO_BIN_EXE_anneal"), directory, &arguments).stderr).unwrap();
    (recovered(directory, &arguments), said)
}

fn check(out: &str) {
    for (name, truth) in TRUTH {
        let (value, error) = said(out, name);
        assert!((value - truth).abs() < 3.0 * error, "{name}: {value} ± {error}, not {truth}");
    }
}

#[test]
fn a_header_that_says_how_the_picture_was_filtered_is_believed() {
    let directory = filtered();
    let (out, said) = told(directory.path(), "");
    check(&out);
    assert!(!said.contains("blurred"), "{said}");
}

#[test]
fn a_picture_that_is_blurred_otherwise_is_doubted() {
    let directory = filtered();
    let (out, doubt) = told(directory.path(), "--filter 0");
    let (rough, error) = said(&out, "rough");
    assert!(rough - 0.03 > 5.0 * error, "{rough} ± {error}");
    let radius = doubt.split_once("more blurred").and_then(|(_, rest)| rest.split_once("a filter of radius ")).unwrap().1;
    let radius: f64 = radius.split(' ').next().unwrap().parse().unwrap();
    assert!((radius - RADIUS).abs() < 0.1 * RADIUS, "{radius}");
}

#[test]
fn how_it_was_filtered_is_found() {
    let directory = filtered();
    let path = directory.path().join("target.hdr");
    let mut picture = Picture::read(&fs::read(&path).unwrap(), "target.hdr").unwrap();
    picture.header.lines.retain(|line| line.starts_with("VIEW="));
    fs::write(&path, picture.write_hdr().unwrap()).unwrap();
    let (out, doubt) = told(directory.path(), "--filter auto");
    check(&out);
    let (radius, error) = said(&out, "filter");
    assert!((radius - RADIUS).abs() < 3.0 * error && error < 0.05, "{radius} ± {error}");
    assert!(!doubt.contains("blurred"), "{doubt}");
    // One that is not filtered needs no other.
    let sharp = photographed("metal it 0 0 5 .8 .6 .3 .9 .03", SCENE, "-x 64 -y 64 --spp 256 --seed 5 -ab 1 -o target.hdr");
    let (out, _) = told(sharp.path(), "--filter auto");
    check(&out);
    let (radius, error) = said(&out, "filter");
    assert!((radius - 6f64.sqrt().recip()).abs() < 3.0 * error, "{radius} ± {error}");
}
