//! Patterns of skies: the functions that `gensky` and `gendaylit` name.
//!
//! Both have the luminance of a sky above the horizon and a constant ground below, blended by
//!
//! ```text
//! L(z) = (a S + b G) / (a + b),   a = (z + 1.01)¹⁰,   b = (z + 1.01)⁻¹⁰
//! ```
//!
//! where `z` is the vertical component of a unit direction. With the angles `γ` from the sun, `η`
//! and `ζ` of the direction and of the sun from the zenith:
//!
//! | function | `S` |
//! |---|---|
//! | `skybr`, 1 (clear) | `A₂ (0.91 + 10 e^{−3γ} + 0.45 cos² γ) (1 − e^{−0.32/z}) / A₄` |
//! | `skybr`, 2 (overcast) | `A₂ (1 + 2z) / 3` |
//! | `skybr`, 3 (uniform) | `A₂` |
//! | `skybr`, 4 (intermediate) | a function of `γ`, `η` and `ζ`, see `intermediate` |
//! | `skybright` (Perez et al. 1993) | `A₁ (1 + A₃ e^{A₄/z}) (1 + A₅ e^{A₆ γ} + A₇ cos² γ)` |
//!
//! Source: Radiance, `skybright.cal` and `perezlum.cal`. Held to this by the tests below.

use glam::DVec3;

use super::definitions::Definition;
use crate::error::{Error, Result};
use crate::math::elementary::{atan2_f64, exp_f64, sin_cos_f64};

/// Luminance of a sky, relative to the radiance of its source.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SkyPattern {
    arguments: Vec<f64>,
    is_perez: bool,
    to_sun: DVec3,
    /// Rotation from the world to the coordinates of the pattern.
    to_local: glam::DMat3,
}

impl SkyPattern {
    /// Reads a pattern; none if it is no sky of these functions.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a wrong number of arguments.
    pub(super) fn new(definition: &Definition) -> Result<Option<Self>> {
        let (strings, arguments) = (&definition.primitive.strings, &definition.primitive.reals);
        let names: Vec<&str> = strings.iter().map(String::as_str).collect();
        let is_perez = match (definition.primitive.kind.as_str(), &names[..]) {
            ("brightfunc", ["skybr", "skybright.cal"]) => false,
            ("brightfunc", ["skybright", "perezlum.cal"]) => true,
            _ => return Ok(None),
        };
        let kind = arguments.first().copied().unwrap_or(0.0);
        let sun = match (is_perez, kind) {
            (true, _) => 7,
            (false, 1.0 | 4.0) => 4,
            (false, 2.0 | 3.0) => 0,
            _ => usize::MAX,
        };
        let enough = if sun == 0 { 3 } else { sun.saturating_add(3) };
        if arguments.len() < enough {
            let found = format!("a sky of {} arguments, {kind} first", arguments.len());
            let expected = "those of skybright.cal (1, 2, 3 or 4 first) or perezlum.cal";
            return Err(Error::invalid(definition.at.clone(), found, expected));
        }
        let to_sun =
            if sun == 0 { DVec3::ZERO } else { DVec3::from_slice(&arguments[sun..]).normalize_or_zero() };
        let to_local = definition.map.map.matrix3.transpose() * (1.0 / definition.map.scale);
        Ok(Some(Self { arguments: arguments.clone(), is_perez, to_sun, to_local }))
    }

    /// Factor on the radiance of the source in a unit direction of the world, at least 0.
    pub(super) fn at(&self, direction: DVec3) -> f64 {
        let direction = self.to_local * direction;
        let (z, cos) = (direction.z, direction.dot(self.to_sun).clamp(-1.0, 1.0));
        let a = &self.arguments;
        let gamma = angle(cos);
        let (sky, ground) = if self.is_perez {
            let z = z.max(0.01);
            let gradient = a[0] * (1.0 + a[2] * exp_f64(a[3] / z));
            (gradient * (1.0 + a[4] * exp_f64(a[5] * gamma) + a[6] * cos * cos), a[1])
        } else {
            let sky = match a[0] as u32 {
                1 => {
                    let fading = if z > 0.01 { 1.0 - exp_f64(-0.32 / z) } else { 1.0 };
                    a[1] * (0.91 + 10.0 * exp_f64(-3.0 * gamma) + 0.45 * cos * cos) * fading / a[3]
                }
                2 => a[1] * (1.0 + 2.0 * z) / 3.0,
                3 => a[1],
                _ => a[1] * intermediate(angle(z), angle(self.to_sun.z), gamma) / a[3],
            };
            (sky, a[2])
        };
        let up = power_of_ten(z + 1.01);
        let value = (up * sky + ground / up) / (up + 1.0 / up);
        if value.is_finite() { value.max(0.0) } else { 0.0 }
    }
}

fn power_of_ten(x: f64) -> f64 {
    let square = x.max(0.0) * x.max(0.0);
    let fourth = square * square;
    fourth * fourth * square
}

/// Angle of a cosine (radians).
fn angle(cos: f64) -> f64 {
    atan2_f64((1.0 - cos * cos).max(0.0).sqrt(), cos)
}

fn intermediate(eta: f64, sun: f64, gamma: f64) -> f64 {
    let sin = |x: f64| sin_cos_f64(x).0;
    let first = (1.35 * sin(5.631 - 3.59 * eta) + 3.12) * sin(4.396 - 2.6 * sun) + 6.37 - eta;
    first / 2.326 * exp_f64(gamma * -0.563 * ((2.629 - eta) * (1.562 - sun) + 0.812))
}

#[cfg(test)]
mod tests {
    use super::super::tests::definition;
    use super::*;

    fn sky(text: &str) -> SkyPattern {
        SkyPattern::new(&definition(text)).unwrap().unwrap()
    }

    #[test]
    fn skies_have_the_luminances_that_radiance_renders() {
        // Printed by rtrace for a source of radiance 1 with these patterns, in the directions
        // (0, 0, 1), (0.6, 0, 0.8), (0, 0.8, 0.6), (0, 0.6, −0.8).
        let up = DVec3::new;
        let directions = [up(0.0, 0.0, 1.0), up(0.6, 0.0, 0.8), up(0.0, 0.8, 0.6), up(0.0, 0.6, -0.8)];
        for (text, shown) in [
            ("void brightfunc s 2 skybr skybright.cal 0 3 2 30.56 4.754", EXPECTED[0]),
            (
                "void brightfunc s 2 skybr skybright.cal 0 7 1 31.59 30.18 1.647 0.038267 -0.247596 0.968107",
                EXPECTED[1],
            ),
            (
                "void brightfunc s 2 skybr skybright.cal 0 7 4 31.59 30.18 1.647 0.038267 -0.247596 0.968107",
                EXPECTED[2],
            ),
            (
                "void brightfunc s 2 skybright perezlum.cal 0 10 44.43 15.77 -1.093145 -0.250638 13.093605 -3.468876 0.240358 -0.241845 -0.664463 0.707107",
                EXPECTED[3],
            ),
        ] {
            let sky = sky(text);
            for (direction, shown) in directions.iter().zip(shown) {
                let value = sky.at(*direction);
                // Radiance prints seven digits; its exponentials are of single precision.
                assert!((value / shown - 1.0).abs() < 2e-5, "{text}: {value} {shown}");
            }
        }
    }

    const EXPECTED: [[f64; 4]; 4] = [
        [30.559_98, 26.485_18, 22.409_38, 4.754],
        [31.566_77, 16.621_44, 10.053_15, 30.18],
        [22.838_45, 9.771_475, 3.438_012, 30.18],
        [13.118_04, 11.570_01, 12.963_1, 15.77],
    ];

    #[test]
    fn other_patterns_are_no_skies_and_arguments_are_counted() {
        for text in ["void brightfunc s 2 a skybright.cal 0 0", "void colorfunc s 4 a b c d 0 0"] {
            assert_eq!(SkyPattern::new(&definition(text)).unwrap(), None, "{text}");
        }
        for text in [
            "void brightfunc s 2 skybr skybright.cal 0 3 1 2 3",
            "void brightfunc s 2 skybr skybright.cal 0 1 9",
        ] {
            let error = SkyPattern::new(&definition(text)).unwrap_err().to_string();
            assert!(error.contains("a sky of") && error.contains("perezlum.cal"), "{error}");
        }
    }
}
