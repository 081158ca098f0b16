//! Flights through a medium whose density varies, by null collisions.
//!
//! Where the extinction `σ_k(x)` of channel `k` is nowhere above a majorant `μ`, the medium is
//! filled up with transparent matter, until it has the extinction `μ` everywhere and for all
//! channels. Collisions with both are drawn as in a homogeneous medium, and each of them is real or
//! null (Woodcock et al. 1965). A path of weights `β_k` has a real one with probability
//!
//! ```text
//! P = Σ_k β_k σ_k(x) / (μ Σ_k β_k)
//! real: it is scattered here, β_k ← β_k σ_s,k(x) / (μ P)
//! null: it goes on,           β_k ← β_k (μ − σ_k(x)) / (μ (1 − P))
//! ```
//!
//! **Why it is unbiased for every channel.** Whether a collision is real or null, the weight of
//! each channel is multiplied by its own share of that outcome, `σ_k/μ` or `1 − σ_k/μ`, over the
//! probability of the outcome, which is the same for all. So the mean weight `W_k(t)` of paths that
//! have come as far as `t` loses `μ W_k dt` to collisions and gets back `(μ − σ_k) W_k dt`:
//!
//! ```text
//! dW_k/dt = −σ_k W_k          W_k(t) = β_k exp(−∫₀ᵗ σ_k)          scattered in dt: σ_s,k W_k dt
//! ```
//!
//! Nothing that a channel needs is out of reach: `P = 0` only where no channel that has weight is
//! extinguished, and `P = 1` only where all are by `μ`. `Σ β` stays as it is at null collisions and
//! does not grow at real ones.
//!
//! The mixture is the one that `flight` draws from where the medium is homogeneous: with one
//! channel `c` drawn by `q_c ∝ β_c` and all its collisions decided by `σ_c/μ`, the weight by the
//! density of all channels together is `β_k Π n_k σ_s,k / Σ_c q_c Π n_c σ_c`, `n = μ − σ`. The
//! exponentials, which are not known here, are the same for all and cancel (Miller et al. 2019).
//! The probabilities above are the marginal ones of that mixture (Kutz et al. 2017), so that no
//! channel is drawn at all.
//!
//! **Transmittance** is a mean of products over the collisions of a flight, of which none is real.
//! If a part `c_k` of the extinction is present everywhere, products are needed for the rest only
//! (Novák et al. 2014):
//!
//! ```text
//! T_k = exp(−∫ c_k) Π_i (1 − (σ_k(x_i) − c_k) / μ)          μ ≥ σ_k − c_k
//! ```
//!
//! so that a density which is constant over a block of cells takes no draw there. Small products
//! end by Russian roulette.
//!
//! Majorants, and `c`, are those of the blocks of [`Density::walk`]. The rest of a flight at the
//! end of a block goes on in the next, as exponential distances have no memory.
//!
//! # Held to this by
//! The tests below; the suite's `grid_media`.

use super::flight::{Flight, sum};
use crate::color::Rgb;
use crate::math::Ray;
use crate::math::elementary::{exp, ln};
use crate::rng::Stream;
use crate::scene::{Density, Medium};

/// Product below which Russian roulette may end a flight.
const SMALL: f32 = 0.1;
/// Survival probability of Russian roulette.
const SURVIVAL: f32 = 0.5;

/// Draws the flight of a path, as `flight::fly`.
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
            // Densities may be far below a majorant: shares are compared with 53 random bits.
            if stream.uniform_f64() < f64::from(real) {
                // Rounding must not overstep surfaces.
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

/// A random number whose mean is the transmittance, by channel.
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

/// An exponential number of mean 1: the free path to the next collision, in mean free paths.
fn free_flight(stream: &mut Stream) -> f64 {
    f64::from(-ln(1.0 - stream.uniform()))
}

/// Place of the next collision before `to`; if there is none, `free` becomes the rest of the
/// flight.
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
    /// Place of a sample; values are linear between samples.
    const KINK: f64 = 18.5 / 24.0;

    /// A grid in the unit cube that varies along `x` by `value`.
    fn along_x(value: impl Fn(f64) -> [f64; 3]) -> VolumeGrid {
        let values = (0..CELLS * 4).map(|i| value((f64::from(i % CELLS) + 0.5) / f64::from(CELLS)));
        let values = VolumeValues::Colors(values.map(|v| Rgb::from(v.map(|v| v as f32))).collect());
        let (samples, edges) = (VolumeSamples::Centers, VolumeEdges::Held);
        let data = VolumeData { counts: [CELLS, 2, 2], values, to_world: DAffine3::IDENTITY, samples, edges };
        VolumeGrid::new(data, &Location::default()).unwrap()
    }

    /// A medium with the closed form of its grids.
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

    /// 0 and 5 by turns, linear between.
    fn zigzag(x: f64) -> f64 {
        let at = x * f64::from(CELLS) - 0.5;
        let (below, share) = (at.floor(), at - at.floor());
        5.0 * if below as i64 % 2 == 0 { share } else { 1.0 - share }
    }

    /// Densities that are linear, that differ by channel, that leave half of the box empty, that
    /// are the same everywhere, and that let little pass; albedos that are linear.
    fn cases() -> Vec<Case> {
        vec![
            case(|x| [3.0 * x; 3], None),
            case(|x| [2.0 - 2.0 * x, 0.5 + x, 1.5 * x], None),
            case(|x| [24.0 * (x - KINK).max(0.0); 3], Some(|x| [x, 1.0 - x, 0.5])),
            case(|_| [1.0; 3], None),
            case(|x| [zigzag(x); 3], None),
        ]
    }

    /// Shares scattered before `half`, scattered from there to `end`, and passed to `end`, by
    /// channel.
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
        // Steps of the sum are 5·10⁻⁶ m long; at the end of a density the sum is off by up to a
        // step.
        assert!(
            off <= 4.9 * m.standard_error() + 1e-4 * expected,
            "{what}: {} ± {} for {expected}",
            m.mean(),
            m.standard_error()
        );
    }

    /// Mean weights of paths that pass, and that are scattered in the first and in the second part
    /// of the way, in every channel, from within the box and from before it. 5 media, 2 ways, 9
    /// means: at 4.9 standard errors one false alarm in 10,000 runs.
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

    /// Transmittance by residual ratio tracking; even densities take no draw. 5 media, 2 ways, 3
    /// channels: at 4.9 standard errors one false alarm in 30,000 runs.
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
