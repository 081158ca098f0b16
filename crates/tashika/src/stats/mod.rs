//! Distributions over tables, running moments, quantiles.

mod discrete;
mod moments;
mod student_t;

pub use discrete::{Discrete, Piecewise2d};
pub use moments::Moments;
pub use student_t::{normal_quantile, student_t_two_sided};
