//! What is in front of the camera: the scene, with the unknown in its place.

use crate::args::anneal::Arguments;
use crate::cli::{Console, Disk, Outcome, scene};
use crate::error::Result;
use crate::expand::{Flat, expand};
use crate::rad::{Class, Primitive};
use crate::recover::begun;
use crate::scene::{MaterialId, Reading, Scene};
use crate::unknown::Unknown;
use std::collections::HashSet;
use std::sync::Arc;

/// A scene, and what is unknown in it.
pub struct Setup {
    /// Its description.
    pub flat: Flat,
    /// The place of the unknown material there.
    pub place: usize,
    /// How it is read.
    pub reading: Reading,
    /// What that makes.
    pub scene: Scene,
    /// Which of its materials is the unknown.
    pub material: MaterialId,
}

impl Setup {
    /// The scene that the arguments name, with the unknown in it; errors if nothing there is made of it. The disk counts what was read.
    pub fn new(unknown: &Unknown, arguments: &Arguments, disk: &Disk, console: &Console) -> Outcome<Self> {
        let mut documents = vec![unknown.source().clone()];
        documents.extend(scene::documents(&arguments.photo.scene, disk)?);
        documents.iter().for_each(|document| disk.count(&document.source.name, &document.bytes()));
        let mut flat = expand(documents, disk)?;
        let place = placed(&mut flat, unknown)?;
        flat.primitives[place].reals = begun(unknown);
        let reading = Reading { unknown: Some(unknown.material().name.clone()), ..scene::reading(&arguments.reading, disk)? };
        let scene = scene::built(&flat, disk, &reading, &arguments.light, console)?;
        let material = scene.material(&flat.primitives[place]).ok_or_else(|| {
            unknown
                .material()
                .error("no surface of the scene is made of it; give the object's file, which names it, too: --scene OBJECT.rad")
        })?;
        Ok(Self { flat, place, reading, scene, material })
    }
}

/// The place of the unknown in a description, whose own definition of it does not count.
fn placed(flat: &mut Flat, unknown: &Unknown) -> Result<usize> {
    let material = unknown.material();
    let is_it = |p: &Primitive| p.name == material.name && p.type_of().is_some_and(|t| t.class == Class::Material);
    flat.primitives.retain(|p| !is_it(p) || Arc::ptr_eq(&p.span.source, &unknown.source().source));
    let place = flat.primitives.iter().rposition(is_it).ok_or_else(|| material.error("it is not in the scene"))?;
    if let Some(other) = undefined_instead(flat, &material.name) {
        let remedy = "call the material so if that is what is unknown (START.rad stands alone, each file of the scene behind a --scene)";
        let problem = format!("nothing in the scene is made of it, and `{other}`, which something is made of, is not defined: {remedy}");
        return Err(material.error(problem));
    }
    let modifier = &material.modifier;
    let defined = |of: &[Primitive]| of.iter().any(|p| p.name == *modifier);
    if !defined(&flat.primitives[..place]) && defined(&flat.primitives[place..]) {
        let problem =
            format!("the scene defines `{modifier}`, but what is unknown stands before it: put `{modifier}` into this file, above");
        return Err(material.modifier_error(problem));
    }
    Ok(place)
}

/// A modifier that a description has and does not define, if nothing there has `name` for its own.
fn undefined_instead<'f>(flat: &'f Flat, name: &str) -> Option<&'f str> {
    let uses = |p: &Primitive| p.modifier == name || p.strings.iter().any(|word| word == name);
    if flat.primitives.iter().any(uses) {
        return None;
    }
    let defined: HashSet<&str> = flat.primitives.iter().map(|p| p.name.as_str()).chain(["void"]).collect();
    flat.primitives.iter().map(|p| p.modifier.as_str()).find(|modifier| !defined.contains(modifier))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::rad::Document;
    use crate::resolve::Files;

    #[test]
    fn a_material_of_another_name_than_the_scene_has_is_told() {
        let said = |scene: &str| {
            let documents = ["void plastic it 0 0 5 .5 .5 .5 0 0", scene].map(|text| Document::parse(Source::new("a.rad", text)).unwrap());
            let flat = expand(documents.into(), &Files::of([])).unwrap();
            undefined_instead(&flat, "it").map(String::from)
        };
        assert_eq!(said("finish sphere s 0 0 4 0 0 0 1"), Some("finish".into()));
        assert_eq!(said("it sphere s 0 0 4 0 0 0 1\nfinish sphere s 0 0 4 0 0 0 1"), None);
        assert_eq!(said("void mirror pane 1 it 0 3 .9 .9 .9\nvoid sphere s 0 0 4 0 0 0 1"), None);
        assert_eq!(said("void alias finish void\nfinish sphere s 0 0 4 0 0 0 1"), None);
    }
}
