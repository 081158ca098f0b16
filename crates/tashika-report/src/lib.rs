//! Comparison of a film with a reference: numbers, a picture of the error, a page.
//!
//! [`compare()`] measures; everything else presents its results. Nothing here accesses files:
//! pictures and pages are bytes, which the caller writes.

#![forbid(unsafe_code)]

mod claims;
mod color_scale;
mod compare;
mod error_budget;
mod error_image;
mod intervals;
mod isolines;
mod judged;
mod luminance_image;
mod measures;
mod own_error;
mod page;
mod pairs;
mod picks;
mod picture;
mod summary;
mod truths;

pub use claims::{Claims, Verdict};
pub use compare::{Comparison, Named, Tolerance, ToleranceFrom, compare};
pub use error_budget::{ErrorBudget, error_budget};
pub use error_image::{error_image, half_width_image};
pub use intervals::Intervals;
pub use judged::PictureJudged;
pub use luminance_image::{LuminanceScale, luminance_image};
pub use measures::Measures;
pub use page::{
    CompareFacts, Images, Measured, Page, PlanCell, Plot, Provenance, RenderFacts, Sheet, Shown,
    compare_page, headline, render_page,
};
pub use picks::least_certain;
pub use picture::Picture;
pub use summary::summary;
pub use tashika_film::film::{
    about_light_not_found, about_not_finite, about_truth, count, percent_of_error, percent_of_share,
    percent_of_tolerance, truth_in_short,
};
pub use truths::Truths;

#[cfg(test)]
mod tests;

// Imports from lower crates, so that paths such as `crate::math` are the same in every crate.
use tashika_film::{color, error, film};
use tashika_math::math;
#[cfg(test)]
use tashika_math::rng;
use tashika_stats as stats;
