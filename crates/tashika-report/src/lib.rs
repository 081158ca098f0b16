//! How far a film is from a reference: numbers, a picture of the error, a page.
//!
//! [`compare()`] measures; everything else shows what it measured. Nothing here touches files: pictures and pages are bytes, which the
//! caller writes.

mod claims;
mod color_scale;
mod compare;
mod error_budget;
mod error_image;
mod intervals;
mod page;
mod picks;
mod picture;
mod srgb_png;
mod summary;
mod words;

pub use claims::Claims;
pub use compare::{Comparison, Named, Tolerance, compare};
pub use error_budget::{ErrorBudget, error_budget};
pub use error_image::{error_image, half_width_image};
pub use intervals::Intervals;
pub use page::{
    Images, Measured, Page, Plot, Provenance, RenderFacts, Sheet, Shown, compare_page, headline, render_page,
};
pub use picks::least_certain;
pub use picture::Picture;
pub(crate) use srgb_png::srgb_png;
pub use summary::summary;
pub use words::{
    about_light_not_found, about_truth, count, percent_of_error, percent_of_share, percent_of_tolerance,
};

#[cfg(test)]
mod tests;
