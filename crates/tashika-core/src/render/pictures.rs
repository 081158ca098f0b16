//! Shares of a picture that is made in passes, in which each tile is a separate picture.
//!
//! The tiles are 32 pixels wide and high, however expensive a pixel is. The error of each tile is
//! predicted from its own pixels, of which there must be enough.

use std::sync::atomic::AtomicBool;

use super::fill::fill;
use super::{Begun, Finished, RenderOptions, Rendered, begin};
use crate::error::Result;
use crate::film::{Film, PlaneSpec, SampleKind, Samples, Window};
use crate::integrator::{Integrator, Setting};

/// Number of points a pixel for which tiles have their largest size.
const FEW_POINTS: u32 = 1;

/// Returns the tiles of the shares, row by row.
pub fn picture_tiles(options: &RenderOptions) -> Vec<Window> {
    options.share.tiles(&options.window, FEW_POINTS)
}

/// Returns the film with which pictures begin: as [`blank`](super::blank), with the planes `more`
/// in addition.
///
/// # Errors
/// As [`blank`](super::blank).
pub fn begin_pictures(
    setting: &Setting<'_>,
    integrator: &dyn Integrator,
    options: &RenderOptions,
    more: &[PlaneSpec],
) -> Result<Film> {
    let mut film = begin(setting, integrator, options, FEW_POINTS)?;
    for spec in more {
        let count = film.window().area() as usize * spec.channels.len();
        let samples = match spec.kind {
            SampleKind::F32 => Samples::F32(vec![0.0; count]),
            SampleKind::U32 => Samples::U32(vec![0; count]),
        };
        film.add_plane(spec, samples);
    }
    Ok(film)
}

/// Makes the tiles that are not finished; `watch` and `cancel` are as in
/// [`render`](super::render()).
///
/// * `work`: returns the film of a tile; `None` if it was cancelled.
///
/// # Panics
/// If a tile's film has other planes than the film of the render, or lacks pixels of the tile.
pub fn resume_pictures(
    begun: Begun,
    tiles: &[Window],
    work: &(dyn Fn(&Window) -> Option<Film> + Sync),
    watch: &(dyn Fn(&Finished<'_>) + Sync),
    cancel: &AtomicBool,
) -> Rendered {
    let store = |film: &mut Film, tile: &Window, of_tile: &Film| {
        for y in tile.y..tile.y + tile.height {
            film.copy_pixels([tile.x, y], of_tile, [tile.x, y], tile.width);
        }
    };
    fill(begun, tiles, work, &store, watch, cancel)
}
