//! Upper bounds of the diffuse part and of the sheen of [`Principled`](crate::bsdf::Principled).
//!
//! ```text
//! b = (1 − w_o/2)(1 − w_i/2) + R (w_o + w_i − w_o w_i) + R² w_o w_i,    R = r (1 + ω_o·ω_i)
//! ```
//!
//! `b` grows with `R` and is linear in `w_i`. If `c_i` is in a range, so is `w_i = (1 − c_i)⁵`.
//! Since `ω_o·ω_i ≤ c_o c_i + s_o s_i`, the largest cosine and the largest sine in the range bound
//! `R`. The maximum of `b` over the range is therefore at most its value at one end of `w_i`, with
//! the largest `R`. The flat part
//!
//! ```text
//! e = 5/4 · (E (1 / (c_o + c_i) − ½) + ½),    E = (1 + (R/2 − 1) w_o)(1 + (R/2 − 1) w_i)
//! ```
//!
//! grows with `E`, since `c_o + c_i ≤ 2`, and otherwise falls with `c_i`. `E` grows with `R` and is
//! linear in `w_i`. Near the horizon `e` grows as `1 / (c_o + c_i)`, but `e c_i` stays bounded:
//!
//! ```text
//! e c_i = 5/4 · (E (c_i / (c_o + c_i) − c_i/2) + c_i/2),    c_i / (c_o + c_i) grows with c_i
//! ```
//!
//! The sheen is `(1 − c_d)⁵` with `2 c_d² = 1 + ω_o·ω_i ≥ 1 − s_o`. Equality holds for the
//! direction in the plane of the surface opposite to the viewer, which of all directions above the
//! horizon is farthest from the viewer.
//!
//! # Guarantee
//! At least the `f32` values except for relative roundings.
//!
//! # Held to this by
//! The test below, `bounds::tests::reflector`, `bounds::tests::analytic`.

/// Number of pieces into which the range of cosines is divided to bound `b`.
const PIECES: u32 = 4;

/// Number of pieces if flatness is positive. They are shorter towards the horizon, where `e` is
/// steep.
const FLAT_PIECES: u32 = 16;

/// Upper bounds of `(1 − f) b + f e` and of the product with `c_i`, for all `cos_i` in
/// `[0, max_cos_i]`.
pub(super) fn upper_shape(roughness: f32, flatness: f32, cos_o: f64, max_cos_i: f64) -> [f64; 2] {
    let (r, flatness) = (f64::from(roughness), f64::from(flatness));
    let larger = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
    if flatness <= 0.0 {
        let ends = |piece: u32| [piece, piece + 1].map(|end| max_cos_i * f64::from(end) / f64::from(PIECES));
        let rough = (0..PIECES).map(|piece| upper_rough(retro(r, cos_o, ends(piece)), cos_o, ends(piece)));
        let rough = rough.fold(0.0, f64::max);
        return [rough, rough * max_cos_i];
    }
    let of_piece = |piece: u32| {
        let [low, high] = [piece, piece + 1].map(|end| {
            let share = f64::from(end) / f64::from(FLAT_PIECES);
            max_cos_i * share * share
        });
        let r = retro(r, cos_o, [low, high]);
        let rough = (1.0 - flatness) * upper_rough(r, cos_o, [low, high]);
        let flat = upper_flat(r, cos_o, [low, high]);
        [rough + flatness * flat[0], rough * high + flatness * flat[1]]
    };
    (0..FLAT_PIECES).map(of_piece).fold([0.0; 2], larger)
}

/// Upper bound of `R` for all `cos_i` in the range.
fn retro(roughness: f64, cos_o: f64, [low, high]: [f64; 2]) -> f64 {
    roughness * (1.0 + (cos_o * high + sine(cos_o) * sine(low)).min(1.0))
}

/// Upper bound of `b` for all `cos_i` in the range and `R` up to `r`.
fn upper_rough(r: f64, cos_o: f64, [low, high]: [f64; 2]) -> f64 {
    let w_o = grazing(cos_o);
    let at =
        |w_i: f64| (1.0 - 0.5 * w_o) * (1.0 - 0.5 * w_i) + r * (w_o + w_i - w_o * w_i) + r * r * w_o * w_i;
    at(grazing(low)).max(at(grazing(high)))
}

/// Upper bounds of `e` and of `e c_i`, for all `cos_i` in the range and `R` up to `r`.
fn upper_flat(r: f64, cos_o: f64, [low, high]: [f64; 2]) -> [f64; 2] {
    let at = |w: f64| 1.0 + (0.5 * r - 1.0) * w;
    let even = at(grazing(cos_o)) * at(grazing(low)).max(at(grazing(high)));
    // The constant covers the rounding of differences that may be zero.
    let of = |difference: f64, half: f64| 1.25 * (even * (difference + 1e-6) + half);
    [of(1.0 / (cos_o + low) - 0.5, 0.5), of(high / (cos_o + high) - 0.5 * low, 0.5 * high)]
}

/// Upper bound of `(1 − c_d)⁵` for all directions above the horizon.
pub(super) fn upper_sheen(cos_o: f64) -> f64 {
    // 1 − s_o, in a form without cancellation. Directions are unit vectors to 10⁻⁶.
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

    /// Compares with the maxima over a grid of directions whose cosine is at most `max_cos_i`.
    #[test]
    fn shapes_and_sheens_hold_and_are_near() {
        for (roughness, flatness) in [(0.0_f32, 0.0_f32), (0.3, 0.0), (1.0, 0.0), (0.3, 0.5), (1.0, 1.0)] {
            for cos_o in [0.01, 0.1, 0.3, 0.7, 1.0] {
                for max_cos_i in [0.05, 0.4, 1.0] {
                    let (mut shape, mut sheen) = ([0.0_f64; 2], 0.0_f64);
                    for (i, j) in (0..=200).flat_map(|i| (0..=40).map(move |j| (i, j))) {
                        let cos_i = max_cos_i * f64::from(i) / 200.0;
                        let azimuth = std::f64::consts::PI * f64::from(j) / 40.0;
                        let along = cos_o * cos_i + sine(cos_o) * sine(cos_i) * azimuth.cos();
                        let cos_d = (0.5 * (1.0 + along)).max(0.0).sqrt();
                        let r = 2.0 * f64::from(roughness) * cos_d * cos_d;
                        let (o, i) = (grazing(cos_o), grazing(cos_i));
                        let b = (1.0 - 0.5 * o) * (1.0 - 0.5 * i) + r * (o + i + o * i * (r - 1.0));
                        let (f, half) = (f64::from(flatness), 0.5 * r - 1.0);
                        let e = (1.0 + half * o) * (1.0 + half * i);
                        let e = 1.25 * (e * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
                        let b = (1.0 - f) * b + f * e;
                        shape = [shape[0].max(b), shape[1].max(b * cos_i)];
                        sheen = sheen.max(grazing(cos_d));
                    }
                    let bound = upper_shape(roughness, flatness, cos_o, max_cos_i);
                    // Without flatness the second bound is not checked.
                    for (factor, limit) in [(0, 1.6), (1, if flatness > 0.0 { 1.9 } else { f64::INFINITY })] {
                        let (bound, largest) = (bound[factor], shape[factor]);
                        let what = || format!("{roughness} {flatness} {cos_o} {max_cos_i} {factor}");
                        assert!(largest <= bound * (1.0 + 1e-9), "{}: {largest} above {bound}", what());
                        assert!(bound <= limit * largest, "{}: {bound} for {largest}", what());
                    }
                    let bound = upper_sheen(cos_o);
                    assert!(sheen <= bound * (1.0 + 1e-9), "{cos_o}: {sheen} above {bound}");
                    assert!(bound <= 1.01 * sheen + 1e-9, "{cos_o}: {bound} for {sheen}");
                }
            }
        }
    }
}
