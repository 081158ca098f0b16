//! LDR-FLIP: perceived difference of two pictures when flipping between them.
//!
//! Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images". At each pixel
//!
//! ```text
//! FLIP = ΔE_c ^ (1 − ΔE_f)                                0 to 1
//! ```
//!
//! of the difference in colour `ΔE_c` (module `color`), after blurring details that are too fine to
//! be seen from the given distance, and the difference in features `ΔE_f`, of edges and points that
//! only one picture has (`features`). Distances are in the visual field, with `p` pixels per
//! degree. Beyond its edges a picture continues with its edge pixels.
//!
//! # Differences from the source
//! None that are known. Where the text leaves a choice (the square that filters are cut off at,
//! pixels beyond the edges), the choice is that of the authors' program. Double precision is used
//! instead of single.
//!
//! # Held to this by
//! `tests::flip_is_that_of_its_authors`.

mod color;
mod features;

use super::Pictures;
use crate::math::elementary::powf_f64;

/// Map of FLIP, in rows.
pub(super) fn map(pictures: &Pictures, pixels_per_degree: f64) -> Vec<f64> {
    let colors = color::differences(pictures, pixels_per_degree);
    let features = features::differences(pictures, pixels_per_degree);
    colors.with(&features, |color, feature| powf_f64(color, 1.0 - feature)).values
}
