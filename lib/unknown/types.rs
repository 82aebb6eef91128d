//! The same unknown taken for another type of material.

use super::{COLORS, EXPOSURES, Unknown, Wishes};
use crate::error::{Error, Result};
use crate::material::GLASS_INDEX;
use crate::rad::{Document, Type};

/// The types that an unknown can be taken for, and what their parameters start with where the file does not say.
pub const TYPES: [(&str, &[f64]); 5] = [
    ("plastic", &[0.5, 0.5, 0.5, 0.1, 0.1]),
    ("metal", &[0.5, 0.5, 0.5, 0.5, 0.1]),
    ("trans", &[0.5, 0.5, 0.5, 0.1, 0.1, 0.5, 0.5]),
    ("dielectric", &[0.5, 0.5, 0.5, 1.5, 0.0]),
    (GLASS, &[0.5, 0.5, 0.5]),
];

/// The one whose index of refraction a file may leave out.
pub const GLASS: &str = "glass";

impl Unknown {
    /// The unknown of a scene file, taken for `kind`, one of [`TYPES`]. What is wished of parameters that it does not have is left out.
    fn taken_for(kind: &str, document: &Document, wishes: &Wishes) -> Result<Self> {
        let (document, wishes) = retyped(kind, document, wishes)?;
        Self::new(document, &wishes)
    }

    /// The unknown of a scene file as each type that it may be: [`TYPES`], and the file's own where that is the anisotropic form of one; or why it
    /// cannot be taken for it.
    pub fn of_each_type(document: &Document, wishes: &Wishes) -> Result<Vec<(String, Result<Self>)>> {
        let own = &super::choose(document, wishes.material.as_deref())?.kind;
        let mut all: Vec<_> = TYPES.iter().map(|(kind, _)| (kind.to_string(), Self::taken_for(kind, document, wishes))).collect();
        if own.strip_suffix('2').is_some_and(|stem| TYPES.iter().any(|(kind, _)| *kind == stem)) {
            let as_it_is = || starting(own, &super::choose(document, wishes.material.as_deref())?.reals, document, wishes);
            all.push((own.clone(), as_it_is().and_then(|(document, wishes)| Self::new(document, &wishes))));
        }
        Ok(all)
    }

    /// The unknown of a scene file, taken for glass whose index of refraction is sought too.
    pub fn as_glass_of_any_index(document: &Document, wishes: &Wishes) -> Result<Self> {
        let (document, wishes) = starting(GLASS, &ANY_GLASS, document, wishes)?;
        Self::new(document, &wishes)
    }
}

/// A scene file with its unknown taken for `kind`, one of [`TYPES`], and what is wished of it that it can have.
///
/// A parameter keeps its value by its name. Glass has an index of refraction only if something is wished of it.
pub fn retyped(kind: &str, document: &Document, wishes: &Wishes) -> Result<(Document, Wishes)> {
    let starts = TYPES.iter().find(|(name, _)| *name == kind).map_or(&[][..], |(_, starts)| *starts);
    let from = super::choose(document, wishes.material.as_deref())?.type_of();
    let index = |word: &String| from.and_then(|from| from.parameters.get(from.parameter(word)?)).map_or(&word[..], |name| *name) == "ior";
    let mut wished = wishes.bounds.iter().map(|wish| &wish.name).chain(&wishes.fixed).chain(wishes.tied.iter().flatten());
    let starts = if kind == GLASS && wished.any(index) { &ANY_GLASS } else { starts };
    starting(kind, starts, document, wishes)
}

/// What glass starts with whose index of refraction is among its numbers.
const ANY_GLASS: [f64; 4] = [0.5, 0.5, 0.5, GLASS_INDEX];

/// The same with as many parameters as there are `starts`, which are what the file does not say; none for a type that no unknown can be taken for.
fn starting(kind: &str, starts: &[f64], document: &Document, wishes: &Wishes) -> Result<(Document, Wishes)> {
    let material = super::choose(document, wishes.material.as_deref())?;
    let (Some(to), Some(from)) = (Type::named(kind).filter(|_| !starts.is_empty()), material.type_of()) else {
        let names = TYPES.map(|(name, _)| name).join(", ");
        return Err(Error::new(format!("no unknown can be taken for {kind}; name one of {names}")));
    };
    let named = |name: &str| from.parameters.iter().position(|p| *p == name).and_then(|i| material.reals.get(i));
    let mut reals: Vec<f64> = to.parameters.iter().zip(starts).map(|(name, start)| *named(name).unwrap_or(start)).collect();
    if from.name == to.name && material.reals.len() >= starts.len() {
        reals.clone_from(&material.reals);
    }
    // Only the names of parameters mean the same in both.
    let name = |word: &str| -> Result<Option<String>> {
        if EXPOSURES.contains(&word) {
            return Ok(Some(word.to_string()));
        }
        let name = from.parameter(word).and_then(|i| from.parameters.get(i)).map_or(word, |name| *name);
        let of = |t: &Type, most: usize| t.parameters.iter().take(most).any(|p| *p == name);
        let mut tried = TYPES.iter().filter_map(|(kind, _)| Type::named(kind)).chain([from]);
        let somewhere = name == COLORS.0 || tried.any(|t| of(t, usize::MAX));
        if !somewhere {
            return Err(material.error(format!("no type of material that is tried has a parameter `{word}`")));
        }
        Ok((name == COLORS.0 || of(to, reals.len())).then(|| name.to_string()))
    };
    let names = |words: &[String]| words.iter().filter_map(|word| name(word).transpose()).collect::<Result<Vec<_>>>();
    let lists = |lists: &[Vec<String>]| lists.iter().map(|list| names(list)).collect::<Result<Vec<_>>>();
    let mut bounds = Vec::new();
    for wish in &wishes.bounds {
        let Some(name) = name(&wish.name)? else { continue };
        // What the file says of another type is no more than a hint.
        let hint = named(&name).map_or(0.5 * (wish.low + wish.high), |value| value.clamp(wish.low, wish.high));
        let other = from.name != to.name && !EXPOSURES.contains(&&name[..]);
        let start = wish.start.or(other.then_some(hint));
        bounds.push(super::Bounds { name, start, ..wish.clone() });
    }
    let wishes = Wishes {
        material: Some(material.name.clone()),
        bounds,
        fixed: names(&wishes.fixed)?,
        // What is left alone is tied no more.
        tied: lists(&wishes.tied)?.into_iter().filter(|tie| tie.len() > 1).collect(),
        groups: lists(&wishes.groups)?,
    };
    let same = from.name == to.name && reals == material.reals;
    Ok((if same { document.clone() } else { document.retyped(&material.name, kind, &reals)? }, wishes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;

    #[test]
    fn parameters_keep_their_values_and_wishes_by_name() {
        let document = Document::parse(Source::new("s.rad", "void dielectric m 0 0 5 .1 .2 .3 1.4 0\n")).unwrap();
        let wishes = Wishes {
            bounds: vec!["a4=:1.2:1.6".parse().unwrap(), "rough=.2:.1:.3".parse().unwrap()],
            fixed: vec!["green".into(), "trans".into()],
            tied: vec![vec!["spec".into(), "rough".into(), "ior".into()]],
            ..Wishes::default()
        };
        let free = |kind: &str| {
            let unknown = Unknown::taken_for(kind, &document, &wishes).unwrap();
            unknown.parameters().iter().map(|p| (p.name.clone(), p.start, p.high)).collect::<Vec<_>>()
        };
        let [red, blue] = [("red".to_string(), 0.1, 1.0), ("blue".to_string(), 0.3, 1.0)];
        assert_eq!(free("dielectric"), [red, blue, ("ior".into(), 1.4, 1.6)]);
        assert_eq!(free("glass"), free("dielectric"));
        let pane = Unknown::taken_for("glass", &document, &Wishes { bounds: vec![], tied: vec![], ..wishes.clone() }).unwrap();
        assert_eq!(pane.material().reals, [0.1, 0.2, 0.3]);
        let tied = Wishes { tied: vec![], ..wishes.clone() };
        let trans = Unknown::taken_for("trans", &document, &tied).unwrap();
        let names: Vec<&str> = trans.parameters().iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["red", "blue", "spec", "rough", "tspec"]);
        assert_eq!(trans.reals(&[0.1, 0.3, 0.1, 0.2, 0.5]), [0.1, 0.2, 0.3, 0.1, 0.2, 0.5, 0.5]);
        let glass = Unknown::as_glass_of_any_index(&document, &Wishes::default()).unwrap();
        let free: Vec<_> = glass.parameters().iter().map(|p| (p.name.as_str(), p.start)).collect();
        assert_eq!(free, [("red", 0.1), ("green", 0.2), ("blue", 0.3), ("ior", 1.4)]);
        // Its index is wished for like any other parameter, and starts as that of glass where the file says nothing of one.
        let glass = Unknown::as_glass_of_any_index(&document, &tied).unwrap();
        let [_, _, index] = glass.parameters() else { panic!() };
        assert_eq!((index.start, index.low, index.high), (1.4, 1.2, 1.6));
        let pane = Document::parse(Source::new("p.rad", "void glass m 0 0 3 .1 .2 .3\n")).unwrap();
        let known = Unknown::as_glass_of_any_index(&pane, &Wishes { fixed: vec!["ior".into()], ..Wishes::default() }).unwrap();
        assert_eq!(known.reals(&known.start()), [0.1, 0.2, 0.3, GLASS_INDEX]);
        // So it is where the type is named; and a type of the file's own heeds what it has.
        let known = Wishes { fixed: vec!["ior".into()], ..Wishes::default() };
        let glass = Unknown::taken_for("glass", &document, &known).unwrap();
        assert_eq!(glass.reals(&glass.start()), [0.1, 0.2, 0.3, 1.4]);
        let brushed = Document::parse(Source::new("b.rad", "void metal2 m 4 1 0 0 . 0 6 .5 .5 .5 .9 .1 .2\n")).unwrap();
        let other = Wishes { bounds: vec!["rough=.1:0:.3".parse().unwrap()], ..Wishes::default() };
        let all = Unknown::of_each_type(&brushed, &other).unwrap();
        assert!(all.iter().any(|(kind, unknown)| kind == "metal2" && unknown.is_ok()));
        let wrong = Wishes { fixed: vec!["gloss".into()], ..Wishes::default() };
        assert!(Unknown::taken_for("metal", &document, &wrong).unwrap_err().message.contains("no type of material that is tried"));
    }

    #[test]
    fn two_roughnesses_of_the_file_are_tried_beside_the_types() {
        let kinds = |text: &str, fixed: &[&str]| {
            let document = Document::parse(Source::new("a.rad", text)).unwrap();
            let wishes = Wishes { fixed: fixed.iter().map(|name| name.to_string()).collect(), ..Wishes::default() };
            let all = Unknown::of_each_type(&document, &wishes).unwrap();
            all.into_iter().map(|(kind, unknown)| (kind, unknown.unwrap().parameters().len())).collect::<Vec<_>>()
        };
        let types = [("plastic", 5), ("metal", 5), ("trans", 7), ("dielectric", 4), ("glass", 3)].map(|(kind, n)| (kind.to_string(), n));
        assert_eq!(kinds("void plastic m 0 0 5 .5 .5 .5 .1 .1", &[]), types);
        let brushed = kinds("void metal2 m 4 0 0 1 . 0 6 .5 .5 .5 .9 .1 .2", &["vrough"]);
        assert_eq!((&brushed[..5], brushed[5].0.as_str(), brushed[5].1), (&types[..], "metal2", 5));
    }
}
