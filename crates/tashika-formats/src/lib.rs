//! Files of [tashika](https://github.com/tashika-render/tashika), a many-light renderer: scenes from
//! pbrt, Mitsuba, glTF, USD, Wavefront OBJ and Radiance, films to and from OpenEXR, pictures to
//! PNG.
//!
//! Everything is in [`io`], which users of the renderer see as `tashika::io`, together with the
//! files of VPL sets.
#![forbid(unsafe_code)]

pub mod io;

// Modules of the lower crates, so that paths such as `crate::math` are valid in every crate.
use tashika_film::{color, error, film};
use tashika_math::math;
#[cfg(test)]
use tashika_math::{rng, warp};
use tashika_scene::{bsdf, scene};
