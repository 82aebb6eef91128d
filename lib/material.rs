//! What a material is: its type and numbers, in RADIANCE's order and range.

use crate::color::Rgb;
use crate::error::Result;
use crate::geometry::TINY;
use crate::pattern::{Functions, Sources};
use crate::rad::Primitive;
use crate::vector::{Vec3, one_minus_cos};
use std::sync::Arc;

/// A material, with its real arguments A1, A2… by name.
#[derive(Clone, Debug)]
pub enum Material {
    /// plastic, metal, trans, plastic2, metal2, trans2. An anisotropic one is oriented by its expressions at each hit.
    Reflectance(Reflectance),
    /// ashik2: diffuse and specular colour, powers along u and v.
    Ashikhmin(Ashikhmin),
    /// BRTDfunc: what its expressions do not say is diffuse.
    Functions(FunctionMaterial),
    /// dielectric: what a unit length of the inside transmits, and its index of refraction.
    Dielectric(Medium),
    /// interface: the media inside and outside.
    Interface(Medium, Medium),
    /// glass: transmissivity at normal incidence, index of refraction.
    Glass(Medium),
    /// mirror: reflectance.
    Mirror(Rgb),
    /// light: radiance.
    Light(Rgb),
    /// illum: radiance of the light that it is for what is aimed at it.
    Illum(Rgb),
    /// glow: radiance, and the radius within which it is a light source.
    Glow(Rgb, f64),
    /// spotlight: radiance, 1 − cos of the half angle of its cone, aim (its length is a focal distance).
    Spotlight(Rgb, f64, Vec3),
    /// antimatter: inside, the materials it lists are not there.
    Antimatter,
}

/// The numbers of ashik2 (Ashikhmin and Shirley 2000).
#[derive(Clone, Copy, Debug)]
pub struct Ashikhmin {
    /// A1 to A3.
    pub diffuse: Rgb,
    /// A4 to A6: at normal incidence.
    pub specular: Rgb,
    /// A7 and A8, the powers of the lobe along the two tangents.
    pub powers: [f64; 2],
}

/// The parts of BRTDfunc.
#[derive(Clone, Debug)]
pub struct FunctionMaterial {
    /// Diffuse reflectance of the front and of the back.
    pub diffuse: [Rgb; 2],
    /// Diffuse transmittance.
    pub through: Rgb,
    /// The rest.
    pub functions: Arc<Functions>,
}

/// The numbers of plastic, metal, trans and their anisotropic kin.
#[derive(Clone, Copy, Debug)]
pub struct Reflectance {
    /// A1 to A3: reflectance per channel, 0 to 1, without the pattern.
    pub color: Rgb,
    /// A4, the specularity, 0 to 1.
    pub specularity: f64,
    /// A5, the roughness, once or along u and v: the root mean square slope of the facets, not its square.
    pub roughness: [f64; 2],
    /// A6, the total transmission, 0 to 1.
    pub transmission: f64,
    /// A7, the specular fraction of it, 0 to 1.
    pub transmitted_specular: f64,
    /// Whether the specular part is coloured: metal.
    pub metal: bool,
    /// Whether it may be a mirror: the isotropic types.
    pub isotropic: bool,
    /// Whether its type is one that transmits.
    pub transmits: bool,
}

/// A transparent medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// What a unit of length transmits, per channel, 0 to 1; of glass, what its pane does at normal incidence, reflections aside.
    pub transmissivity: Rgb,
    /// Index of refraction.
    pub index: f64,
}

/// What fills a stretch of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inside {
    /// Extinction per unit length, per channel.
    pub extinction: Rgb,
    /// What its patterns add to the extinction, if it is the unknown that fills it: then only the length counts beside.
    pub unknown: Option<Rgb>,
}

impl Reflectance {
    /// A Lambertian surface.
    pub fn diffuse(color: Rgb) -> Self {
        let (transmission, transmitted_specular) = (0.0, 0.0);
        let roughness = [0.0; 2];
        Self { color, specularity: 0.0, roughness, transmission, transmitted_specular, metal: false, isotropic: true, transmits: false }
    }
}

impl Inside {
    /// A known medium.
    pub fn of(extinction: Rgb) -> Self {
        Self { extinction, unknown: None }
    }

    /// The part of the light that `length` of it lets through, with RADIANCE's cuts.
    pub fn transmittance(&self, length: f64) -> Rgb {
        if self.extinction == Rgb::ZERO {
            return Rgb::ONE;
        }
        let through = |x: f64| {
            if x <= TINY {
                1.0
            } else if x > 92.0 {
                0.0
            } else {
                (-x).exp()
            }
        };
        self.extinction.to_array().map(|e| if e == 0.0 { 1.0 } else { through(e * length) }).into()
    }
}

/// Roughness at or below this is none at all: a mirror (RADIANCE, `a² ≤ 1e-6`).
pub const PURE: f64 = 0.001;
/// Specularity from which what is that smooth has a Fresnel term.
pub const FRESNEL_FROM: f64 = 0.017999;

impl Medium {
    /// The same that absorbs nothing.
    pub fn cleared(&self) -> Self {
        Self { transmissivity: Rgb::ONE, ..*self }
    }

    /// Extinction per unit length, −ln of the transmissivity times `pattern`: 100 for black, 0 for clear.
    pub fn extinction(&self, pattern: Rgb) -> Rgb {
        let extinction = |t: f64| match t {
            1.0.. => 0.0,
            t if t < 1e-40 => 100.0,
            t => (-t.ln()).max(0.0),
        };
        (self.transmissivity * pattern).to_array().map(extinction).into()
    }
}

/// Index of refraction of glass that does not give one.
pub const GLASS_INDEX: f64 = 1.52;

/// The index of refraction of a dielectric: Hartmann's constant shifts it even where dispersion is not modelled.
pub fn hartmann(index: f64, constant: f64) -> f64 {
    index + constant / 500.0
}

/// Whether a primitive is a material of lamps: any that shines but a glow that lights no distance.
pub fn is_of_lamps(primitive: &Primitive) -> bool {
    match primitive.kind.as_str() {
        "light" | "illum" | "spotlight" => true,
        "glow" => primitive.reals.get(3).is_some_and(|&radius| radius > TINY),
        _ => false,
    }
}

impl Material {
    /// The material that `primitive` defines. `None` if its type is not a material that is rendered.
    pub fn of(primitive: &Primitive, sources: &mut Sources) -> Result<Option<Self>> {
        primitive.complete_reals()?;
        let a = Arguments(primitive);
        Ok(Some(match primitive.kind.as_str() {
            "plastic" | "metal" => Self::Reflectance(a.reflectance(1)),
            "trans" => Self::Reflectance(Reflectance { transmission: a.real(5), transmitted_specular: a.real(6), ..a.reflectance(1) }),
            "plastic2" | "metal2" => {
                a.rough()?;
                Self::Reflectance(a.reflectance(2))
            }
            "trans2" => {
                a.rough()?;
                Self::Reflectance(Reflectance { transmission: a.real(6), transmitted_specular: a.real(7), ..a.reflectance(2) })
            }
            "ashik2" => Self::Ashikhmin(Ashikhmin { diffuse: a.rgb(0), specular: a.rgb(3), powers: a.powers()? }),
            "BRTDfunc" => {
                let Some(functions) = Functions::compile(primitive, sources)? else { return Ok(None) };
                Self::Functions(FunctionMaterial { diffuse: [a.rgb(0), a.rgb(3)], through: a.rgb(6), functions: Arc::new(functions) })
            }
            "antimatter" => {
                if primitive.strings.is_empty() {
                    return Err(primitive.error(format!("antimatter `{}` needs the names of what it removes", primitive.name)));
                }
                Self::Antimatter
            }
            "dielectric" => Self::Dielectric(Medium { transmissivity: a.rgb(0), index: hartmann(a.real(3), a.real(4)) }),
            "interface" => {
                let medium = |i: usize| Medium { transmissivity: a.rgb(i), index: a.real(i + 3) };
                Self::Interface(medium(0), medium(4))
            }
            "glass" => {
                Self::Glass(Medium { transmissivity: a.rgb(0), index: if primitive.reals.len() == 4 { a.real(3) } else { GLASS_INDEX } })
            }
            "mirror" => Self::Mirror(a.rgb(0)),
            "light" => Self::Light(a.rgb(0)),
            "illum" => Self::Illum(a.rgb(0)),
            "glow" => Self::Glow(a.rgb(0), a.real(3)),
            "spotlight" => {
                let aim = Vec3::new(a.real(4), a.real(5), a.real(6));
                if aim.try_normalize().is_none() {
                    return Err(primitive.real_error(
                        4,
                        "the aim of a spotlight must be a direction, not of the length 0, nor out of the range of numbers",
                    ));
                }
                Self::Spotlight(a.rgb(0), one_minus_cos(a.real(3).to_radians() / 2.0), aim)
            }
            _ => return Ok(None),
        }))
    }
}

impl Material {
    /// Whether light passes through it in single directions: then shadow rays do not end at it.
    pub fn passes(&self) -> bool {
        match self {
            Self::Reflectance(m) => m.transmission * m.transmitted_specular > 0.0 && m.isotropic && m.roughness[0].abs() <= PURE,
            Self::Dielectric(_) | Self::Interface(..) | Self::Glass(_) | Self::Antimatter => true,
            // An illum that is not aimed at, and what a mirror shows light, are not in the way of light.
            Self::Illum(_) | Self::Mirror(_) => true,
            Self::Functions(f) => f.functions.transmits(),
            Self::Light(_) | Self::Glow(..) | Self::Spotlight(..) | Self::Ashikhmin(_) => false,
        }
    }

    /// Whether a texture bends the light that passes, of primary and mirrored rays, while shadow and ambient rays go straight on.
    pub fn bends(&self) -> bool {
        matches!(self, Self::Reflectance(_) | Self::Glass(_) | Self::Functions(_)) && self.passes()
    }

    /// Whether its type is one that RADIANCE takes for transparent, whatever its numbers: such a surface gives way to a coincident opaque
    /// one, and `-i` looks through it.
    pub fn nominally_transparent(&self) -> bool {
        match self {
            Self::Reflectance(m) => m.transmits,
            Self::Dielectric(_) | Self::Interface(..) | Self::Glass(_) => true,
            Self::Functions(f) => f.functions.transmits(),
            _ => false,
        }
    }

    /// Whether it is a light source.
    pub fn emits(&self) -> bool {
        matches!(self, Self::Light(_) | Self::Illum(_) | Self::Glow(..) | Self::Spotlight(..))
    }

    /// Whether `-bv-` makes its back invisible.
    pub fn backless(&self) -> bool {
        !matches!(self, Self::Dielectric(_) | Self::Interface(..) | Self::Functions(_) | Self::Antimatter)
    }

    /// Whether what is aimed at a lamp stops here, even where the back is invisible: RADIANCE looks at that first.
    pub fn shades(&self) -> bool {
        match self {
            Self::Reflectance(m) => !(m.transmits && m.isotropic),
            Self::Ashikhmin(_) | Self::Mirror(_) | Self::Light(_) | Self::Glow(..) | Self::Spotlight(..) => true,
            _ => false,
        }
    }

    /// The radiance that a light source emits against the direction of travel `direction`.
    pub fn emitted(&self, direction: Vec3) -> Rgb {
        match self {
            Self::Light(radiance) | Self::Illum(radiance) | Self::Glow(radiance, _) => *radiance,
            Self::Spotlight(radiance, spread, aim) if 1.0 + aim.normalize().dot(direction) <= *spread => *radiance,
            _ => Rgb::ZERO,
        }
    }
}

/// The real arguments of a primitive.
struct Arguments<'a>(&'a Primitive);

impl Arguments<'_> {
    fn real(&self, i: usize) -> f64 {
        self.0.reals[i]
    }

    fn rgb(&self, i: usize) -> Rgb {
        Rgb::new(self.real(i), self.real(i + 1), self.real(i + 2))
    }

    /// Refuses roughnesses that an anisotropic lobe cannot have, as RADIANCE does.
    fn rough(&self) -> Result<()> {
        match [4, 5].into_iter().find(|&i| !(self.real(i) > TINY)) {
            Some(i) => Err(self.0.real_error(i, format!("the roughness of {} must be above {TINY}", self.0.kind))),
            None => Ok(()),
        }
    }

    /// The powers of ashik2, refused below 0.
    fn powers(&self) -> Result<[f64; 2]> {
        match [6, 7].into_iter().find(|&i| !(self.real(i) >= 0.0)) {
            Some(i) => Err(self.0.real_error(i, "a power of ashik2 must be 0 or more")),
            None => Ok([self.real(6), self.real(7)]),
        }
    }

    /// Colour, specularity and one roughness, or two (which RADIANCE does not allow to be zero).
    fn reflectance(&self, roughnesses: usize) -> Reflectance {
        Reflectance {
            color: self.rgb(0),
            specularity: self.real(3),
            roughness: [self.real(4), self.real(3 + roughnesses)],
            transmission: 0.0,
            transmitted_specular: 0.0,
            metal: self.0.kind.starts_with("metal"),
            isotropic: roughnesses == 1,
            transmits: self.0.kind.starts_with("trans"),
        }
    }
}
