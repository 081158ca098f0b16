//! Spectra as linear Rec. 709 colours.
//!
//! Input: samples `(wavelength in nm, value)` in any order, interpolated linearly; outside, the
//! first and last value continue. With the colour matching functions `x̄ ȳ z̄` and the matrix `M`
//! from XYZ to Rec. 709, a channel `c` responds to light by `r̄_c = M_c · (x̄, ȳ, z̄)`, and
//!
//! ```text
//! reflectance:  ρ_c = ∫ ρ S r̄_c dλ / ∫ S r̄_c dλ        S = D65
//! emission:     L_c = ∫ L r̄_c dλ / ∫ ȳ dλ
//! ```
//!
//! # Guarantee
//! * A constant reflectance `v` becomes `(v, v, v)`: D65 is the white of Rec. 709. Each channel is
//!   clamped to the range of the samples, because the weights of the quotient above are partly
//!   negative. So reflectances do not leave `[0, 1]`.
//! * An emission becomes a colour whose luminance, in the unit of the spectrum, is the mean of the
//!   spectrum weighted by `ȳ`; a constant `v` has the luminance `v`. Negative channels are set to
//!   zero, and the others are scaled to keep the luminance.
//! * Samples that are not finite are ignored; if no other is left, there is no colour.
//!
//! # Assumption
//! Lights are near white: only then is the product `L_c ρ_c`, by which an RGB renderer reflects
//! light, close to the integral of `L ρ r̄_c`.
//!
//! | module | contents |
//! |---|---|
//! | `observer` | `x̄ ȳ z̄`, `M`, D65 |
//! | `thermal` | Planck's law |
//! | `illuminants` | chromaticities of the CIE's illuminants |
//!
//! Sources: [^cie15], [^bt709]. Held to this by the tests below and in the modules.

mod illuminants;
mod observer;
mod thermal;

pub use illuminants::illuminant_rgb;
pub use thermal::{blackbody, blackbody_rgb, blackbody_rgb_of_unit_peak};

use super::Rgb;
use observer::{FIRST_NM, Response, responses};

/// A spectrum for lookups: sorted, finite, at least one sample.
struct Sampled(Vec<(f32, f32)>);

impl Sampled {
    fn new(samples: &[(f32, f32)]) -> Option<Self> {
        let mut kept: Vec<_> =
            samples.iter().copied().filter(|(nm, value)| nm.is_finite() && value.is_finite()).collect();
        kept.sort_by(|a, b| a.0.total_cmp(&b.0));
        (!kept.is_empty()).then_some(Self(kept))
    }

    /// Returns the value at a wavelength; at a step, where two samples have one wavelength, the
    /// later one.
    fn at(&self, nm: f32) -> f64 {
        let after = self.0.partition_point(|s| s.0 <= nm);
        let Some(&(x0, y0)) = after.checked_sub(1).and_then(|before| self.0.get(before)) else {
            return f64::from(self.0[0].1);
        };
        let Some(&(x1, y1)) = self.0.get(after) else { return f64::from(y0) };
        let [x, x0, x1, y0, y1] = [nm, x0, x1, y0, y1].map(f64::from);
        y0 + (y1 - y0) * (x - x0) / (x1 - x0)
    }

    /// Smallest and largest sample.
    fn range(&self) -> [f32; 2] {
        let values = || self.0.iter().map(|s| s.1);
        [values().fold(f32::INFINITY, f32::min), values().fold(f32::NEG_INFINITY, f32::max)]
    }
}

/// Returns `∫ spectrum · weight dλ` for the three channels of `weight`, as a sum in steps of 1 nm
/// like those of the CIE.
fn integrate(spectrum: impl Fn(f32) -> f64, weight: impl Fn(&Response) -> [f64; 3]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (i, response) in responses().iter().enumerate() {
        let value = spectrum(FIRST_NM + i as f32);
        for (sum, weight) in sum.iter_mut().zip(weight(response)) {
            *sum += value * weight;
        }
    }
    sum
}

/// Returns the colour of a surface of this reflectance. Also averages any other property of a
/// surface, such as refractive indices, by the response of each channel.
pub fn rgb_of_reflectance(samples: &[(f32, f32)]) -> Option<Rgb> {
    let spectrum = Sampled::new(samples)?;
    let [least, most] = spectrum.range();
    let weight = |r: &Response| r.rgb.map(|channel| channel * r.d65);
    let seen = integrate(|nm| spectrum.at(nm), weight);
    let white = integrate(|_| 1.0, weight);
    let channel = |c: usize| ((seen[c] / white[c]) as f32).clamp(least, most);
    Some(Rgb::new(channel(0), channel(1), channel(2)))
}

/// Returns the colour of light with this spectrum, in the unit of the spectrum.
pub fn rgb_of_emission(samples: &[(f32, f32)]) -> Option<Rgb> {
    let spectrum = Sampled::new(samples)?;
    Some(emission(|nm| spectrum.at(nm)))
}

fn emission(spectrum: impl Fn(f32) -> f64) -> Rgb {
    let [_, luminance, _] = integrate(&spectrum, |r| r.xyz);
    let [_, norm, _] = integrate(|_| 1.0, |r| r.xyz);
    let [r, g, b] = integrate(&spectrum, |r| r.rgb).map(|c| (c / norm) as f32);
    of_luminance(Rgb::new(r, g, b), (luminance / norm) as f32)
}

/// Returns the colour without its negative channels, scaled to a luminance; black if that is not
/// possible.
fn of_luminance(color: Rgb, luminance: f32) -> Rgb {
    let visible = color.map(|c| c.max(0.0));
    let scale = luminance / visible.luminance();
    if scale.is_finite() && scale > 0.0 { visible * scale } else { Rgb::BLACK }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Rgb, b: [f32; 3], tolerance: f32) -> bool {
        a.zip(b.into(), |a, b| (a - b).abs()).max_channel() <= tolerance
    }

    #[test]
    fn constant_reflectances_are_grey_and_constant_emissions_keep_their_luminance() {
        for v in [0.0, 0.25, 1.0, 3.0] {
            assert!(close(rgb_of_reflectance(&[(500.0, v)]).unwrap(), [v; 3], 1e-6 * v));
            let light = rgb_of_emission(&[(400.0, v), (700.0, v)]).unwrap();
            assert!((light.luminance() - v).abs() <= 1e-6 * v, "{light:?}");
            // XYZ = (1, 1, 1) in Rec. 709; the fit moves it by half a percent.
            assert!(close(light, [1.2048, 0.9483, 0.9089].map(|c| c * v), 0.006 * v), "{light:?}");
        }
    }

    #[test]
    fn reflectances_are_seen_under_daylight() {
        // A reflectance that is the inverse of daylight looks like equal energy: XYZ = (1, 1, 1).
        let inverse = |(i, r): (usize, &Response)| (FIRST_NM + i as f32, (80.0 / r.d65) as f32);
        let samples: Vec<(f32, f32)> = responses().iter().enumerate().map(inverse).collect();
        let color = rgb_of_reflectance(&samples).unwrap();
        let expected = [1.2048 / 0.9483, 1.0, 0.9089 / 0.9483];
        // The fit moves daylight's white by one percent.
        assert!(close(color / color.g, expected, 0.02), "{color:?}");
    }

    #[test]
    fn samples_are_linear_in_any_order_with_constant_ends_and_steps() {
        let s =
            Sampled::new(&[(600.0, 4.0), (400.0, 0.0), (f32::NAN, 9.0), (500.0, 2.0), (600.0, 8.0)]).unwrap();
        assert_eq!([300.0, 450.0, 599.0, 600.0, 900.0].map(|nm| s.at(nm)), [0.0, 1.0, 3.98, 8.0, 8.0]);
        assert!(rgb_of_reflectance(&[]).is_none());
        assert!(rgb_of_emission(&[(500.0, f32::INFINITY), (f32::NAN, 1.0)]).is_none());
    }

    #[test]
    fn saturated_spectra_stay_in_range() {
        // A green line of a laser's width; below, a reflectance without green.
        let narrow = [(519.0, 0.0), (520.0, 1.0), (521.0, 0.0)];
        let light = rgb_of_emission(&narrow).unwrap();
        assert!(light.is_valid() && light.r == 0.0 && light.g > 0.0);
        // ȳ(520 nm) = 0.710, ∫ ȳ = 106.86 nm, area 1 nm.
        assert!((light.luminance() / (0.710 / 106.86) - 1.0).abs() < 0.02, "{light:?}");
        let notch = rgb_of_reflectance(&[(470.0, 1.0), (480.0, 0.0), (600.0, 0.0), (610.0, 1.0)]).unwrap();
        assert!(notch.is_valid() && notch.max_channel() <= 1.0, "{notch:?}");
        assert_eq!(rgb_of_emission(&[(500.0, -1.0)]), Some(Rgb::BLACK));
    }
}
