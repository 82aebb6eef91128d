//! Values that look random but follow from a position: Perlin noise, fractal noise, `rand`.

/// A number in 0..1 that follows from `seed` (measured on rcalc; NaN where it has no value).
pub(super) fn rand(seed: f64) -> f64 {
    // One digit short of e and of π/4: with 1e5 behind them, the digits matter.
    #[allow(clippy::approx_constant)]
    const NEAR_E: f64 = 2.71828182845904;
    const NEAR_QUARTER_PI: f64 = 0.785398163397447;
    let product = seed * (1.0 / (1.0 + seed * seed) + NEAR_E);
    let x = 1e5 / (product + NEAR_QUARTER_PI - product.floor());
    x - x.floor()
}

/// Gradient noise in −1..1, zero at whole coordinates (Perlin 2002, "Improving Noise").
pub(super) fn perlin(x: f64, y: f64, z: f64) -> f64 {
    let cell = |v: f64| v.floor().rem_euclid(256.0) as usize;
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mix = |t: f64, a: f64, b: f64| a + t * (b - a);
    let (i, j, k) = (cell(x), cell(y), cell(z));
    let (x, y, z) = (x - x.floor(), y - y.floor(), z - z.floor());
    let shuffle = |n: usize| usize::from(PERMUTATION[n & 255]);
    let corner = |a: usize, b: usize, c: usize| {
        let hash = shuffle(shuffle(shuffle(i + a) + j + b) + k + c);
        gradient(hash, x - a as f64, y - b as f64, z - c as f64)
    };
    let (u, v) = (fade(x), fade(y));
    let layer = |c| mix(v, mix(u, corner(0, 0, c), corner(1, 0, c)), mix(u, corner(0, 1, c), corner(1, 1, c)));
    mix(fade(z), layer(0), layer(1))
}

/// The one-sided difference quotient of [`perlin`] along `axis` that RADIANCE takes for its derivative.
pub(super) fn perlin_slope(axis: usize, mut p: [f64; 3]) -> f64 {
    const STEP: f64 = 0.0005;
    let here = perlin(p[0], p[1], p[2]);
    p[axis] -= STEP;
    (here - perlin(p[0], p[1], p[2])) / STEP
}

/// Fractal noise: a unit cube with hashed corner values, halved round the point with displaced midpoints down to 1/2000 (measured on rtrace).
pub(super) fn fractal(p: [f64; 3]) -> f64 {
    const STEPS: i64 = 2000;
    // Keep the integers exact; so far out the noise has no structure left anyway.
    if p.iter().any(|v| v.is_nan() || v.abs() > 1e12) {
        return f64::NAN;
    }
    let target = p.map(|v| (v * STEPS as f64) as i64);
    let mut low = p.map(|v| v.floor() as i64 * STEPS);
    let mut edge = STEPS;
    // Bit i of a corner's index says that it lies at the far end of axis i.
    let mut corner: [f64; 8] = std::array::from_fn(|c| hash(std::array::from_fn(|i| low[i] + edge * (c as i64 >> i & 1))));
    loop {
        let mut centre = corner.iter().sum::<f64>() * 0.125;
        edge /= 2;
        if edge == 0 {
            return centre;
        }
        let size = edge as f64 / STEPS as f64;
        let middle = low.map(|v| v + edge);
        let octant = (0..3).filter(|&i| target[i] > middle[i]).fold(0usize, |bits, i| bits | 1 << i);
        let shift = |i: usize| if octant >> i & 1 == 1 { edge } else { -edge };
        centre += size * hash(middle);
        let mut next = [0.0; 8];
        next[octant] = corner[octant];
        next[!octant & 7] = centre;
        for i in 0..3 {
            // The midpoint of the cube's face that the octant touches across axis i.
            let mut at = middle;
            at[i] += shift(i);
            let face: f64 = (0..8).filter(|c| (c ^ octant) >> i & 1 == 0).map(|c| corner[c]).sum();
            next[!(octant ^ 1 << i) & 7] = 0.25 * face + size * hash(at);
            // The midpoint of the cube's edge along axis i.
            let mut at = middle;
            for j in [(i + 1) % 3, (i + 2) % 3] {
                at[j] += shift(j);
            }
            let ends = corner[octant & !(1 << i)] + corner[octant | 1 << i];
            next[octant ^ 1 << i] = 0.5 * ends + size * hash(at);
        }
        corner = next;
        low = std::array::from_fn(|i| low[i] + edge * (octant >> i & 1) as i64);
    }
}

/// A number in −1..1 for a lattice point.
fn hash(p: [i64; 3]) -> f64 {
    let s = p[0].wrapping_mul(17).wrapping_add(p[1].wrapping_mul(23)).wrapping_add(p[2].wrapping_mul(29));
    let s = s.wrapping_shl(13) ^ s;
    let n = s.wrapping_mul(s.wrapping_mul(s).wrapping_mul(15731).wrapping_add(789221)).wrapping_add(1376312589);
    1.0 - (n & 0x7fff_ffff) as f64 / 1073741824.0
}

/// The dot product with one of twelve directions to the edges of a cube.
fn gradient(hash: usize, x: f64, y: f64, z: f64) -> f64 {
    let h = hash & 15;
    let u = if h < 8 { x } else { y };
    let v = match h {
        0..4 => y,
        12 | 14 => x,
        _ => z,
    };
    (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
}

/// The standard permutation of Perlin's noise.
#[rustfmt::skip]
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99, 37, 240, 21, 10, 23, 190, 6, 148,
    247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32, 57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175,
    74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54,
    65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64,
    52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213,
    119, 248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104,
    218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179, 162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157,
    184, 84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128, 195, 78, 66, 215, 61, 156, 180,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// `rcalc -n -e '$1=rand(7)'` and so on (Radiance 6.0a).
    #[test]
    fn rand_is_radiance_s() {
        for (seed, value) in [(7.0, 0.964715517), (0.5, 0.234347013), (-3.2, 0.378660016), (0.0, 0.954473516), (1e6, 0.312365513)] {
            assert!((rand(seed) - value).abs() < 1e-9, "{seed}: {}", rand(seed));
        }
    }

    /// A brightfunc of noise3(..), noise3x(..) on a glow seen by `rtrace -h -faa` (Radiance 6.0a).
    #[test]
    fn perlin_noise_is_radiance_s() {
        let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-6 * b.abs(), "{a} {b}");
        near(perlin(0.3, 0.4, 0.5), -7.353335e-3);
        near(perlin(2.3, 3.4, 0.5), 4.413669e-1);
        near(perlin_slope(0, [0.3, 0.4, 0.5]), -1.171078);
        assert_eq!(perlin(1.0, 2.0, 3.0), 0.0);
        assert_eq!(perlin(1e10, 2.0, 3.0), 0.0);
    }

    /// A brightfunc of fnoise3(..) on a glow seen by `rtrace -h -faa` (Radiance 6.0a).
    #[test]
    fn fractal_noise_is_radiance_s() {
        for (p, value) in [
            ([0.3, 0.4, 0.5], -4.145853e-1),
            ([0.25, 0.5, 0.75], -2.387411e-1),
            ([1.0, 2.0, 3.0], -6.420448e-1),
            ([3.3, 14.4, -5.5], 3.566529e-1),
            ([-0.01, 7.77, 0.999], 4.259148e-2),
            ([1e6, 2.0, 3.0], 6.389068e-1),
        ] {
            assert!((fractal(p) - value).abs() < 1e-6, "{p:?}: {}", fractal(p));
        }
    }
}
