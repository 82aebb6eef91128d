//! One RADIANCE surface: from its arguments to what a ray, a light or a picture asks of it.

use super::{Bounds, Cone, Polygon, Ray, Ring, Sphere, tolerance};
use crate::error::{Error, Result};
use crate::rad::{Primitive, Type};
use crate::vector::Vec3;

/// A surface that has an equation of its own.
#[derive(Clone, Debug)]
pub enum Shape {
    /// `polygon`.
    Polygon(Polygon),
    /// `sphere`, `bubble`.
    Sphere(Sphere),
    /// `cone`, `cup`, `cylinder`, `tube`.
    Cone(Cone),
    /// `ring`.
    Ring(Ring),
}

impl Shape {
    /// The surface a primitive describes, without the warnings.
    pub fn of(primitive: &Primitive) -> Result<Option<Self>> {
        Self::read(primitive, &mut Vec::new())
    }

    /// The surface a primitive describes; `None` when RADIANCE ignores it, with the reason among the `warnings` (which have its place, as
    /// errors do); an error when RADIANCE refuses it, or when it is no surface with a shape of its own.
    pub fn read(primitive: &Primitive, warnings: &mut Vec<Error>) -> Result<Option<Self>> {
        let mut texts = Vec::new();
        let shape = Self::new(&primitive.kind, &primitive.reals, &mut texts).map_err(|e| primitive.error(e));
        warnings.extend(texts.into_iter().map(|text| primitive.error(text)));
        shape
    }

    /// The surface of RADIANCE type `kind` with these real arguments. `Ok(None)` when RADIANCE ignores it, with the reason among the
    /// `warnings`; an error when it refuses it (wrong count, not a number, not a type with a shape).
    pub fn new(kind: &str, reals: &[f64], warnings: &mut Vec<String>) -> std::result::Result<Option<Self>, String> {
        if let Some(bad) = reals.iter().find(|r| !r.is_finite()) {
            return Err(format!("{bad} is not a finite number"));
        }
        Type::named(kind).map_or(Ok(()), |kind| kind.takes(reals.len()))?;
        let point = |i: usize| Vec3::new(reals[i], reals[i + 1], reals[i + 2]);
        let mut turned = |negative: bool| {
            if negative {
                warnings.push("negative radius turns the surface inside out".into());
            }
            negative
        };
        let ignored = match kind {
            "polygon" => {
                let polygon = Polygon::new((0..reals.len()).step_by(3).map(point).collect());
                if polygon.as_ref().is_some_and(|p| p.unevenness() > 1e-5) {
                    warnings.push("polygon is not planar; its mean plane is used".into());
                }
                match polygon {
                    Some(polygon) => return Ok(Some(Self::Polygon(polygon))),
                    None => "polygon has zero area",
                }
            }
            "sphere" | "bubble" => {
                let inward = (kind == "bubble") != turned(reals[3] < 0.0);
                if reals[3] != 0.0 {
                    return Ok(Some(Self::Sphere(Sphere { center: point(0), radius: reals[3].abs(), inward })));
                }
                "radius is zero"
            }
            "cone" | "cup" | "cylinder" | "tube" => {
                let frustum = matches!(kind, "cone" | "cup");
                let (r0, r1) = (reals[6], if frustum { reals[7] } else { reals[6] });
                let along = point(3) - point(0);
                match along.try_normalize() {
                    None => "axis has no length",
                    Some(_) if r0 * r1 < 0.0 => "radii have opposite signs",
                    Some(_) if r0 == 0.0 && r1 == 0.0 => "radius is zero",
                    Some(axis) => {
                        let inward = matches!(kind, "cup" | "tube") != turned(r0.min(r1) < 0.0);
                        let (r0, r1) = (r0.abs(), r1.abs());
                        let equal = (r0 - r1).abs() <= tolerance(along.length().max(r0));
                        let radii = [r0, if equal { r0 } else { r1 }];
                        return Ok(Some(Self::Cone(Cone { base: point(0), axis, length: along.length(), radii, inward })));
                    }
                }
            }
            "ring" => {
                let (inner, outer) = (reals[6].min(reals[7]), reals[6].max(reals[7]));
                match point(3).try_normalize() {
                    None => "normal has no length",
                    Some(_) if inner < 0.0 || inner == outer => "radii are negative or equal",
                    Some(normal) => return Ok(Some(Self::Ring(Ring { center: point(0), normal, inner, outer }))),
                }
            }
            _ => return Err(format!("{kind} has no shape of its own")),
        };
        warnings.push(format!("{ignored}; ignored"));
        Ok(None)
    }

    /// The distance of the nearest hit with `t_min < t < t_max`, from either side.
    pub fn intersect(&self, ray: &Ray, t_min: f64, t_max: f64) -> Option<f64> {
        match self {
            Self::Polygon(s) => s.intersect(ray, t_min, t_max),
            Self::Sphere(s) => s.intersect(ray, t_min, t_max),
            Self::Cone(s) => s.intersect(ray, t_min, t_max),
            Self::Ring(s) => s.intersect(ray, t_min, t_max),
        }
    }

    /// The unit normal at a point of the surface, on the front.
    pub fn normal_at(&self, point: Vec3) -> Vec3 {
        match self {
            Self::Polygon(s) => s.normal,
            Self::Sphere(s) => s.normal_at(point),
            Self::Cone(s) => s.normal_at(point),
            Self::Ring(s) => s.normal,
        }
    }

    /// The box round every point a ray can hit.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Polygon(s) => s.bounds(),
            Self::Sphere(s) => s.bounds(),
            Self::Cone(s) => s.bounds(),
            Self::Ring(s) => s.bounds(),
        }
    }

    /// Its area, one side.
    pub fn area(&self) -> f64 {
        match self {
            Self::Polygon(s) => s.area,
            Self::Sphere(s) => s.area(),
            Self::Cone(s) => s.area(),
            Self::Ring(s) => s.area(),
        }
    }

    /// Whether RADIANCE widens highlights of light sources on it (polygon or ring).
    pub fn flat(&self) -> bool {
        matches!(self, Self::Polygon(_) | Self::Ring(_))
    }
}
