//! recover
pub mod fit;
pub mod gram;
pub mod model;
