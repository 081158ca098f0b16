//! Distributions over tables, running moments, quantiles, intervals of shares.

mod adaptive;
mod binomial;
mod discrete;
mod moments;
pub mod stratified;
mod student_t;

pub use adaptive::{AdaptiveDensity, Weighted};
pub use binomial::{Interval, clopper_pearson};
pub use discrete::{Block, Discrete, Piecewise2d};
pub use moments::Moments;
pub use student_t::{normal_quantile, student_t_two_sided};
