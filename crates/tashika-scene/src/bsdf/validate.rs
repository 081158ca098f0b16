//! Ranges of parameters, and the message for a value outside.
//!
//! Messages read `field = value; expected low to high`, so that a loader only has to add the file
//! and the name of the material. Tested by `bsdf::tests::limits`.

use super::{FacetModel, MAX_ALPHA, MIN_ALPHA, Microfacets};
use crate::color::Rgb;

/// Range of the index of refraction, relative to the medium outside.
///
/// Below the lower end the boundary reflects less than `3·10⁻⁹`, which `f32` no longer resolves.
/// The upper end is that of the fit of
/// [`fresnel::dielectric_average`](super::fresnel::dielectric_average). No transparent solid has a
/// larger index.
const IOR: (f32, f32) = (1.0001, 5.0);

/// Allowance for a few roundings of 1.
const SUM_SLACK: f32 = 4.0 * f32::EPSILON;

/// Checks that `value` is in `[low, high]`; NaN is not.
pub(super) fn in_range(field: &str, value: f32, low: f32, high: f32) -> Result<(), String> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(format!("{field} = {value}; expected {low} to {high}"))
    }
}

/// Checks that every channel is in `[low, high]`.
pub(super) fn channels_in_range(field: &str, value: Rgb, low: f32, high: f32) -> Result<(), String> {
    in_range(&format!("{field}.r"), value.r, low, high)?;
    in_range(&format!("{field}.g"), value.g, low, high)?;
    in_range(&format!("{field}.b"), value.b, low, high)
}

/// Checks a reflectance or transmittance: every channel in `[0, 1]`.
pub(super) fn fraction(field: &str, value: Rgb) -> Result<(), String> {
    channels_in_range(field, value, 0.0, 1.0)
}

/// Checks a sum of reflectances: at most 1 in every channel, with an allowance for the rounding of
/// colours that were scaled to that sum.
pub(super) fn fraction_of_sum(field: &str, sum: Rgb) -> Result<(), String> {
    fraction(field, sum.map(|s| if s > 1.0 && s <= 1.0 + SUM_SLACK { 1.0 } else { s }))
}

/// Checks the roughness of facets.
pub(super) fn facets(facets: Microfacets) -> Result<(), String> {
    in_range("alpha", facets.narrowest(), MIN_ALPHA, 1.0)?;
    let largest = if facets.model == FacetModel::Beckmann { 1.0 } else { MAX_ALPHA };
    // `narrowest` ignores a NaN, so each roughness is checked as well.
    facets.alpha.into_iter().try_for_each(|alpha| in_range("alpha", alpha, MIN_ALPHA, largest))
}

/// Checks a relative index of refraction.
pub(super) fn ior(value: f32) -> Result<(), String> {
    in_range("ior", value, IOR.0, IOR.1)
}
