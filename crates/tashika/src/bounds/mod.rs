//! Upper bounds of what clusters of lights give to clusters of gather points.

mod light;

pub use light::{LightBounds, LightShape};
