//! Automatic exposure of a picture of radiance.
//!
//! The log-average of the pixels that are not black becomes middle gray, `0.18` (Reinhard, Stark,
//! Shirley, Ferwerda 2002, eq. 1). Pixels darker than 10⁻⁴ of the mean are omitted:
//!
//! ```text
//! 2ᵉ = 0.18 / exp(mean ln L)
//! ```
//!
//! The exposure depends on nothing but the luminances. Held to this by the tests of `io::png`,
//! which exposes films in this way, and of `report::measures`.

use crate::math::elementary::ln;

/// Luminance that the log-average of a picture is mapped to.
const MIDDLE_GRAY: f64 = 0.18;
/// Share of the mean luminance below which a pixel does not enter the log-average.
const NEGLIGIBLE: f64 = 1e-4;

/// Returns the stops `e`, from −64 to 64, that map the log-average of these luminances to middle
/// gray. Luminances that are not positive and finite are ignored. If none is left, `e` is 0.
pub fn automatic_stops(luminances: impl Iterator<Item = f32> + Clone) -> f32 {
    let luminances = luminances.filter(|&l| l > 0.0 && l.is_finite());
    let mean_above = |floor: f64, of: fn(f32) -> f32| {
        let (mut sum, mut count) = (0.0, 0_u64);
        for l in luminances.clone().filter(|&l| f64::from(l) >= floor) {
            sum += f64::from(of(l));
            count += 1;
        }
        (count > 0).then(|| sum / count as f64)
    };
    let Some(mean) = mean_above(0.0, |l| l) else { return 0.0 };
    let log_average = mean_above(NEGLIGIBLE * mean, ln).expect("the largest is above its mean");
    let log_gray = f64::from(ln(MIDDLE_GRAY as f32));
    (((log_gray - log_average) / std::f64::consts::LN_2) as f32).clamp(-64.0, 64.0)
}
