//! Geometry, random numbers and the elementary functions of
//! [tashika](https://github.com/tashika-render/tashika), a many-light renderer: the same bits on
//! every machine and any number of threads.
//!
//! * [`math`]: boxes, cones, frames and rays, elementary functions, bounds of rounding errors, and
//!   arithmetic for formulas that take one number or a vector of several.
//! * [`rng`]: streams of random numbers, keyed by their purpose.
//! * [`warp`]: maps from uniform squares to disks, spheres, triangles.
//!
//! Users of the renderer find these as `tashika::math`, `tashika::rng` and `tashika::warp`.
#![deny(unsafe_code)]

pub mod math;
pub mod rng;
pub mod warp;
