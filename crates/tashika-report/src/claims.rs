//! What a film claims of its own error, judged by a reference.
//!
//! A film claims where its plane `half_width` holds the half-width `h` of an interval around the
//! luminance (W·m⁻²·sr⁻¹) and its plane `claim` is not 0; without a plane `claim` every half-width
//! is a claim. A claim is kept if the reference is inside:
//!
//! ```text
//! |L − L_r| ≤ h + 2⁻²³ (|L_r| + |L − L_r|)
//! ```
//!
//! where the second term is what storing the colours in single precision may have moved them.
//!
//! Claims are about the sum over the film's own VPLs and gather points. Where the reference is
//! another sum, or light transport itself, the difference between the two truths is judged with
//! them; [`Claims::same_truth`] says whether the films' metadata name the same sum.
//!
//! # Assumption
//! The interval of the share takes pixels for independent trials. Pixels of one image share their
//! VPLs, so that it is narrower than the variation from render to render; and a reference that is
//! itself noisy breaks claims that hold.

use crate::film::keys::{self, About};
use crate::film::{Film, Metadata, RenderFilm, Value};
use crate::stats::{Interval, clopper_pearson};

/// How many claims were kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Claims {
    /// Claims that were kept.
    pub kept: u64,
    /// Claims, of pixels that have an error.
    pub of: u64,
    /// Clopper–Pearson interval of the share kept, at [`Claims::CONFIDENCE`].
    pub interval: Interval,
    /// Whether the reference says that it is of the same scene, VPLs and gather points.
    pub same_truth: bool,
}

impl Claims {
    /// Confidence of the interval.
    pub const CONFIDENCE: f64 = 0.95;

    /// Share of the claims that were kept; none if there were no claims.
    pub fn share(&self) -> Option<f64> {
        (self.of > 0).then(|| self.kept as f64 / self.of as f64)
    }
}

/// What storing colours in single precision may have moved them, at that distance from a reference
/// of that size.
pub(super) fn rounding(distance: f64, size: f64) -> f64 {
    f64::from(f32::EPSILON) * (size + distance)
}

/// Counts the claims that are kept.
pub(super) struct Judge<'f> {
    film: RenderFilm<'f>,
    same_truth: bool,
    kept: u64,
    of: u64,
}

impl<'f> Judge<'f> {
    /// For the claims of a film by that reference; none if it has no half-widths.
    pub(super) fn of(film: &'f Film, reference: &Film) -> Option<Self> {
        let same_truth = same_truth(film, reference);
        let film = RenderFilm::of(film);
        film.has_half_widths().then_some(Self { film, same_truth, kept: 0, of: 0 })
    }

    /// Judges the pixel at that position by its distance from a reference of that size.
    pub(super) fn judge(&mut self, pixel: usize, distance: f64, size: f64) {
        let Some(half_width) = self.film.half_width(pixel) else { return };
        let allowed = f64::from(half_width) + rounding(distance, size);
        self.of += 1;
        // A half-width that is not a number keeps nothing.
        self.kept += u64::from(distance <= allowed);
    }

    /// What was found.
    pub(super) fn claims(self) -> Claims {
        let Self { same_truth, kept, of, .. } = self;
        Claims { kept, of, interval: clopper_pearson(kept, of, Claims::CONFIDENCE), same_truth }
    }
}

/// Whether two films estimate the same truth, as far as their metadata say.
pub(super) fn same_truth(film: &Film, reference: &Film) -> bool {
    truth_of(film.metadata()).eq(truth_of(reference.metadata()))
}

/// What the metadata say of the truth that a film estimates: scene, camera, and, unless it is light
/// transport, what VPLs and gather points were drawn from.
fn truth_of(metadata: &Metadata) -> impl Iterator<Item = (&str, &Value)> {
    let is_transport = metadata.text(keys::TRUTH) == Some("transport");
    metadata.iter().filter(move |(name, _)| match keys::about(name) {
        About::Truth => true,
        About::Sum => !is_transport,
        About::Making | About::Part => false,
    })
}
