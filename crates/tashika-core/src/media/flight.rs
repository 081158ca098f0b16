//! Free flight of a path in a medium until it is scattered.
//!
//! A path of weight `β` (by channel) draws one channel `c` with probability `q_c = β_c / Σ β`, as
//! Chiang et al. 2016 do, and a distance by that channel's extinction, `t = −ln(1 − u) / σ_c`. As
//! with the hero wavelengths of Wilkie et al. 2014, the path is weighted by the density of all
//! channels together, the balance heuristic over the choice:
//!
//! ```text
//! scattered at t < d     β'_k = β_k σ_s,k T_k(t) / Σ_c q_c σ_t,c T_c(t)
//! goes on to d           β'_k = β_k T_k(d)       / Σ_c q_c T_c(d)              T_k(t) = exp(−σ_t,k t)
//! ```
//!
//! Where the density varies, free flights between null collisions take the place of these formulas
//! ([`null_collisions`]); the rest is the same.
//!
//! # Guarantee
//! Both outcomes are unbiased for every channel that has any weight. `Σ β` never grows, since
//! `Σ_k β_k T_k = Σ β · Σ_c q_c T_c` and `σ_s ≤ σ_t`: no weight exceeds three times the largest of
//! the camera's, however colourful the media are. Where all channels are alike the weight is
//! multiplied by the albedo `σ_s / σ_t`, or not at all. A medium that scatters nothing is not drawn
//! from: its transmittance is a factor.
//!
//! # Held to this by
//! The tests below; the suite's `media`.

use super::null_collisions;
use crate::color::Rgb;
use crate::math::Ray;
use crate::math::elementary::ln;
use crate::rng::Stream;
use crate::scene::Medium;

/// Highest survival probability of Russian roulette after a path is scattered in a medium: media
/// that absorb nothing would otherwise hold it for ever.
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

/// Draws the flight of a path of weight `weight`, not black, over `distance` metres of `ray`, all
/// in one medium. The distance is infinite where there is no surface.
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
        // Rounding may leave a rest that belongs to no channel.
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

/// Transmittance of `distance` metres of `ray`, all in one medium, by channel; where the density
/// varies, a random number whose mean it is.
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

    /// The mean weight of paths that pass is the transmittance, and that of scattered paths the
    /// albedo times the rest. The latter also holds for the first half of the way alone. All hold
    /// in every channel and for any weight before. 3 media, 2 weights, 9 means: at 4.5 standard
    /// errors one false alarm in 2,700 runs.
    #[test]
    fn every_channel_is_extinguished_by_its_own_coefficients() {
        let media = [
            medium([0.1, 0.2, 0.0], [0.5, 1.0, 4.0]),
            medium([0.3; 3], [0.6; 3]),
            // One channel passes freely, one is absorbed only.
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
