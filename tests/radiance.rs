//! Recorded answers of the real `rtrace`, ray by ray, given by the program itself.
//!
//! `tests/radiance/vectors.json` holds 129 scenes with rays and what RADIANCE 6.0a said: `oconv scene.rad > s.oct; rtrace ARGS -h s.oct < rays`.
//! `fresh.json` holds more of them, made in the same way: every material flat and round, with and without textures, every kind of pattern,
//! mixture and light, whole and in parts, and how they meet. "tolerance" is relative, on each channel; "files" are base64. Vectors with a
//! "fresnel_offset" were made with that constant.

use crate::fed::fed;
use serde_json::Value;
use std::process::Command;

/// Vectors that need primitives which are not rendered: the program must say so.
const NOT_RENDERED: [&str; 1] = ["mist_absorb"];

/// Vectors with samples in them are answered to this error, and compared to five times that.
const SAMPLED: (&str, f64) = ("1e-3", 0.005);

struct Vector<'a>(&'a Value);

impl Vector<'_> {
    fn text(&self, key: &str) -> &str {
        self.0[key].as_str().unwrap_or_default()
    }

    fn rows(&self, key: &str) -> Vec<Vec<f64>> {
        self.0[key].as_array().unwrap().iter().map(|row| row.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()).collect()
    }

    fn sampled(&self) -> bool {
        !self.text("args").contains("-ab 0") || self.text("args").contains("-ss 20000")
    }

    /// What the program says of each ray, or its message.
    fn radiances(&self) -> Result<Vec<Vec<f64>>, String> {
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join("scene.rad"), self.text("scene")).unwrap();
        for (name, content) in self.0["files"].as_object().into_iter().flatten() {
            std::fs::write(directory.path().join(name), base64(content.as_str().unwrap())).unwrap();
        }
        let mut command = Command::new(env!("CARGO_BIN_EXE_rtrace-rs"));
        command.args(self.text("args").split_whitespace()).arg("-h").current_dir(directory.path()).env("RAYPATH", ".");
        if self.sampled() {
            command.args(["--error", SAMPLED.0]);
        }
        if let Some(offset) = self.0["fresnel_offset"].as_f64() {
            command.args(["--fresnel-offset", &offset.to_string()]);
        }
        let rays: String = self.rows("rays").iter().map(|ray| ray.iter().map(|v| format!("{v} ")).collect::<String>() + "\n").collect();
        let output = fed(command.arg("scene.rad"), rays.as_bytes());
        if !output.status.success() {
            return Err(String::from_utf8(output.stderr).unwrap());
        }
        let text = String::from_utf8(output.stdout).unwrap();
        Ok(text.lines().map(|line| line.split_whitespace().map(|v| v.parse().unwrap()).collect()).collect())
    }
}

#[test]
fn every_vector_of_the_real_rtrace() {
    agree(include_str!("radiance/vectors.json"));
}

#[test]
fn what_materials_patterns_and_lights_do_to_each_other() {
    agree(include_str!("radiance/fresh.json"));
}

/// Compares what the program says with what is recorded.
fn agree(recorded: &str) {
    let vectors: Value = serde_json::from_str(recorded).unwrap();
    let mut failures = Vec::new();
    for vector in vectors.as_array().unwrap() {
        let vector = Vector(vector);
        let name = vector.text("name");
        let tolerance = vector.0["tolerance"].as_f64().unwrap().max(if vector.sampled() { SAMPLED.1 } else { 0.0 });
        let found = match vector.radiances() {
            Err(message) if NOT_RENDERED.contains(&name) => {
                assert!(message.contains("is not rendered (") && message.contains("scene.rad:1:6"), "{message}");
                continue;
            }
            Err(message) => {
                failures.push(format!("{name}: {message}"));
                continue;
            }
            Ok(found) => found,
        };
        let wanted = vector.rows("radiance");
        if found.len() != wanted.len() {
            failures.push(format!("{name}: {} answers to {} rays", found.len(), wanted.len()));
        }
        for (i, (found, wanted)) in found.iter().zip(&wanted).enumerate() {
            if !found.iter().zip(wanted).all(|(f, w)| (f - w).abs() <= tolerance * w.abs() + 1e-9) {
                failures.push(format!("{name} ray {i}: {found:?} instead of {wanted:?}"));
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
