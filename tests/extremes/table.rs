//! The table, and light in scenes that are made for one case.

use inverad::color::Rgb;
use inverad::expand::expand;
use inverad::geometry::Ray;
use inverad::integrator::{Integrator, Radiance};
use inverad::rad::Document;
use inverad::resolve::Files;
use inverad::rules::Rules;
use inverad::sampling::Sampler;
use inverad::scene::{Reading, Scene};
use inverad::vector::Vec3;
use inverad::world::World;

/// Cases of one kind.
pub struct Table {
    title: &'static str,
    rows: Vec<Row>,
}

struct Row {
    case: String,
    expected: String,
    got: f64,
    /// Relative, or absolute where nothing is expected.
    error: f64,
    allowed: f64,
}

impl Row {
    fn holds(&self) -> bool {
        self.error <= self.allowed
    }
}

impl Table {
    pub fn filled(title: &'static str, fill: fn(&mut Self)) -> Self {
        let mut table = Self { title, rows: Vec::new() };
        fill(&mut table);
        table
    }

    /// A case whose answer is known, to a relative (of 0: absolute) error of `allowed`.
    pub fn near(&mut self, case: impl Into<String>, expected: f64, got: f64, allowed: f64) {
        let error = if expected == 0.0 { got.abs() } else { (got - expected).abs() / expected.abs() };
        let expected = format!("{expected:.9e}");
        self.rows.push(Row { case: case.into(), expected, got, error, allowed });
    }

    /// A case whose answer is known to be between these, ends included.
    pub fn within(&mut self, case: impl Into<String>, low: f64, high: f64, got: f64) {
        let error = if (low..=high).contains(&got) { 0.0 } else { f64::INFINITY };
        let expected = format!("{low:e} to {high:e}");
        self.rows.push(Row { case: case.into(), expected, got, error, allowed: 0.0 });
    }

    pub fn count(&self) -> usize {
        self.rows.len()
    }

    pub fn wrong(&self) -> usize {
        self.rows.iter().filter(|row| !row.holds()).count()
    }

    /// A line for each case: case, expected, got, error.
    pub fn text(&self) -> String {
        let mut text = format!("\n{}\n{:<74} {:>24} {:>17} {:>8}\n", self.title, "case", "expected", "got", "error");
        for row in &self.rows {
            let verdict = if row.holds() { String::new() } else { format!("  WRONG: more than {:e}", row.allowed) };
            text += &format!("{:<74} {:>24} {:>17.9e} {:>8.1e}{verdict}\n", row.case, row.expected, row.got, row.error);
        }
        text
    }
}

/// Light of radiance 1 from everywhere.
pub const FURNACE: &str = "void glow e 0 0 4 1 1 1 0\ne source env 0 0 4 0 0 1 360\n";

/// Light of radiance 1 from the half above, z > 0.
pub const ABOVE: &str = "void glow e 0 0 4 1 1 1 0\ne source env 0 0 4 0 0 1 180\n";

/// A scene to look at.
pub struct Room {
    world: World,
    rules: Rules,
}

impl Room {
    /// The scene of a text, with the files it names.
    pub fn with(text: &str, files: &[(&str, &[u8])]) -> Self {
        Self::by(Rules::default(), text, files)
    }

    fn by(rules: Rules, text: &str, files: &[(&str, &[u8])]) -> Self {
        let made = || {
            let files = Files::of(files.iter().copied());
            let flat = expand(vec![Document::read("scene.rad", text.into())?], &files)?;
            World::new(Scene::new(&flat, &files, &Reading::default())?, &rules)
        };
        let world = made().unwrap_or_else(|e| panic!("{e}\n{text}"));
        Self { world, rules }
    }

    /// The same, but that paths of up to twelve reflections are all followed: where nothing is rough, one sample is exact.
    pub fn exact(text: &str) -> Self {
        Self::by(Rules { limit_reflections: Some(12), limit_weight: Some(0.0), ..Rules::default() }, text, &[])
    }

    /// The scene of a text.
    pub fn of(text: &str) -> Self {
        Self::with(text, &[])
    }

    /// The mean of so many samples of the light along a ray; NaN if one of them is negative or no number.
    pub fn light(&self, ray: Ray, samples: u32) -> Rgb {
        let mut integrator = Integrator::new(&self.world, &self.rules);
        let mut sum = Rgb::ZERO;
        for sample in 0..samples {
            let mut light = Radiance { rules: &self.rules, sum: Rgb::ZERO };
            integrator.trace(&mut light, ray, f64::INFINITY, Sampler::new(0, 0, 0, sample));
            sum += if light.sum.is_finite() && light.sum.min_element() >= 0.0 { light.sum } else { Rgb::NAN };
        }
        sum / samples as f64
    }

    /// The green of the light from the origin of the surface z = 0, seen at this cosine from above (below, where it is negative).
    pub fn seen(&self, cos: f64, samples: u32) -> f64 {
        let direction = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, -cos);
        self.light(Ray::new(-direction, direction), samples).y
    }
}

/// A flat surface of a material `m`, z = 0, seen from both sides, and what is around it.
pub fn flat(around: &str, material: &str) -> Room {
    Room::exact(&format!("{around}void {material}\nm ring r 0 0 8 0 0 0 0 0 1 0 1\n"))
}

/// The number next above.
pub fn above(x: f64) -> f64 {
    f64::from_bits(x.to_bits() + 1)
}

/// The number next below.
pub fn below(x: f64) -> f64 {
    f64::from_bits(x.to_bits() - 1)
}
