//! A photograph whose noise is skewed, as where few samples of a pixel find a small lamp: a little too dark nearly everywhere, and far too bright
//! here and there. What leads astray on the way is a part of the mean in the end.

mod photograph;
#[path = "photograph/said.rs"]
mod said;
#[path = "photograph/waves.rs"]
mod waves;

use inverad::picture::Picture;
use inverad::sampling::mix64;
use photograph::photographed;
use said::{recovered, said};
use std::fs;
use waves::SCENE;

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
