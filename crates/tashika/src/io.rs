//! Files in and out: the only place that touches the file system.
//!
//! Scenes, films and pictures are those of the crate `tashika-formats`; files of VPLs and of
//! finished tiles, which need the renderer, are added here.

mod kept_tiles;
mod vpl_set;

pub use kept_tiles::KeptTiles;
pub use tashika_formats::io::*;
pub use vpl_set::{load_vpls, save_vpls};
