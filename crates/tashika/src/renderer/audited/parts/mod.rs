//! A picture whose tiles are shared among any number of machines, and which is audited when the
//! shares are joined.
//!
//! ```text
//! share: each tile ── passes until foreseen to be good ─► halves, truths of its audit pixels ─► part
//! parts ── merge ─► halves of the whole ── reconstruction ─► picture ── one look ─► PictureClaim
//! ```
//!
//! The result of a tile is a function of the tile, the view, the lights and the seed. Any division
//! into shares is therefore joined to the same bits. Each tile is rendered in passes, like a
//! separate picture. It stops when few of its pixels are predicted to be outside
//! ([`MAX_TILE_OUTSIDE`]), or when its limit of paths is reached. On one machine, by contrast,
//! passes move work from easy tiles to hard ones. The joined picture therefore has other samples
//! than a picture rendered on one machine, at about the same quality.
//!
//! A part claims nothing, since the claim is about a share of all pixels. Its film has the planes
//! that merging needs ([`planes::HALVES`], [`planes::TRUTH`]); merging needs neither the scene nor
//! its lights.
//!
//! # Which pixels are audited
//! The first pixels of a random order of all pixels of the window ([`draw`]), except for those that
//! show a constant background. The order does not depend on the picture. Given their number, the
//! audited pixels are therefore a simple random sample of all pixels that show more than a constant
//! background. The length of the draw is fixed before any tile is rendered ([`count`]), from pilot
//! pixels that are used for nothing else. Merging repeats the draw from the seed, and refuses films
//! with truths of other pixels.
//!
//! # Guarantee
//! The guarantee of a picture rendered as a [whole](super); the single analysis has all of the
//! risk. The film names the denoiser of the analysed picture.
//!
//! # Held to this by
//! `parts::tests`, which change a truth, remove one and take truths from the picture; the program's
//! `audited_parts_are_merged_to_the_same_bytes`.

mod draw;
mod merged;
mod share;

#[cfg(test)]
mod tests;

pub use merged::finish_merged;
pub(super) use share::render;

#[cfg(doc)]
use crate::film::planes;
#[cfg(doc)]
use draw::{count, draw};
#[cfg(doc)]
use share::MAX_TILE_OUTSIDE;
