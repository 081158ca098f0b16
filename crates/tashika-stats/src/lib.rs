//! Statistics of [tashika](https://github.com/tashika-render/tashika), a many-light renderer,
//! usable alone: intervals and certificates for means of strata, distributions over tables, running
//! moments, quantiles, intervals of shares, audits of pictures.
//!
//! Users of the renderer find these as `tashika::stats`.
//!
//! # An interval from strata
//! How large is `∫ x² dx` over `[0, 1)`? Cut it into ten strata, draw a few numbers in each, and
//! estimate the error of their sum from the spread inside the strata. The certificate assumes only
//! that no sample is below zero or above the `upper` of its stratum; the calibrated interval is an
//! estimate.
//!
//! ```
//! use tashika_math::rng::{Purpose, Stream};
//! use tashika_stats::Moments;
//! use tashika_stats::stratified::{Spread, Stratum};
//!
//! let mut random = Stream::new(1, Purpose::Test, 0);
//! let (mut sum, mut strata) = (0.0, Vec::new());
//! for k in 0..10 {
//!     let mut moments = Moments::default();
//!     for _ in 0..200 {
//!         let x = (f64::from(k) + random.uniform_f64()) / 10.0;
//!         // Its share of the sum: a tenth of all is in each stratum.
//!         moments.push(0.1 * x * x);
//!     }
//!     let upper = 0.1 * (f64::from(k + 1) / 10.0).powi(2);
//!     sum += moments.mean();
//!     strata.push(Stratum {
//!         samples: 200,
//!         upper,
//!         variance: moments.variance(),
//!         // Nothing was foreseen but the bound.
//!         importance_range: upper,
//!         importance_variance: 0.0,
//!     });
//! }
//! let spread = Spread::of(strata);
//! let (likely, certain) = (spread.calibrated(0.95), spread.certified(0.05));
//! assert!((sum - 1.0 / 3.0).abs() <= likely && likely < 0.003 && certain < 0.03);
//! ```
#![forbid(unsafe_code)]

// Makes `crate::math` and `crate::rng` valid paths, as in the other crates.
use tashika_math::math;
#[cfg(test)]
use tashika_math::rng;

mod adaptive;
mod audit;
mod binomial;
mod discrete;
mod moments;
pub mod stratified;
mod student_t;

pub use adaptive::{AdaptiveDensity, Weighted};
pub use audit::{rank_of_all, tolerance_rank, upper_share_outside, upper_share_outside_of_all};
pub use binomial::{Interval, clopper_pearson};
pub use discrete::{Block, Discrete, Piecewise2d};
pub use moments::Moments;
pub use student_t::{normal_quantile, student_t_two_sided};
