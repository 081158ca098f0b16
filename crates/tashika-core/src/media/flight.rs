//! Free flight of a path in a medium up to its next scattering.
//!
//! Let `β` be the weight of a path (by channel). The path draws one channel `c` with probability
//! `q_c = β_c / Σ β`, as in Chiang et al. 2016, and a distance by the extinction of that channel,
//! `t = −ln(1 − u) / σ_c`. As with the hero wavelengths of Wilkie et al. 2014, the weight is
//! divided by the density of all channels together, which is the balance heuristic over the choice
//! of channel:
//!
//! ```text
//! scattered at t < d     β'_k = β_k σ_s,k T_k(t) / Σ_c q_c σ_t,c T_c(t)
//! goes on to d           β'_k = β_k T_k(d)       / Σ_c q_c T_c(d)              T_k(t) = exp(−σ_t,k t)
//! ```
//!
//! Where the density varies, flights with null collisions replace these formulas
//! ([`null_collisions`]); the rest is the same.
//!
//! # Guarantee
//! Both outcomes are unbiased for every channel whose weight is not zero. `Σ β` never grows, since
//! `Σ_k β_k T_k = Σ β · Σ_c q_c T_c` and `σ_s ≤ σ_t`. Therefore no channel's weight exceeds three
//! times the largest channel of the camera's weight, however colourful the media are. If all
//! channels are equal, scattering multiplies the weight by the albedo `σ_s / σ_t`, and passing
//! leaves it unchanged. A medium that does not scatter takes no draw: its transmittance is a
//! factor.
//!
//! # Held to this by
//! The tests below; the suite's `media`.

use super::null_collisions;
use crate::color::Rgb;
use crate::math::Ray;
use crate::math::elementary::ln;
use crate::rng::Stream;
use crate::scene::Medium;

/// Highest survival probability of Russian roulette after a scattering in a medium. Without this
/// limit, media that absorb nothing would keep a path for ever.
pub const MAX_SURVIVAL_IN_MEDIUM: f32 = 0.999;

/// Outcome of a path's flight to the next surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flight {
    /// The path is scattered before the surface.
    Scattered {
        /// Distance to the scattering (m).
        after: f32,
        /// Weight of the path after the scattering.
        weight: Rgb,
    },
    /// The path reaches the surface.
    Passed {
        /// Weight of the path at the surface.
        weight: Rgb,
    },
}

/// Draws the flight of a path over `distance` metres of `ray`, all in one medium. `weight` must not
/// be black. The distance is infinite if the ray meets no surface.
pub fn fly(medium: &Medium, weight: Rgb, ray: &Ray, distance: f32, stream: &mut Stream) -> Flight {
    if !medium.scatters() {
        return Flight::Passed { weight: weight * transmittance(medium, ray, distance, stream) };
    }
    if let Some(density) = medium.density() {
        return null_collisions::fly((medium, density), weight, ray, distance, stream);
    }
    let extinction = medium.extinction();
    let chances = weight / (weight.r + weight.g + weight.b);
    let u = stream.uniform();
    let channel = if u < chances.r {
        0
    } else if u < chances.r + chances.g || chances.b == 0.0 {
        // Because of rounding, `u` may belong to no channel.
        if chances.g > 0.0 { 1 } else { 0 }
    } else {
        2
    };
    let sigma = extinction[channel];
    let after = if sigma > 0.0 { -ln(1.0 - stream.uniform()) / sigma } else { f32::INFINITY };
    if after < distance {
        let arrives = medium.transmittance(after);
        let density = sum(chances * extinction * arrives);
        let scattering = medium.scattering_at(ray.at(after).as_dvec3(), Rgb::WHITE);
        Flight::Scattered { after, weight: weight * scattering * arrives / density }
    } else {
        let arrives = medium.transmittance(distance);
        Flight::Passed { weight: weight * arrives / sum(chances * arrives) }
    }
}

/// Transmittance of `distance` metres of `ray`, all in one medium, by channel. If the density
/// varies, the result is random, and its mean is the transmittance.
pub fn transmittance(medium: &Medium, ray: &Ray, distance: f32, stream: &mut Stream) -> Rgb {
    match medium.density() {
        None => medium.transmittance(distance),
        Some(density) => null_collisions::transmittance((medium, density), ray, distance, stream),
    }
}

pub(super) fn sum(c: Rgb) -> f32 {
    c.r + c.g + c.b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::HenyeyGreenstein;
    use crate::math::Vec3;
    use crate::rng::Purpose;
    use crate::stats::Moments;

    fn medium(absorption: [f32; 3], scattering: [f32; 3]) -> Medium {
        let [absorption, scattering] = [absorption, scattering].map(|[r, g, b]| Rgb::new(r, g, b));
        let phase = HenyeyGreenstein::default();
        Medium { name: String::new(), absorption, scattering, phase, variation: None }
    }

    const RAY: Ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, t_max: f32::INFINITY };

    /// The mean weight of paths that pass is the transmittance; the mean weight of scattered paths
    /// is the albedo times the complement. The same holds for paths that are scattered in the first
    /// half of the distance. All means are checked in every channel and for two initial weights. 3
    /// media, 2 weights, 9 means: at 4.5 standard errors one false alarm in 2,700 runs.
    #[test]
    fn every_channel_is_extinguished_by_its_own_coefficients() {
        let media = [
            medium([0.1, 0.2, 0.0], [0.5, 1.0, 4.0]),
            medium([0.3; 3], [0.6; 3]),
            // The first channel is not extinguished at all, the second is only absorbed.
            medium([0.0, 1.5, 0.1], [0.0, 0.0, 2.0]),
        ];
        let distance = 0.8;
        for (number, m) in media.iter().enumerate() {
            for before in [Rgb::WHITE, Rgb::new(0.1, 2.0, 0.5)] {
                let mut stream = Stream::new(5, Purpose::Test, number as u64);
                let mut moments = [[Moments::default(); 3]; 3];
                for _ in 0..40_000 {
                    let (mut passed, mut near, mut far) = (Rgb::BLACK, Rgb::BLACK, Rgb::BLACK);
                    match fly(m, before, &RAY, distance, &mut stream) {
                        Flight::Passed { weight } => passed = weight,
                        Flight::Scattered { after, weight } if after < 0.5 * distance => near = weight,
                        Flight::Scattered { after, weight } => {
                            assert!(after < distance);
                            far = weight;
                        }
                    }
                    assert!(sum(passed + near + far) <= sum(before) * 1.00001, "weights never grow");
                    for (m, found) in moments.iter_mut().zip([passed, near, far]) {
                        m.iter_mut().zip(found.to_array()).for_each(|(m, v)| m.push(f64::from(v)));
                    }
                }
                let (half, whole) = (m.transmittance(0.5 * distance), m.transmittance(distance));
                for k in 0..3 {
                    let sigma = m.extinction()[k];
                    let albedo = if sigma > 0.0 { m.scattering[k] / sigma } else { 0.0 };
                    let shares = [whole[k], albedo * (1.0 - half[k]), albedo * (half[k] - whole[k])];
                    for (m, share) in moments.iter().zip(shares) {
                        let (m, expected) = (&m[k], f64::from(before[k] * share));
                        let off = (m.mean() - expected).abs();
                        let bound = 4.5 * m.standard_error() + 1e-5 * expected;
                        assert!(off <= bound, "{number}, {k}: {} for {expected}", m.mean());
                    }
                }
            }
        }
    }

    #[test]
    fn what_scatters_nothing_is_a_factor_and_what_is_gray_keeps_its_weight() {
        let mut stream = Stream::new(1, Purpose::Test, 0);
        let dark = medium([1.0, 2.0, 0.0], [0.0; 3]);
        let passed = Flight::Passed { weight: dark.transmittance(0.7) * 0.5 };
        assert_eq!(fly(&dark, Rgb::gray(0.5), &RAY, 0.7, &mut stream), passed);
        let gray = medium([0.0; 3], [3.0; 3]);
        for distance in [0.1, 1.0, f32::INFINITY] {
            for _ in 0..1000 {
                let (Flight::Passed { weight } | Flight::Scattered { weight, .. }) =
                    fly(&gray, Rgb::gray(0.5), &RAY, distance, &mut stream);
                assert!((weight.r - 0.5).abs() < 1e-6 && weight.r == weight.b, "{weight:?}");
            }
        }
    }
}
