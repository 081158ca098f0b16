//! A picture in shares of its tiles, on any number of machines, audited when they are joined.
//!
//! ```text
//! share: each tile ── passes until foreseen to be good ─► halves, truths of its audit pixels ─► part
//! parts ── merge ─► halves of the whole ── reconstruction ─► picture ── one look ─► PictureClaim
//! ```
//!
//! The result of a tile is a function of the tile, the view, the lights and the seed, so that any
//! number of shares is joined to the same bits. Each tile is made in passes as a picture of its
//! own. It stops when few of its pixels are predicted to be outside ([`SPARE`]) or its work is
//! done. So the joined picture differs from that of one machine, whose passes send work from easy
//! tiles to hard ones: its quality is about the same, its samples differ.
//!
//! A part claims nothing, since the claim is about a share of all pixels. Its film has the planes
//! that merging needs ([`planes::HALVES`], [`planes::TRUTH`]); merging needs neither the scene nor
//! its lights.
//!
//! # Which pixels are audited
//! The first pixels of a random order of all pixels of the window ([`draw`]), except for those that
//! show a constant background. Given their number, these are a simple random sample of the others:
//! the order does not depend on the picture. The length of the draw is fixed before any tile
//! ([`count`]), from pixels that have no other use. Merging repeats the draw from the seed, and
//! refuses films with truths of other pixels.
//!
//! # Guarantee
//! That of the [whole](super), with all the risk for the single analysis. The film names the
//! denoiser of the analysed picture.
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
use share::SPARE;
