//! Optical constants of metals by oscillators fitted to measurements.
//!
//! ```text
//! (η + i k)² = 1 − f₀ ω_p² / (ω² + i ω Γ₀) + Σⱼ fⱼ ω_p² / (ωⱼ² − ω² − i ω Γⱼ)
//! ```
//!
//! with all frequencies as photon energies (eV). Source: Rakić 1998, eqs. 1 to 3 and tables 1 and 2
//! (the Lorentz–Drude model); fitted from 0.1 eV to 6 eV, to within a few percent of the
//! measurements.

use super::{Constants, measured::ENERGY_NM};

/// Oscillators of a metal: one of its free electrons, four of its bound electrons.
struct Metal {
    symbol: &'static str,
    /// Plasma frequency `ω_p` as photon energy (eV).
    plasma: f64,
    /// Strength and damping `(f₀, Γ₀)`.
    free: (f64, f64),
    /// Strengths, dampings and resonances `(fⱼ, Γⱼ, ωⱼ)`.
    bound: &'static [(f64, f64, f64)],
}

#[expect(clippy::approx_constant, reason = "a resonance that happens to be near π")]
const METALS: [Metal; 8] = [
    Metal {
        symbol: "al",
        plasma: 14.98,
        free: (0.523, 0.047),
        bound: &[(0.227, 0.333, 0.162), (0.050, 0.312, 1.544), (0.166, 1.351, 1.808), (0.030, 3.382, 3.473)],
    },
    Metal {
        symbol: "be",
        plasma: 18.51,
        free: (0.084, 0.035),
        bound: &[(0.031, 1.664, 0.100), (0.140, 3.395, 1.032), (0.530, 4.454, 3.183), (0.130, 1.802, 4.604)],
    },
    Metal {
        symbol: "cr",
        plasma: 10.75,
        free: (0.168, 0.047),
        bound: &[(0.151, 3.175, 0.121), (0.150, 1.305, 0.543), (1.149, 2.676, 1.970), (0.825, 1.335, 8.775)],
    },
    Metal {
        symbol: "ni",
        plasma: 15.92,
        free: (0.096, 0.048),
        bound: &[(0.100, 4.511, 0.174), (0.135, 1.334, 0.582), (0.106, 2.178, 1.597), (0.729, 6.292, 6.089)],
    },
    Metal {
        symbol: "pd",
        plasma: 9.72,
        free: (0.330, 0.008),
        bound: &[(0.649, 2.950, 0.336), (0.121, 0.555, 0.501), (0.638, 4.621, 1.659), (0.453, 3.236, 5.715)],
    },
    Metal {
        symbol: "pt",
        plasma: 9.59,
        free: (0.333, 0.080),
        bound: &[(0.191, 0.517, 0.780), (0.659, 1.838, 1.314), (0.547, 3.668, 3.141), (3.576, 8.517, 9.249)],
    },
    Metal {
        symbol: "ti",
        plasma: 7.29,
        free: (0.148, 0.082),
        bound: &[(0.899, 2.276, 0.777), (0.393, 2.518, 1.545), (0.187, 1.663, 2.509), (0.001, 1.762, 19.43)],
    },
    Metal {
        symbol: "w",
        plasma: 13.22,
        free: (0.206, 0.064),
        bound: &[(0.054, 0.530, 1.004), (0.166, 1.281, 1.917), (0.706, 3.332, 3.580), (2.590, 5.836, 7.498)],
    },
];

/// Optical constants of a metal, given its symbol in lower case.
pub(super) fn constants(symbol: &str) -> Option<Constants> {
    let metal = METALS.iter().find(|m| m.symbol == symbol)?;
    let samples = || (380_u16..=780).step_by(10).map(f32::from);
    Some(Constants {
        eta: samples().map(|nm| (nm, metal.index(nm)[0])).collect(),
        k: samples().map(|nm| (nm, metal.index(nm)[1])).collect(),
    })
}

impl Metal {
    /// Index and extinction coefficient `[η, k]` at a wavelength.
    fn index(&self, nm: f32) -> [f32; 2] {
        let w = ENERGY_NM / f64::from(nm);
        let (mut re, mut im) = (1.0, 0.0);
        // Free electrons are an oscillator at zero frequency.
        let free = (self.free.0, self.free.1, 0.0);
        for &(strength, damping, resonance) in std::iter::once(&free).chain(self.bound) {
            let (a, b) = (resonance * resonance - w * w, w * damping);
            let scale = strength * self.plasma * self.plasma / (a * a + b * b);
            re += scale * a;
            im += scale * b;
        }
        let modulus = (re * re + im * im).sqrt();
        [modulus + re, modulus - re].map(|twice| (0.5 * twice).max(0.0).sqrt() as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_agree_with_tables() {
        // Values at 2.1 eV, 590 nm, in the tables that the oscillators were fitted to (Palik 1985).
        // The tolerance is the error of the fit.
        for (symbol, eta, k) in [("al", 1.15, 7.15), ("ni", 1.85, 3.4), ("pt", 2.2, 3.9), ("w", 3.5, 2.8)] {
            let metal = METALS.iter().find(|m| m.symbol == symbol).unwrap();
            let seen = metal.index(590.0);
            for (seen, expected) in seen.into_iter().zip([eta, k]) {
                assert!((seen / expected - 1.0).abs() < 0.05, "{symbol}: {seen} for {expected}");
            }
        }
    }
}
