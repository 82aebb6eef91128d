//! Angles and directions, in a fraction of the time that the general functions take.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2, TAU};
use wide::f64x2;

/// The angle whose cosine is z, as `z.acos()`, within 4e-16 of it; z is brought into −1..1.
#[inline]
pub fn acos(z: f64) -> f64 {
    polar([0.0, 1.0], z)[1]
}

/// The angle of (x, y) from the x axis, and the [`acos`] of z: azimuth and angle from the pole, in the time of one.
#[inline]
pub fn polar([y, x]: [f64; 2], z: f64) -> [f64; 2] {
    let z = z.clamp(-1.0, 1.0);
    atan2([y, ((1.0 - z) * (1.0 + z)).sqrt()], [x, z])
}

/// The angle of each (x, y) from the x axis, as `y.atan2(x)`, within 4e-16 of it; for numbers between 1e-300 and 1e300, zeros included. Two take the time
/// of one.
#[inline]
pub fn atan2(y: [f64; 2], x: [f64; 2]) -> [f64; 2] {
    // Selections instead of branches: directions are unpredictable.
    let (y, x, tan_eighth) = (f64x2::new(y), f64x2::new(x), f64x2::splat(SQRT_2 - 1.0));
    let (a, b) = (x.abs(), y.abs());
    let (small, large) = (a.fast_min(b), a.fast_max(b).fast_max(f64x2::splat(f64::MIN_POSITIVE)));
    // Bring the tangent below that of π/8.
    let steep = small.simd_gt(tan_eighth * large);
    let ratio = (small - (steep & large)) / (large + (steep & small));
    let angle = arctangent(ratio) + (steep & f64x2::splat(FRAC_PI_4));
    let angle = a.simd_lt(b).bitselect(f64x2::splat(FRAC_PI_2) - angle, angle);
    let angle = x.is_sign_negative().bitselect(f64x2::splat(PI) - angle, angle);
    // It has the sign of y.
    (angle | y & f64x2::splat(-0.0)).to_array()
}

/// Sine and cosine of a part of a turn, from −1 to 1, within 2e-16 of those of 2π·`turn`.
#[inline]
pub fn sin_cos(turn: f64) -> (f64, f64) {
    // What is beyond the nearest quarter is exact, and at most an eighth.
    let quarter = (4.0 * turn).round_ties_even();
    let x = TAU * (turn - 0.25 * quarter);
    let w = x * x;
    // fdlibm's polynomials (Sun Microsystems 1993, k_sin.c and k_cos.c).
    const S: [f64; 6] = [
        -0.16666666666666632,
        0.00833333333332249,
        -0.0001984126982985795,
        2.7557313707070068e-06,
        -2.5050760253406863e-08,
        1.58969099521155e-10,
    ];
    const C: [f64; 6] = [
        0.0416666666666666,
        -0.001388888888887411,
        2.480158728947673e-05,
        -2.7557314351390663e-07,
        2.087572321298175e-09,
        -1.1359647557788195e-11,
    ];
    let w2 = w * w;
    let six = |k: [f64; 6]| k[5].mul_add(w, k[4]).mul_add(w2, k[3].mul_add(w, k[2])).mul_add(w2, k[1].mul_add(w, k[0]));
    let (sin, cos) = ((x * w).mul_add(six(S), x), w2.mul_add(six(C), 1.0 - 0.5 * w));
    // Turn by the quarters: signs and roles change.
    let quarter = quarter as i32;
    let (a, b) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let signed = |value: f64, negative: i32| f64::from_bits(value.to_bits() ^ (negative as u64 & 2) << 62);
    (signed(a, quarter), signed(b, quarter + 1))
}

/// atan t for |t| up to tan π/8: t times a polynomial in t², interpolated at Chebyshev nodes (error 1.3e-18).
#[inline]
fn arctangent(t: f64x2) -> f64x2 {
    const C: [f64; 12] = [
        1.0,
        -0.3333333333333312,
        0.19999999999940893,
        -0.14285714279250245,
        0.11111110744919658,
        -0.09090896809064027,
        0.07692045330902225,
        -0.06662951813629191,
        0.05846878297330872,
        -0.05035102456601552,
        0.03796525745386593,
        -0.017805397205419446,
    ];
    let w = t * t;
    // Take the coefficients by fours (Estrin 1960), for the processor to do several at once.
    let (w2, w4) = (w * w, (w * w) * (w * w));
    let c = |i: usize| f64x2::splat(C[i]);
    let four = |i: usize| c(i + 3).mul_add(w, c(i + 2)).mul_add(w2, c(i + 1).mul_add(w, c(i)));
    four(8).mul_add(w4, four(4)).mul_add(w4, four(0)) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_general_functions() {
        let mut values = vec![0.0, 1e-300, 1e-20, 1e-9, 0.3, 0.41421356, 0.414213563, 0.7, 1.0, 1.0 - 1e-16, 1e300];
        values.extend((0..300).map(|i| f64::from(i) / 299.0));
        for &a in &values {
            for &b in &values {
                for (y, x) in [(a, b), (-a, b), (a, -b), (-a, -b)] {
                    let ([one, other], angles) = (atan2([y, x], [x, y]), [y.atan2(x), x.atan2(y)]);
                    assert!((one - angles[0]).abs() <= 4.5e-16, "atan2({y:e}, {x:e}) = {one}, not {}", angles[0]);
                    assert!((other - angles[1]).abs() <= 4.5e-16, "atan2({x:e}, {y:e}) = {other}, not {}", angles[1]);
                }
            }
            for z in [a.min(1.0), -a.min(1.0)] {
                assert!((acos(z) - z.acos()).abs() <= 4.5e-16, "acos({z}) = {}, not {}", acos(z), z.acos());
            }
        }
        for turn in values.iter().filter(|v| **v <= 1.0).flat_map(|v| [*v, -v, 0.125 * v, 0.25 + 0.125 * v]) {
            let ((sin, cos), (s, c)) = (sin_cos(turn), (TAU * turn).sin_cos());
            // The general functions are given a rounded product by a rounded 2π.
            let near = 2.5e-16 + 9.5e-16 * turn.abs();
            assert!((sin - s).abs() <= near && (cos - c).abs() <= near, "sin_cos({turn:e}) = {sin}, {cos}, not {s}, {c}");
            assert!((sin.hypot(cos) - 1.0).abs() <= 2.5e-16);
        }
        assert_eq!(atan2([0.0, -0.0], [-1.0; 2]), [PI, -PI]);
    }
}
