//! What `xform` options do to points: `-t`, `-rx`, `-s`, `-mx`, `-i` and their like as one affine map.

use crate::error::{Error, Result};
use crate::rad::{Primitive, real};
use crate::vector::{Affine, Mat3, Vec3};

/// A similarity: rotation, uniform scale, perhaps a mirror, translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// The map of points (`transform_point3`) and vectors (`transform_vector3`).
    pub affine: Affine,
    /// By how much lengths grow; positive.
    pub scale: f64,
    /// Whether it turns right hands into left ones.
    pub mirrored: bool,
}

impl Transform {
    /// What changes nothing.
    pub const IDENTITY: Self = Self { affine: Affine::IDENTITY, scale: 1.0, mirrored: false };

    /// The transform that `words` begins with, and how many of them it takes. Elements apply from left to right;
    /// `-i n` repeats what follows it, up to the next `-i`, n times. Stops at the first word that is no element.
    pub fn parse<S: AsRef<str>>(words: &[S]) -> Result<(Self, usize)> {
        let (mut done, mut part, mut repeat, mut at) = (Self::IDENTITY, Self::IDENTITY, 1, 0);
        while let Some(word) = words.get(at) {
            let word = word.as_ref();
            let numbers = |n: usize| -> Result<Vec3> {
                let found: Vec<f64> = words[at + 1..].iter().take(n).map_while(|w| real(w.as_ref())).collect();
                match found[..] {
                    [x, y, z] if n == 3 => Ok(Vec3::new(x, y, z)),
                    [x] if n == 1 => Ok(Vec3::splat(x)),
                    _ => Err(Error::new(format!("`{word}` needs {}", if n == 3 { "three numbers" } else { "a number" }))),
                }
            };
            let (element, count) = match word {
                "-t" => (Self { affine: Affine::from_translation(numbers(3)?), ..Self::IDENTITY }, 3),
                "-rx" => (Self::linear(Mat3::from_rotation_x(numbers(1)?.x.to_radians())), 1),
                "-ry" => (Self::linear(Mat3::from_rotation_y(numbers(1)?.x.to_radians())), 1),
                "-rz" => (Self::linear(Mat3::from_rotation_z(numbers(1)?.x.to_radians())), 1),
                "-s" => (Self::scaling(numbers(1)?.x)?, 1),
                "-mx" => (Self::mirror(Vec3::new(-1.0, 1.0, 1.0)), 0),
                "-my" => (Self::mirror(Vec3::new(1.0, -1.0, 1.0)), 0),
                "-mz" => (Self::mirror(Vec3::new(1.0, 1.0, -1.0)), 0),
                "-i" => {
                    let count = words.get(at + 1).and_then(|w| w.as_ref().parse().ok());
                    done = done.then(&part.repeated(repeat));
                    part = Self::IDENTITY;
                    repeat = count.ok_or_else(|| Error::new("`-i` needs a count, 0 or more"))?;
                    (Self::IDENTITY, 1)
                }
                _ => break,
            };
            part = part.then(&element);
            at += 1 + count;
        }
        let whole = done.then(&part.repeated(repeat));
        if !(whole.affine.is_finite() && whole.scale.powi(3).is_normal() && whole.scale > 0.0) {
            return Err(Error::new("the transform leaves the range of numbers; check its `-s`, `-t` and `-i`"));
        }
        Ok((whole, at))
    }

    /// The transform that the strings of a primitive from `start` on are.
    pub fn of(primitive: &Primitive, start: usize) -> Result<Self> {
        let words = primitive.strings.get(start..).unwrap_or_default();
        let (transform, used) = Self::parse(words).map_err(|error| primitive.string_error(start, error.message))?;
        match words.get(used) {
            None => Ok(transform),
            Some(word) => Err(primitive.string_error(start + used, format!("`{word}` is no part of a transform"))),
        }
    }

    /// This transform, and then `next`.
    pub fn then(&self, next: &Self) -> Self {
        Self { affine: next.affine * self.affine, scale: self.scale * next.scale, mirrored: self.mirrored != next.mirrored }
    }

    /// What undoes it.
    pub fn inverse(&self) -> Self {
        Self { affine: self.affine.inverse(), scale: 1.0 / self.scale, mirrored: self.mirrored }
    }

    /// Where the point `p` goes.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.affine.transform_point3(p)
    }

    /// What becomes of the vector `v`; its length scales too.
    pub fn vector(&self, v: Vec3) -> Vec3 {
        self.affine.transform_vector3(v)
    }

    /// This transform `count` times, by repeated squaring.
    fn repeated(&self, count: usize) -> Self {
        let (mut done, mut power, mut left) = (Self::IDENTITY, *self, count);
        while left > 0 {
            if left % 2 == 1 {
                done = done.then(&power);
            }
            power = power.then(&power);
            left /= 2;
        }
        done
    }

    fn linear(matrix: Mat3) -> Self {
        Self { affine: Affine::from_mat3(matrix), ..Self::IDENTITY }
    }

    fn mirror(signs: Vec3) -> Self {
        Self { mirrored: true, ..Self::linear(Mat3::from_diagonal(signs)) }
    }

    fn scaling(factor: f64) -> Result<Self> {
        if !(factor.abs() > 0.0 && factor.is_finite()) {
            return Err(Error::new("`-s` cannot scale to nothing"));
        }
        Ok(Self { scale: factor.abs(), mirrored: factor < 0.0, ..Self::linear(Mat3::from_diagonal(Vec3::splat(factor))) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> (Transform, usize) {
        Transform::parse(&text.split_whitespace().collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn elements_apply_from_left_to_right() {
        // xform -t 1 0 0 -rz 90 -s 2 takes (1,0,0) to (0,4,0).
        let (t, used) = parse("-t 1 0 0 -rz 90 -s 2 room.rad");
        assert_eq!((used, t.scale, t.mirrored), (8, 2.0, false));
        assert!((t.point(Vec3::X) - Vec3::new(0.0, 4.0, 0.0)).length() < 1e-15);
        assert!((parse("-rx 90").0.vector(Vec3::Y) - Vec3::Z).length() < 1e-15);
        assert!((parse("-ry 90").0.vector(Vec3::Z) - Vec3::X).length() < 1e-15);
        assert!((t.then(&t.inverse()).point(Vec3::ONE) - Vec3::ONE).length() < 1e-14);
    }

    #[test]
    fn iterations_repeat_what_follows() {
        // xform -i 1 -t 1 0 0 -i 2 -t 0 1 0 -i 1 -rz 90 -s 2 takes (1,2,3) to (-8,4,6).
        assert!(
            (parse("-i 1 -t 1 0 0 -i 2 -t 0 1 0 -i 1 -rz 90 -s 2").0.point(Vec3::new(1.0, 2.0, 3.0)) - Vec3::new(-8.0, 4.0, 6.0)).length()
                < 1e-14
        );
        assert_eq!(parse("-i 0 -t 1 0 0").0, Transform::IDENTITY);
    }

    #[test]
    fn mirrors_and_negative_scales_cancel() {
        assert!(parse("-mx").0.mirrored && parse("-s -3").0.mirrored && !parse("-my -s -3").0.mirrored);
        assert_eq!(parse("-my -s -3").0.scale, 3.0);
    }

    #[test]
    fn malformed_elements_are_errors() {
        for bad in ["-t 1 2", "-rx", "-s 0", "-i x", "-s 1e200 -s 1e200", "-s 1e-200 -s 1e-200", "-i 2000 -s 2"] {
            assert!(Transform::parse(&bad.split_whitespace().collect::<Vec<_>>()).is_err(), "{bad}");
        }
    }
}
