//! Noise that is skewed, as where few samples of a pixel find a small lamp: a little too dark nearly everywhere, and far too bright here and there.
//! What leads astray on the way is a part of the mean in the end, of a photograph and of a rendering.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};
use crate::photograph::waves::SCENE;
use inverad::picture::Picture;
use inverad::sampling::mix64;
use std::fs;

/// By how much of their light most pixels are too dark, and how many of a thousand make up for it.
const LACK: f32 = 0.05;
const BRIGHT: u64 = 20;

#[test]
fn colors_are_not_too_dark_and_errors_are_honest() {
    let directory = photographed("plastic it 0 0 5 .6 .4 .2 .05 .15", SCENE, "-x 64 -y 64 --spp 100 --seed 5 -ab 1 -o target.exr");
    let path = directory.path().join("target.exr");
    let clean = Picture::read(&fs::read(&path).unwrap(), "target.exr").unwrap();
    for draw in 0..3 {
        let mut picture = clean.clone();
        for (n, pixel) in picture.pixels.iter_mut().enumerate() {
            let bright = mix64(1000 * draw + n as u64) % 1000 < BRIGHT;
            let factor = 1.0 - LACK + if bright { LACK * 1000.0 / BRIGHT as f32 } else { 0.0 };
            pixel.iter_mut().for_each(|v| *v *= factor);
        }
        fs::write(&path, picture.write_exr().unwrap()).unwrap();
        let out = recovered(directory.path(), "-ab 1 --scene scene.rad --target target.exr start.rad");
        for (name, truth) in [("red", 0.6), ("green", 0.4), ("blue", 0.2)] {
            let (value, error) = said(&out, name);
            assert!((value - truth).abs() < 3.0 * error && error < 0.05 * truth, "{name}: {value} ± {error}, not {truth}");
        }
    }
}

/// Few samples of what a ball mirrors of the ground find the sun in the ball again. Red was 3.7 standard errors too bright.
#[test]
fn a_rough_mirror_in_the_sun_is_not_too_bright() {
    let scene = "void light sunlight 0 0 3 1e6 1e6 9e5\nsunlight source sun 0 0 4 -.5 -.6 .62 .5\n\
                 void glow skylight 0 0 4 3 4 6 0\nskylight source sky 0 0 4 0 0 1 180\n\
                 void plastic ground 0 0 5 .3 .3 .25 0 0\nground ring r 0 0 8 0 0 -.7 0 0 1 0 20\nit sphere s 0 0 4 0 0 0 .7\n";
    let directory = photographed("metal it 0 0 5 .8 .8 .8 .95 .05", scene, "-vh 22 -vv 22 -x 48 -y 48 --spp 1024 -ab 1 -o target.hdr");
    let out = recovered(directory.path(), "--seed 4 -ab 1 --scene scene.rad --target target.hdr start.rad");
    for (name, truth) in [("red", 0.8), ("green", 0.8), ("blue", 0.8), ("spec", 0.95), ("rough", 0.05)] {
        let (value, error) = said(&out, name);
        assert!((value - truth).abs() < 3.0 * error && error < 0.01, "{name}: {value} ± {error}, not {truth}");
    }
}
