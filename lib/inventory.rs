//! What a scene holds, and what it takes to render it.

use crate::expand::Flat;
use crate::geometry::{Bounds, Shape};
use crate::material::is_of_lamps;
use crate::rad::{Class, Links, Number, Primitive, Type};
use crate::support::{Feature, SUPPORT};
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

/// What a scene holds, and what it takes to render it.
#[derive(Debug)]
pub struct Inventory {
    /// How many primitives there are of each type.
    pub types: BTreeMap<String, usize>,
    /// The box round all surfaces that have a shape of their own.
    pub bounds: Bounds,
    /// Meshes and instances, which the box leaves out.
    pub unbounded: usize,
    /// Surfaces that are light sources, by type.
    pub lights: BTreeMap<String, usize>,
    /// Distant sources that are sampled as lights: name and angle in degrees.
    pub distant: Vec<(String, f64)>,
    /// Distant sources that are an environment: name, angle in degrees, and the types of the patterns on them.
    pub environment: Vec<(String, f64, Vec<String>)>,
    /// Places at which environments were measured.
    pub probes: usize,
    /// What the surfaces and what is behind them require.
    pub requires: Vec<&'static Feature>,
    /// Of that, what is not rendered: how many primitives, and where the first stands.
    pub unsupported: Vec<(&'static Feature, usize, String)>,
}

impl Inventory {
    /// Takes stock of a scene. What cannot be understood is counted and otherwise passed over.
    pub fn of(flat: &Flat) -> Self {
        let primitives = &flat.primitives;
        let links = Links::of(primitives);
        let mut stock = Self {
            types: BTreeMap::new(),
            bounds: Bounds::EMPTY,
            unbounded: 0,
            lights: BTreeMap::new(),
            distant: Vec::new(),
            environment: Vec::new(),
            probes: flat.annotations.iter().filter(|a| a.word == "probe").count(),
            requires: Vec::new(),
            unsupported: Vec::new(),
        };
        for (i, primitive) in primitives.iter().enumerate() {
            *stock.types.entry(primitive.kind.clone()).or_default() += 1;
            if primitive.type_of().is_some_and(|t| t.class == Class::Surface) {
                let chain: Vec<&Primitive> = links.chain(primitives, i).into_iter().map(|j| &primitives[j]).collect();
                stock.surface(primitive, &chain);
            }
        }
        let used = links.used(primitives);
        for feature in SUPPORT {
            let mut needing = primitives.iter().zip(&used).filter(|(p, used)| **used && feature.types.contains(&p.kind.as_str()));
            let Some((first, _)) = needing.next() else { continue };
            stock.requires.push(feature);
            if !feature.rendered {
                let written = first.span.written();
                let at = format!("{}:{}", written.source.name, written.line_column().0);
                stock.unsupported.push((feature, 1 + needing.count(), at));
            }
        }
        stock
    }

    fn surface(&mut self, primitive: &Primitive, chain: &[&Primitive]) {
        let class = |p: &&&Primitive, class| p.type_of().is_some_and(|t: &Type| t.class == class);
        let material = chain.iter().find(|p| class(p, Class::Material));
        let shines = material.is_some_and(|m| is_of_lamps(m));
        match primitive.kind.as_str() {
            "source" => {
                let angle = primitive.reals.get(3).copied().unwrap_or(0.0);
                let glows = material.is_some_and(|m| m.kind == "glow");
                if glows {
                    let patterns = chain.iter().filter(|p| class(p, Class::Pattern)).map(|p| p.kind.clone()).collect();
                    self.environment.push((primitive.name.clone(), angle, patterns));
                } else if shines {
                    self.distant.push((primitive.name.clone(), angle));
                }
            }
            "mesh" | "instance" => self.unbounded += 1,
            kind => {
                if let Ok(Some(shape)) = Shape::of(primitive) {
                    self.bounds = self.bounds.join(shape.bounds());
                }
                if shines {
                    *self.lights.entry(kind.into()).or_default() += 1;
                }
            }
        }
    }
}

impl Display for Inventory {
    /// One line for each thing, its name first; no line for what there is none of.
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let counted = |counts: &BTreeMap<String, usize>| {
            let list: Vec<String> = counts.iter().map(|(kind, n)| format!("{n} {kind}")).collect();
            format!("{}: {}", counts.values().sum::<usize>(), list.join(", "))
        };
        let degrees = |angle: f64| format!("{}°", Number(angle));
        let mut line = |name: &str, text: String| if text.is_empty() { Ok(()) } else { writeln!(f, "{name:<12} {text}") };
        line("primitives", if self.types.is_empty() { "0".into() } else { counted(&self.types) })?;
        if !self.bounds.is_empty() {
            let [min, max] = [self.bounds.min, self.bounds.max].map(|p| p.to_array().map(|x| Number(x).to_string()).join(" "));
            let rest = if self.unbounded > 0 { format!(" (without {} meshes and instances)", self.unbounded) } else { String::new() };
            line("bounds", format!("{min} to {max}{rest}"))?;
        }
        if !self.lights.is_empty() {
            line("lights", counted(&self.lights))?;
        }
        if !self.distant.is_empty() {
            let list: Vec<String> = self.distant.iter().take(8).map(|(name, angle)| format!("{name} {}", degrees(*angle))).collect();
            let more = if self.distant.len() > 8 { ", …" } else { "" };
            line("distant", format!("{}: {}{more}", self.distant.len(), list.join(", ")))?;
        }
        for (name, angle, patterns) in &self.environment {
            let patterns = if patterns.is_empty() { "uniform".into() } else { patterns.join(", ") };
            line("environment", format!("{name} {}: {patterns}", degrees(*angle)))?;
        }
        line("probes", if self.probes > 0 { self.probes.to_string() } else { String::new() })?;
        line("requires", self.requires.iter().map(|feature| feature.name).collect::<Vec<_>>().join(", "))?;
        for (feature, count, place) in &self.unsupported {
            line("unsupported", format!("{}: {count} (first in {place})", feature.name))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::expand::expand;
    use crate::rad::Document;
    use crate::resolve::Files;

    #[test]
    fn a_scene_is_taken_stock_of() {
        let text = "void colorpict map 7 red green blue map.hdr . u v 0 0 map glow sky 0 0 4 1 1 1 0 sky source world 0 0 4 0 0 1 360\n\
                    void light lamp 0 0 3 1 1 1 lamp sphere bulb 0 0 4 1 2 3 .5 lamp source sun 0 0 4 0 0 1 .5\n\
                    void mist unused 0 0 0\n void BSDF b 6 0 x.xml 0 0 1 . 0 0\n void alias c b c polygon p 0 0 9 0 0 0 1 0 0 0 -1 0\n#@probe 0 0 0 sky\n";
        let flat = expand(vec![Document::parse(Source::new("t.rad", text)).unwrap()], &Files::default()).unwrap();
        let stock = Inventory::of(&flat).to_string();
        let (bounds, others): (Vec<&str>, Vec<&str>) = stock.lines().partition(|l| l.starts_with("bounds"));
        assert_eq!(
            others,
            [
                "primitives   10: 1 BSDF, 1 alias, 1 colorpict, 1 glow, 1 light, 1 mist, 1 polygon, 2 source, 1 sphere",
                "lights       1: 1 sphere",
                "distant      1: sun 0.5°",
                "environment  world 360°: colorpict",
                "probes       1",
                "requires     polygons, spheres, distant sources, aliases, light sources, glow, patterns from pictures, measured scattering",
                "unsupported  measured scattering: 1 (first in t.rad:4)",
            ]
        );
        assert!(bounds.len() == 1);
        let bounds = Inventory::of(&flat).bounds;
        assert!((bounds.max.z - 3.5).abs() < 1e-5 && (bounds.min.y + 1.0).abs() < 1e-5);
    }
}
