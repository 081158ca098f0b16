//! Published tone mappings: a curve for each channel between two matrices, and a power at the end:
//!
//! ```text
//! c″ = ( O · curve( I · c′ ) )ᵍ        cut off at 0 and 1
//! ```
//!
//! | | `I`, `O` | curve | `g` |
//! |---|---|---|---|
//! | filmic | none | `h(2x) / h(11.2)` | 1 |
//! | ACES | sRGB to AP1 with the desaturation of the RRT, and back | `r(x)` | 1 |
//! | AgX | inset and outset of the primaries | polynomial of degree 6 in `a(x)` | 2.2 |
//!
//! `h(x) = (x(0.15x + 0.05) + 0.004)/(x(0.15x + 0.5) + 0.06) − 0.02/0.3`,
//! `r(x) = (x(x + 0.0245786) − 0.000090537)/(x(0.983729x + 0.432951) + 0.238081)`,
//! `a(x) = (log₂ x + 12.47393)/16.5`, clamped to 0 and 1.
//!
//! * Filmic is the curve that John Hable showed for Uncharted 2 (Hable 2010): exposure bias 2,
//!   linear white 11.2, so that radiance 5.6 is the first white. The factor of 16 before the curve
//!   in his listing is the exposure of his scene, which is `--exposure` here.
//! * ACES is Stephen Hill's fit of the reference rendering transform and the output transform for
//!   sRGB at 100 cd/m² (Hill 2016), not the transforms themselves. It maps middle gray to a tenth
//!   of white; a higher exposure makes it brighter.
//! * AgX is Troy Sobotka's (Sobotka 2022) without a look. The curve is the fit by Benjamin Wrensch
//!   (Wrensch 2023), who states a mean squared error of 3.7·10⁻⁶.
//!
//! # Held to this by
//! `tone::tests`, with the published formulas written out, and with points that their authors name.

use serde::Serialize;

use crate::color::Rgb;
use crate::math::elementary::{ln, powf};

/// Rows of a matrix that is applied to red, green and blue.
type Matrix = [[f32; 3]; 3];

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// Largest input of the curves: all are flat above, and its square is finite.
const BRIGHTEST: f32 = 1e6;

/// A curve of one channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Curve {
    /// Ratio of two polynomials; coefficients from the constant on.
    Rational {
        /// Numerator.
        over: [f32; 3],
        /// Denominator.
        under: [f32; 3],
    },
    /// Polynomial of the relative position between two logarithms to base 2; coefficients from the
    /// constant on.
    Logarithmic {
        /// Logarithms at the positions 0 and 1; the input is clamped to them.
        between: [f32; 2],
        /// Coefficients of the powers of the position.
        polynomial: [f32; 7],
    },
}

/// A tone mapping of the module's form.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Published {
    /// Matrix `I`, applied before the curve.
    pub inset: Matrix,
    /// Curve `curve`, applied to each channel.
    pub curve: Curve,
    /// Matrix `O`, applied after the curve.
    pub outset: Matrix,
    /// Power `g` that makes the result display-linear.
    pub power: f32,
}

/// Hable's curve, multiplied out: the numerator is `A(1 − E/F)x² + B(C − E/F)x` at twice the
/// radiance, over `h(11.2)`.
pub(super) const FILMIC: Published = Published {
    inset: IDENTITY,
    curve: Curve::Rational { over: [0.0, 0.045_968_81, 0.772_276], under: [0.06, 1.0, 0.6] },
    outset: IDENTITY,
    power: 1.0,
};

pub(super) const ACES: Published = Published {
    inset: [[0.597_19, 0.354_58, 0.048_23], [0.076, 0.908_34, 0.015_66], [0.028_4, 0.133_83, 0.837_77]],
    curve: Curve::Rational {
        over: [-0.000_090_537, 0.024_578_6, 1.0],
        under: [0.238_081, 0.432_951, 0.983_729],
    },
    outset: [
        [1.604_75, -0.531_08, -0.073_67],
        [-0.102_08, 1.108_13, -0.006_05],
        [-0.003_27, -0.072_76, 1.076_02],
    ],
    power: 1.0,
};

pub(super) const AGX: Published = Published {
    inset: [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_655, 0.078_433_6, 0.879_143],
    ],
    curve: Curve::Logarithmic {
        between: [-12.473_93, 4.026_069],
        polynomial: [-0.002_32, 0.119_1, 0.429_8, -6.868, 31.96, -40.14, 15.5],
    },
    outset: [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_852, 1.151_903_1, -0.098_961_18],
        [-0.052_971_636, -0.098_043_45, 1.151_073_7],
    ],
    power: 2.2,
};

impl Published {
    /// Maps an exposed colour without negative channels. The result is clamped only if a power
    /// follows.
    pub(super) fn of(&self, exposed: Rgb) -> Rgb {
        let inset = times(&self.inset, exposed.map(|v| v.min(BRIGHTEST)));
        let shown = times(&self.outset, inset.map(|v| self.curve.at(v)));
        if self.power == 1.0 { shown } else { shown.map(|v| powf(v.clamp(0.0, 1.0), self.power)) }
    }
}

impl Curve {
    /// Value of the curve at `x`, which is not negative.
    fn at(&self, x: f32) -> f32 {
        match self {
            Self::Rational { over, under } => polynomial(over, x) / polynomial(under, x),
            Self::Logarithmic { between: [low, high], polynomial: coefficients } => {
                // The logarithm of 0 is −∞, the lower end.
                let stops = (ln(x) / std::f32::consts::LN_2).clamp(*low, *high);
                polynomial(coefficients, (stops - low) / (high - low))
            }
        }
    }
}

/// Evaluates a polynomial by Horner's rule, from the highest power on.
fn polynomial(coefficients: &[f32], x: f32) -> f32 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

fn times(rows: &Matrix, c: Rgb) -> Rgb {
    rows.map(|[r, g, b]| r * c.r + g * c.g + b * c.b).into()
}
