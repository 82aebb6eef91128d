//! Random materials on random shapes in random light: no pixel is negative, none is no number.

use super::table::Room;
use inverad::geometry::Ray;
use inverad::sampling::mix64;
use inverad::vector::Vec3;
use rayon::prelude::*;
use std::time::Instant;

/// Random numbers, the same for the same seed.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix64(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.next() * from.len() as f64) as usize]
    }

    /// One of these ends, or a number between the first and the last.
    fn number(&mut self, ends: &[f64]) -> f64 {
        if self.next() < 0.5 { self.pick(ends) } else { ends[0] + self.next() * (ends[ends.len() - 1] - ends[0]) }
    }

    fn numbers(&mut self, count: usize, ends: &[f64]) -> String {
        (0..count).map(|_| format!(" {:e}", self.number(ends))).collect()
    }

    fn direction(&mut self) -> Vec3 {
        let (z, turn) = (2.0 * self.next() - 1.0, 6.0 * self.next());
        let flat = (1.0 - z * z).sqrt();
        Vec3::new(flat * turn.cos(), flat * turn.sin(), z)
    }
}

const COLORS: [f64; 6] = [0.0, 1e-30, 1e-9, 1.0, 1.5, 1.0];
const PARTS: [f64; 7] = [0.0, 1e-9, 0.0179999, 0.018, 1.0, 1.1, 1.0];
const ROUGHNESSES: [f64; 8] = [0.0, 1e-8, 0.001, 0.0010000000000000002, 0.05, 10.0, 1e6, 1.0];
const ANISOTROPIC: [f64; 5] = [1.0000001e-6, 0.001, 0.05, 10.0, 1.0];
const INDICES: [f64; 8] = [0.2, 0.9999999, 1.0, 1.0000001, 1.5, 4.0, 0.0, 3.0];

fn material(dice: &mut Dice) -> String {
    let orientation = dice.pick(&["1 0 0", "0 0 1", "Nx Ny Nz", "0 0 0"]);
    match (dice.next() * 12.0) as usize {
        kind @ 0..=2 => {
            let (color, part, rough) = (dice.numbers(3, &COLORS), dice.numbers(1, &PARTS), dice.numbers(1, &ROUGHNESSES));
            match kind {
                0 => format!("plastic m 0 0 5{color}{part}{rough}"),
                1 => format!("metal m 0 0 5{color}{part}{rough}"),
                _ => format!("trans m 0 0 7{color}{part}{rough}{}", dice.numbers(2, &PARTS)),
            }
        }
        kind @ 3..=5 => {
            let (color, part, rough) = (dice.numbers(3, &COLORS), dice.numbers(1, &PARTS), dice.numbers(2, &ANISOTROPIC));
            match kind {
                3 => format!("plastic2 m 4 {orientation} . 0 6{color}{part}{rough}"),
                4 => format!("metal2 m 4 {orientation} . 0 6{color}{part}{rough}"),
                _ => format!("trans2 m 4 {orientation} . 0 8{color}{part}{rough}{}", dice.numbers(2, &PARTS)),
            }
        }
        6 | 7 => format!("dielectric m 0 0 5{}{} {}", dice.numbers(3, &COLORS), dice.numbers(1, &INDICES), dice.pick(&[0.0, 0.0, 20.0])),
        8 => {
            let [inside, outside] = [(); 2].map(|()| dice.numbers(3, &COLORS) + &dice.numbers(1, &INDICES));
            format!("interface m 0 0 8{inside}{outside}")
        }
        9 => format!("glass m 0 0 4{}{}", dice.numbers(3, &COLORS), dice.numbers(1, &INDICES)),
        10 => format!("mirror m 0 0 3{}", dice.numbers(3, &COLORS)),
        _ => {
            format!("ashik2 m 4 {orientation} . 0 8{}{}", dice.numbers(6, &[0.0, 0.5, 1.0]), dice.numbers(2, &[0.0, 1e-3, 1e6, 1e9, 10.0]))
        }
    }
}

/// A shape round the origin, of size 1.
fn shape(dice: &mut Dice) -> String {
    let normal = dice.direction();
    let thin = dice.pick(&[1.0, 0.5, 1e-3, 1e-6]);
    match (dice.next() * 8.0) as usize {
        0 | 1 => "sphere s 0 0 4 0 0 0 1".into(),
        2 => "bubble s 0 0 4 0 0 0 1".into(),
        3 => format!("cylinder s 0 0 7 0 0 -1 0 0 1 {thin}"),
        4 => format!("cone s 0 0 8 0 0 -1 0 0 1 {thin} 0"),
        5 => format!("cup s 0 0 8 0 0 -1 0 0 1 1 {thin}"),
        6 => format!("ring s 0 0 8 0 0 0 {} {} {} {} 1", normal.x, normal.y, normal.z, 1.0 - thin),
        _ => format!("polygon s 0 0 9 -1 0 -1 1 {} -1 0 0 1", dice.number(&[0.0, 0.5])),
    }
}

/// A scene, and where a ray at it goes.
fn scene(dice: &mut Dice) -> (String, Ray) {
    let mut text = format!("void {}\nm {}\n", material(dice), shape(dice));
    if dice.next() < 0.8 {
        let angle = if dice.next() < 0.97 { 360 } else { dice.pick(&[180, 60]) };
        text += &format!("void glow g 0 0 4{} 0\ng source sky 0 0 4 0 0 1 {angle}\n", dice.numbers(3, &[0.0, 1e-30, 1e30, 1.0]));
    }
    if dice.next() < 0.5 {
        let (to, angle) = (dice.direction(), dice.pick(&[1e-6, 1e-3, 0.5, 60.0, 179.0]));
        text +=
            &format!("void light l 0 0 3{}\nl source sun 0 0 4 {} {} {} {angle}\n", dice.numbers(3, &[0.0, 1.0, 1e9]), to.x, to.y, to.z);
    }
    if dice.next() < 0.4 {
        let to = dice.direction() * dice.pick(&[1.0001, 1.5, 3.0]);
        let radius = dice.pick(&[1e-6, 0.1, 0.4]);
        let near = dice.pick(&["light n 0 0 3 9 9 9", "glow n 0 0 4 9 9 9 2", "spotlight n 0 0 7 9 9 9 40 0 0 -1"]);
        text += &format!("void {near}\nn sphere near 0 0 4 {} {} {} {radius}\n", to.x, to.y, to.z);
    }
    if dice.next() < 0.5 {
        text += "void plastic p 0 0 5 .9 .5 .1 .05 .1\np ring floor 0 0 8 0 0 -1 0 0 1 0 4\n";
    }
    let (scale, shift) = (dice.pick(&[1.0, 1.0, 1e-6, 1e6]), dice.direction() * dice.pick(&[0.0, 0.0, 1e5]));
    let text = text.replace('\n', "\n    ");
    // Aim at the middle, or so that the ray grazes what is round.
    let aside = dice.pick(&[0.0, 0.5, 0.999, 1.0 - 1e-9, 1.0 - 1e-15]);
    let toward = dice.direction();
    let target = toward.any_orthonormal_vector() * aside;
    let line = format!("!xform -s {scale:e} -t {} {} {} inside.rad\n", shift.x, shift.y, shift.z);
    (format!("{line}%{text}"), Ray::new((target - toward * dice.pick(&[1.5, 4.0])) * scale + shift, toward))
}

/// Looks at so many scenes.
pub fn draw(count: u64) {
    let begin = Instant::now();
    let wrong: Vec<String> = (0..count)
        .into_par_iter()
        .filter_map(|seed| {
            let mut dice = Dice(mix64(seed));
            let (text, ray) = scene(&mut dice);
            let (line, inside) = text.split_once('%').unwrap();
            let looked = std::panic::catch_unwind(|| Room::with(line, &[("inside.rad", inside.as_bytes())]).light(ray, 4));
            let good = looked.is_ok_and(|light| light.is_finite());
            (!good).then(|| format!("scene {seed}: {ray:?}\n{line}{inside}"))
        })
        .collect();
    println!("{count} random scenes in {:.1?}: {} with light that is negative or no number", begin.elapsed(), wrong.len());
    assert!(wrong.is_empty(), "{}", wrong[..wrong.len().min(5)].join("\n"));
}
