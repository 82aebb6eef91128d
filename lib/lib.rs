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
pub mod accel;
pub mod args;
pub mod cal;
pub mod cli;
pub mod color;
pub mod error;
pub mod expand;
pub mod pattern;
pub mod geometry;
pub mod picture;
pub mod rad;
pub mod metric;
pub mod resolve;
pub mod transform;
pub mod unknown;
pub mod vector;
pub mod sampling;
pub mod bsdf;
pub mod rules;
pub mod environment;
pub mod accel;
pub mod geometry;
pub mod integrator;
pub mod light;
pub mod material;
pub mod render;
pub mod scene;
pub mod world;
pub mod import;
pub mod transport;
pub mod recover;
pub mod view;
