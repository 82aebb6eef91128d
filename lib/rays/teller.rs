//! The record of a ray: what it meets, and the light that it brings.

use super::fields::{Field, Fields, Space, Writer};
use super::tree::{DARK, Fate, Met, Tree, nothing};
use super::{Asked, Form, Format};
use crate::accel::Hit;
use crate::color::Rgb;
use crate::geometry::{FAR, Ray};
use crate::integrator::{Integrator, Outcome, Radiance};
use crate::render::{Budget, Pixel, Task};
use crate::rules::Rules;
use crate::sampling::Sampler;
use crate::vector::Vec3;
use crate::world::{Coming, World};
use rayon::prelude::*;

/// Tells of rays.
pub struct Teller<'w> {
    /// The scene.
    pub world: &'w World,
    /// The rules of its light.
    pub rules: &'w Rules,
    /// What is told.
    pub fields: &'w Fields,
    /// In which form.
    pub format: Format,
    /// In which colours.
    pub space: Space,
    /// How accurately, each ray by itself. The rays that a ray leads to are those of one sample, unless a number is given.
    pub budget: Budget,
    /// Fixes every random choice.
    pub seed: u64,
    /// Whether the length of the direction is how far the ray goes.
    pub limited: bool,
    /// Whether a ray is a point and a direction to face, whose irradiance is wanted.
    pub irradiance: bool,
}

/// How far above a point RADIANCE measures irradiance, and how far the ray that stands for it is from there.
const ABOVE: f64 = 1e-4;
const BEFORE: f64 = 1e-5;

impl Asked {
    /// Where irradiance on the side of the direction is measured, and the ray that stands for it.
    fn facing(&self) -> (Vec3, Ray) {
        let Ray { origin, direction } = self.ray;
        (origin + direction * ABOVE, Ray::new(origin + direction * (ABOVE + BEFORE), -direction))
    }
}

/// What is known of a ray in the end.
struct Record<'a, 'w> {
    ray: &'a Ray,
    met: &'a Met<'w>,
    fate: &'a Fate,
    weight: f64,
    coefficient: &'a Rgb,
    contribution: &'a Rgb,
}

impl<'w> Teller<'w> {
    /// What takes the records of about so many rays.
    pub fn writer(&self, rays: usize) -> Writer {
        // Most are of numbers of a few bytes.
        Writer { bytes: Vec::with_capacity(rays * self.fields.ray.len() * 16), form: self.format.output, space: self.space }
    }

    /// Writes the records of rays, whose numbers from `first` on make their random choices their own.
    pub fn tell(&self, rays: &[Asked], first: u64, writer: &mut Writer) {
        if self.irradiance || !self.fields.every.is_empty() || !self.fields.needs.first {
            return rays.iter().zip(first..).for_each(|(asked, number)| self.tell_one(asked, number, None, writer));
        }
        let limited = rays.iter().map(|asked| (&asked.ray, self.limit(asked)));
        self.world.nearest_each(limited, |n, hit| self.tell_one(&rays[n], first + n as u64, hit.as_ref(), writer));
    }

    /// How far a ray goes.
    fn limit(&self, asked: &Asked) -> f64 {
        if self.limited { asked.length } else { f64::INFINITY }
    }

    /// Writes the record of a ray, given what it meets first if the record needs that. Inlined, with what it does for the simplest record, since
    /// where only the first surface is asked for, calls would take as long as finding that.
    #[inline(always)]
    fn tell_one(&self, asked: &Asked, number: u64, hit: Option<&Hit>, writer: &mut Writer) {
        if asked.ray.direction == Vec3::ZERO {
            return self.empty(asked, writer);
        }
        if self.irradiance {
            return self.irradiance(asked, number, writer);
        }
        let (ray, limit) = (&asked.ray, self.limit(asked));
        if !self.fields.every.is_empty() {
            return self.every(ray, limit, number, writer);
        }
        let mut met = nothing(ray);
        if self.fields.needs.first {
            self.meet(ray, hit, limit, &mut met);
        }
        // Referred to where it is, as each copy would wait for what was written just before.
        let found;
        let fate = if self.fields.needs.branches {
            found = self.branches(ray, limit, number);
            &found
        } else if self.fields.needs.light {
            let light = self.light(number, |integrator, light, sampler| integrator.trace(light, *ray, limit, sampler));
            found = Fate { light, ..DARK };
            &found
        } else {
            &DARK
        };
        self.write(writer, &self.fields.ray, &whole(ray, &met, fate));
    }

    /// Writes the record that answers a ray without direction: that of a ray like the one before it, which met nothing.
    pub fn empty(&self, before: &Asked, writer: &mut Writer) {
        let ray = if self.irradiance { before.facing().1 } else { before.ray };
        self.write(writer, &self.fields.ray, &whole(&ray, &nothing(&ray), &DARK));
    }

    /// Writes the record of the irradiance at a point on the side of a direction.
    fn irradiance(&self, asked: &Asked, number: u64, writer: &mut Writer) {
        let (point, ray) = asked.facing();
        let light = self.light(number, |integrator, light, sampler| integrator.irradiance(light, point, asked.ray.direction, sampler));
        let met = Met { point, length: BEFORE, ..nothing(&ray) };
        let fate = Fate { light, unmirrored_length: BEFORE, ..DARK };
        self.write(writer, &self.fields.ray, &whole(&ray, &met, &fate));
    }

    /// The light that a ray brings, by way of mirrors and without, and how long these ways are.
    fn branches(&self, ray: &Ray, limit: f64, number: u64) -> Fate {
        let mut tree = Tree::new(self.world, self.rules, false);
        let mut integrator = Integrator::new(self.world, self.rules);
        let pixel = Pixel::converged(self.budget, self.seed, number, |sampler| {
            let before = tree.sum();
            let outcome = integrator.trace(&mut tree, *ray, limit, sampler);
            (tree.sum() - before, outcome)
        });
        // All samples were followed; not all of them may count.
        let (fate, light) = (tree.fates()[0], pixel.mean());
        let part = |c: usize| if fate.light[c] == 0.0 { 0.0 } else { fate.mirrored[c] / fate.light[c] };
        Fate { light, mirrored: light * Rgb::from([0, 1, 2].map(part)), ..fate }
    }

    /// The light that a ray brings, or a point gathers, whichever is `sampled`.
    fn light(&self, number: u64, sampled: impl Fn(&mut Integrator<'w, Rgb>, &mut Radiance<'w>, Sampler) -> Outcome) -> Rgb {
        let mut integrator = Integrator::new(self.world, self.rules);
        let pixel = Pixel::converged(self.budget, self.seed, number, |sampler| {
            let mut light = Radiance { rules: self.rules, sum: Rgb::ZERO };
            let outcome = sampled(&mut integrator, &mut light, sampler);
            (light.sum, outcome)
        });
        pixel.mean()
    }

    /// Takes in what a ray meets first.
    #[inline(always)]
    fn meet(&self, ray: &Ray, hit: Option<&Hit>, limit: f64, met: &mut Met<'w>) {
        met.meet(self.world, ray, hit, limit, self.fields.needs.known);
        if let Some(hit) = hit.filter(|_| self.fields.needs.layers) {
            self.see(ray, hit, met);
        }
    }

    /// Takes in what most of a surface is made of.
    fn see(&self, ray: &Ray, hit: &Hit, first: &mut Met<'w>) {
        let coming = Coming::viewer(ray);
        let mut share = 0.0;
        self.world.layers(hit, &coming, self.rules, &mut |layer| {
            if layer.fraction > share {
                first.see(layer);
                share = layer.fraction;
            }
        });
    }

    /// Writes the records of all rays that a ray leads to, sample by sample, each before the one that it comes from; its own at last.
    fn every(&self, ray: &Ray, limit: f64, number: u64, writer: &mut Writer) {
        let mut integrator = Integrator::new(self.world, self.rules);
        let samples = if let Budget::Samples(samples) = self.budget { samples } else { 1 };
        let mut sum = Rgb::ZERO;
        for index in 0..samples {
            let mut tree = Tree::new(self.world, self.rules, true);
            let outcome = integrator.trace(&mut tree, *ray, limit, Sampler::new(self.seed, number, 0, index));
            let fates = tree.fates();
            self.descend(&tree, &fates, writer);
            sum += tree.sum();
            if index + 1 == samples || !outcome.random {
                let light = if outcome.random { sum / samples as f64 } else { tree.sum() };
                let fate = Fate { light, ..own(&tree, &fates, 0).0 };
                return self.write(writer, &self.fields.ray, &record(&tree, 0, &(fate, light)));
            }
        }
    }

    /// Writes the records of all rays of a tree, each after those of the rays that it leads to.
    fn descend(&self, tree: &Tree<'w>, fates: &[Fate], writer: &mut Writer) {
        let mut open = vec![(0, 0, false)];
        while let Some((node, level, told)) = open.pop() {
            if !told {
                open.push((node, level, true));
                open.extend(tree.children(node, fates, self.fields.shadows).into_iter().rev().map(|child| (child, level + 1, false)));
            } else if self.fields.tells_of(tree.nodes[node].met.names.map(|n| n.modifier)) {
                // Tabs are written in every form.
                writer.bytes.extend(std::iter::repeat_n(b'\t', level));
                self.write(writer, &self.fields.every, &record(tree, node, &own(tree, fates, node)));
            }
        }
    }

    #[inline(always)]
    fn write(&self, writer: &mut Writer, fields: &[Field], record: &Record) {
        let Record { ray, met, fate, .. } = record;
        for field in fields {
            match field {
                Field::Origin => writer.vector(ray.origin),
                Field::Direction => writer.vector(ray.direction),
                Field::Value => writer.color(fate.light),
                Field::Contribution => writer.color(*record.contribution),
                Field::Weight => writer.numbers([record.weight]),
                Field::Coefficient => writer.color(*record.coefficient),
                Field::Effective => writer.numbers([fate.effective()]),
                Field::Length => writer.numbers([met.length]),
                Field::Local => writer.numbers(met.local),
                Field::Point => writer.vector(met.point),
                Field::Normal => writer.vector(met.normal),
                Field::Unperturbed => writer.vector(met.unperturbed),
                Field::Surface => writer.name(met.names.map_or("*", |n| n.surface)),
                Field::Modifier => writer.name(met.names.map_or("*", |n| n.modifier)),
                Field::Material => writer.name(met.names.map_or("*", |n| n.material)),
                Field::Mirrored => writer.color(fate.mirrored),
                Field::MirroredLength => writer.numbers([fate.mirrored_length]),
                Field::Unmirrored => writer.color(fate.unmirrored()),
                Field::UnmirroredLength => writer.numbers([fate.unmirrored_length]),
                Field::Tilde => writer.name("~"),
            }
        }
        if !fields.is_empty() && self.format.output != Form::Color {
            writer.end();
        }
    }
}

/// The effective lengths of the central rays of a picture's pixels, by way of flat mirrors and panes; 1e10 where nothing is.
pub fn lengths(task: &Task) -> Vec<f64> {
    let length = |number: usize| {
        let Some((origin, direction, limit)) = (task.lens)(number, [0.5; 2]) else { return FAR };
        let mut tree = Tree::new(task.world, task.rules, false);
        let sampler = Sampler::new(task.seed, number as u64, 0, 0);
        Integrator::new(task.world, task.rules).trace(&mut tree, Ray { origin, direction }, limit, sampler);
        tree.fates()[0].effective()
    };
    (0..task.count).into_par_iter().map(length).collect()
}

/// The record of a ray that was asked about.
fn whole<'a, 'w>(ray: &'a Ray, met: &'a Met<'w>, fate: &'a Fate) -> Record<'a, 'w> {
    Record { ray, met, fate, weight: 1.0, coefficient: &Rgb::ONE, contribution: &fate.light }
}

/// What becomes of a ray in a tree by itself, and what its light comes to at the viewer.
fn own(tree: &Tree, fates: &[Fate], node: usize) -> (Fate, Rgb) {
    let (fate, coefficient) = (fates[node], tree.nodes[node].coefficient);
    let own = |light: Rgb| Rgb::select(coefficient.cmpeq(Rgb::ZERO), Rgb::ZERO, light / coefficient);
    (Fate { light: own(fate.light), mirrored: own(fate.mirrored), ..fate }, fate.light)
}

/// The record of a ray in a tree.
fn record<'a, 'w>(tree: &'a Tree<'w>, node: usize, (fate, contribution): &'a (Fate, Rgb)) -> Record<'a, 'w> {
    let at = &tree.nodes[node];
    let coefficient = if tree.missed(node) { &Rgb::ZERO } else { &at.coefficient };
    Record { ray: &at.ray, met: &at.met, fate, weight: at.weight, coefficient, contribution }
}
