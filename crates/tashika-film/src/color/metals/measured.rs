//! Measured optical constants.
//!
//! Sources, with wavelengths `1239.84 nm·eV / E` for tables by photon energy `E`:
//! * gold, copper: Johnson 1972, table I;
//! * silver: Palik 1985;
//! * brass (70 % copper, 30 % zinc): Querry 1985;
//! * rutile (ordinary ray): [^devore1951]; magnesium oxide: Stephens 1952; diamond: Peter 1923; by
//!   their dispersion formulas.

use super::Constants;

/// Planck's constant times the speed of light (nm·eV).
pub(super) const ENERGY_NM: f64 = 1_239.841_98;

/// Photon energy (eV), then `η` and `k` of copper and of gold.
const COPPER_AND_GOLD: [(f32, [f32; 4]); 15] = [
    (1.51, [0.26, 5.180, 0.16, 5.083]),
    (1.64, [0.24, 4.665, 0.14, 4.542]),
    (1.76, [0.21, 4.205, 0.13, 4.103]),
    (1.88, [0.22, 3.747, 0.14, 3.697]),
    (2.01, [0.30, 3.205, 0.21, 3.272]),
    (2.14, [0.70, 2.704, 0.29, 2.863]),
    (2.26, [1.02, 2.577, 0.43, 2.455]),
    (2.38, [1.18, 2.608, 0.62, 2.081]),
    (2.50, [1.22, 2.564, 1.04, 1.833]),
    (2.63, [1.25, 2.483, 1.31, 1.849]),
    (2.75, [1.24, 2.397, 1.38, 1.914]),
    (2.88, [1.25, 2.305, 1.45, 1.948]),
    (3.00, [1.28, 2.207, 1.46, 1.958]),
    (3.12, [1.32, 2.116, 1.47, 1.952]),
    (3.25, [1.33, 2.045, 1.46, 1.933]),
];

/// Photon energy (eV), `η`, `k`.
const SILVER: [(f32, f32, f32); 18] = [
    (1.6, 0.143, 5.09),
    (1.7, 0.148, 4.74),
    (1.8, 0.140, 4.44),
    (1.9, 0.140, 4.15),
    (2.0, 0.131, 3.88),
    (2.1, 0.121, 3.66),
    (2.2, 0.120, 3.45),
    (2.3, 0.129, 3.25),
    (2.4, 0.130, 3.07),
    (2.5, 0.130, 2.88),
    (2.6, 0.132, 2.72),
    (2.7, 0.144, 2.56),
    (2.8, 0.157, 2.40),
    (2.9, 0.160, 2.26),
    (3.0, 0.173, 2.11),
    (3.1, 0.173, 1.95),
    (3.2, 0.192, 1.81),
    (3.3, 0.200, 1.67),
];

/// Wavelength (nm), `η`, `k`.
const BRASS: [(f32, f32, f32); 8] = [
    (400.0, 1.445, 1.805),
    (430.0, 1.278, 1.784),
    (460.0, 0.994, 1.883),
    (500.0, 0.686, 2.250),
    (550.0, 0.527, 2.765),
    (600.0, 0.450, 3.253),
    (650.0, 0.444, 3.695),
    (700.0, 0.446, 4.106),
];

/// Optical constants of a metal, given its symbol in lower case.
pub(super) fn constants(symbol: &str) -> Option<Constants> {
    match symbol {
        "cu" => Some(of(COPPER_AND_GOLD.map(|(e, [eta, k, ..])| (wavelength(e), eta, k)))),
        "au" => Some(of(COPPER_AND_GOLD.map(|(e, [.., eta, k])| (wavelength(e), eta, k)))),
        "ag" => Some(of(SILVER.map(|(e, eta, k)| (wavelength(e), eta, k)))),
        "cuzn" => Some(of(BRASS)),
        "tio2" => Some(transparent(|s| 5.913 + 0.2441 / (s - 0.0803))),
        "mgo" => Some(transparent(|s| {
            2.956_362 + 0.021_957_7 / (s - 0.014_283_22) - 0.010_623_87 * s - 0.000_020_496_8 * s * s
        })),
        "d-c" => Some(transparent(|s| 1.0 + 0.3306 * s / (s - 0.030_625) + 4.3356 * s / (s - 0.011_236))),
        _ => None,
    }
}

fn of<const N: usize>(samples: [(f32, f32, f32); N]) -> Constants {
    Constants {
        eta: samples.iter().map(|&(nm, eta, _)| (nm, eta)).collect(),
        k: samples.iter().map(|&(nm, _, k)| (nm, k)).collect(),
    }
}

/// Wavelength (nm) of photons of an energy (eV).
fn wavelength(energy: f32) -> f32 {
    (ENERGY_NM / f64::from(energy)) as f32
}

/// Constants of a transparent material, given its squared index as a function of the squared
/// wavelength (µm²).
fn transparent(squared_index: impl Fn(f64) -> f64) -> Constants {
    let sample = |nm: u16| {
        let micrometres = f64::from(nm) * 1e-3;
        (f32::from(nm), squared_index(micrometres * micrometres).sqrt() as f32)
    };
    Constants { eta: (380..=780).step_by(20).map(sample).collect(), k: vec![(550.0, 0.0)] }
}

#[cfg(test)]
mod tests {
    use crate::color::metals::conductor_rgb;

    #[test]
    fn dispersion_formulas_give_known_indices() {
        // At the sodium line, 589.3 nm, which is close to the green channel; dispersion over that
        // distance is below 0.02.
        for (name, index) in [("MgO", 1.736), ("d-C", 2.417), ("TiO2", 2.613)] {
            let (eta, k) = conductor_rgb(name).unwrap();
            assert!(k.is_black() && (eta.g - index).abs() < 0.06, "{name}: {eta:?}");
            assert!(eta.b > eta.g && eta.g > eta.r, "{name}: {eta:?}");
        }
    }
}
