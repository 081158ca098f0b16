//! Stopping rule of path-traced truths, and the choice of pixels precise enough to judge by.
//!
//! A path-traced truth has errors too. With a standard error `e` of the truth and a tolerance `τ`,
//! an estimate may be judged wrongly only if its distance from the truth is within about `2 e` of
//! `τ`. Pixels with `e > τ/4` are omitted, whatever their estimates.
//!
//! Held to this by `experiment::tests`.

use crate::film::{Film, Plane, Stop, planes};
use crate::integrator::{ControlOptions, PathStop};
use crate::report::Tolerance;

/// Largest standard error of the truth, over the tolerance.
const SHARE: f64 = 0.25;
/// Confidence of an interval of one standard error.
const ONE_SIGMA: f64 = 0.682_689_492;
/// Fewest paths of a converged truth: fewer may not have met rare light.
const FIRST_PATHS: u32 = 4096;

/// Returns the stopping rule of a truth that is precise enough to judge a promise: path tracing
/// stops at a standard error of a quarter of the tolerance, or after `most` paths.
pub fn until_converged(promise: &ControlOptions, most: u32) -> PathStop {
    let options = ControlOptions {
        error: promise.error * SHARE,
        absolute_error: promise.absolute_error * SHARE,
        confidence: ONE_SIGMA,
        ..*promise
    };
    PathStop::Until { options, first: FIRST_PATHS.min(most), most }
}

/// Returns the film with all pixels marked as not rendered whose standard error is above a quarter
/// of the tolerance.
///
/// # Panics
/// If it is not a film of [`render`](crate::render) in luminance.
pub fn converged(film: &Film, tolerance: &Tolerance) -> Film {
    let errors = film.plane(planes::STANDARD_ERROR).and_then(Plane::f32_samples).expect("a film of `render`");
    let colors = film.colors().expect("a film of `render`");
    let unknown: Vec<bool> = colors
        .zip(errors)
        .map(|(color, error)| {
            let allowed = (tolerance.relative * f64::from(color.luminance())).max(tolerance.absolute);
            f64::from(*error) > SHARE * allowed
        })
        .collect();
    let mut film = film.clone();
    let pixels: Vec<(u32, u32)> = film.window().pixels().collect();
    let stop = film.plane_mut(planes::STOP).expect("a film of `render`");
    for ((x, y), _) in pixels.into_iter().zip(unknown).filter(|(_, unknown)| *unknown) {
        stop.set_u32(x, y, &[Stop::NotRendered.id()]);
    }
    film
}
