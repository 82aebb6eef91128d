//! Where a pattern lies: what a ray and a surface look like in its own coordinates.

use crate::cal::Ray;
use crate::geometry::FAR;
use crate::transform::Transform;
use crate::vector::{Affine, Mat3, Vec3};

/// A hit, as patterns and textures see it. All in world coordinates.
#[derive(Clone, Copy, Debug)]
pub struct At<'a> {
    /// Direction of travel, unit length.
    pub direction: Vec3,
    /// Surface normal, unit length.
    pub normal: Vec3,
    /// The point that is hit; on a source, the origin of the ray.
    pub point: Vec3,
    /// Distance from the eye along the path.
    pub t: f64,
    /// Length of this ray, with its shadow parents.
    pub ts: f64,
    /// Cosine between normal and ray, in −1..1: positive where the surface faces the viewer.
    pub rdot: f64,
    /// Coordinates on a mesh.
    pub uv: [f64; 2],
    /// The transform of the instance or mesh that the modifier belongs to, from its coordinates to the world's.
    pub instance: Option<&'a Transform>,
}

impl At<'_> {
    /// A point on a surface that a ray meets, at distance 0.
    pub fn surface(direction: Vec3, normal: Vec3, point: Vec3) -> Self {
        let rdot = (-direction.dot(normal)).clamp(-1.0, 1.0);
        Self { direction, normal, point, t: 0.0, ts: 0.0, rdot, uv: [0.0; 2], instance: None }
    }

    /// A distant source that a ray from `origin` meets: RADIANCE puts it [`FAR`] away, facing the ray.
    pub fn distant(direction: Vec3, origin: Vec3) -> Self {
        Self { t: FAR, ts: FAR, rdot: 1.0, ..Self::surface(direction, -direction, origin) }
    }
}

/// The frame of a pattern.
#[derive(Debug)]
pub(super) struct Frame {
    place: Place,
    still: bool,
}

/// From world coordinates to those of a frame.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// Of points.
    inverse: Affine,
    /// Of directions: a rotation, perhaps with a mirror.
    turn: Mat3,
    /// What a world unit measures.
    unit: f64,
}

impl Place {
    fn of(transform: &Transform) -> Self {
        let unit = 1.0 / transform.scale;
        Self { inverse: transform.affine.inverse(), turn: (transform.affine.matrix3 * unit).transpose(), unit }
    }

    /// First to this place, from there to `inner`.
    fn then(&self, inner: &Self) -> Self {
        Self { inverse: inner.inverse * self.inverse, turn: inner.turn * self.turn, unit: inner.unit * self.unit }
    }
}

impl Frame {
    pub fn new(transform: &Transform) -> Self {
        let still = *transform == Transform::IDENTITY;
        Self { place: Place::of(transform), still }
    }

    fn place(&self, at: &At) -> Place {
        match at.instance {
            None => self.place,
            Some(instance) => Place::of(instance).then(&self.place),
        }
    }

    /// The ray's direction.
    #[inline]
    pub fn direction(&self, at: &At) -> Vec3 {
        match at.instance {
            None if self.still => at.direction,
            None => self.place.turn * at.direction,
            Some(_) => self.turn(at) * at.direction,
        }
    }

    /// What turns a direction into one of the frame.
    pub fn turn(&self, at: &At) -> Mat3 {
        self.place(at).turn
    }

    /// All ray variables.
    pub fn ray(&self, at: &At) -> Ray {
        let mut ray;
        if self.still && at.instance.is_none() {
            ray = Ray::new(at.direction, at.normal, at.point);
            ray.put(Ray::DISTANCE, at.t);
            ray.put(Ray::LENGTH, at.ts);
        } else {
            let Place { inverse, turn, unit } = self.place(at);
            ray = Ray::new(turn * at.direction, turn * at.normal, inverse.transform_point3(at.point));
            ray.put(Ray::DISTANCE, at.t * unit);
            ray.put(Ray::LENGTH, at.ts * unit);
            ray.put(Ray::SCALE, unit);
            ray.set(Ray::ORIGIN, inverse.translation);
            ray.set(Ray::AXES, turn.x_axis);
            ray.set(Ray::AXES + 3, turn.y_axis);
            ray.set(Ray::AXES + 6, turn.z_axis);
        }
        ray.put(Ray::RDOT, at.rdot);
        ray.put(Ray::UV, at.uv[0]);
        ray.put(Ray::UV + 1, at.uv[1]);
        ray
    }

    /// The world's vector for a vector of the frame that measures something on unit vectors: it is turned, not scaled.
    pub fn to_world(&self, at: &At, vector: Vec3) -> Vec3 {
        self.place(at).turn.transpose() * vector
    }
}
