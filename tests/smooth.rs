//! Where light hardly changes within a lobe, the picture changes with the square of the roughness, and its derivative is noise: what is said of
//! the roughness, and of the colours that go with it, must hold all the same.

mod photograph;
#[path = "photograph/said.rs"]
mod said;

use photograph::photographed;
use said::{recovered, said};

/// A sky with gentle waves, and the ball.
const SCENE: &str = "void brightfunc wave 2 1+.3*sin(9*Dx)*sin(7*Dz+Dy) . 0 0\nwave glow sky 0 0 4 1 1.1 1.2 0\nsky source sky 0 0 4 0 0 1 360\n\
                     it sphere s 0 0 4 0 0 0 1\n";

#[test]
fn colours_carry_a_roughness_that_light_without_edges_leaves_open() {
    for seed in [1, 2] {
        let view = format!("-x 40 -y 40 --spp 256 --seed {} -ab 1 -o target.exr", 70 + seed);
        let directory = photographed("plastic it 0 0 5 .12 .79 .68 .07 .02", SCENE, &view);
        let look = format!("-ab 1 --seed {seed} --scene scene.rad --target target.exr start.rad");
        let out = recovered(directory.path(), &look);
        for (name, truth) in [("red", 0.12), ("green", 0.79), ("blue", 0.68), ("spec", 0.07), ("rough", 0.02)] {
            let (value, error) = said(&out, name);
            assert!((value - truth).abs() < 3.0 * error, "{name} {value} ± {error}, not {truth}");
        }
    }
}
