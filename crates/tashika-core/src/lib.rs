//! The many-light renderer of [tashika](https://github.com/tashika-render/tashika), which turns a
//! scene and a request into a film.
//!
//! [`request`] describes the work. [`render`] performs it tile by tile, by means of an
//! [`integrator`]. The other modules are parts of these. The crate `tashika` re-exports all
//! modules, and adds the pipeline `tashika::Renderer` that connects them.
#![forbid(unsafe_code)]

pub mod accel;
pub mod bounds;
pub mod compensation;
pub mod contribution;
pub mod cut;
pub mod gather;
pub mod guidance;
pub mod integrator;
pub mod media;
pub mod picture;
pub mod render;
pub mod request;
pub mod tree;
pub mod vpl;

// Modules of the crates below, so that `crate::math` is a valid path in every crate.
use tashika_film::{color, error, film, reconstruction};
use tashika_math::{math, rng, warp};
use tashika_scene::{bsdf, scene};
use tashika_stats as stats;
