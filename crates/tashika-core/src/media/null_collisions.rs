//! Flights through a medium of varying density, by null collisions.
//!
//! Let `μ` be a majorant: the extinction `σ_k(x)` of each channel `k` is at most `μ` everywhere.
//! Fictitious transparent matter is added to the medium, until its extinction is `μ` everywhere and
//! in all channels. Collisions with both kinds of matter are drawn as in a homogeneous medium. Each
//! of them is then either real or null (Woodcock et al. 1965). A path of weights `β_k` has a real
//! collision with probability
//!
//! ```text
//! P = Σ_k β_k σ_k(x) / (μ Σ_k β_k)
//! real: it is scattered here, β_k ← β_k σ_s,k(x) / (μ P)
//! null: it goes on,           β_k ← β_k (μ − σ_k(x)) / (μ (1 − P))
//! ```
//!
//! **Why it is unbiased for every channel.** Whether a collision is real or null, the weight of
//! each channel is multiplied by that channel's share of the outcome, `σ_k/μ` or `1 − σ_k/μ`, and
//! divided by the probability of the outcome, which is common to all channels. Let `W_k(t)` be the
//! mean weight of paths that have reached the distance `t`. Over `dt` it loses `μ W_k dt` to
//! collisions and regains `(μ − σ_k) W_k dt` from the null ones:
//!
//! ```text
//! dW_k/dt = −σ_k W_k          W_k(t) = β_k exp(−∫₀ᵗ σ_k)          scattered in dt: σ_s,k W_k dt
//! ```
//!
//! No outcome that a channel needs has probability zero: `P = 0` only where the extinction is zero
//! in all channels with weight, and `P = 1` only where it is `μ` in all of them. `Σ β` does not
//! change at null collisions and does not grow at real ones.
//!
//! If the medium is homogeneous, the distribution is the mixture that `flight` draws from. Suppose
//! that one channel `c` is drawn with `q_c ∝ β_c`, and that `σ_c/μ` decides all its collisions. The
//! weight by the density of all channels together is then `β_k Π n_k σ_s,k / Σ_c q_c Π n_c σ_c`,
//! with `n = μ − σ`. The exponentials, which are unknown here, are the same for all channels and
//! cancel (Miller et al. 2019). The probabilities above are the marginal ones of that mixture (Kutz
//! et al. 2017), so that no channel has to be drawn.
//!
//! **Transmittance** is the mean of a product over the collisions of a flight, where each factor is
//! the probability that the collision is null. If a part `c_k` of the extinction is present
//! everywhere, products are needed only for the rest (Novák et al. 2014):
//!
//! ```text
//! T_k = exp(−∫ c_k) Π_i (1 − (σ_k(x_i) − c_k) / μ)          μ ≥ σ_k − c_k
//! ```
//!
//! Therefore no draw is needed where the density is constant over a block of cells. Russian
//! roulette ends small products.
//!
//! The majorant and `c` are those of each block of [`Density::walk`]. At the end of a block, the
//! rest of the flight continues in the next one, as exponential distances have no memory.
//!
//! # Held to this by
//! The tests below; the suite's `grid_media`.

use super::flight::{Flight, sum};
use crate::color::Rgb;
use crate::math::Ray;
use crate::math::elementary::{exp, ln};
use crate::rng::Stream;
use crate::scene::{Density, Medium};

/// Product below which Russian roulette is applied.
const SMALL: f32 = 0.1;
/// Survival probability of Russian roulette.
const SURVIVAL: f32 = 0.5;

/// Draws the flight of a path, like `flight::fly`.
pub(super) fn fly(
    (medium, density): (&Medium, &Density),
    mut weight: Rgb,
    ray: &Ray,
    distance: f32,
    stream: &mut Stream,
) -> Flight {
    let cells = density.ray(ray);
    let extinction = medium.extinction();
    let mut free = free_flight(stream);
    for span in density.walk(&cells, f64::from(distance)) {
        let majorant = (extinction * span.most).max_channel();
        let mut at = span.from;
        while let Some(collision) = collision(&mut free, &mut at, span.to, majorant) {
            let factor = density.at(cells.at(collision));
            let share = extinction * factor * majorant.recip();
            let real = sum(weight * share) / sum(weight);
            // Real extinction may be far below the majorant, so the probability is compared with 53
            // random bits.
            if stream.uniform_f64() < f64::from(real) {
                // Rounding must not put the collision beyond the surface.
                let after = (collision as f32).min(distance.next_down());
                let place = ray.origin.as_dvec3() + ray.direction.as_dvec3() * collision;
                let scattered = medium.scattering_at(place, factor) * majorant.recip();
                return Flight::Scattered { after, weight: weight * scattered / real };
            }
            weight = weight * share.map(|share| (1.0 - share).max(0.0)) / (1.0 - real);
            free = free_flight(stream);
        }
    }
    Flight::Passed { weight }
}

/// Returns a random number, by channel, whose mean is the transmittance.
pub(super) fn transmittance(
    (medium, density): (&Medium, &Density),
    ray: &Ray,
    distance: f32,
    stream: &mut Stream,
) -> Rgb {
    let cells = density.ray(ray);
    let extinction = medium.extinction();
    let (mut left, mut depth) = (Rgb::WHITE, Rgb::BLACK);
    let mut free = free_flight(stream);
    for span in density.walk(&cells, f64::from(distance)) {
        let even = extinction * span.least;
        depth += even * (span.to - span.from) as f32;
        let majorant = (extinction * (span.most - span.least)).max_channel();
        let mut at = span.from;
        while let Some(collision) = collision(&mut free, &mut at, span.to, majorant) {
            let rest = extinction * density.at(cells.at(collision)) - even;
            left *= rest.map(|rest| 1.0 - rest / majorant);
            if left.max_channel() < SMALL {
                if stream.uniform() >= SURVIVAL {
                    return Rgb::BLACK;
                }
                left = left / SURVIVAL;
            }
            free = free_flight(stream);
        }
    }
    left * depth.map(|depth| exp(-depth))
}

/// An exponentially distributed number of mean 1: the free path to the next collision, in mean free
/// paths.
fn free_flight(stream: &mut Stream) -> f64 {
    f64::from(-ln(1.0 - stream.uniform()))
}

/// Distance of the next collision before `to`. If there is none, `free` is reduced to the rest of
/// the flight.
fn collision(free: &mut f64, at: &mut f64, to: f64, majorant: f32) -> Option<f64> {
    let majorant = f64::from(majorant);
    let room = majorant * (to - *at);
    if *free >= room {
        *free -= room;
        return None;
    }
    *at += *free / majorant;
    Some(*at)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::flight;
    use super::*;
    use crate::bsdf::HenyeyGreenstein;
    use crate::error::Location;
    use crate::math::elementary::exp_f64;
    use crate::math::{DAffine3, Vec3};
    use crate::rng::Purpose;
    use crate::scene::{
        Scattered, Variation, VolumeData, VolumeEdges, VolumeGrid, VolumeSamples, VolumeValues,
    };
    use crate::stats::Moments;

    const CELLS: u32 = 24;
    /// Position of a sample; values are interpolated linearly between samples.
    const KINK: f64 = 18.5 / 24.0;

    /// A grid in the unit cube whose values depend on `x` by `value`.
    fn along_x(value: impl Fn(f64) -> [f64; 3]) -> VolumeGrid {
        let values = (0..CELLS * 4).map(|i| value((f64::from(i % CELLS) + 0.5) / f64::from(CELLS)));
        let values = VolumeValues::Colors(values.map(|v| Rgb::from(v.map(|v| v as f32))).collect());
        let (samples, edges) = (VolumeSamples::Centers, VolumeEdges::Held);
        let data = VolumeData { counts: [CELLS, 2, 2], values, to_world: DAffine3::IDENTITY, samples, edges };
        VolumeGrid::new(data, &Location::default()).unwrap()
    }

    /// A medium, and the closed form of its grids.
    struct Case {
        medium: Medium,
        /// Extinction and scattering at `x`, by channel.
        at: Box<dyn Fn(f64) -> [[f64; 3]; 2]>,
    }

    const ABSORPTION: [f64; 3] = [0.2, 0.5, 0.0];
    const SCATTERING: [f64; 3] = [1.0, 2.0, 6.0];

    fn case(density: impl Fn(f64) -> [f64; 3] + 'static, albedo: Option<fn(f64) -> [f64; 3]>) -> Case {
        let grids = [Some(along_x(&density)), albedo.map(along_x)];
        let [density_grid, albedo_grid] = grids;
        let scattered = albedo_grid.map_or(Scattered::Evenly, Scattered::Albedo);
        let [absorption, scattering] = [ABSORPTION, SCATTERING].map(|c| Rgb::from(c.map(|v| v as f32)));
        let medium = Medium {
            name: String::new(),
            absorption,
            scattering,
            phase: HenyeyGreenstein::default(),
            variation: Some(Arc::new(Variation::new(density_grid, scattered))),
        };
        let at = move |x: f64| {
            let within = x.clamp(0.5 / f64::from(CELLS), 1.0 - 0.5 / f64::from(CELLS));
            let factor = if (0.0..=1.0).contains(&x) { density(within) } else { [0.0; 3] };
            let extinction = [0, 1, 2].map(|k| (ABSORPTION[k] + SCATTERING[k]) * factor[k]);
            let scattered = [0, 1, 2].map(|k| match albedo {
                Some(albedo) => extinction[k] * albedo(within)[k],
                None => SCATTERING[k] * factor[k],
            });
            [extinction, scattered]
        };
        Case { medium, at: Box::new(at) }
    }

    /// Alternates between 0 and 5 at the samples, linear between them.
    fn zigzag(x: f64) -> f64 {
        let at = x * f64::from(CELLS) - 0.5;
        let (below, share) = (at.floor(), at - at.floor());
        5.0 * if below as i64 % 2 == 0 { share } else { 1.0 - share }
    }

    /// Five media: linear density; densities that differ by channel; half of the box empty, with
    /// linear albedos; constant density; and a dense zigzag.
    fn cases() -> Vec<Case> {
        vec![
            case(|x| [3.0 * x; 3], None),
            case(|x| [2.0 - 2.0 * x, 0.5 + x, 1.5 * x], None),
            case(|x| [24.0 * (x - KINK).max(0.0); 3], Some(|x| [x, 1.0 - x, 0.5])),
            case(|_| [1.0; 3], None),
            case(|x| [zigzag(x); 3], None),
        ]
    }

    /// Expected shares, by channel, of paths that are scattered before `half`, scattered between
    /// `half` and `end`, or reach `end`.
    fn shares(case: &Case, from: f64, [half, end]: [f64; 2]) -> [[f64; 3]; 3] {
        let steps = 200_000;
        let step = end / f64::from(steps);
        let (mut depth, mut near, mut far) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for i in 0..steps {
            let t = (f64::from(i) + 0.5) * step;
            let [extinction, scattering] = (case.at)(from + t);
            for k in 0..3 {
                let scattered = scattering[k] * step * exp_f64(-depth[k] - 0.5 * extinction[k] * step);
                if t < half {
                    near[k] += scattered
                } else {
                    far[k] += scattered
                }
                depth[k] += extinction[k] * step;
            }
        }
        [near, far, depth.map(|depth| exp_f64(-depth))]
    }

    #[track_caller]
    fn assert_mean(m: &Moments, expected: f64, what: &str) {
        let off = (m.mean() - expected).abs();
        // The integration steps are 5·10⁻⁶ m long. At a jump of the density the numerical integral
        // is off by up to one step.
        assert!(
            off <= 4.9 * m.standard_error() + 1e-4 * expected,
            "{what}: {} ± {} for {expected}",
            m.mean(),
            m.standard_error()
        );
    }

    /// Mean weights of paths that are scattered in the first part of the way, scattered in the
    /// second part, or pass, in every channel. Rays start inside the box or outside. All means
    /// equal the integrals. 5 media, 2 ways, 9 means: at 4.9 standard errors one false alarm in
    /// 10,000 runs.
    #[test]
    fn flights_are_those_of_the_integral_for_every_channel() {
        for (number, case) in cases().iter().enumerate() {
            for (before, from, end) in [(Rgb::WHITE, 0.1, 0.7), (Rgb::new(0.1, 2.0, 0.5), -0.5, 2.0)] {
                let ray = Ray::new(Vec3::new(from as f32, 0.4, 0.5), Vec3::X);
                let half = 0.6 * end;
                let expected = shares(case, from, [half, end]);
                let mut stream = Stream::new(6, Purpose::Test, number as u64);
                let mut moments = [[Moments::default(); 3]; 3];
                for _ in 0..60_000 {
                    let mut found = [Rgb::BLACK; 3];
                    match flight::fly(&case.medium, before, &ray, end as f32, &mut stream) {
                        Flight::Passed { weight } => found[2] = weight,
                        Flight::Scattered { after, weight } => {
                            assert!(after < end as f32);
                            found[usize::from(f64::from(after) >= half)] = weight;
                        }
                    }
                    let all = sum(found[0] + found[1] + found[2]);
                    assert!(all <= sum(before) * 1.0001, "weights never grow");
                    for (m, found) in moments.iter_mut().zip(found) {
                        m.iter_mut().zip(found.to_array()).for_each(|(m, v)| m.push(f64::from(v)));
                    }
                }
                for (part, name) in ["near", "far", "passed"].into_iter().enumerate() {
                    for k in 0..3 {
                        let what = format!("case {number}, from {from}, {name}, channel {k}");
                        assert_mean(&moments[part][k], expected[part][k] * f64::from(before[k]), &what);
                    }
                }
            }
        }
    }

    /// Mean transmittance by residual ratio tracking equals the integral; constant densities take
    /// no draw. 5 media, 2 ways, 3 channels: at 4.9 standard errors one false alarm in 30,000 runs.
    #[test]
    fn transmittance_is_that_of_the_integral_for_every_channel() {
        for (number, case) in cases().iter().enumerate() {
            for (from, end) in [(0.1, 0.7), (-0.5, 2.0)] {
                let ray = Ray::new(Vec3::new(from as f32, 0.4, 0.5), Vec3::X);
                let [_, _, expected] = shares(case, from, [end, end]);
                let mut stream = Stream::new(7, Purpose::Test, number as u64);
                let mut moments = [Moments::default(); 3];
                for _ in 0..60_000 {
                    let t = flight::transmittance(&case.medium, &ray, end as f32, &mut stream);
                    moments.iter_mut().zip(t.to_array()).for_each(|(m, v)| m.push(f64::from(v)));
                }
                for k in 0..3 {
                    assert_mean(
                        &moments[k],
                        expected[k],
                        &format!("case {number}, from {from}, channel {k}"),
                    );
                }
                if number == 3 {
                    assert!(moments.iter().all(|m| m.standard_error() < 1e-6), "even densities are drawn");
                }
            }
        }
    }

    #[test]
    fn what_is_beside_the_grid_is_not_met() {
        let case = &cases()[0];
        let beside = Ray::new(Vec3::new(-0.5, 1.01, 0.5), Vec3::X);
        let before = Ray::new(Vec3::new(-0.5, 0.5, 0.5), Vec3::X);
        let mut stream = Stream::new(8, Purpose::Test, 0);
        for (ray, distance) in [(beside, f32::INFINITY), (before, 0.5)] {
            let weight = Rgb::new(0.1, 0.2, 0.3);
            let passed = flight::fly(&case.medium, weight, &ray, distance, &mut stream);
            assert_eq!(passed, Flight::Passed { weight });
            assert_eq!(flight::transmittance(&case.medium, &ray, distance, &mut stream), Rgb::WHITE);
        }
    }
}
