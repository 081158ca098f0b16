//! Panes of Radiance's `glass` as panes of this renderer.
//!
//! A pane of transmissivity `τ` and index `n` transmits and reflects, averaged over both
//! polarizations `F = F_s, F_p` of a face, with the cosine `c₂` inside and `d = τ^(1/c₂)`,
//!
//! ```text
//! T = (1 − F)² d / (1 − F² d²)          R = F (1 + (1 − 2F) d²) / (1 − F² d²)
//! ```
//!
//! Here a pane of index `n'` transmits `k (1 − G)/(1 + G)` and reflects `r 2G/(1 + G)`, with the
//! reflectance `G` of a face for unpolarized light. `k` and `r` are chosen by channel so that
//! diffuse light is transmitted and reflected as there. `n'`, from `0.95 n` to `n`, is chosen so
//! that light of normal incidence is transmitted as there, too. Clear glass has such an index. Dark
//! glass transmits too little light at normal incidence and too much at grazing angles.
//!
//! Source: Radiance, `src/rt/glass.c`, and the reference manual, "Glass". Held to this by the tests
//! below.

use crate::color::Rgb;
use crate::io::dielectrics::IOR_RANGE;
use crate::math::elementary::powf_f64;
use crate::scene::Surface;

/// Directions over which diffuse light is averaged.
const DIRECTIONS: usize = 256;

/// Steps of the bisection: it ends within 10⁻⁹ of the index.
const STEPS: usize = 32;

/// Index of refraction of `glass` without one.
pub(super) const DEFAULT_INDEX: f64 = 1.52;

/// Transmissivity below which a pane is black.
const BLACK: f64 = 1e-12;

/// The pane of the transmissivities `tau` and the index `index`.
pub(super) fn pane(tau: [f64; 3], index: f64) -> Surface {
    let tau = tau.map(|t| t.clamp(0.0, 1.0));
    let mean = tau.iter().sum::<f64>() / 3.0;
    let [least, most] = IOR_RANGE.map(f64::from);
    let index = index.clamp(least, most);
    let (normal, diffuse) = (of_file(1.0, index, mean)[0], over_directions(|c| of_file(c, index, mean)[0]));
    let (mut low, mut high) = ((0.95 * index).max(least), index);
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        let factor = normal / clear(1.0, middle)[0];
        // In this range, the larger the index is, the smaller is the share of diffuse light.
        if mean > BLACK && factor * over_directions(|c| clear(c, middle)[0]) > diffuse {
            low = middle;
        } else {
            high = middle;
        }
    }
    let ior = low;
    let share = |part: usize, tau: f64| {
        let of_here = over_directions(|c| clear(c, ior)[part]);
        (over_directions(|c| of_file(c, index, tau)[part]) / of_here).min(1.0) as f32
    };
    let factor = |part: usize| Rgb::from(tau.map(|tau| share(part, tau)));
    Surface::ThinGlass {
        ior: ior as f32,
        reflectance: factor(1).into(),
        transmittance: factor(0).into(),
        facets: 0.0.into(),
    }
}

/// Reflectances of a face for both polarizations, and the cosine inside.
fn face(cos: f64, index: f64) -> ([f64; 2], f64) {
    let inside = (1.0 - (1.0 - cos * cos) / (index * index)).sqrt();
    let s = (cos - index * inside) / (cos + index * inside);
    let p = (index * cos - inside) / (index * cos + inside);
    ([s * s, p * p], inside)
}

/// Transmittance and reflectance of a pane in Radiance.
fn of_file(cos: f64, index: f64, tau: f64) -> [f64; 2] {
    if tau <= BLACK {
        let (faces, _) = face(cos, index);
        return [0.0, 0.5 * (faces[0] + faces[1])];
    }
    let (faces, inside) = face(cos, index);
    let d = powf_f64(tau, 1.0 / inside);
    let mut sums = [0.0; 2];
    for f in faces {
        let rest = 1.0 - f * f * d * d;
        sums[0] += 0.5 * (1.0 - f) * (1.0 - f) * d / rest;
        sums[1] += 0.5 * f * (1.0 + (1.0 - 2.0 * f) * d * d) / rest;
    }
    sums
}

/// Transmittance and reflectance of a clear pane of this renderer.
fn clear(cos: f64, index: f64) -> [f64; 2] {
    let ([s, p], _) = face(cos, index);
    let f = 0.5 * (s + p);
    [(1.0 - f) / (1.0 + f), 2.0 * f / (1.0 + f)]
}

/// Mean over the directions of diffuse light, which have the density `2 cos θ` in `cos θ`.
fn over_directions(value: impl Fn(f64) -> f64) -> f64 {
    let direction = |i: usize| value(((i as f64 + 0.5) / DIRECTIONS as f64).sqrt());
    (0..DIRECTIONS).map(direction).sum::<f64>() / DIRECTIONS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(tau: f64, index: f64) -> (f64, f64, f64) {
        let Surface::ThinGlass { ior, reflectance, transmittance, .. } = pane([tau; 3], index) else {
            panic!()
        };
        let factor = |c: crate::scene::ColorInput| f64::from(c.factor.to_array()[1]);
        (f64::from(ior), factor(transmittance), factor(reflectance))
    }

    #[test]
    fn transmittances_are_those_that_radiance_renders() {
        // Radiance of a sky of 1 behind a pane, from `rtrace -ab 0`.
        for (tau, shown) in [(0.96, 0.881_459_8), (0.5, 0.458_534_4), (0.1, 0.091_666_97)] {
            assert!((of_file(1.0, DEFAULT_INDEX, tau)[0] - shown).abs() < 1e-6);
        }
    }

    #[test]
    fn diffuse_light_passes_as_in_radiance_and_parallel_light_nearly_so() {
        // For each pane, the largest error of the transmittance up to 70°.
        for (tau, index, most) in [
            (1.0, 1.52, 0.016),
            (0.96, 1.52, 0.012),
            (0.9, 1.52, 0.02),
            (0.8, 1.52, 0.026),
            (0.5, 1.52, 0.11),
            (0.96, 1.7, 0.03),
        ] {
            let (ior, k, r) = parts(tau, index);
            let diffuse = |part: usize, of: &dyn Fn(f64) -> f64| {
                over_directions(|c| of(c) - of_file(c, index, tau)[part])
            };
            assert!(diffuse(0, &|c| k * clear(c, ior)[0]).abs() < 1e-6, "{tau}");
            assert!(diffuse(1, &|c| r * clear(c, ior)[1]).abs() < 0.013, "{tau}");
            for degrees in [0, 30, 45, 60, 70] {
                let cos = f64::from(degrees).to_radians().cos();
                let off = k * clear(cos, ior)[0] / of_file(cos, index, tau)[0] - 1.0;
                assert!(off.abs() < most, "{tau}, {degrees} degrees: {off}");
            }
        }
        // Clear glass transmits light of normal incidence exactly.
        let (ior, k, _) = parts(0.96, DEFAULT_INDEX);
        assert!((k * clear(1.0, ior)[0] - of_file(1.0, DEFAULT_INDEX, 0.96)[0]).abs() < 1e-4);
    }

    #[test]
    fn black_panes_transmit_nothing_and_coloured_ones_by_channel() {
        assert_eq!(parts(0.0, 1.52).1, 0.0);
        let Surface::ThinGlass { transmittance, .. } = pane([0.96, 0.5, 0.0], 1.52) else { panic!() };
        let [red, green, blue] = transmittance.factor.to_array();
        assert!(red > 0.9 && green < 0.6 && green > 0.4 && blue == 0.0, "{transmittance:?}");
    }
}
