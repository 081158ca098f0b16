//! A picture in shares of its tiles, on any number of machines, audited when they are joined.
//!
//! ```text
//! share: each tile ── passes until foreseen to be good ─► halves, truths of its audit pixels ─► part
//! parts ── merge ─► halves of the whole ── reconstruction ─► picture ── one look ─► PictureClaim
//! ```
//!
//! What becomes of a tile follows from the tile, the view, the lights and the seed, so that any number
//! of shares is joined to the same bits. Each is made in passes as a picture of its own and stops by
//! itself, where few of its pixels are foreseen to be outside ([`SPARE`]) or its work is done. So the
//! joined picture is another one than the whole that one machine makes, whose passes send work from
//! easy tiles to hard ones: about as good, by other samples.
//!
//! A part claims nothing, since a share of a share is no share. Its film has what merging needs
//! ([`planes::HALVES`], [`planes::TRUTH`]); merging needs neither the scene nor its lights.
//!
//! # Which pixels are audited
//! The first of a random order of all pixels of the window ([`draw`]), but for those that show a
//! constant background. That is a simple random sample of the others, given their number: the order
//! knows nothing of the picture. How many come first is fixed before any tile ([`count`]), by pixels
//! of which nothing else is used. Merging draws them once more, from the seed, and refuses films
//! that have truths of other pixels.
//!
//! # Guarantee
//! That of the [whole](super), with all the risk for the one look there is. The film says which
//! denoiser that look is at.
//!
//! # Held to this by
//! `parts::tests`, which move a truth, forget one and take truths from the picture; the program's
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
