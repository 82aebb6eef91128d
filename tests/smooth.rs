//! Where light hardly changes within a lobe, the picture changes with the square of the roughness, and its derivative is noise: what is said of
//! the roughness, and of the colours that go with it, must hold all the same.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};
use std::fs;
use std::path::Path;

/// A sky with gentle waves, and the ball.
const SCENE: &str = "void brightfunc wave 2 1+.3*sin(9*Dx)*sin(7*Dz+Dy) . 0 0\nwave glow sky 0 0 4 1 1.1 1.2 0\nsky source sky 0 0 4 0 0 1 360\n\
                     it sphere s 0 0 4 0 0 0 1\n";

/// Recovers what is in the directory, and compares it with the truth.
fn check(directory: &Path, seed: u64, truth: &[(&str, f64)]) {
    let out = recovered(directory, &format!("-ab 1 --seed {seed} --scene scene.rad --target target.exr start.rad"));
    for (name, truth) in truth {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error, "{name} {value} ± {error}, not {truth}");
    }
}

#[test]
fn colours_carry_a_roughness_that_light_without_edges_leaves_open() {
    for seed in [1, 2] {
        let view = format!("-x 40 -y 40 --spp 256 --seed {} -ab 1 -o target.exr", 70 + seed);
        let directory = photographed("plastic it 0 0 5 .12 .79 .68 .07 .02", SCENE, &view);
        check(directory.path(), seed, &[("red", 0.12), ("green", 0.79), ("blue", 0.68), ("spec", 0.07), ("rough", 0.02)]);
    }
}

#[test]
fn two_roughnesses_that_it_leaves_open_are_left_open_together() {
    let directory =
        photographed("plastic2 it 4 1 0 0 . 0 6 .4 .5 .2 .06 .05 .15", SCENE, "-x 48 -y 48 --spp 16 --seed 5 -ab 1 -o target.exr");
    fs::write(directory.path().join("start.rad"), "void plastic2 it 4 1 0 0 . 0 6 .5 .5 .5 .1 .1 .1\n").unwrap();
    for seed in [1, 3] {
        check(directory.path(), seed, &[("red", 0.4), ("spec", 0.06), ("urough", 0.05), ("vrough", 0.15)]);
    }
}
