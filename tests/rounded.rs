//! A pane before plain walls: hardly any noise, and all pixels of a wall alike. A RADIANCE picture rounds them alike too, a dark channel beside a
//! bright one by percents, and no number of pixels averages that out.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};

const SCENE: &str = "void glow sky 0 0 4 .5 .6 .9 0\nsky source above 0 0 4 0 0 1 180\nvoid glow ground 0 0 4 .3 .2 .1 0\n\
                     ground source below 0 0 4 0 0 -1 180\nvoid plastic left 0 0 5 .6 .1 .1 0 0\nvoid plastic right 0 0 5 .1 .2 .6 0 0\n\
                     left polygon l 0 0 12 -4 2 -3 -4 2 3 0 2 3 0 2 -3\nright polygon r 0 0 12 0 2 -3 0 2 3 4 2 3 4 2 -3\n\
                     it polygon pane 0 0 12 -.5 0 -.5 -.5 0 .5 .5 0 .5 .5 0 -.5\n";
const TRUE: [(&str, f64); 3] = [("red", 0.7332), ("green", 0.1248), ("blue", 0.7702)];

/// Values and errors of colours from a photograph of a material in this file.
fn found(material: &str, scene: &str, target: &str) -> [(f64, f64); 3] {
    let directory = photographed(material, scene, &format!("-x 48 -y 48 --spp 1024 -ab 1 -o {target}"));
    let out = recovered(directory.path(), &format!("-ab 1 --scene scene.rad --target {target} start.rad"));
    TRUE.map(|(name, _)| said(&out, name))
}

#[test]
fn errors_hold_the_rounding_of_the_file() {
    let material = format!("glass it 0 0 3 {} {} {}", TRUE[0].1, TRUE[1].1, TRUE[2].1);
    let (rounded, exact) = (found(&material, SCENE, "target.hdr"), found(&material, SCENE, "target.exr"));
    for ((name, truth), (rounded, exact)) in TRUE.into_iter().zip(rounded.into_iter().zip(exact)) {
        for (value, error) in [rounded, exact] {
            assert!((value - truth).abs() < 3.0 * error, "{name}: {value} ± {error}, not {truth}");
        }
    }
    // Green has 20 to 40 steps of the file at most.
    assert!(rounded[1].1 > 4.0 * exact[1].1 && exact[1].1 < 0.004 * TRUE[1].1, "{rounded:?} {exact:?}");
}

/// The file has half a step for what is less than one, in all pixels, however bright they are otherwise.
#[test]
fn what_is_less_than_a_step_may_be_nothing() {
    let lit = "void light lamp 0 0 3 100 90 80\nlamp sphere l 0 0 4 3 -4 5 .2\nit sphere s 0 0 4 0 0 0 1\n";
    let [red, green, blue] = found("metal it 0 0 5 0 0 .8 .6 .2", lit, "target.hdr");
    assert!(red.0 < 2.0 * red.1 && green.0 < 2.0 * green.1 && green.1 < 0.003, "{red:?} {green:?}");
    assert!((blue.0 - 0.8).abs() < 3.0 * blue.1, "{blue:?}");
}

/// In light that is the same from everywhere all pixels are, too: what noise the rendering has did not make the file err to both sides.
#[test]
fn pixels_that_are_alike_were_not_dithered() {
    let even = "void glow sky 0 0 4 1 1 1 0\nsky source all 0 0 4 0 0 1 360\nit sphere ball 0 0 4 0 0 0 1\n";
    let rules = "-ss 1 -ab 2 -lr 10";
    let directory = photographed("metal it 0 0 5 .8 .6 .4 .8 .2", even, &format!("-x 48 -y 48 --spp 64 {rules} -o target.hdr"));
    let out = recovered(directory.path(), &format!("{rules} --seed 3 --scene scene.rad --target target.hdr start.rad"));
    for (name, truth) in [("red", 0.8), ("green", 0.6), ("blue", 0.4)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 2.0 * error, "{name}: {value} ± {error}");
    }
}
