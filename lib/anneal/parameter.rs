//! One coordinate of the vector.

use serde::{Deserialize, Serialize};

/// One coordinate of the vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// What messages call it.
    pub name: String,
    /// Where the search starts.
    pub start: f64,
    /// Smallest value that is ever proposed.
    pub low: f64,
    /// Largest value that is ever proposed.
    pub high: f64,
}

impl Parameter {
    /// How far its bounds are apart.
    pub fn range(&self) -> f64 {
        self.high - self.low
    }

    /// The standard error of its value when nothing but its bounds is known.
    pub fn anywhere(&self) -> f64 {
        anywhere((self.low, self.high))
    }

    /// 0 at the lower bound, 1 at the upper.
    pub(super) fn unit(&self, value: f64) -> f64 {
        (value - self.low) / self.range()
    }

    /// The value at `unit`, rounded to a decimal number: the range has ten to a hundred million of them.
    pub(super) fn value(&self, unit: f64) -> f64 {
        let scale = 10f64.powi(7 - self.range().log10().floor() as i32);
        let value = self.low + unit * self.range();
        let rounded = (value * scale).round() / scale;
        if rounded.is_finite() { rounded.clamp(self.low, self.high) } else { value.clamp(self.low, self.high) }
    }
}

/// The standard deviation of what may be anywhere between two bounds.
pub fn anywhere((low, high): (f64, f64)) -> f64 {
    (high - low) / 12f64.sqrt()
}
