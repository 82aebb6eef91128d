//! What may be meant by a word that is none.

use std::cell::RefCell;
use std::collections::HashMap;

/// For so many names that no modifier has is one sought that may be meant: a scene without its materials has more.
const SOUGHT: usize = 100;

/// What is wrong with names that no modifier has; the same for each that is wrong in many places.
#[derive(Default)]
pub struct Undefined(RefCell<HashMap<String, String>>);

impl Undefined {
    /// What is wrong with one, and which of those that are `known` so far may be meant.
    pub fn said<'a>(&self, name: &str, known: impl Iterator<Item = &'a str>) -> String {
        let mut said = self.0.borrow_mut();
        if let Some(said) = said.get(name) {
            return said.clone();
        }
        let likely = if said.len() < SOUGHT { likely(name, known.filter(|other| *other != name)) } else { None };
        let likely = likely.map_or(String::new(), |likely| format!("; `{likely}` is"));
        let new = format!("no modifier `{name}` is defined before this{likely}");
        said.insert(name.into(), new.clone());
        new
    }
}

/// The nearest to a word of some others, if it is so near that it may be meant: no more than two letters are wrong, nor more than half of it.
pub fn likely<'a>(word: &str, others: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let nearest = others.map(|other| (distance(word, other), other)).min();
    nearest.filter(|(wrong, _)| *wrong <= 2.min(word.chars().count() / 2)).map(|(_, likely)| likely)
}

/// Edits between two words (Levenshtein 1966), letters compared without case.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.to_lowercase().chars().enumerate() {
        let mut corner = std::mem::replace(&mut row[0], i + 1);
        for (j, cb) in b.iter().enumerate() {
            let best = (row[j] + 1).min(row[j + 1] + 1).min(corner + usize::from(ca != *cb));
            corner = std::mem::replace(&mut row[j + 1], best);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_sought_once_and_so_are_not_too_many() {
        let undefined = Undefined::default();
        let known = || ["oak", "brass"].into_iter();
        assert_eq!(undefined.said("bras", known()), "no modifier `bras` is defined before this; `brass` is");
        assert_eq!(undefined.said("bras", std::iter::empty()), undefined.said("bras", known()));
        assert_eq!(undefined.said("marble", known()), "no modifier `marble` is defined before this");
        let last = (0..2 * SOUGHT).map(|i| undefined.said(&format!("oa{i}"), known())).last();
        assert_eq!(last.as_deref(), Some("no modifier `oa199` is defined before this"));
    }
}
