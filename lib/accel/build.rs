//! From a list of surfaces to a tree.

use super::binary::Binary;
use super::body::{Body, Instance, Placed};
use super::collapse::collapse;
use super::tree::{SINGLE, Space, single};
use super::{Accel, Geometry, Surface};
use crate::error::{Error, Result};
use crate::geometry::{Bounds, LEVELS, Mesh, tolerance};
use crate::vector::{Affine, Vec3};
use obvhs::aabb::Aabb;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// Coordinates from here on are taken for infinite: their products would be.
const HUGE: f64 = 1e100;
/// A mesh this many times smaller than the scene gets a tree of its own, because single precision in the scene's is too coarse for it.
const SMALL: f64 = 1024.0;
/// A mesh with fewer triangles does not.
const FEW: usize = 64;

impl Accel {
    /// The tree over these surfaces. Triangles with corners that are not finite numbers below 1e100, or without area, are left out. Refuses more
    /// than 2³⁰ triangles and surfaces together, groups more than [`LEVELS`] deep, and transforms that are no similarity with an inverse.
    pub fn build(surfaces: Vec<Surface>) -> Result<Self> {
        let mut uses: HashMap<*const Mesh, usize> = HashMap::new();
        let mut bounds = Bounds::EMPTY;
        for surface in &surfaces {
            if let Geometry::Mesh(mesh, _) = &surface.geometry {
                *uses.entry(Arc::as_ptr(mesh)).or_default() += 1;
            }
            bounds = bounds.join(surface.geometry.bounds());
        }
        // Triangles that cannot be hit are left out of the bounds later; here only the size matters.
        let small = |geometry: &Geometry| geometry.bounds().size() * SMALL < bounds.size();
        let mut trees: HashMap<*const Mesh, Arc<Self>> = HashMap::new();
        let (mut bodies, mut ranks) = (Vec::with_capacity(surfaces.len()), Vec::with_capacity(surfaces.len()));
        for Surface { geometry, ranks: own } in surfaces {
            let apart = match &geometry {
                Geometry::Mesh(mesh, _) => uses[&Arc::as_ptr(mesh)] > 1 || (mesh.triangles.len() >= FEW && small(&geometry)),
                _ => false,
            };
            let instance = |accel, affine, mesh| {
                Instance::new(accel, affine, mesh)
                    .ok_or_else(|| Error::new("a transform has no inverse; check its scale"))
                    .map(Body::Instance)
            };
            bodies.push(match geometry {
                Geometry::Shape(shape) => Body::Shape(shape),
                Geometry::Group(accel, affine) => instance(accel, affine, false)?,
                Geometry::Mesh(mesh, affine) if apart => {
                    let accel = match trees.get(&Arc::as_ptr(&mesh)) {
                        Some(accel) => accel.clone(),
                        None => {
                            let accel = Arc::new(Self::over(vec![Body::Mesh(place(mesh.clone(), Affine::IDENTITY))], vec![Vec::new()])?);
                            trees.insert(Arc::as_ptr(&mesh), accel.clone());
                            accel
                        }
                    };
                    instance(accel, affine, true)?
                }
                Geometry::Mesh(mesh, affine) => Body::Mesh(place(mesh, affine)),
            });
            ranks.push(own);
        }
        Self::over(bodies, ranks)
    }

    /// The tree over what is ready to be hit.
    fn over(surfaces: Vec<Body>, ranks: Vec<Vec<super::Rank>>) -> Result<Self> {
        let depth = surfaces.iter().map(|s| if let Body::Instance(i) = s { i.accel.depth + usize::from(!i.mesh) } else { 0 }).max();
        let depth = depth.unwrap_or(0);
        if depth > LEVELS {
            return Err(Error::new(format!("instances are nested more than {LEVELS} levels deep")));
        }
        let count = |s: &Body| if let Body::Mesh(m) = s { m.mesh.triangles.len() } else { 1 };
        let total: usize = surfaces.iter().map(count).sum();
        if total >= SINGLE as usize || surfaces.len() >= u32::MAX as usize {
            return Err(Error::new(format!("the scene has {total} triangles and surfaces; at most {} fit", SINGLE - 1)));
        }
        // List what can be hit, and its bounds.
        let mut primitives = Vec::with_capacity(total);
        let mut bounds = Bounds::EMPTY;
        for (i, surface) in surfaces.iter().enumerate() {
            let i = i as u32;
            if let Body::Mesh(placed) = surface {
                let listed = primitives.len();
                primitives.extend((0..placed.mesh.triangles.len() as u32).filter(|&t| sound(placed.corners(t))).map(|t| (i, t)));
                let found = primitives[listed..].par_iter().with_min_len(4096).map(|&(_, t)| Bounds::of(placed.corners(t)));
                bounds = bounds.join(found.reduce(|| Bounds::EMPTY, Bounds::join));
            } else {
                let own = surface.bounds();
                if !own.is_empty() && own.min.is_finite() && own.max.is_finite() {
                    primitives.push((i, 0));
                    bounds = bounds.join(own);
                }
            }
        }
        let space = Space::new(bounds);
        let corners = |primitive: u32| {
            let (surface, triangle) = primitives[primitive as usize];
            match &surfaces[surface as usize] {
                Body::Mesh(placed) => Some(placed.corners(triangle).map(|p| space.local(p))),
                _ => None,
            }
        };
        let boxes: Vec<Aabb> = (0..primitives.len() as u32)
            .into_par_iter()
            .with_min_len(4096)
            .map(|primitive| match corners(primitive) {
                Some(corners) => Aabb::from_points(&corners.map(|p| single(p).into())),
                None => {
                    let b = surfaces[primitives[primitive as usize].0 as usize].bounds();
                    Aabb::new(single(space.local(b.min)).map(f32::next_down).into(), single(space.local(b.max)).map(f32::next_up).into())
                }
            })
            .collect();
        let binary = Binary::build(&boxes);
        let tree = collapse(&binary, &primitives, corners);
        // World positions were needed only to get here.
        let mut surfaces = surfaces;
        surfaces.iter_mut().for_each(|surface| {
            if let Body::Mesh(placed) = surface {
                placed.moved = None
            }
        });
        Ok(Self { tree, space, surfaces, ranks, tolerance: tolerance(bounds.size()), depth })
    }
}

impl Geometry {
    /// The world box round it.
    fn bounds(&self) -> Bounds {
        match self {
            Self::Shape(shape) => shape.bounds(),
            Self::Mesh(mesh, affine) => moved(Bounds::of(mesh.positions.iter().copied().filter(|&p| finite(p))), affine),
            Self::Group(accel, affine) => moved(accel.bounds(), affine),
        }
    }
}

impl Body {
    fn bounds(&self) -> Bounds {
        match self {
            Self::Shape(shape) => shape.bounds(),
            Self::Instance(instance) => moved(instance.accel.bounds(), &instance.to_world),
            Self::Mesh(placed) => placed.mesh.bounds(),
        }
    }
}

/// The box round a box that is moved, with room for rounding.
fn moved(bounds: Bounds, affine: &Affine) -> Bounds {
    if bounds.is_empty() {
        return bounds;
    }
    let b = Bounds::of(bounds.corners().map(|p| affine.transform_point3(p)));
    b.grow(1e-12 * (b.size() + b.max.abs().max(b.min.abs()).max_element()))
}

/// A mesh moved to its place.
fn place(mesh: Arc<Mesh>, affine: Affine) -> Placed {
    let moved = (affine != Affine::IDENTITY).then(|| mesh.positions.par_iter().map(|&p| affine.transform_point3(p)).collect());
    Placed { mesh, moved, mirrored: affine.matrix3.determinant() < 0.0 }
}

/// Whether a point is one that can be computed with.
fn finite(p: Vec3) -> bool {
    p.abs().cmplt(Vec3::splat(HUGE)).all()
}

/// Whether a triangle can be hit: its corners are numbers and it has an area.
fn sound(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners;
    corners.into_iter().all(finite) && (b - a).cross(c - a) != Vec3::ZERO
}
