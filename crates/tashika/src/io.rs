//! Files in and out: the only place that touches the file system.
//!
//! Scenes, films and pictures are those of the crate `tashika-formats`; files of what only a
//! renderer knows, its lights and its finished tiles, are added here.

mod kept_tiles;
mod vpl_set;

pub use kept_tiles::KeptTiles;
pub use tashika_formats::io::*;
pub use vpl_set::{load_vpls, save_vpls};
