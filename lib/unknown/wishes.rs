//! What a person says of the unknown: bounds, and what is fixed, tied or moves together.

use super::EXPOSURES;
use crate::error::{Error, Result};
use crate::rad::real;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// What the user said of the unknown; what was not said follows from the material's type.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wishes {
    /// The identifier of the unknown material; needed when the file has several.
    pub material: Option<String>,
    /// Start and bounds of parameters.
    pub bounds: Vec<Bounds>,
    /// Parameters that keep the value they start with.
    pub fixed: Vec<String>,
    /// Parameters that share one value, which starts as the first of them does.
    pub tied: Vec<Vec<String>>,
    /// Groups of parameters that move together. `rgb` is short for the three colours; those not named are one more group.
    pub groups: Vec<Vec<String>>,
}

/// Start and bounds of one parameter: `NAME=START:LOW:HIGH`. Without a start, the one in the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// `red`, `rough`, `a5`…
    pub name: String,
    /// Where the search starts.
    pub start: Option<f64>,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

/// Beyond, squares of radiance leave what numbers can hold.
const FARTHEST: f64 = 1e9;

impl FromStr for Bounds {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |what: &str| {
            Error::new(format!("{what}; write NAME=START:LOW:HIGH, as in rough=.1:0:.3, or rough=:0:.3 to start as the file does"))
        };
        let (name, numbers) = text.split_once('=').ok_or_else(|| wrong("no `=`"))?;
        let numbers: Vec<&str> = numbers.split(':').map(str::trim).collect();
        let [start, low, high] = numbers[..] else { return Err(wrong("not three numbers")) };
        let number = |word: &str| real(word).ok_or_else(|| wrong(&format!("`{word}` is not a number")));
        let start = if start.is_empty() { None } else { Some(number(start)?) };
        let (low, high) = (number(low)?, number(high)?);
        if low >= high {
            return Err(wrong("the upper bound must be greater than the lower one"));
        }
        if low.abs().max(high.abs()) > FARTHEST {
            return Err(wrong(&format!("no bound is farther from 0 than {FARTHEST:e}")));
        }
        if low <= 0.0 && EXPOSURES.contains(&name.trim()) {
            return Err(wrong("an exposure is a factor: its bounds must be greater than 0"));
        }
        if start.is_some_and(|s| !(low..=high).contains(&s)) {
            return Err(wrong("the start is outside the bounds"));
        }
        Ok(Self { name: name.trim().into(), start, low, high })
    }
}

/// Names separated by `separator`: `red=green=blue`, `spec,rough`.
pub fn names(text: &str, separator: char) -> Vec<String> {
    text.split(separator).map(str::trim).filter(|name| !name.is_empty()).map(String::from).collect()
}
