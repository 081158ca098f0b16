//! Colours of other primaries as linear Rec. 709.
//!
//! ```text
//! RGB' = M₇₀₉⁻¹ A M RGB
//! ```
//!
//! with the matrix `M` whose columns are the primaries, scaled so that they add up to the white of
//! luminance 1. `A` is the identity, which leaves XYZ unchanged, or the chromatic adaptation from
//! one white to the other ([`Adapted`](White::Adapted)). The adaptation scales the cone responses
//! that ICC.1:2010, annex E, calls Bradford's.
//!
//! Sources of the chromaticities: ITU-R BT.709-6 and BT.2020-2; SMPTE EG 432-1 (P3, here with the
//! white D65, as displays have it); SMPTE ST 2065-1 and ACES S-2014-004 (ACES). Held to this by the
//! tests below.

use glam::{DMat3, DVec3};

use super::Rgb;

/// Chromaticities `x`, `y` of the primaries and of white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Chromaticities of red, green and blue.
    pub rgb: [[f64; 2]; 3],
    /// Chromaticity of equal amounts of red, green and blue.
    pub white: [f64; 2],
}

/// Treatment of a white other than that of Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum White {
    /// XYZ stays unchanged: for light.
    Kept,
    /// The white of the primaries becomes that of Rec. 709: for reflectances and pictures.
    Adapted,
}

const D65: [f64; 2] = [0.3127, 0.3290];
/// White of ACES, near D60.
const ACES: [f64; 2] = [0.321_68, 0.337_67];

/// Bradford's matrix from XYZ to cone responses, by columns.
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

impl Primaries {
    /// Rec. 709, the primaries of the renderer.
    pub const REC709: Self = Self { rgb: [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]], white: D65 };
    /// Rec. 2020.
    pub const REC2020: Self = Self { rgb: [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]], white: D65 };
    /// P3 with the white D65.
    pub const P3: Self = Self { rgb: [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]], white: D65 };
    /// ACES2065-1, with the white of ACES.
    pub const ACES2065_1: Self = Self { rgb: [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077]], white: ACES };
    /// ACEScg, with the white of ACES.
    pub const ACESCG: Self = Self { rgb: [[0.713, 0.293], [0.165, 0.830], [0.128, 0.044]], white: ACES };

    /// The matrix to linear Rec. 709, by rows; `None` if the primaries are linearly dependent.
    pub fn to_rec709(&self, white: White) -> Option<[[f32; 3]; 3]> {
        let adapted = match white {
            White::Kept => DMat3::IDENTITY,
            White::Adapted => {
                let [from, to] = [self.white, Self::REC709.white].map(|white| BRADFORD * xyz(white));
                BRADFORD.inverse() * DMat3::from_diagonal(to / from) * BRADFORD
            }
        };
        let matrix = Self::REC709.matrix().inverse() * adapted * self.matrix();
        let rows = matrix.transpose().to_cols_array_2d();
        matrix.is_finite().then(|| rows.map(|row| row.map(|v| v as f32)))
    }

    /// `M`, by rows: from these primaries to CIE XYZ, where white has the luminance 1.
    pub fn to_xyz(self) -> [[f64; 3]; 3] {
        self.matrix().transpose().to_cols_array_2d()
    }

    /// `M⁻¹`, by rows: from CIE XYZ to these primaries.
    pub fn from_xyz(self) -> [[f64; 3]; 3] {
        self.matrix().inverse().transpose().to_cols_array_2d()
    }

    fn matrix(self) -> DMat3 {
        let [r, g, b] = self.rgb.map(xyz);
        let unscaled = DMat3::from_cols(r, g, b);
        unscaled * DMat3::from_diagonal(unscaled.inverse() * xyz(self.white))
    }
}

/// XYZ of luminance 1, given the chromaticity.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// Product of a matrix, given by rows, and a colour.
pub fn transformed(rows: &[[f32; 3]; 3], c: Rgb) -> Rgb {
    let c = c.to_array();
    Rgb::from(rows.map(|row| row[0] * c[0] + row[1] * c[1] + row[2] * c[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(rows: [[f32; 3]; 3], expected: [[f32; 3]; 3]) {
        let difference = rows.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs());
        assert!(difference.fold(0.0, f32::max) < 2e-4, "{rows:?} for {expected:?}");
    }

    /// Rec. 2020: the inverse of ITU-R BT.2087-0; ACEScg: adapted, as printed in the colour
    /// transforms of ACES.
    #[test]
    fn matrices_are_those_of_the_standards() {
        let rec709 = Primaries::REC709.to_rec709(White::Kept).unwrap();
        close(rec709, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let rec2020 = Primaries::REC2020.to_rec709(White::Adapted).unwrap();
        close(rec2020, [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]);
        let aces_cg = Primaries::ACESCG.to_rec709(White::Adapted).unwrap();
        close(aces_cg, [[1.7051, -0.6218, -0.0833], [-0.1303, 1.1408, -0.0105], [-0.0240, -0.1290, 1.1530]]);
    }

    /// IEC 61966-2-1, annex F, to four digits.
    #[test]
    fn rec709_is_taken_to_xyz_and_back() {
        let there = Primaries::REC709.to_xyz();
        let standard = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        assert!(there.as_flattened().iter().zip(standard.as_flattened()).all(|(a, b)| (a - b).abs() < 5e-5));
        let back = Primaries::REC709.from_xyz();
        for (row, column) in (0..3).flat_map(|row| (0..3).map(move |column| (row, column))) {
            let product: f64 = (0..3).map(|k| back[row][k] * there[k][column]).sum();
            assert!((product - f64::from(row == column)).abs() < 1e-12, "{row} {column}: {product}");
        }
    }

    #[test]
    fn white_becomes_white_or_stays_as_it_is_seen() {
        for primaries in [Primaries::REC2020, Primaries::P3, Primaries::ACES2065_1, Primaries::ACESCG] {
            let adapted = transformed(&primaries.to_rec709(White::Adapted).unwrap(), Rgb::WHITE);
            assert!((adapted - Rgb::WHITE).map(f32::abs).max_channel() < 1e-5, "{primaries:?}: {adapted:?}");
            let kept = transformed(&primaries.to_rec709(White::Kept).unwrap(), Rgb::WHITE);
            assert!((kept.luminance() - 1.0).abs() < 1e-3, "{primaries:?}: {kept:?}");
            // D60 is redder than D65.
            let is_warm = kept.r > 1.02 && kept.b < 0.98;
            assert_eq!(is_warm, primaries.white == ACES, "{primaries:?}: {kept:?}");
        }
        let flat = Primaries { rgb: [[0.3, 0.3]; 3], ..Primaries::REC709 };
        assert_eq!(flat.to_rec709(White::Kept), None);
    }
}
