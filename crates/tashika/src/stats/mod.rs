//! Distributions over tables.

mod discrete;
mod moments;

pub use discrete::{Discrete, Piecewise2d};
pub use moments::Moments;
