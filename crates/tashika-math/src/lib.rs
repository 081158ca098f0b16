//! Geometry, random numbers and the elementary functions of
//! [tashika](https://github.com/tashika-render/tashika), a many-light renderer: the same bits on
//! every machine and any number of threads.
//!
//! * [`math`]: boxes, cones, frames and rays, elementary functions, what rounding can do, and
//!   formulas for one number or for vectors.
//! * [`rng`]: streams of random numbers, keyed by what they are for.
//! * [`warp`]: uniform squares to disks, spheres, triangles.
//!
//! Users of the renderer find these as `tashika::math`, `tashika::rng` and `tashika::warp`.
#![deny(unsafe_code)]

pub mod math;
pub mod rng;
pub mod warp;
