//! Guidance: what is learned about a picture before any estimate is made, and where it sends work.
//!
//! * [`learn_light_guide`]: which emission reaches what the camera sees.
//! * [`BentLight`]: what comes to surfaces over mirrors and through solid glass, which neither sums
//!   nor paths may find.
//! * [`SeenLamps`]: how bright lamps that are seen make a pixel, however small they are.
//! * [`importance_correlation`]: how much more VPLs that light paths leave together vary than as
//!   many that are independent.
//! * [`Grid`]: the cells of an image, each with what was learned of its neighbourhood.
//!
//! # Independence
//! What guides is learned from random numbers of its own
//! ([`Purpose::Guidance`](crate::rng::Purpose::Guidance)), which no estimate uses: estimates are
//! unbiased whatever was learned.

mod bent;
mod correlation;
mod emission;
mod grid;
mod lamps;

pub use bent::BentLight;
pub use correlation::importance_correlation;
pub use emission::{Guided, learn_light_guide};
pub use grid::{Grid, cell_of, key_of, pixels_of, random_pixel};
pub use lamps::SeenLamps;
