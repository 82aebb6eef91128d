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
    /// World positions, where they differ from the mesh's and until the tree is built.
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
    /// Whether it is a mesh whose triangles show their fronts clockwise.
    pub fn mirrored(&self) -> bool {
        matches!(self, Self::Mesh(placed) if placed.mirrored)
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
