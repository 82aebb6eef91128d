//! Antimatter on a ray's way: which modifiers are not there, and inside how many bodies of each the ray is.

use crate::scene::ChainId;

/// The state of a ray among antimatter. A body's front is outside: a ray that meets it enters.
#[derive(Clone, Debug, Default)]
pub struct Clip {
    /// Modifiers that are not there.
    removed: Vec<ChainId>,
    /// How often the ray has entered bodies of a modifier more than left them.
    inside: Vec<(ChainId, i32)>,
}

impl Clip {
    /// Whether surfaces of this modifier are not there.
    pub fn removes(&self, chain: ChainId) -> bool {
        self.removed.contains(&chain)
    }

    /// Takes the surface of a body into account.
    pub fn cross(&mut self, chain: ChainId, entering: bool) {
        let change = if entering { 1 } else { -1 };
        match self.inside.iter_mut().find(|i| i.0 == chain) {
            Some(inside) => inside.1 += change,
            None => self.inside.push((chain, change)),
        }
    }

    /// Takes the surface of antimatter that removes `chains` into account.
    pub fn cut(&mut self, chains: &[ChainId], entering: bool) {
        self.removed.retain(|chain| !chains.contains(chain));
        if entering {
            self.removed.extend(chains);
        }
    }

    /// Whether the ray is inside bodies of these modifiers.
    pub fn is_inside(&self, chains: &[ChainId]) -> bool {
        self.inside.iter().filter(|(chain, _)| chains.contains(chain)).map(|i| i.1).sum::<i32>() > 0
    }
}
