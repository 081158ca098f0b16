//! LDR-FLIP: how different two pictures look when one flips between them.
//!
//! Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images". At each pixel
//!
//! ```text
//! FLIP = ΔE_c ^ (1 − ΔE_f)                                0 to 1
//! ```
//!
//! of the difference in colour `ΔE_c` (module `color`), where what is too fine to be seen from the
//! given distance is blurred before, and the difference in features `ΔE_f`, of edges and points
//! that one picture has and the other has not (`features`). Distances are of the visual field: `p`
//! pixels per degree. Beyond its edges a picture goes on as it ends.
//!
//! # Differences from the source
//! None that are known; where the text leaves it open (the square that filters are cut off at, what
//! is beyond the edges), as the authors' program does. Double precision instead of single.
//!
//! # Held to this by
//! `tests::flip_is_that_of_its_authors`.

mod color;
mod features;

use super::Pictures;
use crate::math::elementary::powf_f64;

/// The map, in rows.
pub(super) fn map(pictures: &Pictures, pixels_per_degree: f64) -> Vec<f64> {
    let colors = color::differences(pictures, pixels_per_degree);
    let features = features::differences(pictures, pixels_per_degree);
    colors.with(&features, |color, feature| powf_f64(color, 1.0 - feature)).values
}
