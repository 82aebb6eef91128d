//! Three numbers: points and directions, their bases and transforms.
//!
//! Directions are unit vectors unless said otherwise. `glam` is named here and nowhere else.

pub mod angle;

/// A point, a direction or a difference of points, in world units.
pub type Vec3 = glam::DVec3;

/// An affine map of points (`transform_point3`) and vectors (`transform_vector3`).
pub type Affine = glam::DAffine3;

/// A 3 × 3 matrix, column by column.
pub type Mat3 = glam::DMat3;

/// 1 − cos of an angle in radians, exact for the smallest too.
pub fn one_minus_cos(angle: f64) -> f64 {
    let sine = (angle / 2.0).sin();
    2.0 * sine * sine
}

/// The axis that a vector is longest along.
pub fn longest(v: Vec3) -> usize {
    let v = v.abs();
    if v.x >= v.y && v.x >= v.z { 0 } else { 1 + usize::from(v.y < v.z) }
}

/// The other two axes, in the order that makes a right-handed system.
#[inline(always)]
pub fn across(axis: usize) -> [usize; 2] {
    let next = if axis == 2 { 0 } else { axis + 1 };
    [next, 3 - axis - next]
}

/// A right-handed orthonormal basis whose third axis is a given direction.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First tangent.
    pub s: Vec3,
    /// Second tangent.
    pub t: Vec3,
    /// The direction the frame was built on.
    pub n: Vec3,
}

impl Frame {
    /// The frame around the unit vector `n` (Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3).
    pub fn around(n: Vec3) -> Self {
        let sign = 1f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self { s: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), t: Vec3::new(b, sign + n.y * n.y * a, -n.y), n }
    }

    /// Components of the world vector `v` along `s`, `t` and `n`.
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// The world vector with components `v` along `s`, `t` and `n`.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_right_handed_everywhere() {
        for n in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(1.0, -2.0, 3.0).normalize(), Vec3::new(1e-9, 0.0, -1.0).normalize()] {
            let f = Frame::around(n);
            assert!((f.s.cross(f.t) - n).length() < 1e-14);
            assert!((f.to_world(f.to_local(Vec3::new(0.3, 0.4, 0.5))) - Vec3::new(0.3, 0.4, 0.5)).length() < 1e-15);
        }
    }
}
