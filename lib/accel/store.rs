//! Where a tree lies in memory: in huge pages, if it would fill half of one and the system has them.
//!
//! Rays read a tree at random places, and a processor remembers of only some thousand pages where they are: 8 MB of the usual ones.

use super::exact::Detail;
use super::tree::{Block, Node, Tree};
use bytemuck::{Pod, cast_slice, cast_slice_mut};
use memmap2::MmapMut;
use rayon::prelude::*;
use std::sync::Arc;
use yoke::Yoke;

/// A tree, and the memory that it lies in.
pub(super) type Stored = Yoke<Tree<'static>, Arc<Memory>>;

/// Bytes of a huge page.
const HUGE: usize = 1 << 21;

/// What a tree lies in.
#[derive(Debug)]
pub(super) enum Memory {
    /// Its parts, each where it was made.
    Few(Vec<Node>, Vec<Block>, Vec<Detail>),
    /// One part behind the other in whole huge pages: how many bytes of each.
    Many(MmapMut, [usize; 3]),
}

/// The tree of these parts.
pub(super) fn store(
    nodes: Vec<Node>,
    blocks: impl IndexedParallelIterator<Item = Block>,
    details: impl IndexedParallelIterator<Item = Detail>,
    root: Option<u32>,
) -> Stored {
    let sizes = [size_of_val(&nodes[..]), blocks.len() * size_of::<Block>(), details.len() * size_of::<Detail>()];
    let memory = match pages(sizes.iter().sum()) {
        None => Memory::Few(nodes, blocks.collect(), details.collect()),
        Some(mut map) => {
            let (for_nodes, rest) = map.split_at_mut(sizes[0]);
            let (for_blocks, for_details) = rest.split_at_mut(sizes[1]);
            fill(for_nodes, nodes.into_par_iter());
            fill(for_blocks, blocks);
            fill(&mut for_details[..sizes[2]], details);
            Memory::Many(map, sizes)
        }
    };
    Stored::attach_to_cart(Arc::new(memory), |memory| memory.tree(root))
}

/// So many bytes, in huge pages; `None` if they are few, or there is no such memory.
fn pages(bytes: usize) -> Option<MmapMut> {
    if bytes < HUGE / 2 {
        return None;
    }
    let map = MmapMut::map_anon(bytes.next_multiple_of(HUGE)).ok()?;
    // A wish: where it is not granted, rays are slower, by up to an eighth among 10⁶ triangles.
    #[cfg(target_os = "linux")]
    let _ = map.advise(memmap2::Advice::HugePage);
    Some(map)
}

/// Puts values into bytes that are as many.
fn fill<T: Pod + Send>(bytes: &mut [u8], values: impl IndexedParallelIterator<Item = T>) {
    cast_slice_mut(bytes).par_iter_mut().zip(values).for_each(|(slot, value)| *slot = value);
}

impl Memory {
    fn tree(&self, root: Option<u32>) -> Tree<'_> {
        match self {
            Self::Few(nodes, blocks, details) => Tree { nodes, blocks, details, root },
            Self::Many(map, [nodes, blocks, details]) => {
                let (nodes, rest) = map.split_at(*nodes);
                let (blocks, rest) = rest.split_at(*blocks);
                Tree { nodes: cast_slice(nodes), blocks: cast_slice(blocks), details: cast_slice(&rest[..*details]), root }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn a_tree_is_stored_as_it_was_built() {
        for count in [0, 7, 12_000] {
            let nodes: Vec<Node> = (0..count).map(|i| Node { rest: [i; 8], ..Zeroable::zeroed() }).collect();
            let blocks: Vec<Block> = (0..count).map(|first| Block { first, ..Zeroable::zeroed() }).collect();
            let details: Vec<Detail> = (0..count).map(|triangle| Detail { triangle, ..Zeroable::zeroed() }).collect();
            let stored = store(nodes.clone(), blocks.par_iter().copied(), details.par_iter().copied(), Some(5));
            assert_eq!(matches!(**stored.backing_cart(), Memory::Many(..)), count == 12_000);
            let Tree { nodes: n, blocks: b, details: d, root } = stored.get();
            let bytes: [[&[u8]; 3]; 2] =
                [[cast_slice(&nodes), cast_slice(&blocks), cast_slice(&details)], [cast_slice(n), cast_slice(b), cast_slice(d)]];
            assert_eq!(bytes[0], bytes[1]);
            assert_eq!(*root, Some(5));
        }
    }
}
