//! Inverad tells what material an object is made of, from one high-dynamic-range picture of it.
//!
//! ```text
//! text ──rad──▶ Document ──scene──▶ Scene ──world──▶ World ──render──▶ Picture ──picture──▶ bytes
//!                  ▲                                   │                  │
//!   edited words ──┘                                   └─ transport ─▶ basis ─┴─ metric ─▶ χ² ─▶ anneal
//! ```
//!
//! Data flows one way. A room uses only rooms that stand above it here.

pub mod anneal;
pub mod args;
pub mod cal;
pub mod cli;
pub mod color;
pub mod error;
pub mod expand;
pub mod metric;
pub mod picture;
pub mod rad;
pub mod resolve;
pub mod transform;
pub mod unknown;
pub mod vector;
pub mod view;
