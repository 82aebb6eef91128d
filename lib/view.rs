//! A RADIANCE view, and the rays through its picture.
//!
//! A [`View`] is what a person writes (`-vtv -vp 0 0 5 -vh 60`) and a header keeps; made ready it is a [`Camera`]. Picture
//! coordinates run from 0 to 1, x to the right and y up.

use crate::error::{Error, Result};
use crate::geometry::TINY;
use crate::picture::command_words;
use crate::vector::Vec3;
use std::f64::consts::PI;

/// The number of values of a view option, named without its dash, or nothing if there is none of that name. `vt` has its value attached.
pub fn option_values(name: &str) -> Option<usize> {
    match name {
        "vp" | "vd" | "vu" => Some(3),
        "vf" | "vh" | "vv" | "vo" | "va" | "vs" | "vl" => Some(1),
        _ => name.starts_with("vt").then_some(0),
    }
}

/// Programs whose command lines in a header hold view options, and the mark of a line that holds nothing else. What begins so counts.
const VIEW_LINES: [&str; 8] = ["VIEW=", "rpict", "rvu", "rpiece", "rxpiece", "pinterp", "rview", "rtrace-rs"];

/// Views are alike up to so much; their points up to what a header that was typed again may differ by.
const ALIKE: f64 = 0.01;
const SAME: f64 = 1e-3;

/// The largest number of a view: of what is farther the squares overflow.
const FARTHEST: f64 = 1e30;

/// A view as it is written. Lengths are in world units, angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// `-vt`: how directions become places in the picture.
    pub kind: ViewKind,
    /// `-vp`: where it is seen from.
    pub point: Vec3,
    /// `-vd`: where it looks to, of any length but 0.
    pub direction: Vec3,
    /// `-vu`: what is up in the picture, of any length but 0.
    pub up: Vec3,
    /// `-vh`: horizontal size, an angle; for parallel views a length.
    pub horizontal: f64,
    /// `-vv`: vertical size.
    pub vertical: f64,
    /// `-vo`: nothing nearer than this is seen.
    pub fore: f64,
    /// `-va`: nothing farther than this is seen; 0 is no limit.
    pub aft: f64,
    /// `-vs`: by how many widths the picture is shifted to the right.
    pub shift: f64,
    /// `-vl`: by how many heights it is lifted.
    pub lift: f64,
}

/// How directions become places in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewKind {
    /// `v`: perspective, below 180 degrees.
    Perspective,
    /// `l`: parallel.
    Parallel,
    /// `c`: a cylinder around the up vector, unrolled.
    Cylinder,
    /// `h`: a hemisphere seen from far above, at most 180 degrees.
    Hemisphere,
    /// `a`: distance from the centre is the angle from the view direction.
    Angular,
    /// `s`: stereographic, below 360 degrees.
    Planisphere,
}

impl ViewKind {
    /// The letter of `-vt`.
    pub fn letter(self) -> char {
        match self {
            Self::Perspective => 'v',
            Self::Parallel => 'l',
            Self::Cylinder => 'c',
            Self::Hemisphere => 'h',
            Self::Angular => 'a',
            Self::Planisphere => 's',
        }
    }

    /// The kind of that letter.
    pub fn of(letter: char) -> Option<Self> {
        let all = [Self::Perspective, Self::Parallel, Self::Cylinder, Self::Hemisphere, Self::Angular, Self::Planisphere];
        all.into_iter().find(|kind| kind.letter() == letter)
    }
}

impl Default for View {
    /// RADIANCE's: perspective from the origin to +y, 45 degrees.
    fn default() -> Self {
        Self {
            kind: ViewKind::Perspective,
            point: Vec3::ZERO,
            direction: Vec3::Y,
            up: Vec3::Z,
            horizontal: 45.0,
            vertical: 45.0,
            fore: 0.0,
            aft: 0.0,
            shift: 0.0,
            lift: 0.0,
        }
    }
}

impl View {
    /// Applies the options of a command line in their order. `read` gives the bytes of the file that `-vf` names.
    pub fn apply(&mut self, words: &[String], read: &dyn Fn(&str) -> Result<Vec<u8>>) -> Result<()> {
        let mut words = words;
        while let [word, rest @ ..] = words {
            let name = word.strip_prefix('-').unwrap_or_default();
            let Some(count) = option_values(name) else {
                return Err(Error::new(format!("{word} is not a view option")));
            };
            let values: Vec<&str> = rest.iter().take(count).map(String::as_str).collect();
            if name == "vf" {
                let file = values.first().ok_or_else(|| Error::new("-vf needs the name of a file"))?;
                let text = read(file)?;
                if !self.apply_header(header_lines(&String::from_utf8_lossy(&text))) {
                    return Err(Error::new(format!("{file}: no view in this file (a line like VIEW= -vp 0 0 5 -vd 0 0 -1)")));
                }
            } else if !self.option(name, &values) {
                let given = if values.is_empty() { "nothing".into() } else { values.join(" ") };
                return Err(Error::new(match count {
                    0 => format!("{word}: the letter of a view is one of v l c h a s"),
                    1 => format!("{word} needs a number, not {given}"),
                    _ => format!("{word} needs {count} numbers, not {given}"),
                }));
            }
            words = &rest[count.min(rest.len())..];
        }
        Ok(())
    }

    /// Errors as [`Self::apply`] does but for what files hold: none is read, which a pipe would not bear twice.
    pub fn check(words: &[String]) -> Result<()> {
        let usual = Self::default();
        usual.clone().apply(words, &|_| Ok(usual.header_line().into_bytes()))
    }

    /// What header lines say of a view; `None` if they do not, or only of one that was cut or put together since.
    pub fn said<'a>(lines: impl IntoIterator<Item = &'a str>) -> Option<Self> {
        let lines: Vec<&str> = lines.into_iter().collect();
        let since = lines.rsplit(|line| command_words(line).first() == Some(&"pcompos")).next().unwrap_or_default();
        let mut view = Self::default();
        view.apply_header(since.iter().copied()).then_some(view)
    }

    /// Whether it shows about the same as another: no point differs by more than a thousandth of itself, nothing else by more than a hundredth of itself or
    /// of the picture.
    pub fn is_like(&self, other: &Self) -> bool {
        let alike = |a: f64, b: f64| (a - b).abs() <= ALIKE * a.abs().max(b.abs());
        self.kind == other.kind
            && self.point.distance(other.point) <= SAME * self.point.length()
            && self.direction.angle_between(other.direction) <= ALIKE
            && self.direction.cross(self.up).angle_between(other.direction.cross(other.up)) <= ALIKE
            && alike(self.horizontal, other.horizontal)
            && alike(self.vertical, other.vertical)
            && (self.shift - other.shift).abs() <= ALIKE
            && (self.lift - other.lift).abs() <= ALIKE
    }

    /// Applies, in their order, all view options in header lines that hold some; tells whether there was one. Words that are no view
    /// options are passed over.
    pub fn apply_header<'a>(&mut self, lines: impl IntoIterator<Item = &'a str>) -> bool {
        let mut found = false;
        for line in lines.into_iter().filter(|line| is_view_line(line)) {
            let words: Vec<&str> = line.split_whitespace().collect();
            let mut at = 0;
            while at < words.len() {
                let name = words[at].strip_prefix('-').unwrap_or_default();
                let count = option_values(name).unwrap_or(0);
                let values = &words[at + 1..words.len().min(at + 1 + count)];
                let applied = self.option(name, values);
                at += if applied { 1 + count } else { 1 };
                found |= applied;
            }
        }
        found
    }

    /// The line of a header that keeps this view, exactly.
    pub fn header_line(&self) -> String {
        let [p, d, u] = [self.point, self.direction, self.up].map(|v| format!("{} {} {}", v.x, v.y, v.z));
        let Self { horizontal, vertical, fore, aft, shift, lift, .. } = self;
        let kind = self.kind.letter();
        format!("VIEW= -vt{kind} -vp {p} -vd {d} -vu {u} -vh {horizontal} -vv {vertical} -vo {fore} -va {aft} -vs {shift} -vl {lift}")
    }

    /// The camera of this view. Errors say what is impossible about it.
    pub fn ready(&self) -> Result<Camera> {
        let fails = |message: String| Err(Error::new(message));
        let vectors = [("-vp", self.point), ("-vd", self.direction), ("-vu", self.up)].map(|(option, v)| (option, v.abs().max_element()));
        let Self { horizontal, vertical, fore, aft, shift, lift, .. } = *self;
        let numbers = [("-vh", horizontal), ("-vv", vertical), ("-vo", fore), ("-va", aft), ("-vs", shift), ("-vl", lift)];
        if let Some((option, number)) = vectors.into_iter().chain(numbers).find(|(_, number)| number.abs() > FARTHEST) {
            return fails(format!("{option} {number:e}: the numbers of a view go up to {FARTHEST:e}"));
        }
        if self.fore < -TINY || self.aft < -TINY || (self.aft > TINY && self.aft <= self.fore) {
            return fails(format!(
                "-vo {} -va {}: neither may be negative, and the aft plane must lie behind the fore plane",
                self.fore, self.aft
            ));
        }
        let (Some(forward), Some(up)) = (self.direction.try_normalize(), self.up.try_normalize()) else {
            return fails("-vd and -vu must not be 0 0 0".into());
        };
        let right = forward.cross(up);
        let Some(right) = right.try_normalize().filter(|_| right.length() > 1e-12) else {
            return fails("-vd and -vu are parallel; give another -vu".into());
        };
        let most = |option: &str, size: f64, limit: f64, inclusive: bool| {
            if size > TINY && (size < limit || inclusive && size == limit) {
                return Ok(());
            }
            let bound = match limit {
                f64::INFINITY => String::new(),
                _ => format!(" and {} {limit}", if inclusive { "at most" } else { "below" }),
            };
            Err(Error::new(format!("{option} {size}: must be above 0{bound} for -vt{}", self.kind.letter())))
        };
        let (wide, wide_inclusive, high, high_inclusive) = match self.kind {
            ViewKind::Perspective => (180.0, false, 180.0, false),
            ViewKind::Parallel => (f64::INFINITY, false, f64::INFINITY, false),
            ViewKind::Cylinder => (360.0, true, 180.0, false),
            ViewKind::Hemisphere => (180.0, true, 180.0, true),
            ViewKind::Angular => (360.0, true, 360.0, true),
            ViewKind::Planisphere => (360.0, false, 360.0, false),
        };
        most("-vh", self.horizontal, wide, wide_inclusive)?;
        most("-vv", self.vertical, high, high_inclusive)?;
        let (h, v) = (self.horizontal.to_radians(), self.vertical.to_radians());
        let flat = |angle: f64| 2.0 * (angle / 2.0).tan();
        let (width, height) = match self.kind {
            ViewKind::Perspective => (flat(h), flat(v)),
            ViewKind::Parallel => (self.horizontal, self.vertical),
            ViewKind::Cylinder => (h, flat(v)),
            ViewKind::Hemisphere => (2.0 * (h / 2.0).sin(), 2.0 * (v / 2.0).sin()),
            ViewKind::Angular => (h, v),
            ViewKind::Planisphere => (flat(h / 2.0), flat(v / 2.0)),
        };
        Ok(Camera { view: self.clone(), forward, right, up: right.cross(forward), width, height })
    }

    /// Applies one option, or says no because there is no such option or a value is not a number.
    fn option(&mut self, name: &str, values: &[&str]) -> bool {
        if let Some(kind) = name.strip_prefix("vt") {
            let mut letters = kind.chars();
            let (Some(letter), None) = (letters.next(), letters.next()) else { return false };
            return ViewKind::of(letter).map(|kind| self.kind = kind).is_some();
        }
        let numbers: Option<Vec<f64>> = values.iter().map(|v| v.parse().ok().filter(|v: &f64| v.is_finite())).collect();
        match (name, numbers.as_deref()) {
            ("vp", Some(&[x, y, z])) => self.point = Vec3::new(x, y, z),
            ("vd", Some(&[x, y, z])) => self.direction = Vec3::new(x, y, z),
            ("vu", Some(&[x, y, z])) => self.up = Vec3::new(x, y, z),
            ("vh", Some(&[size])) => self.horizontal = size,
            ("vv", Some(&[size])) => self.vertical = size,
            ("vo", Some(&[distance])) => self.fore = distance,
            ("va", Some(&[distance])) => self.aft = distance,
            ("vs", Some(&[widths])) => self.shift = widths,
            ("vl", Some(&[heights])) => self.lift = heights,
            _ => return false,
        }
        true
    }
}

/// A view made ready: where the ray through each place of the picture begins and goes.
#[derive(Clone, Debug)]
pub struct Camera {
    view: View,
    /// Unit vectors: into the picture, to its right, to its top.
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    /// The size of the picture in the units of its projection.
    width: f64,
    height: f64,
}

impl Camera {
    /// The distance `|-vd|`, at which a lens would focus.
    pub fn focus(&self) -> f64 {
        self.view.direction.length()
    }

    /// Unit vectors into the picture, to its right, to its top; and whether it is flat, so that depth counts from its plane.
    pub fn axes(&self) -> ([Vec3; 3], bool) {
        ([self.forward, self.right, self.up], matches!(self.view.kind, ViewKind::Perspective | ViewKind::Parallel))
    }

    /// Width and height in pixels of the largest picture that fits into `x_max` × `y_max` with pixels of that aspect (height over
    /// width). With aspect 0 pixels take what shape they must.
    pub fn resolution(&self, x_max: usize, y_max: usize, aspect: f64) -> (usize, usize) {
        let (x, y, shape) = (x_max as f64, y_max as f64, self.height / self.width);
        if aspect <= TINY {
            (x_max, y_max)
        } else if shape * x > aspect * y {
            (((y / shape * aspect + 0.5) as usize).max(1), y_max)
        } else {
            (x_max, ((x * shape / aspect + 0.5) as usize).max(1))
        }
    }

    /// Height over width of a pixel in a picture of that many pixels.
    pub fn pixel_aspect(&self, width: usize, height: usize) -> f64 {
        self.height / self.width * width as f64 / height as f64
    }

    /// The ray through the place (x, y) of the picture, 0 to 1 from its lower left corner: origin, unit direction, and how far
    /// it sees (infinite without an aft plane). `None` where the projection shows nothing.
    pub fn ray(&self, x: f64, y: f64) -> Option<(Vec3, Vec3, f64)> {
        let View { point, fore, aft, .. } = self.view;
        let x = (x - 0.5 + self.view.shift) * self.width;
        let y = (y - 0.5 + self.view.lift) * self.height;
        let (direction, origin) = match self.view.kind {
            ViewKind::Perspective => (self.forward + x * self.right + y * self.up, point),
            ViewKind::Parallel => (self.forward, point + x * self.right + y * self.up),
            ViewKind::Cylinder => (x.cos() * self.forward + x.sin() * self.right + y * self.up, point),
            ViewKind::Hemisphere => {
                let z = 1.0 - x * x - y * y;
                if z < 0.0 {
                    return None;
                }
                (z.sqrt() * self.forward + x * self.right + y * self.up, point)
            }
            ViewKind::Angular => {
                let angle = x.hypot(y);
                if angle > PI {
                    return None;
                }
                // sin θ / θ, which is 1 in the centre.
                let spread = if angle <= TINY { 1.0 } else { angle.sin() / angle };
                (angle.cos() * self.forward + spread * (x * self.right + y * self.up), point)
            }
            ViewKind::Planisphere => {
                let square = x * x + y * y;
                let z = (1.0 - square) / (1.0 + square);
                (z * self.forward + (1.0 + z) * (x * self.right + y * self.up), point)
            }
        };
        // The fore and aft planes are planes for flat pictures and cylinders for round ones: distances are along the direction
        // as it is before it is made a unit vector.
        let length = direction.length();
        let limit = if aft > TINY { (aft - fore) * length } else { f64::INFINITY };
        Some((origin + fore * direction, direction / length, limit))
    }
}

/// The lines of a text that is read like a header: up to the first empty line.
fn header_lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines().take_while(|line| !line.is_empty())
}

/// Whether the first word, without a path, begins like the name of a program that has a view, or with the mark of views.
fn is_view_line(line: &str) -> bool {
    let word = line.split(' ').next().unwrap_or_default();
    let word = word.rsplit('/').next().unwrap_or_default();
    VIEW_LINES.iter().any(|start| word.starts_with(start))
}
