//! The highlight of a small lamp is a few pixels, and all that tells specularity and roughness: none of these is one pixel too many.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};

const SCENE: &str = "void light bulb 0 0 3 100 100 100\nbulb sphere lamp 0 0 4 3 -3 4 .2\nit sphere s 0 0 4 0 0 0 1\n";

/// Of what single pixels made of it little was left: a roughness of .10 ± .11, "not determined".
#[test]
fn what_few_pixels_tell_is_determined() {
    let light = "-ab 0 -av .1 .1 .1";
    let view = format!("-vp 0 -5 0 -vd 0 1 0 -vh 30 -vv 30 -x 32 -y 32 --spp 1024 {light} -o target.hdr");
    let directory = photographed("plastic it 0 0 5 .6 .3 .1 .06 .1", SCENE, &view);
    for seed in [2, 4] {
        let out = recovered(directory.path(), &format!("--seed {seed} {light} --scene scene.rad --target target.hdr start.rad"));
        assert!(!out.contains("warning"), "{out}");
        for (name, truth) in [("red", 0.6), ("green", 0.3), ("blue", 0.1), ("spec", 0.06), ("rough", 0.1)] {
            let (value, error) = said(&out, name);
            assert!((value - truth).abs() < 3.0 * error && error < 0.004, "{name}: {value} ± {error}, not {truth}");
        }
    }
}
