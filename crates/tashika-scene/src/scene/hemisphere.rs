//! Integrals and images of a radiance that is given by direction.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{Image, Pixels};
use crate::math::elementary::sin_cos_f64;

/// Rows between the zenith and the horizon, and directions in a row.
const ROWS: u32 = 512;
const COLUMNS: u32 = 2048;

/// Irradiance of a plane by a hemisphere:
///
/// ```text
/// E = ∫ L(θ, φ) cos θ sin θ dθ dφ          0 ≤ θ ≤ π/2
/// ```
///
/// by the midpoint rule with 512 × 2048 directions. Rows have equal `sin² θ`, so their weights are
/// equal. Sums are taken by row: the rounding error of a constant `L` is at most 3·10⁻¹³.
///
/// * `up`: normal of the plane, a unit vector.
/// * `radiance`: values of `L` by channel in a unit direction.
pub fn hemispherical_irradiance<const N: usize>(up: DVec3, radiance: impl Fn(DVec3) -> [f64; N]) -> [f64; N] {
    let (right, ahead) = up.any_orthonormal_pair();
    let mut sum = [0.0; N];
    for row in 0..ROWS {
        let squared = (f64::from(row) + 0.5) / f64::from(ROWS);
        let (sin, cos) = (squared.sqrt(), (1.0 - squared).sqrt());
        let mut row_sum = [0.0; N];
        for column in 0..COLUMNS {
            let (sin_phi, cos_phi) = sin_cos_f64(TAU * (f64::from(column) + 0.5) / f64::from(COLUMNS));
            let direction = up * cos + (right * cos_phi + ahead * sin_phi) * sin;
            for (sum, value) in row_sum.iter_mut().zip(radiance(direction)) {
                *sum += value;
            }
        }
        for (sum, value) in sum.iter_mut().zip(row_sum) {
            *sum += value;
        }
    }
    sum.map(|sum| sum * PI / (f64::from(ROWS) * f64::from(COLUMNS)))
}

/// Latitude-longitude image of a sky: row 0 at `+y`, `u = 0.5` at `−z`, `u = 0.75` at `+x`.
pub(super) fn sky_image(width: u32, height: u32, radiance: impl Fn(DVec3) -> [f32; 3]) -> Image {
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for row in 0..height {
        let (sin_theta, cos_theta) = sin_cos_f64((f64::from(row) + 0.5) / f64::from(height) * PI);
        for column in 0..width {
            let (sin_phi, cos_phi) = sin_cos_f64((f64::from(column) + 0.5) / f64::from(width) * TAU);
            texels.push(radiance(DVec3::new(-sin_phi * sin_theta, cos_theta, cos_phi * sin_theta)));
        }
    }
    Image { name: "sky".to_owned(), width, height, pixels: Pixels::Float(texels) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Radiances 1, `cos θ` and `sin θ cos φ` integrate to `π`, `2π/3` and 0, about any axis. With
    /// rows of equal `x = sin² θ`, `cos θ` is `√(1 − x)`, of which the midpoint rule with steps `h`
    /// has too much by `0.0608 h^(3/2)`: here 1.65·10⁻⁵ in all.
    #[test]
    fn irradiances_have_their_closed_forms() {
        for up in [DVec3::Y, DVec3::X, DVec3::new(1.0, 2.0, -3.0).normalize()] {
            let across = up.any_orthonormal_vector();
            let found = hemispherical_irradiance(up, |w| [1.0, w.dot(up), w.dot(across)]);
            for (value, expected) in found.into_iter().zip([PI, 2.0 * PI / 3.0, 0.0]) {
                assert!((value - expected).abs() < 2e-5, "{found:?}");
            }
            assert!((found[0] / PI - 1.0).abs() < 3e-13, "{found:?}");
        }
    }
}
