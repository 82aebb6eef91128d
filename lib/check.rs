//! What is wrong with a scene, all of it in one go: what makes `oconv` or the renderer stop, and what they only warn of.

use crate::error::{Error, Span};
use crate::expand::Flat;
use crate::geometry::Shape;
use crate::material::is_of_lamps;
use crate::rad::{Class, Link, Links, Primitive, Type, Undefined};
use crate::resolve::Resolve;
use crate::scene::{Scene, misspelt};
use crate::transform::Transform;
use std::collections::{HashMap, HashSet};

/// What a check found.
#[derive(Debug, Default)]
pub struct Problems {
    /// What makes a scene useless.
    pub errors: Vec<Error>,
    /// What is doubtful, or ignored.
    pub warnings: Vec<Error>,
}

/// What the primitives show by themselves: as errors surfaces that have not the arguments of their types, as warnings, once each, names that do not
/// mean anything, which another scene, read before, may give a meaning.
pub fn glance(flat: &Flat) -> Problems {
    let primitives = &flat.primitives;
    let surfaces = primitives.iter().filter(|primitive| primitive.type_of().is_some_and(|kind| kind.class == Class::Surface));
    let errors = surfaces.filter_map(|surface| surface.complete().err()).collect();
    let mut checker = Checker::new(primitives, Links::of(primitives));
    (0..primitives.len()).for_each(|i| checker.names(i));
    let Problems { errors: names, mut warnings } = checker.problems;
    let mut said = HashSet::new();
    warnings.extend(names.into_iter().filter(|name| said.insert(name.message.clone())));
    Problems { errors, warnings }
}

/// Checks a scene; `resolve` reads the files that it names.
pub fn check(flat: &Flat, resolve: &dyn Resolve) -> Problems {
    let primitives = &flat.primitives;
    let links = Links::of(primitives);
    let used = links.used(primitives);
    let mut checker = Checker::new(primitives, links);
    let mut unread = HashSet::new();
    for (i, primitive) in primitives.iter().enumerate() {
        checker.names(i);
        let Some(kind) = primitive.type_of() else { continue };
        if kind.class == Class::Surface {
            let before = checker.problems.errors.len();
            checker.surface(i, resolve);
            if matches!(kind.name, "mesh" | "instance") && checker.problems.errors.len() > before {
                unread.insert(i);
            }
            continue;
        }
        // The arguments of a modifier that nothing uses do no harm.
        if let Err(error) = primitive.complete() {
            if used[i] { checker.problems.errors.push(error) } else { checker.problems.warnings.push(error) }
        }
    }
    let mut problems = checker.problems;
    // What the renderer says beside, once at each place: all users of a modifier find the same wrong with it.
    let at = |place: &Span| (place.source.name.clone(), place.start);
    let place = |error: &Error| error.place.as_ref().map(at);
    let mut told: HashSet<_> = problems.errors.iter().map(place).collect();
    let read = primitives.iter().enumerate().filter(|(i, _)| !unread.contains(i)).map(|(_, primitive)| primitive);
    problems.errors.extend(Scene::problems(read, &flat.annotations, resolve).into_iter().filter(|error| told.insert(place(error))));
    problems.warnings.extend(misspelt(&flat.annotations));
    // All that a command prints may have one thing wrong with it.
    let mut written = HashSet::new();
    problems.errors.retain(|error| written.insert((error.place.as_ref().map(Span::written).map(at), error.message.clone())));
    problems
}

struct Checker<'a> {
    primitives: &'a [Primitive],
    links: Links,
    problems: Problems,
    /// Where each name is first that of a modifier, and which names are those of surfaces.
    known_names: (HashMap<&'a str, usize>, HashSet<&'a str>),
    undefined: Undefined,
    /// Of each file that surfaces name whether it is none of RADIANCE's; or why it cannot be read.
    files: HashMap<String, Result<bool, String>>,
}

impl<'a> Checker<'a> {
    fn new(primitives: &'a [Primitive], links: Links) -> Self {
        Self {
            primitives,
            links,
            problems: Problems::default(),
            known_names: names(primitives),
            undefined: Undefined::default(),
            files: HashMap::new(),
        }
    }

    /// Checks what a primitive is called and what it calls.
    fn names(&mut self, i: usize) {
        let primitive = &self.primitives[i];
        let Primitive { name, modifier, kind, .. } = primitive;
        let is_modifier = primitive.type_of().is_some_and(Type::is_modifier);
        if is_modifier && matches!(name.as_str(), "void" | "inherit") {
            self.problems.errors.push(primitive.name_error(format!("a modifier may not be called `{name}`; choose another name")));
        }
        if name.contains('\t') {
            self.problems.errors.push(primitive.name_error("a name may not hold a tab; use blanks or underscores"));
        }
        match self.links.modifier[i] {
            Link::Unknown => self.problems.errors.push(primitive.modifier_error(self.undefined(modifier, i))),
            Link::Inherit if kind != "alias" => {
                self.problems.errors.push(primitive.modifier_error("only an alias can `inherit`; name the modifier"));
            }
            _ => {}
        }
        for &(j, link) in &self.links.references[i] {
            let target = &primitive.strings[j];
            let problem = match link {
                Link::Unknown => self.undefined(target, i),
                Link::Void if kind == "alias" => "an alias cannot stand for `void`; name a modifier".into(),
                _ => continue,
            };
            let error = primitive.string_error(j, problem);
            if kind == "antimatter" { self.problems.warnings.push(error) } else { self.problems.errors.push(error) }
        }
    }

    fn undefined(&self, name: &str, user: usize) -> String {
        let (modifiers, surfaces) = &self.known_names;
        match modifiers.get(name) {
            Some(&i) if i >= user => {
                let written = self.primitives[i].span.written();
                let (file, (line, _)) = (&written.source.name, written.line_column());
                format!("no modifier `{name}` is defined before this: it is only later, in {file} line {line}; move the definition up")
            }
            _ if surfaces.contains(name) => format!("no modifier is called `{name}`: only a surface is; name its modifier"),
            _ => {
                let what = self.undefined.said(name, modifiers.keys().copied());
                format!("{what}; define it above, or read the file that does first")
            }
        }
    }

    fn surface(&mut self, i: usize, resolve: &dyn Resolve) {
        let primitive = &self.primitives[i];
        match primitive.kind.as_str() {
            // The renderer says what is wrong with it.
            "source" => {}
            "mesh" | "instance" => self.file(primitive, resolve),
            _ => match Shape::read(primitive, &mut self.problems.warnings) {
                Ok(shape) => self.material(i, shape),
                Err(error) => self.error(error),
            },
        }
    }

    /// Checks that a surface may be a light if its material is one.
    fn material(&mut self, i: usize, shape: Option<Shape>) {
        let chain = self.links.chain(self.primitives, i);
        let class = |j: &usize| self.primitives[*j].type_of().map(|t| t.class);
        let Some(&material) = chain.iter().find(|j| class(j) == Some(Class::Material)) else { return };
        let (primitive, material) = (&self.primitives[i], &self.primitives[material]);
        if let Some(Err(reason)) = shape.filter(|_| is_of_lamps(material)).map(|s| s.light()) {
            self.error(primitive.error(format!("`{}` is a {} on a {}: {reason}", primitive.name, material.kind, primitive.kind)));
        }
    }

    /// Checks the file that a mesh or an instance names, and where it is put.
    fn file(&mut self, primitive: &Primitive, resolve: &dyn Resolve) {
        let Some(name) = primitive.strings.first() else {
            return self.error(primitive.error(format!("{} needs the name of a file", primitive.kind)));
        };
        if let Err(error) = Transform::of(primitive, 1) {
            self.error(error);
        }
        let foreign = |bytes: Vec<u8>| !bytes.starts_with(b"#?RADIANCE");
        let read = self.files.entry(name.clone()).or_insert_with(|| resolve.library(name).map(foreign).map_err(|error| error.message));
        match read.clone() {
            Ok(false) => {}
            Ok(true) if primitive.kind == "mesh" => {
                self.problems
                    .warnings
                    .push(primitive.string_error(0, format!("{name}: oconv does not read it; obj2mesh makes a mesh of it")));
            }
            Ok(true) => self.error(primitive.string_error(0, format!("{name}: not an octree; make it with oconv"))),
            Err(message) => self.error(primitive.string_error(0, message)),
        }
    }

    fn error(&mut self, error: Error) {
        self.problems.errors.push(error);
    }
}

fn names(primitives: &[Primitive]) -> (HashMap<&str, usize>, HashSet<&str>) {
    let (mut modifiers, mut surfaces) = (HashMap::new(), HashSet::new());
    for (i, primitive) in primitives.iter().enumerate() {
        if primitive.type_of().is_some_and(Type::is_modifier) {
            modifiers.entry(primitive.name.as_str()).or_insert(i);
        } else {
            surfaces.insert(primitive.name.as_str());
        }
    }
    (modifiers, surfaces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::expand::expand;
    use crate::rad::Document;
    use crate::resolve::Files;

    fn problems(text: &str) -> (Vec<String>, usize) {
        let files = Files::of([("a.rtm", &b"#?RADIANCE\n"[..]), ("b.rtm", b"solid"), ("c.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
        let flat = expand(vec![Document::parse(Source::new("t.rad", text)).unwrap()], &files).unwrap();
        let problems = check(&flat, &files);
        (problems.errors.iter().map(Error::to_string).collect(), problems.warnings.len())
    }

    #[test]
    fn a_name_that_another_scene_may_define_is_asked_for_once() {
        let text = "!genbox it box 1 1 1\nit sphere s 0 0 4 0 0 0 1\nother sphere s 0 0 4 0 0 0 1\n";
        let flat = expand(vec![Document::parse(Source::new("t.rad", text)).unwrap()], &Files::default()).unwrap();
        let Problems { errors, warnings } = glance(&flat);
        let names: Vec<_> = warnings.iter().map(|warning| warning.message.split('`').nth(1)).collect();
        assert!(errors.is_empty() && names == [Some("it"), Some("other")], "{names:?}");
    }

    #[test]
    fn what_oconv_refuses_is_an_error_with_its_place() {
        // oconv rejects each of these; the text between the two bars is what its message or the reason is about.
        for (text, reason) in [
            ("void plastic void 0 0 5 1 1 1 0 0", "1:14: error: a modifier may not be called `void`"),
            ("void plastic a 0 0 5 1 1 1 0 0 inherit sphere s 0 0 4 0 0 0 1", "1:32: error: only an alias can `inherit`"),
            ("void alias a b", "1:14: error: no modifier `b` is defined before this"),
            ("void alias b void", "an alias cannot stand for `void`"),
            ("void sphere s 0 0 3 0 0 0", "sphere needs 4"),
            ("void polygon s 0 0 10 0 0 0 1 1 1 2 2 2 2", "polygon needs three"),
            ("void cone s 0 0 7 0 0 0 1 1 1 2", "cone needs 8"),
            ("void mesh s 0 0 0", "mesh needs the name of a file"),
            ("void mesh s 1 none.rtm 0 0", "1:15: error: none.rtm: no such file"),
            ("void instance s 1 b.rtm 0 0", "b.rtm: not an octree"),
            ("void mesh s 2 a.rtm -t 0 0", "`-t` needs three numbers"),
            ("void mesh s 3 a.rtm -mx x 0 0", "1:25: error: `x` is no part of a transform"),
            ("void sphere \"a\tb\" 0 0 4 0 0 0 1", "may not hold a tab"),
            (
                "\nx sphere s 0 0 4 0 0 0 1\nvoid plastic x 0 0 5 1 1 1 0 0",
                "2:1: error: no modifier `x` is defined before this: it is only later, in t.rad line 3",
            ),
            ("x sphere s 0 0 4 0 0 0 1\nvoid metal x 0 0 5 1 1 1 1 0\nvoid plastic x 0 0 5 1 1 1 0 0", "only later, in t.rad line 2"),
            ("void sphere x 0 0 4 0 0 0 1 x sphere s 0 0 4 0 0 0 1", "no modifier is called `x`: only a surface is"),
        ] {
            let (errors, _) = problems(text);
            assert!(errors.len() == 1 && errors[0].contains(reason), "{text}: {errors:?}");
        }
    }

    #[test]
    fn what_the_renderer_refuses_is_an_error_where_it_is_used() {
        for (text, errors, warnings) in [
            ("void texfunc t 0 0 0 t sphere s 0 0 4 0 0 0 1", 1, 0),
            ("void texfunc t 0 0 0", 0, 1),
            ("void light l 0 0 3 1 1 1 l cone c 0 0 8 0 0 0 0 0 1 1 2", 1, 0),
            ("void glow l 0 0 4 1 1 1 0 l cone c 0 0 8 0 0 0 0 0 1 1 2", 0, 0),
            ("void plastic a 0 0 5 1 1 1 0 0 a metal b 0 0 5 1 1 1 0 0 b sphere s 0 0 4 0 0 0 1", 1, 0),
            ("void source s 0 0 4 0 0 1 0", 1, 0),
            ("void source s 0 0 4 0 0 0 1", 1, 0),
            ("void antimatter a 1 none 0 0 a sphere s 0 0 4 0 0 0 1", 0, 1),
            ("void sphere s 0 0 4 0 0 0 0", 0, 1),
            ("void polygon p 0 0 12 0 0 0 1 0 0 1 1 .1 0 1 0", 0, 1),
            ("void sphere s 1 surplus 0 4 0 0 0 1", 0, 0),
            ("void mesh m 1 c.obj 0 0", 0, 1),
        ] {
            let (found, warned) = problems(text);
            assert_eq!((found.len(), warned), (errors, warnings), "{text}: {found:?}");
        }
    }
}
