//! Guidance: what is learned about a picture before any estimate is made, and where it sends work.
//!
//! * [`learn_light_guide`]: which emission reaches what the camera sees.
//!
//! # Independence
//! What guides is learned from random numbers of its own ([`Purpose::Guidance`](crate::rng::Purpose::Guidance)),
//! which no estimate uses: estimates are unbiased whatever was learned.

mod emission;

pub use emission::{Guided, learn_light_guide};
