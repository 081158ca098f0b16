//! The many-light renderer of [tashika](https://github.com/tashika-render/tashika): from a scene and
//! a request to a film.
//!
//! [`request`] describes the work, [`render`] does it tile by tile with an [`integrator`]; the
//! other modules are their parts. The crate `tashika` re-exports them all, and adds the pipeline
//! `tashika::Renderer` that joins them.
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

// Modules of the crates below, so that `crate::math` is the same wherever code stands.
use tashika_film::{color, error, film, reconstruction};
use tashika_math::{math, rng, warp};
use tashika_scene::{bsdf, scene};
use tashika_stats as stats;
