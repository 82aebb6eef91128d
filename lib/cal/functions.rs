//! The functions every `.cal` text may call, by name, and what they compute.
//!
//! A result that does not exist (division by zero, logarithm of a negative number) is NaN, which every operation passes on, but for powers: that
//! of anything to 0 is 1, and so is that of 1 to anything.

use super::noise;
use std::f64::consts::FRAC_2_SQRT_PI;

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Unary {
    Negate,
    Sqrt,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Floor,
    Ceil,
    Exp,
    Log,
    Log10,
    Erf,
    Erfc,
    Rand,
}

/// A function of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Atan2,
    Min,
    Max,
}

/// A function of three numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Ternary {
    Noise,
    NoiseX,
    NoiseY,
    NoiseZ,
    Fractal,
}

/// A function that needs no definition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Builtin {
    If,
    Select,
    Arg,
    /// Folded over any number of arguments.
    Fold(Binary),
    Unary(Unary),
    Binary(Binary),
    Ternary(Ternary),
}

impl Builtin {
    /// The function of that name.
    pub fn named(name: &str) -> Option<Self> {
        use Builtin::{Arg, Fold, If, Select};
        let unary = |f| Some(Self::Unary(f));
        let ternary = |f| Some(Self::Ternary(f));
        match name {
            "if" => Some(If),
            "select" => Some(Select),
            "arg" => Some(Arg),
            "min" => Some(Fold(Binary::Min)),
            "max" => Some(Fold(Binary::Max)),
            "atan2" => Some(Self::Binary(Binary::Atan2)),
            "sqrt" => unary(Unary::Sqrt),
            "sin" => unary(Unary::Sin),
            "cos" => unary(Unary::Cos),
            "tan" => unary(Unary::Tan),
            "asin" => unary(Unary::Asin),
            "acos" => unary(Unary::Acos),
            "atan" => unary(Unary::Atan),
            "floor" => unary(Unary::Floor),
            "ceil" => unary(Unary::Ceil),
            "exp" => unary(Unary::Exp),
            "log" => unary(Unary::Log),
            "log10" => unary(Unary::Log10),
            "erf" => unary(Unary::Erf),
            "erfc" => unary(Unary::Erfc),
            "rand" => unary(Unary::Rand),
            "noise3" => ternary(Ternary::Noise),
            "noise3x" => ternary(Ternary::NoiseX),
            "noise3y" => ternary(Ternary::NoiseY),
            "noise3z" => ternary(Ternary::NoiseZ),
            "fnoise3" => ternary(Ternary::Fractal),
            _ => None,
        }
    }

    /// How many arguments it must be given at least.
    pub fn arity(self) -> usize {
        match self {
            Self::If => 2,
            Self::Select | Self::Arg | Self::Fold(_) | Self::Unary(_) => 1,
            Self::Binary(_) => 2,
            Self::Ternary(_) => 3,
        }
    }
}

impl Unary {
    #[inline(never)]
    pub fn apply(self, x: f64) -> f64 {
        match self {
            Self::Negate => -x,
            Self::Sqrt => x.sqrt(),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Floor => x.floor(),
            Self::Ceil => x.ceil(),
            Self::Exp => x.exp(),
            Self::Log => x.ln(),
            Self::Log10 => x.log10(),
            Self::Erf => erf(x),
            Self::Erfc => erfc(x),
            Self::Rand => noise::rand(x),
        }
    }
}

impl Binary {
    #[inline(never)]
    pub fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => divide(a, b),
            Self::Power => power(a, b),
            Self::Atan2 => a.atan2(b),
            Self::Min if a < b => a,
            Self::Min if b <= a => b,
            Self::Max if a > b => a,
            Self::Max if b >= a => b,
            Self::Min | Self::Max => f64::NAN,
        }
    }
}

impl Ternary {
    #[inline(never)]
    pub fn apply(self, [x, y, z]: [f64; 3]) -> f64 {
        if x.is_nan() || y.is_nan() || z.is_nan() {
            return f64::NAN;
        }
        match self {
            Self::Noise => noise::perlin(x, y, z),
            Self::NoiseX => noise::perlin_slope(0, [x, y, z]),
            Self::NoiseY => noise::perlin_slope(1, [x, y, z]),
            Self::NoiseZ => noise::perlin_slope(2, [x, y, z]),
            Self::Fractal => noise::fractal([x, y, z]),
        }
    }
}

/// The quotient; NaN for a divisor of zero.
#[inline]
pub(super) fn divide(a: f64, b: f64) -> f64 {
    if b == 0.0 { f64::NAN } else { a / b }
}

/// `x` to the `y`, small whole powers by multiplication.
#[inline(never)]
pub(super) fn power(x: f64, y: f64) -> f64 {
    if y.abs() > 16.0 || y != y.trunc() {
        return x.powf(y);
    }
    let (mut factor, mut product) = (x, 1.0);
    let mut n = y.abs() as u32;
    while n > 0 {
        if n & 1 == 1 {
            product *= factor;
        }
        factor *= factor;
        n >>= 1;
    }
    if y < 0.0 { 1.0 / product } else { product }
}

/// The value that a rounded index picks: the nearest whole number.
#[inline]
pub(super) fn nearest(index: f64) -> i64 {
    (index + 0.5).floor() as i64
}

/// The error function near zero, by its power series (Abramowitz and Stegun 1964, equation 7.1.6); beyond, what its complement leaves.
fn erf(x: f64) -> f64 {
    if !(x.abs() < NEAR_ZERO) {
        return 1.0 - erfc(x);
    }
    let (mut term, mut sum, mut n) = (x, x, 1.0);
    while term.abs() > 1e-18 * sum.abs() {
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        sum += term;
        n += 1.0;
    }
    FRAC_2_SQRT_PI * (-x * x).exp() * sum
}

/// The complementary error function: what the other leaves near zero, its continued fraction beyond (the same, equation 7.1.14).
fn erfc(x: f64) -> f64 {
    if x.is_nan() {
        return x;
    }
    if x.abs() < NEAR_ZERO {
        return 1.0 - erf(x);
    }
    let tail = (1..=60).rev().fold(x.abs(), |below, n| x.abs() + 0.5 * f64::from(n) / below);
    let tail = (-x * x).exp() * 0.5 * FRAC_2_SQRT_PI / tail;
    if x > 0.0 { tail } else { 2.0 - tail }
}

/// Where the power series is as good as the continued fraction.
const NEAR_ZERO: f64 = 2.5;

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun 1964, table 7.1, and rtrace (a brightfunc of erfc(5), erf(-3.3) on a glow, Radiance 6.0a).
    #[test]
    fn error_functions() {
        assert!((Unary::Erf.apply(0.5) - 0.5204998778).abs() < 1e-10);
        // 2 x / sqrt π near zero (the same, 7.1.5).
        assert!((Unary::Erf.apply(1e-17) / 1.1283791671e-17 - 1.0).abs() < 1e-10);
        assert!((Unary::Erf.apply(2.0) - 0.9953222650).abs() < 1e-10);
        assert!((Unary::Erfc.apply(5.0) / 1.537460e-12 - 1.0).abs() < 1e-6);
        assert!((Unary::Erf.apply(-3.3) + 9.999970e-01).abs() < 1e-6);
        assert!((Unary::Erfc.apply(-0.7) - 1.677801).abs() < 1e-6);
        assert!((erfc(2.5 - 1e-12) / erfc(2.5 + 1e-12) - 1.0).abs() < 1e-10);
    }

    #[test]
    fn whole_powers_agree_with_powf() {
        for (x, y) in [(1.7, 10.0), (1.7, -10.0), (-0.3, 3.0), (0.0, 0.0), (2.0, -1.0)] {
            assert!((power(x, y) - f64::powf(x, y)).abs() <= 1e-14 * f64::powf(x, y).abs());
        }
        assert!(power(-8.0, 1.0 / 3.0).is_nan());
    }
}
