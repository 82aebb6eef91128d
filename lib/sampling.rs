//! Low-discrepancy numbers, warps of them with their densities, tabulated distributions, and what combines several samplers.
//!
//! Every number follows from (seed, pixel, sample index, dimension) and from nothing else: never from a thread or a tile.

use crate::vector::Vec3;
use crate::vector::angle::sin_cos;

/// The random numbers of one sample of one pixel: an Owen-scrambled Sobol' (0, 2)-sequence, each pair of dimensions
/// shuffled and scrambled on its own (Burley 2020, "Practical Hash-based Owen Scrambling").
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    seed: u32,
    index: u32,
    dimension: u32,
}

impl Sampler {
    /// The numbers of sample `index` in the sequence that `seed`, `pixel` and `group` name. Different groups of a pixel are
    /// scrambled independently, so that the spread of their means tells the error.
    pub fn new(seed: u64, pixel: u64, group: u32, index: u32) -> Self {
        let mixed = mix64(seed ^ mix64(pixel.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (group as u64) << 40));
        Self { seed: (mixed >> 32) as u32 ^ mixed as u32, index, dimension: 0 }
    }

    /// The next pair of numbers in [0, 1).
    pub fn pair(&mut self) -> [f64; 2] {
        self.dimension += 1;
        let key = hash32(self.seed ^ self.dimension.wrapping_mul(0x9e37_79b9));
        let shuffled = owen_scramble(self.index, key);
        let x = owen_scramble(shuffled.reverse_bits(), key ^ 0x68bc_21eb);
        let y = owen_scramble(sobol_second(shuffled), key ^ 0x02e5_be93);
        [unit(x), unit(y)]
    }

    /// The next number in [0, 1).
    pub fn single(&mut self) -> f64 {
        self.pair()[0]
    }

    /// A generator for a further path of the same sample, independent of what this one draws next.
    pub fn fork(&mut self) -> Self {
        self.dimension += 1;
        Self { seed: hash32(self.seed ^ self.dimension.wrapping_mul(0x85eb_ca6b)), index: self.index, dimension: 0 }
    }
}

/// A 32-bit fraction as a number in [0, 1).
fn unit(x: u32) -> f64 {
    x as f64 * (1.0 / 4294967296.0)
}

/// A mixing function of 64 bits (Stafford 2011, variant 13, the finaliser of splitmix64).
pub fn mix64(mut x: u64) -> u64 {
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

/// A mixing function of 32 bits (Wellons 2018, "lowbias32").
fn hash32(mut x: u32) -> u32 {
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// Owen scrambling of the fraction `x` (most significant bit first): each bit is flipped by a hash of the bits above it
/// (Laine and Karras 2011, with the constants of Vegdahl 2021).
fn owen_scramble(x: u32, seed: u32) -> u32 {
    let mut v = x.reverse_bits();
    v ^= v.wrapping_mul(0x3d20_adea);
    v = v.wrapping_add(seed);
    v = v.wrapping_mul((seed >> 16) | 1);
    v ^= v.wrapping_mul(0x0552_6c56);
    v ^= v.wrapping_mul(0x53a2_2864);
    v.reverse_bits()
}

/// The second dimension of Sobol's sequence as a fraction: the index, most significant bit first, times Pascal's triangle modulo 2.
fn sobol_second(index: u32) -> u32 {
    let mut x = index;
    x ^= (x >> 16) & 0x0000_ffff;
    x ^= (x >> 8) & 0x00ff_00ff;
    x ^= (x >> 4) & 0x0f0f_0f0f;
    x ^= (x >> 2) & 0x3333_3333;
    x ^= (x >> 1) & 0x5555_5555;
    x.reverse_bits()
}

/// A point of the unit disk, uniform in area, from the unit square (Shirley and Chiu 1997).
pub fn disk([u, v]: [f64; 2]) -> [f64; 2] {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    let (r, turn) = if a.abs() > b.abs() { (a, 0.125 * (b / a)) } else { (b, 0.25 - 0.125 * (a / b)) };
    let (sin, cos) = sin_cos(turn);
    [r * cos, r * sin]
}

/// The place of that number in the unit square on a lattice that is even in each of its two dimensions: its steps are 1/ρ and 1/ρ² of the plastic
/// number, ρ³ = ρ + 1 (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
pub fn lattice(number: usize) -> [f64; 2] {
    [0.754_877_666_246_692_8, 0.569_840_290_998_053_2].map(|step| (number as f64 * step).fract())
}

/// A direction of the hemisphere around +z with density cos θ / π (per solid angle).
pub fn cosine_hemisphere(u: [f64; 2]) -> Vec3 {
    let [x, y] = disk(u);
    Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// A direction of the cone around +z whose half angle has 1 − cos = `one_minus_cos`, uniform in solid angle (density 1/(2π `one_minus_cos`)).
pub fn cone([u, v]: [f64; 2], one_minus_cos: f64) -> Vec3 {
    let one_minus_z = u * one_minus_cos;
    let r = (one_minus_z * (2.0 - one_minus_z)).max(0.0).sqrt();
    let (sin, cos) = sin_cos(v);
    Vec3::new(r * cos, r * sin, 1.0 - one_minus_z)
}

/// A distribution over equal steps of [0, 1), constant on each: inverted monotonically, so that well-spread numbers stay well spread.
#[derive(Clone, Debug)]
pub struct Steps {
    /// Cumulative probability at the end of each step; the last is 1.
    cumulative: Box<[f32]>,
    /// For each of as many equal parts of [0, 1): a step at or before the one where it falls.
    guide: Box<[u32]>,
}

impl Steps {
    /// The distribution proportional to `weights` (finite, not negative), and their sum. `None` if the sum is zero.
    pub fn new(weights: &[f32]) -> Option<(Self, f64)> {
        let total: f64 = weights.iter().map(|&w| w as f64).sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut sum = 0.0;
        let mut cumulative: Box<[f32]> = weights
            .iter()
            .map(|&w| {
                sum += w as f64;
                (sum / total) as f32
            })
            .collect();
        // What rounding leaves belongs to the last step that can occur.
        let last = weights.iter().rposition(|&w| w > 0.0)?;
        cumulative[last..].fill(1.0);
        let n = weights.len();
        let mut step = 0;
        let guide = (0..n)
            .map(|part| {
                while (cumulative[step] as f64) < part as f64 / n as f64 {
                    step += 1;
                }
                step as u32
            })
            .collect();
        Some((Self { cumulative, guide }, total))
    }

    /// The step where `u` in [0, 1) falls, and how far into it, in [0, 1).
    pub fn sample(&self, u: f64) -> (usize, f64) {
        let n = self.guide.len();
        let mut i = self.guide[((u * n as f64) as usize).min(n - 1)] as usize;
        while self.cumulative[i] as f64 <= u {
            i += 1;
        }
        let below = self.below(i);
        (i, ((u - below) / (self.cumulative[i] as f64 - below)).clamp(0.0, 1.0 - f64::EPSILON))
    }

    /// The probability of step `i`.
    pub fn probability(&self, i: usize) -> f64 {
        self.cumulative[i] as f64 - self.below(i)
    }

    fn below(&self, i: usize) -> f64 {
        if i == 0 { 0.0 } else { self.cumulative[i - 1] as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(n: u32) -> Vec<[f64; 2]> {
        (0..n).map(|i| Sampler::new(1, 2, 3, i).pair()).collect()
    }

    #[test]
    fn the_sequence_is_a_net_in_base_two() {
        // Each elementary interval of area 1/64 holds exactly one of the first 64 points: the defining property of a (0, 6, 2)-net.
        for k in 0..=6 {
            let (nx, ny) = (1 << k, 64 >> k);
            let mut seen = vec![0; 64];
            points(64).iter().for_each(|p| seen[(p[0] * nx as f64) as usize * ny + (p[1] * ny as f64) as usize] += 1);
            assert!(seen.iter().all(|&c| c == 1), "{k}: {seen:?}");
        }
    }

    #[test]
    fn dimensions_and_groups_differ() {
        let mut s = Sampler::new(0, 0, 0, 5);
        assert_ne!(s.pair(), s.pair());
        assert_ne!(Sampler::new(0, 0, 0, 5).pair(), Sampler::new(0, 0, 1, 5).pair());
        assert_ne!(Sampler::new(0, 0, 0, 5).pair(), Sampler::new(0, 1, 0, 5).pair());
    }

    #[test]
    fn the_mean_of_a_smooth_function_converges_faster_than_random_points_allow() {
        // ∫∫ x y² = 1/6.
        let error = |n: u32| (points(n).iter().map(|p| p[0] * p[1] * p[1]).sum::<f64>() / n as f64 - 1.0 / 6.0).abs();
        assert!(error(4096) < 2e-4);
    }

    #[test]
    fn steps_give_their_weights_back() {
        let (steps, total) = Steps::new(&[1.0, 0.0, 3.0, 4.0, 0.0]).unwrap();
        assert_eq!(total, 8.0);
        let mut count = [0.0; 5];
        let n = 80_000;
        (0..n).for_each(|i| count[steps.sample((i as f64 + 0.5) / n as f64).0] += 1.0 / n as f64);
        for (i, c) in count.iter().enumerate() {
            assert!((c - steps.probability(i)).abs() < 1e-4, "{count:?}");
        }
        assert_eq!(steps.sample(1.0 - f64::EPSILON).0, 3);
        assert!(Steps::new(&[0.0]).is_none());
    }
}
