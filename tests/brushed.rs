//! anneal recovers two roughnesses from a start at which they are the same.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};
use std::fs;

#[test]
fn a_start_without_direction_does_not_lose_it() {
    let scene = "void glow even 0 0 4 .3 .3 .3 0\neven source sky 0 0 4 0 0 1 360\nvoid light bulb 0 0 3 300 300 300\n\
                 bulb sphere lamp 0 0 4 -3 -4 4 .3\nit sphere s 0 0 4 0 0 0 1\n";
    let directory =
        photographed("plastic2 it 4 .3 .2 1 . 0 6 .5 .3 .2 .1 .08 .25", scene, "-x 48 -y 48 --spp 256 --seed 5 -ab 1 -o target.hdr");
    let path = directory.path();
    fs::write(path.join("start.rad"), "void plastic2 it 4 .3 .2 1 . 0 6 .5 .5 .5 .1 .15 .15\n").unwrap();
    let out = recovered(path, "-q -ab 1 --scene scene.rad --target target.hdr start.rad");
    let value = |name: &str| said(&out, name).0;
    assert!((value("urough") - 0.08).abs() < 0.01 && (value("vrough") - 0.25).abs() < 0.02, "{out}");
}
