//! Inverad tells what material an object is made of, from one high-dynamic-range picture of it.
//!
//! ```text
//! text ──rad──▶ Document ──scene──▶ Scene ──world──▶ World ──render──▶ Picture ──picture──▶ bytes
//!                  ▲                                   │                  │
//!   edited words ──┘                                   └─ transport ─▶ basis ─┴─ metric ─▶ χ² ─▶ anneal
//! ```
//!
//! Data flows one way: each stage takes the finished product of the one before and knows nothing of the one after. A room of
//! this house names only rooms that stand above it here, and a third-party crate only if it is at home there; `tests/tidy.rs`
//! keeps both.
//!
//! | room | its one question | crates at home |
//! |---|---|---|
//! | [`error`] | what went wrong, and where: file, line, column, caret | |
//! | [`vector`] | points, directions, bases, affine maps | glam, wide |
//! | [`color`] | what a radiance is | |
//! | [`resolve`] | who reads a file or runs a command for the library | |
//! | [`rad`] | the `.rad` syntax, lossless: statements of words that keep what stands between them | nom, serde, serde_json |
//! | [`transform`] | what `xform` options do to points | |
//! | [`cal`] | the `.cal` language: text, expression, number | nom |
//! | [`sampling`] | low-discrepancy numbers, warps and their densities, tables, weights | |
//! | [`geometry`] | rays; surfaces: where a ray meets them, their bounds, area, light | |
//! | [`picture`] | pixels and their trail; bytes to pixels and back | exr, png |
//! | [`rules`] | what RADIANCE's options say about light | |
//! | [`view`] | a RADIANCE view, and the rays through its picture | |
//! | [`pattern`] | patterns, textures, mixtures at a hit | |
//! | [`material`] | what a material is: its type and numbers | |
//! | [`panorama`] | what a whole environment does to a surface | rayon, wide |
//! | [`environment`] | where distant light comes from, and how to sample it | rayon |
//! | [`metric`] | how far two pictures are apart: χ² (equation 11) and its kin | serde |
//! | [`anneal`] | simulated annealing of a vector; knows no graphics | rand, serde |
//! | [`unknown`] | which numbers of a file are unknown, and the file with those numbers in place | serde |
//! | [`expand`] | inline commands (`xform`, `genbox` …) done in-process; the gate for all others | |
//! | [`support`] | which primitive types are rendered | |
//! | [`inventory`] | what a scene holds, and what rendering it takes | |
//! | [`import`] | `.rtm`, `.oct`, `.obj`: triangles and documents | |
//! | [`scene`] | Document to Scene: modifiers, aliases, types, patterns resolved | |
//! | [`check`] | all that is wrong with a scene, in one go | |
//! | [`bsdf`] | what a material does at a point: value, sample, density | |
//! | [`light`] | what lights a point directly | |
//! | [`accel`] | which surface a ray meets first: an eight-wide hierarchy | bytemuck, memmap2, obvhs, rayon, wide, yoke |
//! | [`world`] | Scene to World: ready for rays, specialised to what the scene contains | |
//! | [`integrator`] | the radiance along one ray | |
//! | [`render`] | all pixels: seeds, threads, sample budget, error estimate | rayon |
//! | [`rays`] | what is asked and said of single rays, as `rtrace` reads and writes it | rayon |
//! | [`transport`] | the basis: the picture as a function of one unknown material | rayon, wide |
//! | [`recover`] | target, unknown and bounds to values and their standard errors | rayon, serde |
//! | [`report`] | a recovery as one page to look at | serde |
//! | [`args`] | what was typed | clap, clap_complete, clap_mangen |
//! | [`cli`] | the outside: files, commands, progress, exit status | clap, rayon, serde, serde_json, signal_hook, tempfile |

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
pub mod panorama;
pub mod pattern;
pub mod picture;
pub mod rad;
pub mod rays;
pub mod recover;
pub mod render;
pub mod report;
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
