//! Directions of caustics at one place: a density over directions, and draws from it.

use crate::math::elementary::{exp, ln, sin_cos};
use crate::math::{Frame, Vec3};

/// Exponent beyond which a kernel counts as zero.
const FARTHEST: f32 = 20.0;
/// Largest share of the directions of a path that are drawn from caustics.
const MOST: f32 = 0.5;

/// A mixture of kernels on the sphere, one for each photon near by:
///
/// ```text
/// p(ω) = Σ_i w_i / (2π σ_i² (1 − e^{−2/σ_i²})) · e^{−|ω − ω_i|² / 2σ_i²}        Σ w_i = 1
/// ```
///
/// (von Mises, Fisher 1953), of spread `σ` around the directions `ω_i`.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    kernels: Vec<Kernel>,
    weight: f32,
    weighted_share: f32,
    /// Numbers of the photons near by; the memory is reused.
    pub(super) near: Vec<usize>,
}

#[derive(Clone, Copy, Debug)]
struct Kernel {
    towards: Vec3,
    /// `σ²`.
    square: f32,
    /// The factor before the exponential, without the weight (sr⁻¹).
    peak: f32,
    /// Unnormalised weight: luminance of the photon's intensity (W·sr⁻¹).
    weight: f32,
}

impl Directions {
    /// Removes all kernels.
    pub fn clear(&mut self) {
        self.kernels.clear();
        self.weight = 0.0;
        self.weighted_share = 0.0;
    }

    /// Adds the kernel of a photon; `share` is the share of caustics in the flux around the photon.
    pub(super) fn add(&mut self, towards: Vec3, spread: f32, weight: f32, share: f32) {
        let square = spread * spread;
        let peak = 1.0 / (std::f32::consts::TAU * square * (1.0 - exp(-2.0 / square)));
        self.kernels.push(Kernel { towards, square, peak, weight });
        self.weight += weight;
        self.weighted_share += weight * share;
    }

    /// Returns the share of a path's directions that is to be drawn from these kernels: zero if
    /// there are none, and half where all light is of caustics. Chosen.
    pub fn share(&self) -> f32 {
        if self.weight > 0.0 { MOST * (self.weighted_share / self.weight).sqrt() } else { 0.0 }
    }

    /// Draws a unit direction from three uniform numbers; `None` if there are no kernels.
    pub fn sample(&self, [u, v, w]: [f32; 3]) -> Option<Vec3> {
        let mut left = u * self.weight;
        let drawn = self.kernels.iter().find(|kernel| {
            left -= kernel.weight;
            left < 0.0
        });
        let kernel = drawn.or(self.kernels.last())?;
        // 1 − cos θ.
        let t = -kernel.square * ln(1.0 - v * (1.0 - exp(-2.0 / kernel.square)));
        let (sin, cos) = sin_cos(std::f32::consts::TAU * w);
        let radius = (t * (2.0 - t)).max(0.0).sqrt();
        let local = Vec3::new(radius * cos, radius * sin, 1.0 - t);
        Some(Frame::about(kernel.towards).to_world(local).normalize())
    }

    /// Returns the density with which a unit direction is drawn (sr⁻¹).
    pub fn density(&self, direction: Vec3) -> f32 {
        let of_kernel = |kernel: &Kernel| {
            let exponent = kernel.towards.distance_squared(direction) / (2.0 * kernel.square);
            if exponent < FARTHEST { kernel.weight * kernel.peak * exp(-exponent) } else { 0.0 }
        };
        if self.weight > 0.0 { self.kernels.iter().map(of_kernel).sum::<f32>() / self.weight } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    fn two() -> Directions {
        let mut directions = Directions::default();
        directions.add(Vec3::Z, 0.3, 1.0, 1.0);
        directions.add(Vec3::new(0.6, 0.0, 0.8), 0.01, 3.0, 1.0);
        directions
    }

    /// Samples have the stated density: the mean of its reciprocal over samples, counting only
    /// those within a chord `c` of a direction, is the solid angle `π c²` of that cone. The share
    /// of samples near the direction of a kernel is the kernel's share of the weight.
    #[test]
    fn samples_have_the_density() {
        let directions = two();
        let mut s = Stream::new(1, Purpose::Test, 0);
        const SAMPLES: u32 = 200_000;
        const CHORD: f32 = 0.02;
        let (mut solid_angle, mut inside) = (0.0_f64, 0);
        for _ in 0..SAMPLES {
            let direction = directions.sample(s.uniform_3()).unwrap();
            if direction.distance(Vec3::new(0.6, 0.0, 0.8)) < CHORD {
                solid_angle += 1.0 / f64::from(directions.density(direction)) / f64::from(SAMPLES);
                inside += 1;
            }
        }
        let expected = std::f64::consts::PI * f64::from(CHORD * CHORD);
        assert!((solid_angle / expected - 1.0).abs() < 0.05, "{solid_angle} of {expected}");
        // The narrow kernel has three quarters of the weight, of which `1 − e^{−2}` is within the
        // chord. The wide kernel adds next to nothing.
        let share = f64::from(inside) / f64::from(SAMPLES);
        assert!((share - 0.75 * 0.8647).abs() < 0.01, "{share}");
    }

    #[test]
    fn nothing_is_drawn_from_nothing() {
        let nothing = Directions::default();
        assert_eq!((nothing.share(), nothing.density(Vec3::Z)), (0.0, 0.0));
        assert_eq!(nothing.sample([0.5; 3]), None);
    }
}
