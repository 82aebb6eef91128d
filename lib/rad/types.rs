//! Which primitive types there are: what each is, how many arguments it takes and what its numbers are called.

use std::collections::HashMap;
use std::sync::LazyLock;

/// What a primitive type is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Something to be hit.
    Surface,
    /// What a surface is made of; ends the search along a chain of modifiers.
    Material,
    /// Multiplies the colour of what is behind it.
    Pattern,
    /// Perturbs the normal.
    Texture,
    /// Chooses between two modifiers.
    Mixture,
    /// Another name for a modifier.
    Alias,
}

/// How many real arguments a type takes.
#[derive(Clone, Copy, Debug)]
pub enum Reals {
    /// One of these counts.
    Of(&'static [usize]),
    /// This many or more.
    From(usize),
    /// Three for each vertex, at least three vertices.
    Vertices,
}

/// A primitive type.
#[derive(Debug)]
pub struct Type {
    /// RADIANCE's name for it.
    pub name: &'static str,
    /// What it is for.
    pub class: Class,
    /// Fewest and most string arguments, transform words not counted.
    pub strings: (usize, usize),
    /// Real arguments.
    pub reals: Reals,
    /// Whether transform words may stand at the end of the strings, and `xform` appends its own.
    pub moves_by_words: bool,
    /// Names of the first real arguments, as `--set` and `--param` know them; `a1`, `a2`… name them too.
    pub parameters: &'static [&'static str],
}

impl Type {
    /// The type called `name`.
    pub fn named(name: &str) -> Option<&'static Type> {
        static INDEX: LazyLock<HashMap<&str, &Type>> = LazyLock::new(|| TYPES.iter().map(|t| (t.name, t)).collect());
        INDEX.get(name).copied()
    }

    /// Errors, saying how many real arguments it takes, if these are not as many.
    pub fn takes(&self, reals: usize) -> Result<(), String> {
        let (fits, needed) = match &self.reals {
            Reals::Of(counts) => {
                let counted = counts.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ");
                let all_named = counts.contains(&self.parameters.len()) && !self.parameters.is_empty();
                let names = if all_named { format!(" ({})", self.parameters.join(" ")) } else { String::new() };
                (counts.contains(&reals), format!("{counted} real arguments{names}"))
            }
            Reals::From(least) => (reals >= *least, format!("{least} or more real arguments")),
            Reals::Vertices => (reals >= 9 && reals.is_multiple_of(3), "three real arguments for each of at least three vertices".into()),
        };
        if fits { Ok(()) } else { Err(format!("{} needs {needed}, not {reals}", self.name)) }
    }

    /// Whether it can stand as the modifier of another primitive.
    pub fn is_modifier(&self) -> bool {
        self.class != Class::Surface
    }

    /// The place among the real arguments of the parameter called `name` (`rough`, `a5`).
    pub fn parameter(&self, name: &str) -> Option<usize> {
        let numbered = || name.strip_prefix('a')?.parse::<usize>().ok()?.checked_sub(1);
        self.parameters.iter().position(|p| *p == name).or_else(numbered)
    }
}

/// Every type that RADIANCE reads.
pub const TYPES: &[Type] = &[
    surface("source", Reals::Of(&[4])),
    surface("sphere", Reals::Of(&[4])),
    surface("bubble", Reals::Of(&[4])),
    surface("polygon", Reals::Vertices),
    surface("cone", Reals::Of(&[8])),
    surface("cup", Reals::Of(&[8])),
    surface("cylinder", Reals::Of(&[7])),
    surface("tube", Reals::Of(&[7])),
    surface("ring", Reals::Of(&[8])),
    Type { strings: (1, ANY), moves_by_words: true, ..surface("mesh", Reals::Of(&[0])) },
    Type { strings: (1, ANY), moves_by_words: true, ..surface("instance", Reals::Of(&[0])) },
    material("light", (0, 0), Reals::Of(&[3]), RGB),
    material("illum", (0, 1), Reals::Of(&[3]), RGB),
    material("glow", (0, 0), Reals::Of(&[4]), &["red", "green", "blue", "radius"]),
    material("spotlight", (0, 0), Reals::Of(&[7]), &["red", "green", "blue", "angle"]),
    material("mirror", (0, 1), Reals::Of(&[3]), RGB),
    function(Class::Material, "prism1", 5, Reals::From(0), &[]),
    function(Class::Material, "prism2", 9, Reals::From(0), &[]),
    material("mist", (0, ANY), Reals::Of(&[0, 3, 6, 7]), &[]),
    material("plastic", (0, 0), Reals::Of(&[5]), ISOTROPIC),
    material("metal", (0, 0), Reals::Of(&[5]), ISOTROPIC),
    material("trans", (0, 0), Reals::Of(&[7]), &["red", "green", "blue", "spec", "rough", "trans", "tspec"]),
    function(Class::Material, "plastic2", 4, Reals::Of(&[6]), ANISOTROPIC),
    function(Class::Material, "metal2", 4, Reals::Of(&[6]), ANISOTROPIC),
    function(Class::Material, "trans2", 4, Reals::Of(&[8]), &["red", "green", "blue", "spec", "urough", "vrough", "trans", "tspec"]),
    function(Class::Material, "ashik2", 4, Reals::Of(&[8]), RGB),
    function(Class::Material, "WGMDfunc", 13, Reals::From(9), &[]),
    material("dielectric", (0, 0), Reals::Of(&[5]), &["red", "green", "blue", "ior", "hartmann"]),
    material("interface", (0, 0), Reals::Of(&[8]), &["red", "green", "blue", "ior"]),
    material("glass", (0, 0), Reals::Of(&[3, 4]), &["red", "green", "blue", "ior"]),
    function(Class::Material, "plasfunc", 2, Reals::From(4), &["red", "green", "blue", "spec"]),
    function(Class::Material, "metfunc", 2, Reals::From(4), &["red", "green", "blue", "spec"]),
    function(Class::Material, "plasdata", 4, Reals::From(4), &["red", "green", "blue", "spec"]),
    function(Class::Material, "metdata", 4, Reals::From(4), &["red", "green", "blue", "spec"]),
    function(Class::Material, "transfunc", 2, Reals::From(6), &["red", "green", "blue", "spec", "trans", "tspec"]),
    function(Class::Material, "transdata", 4, Reals::From(6), &["red", "green", "blue", "spec", "trans", "tspec"]),
    function(Class::Material, "BRTDfunc", 10, Reals::From(9), &[]),
    function(Class::Material, "BSDF", 6, Reals::Of(&[0, 3, 6, 9]), &[]),
    function(Class::Material, "aBSDF", 5, Reals::Of(&[0, 3, 6, 9]), &[]),
    material("antimatter", (1, ANY), Reals::Of(&[0]), &[]),
    function(Class::Texture, "texfunc", 4, Reals::From(0), &[]),
    function(Class::Texture, "texdata", 8, Reals::From(0), &[]),
    function(Class::Pattern, "colorfunc", 4, Reals::From(0), &[]),
    function(Class::Pattern, "brightfunc", 2, Reals::From(0), &[]),
    function(Class::Pattern, "colordata", 8, Reals::From(0), &[]),
    function(Class::Pattern, "brightdata", 4, Reals::From(0), &[]),
    function(Class::Pattern, "colorpict", 7, Reals::From(0), &[]),
    plain(Class::Pattern, "colortext", (2, ANY), Reals::Of(&[15, 16])),
    plain(Class::Pattern, "brighttext", (2, ANY), Reals::Of(&[11, 12])),
    plain(Class::Pattern, "spectrum", (0, 0), Reals::From(5)),
    plain(Class::Pattern, "specfile", (1, 1), Reals::Of(&[0])),
    function(Class::Pattern, "specfunc", 2, Reals::From(2), &[]),
    function(Class::Pattern, "specdata", 4, Reals::From(0), &[]),
    function(Class::Pattern, "specpict", 5, Reals::From(0), &[]),
    function(Class::Mixture, "mixfunc", 4, Reals::From(0), &[]),
    function(Class::Mixture, "mixdata", 6, Reals::From(0), &[]),
    function(Class::Mixture, "mixpict", 7, Reals::From(0), &[]),
    plain(Class::Mixture, "mixtext", (4, ANY), Reals::Of(&[9, 10])),
    plain(Class::Alias, "alias", (1, 1), Reals::Of(&[0])),
];

const ANY: usize = usize::MAX;
const RGB: &[&str] = &["red", "green", "blue"];
const ISOTROPIC: &[&str] = &["red", "green", "blue", "spec", "rough"];
const ANISOTROPIC: &[&str] = &["red", "green", "blue", "spec", "urough", "vrough"];

const fn plain(class: Class, name: &'static str, strings: (usize, usize), reals: Reals) -> Type {
    Type { name, class, strings, reals, moves_by_words: false, parameters: &[] }
}

const fn surface(name: &'static str, reals: Reals) -> Type {
    plain(Class::Surface, name, (0, 0), reals)
}

const fn material(name: &'static str, strings: (usize, usize), reals: Reals, parameters: &'static [&'static str]) -> Type {
    Type { parameters, ..plain(Class::Material, name, strings, reals) }
}

/// A type whose strings are expressions, a function file and more, then transform words.
const fn function(class: Class, name: &'static str, strings: usize, reals: Reals, parameters: &'static [&'static str]) -> Type {
    Type { moves_by_words: true, parameters, ..plain(class, name, (strings, ANY), reals) }
}
