//! A picture whose pixels hold light of their neighbours: what filtered it is known from its header, or told, or found.

use crate::photograph::said::{recovered, said};
use crate::photograph::waves::SCENE;
use crate::photograph::{photographed, run};
use inverad::picture::Picture;
use inverad::render::Filter;
use std::fs;
use std::path::Path;

const RADIUS: f64 = 0.7;
const TRUTH: [(&str, f64); 5] = [("red", 0.8), ("green", 0.6), ("blue", 0.3), ("spec", 0.9), ("rough", 0.03)];

fn filtered(radius: f64, samples: u32) -> tempfile::TempDir {
    let view = format!("-x 64 -y 64 --spp {samples} --seed 5 --filter {radius} -ab 1 -o target.hdr");
    photographed("metal it 0 0 5 .8 .6 .3 .9 .03", SCENE, &view)
}

fn arguments(options: &str) -> String {
    format!("-ab 1 --scene scene.rad --target target.hdr {options} start.rad")
}

/// What anneal writes and says of the picture.
fn told(directory: &Path, options: &str) -> (String, String) {
    let done = run(env!("CARGO_BIN_EXE_anneal"), directory, &arguments(options));
    let [out, said] = [done.stdout, done.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    println!("{out}{said}");
    (out, said)
}

/// The picture that `pfilt -1 -r radius -x /3 -y /3` makes of a larger one.
fn reduced(large: &Picture, radius: f64) -> Picture {
    let (width, height) = (large.width / 3, large.height / 3);
    let mut header = large.header.clone();
    header.push(&format!("pfilt -1 -r {radius} -x /3 -y /3"));
    let pixel = |n: usize| {
        let (x, y) = ((3 * (n % width) + 1) as i32, (3 * (n / width) + 1) as i32);
        let reach = (6.0 * radius) as i32 + 1;
        let (mut sum, mut whole) = ([0.0; 3], 0.0);
        for v in (y - reach).max(0)..=(y + reach).min(large.height as i32 - 1) {
            for u in (x - reach).max(0)..=(x + reach).min(large.width as i32 - 1) {
                let weight = (-((u - x).pow(2) + (v - y).pow(2)) as f64 / (9.0 * radius * radius)).exp();
                let value = large.pixels[v as usize * large.width + u as usize];
                (0..3).for_each(|c| sum[c] += weight * f64::from(value[c]));
                whole += weight;
            }
        }
        sum.map(|s| (s / whole) as f32)
    };
    Picture { width, height, header, pixels: (0..width * height).map(pixel).collect() }
}

fn check(out: &str) {
    for (name, truth) in TRUTH {
        let (value, error) = said(out, name);
        assert!((value - truth).abs() < 3.0 * error && error < 0.01, "{name}: {value} ± {error}, not {truth}");
    }
}

#[test]
fn a_header_that_says_how_the_picture_was_filtered_is_believed() {
    let directory = filtered(RADIUS, 256);
    let (out, said) = told(directory.path(), "");
    check(&out);
    assert!(!said.contains("blurred"), "{said}");
}

#[test]
fn a_picture_that_is_blurred_otherwise_is_doubted() {
    let directory = filtered(RADIUS, 256);
    let (out, doubt) = told(directory.path(), "--filter 0");
    let (rough, error) = said(&out, "rough");
    assert!(rough - 0.03 > 5.0 * error, "{rough} ± {error}");
    let radius = doubt.split_once("more blurred").and_then(|(_, rest)| rest.split_once("a filter of radius ")).unwrap().1;
    let radius: f64 = radius.split(' ').next().unwrap().parse().unwrap();
    assert!((radius - RADIUS).abs() < 0.1 * RADIUS, "{radius}");
}

#[test]
fn how_it_was_filtered_is_found() {
    let directory = filtered(RADIUS, 256);
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
    assert!((radius - Filter::radius(1.0 / 12.0)).abs() < 3.0 * error, "{radius} ± {error}");
}

#[test]
fn no_round_takes_its_values_for_exact() {
    // Where the errors of the rendering seem to be more than there are in all, none are left for the photograph to spread, but not fewer.
    let directory = filtered(2.0, 512);
    recovered(directory.path(), &arguments("--log rounds.jsonl"));
    for line in fs::read_to_string(directory.path().join("rounds.jsonl")).unwrap().lines() {
        let round: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(round["errors"].as_object().unwrap().values().all(|error| error.as_f64().unwrap() > 0.0), "{line}");
    }
}

/// A picture of few samples, made smaller by a filter of this radius.
fn noisy(material: &str, radius: f64, seed: u64) -> tempfile::TempDir {
    let directory = photographed(material, SCENE, &format!("-x 192 -y 192 --spp 1 --seed {seed} -ab 1 -o target.hdr"));
    let path = directory.path().join("target.hdr");
    let large = Picture::read(&fs::read(&path).unwrap(), "target.hdr").unwrap();
    fs::write(&path, reduced(&large, radius).write_hdr().unwrap()).unwrap();
    directory
}

#[test]
fn noise_that_neighbours_share_is_not_taken_for_another_light() {
    for seed in 1..4 {
        let out = recovered(noisy("metal it 0 0 5 .95 .93 .88 .95 .3", 0.6, seed).path(), &arguments(""));
        assert!(!out.contains("whole areas"), "{out}");
    }
}

#[test]
fn another_light_is_told_however_wide_the_filter() {
    let lamp = |x: f64| format!("void light bulb 0 0 3 100 100 100\nbulb sphere lamp 0 0 4 {x} -3 4 .2\nit sphere s 0 0 4 0 0 0 1\n");
    for radius in [0.0, 2.2, 3.0] {
        let view = format!("-x 96 -y 96 --spp 16 --filter {radius} -ab 0 -av .1 .1 .1 -o target.hdr");
        let directory = photographed("plastic it 0 0 5 .6 .4 .2 .05 .15", &lamp(-3.0), &view);
        fs::write(directory.path().join("scene.rad"), lamp(3.0)).unwrap();
        let out = recovered(directory.path(), "--scene scene.rad --target target.hdr start.rad");
        assert!(out.contains("whole areas") && out.contains("# red") && said(&out, "red").1 > 0.05, "{radius}: {out}");
    }
}

#[test]
fn errors_hold_the_noise_that_neighbours_share() {
    let (mut squares, mut count) = (0.0, 0);
    for seed in 1..5 {
        let out = recovered(noisy("metal it 0 0 5 .8 .6 .3 .9 .03", 1.0, seed).path(), &arguments(""));
        for (name, truth) in TRUTH {
            let (value, error) = said(&out, name);
            squares += ((value - truth) / error).powi(2);
            count += 1;
        }
    }
    // Taken for independent, they are 2.6 times too small.
    let off = (squares / f64::from(count)).sqrt();
    assert!((0.5..1.5).contains(&off), "{off}");
}
