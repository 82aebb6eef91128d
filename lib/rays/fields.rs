//! What `-o` and `-p` name: the fields of a record, the colours in it, and how they are written.

use super::Form;
use crate::color::{Rgb, WHITE_EFFICACY};
use crate::error::{Error, Result};
use crate::expand::printf;
use crate::picture::{hdr, rgb_to_xyz};
use crate::rad::encode;
use crate::vector::Vec3;
use std::collections::HashSet;

/// What is said of each ray.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fields {
    /// The fields of the ray itself.
    pub ray: Vec<Field>,
    /// The fields of every ray that it leads to; none are said if there are none.
    pub every: Vec<Field>,
    /// Whether shadow rays are among them.
    pub shadows: bool,
    /// The modifiers of what those rays must have met (true), or must not (false).
    pub among: Option<(bool, HashSet<String>)>,
    /// What must be found out for the fields of the ray itself.
    pub needs: Needs,
}

/// What must be found out to tell of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// What it meets first.
    pub first: bool,
    /// More of that than where it is.
    pub known: bool,
    /// What the surface there is made of.
    pub layers: bool,
    /// The light that it brings.
    pub light: bool,
    /// Mirrored and unmirrored light, told apart.
    pub branches: bool,
}

impl Needs {
    fn of(fields: &[Field]) -> Self {
        use Field::*;
        let any = |among: &[Field]| fields.iter().any(|f| among.contains(f));
        let known = any(&[Normal, Unperturbed, Surface, Modifier, Material]);
        let layers = any(&[Normal, Local]);
        Self {
            first: known || layers || any(&[Length, Point]),
            known,
            layers,
            light: any(&[Value, Contribution]),
            branches: any(&[Effective, Mirrored, MirroredLength, Unmirrored, UnmirroredLength]),
        }
    }
}

/// A field of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// `o`
    Origin,
    /// `d`
    Direction,
    /// `v`
    Value,
    /// `V`
    Contribution,
    /// `w`
    Weight,
    /// `W`
    Coefficient,
    /// `l`
    Effective,
    /// `L`
    Length,
    /// `c`
    Local,
    /// `p`
    Point,
    /// `n`
    Normal,
    /// `N`
    Unperturbed,
    /// `s`
    Surface,
    /// `m`
    Modifier,
    /// `M`
    Material,
    /// `r`
    Mirrored,
    /// `R`
    MirroredLength,
    /// `x`
    Unmirrored,
    /// `X`
    UnmirroredLength,
    /// `~`
    Tilde,
}

impl Fields {
    /// What the letters of `-o` mean, with answers in this form.
    pub fn of(letters: &str, output: Form) -> Result<Self> {
        let (mut ray, mut every, mut shadows) = (Vec::new(), None, false);
        for (i, letter) in letters.char_indices() {
            match letter {
                't' | 'T' => {
                    shadows |= letter == 'T';
                    if i + 1 < letters.len() {
                        every.get_or_insert_default();
                    }
                }
                _ => {
                    let Some(field) = Field::of(letter) else {
                        return Err(Error::new(format!("-o{letters}: there is no field `{letter}` (--help lists all)")));
                    };
                    every.as_mut().unwrap_or(&mut ray).push(field);
                }
            }
        }
        let every = every.unwrap_or_default();
        if ray.is_empty() && every.is_empty() {
            return Err(Error::new("-o: name at least one field, as in -ov"));
        }
        let color = |f: &Field| matches!(f, Field::Value | Field::Mirrored | Field::Unmirrored);
        if output == Form::Color && !(every.is_empty() && ray.len() == 1 && color(&ray[0])) {
            return Err(Error::new("answers are colours (-f…c) with -ov, -or or -ox alone; write numbers with -ff, -fd or -fa"));
        }
        Ok(Self { needs: Needs::of(&ray), ray, every, shadows, among: None })
    }

    /// Whether a ray that met this modifier, or nothing, is told of.
    pub fn tells_of(&self, modifier: Option<&str>) -> bool {
        match (&self.among, modifier) {
            (None, _) => true,
            (Some((included, _)), None) => !included,
            (Some((included, names)), Some(modifier)) => names.contains(modifier) == *included,
        }
    }

    /// How many numbers and names a record has; `None` if that differs from ray to ray.
    pub fn count(&self, space: Space) -> Option<usize> {
        self.every.is_empty().then(|| self.ray.iter().map(|f| f.count(space)).sum())
    }
}

impl Field {
    fn of(letter: char) -> Option<Self> {
        Some(match letter {
            'o' => Self::Origin,
            'd' => Self::Direction,
            'v' => Self::Value,
            'V' => Self::Contribution,
            'w' => Self::Weight,
            'W' => Self::Coefficient,
            'l' => Self::Effective,
            'L' => Self::Length,
            'c' => Self::Local,
            'p' => Self::Point,
            'n' => Self::Normal,
            'N' => Self::Unperturbed,
            's' => Self::Surface,
            'm' => Self::Modifier,
            'M' => Self::Material,
            'r' => Self::Mirrored,
            'R' => Self::MirroredLength,
            'x' => Self::Unmirrored,
            'X' => Self::UnmirroredLength,
            '~' => Self::Tilde,
            _ => return None,
        })
    }

    fn count(self, space: Space) -> usize {
        match self {
            Self::Value | Self::Contribution | Self::Coefficient | Self::Mirrored | Self::Unmirrored => space.channels(),
            Self::Origin | Self::Direction | Self::Point | Self::Normal | Self::Unperturbed => 3,
            Self::Local => 2,
            Self::Tilde => 0,
            _ => 1,
        }
    }
}

/// What colours are told in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Space {
    /// Red, green and blue.
    #[default]
    Rgb,
    /// CIE X, Y and Z, Y in cd/m².
    Xyz,
    /// What the eye sees by day, in cd/m².
    Photopic,
    /// What it sees by night.
    Scotopic,
    /// What sets its clock.
    Melanopic,
}

/// What RADIANCE makes of red, green and blue of 1 for night vision and for the clock (`rtrace -pS`, `-pM`, measured on a glow of each).
const SCOTOPIC: Rgb = Rgb::new(4.652171, 292.0746, 115.2732);
const MELANOPIC: Rgb = Rgb::new(0.3277638, 107.4519, 71.22034);

impl Space {
    /// How many numbers a colour is.
    pub fn channels(self) -> usize {
        match self {
            Self::Rgb | Self::Xyz => 3,
            _ => 1,
        }
    }

    /// A colour in it: the numbers that count come first.
    fn of(self, color: Rgb) -> [f64; 3] {
        let xyz = || (rgb_to_xyz() * color * WHITE_EFFICACY).to_array();
        match self {
            Self::Rgb => color.to_array(),
            Self::Xyz => xyz(),
            Self::Photopic => [xyz()[1], 0.0, 0.0],
            Self::Scotopic => [SCOTOPIC.dot(color), 0.0, 0.0],
            Self::Melanopic => [MELANOPIC.dot(color), 0.0, 0.0],
        }
    }
}

/// Records in the making.
pub struct Writer {
    /// What was written.
    pub bytes: Vec<u8>,
    /// In which form.
    pub form: Form,
    /// With which colours.
    pub space: Space,
}

impl Writer {
    /// Numbers.
    #[inline(always)]
    pub fn numbers<const N: usize>(&mut self, numbers: [f64; N]) {
        match self.form {
            Form::Ascii => numbers.iter().for_each(|&number| self.text(number)),
            Form::Double => self.bytes.extend_from_slice(numbers.map(f64::to_ne_bytes).as_flattened()),
            Form::Single | Form::Color => self.bytes.extend_from_slice(numbers.map(|number| (number as f32).to_ne_bytes()).as_flattened()),
        }
    }

    /// A number as text.
    fn text(&mut self, number: f64) {
        printf::put_e(&mut self.bytes, number, 6);
        self.bytes.push(b'\t');
    }

    /// A vector.
    pub fn vector(&mut self, vector: Vec3) {
        self.numbers(vector.to_array());
    }

    /// A colour. One that no pixel can hold is black.
    pub fn color(&mut self, color: Rgb) {
        let channels = self.space.of(color);
        match self.form {
            Form::Color => self.bytes.extend_from_slice(&hdr::encode(channels.map(|v| v as f32)).unwrap_or_default()),
            _ if self.space.channels() == 1 => self.numbers([channels[0]]),
            _ => self.numbers(channels),
        }
    }

    /// A name.
    pub fn name(&mut self, name: &str) {
        self.bytes.extend_from_slice(&encode(name));
        self.bytes.push(b'\t');
    }

    /// The end of a record.
    pub fn end(&mut self) {
        if self.form == Form::Ascii {
            self.bytes.push(b'\n');
        }
    }
}
