//! An unknown that stands behind a pane of glass, or is seen only in a mirror, is recovered as if it stood in the open.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};

const LIGHT: &str = "void brightfunc dim 2 .6+.4*Dz . 0 0\ndim glow g 0 0 4 1 1 1 0\ng source sky 0 0 4 0 0 1 360\n\
                     void light bulb 0 0 3 300 300 300\nbulb sphere lamp 0 0 4 -3 -4 4 .3\n";
/// In front of the camera; the ball is behind it.
const PANE: &str =
    "void glass clear 0 0 3 .8 .9 .7\nclear polygon pane 0 0 12 -2 -2 -2 2 -2 -2 2 -2 2 -2 -2 2\nit sphere s 0 0 4 0 0 0 .8\n";
/// Shows what is behind the camera.
const MIRROR: &str =
    "void mirror silver 0 0 3 .8 .9 .7\nsilver polygon m 0 0 12 -2 0 -2 2 0 -2 2 0 2 -2 0 2\nit sphere s 0 0 4 0 -7 .2 .8\n";

#[test]
fn panes_are_looked_through_and_mirrors_looked_into() {
    let truth = [0.6, 0.4, 0.2, 0.1, 0.2];
    for what in [PANE, MIRROR] {
        let scene = format!("{LIGHT}{what}");
        let directory = photographed("plastic it 0 0 5 .6 .4 .2 .1 .2", &scene, "-x 48 -y 48 --spp 256 --seed 5 -ab 2 -o target.hdr");
        let out = recovered(directory.path(), "-ab 2 --scene scene.rad --target target.hdr start.rad");
        for (name, truth) in ["red", "green", "blue", "spec", "rough"].iter().zip(truth) {
            let (value, error) = said(&out, name);
            assert!((value - truth).abs() < 3.0 * error + 0.002 && error < 0.01, "{what}: {name} {value} ± {error}, not {truth}");
        }
    }
}
