//! Sums over pixels that are the same for any number of threads.

use rayon::prelude::*;

/// `width` sums over `count` pixels, to which `part` adds those of one. Fixed pieces, summed in order: the same bytes for any number of threads. Compiled
/// once for all of them, as what shares work between threads is long.
pub fn total(count: usize, width: usize, part: &(dyn Fn(usize, &mut [f64]) + Sync)) -> Vec<f64> {
    let piece = |piece: usize| {
        let mut sums = vec![0.0; width];
        (piece * PIECE..((piece + 1) * PIECE).min(count)).for_each(|p| part(p, &mut sums));
        sums
    };
    let pieces: Vec<Vec<f64>> = (0..count.div_ceil(PIECE)).into_par_iter().with_max_len(1).map(piece).collect();
    let mut sums = vec![0.0; width];
    pieces.iter().for_each(|piece| sums.iter_mut().zip(piece).for_each(|(sum, piece)| *sum += piece));
    sums
}

/// Pixels that are summed at a time.
const PIECE: usize = 256;
