//! Films of [tashika](https://github.com/tashika-render/tashika), a many-light renderer: planes of
//! samples with units, claims of pixels, and a reconstruction for viewing.
//!
//! * [`color`]: linear Rec. 709, spectra, metals.
//! * [`error`]: the error type of all crates, and the place in a file that a message begins with.
//! * [`film`]: planes, metadata, and the records of a rendered film.
//! * [`reconstruction`]: each pixel as a mean of similar pixels.
//!
//! Users of the renderer find these under `tashika`, by the same names.
#![forbid(unsafe_code)]

pub mod color;
pub mod error;
pub mod film;
pub mod reconstruction;

// Imports from lower crates, so that paths such as `crate::math` are the same in every crate.
use tashika_math::math;
#[cfg(test)]
use tashika_math::rng;
