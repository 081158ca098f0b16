//! Estimates of all light at gather points without a sum over VPLs: a few emitters and VPLs are
//! drawn, and a path is followed.
//!
//! ```text
//! L = Σ_e emitter(e)/E  +  Σ_k VPL(u_k)/V  +  path        u_k = (k + u)/V
//! ```
//!
//! All draws at a gather point use the same distributions, those learned for its place
//! ([`Choices`](super::Choices)). Evenly spread numbers therefore give draws that are evenly spread
//! over the lights. An emitter is weighted against the path that may meet it by the balance
//! heuristic of several samples (Veach 1997, section 9.2).
//!
//! Draws from one set of VPLs do not show the variance over sets. If VPLs are independent, this
//! variance is at most the sum of their squared contributions. The draws estimate this sum:
//!
//! ```text
//! Σ_i c_i² = E [(c_k/p_k)² p_k]          VPL k is drawn with probability p_k and gives c_k
//! ```

use super::vertex::{Kernel, Vertex};
use super::{Arrives, Compensation, EmittersAt, LightingContext};
use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::gather::GatherPoint;
use crate::rng::{self, Purpose, Stream};
use crate::vpl::LightSample;

/// Numbers of lights that are drawn at a gather point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draws {
    /// Number of emitter samples; at least 1.
    pub emitters: u32,
    /// Number of VPLs that are drawn; may be 0.
    pub vpls: u32,
}

/// Uniform numbers of one gather point of a pixel, from an Owen-scrambled Sobol' sequence over all
/// of its gather points (Burley 2020), so that lights are spread evenly over the pixel.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    /// Number of the gather point within the sequence.
    index: u32,
    key: u64,
}

/// Maximum number of gather points of one sequence; further points begin another.
const LONGEST: u32 = 1 << 12;
/// Spacing of uniform numbers in single precision.
const STEP: f64 = 1.0 / (1u64 << 24) as f64;

impl Numbers {
    /// Returns the numbers of gather point `index` of a pixel; `key` distinguishes pixels.
    pub fn new(index: u32, key: u64) -> Self {
        Self { index: index % LONGEST, key: rng::key(key, Purpose::Cut, u64::from(index / LONGEST)) }
    }

    /// Returns the numbers of draw `k` of `draws`.
    fn of_draw(&self, k: u32, draws: u32) -> [f32; 4] {
        sobol_burley::sample_4d(self.index * draws + k, 0, self.key as u32)
    }

    /// Returns the numbers with which the path begins.
    fn of_path(&self) -> [f32; 4] {
        sobol_burley::sample_4d(self.index, 1, (self.key >> 32) as u32)
    }

    /// Returns the number from which all VPLs are drawn.
    fn of_vpls(&self) -> f32 {
        sobol_burley::sample(self.index, 0, (self.key >> 32) as u32)
    }
}

/// Adds random digits beyond single precision, which is too coarse to reach every light of a large
/// set.
fn precise(u: f32, stream: &mut Stream) -> f64 {
    f64::from(u) + STEP * stream.uniform_f64()
}

/// Light drawn at a gather point, and the numbers with which its path begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    pub draws: Draws,
    /// Radiance that arrived straight (W·m⁻²·sr⁻¹).
    pub straight: Rgb,
    /// Radiance that arrived through panes (W·m⁻²·sr⁻¹).
    pub through_panes: Rgb,
    /// Uniform numbers with which the path begins: three for its direction, the last for its
    /// kernel.
    pub of_path: [f32; 4],
}

/// Radiance from the lights drawn at a gather point (W·m⁻²·sr⁻¹).
struct Arrived {
    straight: Rgb,
    through_panes: Rgb,
    /// Estimated sum of squared contributions of all VPLs (luminance²).
    squares: f64,
}

impl Compensation<'_> {
    /// Returns an unbiased estimate of all light at a gather point (W·m⁻²·sr⁻¹), times the weight
    /// of the point.
    ///
    /// * `by_vpls`: the BSDF with which light of VPLs is scattered there; paths estimate the rest.
    /// * `key`: key for the decisions of rays at partly opaque surfaces.
    pub fn whole(
        &mut self,
        point: &GatherPoint,
        by_vpls: &Bsdf,
        draws: Draws,
        numbers: Numbers,
        key: u64,
        stream: &mut Stream,
    ) -> Rgb {
        let first = Vertex::first(point, self.lit.lights.map(|_| by_vpls));
        let Arrived { straight, through_panes, squares } = self.drawn(&first, draws, numbers, key, stream);
        let weight = f64::from(point.weight.luminance());
        self.squares_of_vpls = weight * weight * squares;
        let drawn = Drawn { draws, straight, through_panes, of_path: numbers.of_path() };
        self.from(first, point, Some(drawn), key, stream)
    }

    /// Draws lights at a gather point.
    fn drawn(
        &mut self,
        vertex: &Vertex,
        draws: Draws,
        numbers: Numbers,
        key: u64,
        stream: &mut Stream,
    ) -> Arrived {
        let receiver = vertex.receiver();
        self.look_for_caustics(&receiver);
        let LightingContext { emitters, choices, tracer, .. } = self.lit;
        let choice = choices.map(|choices| &choices.emitters);
        let emitters = EmittersAt::new(emitters, choice, &receiver);
        let of_emitters = draws.emitters as f32;
        let mut arrive = Vec::with_capacity((draws.emitters + draws.vpls) as usize);
        let kernels = [Kernel::Carried, Kernel::Rest];
        // Emitter samples that may be visible through panes, with the index in `arrive` of their
        // straight light.
        let mut behind: Vec<(LightSample, Option<usize>)> = Vec::new();
        for k in 0..draws.emitters {
            let [u, v @ .., _] = numbers.of_draw(k, draws.emitters);
            let Some(sample) = emitters.sample(precise(u, stream), v) else { continue };
            let arrives = self.emitter(vertex, &kernels, &sample, of_emitters);
            if tracer.scene().refracts() {
                behind.push((sample, arrives.as_ref().map(|_| arrive.len())));
            }
            arrive.extend(arrives.map(|arrives| arrives.share(of_emitters)));
        }
        let u = precise(numbers.of_vpls(), stream);
        for k in 0..draws.vpls {
            let u = (f64::from(k) + u) / f64::from(draws.vpls);
            let arrives = self.vpl(vertex, &receiver, u);
            arrive.extend(arrives.map(|arrives| arrives.share(draws.vpls as f32)));
        }
        self.rays += arrive.len() as u64;
        self.shadows.clear();
        for Arrives { light, .. } in &arrive {
            self.shadows.push((vertex.position(), vertex.medium()), light.apex());
        }
        let passing = self.shadows.trace(tracer);
        behind.retain(|(_, straight)| straight.is_none_or(|number| passing[number] != Rgb::WHITE));
        let (mut radiance, mut squares) = (Rgb::BLACK, 0.0);
        for (arrives, passing) in arrive.iter().zip(passing) {
            let value = arrives.value * *passing;
            let luminance = f64::from(value.luminance());
            radiance += value;
            squares += luminance * luminance * arrives.probability * f64::from(draws.vpls);
        }
        let mut through_panes = Rgb::BLACK;
        for (sample, _) in &behind {
            through_panes += self.through_panes(vertex, &kernels, sample, of_emitters, key, stream);
        }
        Arrived { straight: radiance, through_panes: through_panes / of_emitters, squares }
    }
}

impl Arrives {
    /// Divides the light by the number of samples.
    fn share(self, count: f32) -> Self {
        Self { value: self.value / count, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns true if `n` numbers in `[0, 1)` fall into different parts of `n` equal parts.
    fn is_even(numbers: &[f32]) -> bool {
        let mut parts: Vec<usize> = numbers.iter().map(|u| (*u * numbers.len() as f32) as usize).collect();
        parts.sort_unstable();
        parts.into_iter().eq(0..numbers.len())
    }

    /// The numbers of all gather points of a pixel are spread evenly in each dimension. Different
    /// pixels have different numbers.
    #[test]
    fn numbers_are_spread_over_a_pixel() {
        const POINTS: u32 = 16;
        let of = |key: u64| (0..POINTS).map(move |index| Numbers::new(index, key));
        for key in [1, 2] {
            for dimension in 0..3 {
                let of_draws = of(key).flat_map(|n| [0, 1].map(|k| n.of_draw(k, 2)[dimension]));
                assert!(is_even(&of_draws.collect::<Vec<_>>()), "draws, {dimension}");
                let of_paths = of(key).map(|numbers| numbers.of_path()[dimension]);
                assert!(is_even(&of_paths.collect::<Vec<_>>()), "paths, {dimension}");
            }
            assert!(is_even(&of(key).map(|numbers| numbers.of_vpls()).collect::<Vec<_>>()));
        }
        assert!(of(1).zip(of(2)).all(|(a, b)| a.of_vpls() != b.of_vpls()));
        let [first, later] = [0, LONGEST].map(|index| Numbers::new(index, 1).of_vpls());
        assert_ne!(first, later, "a sequence that is used up is followed by another");
    }

    /// Random digits are added below those of single precision.
    #[test]
    fn numbers_have_the_digits_of_large_sets() {
        let mut stream = Stream::new(1, Purpose::Test, 0);
        let numbers: Vec<f64> = (0..100).map(|_| precise(0.25, &mut stream)).collect();
        assert!(numbers.iter().all(|u| (0.25..0.25 + STEP).contains(u)));
        let in_upper_half = numbers.iter().filter(|u| **u >= 0.25 + 0.5 * STEP).count();
        assert!((30..70).contains(&in_upper_half), "{in_upper_half}");
    }
}
