//! Optical constants of metals by the names that scene formats give them.
//!
//! Output: refractive index `η` and extinction coefficient `k` of `η + i k`, both averaged over the
//! spectrum with the response of each Rec. 709 channel under D65 ([`rgb_of_reflectance`]). At
//! normal incidence a channel reflects
//!
//! ```text
//! R = ((η − 1)² + k²) / ((η + 1)² + k²)
//! ```
//!
//! # Assumption
//! The mean of `R` over a channel is `R` of the means. The error where the constants change within
//! a channel is below 0.025 for gold and copper, see the test.
//!
//! | module | metals |
//! |---|---|
//! | `measured` | gold, silver, copper, brass; diamond and oxides, which formats count as metals |
//! | `lorentz_drude` | Al, Be, Cr, Ni, Pd, Pt, Ti, W |
//!
//! Metals without known published constants have no entry: callers use an approximation and report
//! it.

mod lorentz_drude;
mod measured;

use super::Rgb;
use super::spectrum::rgb_of_reflectance;

/// Spectra of `η` and `k` over wavelengths in nm.
struct Constants {
    eta: Vec<(f32, f32)>,
    k: Vec<(f32, f32)>,
}

/// Returns the constants `(η, k)` of a metal, given its name in any case of letters: `Au`,
/// `Ni_palik`, `metal-Au-eta`, `metals/Au.k.spd`. `None` if the metal has no entry.
pub fn conductor_rgb(name: &str) -> Option<(Rgb, Rgb)> {
    let symbol = symbol(name);
    let Constants { eta, k } = measured::constants(&symbol).or_else(|| lorentz_drude::constants(&symbol))?;
    Some((rgb_of_reflectance(&eta)?, rgb_of_reflectance(&k)?))
}

/// Returns the metal's symbol in lower case: the name without folders, prefix and suffixes.
fn symbol(name: &str) -> String {
    let name = name.to_ascii_lowercase();
    let mut rest = name.rsplit(['/', '\\']).next().unwrap_or_default();
    rest = rest.strip_suffix(".spd").unwrap_or(rest);
    rest = rest.strip_prefix("metal-").unwrap_or(rest);
    for suffix in [".eta", "-eta", ".k", "-k"] {
        rest = rest.strip_suffix(suffix).unwrap_or(rest);
    }
    rest.strip_suffix("_palik").unwrap_or(rest).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normal_reflectance(eta: f32, k: f32) -> f32 {
        ((eta - 1.0) * (eta - 1.0) + k * k) / ((eta + 1.0) * (eta + 1.0) + k * k)
    }

    fn color(name: &str) -> Rgb {
        let (eta, k) = conductor_rgb(name).unwrap();
        eta.zip(k, normal_reflectance)
    }

    #[test]
    fn every_spelling_of_a_name_is_the_same_metal() {
        let gold = conductor_rgb("Au").unwrap();
        for name in
            ["metal-Au-eta", "metal-Au-k", "metals/Au.eta.spd", "spds\\metals\\Au.k.spd", "au", "Au_palik"]
        {
            assert_eq!(conductor_rgb(name), Some(gold), "{name}");
        }
        assert_ne!(conductor_rgb("Ag"), Some(gold));
        for name in ["", "none", "metal-", ".spd", "Unobtainium", "K"] {
            assert_eq!(conductor_rgb(name), None, "{name}");
        }
    }

    #[test]
    fn reflectances_are_the_published_ones() {
        // Linear Rec. 709 at normal incidence, [^akenine2018], table 9.2, measured on other
        // samples: published colours of gold differ from each other by 0.05.
        for (name, expected) in [
            ("Au", [1.00, 0.78, 0.34]),
            ("Ag", [0.97, 0.96, 0.91]),
            ("Cu", [0.96, 0.64, 0.54]),
            ("Al", [0.91, 0.92, 0.92]),
            ("Ni_palik", [0.66, 0.61, 0.53]),
            ("Pt", [0.67, 0.64, 0.59]),
            ("Pd", [0.73, 0.70, 0.65]),
            ("W", [0.50, 0.50, 0.48]),
            ("metal-CuZn-k", [0.91, 0.78, 0.42]),
        ] {
            let seen = color(name);
            let difference = seen.zip(expected.into(), |a, b| (a - b).abs()).max_channel();
            assert!(difference < 0.05, "{name}: {seen:?}");
        }
        let [gold, copper, silver, aluminium] = ["Au", "Cu", "Ag", "Al"].map(color);
        assert!(gold.r > gold.g + 0.2 && gold.g > gold.b + 0.3, "{gold:?}");
        assert!(copper.r > copper.g + 0.25 && copper.g > copper.b + 0.05, "{copper:?}");
        assert!(silver.r > silver.b && aluminium.r < aluminium.b, "{silver:?} {aluminium:?}");
    }

    #[test]
    fn a_channel_reflects_what_its_part_of_the_spectrum_does() {
        for name in ["au", "ag", "cu"] {
            let Constants { eta, k } = measured::constants(name).unwrap();
            let spectrum: Vec<(f32, f32)> =
                eta.iter().zip(&k).map(|(&(nm, eta), &(_, k))| (nm, normal_reflectance(eta, k))).collect();
            let exact = rgb_of_reflectance(&spectrum).unwrap();
            let difference = color(name).zip(exact, |a, b| (a - b).abs()).max_channel();
            assert!(difference < 0.025, "{name}: {difference}");
        }
    }
}
