//! Horizontal irradiance outdoors, to which daylight factors are relative.

use glam::DVec3;

use crate::scene::{Environment, hemispherical_irradiance};

/// Irradiance by channel (W·m⁻²) that an environment gives to an unobstructed horizontal plane:
///
/// ```text
/// E = ∫ L(θ, φ) cos θ sin θ dθ dφ          0 ≤ θ ≤ π/2
/// ```
///
/// by [`hemispherical_irradiance`]. The sun and other directional lights are not included, as in
/// the definition of the daylight factor.
///
/// * `up`: unit vector to the zenith.
pub fn horizontal_irradiance(environment: &Environment, up: DVec3) -> [f64; 3] {
    hemispherical_irradiance(up, |direction| {
        environment.radiance(direction.as_vec3().normalize()).to_array().map(f64::from)
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::color::Rgb;
    use crate::math::Mat3;
    use crate::math::elementary::sin_cos_f64;
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
