//! Light at gather points where nothing is summed: a few emitters and VPLs are drawn, and a path is
//! followed.
//!
//! ```text
//! L = Σ_e emitter(e)/E  +  Σ_k VPL(u_k)/V  +  path        u_k = (k + u)/V
//! ```
//!
//! All draws are told the one place of the gather point, so that they are spread evenly over what was
//! learned of it ([`Choices`](super::Choices)). An emitter is weighted against the path that may meet
//! it by the balance heuristic of several samples (Veach 1997, section 9.2).
//!
//! How much light varies by which set of VPLs there is, no draw from one set shows. If VPLs are
//! independent, that is the sum of the squares of what each gives, which draws estimate:
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

/// How many lights are drawn at a gather point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draws {
    /// Of the emitters; at least 1.
    pub emitters: u32,
    /// Of the VPLs.
    pub vpls: u32,
}

/// The uniform numbers of one of the gather points of a pixel: an Owen-scrambled Sobol' sequence over
/// them all (Burley 2020), so that lights are spread evenly over the pixel.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    /// Which gather point.
    index: u32,
    key: u64,
}

/// Longest part of a sequence.
const LONGEST: u32 = 1 << 12;
/// What a number of single precision leaves open.
const STEP: f64 = 1.0 / (1u64 << 24) as f64;

impl Numbers {
    /// Of the gather point `index` of a pixel; pixels are told apart by `key`.
    pub fn new(index: u32, key: u64) -> Self {
        Self { index: index % LONGEST, key: rng::key(key, Purpose::Cut, u64::from(index / LONGEST)) }
    }

    /// Of draw `k` of so many.
    fn of_draw(&self, k: u32, draws: u32) -> [f32; 4] {
        sobol_burley::sample_4d(self.index * draws + k, 0, self.key as u32)
    }

    /// For the path.
    fn of_path(&self) -> [f32; 4] {
        sobol_burley::sample_4d(self.index, 1, (self.key >> 32) as u32)
    }

    /// For all VPLs.
    fn of_vpls(&self) -> f32 {
        sobol_burley::sample(self.index, 0, (self.key >> 32) as u32)
    }
}

/// With the digits that single precision does not have, of which large sets of lights need some.
fn precise(u: f32, stream: &mut Stream) -> f64 {
    f64::from(u) + STEP * stream.uniform_f64()
}

/// What was drawn at a gather point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    pub draws: Draws,
    /// Radiance that arrived straight, and through panes (W·m⁻²·sr⁻¹).
    pub straight: Rgb,
    pub through_panes: Rgb,
    /// Uniform numbers that the path begins with: of its direction, and by which kernel.
    pub of_path: [f32; 4],
}

/// Light of the draws at a gather point (W·m⁻²·sr⁻¹).
struct Arrived {
    straight: Rgb,
    through_panes: Rgb,
    /// Sum of the squares of the light of each VPL (luminance²).
    squares: f64,
}

impl Compensation<'_> {
    /// An unbiased estimate of all light at a gather point (W·m⁻²·sr⁻¹), with its weight.
    ///
    /// * `by_vpls`: the BSDF that light of VPLs is scattered with there; paths have the rest.
    /// * `key`: of the decisions of rays.
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
        // Emitters that may be seen through panes, with the number of what arrives straight.
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
    /// One of so many.
    fn share(self, count: f32) -> Self {
        Self { value: self.value / count, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of so many numbers in `[0, 1)`, each part of the interval has one.
    fn is_even(numbers: &[f32]) -> bool {
        let mut parts: Vec<usize> = numbers.iter().map(|u| (*u * numbers.len() as f32) as usize).collect();
        parts.sort_unstable();
        parts.into_iter().eq(0..numbers.len())
    }

    /// The draws of all gather points of a pixel are spread evenly, in each number; those of other
    /// pixels are others.
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

    /// Digits are added below those that single precision has.
    #[test]
    fn numbers_have_the_digits_of_large_sets() {
        let mut stream = Stream::new(1, Purpose::Test, 0);
        let numbers: Vec<f64> = (0..100).map(|_| precise(0.25, &mut stream)).collect();
        assert!(numbers.iter().all(|u| (0.25..0.25 + STEP).contains(u)));
        let in_upper_half = numbers.iter().filter(|u| **u >= 0.25 + 0.5 * STEP).count();
        assert!((30..70).contains(&in_upper_half), "{in_upper_half}");
    }
}
