//! Error of the reference itself: a half-width around each of its pixels.
//!
//! A reference with mean `r` and standard error `s` covers the truth `T` by
//!
//! ```text
//! |r − T| ≤ q,    q = z s,    P(|Z| ≤ z) = 99.9 %
//! ```
//!
//! | information of the reference about a pixel | `q` (W·m⁻²·sr⁻¹) |
//! |---|---|
//! | it is exact | 0 |
//! | an interval of half-width `h` at confidence `c` | `h z(99.9 %) / z(c)` |
//! | a standard error `s` | `z s`; of `n` paths `t s`: Student's `t`, `n − 1` degrees of freedom |
//! | its error is not known (NaN), or it is one path | infinite |
//! | it is audited: of a single pixel nothing is known | 0: it is taken for the truth |
//! | none, as in films of other renderers | 0: it is taken for the truth |
//!
//! # Assumption
//! Errors of the reference are approximately normal. Means of many paths are, unless few paths
//! carry most of the light.
//!
//! # Held to this by
//! `own_error::tests`, and `claims::tests` on films whose truth is known.

use crate::film::{Claim, Film, Plane, PlaneSpec, RenderFilm, Samples, Window, keys, planes};
use crate::stats::{normal_quantile, student_t_two_sided};

/// Half-widths around the pixels of a reference, at [`OwnError::CONFIDENCE`].
pub(super) struct OwnError<'f> {
    film: RenderFilm<'f>,
    standard_errors: Option<&'f [f32]>,
    /// Ratio of the half-width to the standard error.
    of_standard_error: f64,
    /// Ratio of the half-width to a half-width that the film claims.
    of_half_width: f64,
}

impl<'f> OwnError<'f> {
    /// Confidence of the half-widths.
    pub const CONFIDENCE: f64 = 0.999;
    /// Assumed confidence of the intervals of a film that states none.
    const ASSUMED_CONFIDENCE: f64 = 0.95;

    /// Reads the error from a reference.
    pub fn of(reference: &'f Film) -> Self {
        let metadata = reference.metadata();
        let plane = reference.plane(planes::STANDARD_ERROR).filter(|plane| plane.channels().len() == 1);
        let is_audited = metadata.text(keys::CLAIM) == Some(Claim::Audited.code().name);
        let z = |confidence: f64| normal_quantile(0.5 + 0.5 * confidence);
        let own = z(Self::CONFIDENCE);
        let claimed = metadata.number(keys::CONFIDENCE).filter(|c| *c > 0.0 && *c < 1.0);
        let of_standard_error = match metadata.number(keys::PATHS) {
            Some(paths) if paths < 2.0 => f64::INFINITY,
            Some(paths) => student_t_two_sided(Self::CONFIDENCE, paths - 1.0),
            None => own,
        };
        Self {
            film: RenderFilm::of(reference),
            standard_errors: plane.and_then(Plane::f32_samples).filter(|_| !is_audited),
            of_standard_error,
            of_half_width: own / z(claimed.unwrap_or(Self::ASSUMED_CONFIDENCE)),
        }
    }

    /// Returns the half-width around a pixel (W·m⁻²·sr⁻¹); infinite if the error is not known.
    pub fn half_width(&self, pixel: usize) -> f64 {
        let claim = self.film.claim(pixel);
        let half_width = match (claim, self.standard_errors) {
            (Claim::Exact | Claim::Audited, _) => 0.0,
            _ if claim.states_interval() => {
                self.film.half_width(pixel).map_or(0.0, |h| f64::from(h) * self.of_half_width)
            }
            (_, Some(errors)) => f64::from(errors[pixel]) * self.of_standard_error,
            (_, None) => 0.0,
        };
        // NaN arises from zero times infinity, and stands for unknown errors.
        if half_width >= 0.0 { half_width } else { f64::INFINITY }
    }

    /// Returns true if the reference states an error above zero at some pixel; an unknown error
    /// counts as infinite.
    pub fn is_some(&self) -> bool {
        (self.standard_errors.is_some() || self.film.has_half_widths())
            && (0..self.pixels()).any(|pixel| self.half_width(pixel) > 0.0)
    }

    /// Returns all half-widths, as a plane of the given window.
    pub fn plane(&self, window: Window) -> Plane {
        let PlaneSpec { name, channels, unit, doc, .. } = planes::REFERENCE_HALF_WIDTH;
        let samples = (0..self.pixels()).map(|pixel| self.half_width(pixel) as f32).collect();
        let channels = channels.iter().map(|&channel| channel.to_owned()).collect();
        Plane::from_samples([name, unit, doc].map(str::to_owned), channels, window, Samples::F32(samples))
    }

    fn pixels(&self) -> usize {
        self.film.pixels()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PixelRecord;

    /// Value of `z(99.9 %)`, from published tables.
    const Z: f64 = 3.290_527;

    fn film(records: &[PixelRecord]) -> Film {
        let size = [records.len() as u32, 1];
        let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
        (0..).zip(records).for_each(|(x, record)| record.store(&mut film, x, 0));
        film
    }

    fn record(claim: Claim, half_width: f32, standard_error: f32) -> PixelRecord {
        PixelRecord { claim, half_width, standard_error, ..PixelRecord::default() }
    }

    #[test]
    fn each_kind_of_reference_has_its_own_error() {
        let mut film = film(&[
            record(Claim::Exact, 0.0, 0.0),
            record(Claim::Calibrated, 0.2, 0.01),
            record(Claim::None, 0.0, 0.1),
            record(Claim::None, 0.0, f32::NAN),
        ]);
        film.metadata_mut().set(keys::CONFIDENCE, 0.95);
        let found = |film: &Film| [0, 1, 2, 3].map(|pixel| OwnError::of(film).half_width(pixel));
        let [exact, claimed, paths, unknown] = found(&film);
        assert_eq!((exact, unknown), (0.0, f64::INFINITY));
        // Tolerance of the stored single precision.
        assert!((claimed - 0.2 * Z / 1.959_964).abs() < 1e-6 && (paths - 0.1 * Z).abs() < 1e-6);
        film.metadata_mut().set(keys::PATHS, 5u32);
        // Student's t of four degrees of freedom at 99.9 %, from published tables.
        assert!((found(&film)[2] - 0.861_03).abs() < 1e-5, "{}", found(&film)[2]);
        film.metadata_mut().set(keys::PATHS, 1u32);
        assert_eq!(found(&film)[2], f64::INFINITY);
        assert!(OwnError::of(&film).is_some());
    }

    #[test]
    fn a_film_that_says_nothing_is_taken_for_the_truth() {
        let plain = Film::new([2, 1], Window::full([2, 1]), &[planes::RADIANCE]).unwrap();
        let own = OwnError::of(&plain);
        assert!(own.half_width(1) == 0.0 && !own.is_some());
    }
}
