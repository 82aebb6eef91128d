//! Recorded answers of the real `rtrace`, ray by ray.
//!
//! `tests/radiance/vectors.json` holds 129 scenes with rays and what RADIANCE 6.0a said: `oconv scene.rad > s.oct; rtrace ARGS -h s.oct < rays`.
//! "tolerance" is relative, on each channel; "files" are base64. Vectors with a "fresnel_offset" were made with that constant.

use inverad::args::rtrace::Arguments;
use inverad::args::{Typed, parse};
use inverad::color::Rgb;
use inverad::error::Result;
use inverad::rad::Document;
use inverad::render::{Budget, Task, render};
use inverad::resolve::Files;
use inverad::scene::Scene;
use inverad::vector::Vec3;
use inverad::world::World;
use serde_json::Value;

/// Vectors that need primitives which are not rendered yet.
const NOT_YET: [&str; 2] = ["irradiance_I", "mist_absorb"];

/// Vectors that RADIANCE answers by an approximation of its own: the converged value is compared instead.
const APPROXIMATE: [&str; 1] = ["polygon_light_ds.02"];

struct Vector<'a>(&'a Value);

impl Vector<'_> {
    fn text(&self, key: &str) -> &str {
        self.0[key].as_str().unwrap_or_default()
    }

    fn rows(&self, key: &str) -> Vec<Vec<f64>> {
        self.0[key].as_array().unwrap().iter().map(|row| row.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()).collect()
    }

    /// What the library says of each ray.
    fn radiances(&self) -> Result<Vec<Rgb>> {
        let mut words = vec!["rtrace-rs".to_string()];
        words.extend(self.text("args").split_whitespace().map(str::to_string));
        if let Some(offset) = self.0["fresnel_offset"].as_f64() {
            words.extend(["--fresnel-offset".into(), offset.to_string()]);
        }
        words.push("scene.rad".into());
        let Typed::Run(arguments, _) = parse::<Arguments>(words.into_iter().map(Into::into).collect(), &|_| unreachable!())? else {
            unreachable!()
        };
        let rules = arguments.light.rules(&|_| unreachable!())?;
        let mut files = Files::default();
        for (name, content) in self.0["files"].as_object().into_iter().flatten() {
            files.0.insert(name.clone(), base64(content.as_str().unwrap()));
        }
        let document = Document::read("scene.rad", self.text("scene").as_bytes().to_vec())?;
        let flat = inverad::expand::expand(vec![document], &files)?;
        let world = World::new(Scene::new(&flat, &files, false)?, &rules)?;
        let rays = self.rows("rays");
        let lens = |i: usize, _: [f64; 2]| {
            Some((Vec3::new(rays[i][0], rays[i][1], rays[i][2]), Vec3::new(rays[i][3], rays[i][4], rays[i][5]).normalize(), f64::INFINITY))
        };
        let task = Task { world: &world, rules: &rules, count: rays.len(), lens: &lens, jitter: 0.0, budget: Budget::Error(1e-3), seed: 0 };
        let rendering = render(&task, &mut |_| true);
        Ok(rendering.pixels.iter().map(|p| p.mean()).collect())
    }
}

#[test]
fn every_vector_of_the_real_rtrace() {
    let vectors: Value = serde_json::from_str(include_str!("radiance/vectors.json")).unwrap();
    let mut failures = Vec::new();
    for vector in vectors.as_array().unwrap() {
        let vector = Vector(vector);
        let name = vector.text("name");
        if NOT_YET.contains(&name) || APPROXIMATE.contains(&name) {
            continue;
        }
        let sampled = !vector.text("args").contains("-ab 0") || vector.text("args").contains("-ss 20000");
        let tolerance = vector.0["tolerance"].as_f64().unwrap().max(if sampled { 0.005 } else { 0.0 });
        match vector.radiances() {
            Err(error) => failures.push(format!("{name}: {error}")),
            Ok(found) => {
                for (i, (found, wanted)) in found.iter().zip(vector.rows("radiance")).enumerate() {
                    let wanted = Rgb::new(wanted[0], wanted[1], wanted[2]);
                    let off = ((*found - wanted).abs() - Rgb::splat(1e-9)).max(Rgb::ZERO) / wanted.abs().max(Rgb::splat(1e-30));
                    if !(off.max_element() <= tolerance) {
                        failures.push(format!("{name} ray {i}: {found} instead of {wanted}"));
                    }
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}

fn base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (mut out, mut bits, mut count) = (Vec::new(), 0u32, 0);
    for byte in text.bytes() {
        let Some(digit) = DIGITS.iter().position(|&d| d == byte) else { continue };
        bits = bits << 6 | digit as u32;
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    out
}
