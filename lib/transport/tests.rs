//! The basis, put together with the numbers of a material, is the picture that a plain rendering makes of the same samples.

use super::{Basis, Clear, Columns, Explored, LANES, Mixture, ORDER, Piece, Pixels, Rough, Transport, clear, follow, rough, trace};
use crate::bsdf::{Arriving, Bsdf, Delta, Part};
use crate::color::Rgb;
use crate::error::Source;
use crate::expand::expand;
use crate::integrator::{Radiance, Scattering};
use crate::material::Inside;
use crate::rad::Document;
use crate::recover::model::{Kind, alphas, coefficients};
use crate::resolve::Files;
use crate::rules::Rules;
use crate::scene::{MaterialId, Reading, Scene};
use crate::vector::Vec3;
use crate::world::{Layer, World};

/// A bowl with a ball in it, both of the material, on a table, under a sky and a lamp.
const SCENE: &str = "
    void glow sky 0 0 4 .8 .9 1.2 0
    sky source above 0 0 4 0 0 1 180
    void light bulb 0 0 3 40 30 20
    bulb sphere lamp 0 0 4 1 1 2 .3
    void plastic table 0 0 5 .4 .3 .2 .03 .1
    table ring top 0 0 8 0 0 -1.2 0 0 1 0 5
    thing cup bowl 0 0 8 0 0 -1 0 0 0 .5 1.2
    thing ring bottom 0 0 8 0 0 -1 0 0 1 0 .5
    thing sphere ball 0 0 4 .1 0 -.5 .35
";

fn world(material: &str, rules: &Rules) -> (World, MaterialId) {
    let text = format!("void {material}\n{SCENE}");
    let document = Document::parse(Source::new("scene.rad", text)).unwrap();
    let files = Files::default();
    let flat = expand(vec![document], &files).unwrap();
    let scene = Scene::new(&flat, &files, &Reading::default()).unwrap();
    let id = scene.material(&flat.primitives[0]).unwrap();
    let mut world = World::new(scene, rules).unwrap();
    world.unknown = Some(id);
    (world, id)
}

/// Looks down into the bowl.
fn lens(number: usize, [u, v]: [f64; 2]) -> Option<(Vec3, Vec3, f64)> {
    let target = Vec3::new((number % 4) as f64 - 2.0 + u, (number / 4) as f64 - 2.0 + v, -2.0) * 0.35;
    let eye = Vec3::new(0.4, -1.5, 3.0);
    Some((eye, (target - eye).normalize(), f64::INFINITY))
}

const SAMPLES: u32 = 24;
const SEED: u64 = 7;

fn basis(world: &World, rules: &Rules, unknown: Explored, x: &[Vec<f64>; 3]) -> Basis {
    let numbers: Vec<usize> = (0..16).collect();
    let samples = vec![0..SAMPLES; numbers.len()];
    trace(world, rules, unknown, &Pixels { numbers: &numbers, samples: &samples, lens: &lens, picture: Some(x) }, 1, SEED)
}

/// A pixel, and the variance of its samples.
type Told = ([f32; 3], [f32; 3]);

/// The picture that a basis makes, and the one that `plain` renders of the same samples, must agree to 10⁻⁶ of the mean; and so must the
/// variances of their samples, to what differences of sums leave over.
fn compare(basis: &Basis, x: &[Vec<f64>; 3], plain: &[Told]) {
    let mean = plain.iter().flat_map(|told| told.0).map(f64::from).sum::<f64>() / 48.0;
    assert!(mean > 0.01);
    for (pixel, (expected, variance)) in plain.iter().enumerate() {
        let value = Mixture::new(x).of(basis.pixel(pixel, 0));
        for c in 0..3 {
            let (value, expected) = (value[c], expected[c] as f64);
            assert!((value - expected).abs() < 1e-6 * (mean + expected), "pixel {pixel}, channel {c}: {value} is not {expected}");
            let (value, expected) = (basis.variances[pixel][c], variance[c]);
            let near = 1e-4 * (expected + (mean * mean) as f32);
            assert!((value - expected).abs() < near, "pixel {pixel}, channel {c}: a variance of {value} is not {expected}");
        }
    }
    assert!(plain.iter().any(|(expected, variance)| variance[0] > 0.01 * expected[0] * expected[0]));
}

/// Renders with a material's own numbers, and makes every choice on the way as `guide` does.
struct Plain<'a, T> {
    guide: T,
    rules: &'a Rules,
    material: MaterialId,
    /// How often a path may meet the material.
    order: u8,
    sum: &'a mut [f32],
}

/// What guides a path, its radiance per radiance at its end, and how often it met the material.
type Beta<B> = (B, Rgb, u8);

struct Surface<S> {
    guide: S,
    own: Bsdf,
    unknown: bool,
}

impl<S: Scattering> Scattering for Surface<S> {
    fn bsdf(&self) -> &Bsdf {
        self.guide.bsdf()
    }
    fn is_known(&self) -> bool {
        self.guide.is_known()
    }
    fn deltas(&self) -> &[Option<Delta>; 2] {
        self.guide.deltas()
    }
    fn weights(&self) -> [f64; 4] {
        self.guide.weights()
    }
    fn ways(&self, part: Part) -> usize {
        self.guide.ways(part)
    }
    fn sample(&mut self, part: Part, way: usize, u: [f64; 2]) -> Option<Vec3> {
        self.guide.sample(part, way, u)
    }
    fn lamp_ratio(&self, part: Part, wi: Vec3) -> Option<f64> {
        self.guide.lamp_ratio(part, wi)
    }
}

/// The density with which a guide draws directions from a part.
trait Densities: Transport {
    fn density(&self, surface: &Self::Surface, part: Part, wi: Vec3) -> f64;
}

impl Densities for rough::Tagging<'_, 1> {
    fn density(&self, surface: &Self::Surface, part: Part, wi: Vec3) -> f64 {
        match surface {
            rough::Surface::Known(bsdf) => bsdf.pdf(part, wi),
            rough::Surface::Unknown { shape, repeated, .. } => self.shape(shape, repeated, part, wi, Arriving::Indirect).1,
        }
    }
}

impl Densities for clear::Dimming<'_> {
    fn density(&self, surface: &Self::Surface, part: Part, wi: Vec3) -> f64 {
        surface.bsdf().pdf(part, wi)
    }
}

impl<T: Densities> Plain<'_, T> {
    fn met(&self, beta: &Beta<T::Beta>, surface: &Surface<T::Surface>, factor: Rgb) -> (Rgb, u8) {
        match surface.unknown {
            true if beta.2 == self.order => (Rgb::ZERO, beta.2),
            unknown => (beta.1 * factor, beta.2 + unknown as u8),
        }
    }
}

impl<T: Densities> Transport for Plain<'_, T> {
    type Beta = Beta<T::Beta>;
    type Surface = Surface<T::Surface>;

    fn start(&self) -> Self::Beta {
        (self.guide.start(), Rgb::ONE, 0)
    }
    fn scale(&self, beta: &mut Self::Beta, by: Rgb) {
        self.guide.scale(&mut beta.0, by);
        beta.1 *= by;
    }
    fn size(&self, beta: &Self::Beta) -> f64 {
        self.guide.size(&beta.0)
    }
    fn surface(&self, layer: &Layer, rules: &Rules) -> Self::Surface {
        let unknown = layer.id == self.material && layer.material.is_some();
        Surface { guide: self.guide.surface(layer, rules), own: layer.bsdf(rules), unknown }
    }
    fn aimed(&self, beta: &Self::Beta, surface: &Self::Surface, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> Self::Beta {
        let weights = std::array::from_fn(|k| match counts[k] {
            0.0 if arriving == Arriving::Indirect => 0.0,
            count => 1.0 / (pdf + if count > 0.0 { count * self.guide.density(&surface.guide, Part::ALL[k], wi) } else { 0.0 }),
        });
        let value = surface.own.value(wi, arriving, &weights, self.rules);
        let (value, met) = self.met(beta, surface, value);
        (self.guide.aimed(&beta.0, &surface.guide, wi, arriving, pdf, counts), value, met)
    }
    fn drawn(&self, beta: &Self::Beta, surface: &Self::Surface, wi: Vec3, part: Part, way: usize, count: f64) -> (Self::Beta, f64) {
        let (guide, density) = self.guide.drawn(&beta.0, &surface.guide, wi, part, way, count);
        let value = surface.own.value(wi, Arriving::Indirect, &part.alone(1.0 / density), self.rules);
        let (value, met) = self.met(beta, surface, value);
        ((guide, value, met), density)
    }
    fn ambient(&self, beta: &Self::Beta, surface: &Self::Surface, side: usize) -> Self::Beta {
        let (value, met) = self.met(beta, surface, surface.own.ambient[side]);
        (self.guide.ambient(&beta.0, &surface.guide, side), value, met)
    }
    fn follow(&self, beta: &Self::Beta, surface: &Self::Surface, delta: &Delta) -> Self::Beta {
        let own = surface.own.deltas.iter().flatten().find(|d| d.reflected == delta.reflected).unwrap();
        (self.guide.follow(&beta.0, &surface.guide, delta), beta.1 * own.coefficient, beta.2)
    }
    fn absorb(&self, beta: &mut Self::Beta, medium: &Inside, length: f64) {
        self.guide.absorb(&mut beta.0, medium, length);
        // The guide's medium knows no numbers.
        if medium.unknown.is_some() {
            beta.1 *= Inside::of(-Rgb::from(dim().map(f64::ln))).transmittance(length);
        } else {
            beta.1 *= medium.transmittance(length);
        }
    }
    fn extinction(&self, medium: &Inside) -> Rgb {
        self.guide.extinction(medium)
    }
    fn collect(&mut self, beta: &Self::Beta, radiance: Rgb) {
        let light = beta.1 * radiance;
        self.sum.iter_mut().zip(light.to_array()).for_each(|(sum, v)| *sum += v as f32);
    }
}

impl<T: Densities> Columns for Plain<'_, T> {
    fn columns(&mut self) -> &mut [f32] {
        self.sum
    }
}

fn plain<'c, T: Columns>(world: &World, rules: &Rules, picture: &'c mut [Told; 16], transport: impl Fn(&'c mut [f32]) -> T) {
    let piece = |(number, (columns, variance)): (usize, &'c mut Told)| Piece { number, set: 0, samples: 0..SAMPLES, columns, variance };
    let mixture = Mixture::new(&[1.0; 3].map(|one| vec![one]));
    follow(world, rules, &lens, SEED, picture.iter_mut().enumerate().map(piece), Some(&mixture), transport);
}

/// Bases against renderings with five sets of numbers, at roughnesses that are nodes: lamps integrated, by RADIANCE's rule, and by its single samples.
fn check_rough(kind: Kind, name: &str, sets: [&[f64]; 5]) {
    check_rough_by(Rules { ambient_bounces: 3, ..Rules::default() }, kind, name, sets);
    let by_radiances = Rules { ambient_bounces: 3, light_jitter: Some(0.3), ..Rules::default() };
    check_rough_by(by_radiances.clone(), kind, name, sets);
    check_rough_by(Rules { specular_sampling: Some(1.0), ..by_radiances }, kind, name, sets);
}

fn check_rough_by(rules: Rules, kind: Kind, name: &str, sets: [&[f64]; 5]) {
    let grid = [vec![0.05, 0.08, 0.12, 0.2, 0.3], vec![]];
    let write = |a: &[f64]| format!("{name} thing 0 0 {} {}", a.len(), a.iter().map(|v| v.to_string() + " ").collect::<String>());
    let (start, material) = world(&write(sets[0]), &rules);
    let nodes: Vec<[f64; 2]> = alphas(kind, &grid);
    let rough = Rough::new(material, kind.metal, kind.transmits, nodes, [0.06, 0.15].map(|a| [a * a; 2]).to_vec());
    assert!(grid[0].len() <= LANES);
    for a in sets {
        let mut x = coefficients(kind, &rough.monomials, &grid, a);
        // The plain rendering ends where products do.
        x.iter_mut().for_each(|x| x[rough.monomials.told()..].fill(0.0));
        let basis = basis(&start, &rules, Explored::Rough(&rough), &x);
        let (world, _) = world(&write(a), &rules);
        let mut picture = [Told::default(); 16];
        plain(&world, &rules, &mut picture, |sum| Plain {
            guide: rough::Tagging::<1> { rules: &rules, unknown: &rough, columns: &mut [] },
            rules: &rules,
            material,
            order: ORDER as u8,
            sum,
        });
        compare(&basis, &x, &picture);
    }
}

#[test]
fn a_basis_of_plastic_is_the_picture() {
    let kind = Kind::named("plastic").unwrap();
    let sets: [&[f64]; 5] = [
        &[0.5, 0.5, 0.5, 0.05, 0.12],
        &[0.7, 0.7, 0.7, 0.12, 0.12],
        &[0.1, 0.9, 0.0, 0.0, 0.2],
        &[1.0, 0.3, 0.6, 0.3, 0.05],
        &[0.2, 0.2, 0.9, 0.07, 0.3],
    ];
    check_rough(kind, "plastic", sets);
}

#[test]
fn a_basis_of_metal_is_the_picture() {
    let kind = Kind::named("metal").unwrap();
    let sets: [&[f64]; 5] = [
        &[0.5, 0.5, 0.5, 0.5, 0.12],
        &[0.8, 0.6, 0.3, 0.9, 0.05],
        &[0.1, 0.9, 0.0, 1.0, 0.2],
        &[1.0, 0.3, 0.6, 0.4, 0.08],
        &[0.2, 0.2, 0.9, 0.7, 0.3],
    ];
    check_rough(kind, "metal", sets);
}

#[test]
fn a_basis_of_trans_is_the_picture() {
    let kind = Kind::named("trans").unwrap();
    let sets: [&[f64]; 5] = [
        &[0.5, 0.5, 0.5, 0.05, 0.12, 0.5, 0.5],
        &[0.8, 0.6, 0.3, 0.0, 0.05, 1.0, 0.0],
        &[0.1, 0.9, 0.0, 0.2, 0.2, 0.3, 1.0],
        &[1.0, 0.3, 0.6, 0.1, 0.08, 0.8, 0.3],
        &[0.2, 0.2, 0.9, 0.3, 0.3, 0.0, 0.5],
    ];
    check_rough(kind, "trans", sets);
}

/// The nodes of three transmissivities.
const DIM: [usize; 3] = [5, 8, 11];

/// Those transmissivities.
fn dim() -> [f64; 3] {
    DIM.map(|node| Clear::new(MaterialId::default(), false, 1.5, 1.0).nodes[node])
}

#[test]
fn a_basis_of_dielectric_is_the_picture() {
    let rules = Rules { ambient_bounces: 1, ..Rules::default() };
    for index in [1.5, 1.3, 1.0, 0.8, 2.0] {
        let [red, green, blue] = dim();
        let (world, material) = world(&format!("dielectric thing 0 0 5 {red} {green} {blue} {index} 0"), &rules);
        let clear = || {
            let mut clear = Clear::new(material, false, index, 1.0);
            clear.guess = Rgb::new(0.1, 0.4, 0.9);
            clear
        };
        let (clear, guide) = (clear(), clear());
        let x = DIM.map(|node| (0..clear.columns()).map(|i| f64::from(i == node)).collect::<Vec<_>>());
        let mut picture = [Told::default(); 16];
        plain(&world, &rules, &mut picture, |sum| Plain {
            guide: clear::Dimming { colors: Radiance { rules: &rules, sum: Rgb::ZERO }, unknown: &guide, columns: &mut [] },
            rules: &rules,
            material,
            order: u8::MAX,
            sum,
        });
        compare(&basis(&world, &rules, Explored::Clear(&clear), &x), &x, &picture);
    }
}
