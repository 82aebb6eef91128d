//! A surface as the tree's leaves hold it, and exact hits on it.

use super::{Accel, Hit, Path, Rank};
use crate::geometry::{Mesh, Ray, Shape};
use crate::vector::{Affine, Vec3};
use std::sync::Arc;

/// A surface ready to be hit.
#[derive(Clone, Debug)]
pub(super) enum Body {
    Shape(Shape),
    Mesh(Placed),
    Instance(Instance),
}

/// A mesh whose triangles are in the tree itself.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub mesh: Arc<Mesh>,
    /// World positions, where they differ from the mesh's.
    pub moved: Option<Vec<Vec3>>,
    /// Whether the transform mirrors: then a triangle's front is where its world corners are seen clockwise.
    pub mirrored: bool,
}

/// A tree within the tree.
#[derive(Clone, Debug)]
pub(super) struct Instance {
    pub accel: Arc<Accel>,
    pub to_world: Affine,
    pub to_local: Affine,
    /// World lengths per local one.
    pub scale: f64,
    /// Whether it is a mesh: its hits then belong to this surface and not to one inside.
    pub mesh: bool,
}

impl Body {
    /// The exact hit on a shape or instance, the first between the distances, or on a triangle known to be hit at about the distance `near`.
    pub fn hit(&self, ray: &Ray, near: f64, t_min: f64, t_max: f64, surface: u32, triangle: u32) -> Option<Hit> {
        match self {
            Self::Shape(shape) => {
                let t = shape.intersect(ray, t_min, t_max)?;
                let point = ray.at(t);
                Some(Hit { t, point, normal: shape.normal_at(point), surface, path: Path::default(), triangle: 0, barycentric: [0.0; 2] })
            }
            Self::Mesh(placed) => Some(placed.hit(ray, near, surface, triangle)),
            Self::Instance(instance) => {
                let hit = instance.accel.nearest(&instance.inward(ray), t_min / instance.scale, t_max / instance.scale)?;
                Some(instance.outward(hit, surface))
            }
        }
    }

    /// The distance of the first hit of a shape or instance between the distances.
    pub fn distance(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<f64> {
        match self {
            Self::Shape(shape) => shape.intersect(ray, t_min, t_max),
            _ => self.hit(ray, t_min, t_min, t_max, 0, 0).map(|hit| hit.t),
        }
    }

    /// Whether a shape or instance is hit between the distances.
    pub fn occludes(&self, ray: &Ray, t_min: f64, t_max: f64) -> bool {
        match self {
            Self::Instance(instance) => instance.accel.occluded(&instance.inward(ray), t_min / instance.scale, t_max / instance.scale),
            _ => self.distance(ray, t_min, t_max).is_some(),
        }
    }

    /// Every hit on a shape or instance between the distances, with its rank; `ranks` are this surface's.
    pub fn each(&self, ray: &Ray, t_min: f64, t_max: f64, surface: u32, ranks: &[Rank], visit: &mut dyn FnMut(Hit, Rank)) {
        if let Self::Instance(instance) = self {
            let (low, high) = (t_min / instance.scale, t_max / instance.scale);
            return instance.accel.each(&instance.inward(ray), low, high, &mut |hit, rank| {
                let own = if instance.mesh { instance.rank(ranks, hit.triangle) } else { ranks.first().copied().unwrap_or(rank) };
                visit(instance.outward(hit, surface), own);
            });
        }
        let mut from = t_min;
        while let Some(hit) = self.hit(ray, from, from, t_max, surface, 0) {
            from = hit.t;
            visit(hit, self.rank(ranks, 0));
        }
    }

    /// The rank of a triangle of a mesh, or of a shape.
    pub fn rank(&self, ranks: &[Rank], triangle: u32) -> Rank {
        let material = if let Self::Mesh(placed) = self { placed.mesh.material(triangle) as usize } else { 0 };
        ranks.get(material).or(ranks.last()).copied().unwrap_or_default()
    }
}

impl Placed {
    /// World corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let positions = self.moved.as_ref().unwrap_or(&self.mesh.positions);
        self.mesh.triangles[triangle as usize].map(|v| positions[v as usize])
    }

    /// The hit on a triangle that the ray is known to meet at about that distance; a point of the triangle in any case.
    #[inline]
    fn hit(&self, ray: &Ray, near: f64, surface: u32, triangle: u32) -> Hit {
        // Seen from a point of the ray near the triangle no digits are lost, however far the ray has come.
        let from = ray.at(near);
        let corners = self.corners(triangle);
        let [a, b, c] = corners.map(|p| p - from);
        let d = ray.direction;
        // The ray against the three edges (Plücker); outside by rounding is on the edge.
        let weights = Vec3::new(d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a)));
        let sum = weights.element_sum();
        let weights = if sum > 0.0 { weights.max(Vec3::ZERO) } else { weights.min(Vec3::ZERO) };
        // Seen exactly edge on, any weights will do.
        let weights = Some(weights / weights.element_sum()).filter(|w| w.is_finite()).unwrap_or(Vec3::splat(1.0 / 3.0));
        let offset = a * weights.x + b * weights.y + c * weights.z;
        let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let normal = cross.normalize_or_zero() * if self.mirrored { -1.0 } else { 1.0 };
        Hit {
            t: near + offset.dot(d),
            point: from + offset,
            normal,
            surface,
            path: Path::default(),
            triangle,
            barycentric: [weights.y, weights.z],
        }
    }
}

impl Instance {
    /// The instance of a tree, moved by a similarity; `None` when that has no inverse.
    pub fn new(accel: Arc<Accel>, to_world: Affine, mesh: bool) -> Option<Self> {
        let scale = to_world.matrix3.determinant().abs().cbrt();
        let to_local = to_world.inverse();
        (scale > 0.0 && to_local.is_finite() && to_world.is_finite()).then_some(Self { accel, to_world, to_local, scale, mesh })
    }

    /// The world's ray as it is inside.
    fn inward(&self, ray: &Ray) -> Ray {
        Ray::new(self.to_local.transform_point3(ray.origin), self.to_local.transform_vector3(ray.direction) * self.scale)
    }

    /// An inner hit as it is in the world.
    fn outward(&self, hit: Hit, surface: u32) -> Hit {
        Hit {
            t: hit.t * self.scale,
            point: self.to_world.transform_point3(hit.point),
            normal: self.to_world.transform_vector3(hit.normal) / self.scale,
            surface,
            path: if self.mesh { hit.path } else { hit.path.within(hit.surface) },
            ..hit
        }
    }

    /// The rank of a triangle, when this is a mesh.
    fn rank(&self, ranks: &[Rank], triangle: u32) -> Rank {
        self.accel.surfaces[0].rank(ranks, triangle)
    }
}
