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
    /// The shape, if it is one.
    pub fn shape(&self) -> Option<&Shape> {
        if let Self::Shape(shape) = self { Some(shape) } else { None }
    }

    /// The instance, if it is one.
    pub fn instance(&self) -> Option<&Instance> {
        if let Self::Instance(instance) = self { Some(instance) } else { None }
    }

    /// Whether a shape or instance is hit between the distances.
    pub fn occludes(&self, ray: &Ray, t_min: f64, t_max: f64) -> bool {
        match self {
            Self::Shape(shape) => shape.intersect(ray, t_min, t_max).is_some(),
            Self::Instance(instance) => instance.occludes(ray, t_min, t_max),
            Self::Mesh(_) => false,
        }
    }

    /// Every hit on a shape or instance between the distances, with its rank; `ranks` are this surface's.
    pub fn each(&self, ray: &Ray, t_min: f64, t_max: f64, surface: u32, ranks: &[Rank], visit: &mut dyn FnMut(Hit, Rank)) {
        match self {
            Self::Shape(shape) => {
                let mut from = t_min;
                while let Some(hit) = shape_hit(shape, ray, from, t_max, surface) {
                    from = hit.t;
                    visit(hit, ranks.first().copied().unwrap_or_default());
                }
            }
            Self::Instance(instance) => instance.each(ray, t_min, t_max, surface, ranks, visit),
            Self::Mesh(_) => {}
        }
    }
}

/// The first hit on a shape between the distances.
pub(super) fn shape_hit(shape: &Shape, ray: &Ray, t_min: f64, t_max: f64, surface: u32) -> Option<Hit> {
    let t = shape.intersect(ray, t_min, t_max)?;
    let point = ray.at(t);
    Some(Hit { t, point, normal: shape.normal_at(point), surface, path: Path::default(), triangle: 0, barycentric: [0.0; 2] })
}

impl Placed {
    /// World corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let positions = self.moved.as_ref().unwrap_or(&self.mesh.positions);
        self.mesh.triangles[triangle as usize].map(|v| positions[v as usize])
    }

    /// The rank of a triangle.
    pub fn rank(&self, ranks: &[Rank], triangle: u32) -> Rank {
        ranks.get(self.mesh.material(triangle) as usize).or(ranks.last()).copied().unwrap_or_default()
    }

    /// The hit on a triangle that the ray is known to meet at about that distance; a point of the triangle in any case.
    #[inline]
    pub fn hit(&self, ray: &Ray, near: f64, surface: u32, triangle: u32) -> Hit {
        // Seen from a point of the ray near the triangle no digits are lost, however far the ray has come.
        let from = ray.at(near);
        let corners = self.corners(triangle);
        let [a, b, c] = corners.map(|p| p - from);
        let d = ray.direction;
        // The ray against the three edges (Plücker).
        let volumes = Vec3::new(d.dot(c.cross(b)), d.dot(a.cross(c)), d.dot(b.cross(a)));
        let mut weights = volumes / volumes.element_sum();
        // A little outside is single precision's doing and still on the plane. More is a triangle seen edge on: take a point in it.
        if weights.is_nan() || weights.min_element() < -1e-2 {
            let positive = weights.max(Vec3::ZERO);
            weights = Some(positive / positive.element_sum()).filter(|w| w.is_finite()).unwrap_or(Vec3::splat(1.0 / 3.0));
        }
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
            barycentric: [weights.y, weights.z].map(|w| w.clamp(0.0, 1.0)),
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

    /// The first hit between the distances.
    pub fn nearest(&self, ray: &Ray, t_min: f64, t_max: f64, surface: u32) -> Option<Hit> {
        let hit = self.accel.nearest(&self.inward(ray), t_min / self.scale, t_max / self.scale)?;
        Some(self.outward(hit, surface))
    }

    /// Whether it is hit between the distances.
    fn occludes(&self, ray: &Ray, t_min: f64, t_max: f64) -> bool {
        self.accel.occluded(&self.inward(ray), t_min / self.scale, t_max / self.scale)
    }

    /// Every hit between the distances, with its rank; `ranks` are this surface's.
    fn each(&self, ray: &Ray, t_min: f64, t_max: f64, surface: u32, ranks: &[Rank], visit: &mut dyn FnMut(Hit, Rank)) {
        self.accel.each(&self.inward(ray), t_min / self.scale, t_max / self.scale, &mut |hit, inner| {
            let rank = match &self.accel.surfaces[0] {
                Body::Mesh(placed) if self.mesh => placed.rank(ranks, hit.triangle),
                _ => ranks.first().copied().unwrap_or(inner),
            };
            visit(self.outward(hit, surface), rank);
        });
    }
}
