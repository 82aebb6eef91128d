//! The rays that a ray leads to: what each met, what light it brought, how long it was.

use crate::accel::Hit;
use crate::bsdf::{Arriving, Bsdf, Delta, Part};
use crate::color::{Rgb, bright};
use crate::geometry::{FAR, Ray, TINY};
use crate::integrator::{Kind, Radiance, Transport, Visit};
use crate::material::{Inside, Material};
use crate::rules::Rules;
use crate::vector::Vec3;
use crate::world::{Layer, Names, World};

/// A ray, and what became of it.
#[derive(Clone, Debug)]
pub struct Node<'w> {
    /// The ray.
    pub ray: Ray,
    /// How it came to be.
    pub kind: Kind,
    /// RADIANCE's weight of it.
    pub weight: f64,
    /// What light that it finds is multiplied with, on the way to its end too.
    pub coefficient: Rgb,
    /// The light found at its end, times the coefficient, summed over the samples.
    light: Rgb,
    /// Whether there was light at its end.
    lit: bool,
    /// Whether it looks for a light.
    shadow: bool,
    /// What it met.
    pub met: Met<'w>,
    /// Whether the length of the mirrored ray, and of the one that goes on, add to its own.
    extends: [bool; 2],
    /// The share of the layer that the normal is of.
    share: f64,
    /// The rays it leads to, by their places in the list.
    children: Vec<usize>,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug)]
pub struct Met<'w> {
    /// How far it is; [`FAR`] for what is beyond all surfaces.
    pub length: f64,
    /// Where it is; the origin of the ray for what is beyond all surfaces, the end of the ray if nothing was met within its limit.
    pub point: Vec3,
    /// The normal there, bent by textures, on the viewer's side for surfaces that have no sides of their own; zero for nothing.
    pub normal: Vec3,
    /// The normal of the surface itself; zero for nothing.
    pub unperturbed: Vec3,
    /// Coordinates on the surface of a mesh.
    pub local: [f64; 2],
    /// What it is called; `None` for nothing, and where nobody asks.
    pub names: Option<Names<'w>>,
}

/// What became of a ray in the end: RADIANCE's mirrored and unmirrored parts.
#[derive(Clone, Copy, Debug)]
pub struct Fate {
    /// The light it brings, times its coefficient.
    pub light: Rgb,
    /// The part of it that came by way of a mirror.
    pub mirrored: Rgb,
    /// The length of the way by the mirror.
    pub mirrored_length: f64,
    /// The length of the way without it.
    pub unmirrored_length: f64,
}

/// What becomes of a ray that finds no light.
pub const DARK: Fate = Fate { light: Rgb::ZERO, mirrored: Rgb::ZERO, mirrored_length: FAR, unmirrored_length: FAR };

impl Fate {
    /// The light that came by no mirror. (Inlined, it would be reckoned for records that do not tell it.)
    #[inline(never)]
    pub fn unmirrored(&self) -> Rgb {
        self.light - self.mirrored
    }

    /// The length of the way that brings more light. (Not inlined either.)
    #[inline(never)]
    pub fn effective(&self) -> f64 {
        if bright(self.mirrored) > 0.5 * bright(self.light) { self.mirrored_length } else { self.unmirrored_length }
    }
}

/// A transport that keeps the rays it hears of.
pub struct Tree<'w> {
    world: &'w World,
    colors: Radiance<'w>,
    /// Whether all rays are kept; otherwise only those that nothing was left to chance for, each once.
    all: bool,
    /// The rays, each after the one that it comes from.
    pub nodes: Vec<Node<'w>>,
}

/// A throughput, and the ray it is the throughput of.
#[derive(Clone, Copy)]
pub struct Beta {
    color: Rgb,
    node: usize,
    /// Whether it is the throughput of a ray that is not kept, and comes from `node`.
    beyond: bool,
}

/// The place of no ray.
const NONE: usize = usize::MAX;

impl<'w> Tree<'w> {
    /// An empty tree, for all rays or for those that nothing is left to chance for.
    pub fn new(world: &'w World, rules: &'w Rules, all: bool) -> Self {
        Self { world, colors: Radiance { rules, sum: Rgb::ZERO }, all, nodes: Vec::new() }
    }

    /// All light found so far.
    pub fn sum(&self) -> Rgb {
        self.colors.sum
    }

    /// The rays that a ray leads to, in RADIANCE's order: those that go on, mirrored ones, scattered ones, then those that looked for a light
    /// and found it, the brightest first; without `shadows`, only those that came through something.
    pub fn children(&self, node: usize, fates: &[Fate], shadows: bool) -> Vec<usize> {
        let order = |kind: Kind| match kind {
            Kind::Primary | Kind::Passed | Kind::Transmitted => 0,
            Kind::Reflected => 1,
            Kind::Scattered => 2,
            Kind::Shadow => 3,
        };
        let mut children: Vec<(u8, f64, usize)> = Vec::new();
        for &child in &self.nodes[node].children {
            let (kind, light) = (self.nodes[child].kind, bright(fates[child].light));
            let told = light > 0.0 && (shadows || !self.nodes[child].lit);
            if kind != Kind::Shadow {
                children.push((order(kind), 0.0, child));
            } else if told {
                children.push((order(kind), -light, child));
            }
        }
        children.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        children.into_iter().map(|(.., child)| child).collect()
    }

    /// Whether a ray was aimed at a light and did not meet it.
    pub fn missed(&self, node: usize) -> bool {
        self.nodes[node].shadow && !self.nodes[node].lit
    }

    /// What becomes of each ray.
    pub fn fates(&self) -> Vec<Fate> {
        let mut fates = vec![DARK; self.nodes.len()];
        // Rays stand behind those that they come from.
        for node in (0..fates.len()).rev() {
            fates[node] = self.fate(node, &fates);
        }
        fates
    }

    /// What becomes of a ray, where that is known of those that it leads to.
    fn fate(&self, node: usize, fates: &[Fate]) -> Fate {
        let Node { met, extends, light, children, .. } = &self.nodes[node];
        let mut fate = Fate { light: *light, unmirrored_length: met.length, ..DARK };
        for &child in children {
            let next = fates[child];
            fate.light += next.light;
            match self.nodes[child].kind {
                Kind::Passed => {
                    fate.mirrored += next.mirrored;
                    fate.mirrored_length = met.length + next.mirrored_length;
                    fate.unmirrored_length = met.length + next.unmirrored_length;
                }
                Kind::Reflected => {
                    fate.mirrored += next.light;
                    fate.mirrored_length = met.length + if extends[0] { next.effective() } else { 0.0 };
                }
                Kind::Transmitted if extends[1] => fate.unmirrored_length = met.length + next.effective(),
                _ => {}
            }
        }
        fate
    }

    /// The kept child of `parent` that this ray is.
    fn known(&self, parent: usize, visit: &Visit) -> Option<usize> {
        let same = |&&child: &&usize| {
            let node = &self.nodes[child];
            node.kind == visit.kind && node.ray.direction.distance_squared(visit.ray.direction) < 1e-20
        };
        match parent {
            NONE => (!self.nodes.is_empty()).then_some(0),
            _ => self.nodes[parent].children.iter().find(same).copied(),
        }
    }
}

/// What a ray meets that meets nothing.
pub fn nothing<'w>(ray: &Ray) -> Met<'w> {
    Met { length: FAR, point: ray.origin, normal: Vec3::ZERO, unperturbed: Vec3::ZERO, local: [0.0; 2], names: None }
}

impl<'w> Met<'w> {
    /// Takes in what a ray of the limit `limit` meets first; the normal is its own until a layer says otherwise. What is not to be
    /// `known` gets no names, and no normal beyond all surfaces.
    #[inline(always)]
    pub fn meet(&mut self, world: &'w World, ray: &Ray, hit: Option<&Hit>, limit: f64, known: bool) {
        match hit {
            Some(hit) => {
                (self.length, self.point) = (hit.t, hit.point);
                (self.normal, self.unperturbed) = (hit.normal, hit.normal);
                if known {
                    self.names = Some(world.names(hit));
                }
            }
            None if limit.is_finite() => self.point = ray.at(limit),
            None if known => {
                if let Some(names) = world.source_names(ray.direction) {
                    (self.normal, self.unperturbed) = (-ray.direction, -ray.direction);
                    self.names = Some(names);
                }
            }
            None => {}
        }
    }

    /// Takes in what a layer says of the normal.
    pub fn see(&mut self, layer: &Layer) {
        let turns =
            layer.material.is_some_and(|m| matches!(m.material, Material::Reflectance(_) | Material::Ashikhmin(_) | Material::Glass(_)));
        let side = if turns || layer.at.rdot > 0.0 { 1.0 } else { -1.0 };
        self.normal = layer.point.shading * side;
        self.local = layer.at.uv;
    }
}

/// Whether the ways by a mirror, and straight on, are longer than the way to the surface, as RADIANCE reckons: it adds the rest of the way for
/// flat mirrors and panes, and for what mostly lets light through.
fn extends(layer: &Layer, rules: &Rules) -> [bool; 2] {
    let even = layer.point.perturbation == Vec3::ZERO;
    let flat = even && layer.point.flat;
    let Some(named) = layer.material.filter(|_| layer.emission.is_none()) else { return [false; 2] };
    match &named.material {
        Material::Mirror(_) => [flat, false],
        Material::Glass(_) => [flat, even],
        Material::Dielectric(inside) => [flat, flat || (inside.index - 1.0).abs() <= TINY],
        Material::Interface(inside, outside) => [flat, flat || (inside.index / outside.index - 1.0).abs() <= TINY],
        Material::Reflectance(_) => {
            let bsdf = layer.bsdf(rules);
            let straight = bsdf.deltas[1].map_or(0.0, |d| d.coefficient.max_element());
            [false, straight > (bsdf.diffuse[0] + bsdf.diffuse[1]).max_element()]
        }
        _ => [false; 2],
    }
}

impl<'w> Transport for Tree<'w> {
    type Beta = Beta;
    type Surface = Bsdf;

    const WATCHES: bool = true;

    fn start(&self) -> Beta {
        Beta { color: self.colors.start(), node: NONE, beyond: false }
    }

    fn scale(&self, beta: &mut Beta, by: Rgb) {
        self.colors.scale(&mut beta.color, by);
    }

    fn size(&self, beta: &Beta) -> f64 {
        self.colors.size(&beta.color)
    }

    fn surface(&self, layer: &Layer, rules: &Rules) -> Bsdf {
        self.colors.surface(layer, rules)
    }

    fn aimed(&self, beta: &Beta, surface: &Bsdf, wi: Vec3, arriving: Arriving, pdf: f64, counts: &[f64; 4]) -> Beta {
        Beta { color: self.colors.aimed(&beta.color, surface, wi, arriving, pdf, counts), ..*beta }
    }

    fn drawn(&self, beta: &Beta, surface: &Bsdf, wi: Vec3, part: Part, way: usize, count: f64) -> (Beta, f64) {
        let (color, density) = self.colors.drawn(&beta.color, surface, wi, part, way, count);
        (Beta { color, ..*beta }, density)
    }

    fn ambient(&self, beta: &Beta, surface: &Bsdf, side: usize) -> Beta {
        Beta { color: self.colors.ambient(&beta.color, surface, side), ..*beta }
    }

    fn follow(&self, beta: &Beta, surface: &Bsdf, delta: &Delta) -> Beta {
        Beta { color: self.colors.follow(&beta.color, surface, delta), ..*beta }
    }

    fn absorb(&self, beta: &mut Beta, medium: &Inside, length: f64) {
        self.colors.absorb(&mut beta.color, medium, length);
    }

    fn collect(&mut self, beta: &Beta, radiance: Rgb) {
        self.colors.collect(&beta.color, radiance);
        if let Some(node) = self.nodes.get_mut(beta.node) {
            node.light += beta.color * radiance;
            node.lit |= !beta.beyond;
        }
    }

    fn visit(&mut self, beta: &mut Beta, visit: &Visit) {
        beta.beyond |= !self.all && matches!(visit.kind, Kind::Scattered | Kind::Shadow);
        if beta.beyond {
            return;
        }
        let parent = beta.node;
        if !self.all
            && let Some(known) = self.known(parent, visit)
        {
            beta.node = known;
            return;
        }
        beta.node = self.nodes.len();
        if let Some(parent) = self.nodes.get_mut(parent) {
            parent.children.push(beta.node);
        }
        let mut coefficient = beta.color;
        if visit.hit.is_none() && visit.limit == f64::INFINITY {
            self.colors.absorb(&mut coefficient, visit.medium, f64::INFINITY);
        }
        let mut met = nothing(visit.ray);
        met.meet(self.world, visit.ray, visit.hit, visit.limit, true);
        self.nodes.push(Node {
            ray: *visit.ray,
            kind: visit.kind,
            weight: visit.weight,
            coefficient,
            light: Rgb::ZERO,
            lit: false,
            shadow: visit.shadow,
            met,
            extends: [false; 2],
            share: 0.0,
            children: Vec::new(),
        });
    }

    fn meet(&mut self, beta: &Beta, layer: &Layer) {
        let rules = self.colors.rules;
        if let Some(node) = self.nodes.get_mut(beta.node).filter(|_| !beta.beyond) {
            let [mirrored, unmirrored] = extends(layer, rules);
            node.extends = [node.extends[0] | mirrored, node.extends[1] | unmirrored];
            if layer.fraction > node.share {
                node.met.see(layer);
                node.share = layer.fraction;
                node.coefficient = beta.color * (1.0 / layer.fraction);
            }
        }
    }
}
