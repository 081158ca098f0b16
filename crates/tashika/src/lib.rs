//! # tashika: a many-light renderer that knows its own error
//!
//! Layers, from the bottom; a module uses only those above it in this list (kept by the test
//! `tidy`).
//!
//! | layer | modules |
//! |---|---|
//! | 0 | [`math`], [`color`], [`rng`], [`warp`], [`stats`], [`error`] |
//! | 1 | [`bsdf`], [`film`] |
//! | 2 | [`scene`], [`accel`] |
//! | 3 | [`vpl`], [`gather`], [`transport`] |
//! | 4 | [`bounds`], [`guidance`] |
//! | 5 | [`tree`] |
//! | 6 | [`cut`], [`uncarried`] |
//! | 7 | [`integrator`] |
//! | 8 | [`reconstruction`], [`render`], [`report`], [`request`] |
//! | 9 | [`experiment`], [`io`] |
#![deny(unsafe_code)]

pub mod accel;
pub mod bounds;
pub mod bsdf;
pub mod color;
pub mod cut;
pub mod error;
pub mod experiment;
pub mod film;
pub mod gather;
pub mod guidance;
pub mod integrator;
pub mod io;
pub mod math;
pub mod reconstruction;
pub mod render;
pub mod report;
pub mod request;
pub mod rng;
pub mod scene;
pub mod stats;
pub mod transport;
pub mod tree;
pub mod uncarried;
pub mod vpl;
pub mod warp;

/// The example of the README, compiled and run as a test of the documentation.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
pub struct Readme;
