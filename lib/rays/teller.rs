//! The record of a ray: what it meets, and the light that it brings.

use super::fields::{Field, Fields, Space, Writer};
use super::tree::{FAR, Fate, Met, Tree, met};
use super::{Form, Format};
use crate::color::Rgb;
use crate::geometry::Ray;
use crate::integrator::{Integrator, Radiance};
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

/// What is known of a ray in the end.
struct Record<'w> {
    ray: Ray,
    met: Met<'w>,
    fate: Fate,
    weight: f64,
    coefficient: Rgb,
    contribution: Rgb,
}

impl<'w> Teller<'w> {
    /// What takes records.
    pub fn writer(&self) -> Writer {
        Writer { bytes: Vec::new(), form: self.format.output, space: self.space }
    }

    /// Writes the record of a ray; `number` makes its random choices its own.
    pub fn tell(&self, ray: [f64; 6], number: u64, writer: &mut Writer) {
        let (origin, direction) = (Vec3::new(ray[0], ray[1], ray[2]), Vec3::new(ray[3], ray[4], ray[5]));
        let Some(unit) = direction.try_normalize() else { return self.empty(ray, writer) };
        let record = if self.irradiance {
            self.irradiance(origin, unit, number)
        } else {
            let limit = if self.limited { direction.length() } else { f64::INFINITY };
            self.radiance(Ray::new(origin, unit), limit, number, writer)
        };
        self.write(writer, &self.fields.ray, &record);
    }

    /// Writes the record that answers a ray without direction: that of a ray like the one before it, which met nothing.
    pub fn empty(&self, before: [f64; 6], writer: &mut Writer) {
        let [x, y, z, dx, dy, dz] = before;
        let (origin, direction) = (Vec3::new(x, y, z), Vec3::new(dx, dy, dz).normalize_or_zero());
        let ray = if self.irradiance { Ray::new(origin + direction * (ABOVE + BEFORE), -direction) } else { Ray::new(origin, direction) };
        self.write(writer, &self.fields.ray, &nothing(ray));
    }

    /// The irradiance at a point on the side of a direction.
    fn irradiance(&self, origin: Vec3, normal: Vec3, number: u64) -> Record<'w> {
        let point = origin + normal * ABOVE;
        let mut record = nothing(Ray::new(origin + normal * (ABOVE + BEFORE), -normal));
        let mut integrator = Integrator::new(self.world, self.rules);
        let pixel = Pixel::converged(self.budget, self.seed, number, |sampler| {
            let mut light = Radiance { rules: self.rules, sum: Rgb::ZERO };
            let outcome = integrator.irradiance(&mut light, point, normal, sampler);
            (light.sum, outcome)
        });
        (record.met.point, record.met.length) = (point, BEFORE);
        record.fate = Fate { light: pixel.mean(), unmirrored_length: BEFORE, ..record.fate };
        Record { contribution: pixel.mean(), ..record }
    }

    /// What a ray meets and brings, and the records of the rays that it leads to, if they are wanted.
    fn radiance(&self, ray: Ray, limit: f64, number: u64, writer: &mut Writer) -> Record<'w> {
        if !self.fields.every.is_empty() {
            return self.every(ray, limit, number, writer);
        }
        let mut record = nothing(ray);
        record.met = self.first(&ray, limit);
        if self.fields.needs_branches() {
            let mut tree = Tree::new(self.world, self.rules, false);
            let mut integrator = Integrator::new(self.world, self.rules);
            let pixel = Pixel::converged(self.budget, self.seed, number, |sampler| {
                let before = tree.sum();
                let outcome = integrator.trace(&mut tree, ray, limit, sampler);
                (tree.sum() - before, outcome)
            });
            let fate = tree.fate(0);
            let mean = 1.0 / pixel.samples().max(1) as f64;
            record.fate = Fate { light: fate.light * mean, mirrored: fate.mirrored * mean, ..fate };
        } else if self.fields.needs_light() {
            let mut integrator = Integrator::new(self.world, self.rules);
            let pixel = Pixel::converged(self.budget, self.seed, number, |sampler| {
                let mut light = Radiance { rules: self.rules, sum: Rgb::ZERO };
                let outcome = integrator.trace(&mut light, ray, limit, sampler);
                (light.sum, outcome)
            });
            record.fate.light = pixel.mean();
        }
        Record { contribution: record.fate.light, ..record }
    }

    /// What a ray meets first.
    fn first(&self, ray: &Ray, limit: f64) -> Met<'w> {
        let hit = self.world.nearest(ray, limit);
        let mut first = met(self.world, ray, hit.as_ref(), limit);
        if let Some(hit) = hit.as_ref().filter(|_| self.fields.needs_layers()) {
            let coming = Coming { ray, travelled: 0.0, aim: None, primary: true, gathered: false, ambient: false, clip: None };
            let mut share = 0.0;
            self.world.layers(hit, &coming, self.rules, &mut |layer| {
                if layer.fraction > share {
                    first.see(layer);
                    share = layer.fraction;
                }
            });
        }
        first
    }

    /// Writes the records of all rays that a ray leads to, sample by sample, each before the one that it comes from.
    fn every(&self, ray: Ray, limit: f64, number: u64, writer: &mut Writer) -> Record<'w> {
        let mut integrator = Integrator::new(self.world, self.rules);
        let samples = if let Budget::Samples(samples) = self.budget { samples } else { 1 };
        let mut last = nothing(ray);
        let mut light = Rgb::ZERO;
        for index in 0..samples {
            let mut tree = Tree::new(self.world, self.rules, true);
            let outcome = integrator.trace(&mut tree, ray, limit, Sampler::new(self.seed, number, 0, index));
            self.descend(&tree, 0, 0, writer);
            last = record(&tree, 0);
            light += tree.sum();
            if !outcome.random {
                (light, last.fate.light) = (tree.sum(), tree.sum());
                return Record { contribution: light, ..last };
            }
        }
        last.fate.light = light / samples as f64;
        Record { contribution: last.fate.light, ..last }
    }

    fn descend(&self, tree: &Tree<'w>, node: usize, level: usize, writer: &mut Writer) {
        for child in tree.children(node, self.fields.shadows) {
            self.descend(tree, child, level + 1, writer);
        }
        if !self.fields.tells_of(tree.nodes[node].met.names.map(|n| n.modifier)) {
            return;
        }
        // Tabs are written in every form.
        writer.bytes.extend(std::iter::repeat_n(b'\t', level));
        self.write(writer, &self.fields.every, &record(tree, node));
    }

    fn write(&self, writer: &mut Writer, fields: &[Field], record: &Record) {
        let Record { ray, met, fate, .. } = record;
        for field in fields {
            match field {
                Field::Origin => writer.vector(ray.origin),
                Field::Direction => writer.vector(ray.direction),
                Field::Value => writer.color(fate.light),
                Field::Contribution => writer.color(record.contribution),
                Field::Weight => writer.numbers(&[record.weight]),
                Field::Coefficient => writer.color(record.coefficient),
                Field::Effective => writer.numbers(&[fate.effective()]),
                Field::Length => writer.numbers(&[met.length]),
                Field::Local => writer.numbers(&met.local),
                Field::Point => writer.vector(met.point),
                Field::Normal => writer.vector(met.normal),
                Field::Unperturbed => writer.vector(met.unperturbed),
                Field::Surface => writer.name(met.names.map_or("*", |n| n.surface)),
                Field::Modifier => writer.name(met.names.map_or("*", |n| n.modifier)),
                Field::Material => writer.name(met.names.map_or("*", |n| n.material)),
                Field::Mirrored => writer.color(fate.mirrored),
                Field::MirroredLength => writer.numbers(&[fate.mirrored_length]),
                Field::Unmirrored => writer.color(fate.light - fate.mirrored),
                Field::UnmirroredLength => writer.numbers(&[fate.unmirrored_length]),
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
        tree.fate(0).effective()
    };
    (0..task.count).into_par_iter().map(length).collect()
}

/// The record of a ray that meets nothing.
fn nothing<'w>(ray: Ray) -> Record<'w> {
    let met = Met { length: FAR, point: ray.origin, normal: Vec3::ZERO, unperturbed: Vec3::ZERO, local: [0.0; 2], names: None };
    let fate = Fate { light: Rgb::ZERO, mirrored: Rgb::ZERO, mirrored_length: FAR, unmirrored_length: FAR };
    Record { ray, met, fate, weight: 1.0, coefficient: Rgb::ONE, contribution: Rgb::ZERO }
}

/// The record of a ray in a tree: its light is what it brings, its contribution what that comes to at the viewer.
fn record<'w>(tree: &Tree<'w>, node: usize) -> Record<'w> {
    let (fate, at) = (tree.fate(node), &tree.nodes[node]);
    let own = |light: Rgb| Rgb::select(at.coefficient.cmpeq(Rgb::ZERO), Rgb::ZERO, light / at.coefficient);
    let coefficient = if tree.missed(node) { Rgb::ZERO } else { at.coefficient };
    Record {
        ray: at.ray,
        met: at.met,
        contribution: fate.light,
        fate: Fate { light: own(fate.light), mirrored: own(fate.mirrored), ..fate },
        weight: at.weight,
        coefficient,
    }
}
