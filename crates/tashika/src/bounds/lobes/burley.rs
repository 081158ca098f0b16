//! Upper bounds of the diffuse part and of the sheen of [`Principled`](crate::bsdf::Principled).
//!
//! ```text
//! b = (1 − w_o/2)(1 − w_i/2) + R (w_o + w_i − w_o w_i) + R² w_o w_i,    R = r (1 + ω_o·ω_i)
//! ```
//!
//! grows with `R`, and is linear in `w_i`. Where `c_i` is in a range, so is `w_i = (1 − c_i)⁵`, and
//! `ω_o·ω_i ≤ c_o c_i + s_o s_i` with the largest cosine and the largest sine: the maximum over the
//! range is at most that at one end of `w_i`, with the largest `R`.
//!
//! The sheen is `(1 − c_d)⁵` with `2 c_d² = 1 + ω_o·ω_i ≥ 1 − s_o`: of all directions above the
//! horizon, the one opposite to the viewer's and in the surface is farthest from it.
//!
//! # Guarantee
//! At least the `f32` values but for relative roundings.
//!
//! # Held to this by
//! The test below, `bounds::tests::reflector`, `bounds::tests::analytic`.

/// Pieces of the cosines over which `b` is bounded.
const PIECES: u32 = 4;

/// At least `b` for all `cos_i` in `[0, max_cos_i]`.
pub(super) fn upper_shape(roughness: f32, cos_o: f64, max_cos_i: f64) -> f64 {
    let (r, w_o, sin_o) = (f64::from(roughness), grazing(cos_o), sine(cos_o));
    let of_piece = |piece: u32| {
        let [low, high] = [piece, piece + 1].map(|end| max_cos_i * f64::from(end) / f64::from(PIECES));
        let r = r * (1.0 + (cos_o * high + sin_o * sine(low)).min(1.0));
        let at = |w_i: f64| {
            (1.0 - 0.5 * w_o) * (1.0 - 0.5 * w_i) + r * (w_o + w_i - w_o * w_i) + r * r * w_o * w_i
        };
        at(grazing(low)).max(at(grazing(high)))
    };
    (0..PIECES).map(of_piece).fold(0.0, f64::max)
}

/// At least `(1 − c_d)⁵` for all directions above the horizon.
pub(super) fn upper_sheen(cos_o: f64) -> f64 {
    // 1 − s_o, as it is where it is small; directions are unit vectors to 10⁻⁶.
    let least = (0.5 * cos_o * cos_o / (1.0 + sine(cos_o)) - 1e-6).max(0.0).sqrt();
    grazing(least)
}

fn grazing(cos: f64) -> f64 {
    let x = (1.0 - cos).max(0.0);
    x * x * x * x * x
}

fn sine(cos: f64) -> f64 {
    ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all directions of a grid, for cosines of the light up to a largest one.
    #[test]
    fn shapes_and_sheens_hold_and_are_near() {
        for roughness in [0.0_f32, 0.3, 1.0] {
            for cos_o in [0.01, 0.1, 0.3, 0.7, 1.0] {
                for max_cos_i in [0.05, 0.4, 1.0] {
                    let (mut shape, mut sheen) = (0.0_f64, 0.0_f64);
                    for (i, j) in (0..=200).flat_map(|i| (0..=40).map(move |j| (i, j))) {
                        let cos_i = max_cos_i * f64::from(i) / 200.0;
                        let azimuth = std::f64::consts::PI * f64::from(j) / 40.0;
                        let along = cos_o * cos_i + sine(cos_o) * sine(cos_i) * azimuth.cos();
                        let cos_d = (0.5 * (1.0 + along)).max(0.0).sqrt();
                        let r = 2.0 * f64::from(roughness) * cos_d * cos_d;
                        let (o, i) = (grazing(cos_o), grazing(cos_i));
                        let b = (1.0 - 0.5 * o) * (1.0 - 0.5 * i) + r * (o + i + o * i * (r - 1.0));
                        (shape, sheen) = (shape.max(b), sheen.max(grazing(cos_d)));
                    }
                    let bound = upper_shape(roughness, cos_o, max_cos_i);
                    assert!(
                        shape <= bound * (1.0 + 1e-9),
                        "{roughness} {cos_o} {max_cos_i}: {shape} {bound}"
                    );
                    assert!(bound <= 1.6 * shape, "{roughness} {cos_o} {max_cos_i}: {bound} for {shape}");
                    let bound = upper_sheen(cos_o);
                    assert!(sheen <= bound * (1.0 + 1e-9), "{cos_o}: {sheen} above {bound}");
                    assert!(bound <= 1.01 * sheen + 1e-9, "{cos_o}: {bound} for {sheen}");
                }
            }
        }
    }
}
