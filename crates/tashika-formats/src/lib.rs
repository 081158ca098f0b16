//! Files of [tashika](https://github.com/tashika-render/tashika), a many-light renderer: scenes from
//! pbrt, Mitsuba, glTF, USD and Wavefront OBJ, films to and from OpenEXR, pictures to PNG.
//!
//! All is in [`io`]; users of the renderer find it as `tashika::io`, together with the files of
//! lights.
#![forbid(unsafe_code)]

pub mod io;

// Modules of the crates below, so that `crate::math` is the same wherever code stands.
use tashika_film::{color, error, film, reconstruction};
use tashika_math::math;
#[cfg(test)]
use tashika_math::{rng, warp};
use tashika_scene::{bsdf, scene};
