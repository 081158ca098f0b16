//! The image viewer tev (<https://github.com/Tom94/tev>), which shows an image while it is
//! rendered.
//!
//! [`packet`] writes packets as bytes; [`viewer`] sends them over a connection.

mod packet;
mod viewer;

pub use viewer::{DEFAULT_ADDRESS, Viewer};
