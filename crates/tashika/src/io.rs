//! Files in and out: the only place that touches the file system.
//!
//! The crate `tashika-formats` reads and writes scenes, films and pictures. This module adds files
//! of VPLs and of finished tiles, which need the renderer.

mod kept_tiles;
mod vpl_set;

pub use kept_tiles::KeptTiles;
pub use tashika_formats::io::*;
pub use vpl_set::{load_vpls, save_vpls};
