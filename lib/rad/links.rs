//! Which primitive each name means: the latest modifier of that name before the place of use.

use super::{Class, Primitive};
use std::collections::HashMap;

/// The most patterns, textures, mixtures and alternates that one modifier may lead through, counted as often as a ray may meet them.
pub const WEIGHT_LIMIT: usize = 1000;

/// What a name stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// `void`: nothing.
    Void,
    /// `inherit`: for an alias, the modifier of its target; in a string, that of the primitive that has the string.
    Inherit,
    /// The primitive with that index.
    To(usize),
    /// No modifier before it has that name.
    Unknown,
}

/// The links of a list of primitives, by their indices.
#[derive(Debug)]
pub struct Links {
    /// What modifies each primitive.
    pub modifier: Vec<Link>,
    /// What the strings that name modifiers mean, with the place of each string. An alias has one, its target.
    pub references: Vec<Vec<(usize, Link)>>,
}

impl Links {
    /// Looks up all names of `primitives`.
    pub fn of(primitives: &[Primitive]) -> Self {
        let mut latest: HashMap<&str, usize> = HashMap::new();
        let (mut modifier, mut references) = (Vec::with_capacity(primitives.len()), Vec::with_capacity(primitives.len()));
        for (i, primitive) in primitives.iter().enumerate() {
            let link = |name: &str| match name {
                "void" => Link::Void,
                "inherit" => Link::Inherit,
                name => latest.get(name).map_or(Link::Unknown, |&i| Link::To(i)),
            };
            modifier.push(link(&primitive.modifier));
            let named = naming_strings(&primitive.kind);
            references.push(primitive.strings.iter().enumerate().filter(|(j, _)| named(*j)).map(|(j, s)| (j, link(s))).collect());
            if primitive.type_of().is_some_and(|t| t.is_modifier()) {
                latest.insert(&primitive.name, i);
            }
        }
        Self { modifier, references }
    }

    /// The chain of modifiers of a primitive, nearest first, aliases followed: an alias stands for its target, and for what
    /// is behind it, unless it has a modifier of its own. What lies behind more modifiers than a renderer follows is left out.
    pub fn chain(&self, primitives: &[Primitive], primitive: usize) -> Vec<usize> {
        let (mut chain, mut at) = (Vec::new(), self.modifier[primitive]);
        let mut left = WEIGHT_LIMIT;
        while let (Link::To(mut i), 1..) = (at, left) {
            left -= 1;
            // What stands behind the target: the modifier of the first alias that has its own.
            let mut behind = None;
            while primitives[i].kind == "alias" && left > 0 {
                left -= 1;
                let Some(&(_, Link::To(target))) = self.references[i].first() else { return chain };
                if self.modifier[i] != Link::Inherit && self.modifier[i] != self.modifier[target] {
                    behind = behind.or(Some(self.modifier[i]));
                }
                i = target;
            }
            chain.push(i);
            at = behind.unwrap_or(self.modifier[i]);
        }
        chain
    }

    /// Which primitives are surfaces or stand behind one: in its chain, or named by what is in its chain.
    pub fn used(&self, primitives: &[Primitive]) -> Vec<bool> {
        let mut used = vec![false; primitives.len()];
        // Links point backward, so one pass from the end reaches everything.
        for i in (0..primitives.len()).rev() {
            used[i] |= primitives[i].type_of().is_some_and(|t| t.class == Class::Surface);
            if used[i] {
                let references = self.references[i].iter().map(|(_, link)| *link);
                for link in references.chain([self.modifier[i]]) {
                    if let Link::To(j) = link {
                        used[j] = true;
                    }
                }
            }
        }
        used
    }
}

/// Which strings of a type name modifiers.
fn naming_strings(kind: &str) -> fn(usize) -> bool {
    match kind {
        "alias" | "illum" | "mirror" => |i| i == 0,
        "mixfunc" | "mixdata" | "mixpict" | "mixtext" => |i| i < 2,
        "WGMDfunc" => |i| matches!(i, 0 | 4 | 8),
        "antimatter" => |_| true,
        _ => |_| false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Source;
    use crate::rad::Document;

    fn primitives(text: &str) -> Vec<Primitive> {
        Document::parse(Source::new("t.rad", text)).unwrap().primitives().cloned().collect()
    }

    #[test]
    fn a_chain_ends_where_a_renderer_gives_up() {
        let mut text = "void plastic m0 0 0 5 .5 .5 .5 0 0\n".to_string();
        (1..2 * WEIGHT_LIMIT).for_each(|i| text += &format!("m{} brightfunc m{i} 2 .9 . 0 0\n", i - 1));
        let primitives = primitives(&(text + "m1999 sphere s 0 0 4 0 0 0 1\nm4 sphere t 0 0 4 0 0 0 1\n"));
        let links = Links::of(&primitives);
        assert_eq!([2000, 2001].map(|i| links.chain(&primitives, i).len()), [WEIGHT_LIMIT, 5]);
    }

    #[test]
    fn a_name_means_the_latest_modifier_before_it() {
        let p = primitives("void plastic a 0 0 0 a sphere a 0 0 0 void metal a 0 0 0 a sphere s 0 0 0 b sphere t 0 0 0 void metal b 0 0 0");
        assert_eq!(Links::of(&p).modifier, [Link::Void, Link::To(0), Link::Void, Link::To(2), Link::Unknown, Link::Void]);
    }

    #[test]
    fn aliases_pass_their_target_or_change_what_is_behind_it() {
        let p = primitives(
            "void brightfunc f 2 x . 0 0 void colorfunc g 4 x x x . 0 0 f plastic m 0 0 0 void metal unused 0 0 0\n\
             inherit alias same m f alias also m g alias other same void alias bare other\n\
             same sphere a 0 0 0 also sphere b 0 0 0 other sphere c 0 0 0 bare sphere d 0 0 0",
        );
        let links = Links::of(&p);
        assert_eq!([8, 9, 10, 11].map(|i| links.chain(&p, i)), [vec![2, 0], vec![2, 0], vec![2, 1], vec![2]]);
        assert_eq!(links.used(&p).iter().position(|u| !u), Some(3));
    }
}
