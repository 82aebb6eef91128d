//! The unknown: which numbers of which material a search may change, between which bounds, and the file with those numbers in place.

mod types;
mod wishes;

pub use types::{GLASS, TYPES, retyped};
pub use wishes::{Bounds, Wishes, names};

use crate::anneal::Parameter;
use crate::error::{Error, Result};
use crate::rad::{Class, Document, Number, Primitive};
use std::collections::HashSet;

/// A material some of whose numbers are not known.
#[derive(Clone, Debug)]
pub struct Unknown {
    document: Document,
    material: Primitive,
    /// Its real arguments at the start of the search, then the exposures.
    start: Vec<f64>,
    parameters: Vec<Parameter>,
    groups: Vec<Vec<usize>>,
    /// For each of these the parameter that it takes its value from, if it is not fixed.
    slots: Vec<Option<usize>>,
}

/// What the picture may be brighter by than the scene is: in all, and in each channel. No numbers of the material, but as unknown.
pub const EXPOSURES: [&str; 4] = ["exposure", "exposure-red", "exposure-green", "exposure-blue"];

/// Shares of the light: none is more than all of it.
pub const SHARES: [&str; 3] = ["spec", "trans", "tspec"];

/// What shapes specular reflection.
pub const ROUGHNESSES: [&str; 3] = ["rough", "urough", "vrough"];

/// The words that stand for the three colours in a list of parameters.
pub const COLORS: (&str, [&str; 3]) = ("rgb", ["red", "green", "blue"]);

impl Unknown {
    /// The unknown of a scene file.
    pub fn new(document: Document, wishes: &Wishes) -> Result<Self> {
        let material = choose(&document, wishes.material.as_deref())?.clone();
        material.complete()?;
        let (start, mut ranges) = bounded(&material, wishes)?;
        let leader = leaders(&material, wishes, &ranges)?;
        let start: Vec<f64> = leader.iter().map(|&first| start[first]).collect();
        for name in &wishes.fixed {
            let first = leader[find(&material, name)?];
            ranges[first] = None;
        }
        // Lay out what is left free.
        let mut parameters = Vec::new();
        let mut slots: Vec<Option<usize>> = vec![None; start.len()];
        for (i, range) in ranges.iter().enumerate().filter(|(i, _)| leader[*i] == *i) {
            if let Some(range) = range {
                slots[i] = Some(parameters.len());
                parameters.push(parameter(&material, i, start[i], *range)?);
            }
        }
        (0..slots.len()).for_each(|i| slots[i] = slots[leader[i]]);
        if parameters.is_empty() {
            let message = format!("no parameter of {} `{}` is free", material.kind, material.name);
            return Err(material.error(message + "; give bounds with --param NAME=START:LOW:HIGH"));
        }
        let groups = groups(&material, &slots, parameters.len(), &wishes.groups)?;
        Ok(Self { document, material, start, parameters, groups, slots })
    }

    /// What to search for, each with its start and bounds.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// What each parameter starts with.
    pub fn start(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.start).collect()
    }

    /// The bounds of each parameter.
    pub fn bounds(&self) -> Vec<(f64, f64)> {
        self.parameters.iter().map(|p| (p.low, p.high)).collect()
    }

    /// The parameters that move together, by their places in [`Self::parameters`].
    pub fn groups(&self) -> &[Vec<usize>] {
        &self.groups
    }

    /// The file as it was read.
    pub fn source(&self) -> &Document {
        &self.document
    }

    /// The material as it was read.
    pub fn material(&self) -> &Primitive {
        &self.material
    }

    /// The material's real arguments when the parameters have these values.
    pub fn reals(&self, values: &[f64]) -> Vec<f64> {
        (0..self.material.reals.len()).map(|i| self.at(i, values)).collect()
    }

    fn at(&self, i: usize, values: &[f64]) -> f64 {
        self.slots[i].map_or(self.start[i], |k| values[k])
    }

    /// By what red, green and blue of the picture are brighter than the scene is.
    pub fn exposures(&self, values: &[f64]) -> [f64; 3] {
        let [all, channels @ ..] = std::array::from_fn::<f64, 4, _>(|k| self.at(self.material.reals.len() + k, values));
        channels.map(|channel| all * channel)
    }

    /// Whether an exposure is unknown.
    pub fn seeks_exposure(&self) -> bool {
        self.slots[self.material.reals.len()..].iter().any(Option::is_some)
    }

    /// Errors if there is an exposure, which the file does not tell.
    pub fn told_by_file(&self) -> Result<()> {
        if !self.seeks_exposure() && self.exposures(&self.start()) == [1.0; 3] {
            return Ok(());
        }
        let message =
            "an exposure is no number of a file, so a command cannot use it; let it fit the exposure, as imgdiff --fit-exposure does";
        Err(Error::new(message))
    }

    /// For each real argument, the place in [`Self::parameters`] of the parameter that it takes its value from, if it is free.
    pub fn slots(&self) -> &[Option<usize>] {
        &self.slots[..self.material.reals.len()]
    }

    /// The same with one parameter known, at the place `slot` of [`Self::parameters`]; `None` if nothing is unknown then.
    pub fn knowing(&self, slot: usize, value: f64) -> Option<Self> {
        let mut known = self.clone();
        known.parameters.remove(slot);
        for (start, at) in known.start.iter_mut().zip(&mut known.slots) {
            match *at {
                Some(k) if k == slot => (*start, *at) = (value, None),
                Some(k) if k > slot => *at = Some(k - 1),
                _ => {}
            }
        }
        let place = |k: &usize| if *k > slot { k - 1 } else { *k };
        known.groups.iter_mut().for_each(|group| *group = group.iter().filter(|k| **k != slot).map(place).collect());
        known.groups.retain(|group| !group.is_empty());
        (!known.parameters.is_empty()).then_some(known)
    }

    /// The same with what `length` lets through instead of the transmissivity of a unit of length, its first three numbers.
    pub fn through(&self, length: f64) -> Self {
        let mut through = self.clone();
        let power = |v: &mut f64| *v = v.max(0.0).powf(length);
        through.start[..3].iter_mut().for_each(power);
        for (slot, parameter) in through.parameters.iter_mut().enumerate() {
            if self.slots[..3].contains(&Some(slot)) {
                [&mut parameter.start, &mut parameter.low, &mut parameter.high].into_iter().for_each(power);
            }
        }
        through
    }

    /// The same with its parameter at `slot`, and its bounds, not below `least`.
    pub fn at_least(&self, slot: usize, least: f64) -> Self {
        let mut bounded = self.clone();
        let Parameter { start, low, high, .. } = &mut bounded.parameters[slot];
        [start, low, high].into_iter().for_each(|value| *value = value.max(least));
        bounded
    }

    /// The file with these values of the parameters and nothing else changed.
    pub fn document(&self, values: &[f64]) -> Result<Document> {
        let mut document = self.document.clone();
        for (i, real) in self.reals(values).into_iter().enumerate() {
            // A number that stays keeps its spelling.
            if real != self.material.reals[i] {
                document.set(&self.material.name, i, real)?;
            }
        }
        Ok(document)
    }
}

/// The material called `wanted`, or the only one there is, lamps and what else has nothing unknown by itself not counted.
fn choose<'a>(document: &'a Document, wanted: Option<&str>) -> Result<&'a Primitive> {
    let file = &document.source.name;
    let mut found: Vec<&Primitive> = document
        .primitives()
        .filter(|p| p.type_of().is_some_and(|t| t.class == Class::Material) && wanted.is_none_or(|w| w == p.name))
        .collect();
    // Of those with the same name the last one counts.
    let mut names = HashSet::new();
    found.reverse();
    found.retain(|p| names.insert(&p.name));
    let open = |p: &&Primitive| (0..p.reals.len()).any(|index| usual(p, index).is_some());
    if wanted.is_none() && found.iter().any(open) {
        found.retain(open);
    }
    match (&found[..], wanted) {
        ([material], _) => Ok(material),
        ([last, ..], _) => {
            let mut names: Vec<&str> = found.iter().map(|p| p.name.as_str()).collect();
            names.sort_unstable();
            Err(last.error(format!(
                "there are {} materials: {}; say which one is unknown with --material ID",
                names.len(),
                names.join(" ")
            )))
        }
        ([], Some(name)) => Err(Error::new(format!("{file}: no material is called `{name}`"))),
        ([], None) => Err(Error::new(format!(
            "{file}: no material; write one with the values to start from, as in: void plastic m 0 0 5 .5 .5 .5 .05 .1"
        ))),
    }
}

/// What no material has less than nothing of.
const NEVER_NEGATIVE: [(&[&str], &str); 4] =
    [(&ROUGHNESSES, "a roughness"), (&SHARES, "a share of light"), (&COLORS.1, "a colour"), (&["ior"], "an index of refraction")];

/// The bounds of an argument; `None` if it is known.
type Bounded = Option<(f64, f64)>;

/// What each argument starts with, and its bounds if it is free. Exposures stand behind the arguments, and stay as they are unless something else is said.
fn bounded(material: &Primitive, wishes: &Wishes) -> Result<(Vec<f64>, Vec<Bounded>)> {
    let mut start = [&material.reals[..], &[1.0; EXPOSURES.len()]].concat();
    let mut ranges: Vec<_> = (0..material.reals.len()).map(|index| usual(material, index)).collect();
    ranges.resize(start.len(), None);
    let mut said = vec![false; start.len()];
    for bounds in &wishes.bounds {
        let i = find(material, &bounds.name)?;
        if std::mem::replace(&mut said[i], true) {
            return Err(Error::new(format!("{}: bounds given twice", bounds.name)));
        }
        let named = if i < material.reals.len() { name(material, i) } else { String::new() };
        let what = NEVER_NEGATIVE.iter().find(|(names, _)| names.contains(&&*named)).filter(|_| bounds.low < 0.0);
        if let Some((_, what)) = what {
            return Err(Error::new(format!("{}: {what} is not below 0; give bounds that begin there, as START:0:HIGH", bounds.name)));
        }
        start[i] = bounds.start.unwrap_or(start[i]);
        ranges[i] = Some((bounds.low, bounds.high));
        if !(bounds.low..=bounds.high).contains(&start[i]) {
            let message = format!("{} starts outside its bounds {}:{}", bounds.name, Number(bounds.low), Number(bounds.high));
            let error = |text| if i < material.reals.len() { material.real_error(i, text) } else { material.error(text) };
            return Err(error(message + "; give a start as NAME=START:LOW:HIGH"));
        }
    }
    Ok((start, ranges))
}

/// The argument that each follows, itself if it is tied to none: tied ones follow the first of them, with all that are tied to them.
fn leaders(material: &Primitive, wishes: &Wishes, ranges: &[Bounded]) -> Result<Vec<usize>> {
    let mut leader: Vec<usize> = (0..ranges.len()).collect();
    for tie in &wishes.tied {
        let members = tie.iter().map(|name| find(material, name)).collect::<Result<Vec<_>>>()?;
        let [first, rest @ ..] = &members[..] else { continue };
        if rest.is_empty() {
            return Err(Error::new(format!("{} is tied to nothing; name two or more, as in red=green", tie[0])));
        }
        for &follower in rest {
            let said = wishes.bounds.iter().any(|bounds| find(material, &bounds.name).is_ok_and(|i| i == follower));
            if said && follower != *first {
                let message = format!("{0} is tied to {1}: give the bounds of {1}", tie[1..].join(", "), tie[0]);
                return Err(Error::new(message));
            }
            let (old, new) = (leader[follower], leader[*first]);
            leader.iter_mut().filter(|l| **l == old).for_each(|l| *l = new);
        }
    }
    match (0..ranges.len()).find(|&i| ranges[i].is_some() && ranges[leader[i]].is_none()) {
        None => Ok(leader),
        Some(i) => {
            let [first, follower] = [leader[i], i].map(|i| name(material, i));
            Err(Error::new(format!("{follower} is tied to {first}, which has no bounds: give --param {first}=START:LOW:HIGH")))
        }
    }
}

/// Argument `i` as something to search for. What is more than usual exists, but neither less than nothing nor a share of more than all.
fn parameter(material: &Primitive, i: usize, start: f64, (low, high): (f64, f64)) -> Result<Parameter> {
    let name = name(material, i);
    if start < 0.0 && low == 0.0 || start > 1.0 && high == 1.0 {
        let remedy = format!("start it there, or give --param {name}=START:LOW:HIGH");
        let message = format!("{name} is sought from {} to {}, and starts at {}; {remedy}", Number(low), Number(high), Number(start));
        return Err(material.real_error(i, message));
    }
    Ok(Parameter { name, start, low: low.min(start), high: high.max(start) })
}

/// The argument called `name`.
fn find(material: &Primitive, name: &str) -> Result<usize> {
    let exposure = EXPOSURES.iter().position(|e| *e == name).map(|k| material.reals.len() + k);
    let place = exposure.or_else(|| material.type_of().and_then(|t| t.parameter(name)).filter(|&i| i < material.reals.len()));
    place.ok_or_else(|| {
        let names: Vec<String> = (0..material.reals.len()).map(|i| self::name(material, i)).collect();
        let remedy = if name.contains('=') { "; --fix takes names alone, and keeps the values of the file" } else { "" };
        material.error(format!("{} `{}` has no parameter `{name}`; it has {}{remedy}", material.kind, material.name, names.join(" ")))
    })
}

/// What argument `index` is called.
fn name(material: &Primitive, index: usize) -> String {
    if let Some(exposure) = index.checked_sub(material.reals.len()) {
        return EXPOSURES[exposure].into();
    }
    let named = material.type_of().and_then(|t| t.parameters.get(index));
    named.map_or_else(|| format!("a{}", index + 1), |name| (*name).to_string())
}

/// The bounds of argument `index` when none are given; `None` if it then stays as it is.
///
/// A colour, a share of the light and a transmissivity lie between 0 and 1 in all that exist. Roughness .4 is past what a
/// Ward lobe describes well; the anisotropic types must not have roughness 0. Indices of refraction go up to diamond's.
fn usual(material: &Primitive, index: usize) -> Bounded {
    let kind = material.kind.as_str();
    if matches!(kind, "light" | "illum" | "glow" | "spotlight" | "mist") {
        return None;
    }
    match (name(material, index).as_str(), kind, index) {
        ("red" | "green" | "blue" | "spec" | "trans" | "tspec", ..) => Some((0.0, 1.0)),
        ("rough", ..) => Some((0.0, 0.4)),
        ("urough" | "vrough", ..) => Some((0.001, 0.4)),
        ("ior", ..) => Some((1.0, 2.5)),
        (_, "ashik2", 3..=5) | (_, "interface", 4..=6) => Some((0.0, 1.0)),
        _ => None,
    }
}

/// The groups that move together: as wished, else the colours and the others.
fn groups(material: &Primitive, slots: &[Option<usize>], count: usize, wished: &[Vec<String>]) -> Result<Vec<Vec<usize>>> {
    let usual = [vec![COLORS.0.to_string()]];
    let mut left: Vec<bool> = vec![true; count];
    let mut groups = Vec::new();
    for wish in if wished.is_empty() { &usual } else { wished } {
        let mut group = Vec::new();
        for name in wish {
            let colors = name == COLORS.0;
            let members = if colors { COLORS.1.to_vec() } else { vec![name.as_str()] };
            for name in members {
                let index = match find(material, name) {
                    Err(_) if colors => continue,
                    found => found?,
                };
                // Each free parameter is in one group; a fixed one may be named and stays fixed.
                if let Some(k) = slots[index].filter(|&k| std::mem::take(&mut left[k])) {
                    group.push(k);
                }
            }
        }
        groups.push(group);
    }
    groups.push((0..count).filter(|&k| left[k]).collect());
    groups.retain(|group| !group.is_empty());
    Ok(groups)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;

    const HORSE: &str = "# a horse\nvoid metal obj_mat\n0\n0\n5 0.50 .5 5e-1 0.5 0.1 # start\n";

    fn unknown(text: &str, wishes: &Wishes) -> Result<Unknown> {
        Unknown::new(Document::parse(Source::new("start.rad", text))?, wishes)
    }

    fn message(text: &str, wishes: &Wishes) -> String {
        unknown(text, wishes).err().map(|e| e.to_string()).unwrap_or_default()
    }

    fn words(words: &[&str]) -> Vec<String> {
        words.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn only_the_changed_numbers_change_in_the_file() {
        let unknown = unknown(HORSE, &Wishes { fixed: words(&["rough"]), ..Wishes::default() }).unwrap();
        let names: Vec<_> = unknown.parameters().iter().map(|p| (p.name.as_str(), p.start, p.low, p.high)).collect();
        assert_eq!(names, [("red", 0.5, 0.0, 1.0), ("green", 0.5, 0.0, 1.0), ("blue", 0.5, 0.0, 1.0), ("spec", 0.5, 0.0, 1.0)]);
        let bytes = unknown.document(&[0.5, 0.25, 0.5, 0.75]).unwrap().bytes();
        assert_eq!(String::from_utf8(bytes).unwrap(), "# a horse\nvoid metal obj_mat\n0\n0\n5 0.50 0.25 5e-1 0.75 0.1 # start\n");
    }

    #[test]
    fn bounds_ties_and_groups_are_as_said() {
        let wishes = Wishes {
            bounds: vec!["a5=.2:.1:.3".parse().unwrap(), "red=:0.1:0.9".parse().unwrap()],
            tied: vec![words(&["red", "green", "blue"])],
            groups: vec![words(&["rgb"]), words(&["rough"])],
            ..Wishes::default()
        };
        let unknown = unknown(HORSE, &wishes).unwrap();
        let names: Vec<_> = unknown.parameters().iter().map(|p| (p.name.as_str(), p.start, p.low, p.high)).collect();
        assert_eq!(names, [("red", 0.5, 0.1, 0.9), ("spec", 0.5, 0.0, 1.0), ("rough", 0.2, 0.1, 0.3)]);
        assert_eq!(unknown.groups(), [vec![0], vec![2], vec![1]]);
        assert_eq!(unknown.slots(), [Some(0), Some(0), Some(0), Some(1), Some(2)]);
        assert_eq!(unknown.reals(&[0.7, 0.9, 0.25]), [0.7, 0.7, 0.7, 0.9, 0.25]);
    }

    #[test]
    fn ties_hold_in_any_order() {
        for ties in [[["blue", "green"], ["red", "blue"]], [["red", "blue"], ["blue", "green"]]] {
            let unknown = unknown(HORSE, &Wishes { tied: ties.map(|tie| words(&tie)).into(), ..Wishes::default() }).unwrap();
            assert_eq!(unknown.slots()[..3], [Some(0); 3], "{ties:?}");
            assert_eq!(unknown.reals(&unknown.start())[..3], [0.5; 3]);
        }
    }

    #[test]
    fn the_unknown_is_the_only_material_or_the_one_named() {
        let two = "void plastic a 0 0 5 .5 .5 .5 0 0\nvoid glass b 0 0 3 .9 .9 .9\na sphere s 0 0 4 0 0 0 1\n";
        assert!(message(two, &Wishes::default()).contains("there are 2 materials: a b; say which one is unknown with --material ID"));
        let glass = unknown(two, &Wishes { material: Some("b".into()), ..Wishes::default() }).unwrap();
        assert_eq!(glass.material().kind, "glass");
        assert!(message(two, &Wishes { material: Some("c".into()), ..Wishes::default() }).contains("start.rad: no material is called `c`"));
        assert!(message("a sphere s 0 0 4 0 0 0 1\n", &Wishes::default()).contains("no material"));
        let lit = "void light l 0 0 3 9 9 9\nvoid plastic a 0 0 5 .5 .5 .5 0 0\nvoid antimatter cut 1 a 0 0\n";
        assert_eq!(unknown(lit, &Wishes::default()).unwrap().material().kind, "plastic");
        // RADIANCE takes the last of two definitions.
        let again = "void plastic a 0 0 5 .5 .5 .5 0 0\nvoid metal a 0 0 5 .5 .5 .5 0 0\n";
        assert_eq!(unknown(again, &Wishes::default()).unwrap().material().kind, "metal");
    }

    #[test]
    fn what_cannot_be_is_said_with_its_remedy() {
        let fix = |name: &str| Wishes { fixed: words(&[name]), ..Wishes::default() };
        assert!(message(HORSE, &fix("ior")).contains("metal `obj_mat` has no parameter `ior`; it has red green blue spec rough"));
        assert!(message(HORSE, &fix("a6")).contains("has no parameter `a6`"));
        assert!(
            message("void light l 0 0 3 9 9 9", &Wishes::default()).contains("no parameter of light `l` is free; give bounds with --param")
        );
        assert!(
            message("void plastic m 0 0 3 .5 .5 .5", &Wishes::default())
                .contains("plastic needs 5 real arguments (red green blue spec rough), not 3")
        );
        let outside = Wishes { bounds: vec!["rough=:.2:.3".parse().unwrap()], ..Wishes::default() };
        assert!(message(HORSE, &outside).starts_with("start.rad:5:"));
        let alone = Wishes { tied: vec![words(&["red"])], ..Wishes::default() };
        assert!(message(HORSE, &alone).contains("red is tied to nothing; name two or more, as in red=green"));
        let tied = Wishes { tied: vec![words(&["red", "blue"])], bounds: vec!["blue=.5:0:1".parse().unwrap()], ..Wishes::default() };
        assert!(message(HORSE, &tied).contains("blue is tied to red: give the bounds of red"));
        let boundless = Wishes { tied: vec![["exposure", "red"].map(String::from).to_vec()], ..Wishes::default() };
        assert!(message(HORSE, &boundless).contains("red is tied to exposure, which has no bounds: give --param exposure=START:LOW:HIGH"));
        for wrong in ["rough", "rough=1:2", "rough=a:0:1", "rough=.5:1:0", "rough=2:0:1", "rough=nan:0:1", "exposure=1:0:5"] {
            assert!(wrong.parse::<Bounds>().unwrap_err().message.contains("write NAME=START:LOW:HIGH"), "{wrong}");
        }
    }

    #[test]
    fn a_start_outside_the_usual_bounds_widens_them() {
        let rough = unknown("void plastic a 0 0 5 .5 .5 .5 0 .6", &Wishes::default()).unwrap();
        assert_eq!(rough.parameters()[4].high, 0.6);
        // But nothing is less than nothing, and no share more than all.
        let said = message("void plastic a 0 0 5 .5 1.5 .5 0 .6", &Wishes::default());
        assert!(said.starts_with("start.rad:1:25: error: green is sought from 0 to 1, and starts at 1.5; "), "{said}");
        assert!(message("void dielectric a 0 0 5 .5 -1 .5 1.5 0", &Wishes::default()).contains("green is sought from 0 to 1"));
        let wider = Wishes { bounds: vec!["green=:0:2".parse().unwrap()], ..Wishes::default() };
        assert!(unknown("void plastic a 0 0 5 .5 1.5 .5 0 .6", &wider).is_ok());
    }

    #[test]
    fn hartmann_and_a_glass_without_index_stay_as_they_are() {
        let names = |text: &str| unknown(text, &Wishes::default()).unwrap().parameters().iter().map(|p| p.name.clone()).collect::<Vec<_>>();
        assert_eq!(names("void dielectric a 0 0 5 .5 .5 .5 1.3 0"), ["red", "green", "blue", "ior"]);
        assert_eq!(names("void glass a 0 0 3 .5 .5 .5"), ["red", "green", "blue"]);
        assert_eq!(names("void ashik2 a 4 0 1 0 . 0 8 .5 .5 .5 .1 .1 .1 10 10"), ["red", "green", "blue", "a4", "a5", "a6"]);
    }
}
