//! Inverad tells what material an object is made of, from one high-dynamic-range picture of it.
//!
//! ```text
//! text ──rad──▶ Document ──scene──▶ Scene ──world──▶ World ──render──▶ Picture ──picture──▶ bytes
//!                  ▲                                   │                  │
//!   edited words ──┘                                   └─ transport ─▶ basis ─┴─ metric ─▶ χ² ─▶ anneal
//! ```
//!
//! Data flows one way. A room uses only rooms that stand above it here.

pub mod accel;
pub mod anneal;
pub mod args;
pub mod bsdf;
pub mod cal;
pub mod check;
pub mod cli;
pub mod color;
pub mod environment;
pub mod error;
pub mod expand;
pub mod geometry;
pub mod import;
pub mod integrator;
pub mod inventory;
pub mod light;
pub mod material;
pub mod metric;
pub mod pattern;
pub mod picture;
pub mod rad;
pub mod recover;
pub mod render;
pub mod resolve;
pub mod rules;
pub mod sampling;
pub mod scene;
pub mod support;
pub mod transform;
pub mod transport;
pub mod unknown;
pub mod vector;
pub mod view;
pub mod world;
