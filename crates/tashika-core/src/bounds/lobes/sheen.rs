//! Upper bounds of [`Sheen`](crate::bsdf::Sheen) for one viewing direction.
//!
//! The range of `c_i` is divided into pieces `[a, b]`. With the sines `s` of the cosines,
//!
//! ```text
//! sin²θ_h ≤ 1 − (c_o + a)² / (2 + 2 (c_o b + s_o s_a)),            D grows with it
//! V c_i ≤ 1 / ((1 + Λ(c_o) + Λ(b)) 4 c_o),      V ≤ that over a,   since Λ falls
//! V ≤ 1 / (4 c_o · least of c (1 + Λ(c)))                          in the first piece
//! ```
//!
//! # Guarantee
//! At least the `f32` values except for relative roundings.
//!
//! # Held to this by
//! The test below, `bounds::tests::reflector`, `bounds::tests::analytic`,
//! `bounds::tests::cube_map`.

use std::f64::consts::TAU;

use crate::bsdf::{Sheen, UPPER_SHEEN_VISIBILITY};
use crate::math::elementary::powf_f64;

/// Factor for the errors of powers and exponentials in `f32`: the roundings of exponents of up to
/// 50, and those of `Λ`, whose computed values fall with the cosine only to within a relative error
/// of 10⁻⁵.
const ROUNDINGS: f64 = 1.0 + 1e-4;

/// Number of pieces of the range of cosines; the pieces are shorter towards the horizon.
const PIECES: u32 = 8;

/// Upper bounds of the largest channel of the sheen (sr⁻¹) and of its product with the cosine, for
/// light at cosines of at most `max_cos_i` and a viewer at the cosine `cos_o > 0`.
pub(super) fn upper(sheen: &Sheen, cos_o: f32, max_cos_i: f64) -> [f64; 2] {
    if !sheen.is_there() {
        return [0.0; 2];
    }
    let cos_o64 = f64::from(cos_o);
    let inverse = 1.0 / f64::from(sheen.roughness * sheen.roughness);
    let scale = f64::from(sheen.color.max_channel()) * (2.0 + inverse) / TAU / (4.0 * cos_o64) * ROUNDINGS;
    let seen = 1.0 + f64::from(sheen.hidden(cos_o));
    let end = |piece: u32| {
        let share = f64::from(piece) / f64::from(PIECES);
        max_cos_i * share * share
    };
    let of_piece = |piece: u32| {
        let [low, high] = [end(piece), end(piece + 1)];
        let along = (cos_o64 * high + sine(cos_o64) * sine(low)).min(1.0);
        let axial2 = (cos_o64 + low) * (cos_o64 + low) / (2.0 + 2.0 * along);
        // Directions are unit vectors to 10⁻⁶.
        let tangential2 = (1.0 - axial2 + 4e-6).clamp(0.0, 1.0);
        let fibres = scale * powf_f64(tangential2, 0.5 * inverse);
        let visible = 1.0 / (seen + f64::from(sheen.hidden((high as f32).next_up())));
        let plain =
            if low > 0.0 { UPPER_SHEEN_VISIBILITY.min(visible / low) } else { UPPER_SHEEN_VISIBILITY };
        [fibres * plain, fibres * visible]
    };
    (0..PIECES).map(of_piece).fold([0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])])
}

fn sine(cos: f64) -> f64 {
    // Directions are unit vectors to 10⁻⁶.
    ((1.0 - cos) * (1.0 + cos) + 4e-6).clamp(0.0, 1.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Bsdf, Lambert, Layered};
    use crate::color::Rgb;
    use crate::math::Vec3;
    use crate::math::elementary::sin_cos;

    /// The bounds hold for all directions of a grid. The bound with the cosine is within a factor
    /// of 3 of the largest value, unless that is negligible.
    #[test]
    fn sheens_are_bounded_and_bounds_with_the_cosine_are_near() {
        let black = Bsdf::Lambert(Lambert { reflectance: Rgb::BLACK });
        for roughness in [0.1, 0.2, 0.5, 1.0] {
            for cos_o in [1e-4, 0.01, 0.1, 0.5, 0.9, 1.0_f32] {
                let sheen = Sheen { color: Rgb::WHITE, roughness };
                let bsdf = Bsdf::Layered(Layered { sheen, ..Layered::over(&black).unwrap() });
                let wo = Vec3::new((1.0 - cos_o * cos_o).sqrt(), 0.0, cos_o);
                for max_cos_i in [0.01_f32, 0.3, 1.0] {
                    let bounds = upper(&sheen, cos_o, max_cos_i.into());
                    let mut largest = [0.0_f64; 2];
                    for (i, j) in (1..=200_u16).flat_map(|i| (0..=40_u16).map(move |j| (i, j))) {
                        let cos_i = max_cos_i * f32::from(i) * f32::from(i) / 40_000.0;
                        let (sin, cos) = sin_cos(std::f32::consts::PI * f32::from(j) / 40.0);
                        let wi = Vec3::new(cos, sin, 0.0) * (1.0 - cos_i * cos_i).sqrt() + Vec3::Z * cos_i;
                        let values = [bsdf.eval(wo, wi).g, bsdf.eval_cos(wo, wi).g];
                        for (largest, (value, bound)) in
                            largest.iter_mut().zip(values.into_iter().zip(bounds))
                        {
                            assert!(
                                f64::from(value) <= bound,
                                "{roughness} {wo} {wi}: {value} above {bound}"
                            );
                            *largest = largest.max(value.into());
                        }
                    }
                    // Smaller values are invisible.
                    let near = bounds[1] / largest[1].max(1e-3);
                    assert!(near < 3.0, "{roughness} {cos_o} {max_cos_i}: {} for {}", bounds[1], largest[1]);
                }
            }
        }
    }
}
