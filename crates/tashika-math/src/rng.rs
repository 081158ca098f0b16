//! Random numbers that are a function of their *purpose*.
//!
//! A [`Stream`] is keyed by (seed, purpose, index). The same key gives the same numbers in any
//! thread, for any tile and on any machine. Different keys give independent numbers. The key is
//! hashed into the state and the increment of a PCG-XSH-RR generator (O'Neill 2014, `rand_pcg`).

use rand_core::Rng;
use rand_pcg::Pcg32;

/// Purpose of a stream of random numbers; part of its key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u64)]
pub enum Purpose {
    /// Camera rays and specular chains of a pixel.
    Gather = 1,
    /// Light paths of a VPL set.
    LightPath = 2,
    /// Light paths traced only to estimate the number of VPLs per path.
    LightPathPilot = 3,
    /// VPLs placed directly on emitters.
    DirectLight = 4,
    /// Paths of the path tracer.
    CameraPath = 5,
    /// Choice of a subset, as for estimating the spacing of VPLs.
    Subset = 6,
    /// Tests.
    Test = 7,
    /// Shapes of the built-in scene.
    Modelling = 8,
    /// Random decisions whether a ray meets a partly transparent surface.
    Opacity = 9,
    /// Choice of the terms that are sampled in the pairs of a cut.
    Cut = 11,
    /// Heuristics that decide where work is spent. They do not enter estimates in any other way.
    Guidance = 13,
    /// Independent repetitions: sets of VPLs, gather points.
    Replicate = 14,
    /// Paths of the light that VPLs do not carry.
    Compensation = 15,
    /// Paths of pictures that are reconstructed.
    Picture = 16,
    /// Choice of the pixels of an audit, and paths of their reference values.
    Audit = 17,
    /// Times of camera samples while the shutter is open.
    Shutter = 18,
    /// Transmittance of heterogeneous media between two points.
    Transmittance = 19,
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): a bijection of 64-bit words that mixes
/// well.
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A 64-bit hash of (seed, purpose, index), for generators that take a seed of their own.
#[inline]
pub fn key(seed: u64, purpose: Purpose, index: u64) -> u64 {
    const STEP: u64 = 0x9e37_79b9_7f4a_7c15;
    let a = mix(seed.wrapping_add(STEP));
    let b = mix(a ^ mix((purpose as u64).wrapping_mul(STEP)));
    mix(b ^ mix(index.wrapping_add(STEP)))
}

/// A deterministic stream of uniform numbers.
#[derive(Clone, Debug)]
pub struct Stream(Pcg32);

impl Stream {
    /// The stream of (seed, purpose, index).
    #[inline]
    pub fn new(seed: u64, purpose: Purpose, index: u64) -> Self {
        let state = key(seed, purpose, index);
        Self(Pcg32::new(state, mix(!state)))
    }

    /// A number in `[0, 1)`, a multiple of 2⁻²⁴.
    #[inline]
    pub fn uniform(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 * (1.0 / (1 << 24) as f32)
    }

    /// Two numbers in `[0, 1)`.
    #[inline]
    pub fn uniform_2(&mut self) -> [f32; 2] {
        [self.uniform(), self.uniform()]
    }

    /// Three numbers in `[0, 1)`.
    #[inline]
    pub fn uniform_3(&mut self) -> [f32; 3] {
        [self.uniform(), self.uniform(), self.uniform()]
    }

    /// A number in `[0, 1)` with 53 random bits.
    #[inline]
    pub fn uniform_f64(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// An integer in `[0, n)`; `n` must not be zero. Its bias is below `n / 2⁶⁴`.
    #[inline]
    pub fn below(&mut self, n: u64) -> u64 {
        debug_assert!(n > 0);
        ((u128::from(self.0.next_u64()) * u128::from(n)) >> 64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_stable() {
        let mut s = Stream::new(1, Purpose::Test, 2);
        let got: Vec<u32> = (0..4).map(|_| (s.uniform() * (1 << 24) as f32) as u32).collect();
        // These numbers are part of every image: a change of them changes all images.
        assert_eq!(got, [4_253_212, 53_849, 6_634_636, 15_927_962]);
    }

    #[test]
    fn neighbouring_keys_are_uncorrelated() {
        let n = 20_000;
        let pairs: Vec<(f64, f64)> = (0..n)
            .map(|i| {
                let first = |k| f64::from(Stream::new(7, Purpose::Test, k).uniform());
                (first(i), first(i + 1))
            })
            .collect();
        let mean = pairs.iter().map(|p| p.0).sum::<f64>() / n as f64;
        let covariance = pairs.iter().map(|p| (p.0 - 0.5) * (p.1 - 0.5)).sum::<f64>() / n as f64;
        // Standard errors are 0.0020 and 0.00059; the limits are five of them.
        assert!((mean - 0.5).abs() < 0.0102, "mean {mean}");
        assert!(covariance.abs() < 0.003, "covariance {covariance}");
    }

    #[test]
    fn purposes_separate_streams() {
        let first = |p| Stream::new(1, p, 0).uniform();
        assert_ne!(first(Purpose::Gather), first(Purpose::LightPath));
        assert!((0..1000).all(|i| Stream::new(3, Purpose::Test, i).below(7) < 7));
    }
}
