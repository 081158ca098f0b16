//! Scenes of [tashika](https://github.com/tashika-render/tashika), a many-light renderer.
//!
//! * [`bsdf`]: reflection and transmission of surfaces: evaluation, sampling, density.
//! * [`scene`]: meshes, materials, textures, emitters, skies, cameras; built by a
//!   [`SceneBuilder`](scene::SceneBuilder), or built in.
//!
//! Users of the renderer find these under `tashika`, by the same names.
#![forbid(unsafe_code)]

pub mod bsdf;
pub mod scene;

// Makes paths such as `crate::math` valid here, as in the other crates.
use tashika_film::{color, error, film};
use tashika_math::{math, rng, warp};
use tashika_stats as stats;
