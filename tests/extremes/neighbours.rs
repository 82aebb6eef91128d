//! Where the model is continuous, a parameter moved by 1e-9 does not show: nothing flickers in a search.

use super::table::{Room, Table};
use inverad::geometry::Ray;
use inverad::vector::Vec3;

/// Every type with the words before its numbers, and its numbers: at home, then with some of them near an end.
const MATERIALS: [(&str, &[&[f64]]); 11] = [
    ("plastic m 0 0 5", &[&[0.5, 0.4, 0.3, 0.05, 0.1], &[0.0, 1.0, 1e-9, 0.999999999, 0.0011], &[1.5, 0.1, 1.0, 0.5, 10.0]]),
    ("plastic m 0 0 5", &[&[0.5, 0.4, 0.3, 0.05, 1e-4], &[0.0, 1.0, 0.5, 0.999999999, 0.0]]),
    ("metal m 0 0 5", &[&[0.9, 0.6, 0.2, 0.9, 0.05], &[0.9, 1.0, 0.0, 1.0, 1.0], &[0.9, 0.6, 0.2, 0.3, 0.0]]),
    (
        "trans m 0 0 7",
        &[&[0.8, 0.6, 0.4, 0.05, 0.1, 0.6, 0.4], &[0.8, 0.6, 0.4, 0.5, 0.0, 0.6, 0.4], &[0.8, 1.0, 0.4, 0.05, 0.5, 1.0, 1.0]],
    ),
    ("plastic2 m 4 0 0 1 . 0 6", &[&[0.5, 0.4, 0.3, 0.05, 0.05, 0.2], &[0.5, 0.4, 0.3, 1.0, 10.0, 0.0011]]),
    ("metal2 m 4 0 0 1 . 0 6", &[&[0.5, 0.4, 0.3, 0.05, 0.05, 0.2], &[0.5, 0.4, 0.3, 0.5, 1e-4, 0.2]]),
    ("trans2 m 4 0 0 1 . 0 8", &[&[0.8, 0.6, 0.4, 0.05, 0.1, 0.3, 0.6, 0.5]]),
    ("dielectric m 0 0 5", &[&[0.9, 0.5, 0.1, 1.5, 0.0], &[1.0, 0.0, 1e-30, 1.0, 0.0], &[0.9, 0.5, 0.1, 4.0, 1.0]]),
    ("interface m 0 0 8", &[&[0.9, 0.5, 0.1, 1.5, 0.99, 0.99, 0.99, 1.33]]),
    ("glass m 0 0 4", &[&[0.9, 0.8, 0.7, 1.52], &[0.0, 1.0, 1e-9, 1.0], &[0.9, 0.8, 0.7, 4.0]]),
    ("mirror m 0 0 3", &[&[0.9, 0.8, 0.7], &[0.0, 1.0, 1.5]]),
];

const SCENE: &str = "void glow sky_glow 0 0 4 .3 .3 .3 0\nsky_glow source sky 0 0 4 0 0 1 180\nvoid light lamp 0 0 3 40 30 20\n\
    lamp sphere bulb 0 0 4 2 -1 3 .2\nm sphere ball 0 0 4 0 0 0 1\n";

/// The light of a few rays at a ball, each channel.
fn lights(words: &str, numbers: &[f64]) -> Vec<f64> {
    let numbers: Vec<String> = numbers.iter().map(|v| format!("{v:e}")).collect();
    let room = Room::of(&format!("void {words} {}\n{SCENE}", numbers.join(" ")));
    let eye = Vec3::new(0.3, -6.0, 1.0);
    let rays = (0..36).map(|i| Vec3::new((i % 6) as f64 / 3.0 - 0.8, 0.0, (i / 6) as f64 / 3.0 - 0.8) - eye);
    rays.flat_map(|to| room.light(Ray::new(eye, to.normalize()), 2).to_array()).collect()
}

pub fn fill(table: &mut Table) {
    for (words, places) in MATERIALS {
        for numbers in places {
            let home = lights(words, numbers);
            let sum: f64 = home.iter().sum();
            for (i, &value) in numbers.iter().enumerate() {
                let mut near = numbers.to_vec();
                near[i] = if value == 0.0 { 1e-9 } else { value * (1.0 + 1e-9) };
                let off: f64 = home.iter().zip(lights(words, &near)).map(|(a, b)| (a - b).abs()).sum();
                let kind = words.split(' ').next().unwrap();
                table.near(format!("{kind} {numbers:?}: A{} moved by 1e-9", i + 1), sum, sum + off, 1e-6);
            }
        }
    }
}
