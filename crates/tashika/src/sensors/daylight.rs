//! Horizontal irradiance outdoors, to which daylight factors are relative.

use std::f64::consts::PI;

use glam::DVec3;

use crate::math::elementary::sin_cos_f64;
use crate::scene::Environment;

/// Rows between the zenith and the horizon, and directions in a row.
const ROWS: u32 = 512;
const COLUMNS: u32 = 2048;

/// Irradiance by channel (W·m⁻²) that an environment gives to an unobstructed horizontal plane:
///
/// ```text
/// E = ∫ L(θ, φ) cos θ sin θ dθ dφ          0 ≤ θ ≤ π/2
/// ```
///
/// by the midpoint rule with 512 × 2048 directions. The sun and other directional lights are not
/// included, as in the definition of the daylight factor.
///
/// * `up`: unit vector to the zenith.
pub fn horizontal_irradiance(environment: &Environment, up: DVec3) -> [f64; 3] {
    let (right, ahead) = up.any_orthonormal_pair();
    let mut sum = [0.0; 3];
    for row in 0..ROWS {
        // Rows of equal sin² θ have equal weights.
        let squared = (f64::from(row) + 0.5) / f64::from(ROWS);
        let (sin, cos) = (squared.sqrt(), (1.0 - squared).sqrt());
        for column in 0..COLUMNS {
            let phi = 2.0 * PI * (f64::from(column) + 0.5) / f64::from(COLUMNS);
            let (sin_phi, cos_phi) = sin_cos_f64(phi);
            let direction = up * cos + (right * cos_phi + ahead * sin_phi) * sin;
            let radiance = environment.radiance(direction.as_vec3().normalize()).to_array();
            for (sum, value) in sum.iter_mut().zip(radiance) {
                *sum += f64::from(value);
            }
        }
    }
    sum.map(|sum| sum * PI / (f64::from(ROWS) * f64::from(COLUMNS)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::math::Mat3;
    use crate::scene::{Image, Pixels};

    /// Radiance `cos θ` integrates to `2π/3`; below the horizon nothing counts.
    #[test]
    fn the_horizontal_irradiance_is_the_integral_over_the_sky() {
        const ROWS: u32 = 256;
        let row = |row: u32| {
            let cos = sin_cos_f64(PI * (f64::from(row) + 0.5) / f64::from(ROWS)).1;
            if cos > 0.0 { [cos as f32, 2.0 * cos as f32, 0.0] } else { [5.0; 3] }
        };
        let texels = (0..ROWS).flat_map(|k| [row(k); 4]).collect();
        let image = Image { name: "sky".into(), width: 4, height: ROWS, pixels: Pixels::Float(texels) };
        let environment = Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY);
        let found = horizontal_irradiance(&environment, DVec3::Y);
        for (value, expected) in found.iter().zip([1.0, 2.0, 0.0]) {
            assert!((value - expected * 2.0 * PI / 3.0).abs() < 2e-3, "{found:?}");
        }
    }
}
