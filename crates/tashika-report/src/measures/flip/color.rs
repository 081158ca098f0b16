//! Perceived difference in colour from a distance (Andersson et al. 2020, section 4.1).
//!
//! 1. Linear RGB → XYZ → YCxCz, a space of opponent colours (Flohr et al. 1993), relative to the
//!    white `n` of the display: `Y = 116 Y/Yₙ − 16`, `Cx = 500 (X/Xₙ − Y/Yₙ)`,
//!    `Cz = 200 (Y/Yₙ − Z/Zₙ)`.
//! 2. Each channel is blurred by the contrast sensitivity of the eye, `Σ a √(π/b) exp(−π² d²/b)` of
//!    the distance `d` (degrees), with weights that add up to 1.
//! 3. Back to linear RGB, clamped to 0 to 1, and on to CIE L\*a\*b\* (CIE 15), whose `a*`, `b*` are
//!    scaled by `0.01 L*` (Hunt 1952).
//! 4. The distance is that of Abasi et al. 2020, `HyAB = |ΔL*| + √(Δa*² + Δb*²)`, raised to the
//!    power 0.7. In units of the distance between green and blue, the range from 0 to 0.4 is mapped
//!    to 0 to 0.95, and the rest to 0.95 to 1.

use std::f64::consts::PI;

use super::super::Pictures;
use super::super::grid::{Grid, Weights};
use crate::color::{Primaries, Rgb};
use crate::math::elementary::{exp_f64, powf_f64};

/// Parameters `a`, `b` (degrees squared) of a Gaussian of a channel.
type Gaussian = (f64, f64);
/// Contrast sensitivity of the channels Y, Cx, Cz (table 1 of the source).
const SENSITIVITY: [&[Gaussian]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
/// Largest `b`.
const WIDEST: f64 = 0.04;
/// Power to which `HyAB` is raised.
const EXPONENT: f64 = 0.7;
/// Share of the largest distance at which the slope of the mapping changes.
const KNEE: f64 = 0.4;
/// Difference that the knee is mapped to.
const AT_KNEE: f64 = 0.95;

type Matrix = [[f64; 3]; 3];

/// Conversions between linear RGB, XYZ, and the opponent colours.
struct Space {
    to_xyz: Matrix,
    from_xyz: Matrix,
    /// XYZ `Xₙ`, `Yₙ`, `Zₙ` of the display's white.
    white: [f64; 3],
}

/// Difference in colour at each pixel, 0 to 1.
pub(super) fn differences(pictures: &Pictures, pixels_per_degree: f64) -> Grid {
    let space = Space::new();
    let [a, b] = [0, 1].map(|picture| seen(&space, pictures, picture, pixels_per_degree));
    let largest = {
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|linear| space.perceived(linear));
        powf_f64(distance(green, blue), EXPONENT)
    };
    let knee = KNEE * largest;
    let spread = |difference: f64| {
        if difference < knee {
            AT_KNEE / knee * difference
        } else {
            AT_KNEE + (difference - knee) / (largest - knee) * (1.0 - AT_KNEE)
        }
    };
    let differences = a.iter().zip(&b).map(|(a, b)| spread(powf_f64(distance(*a, *b), EXPONENT)));
    Grid::new(pictures.width, differences)
}

/// The distance `HyAB` between two colours.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [l, x, y] = [0, 1, 2].map(|i| a[i] - b[i]);
    l.abs() + (x * x + y * y).sqrt()
}

/// A picture as perceived: `L*` and the scaled `a*`, `b*`.
fn seen(space: &Space, pictures: &Pictures, picture: usize, pixels_per_degree: f64) -> Vec<[f64; 3]> {
    // The widest Gaussian is negligible beyond three standard deviations.
    let deviation = (0.5 * WIDEST).sqrt() / PI;
    let radius = (3.0 * deviation * pixels_per_degree).ceil() as usize;
    let opponents = || pictures.colors[picture].iter().map(|color| space.opponents(*color));
    let [y, cx, cz] = [0, 1, 2].map(|channel| {
        let sharp = Grid::new(pictures.width, opponents().map(|color| color[channel]));
        blurred(&sharp, SENSITIVITY[channel], radius, pixels_per_degree)
    });
    let blurred = y.values.iter().zip(&cx.values).zip(&cz.values);
    blurred.map(|((y, cx), cz)| space.perceived(space.shown([*y, *cx, *cz]))).collect()
}

/// A channel at the resolution of the eye.
fn blurred(channel: &Grid, gaussians: &[Gaussian], radius: usize, pixels_per_degree: f64) -> Grid {
    let weights = gaussians.iter().map(|(a, b)| {
        let weights = Weights::of(radius, |x| {
            let angle = PI * x / pixels_per_degree;
            exp_f64(-angle * angle / b)
        });
        let sum = weights.sum();
        (a * (PI / b).sqrt() * sum * sum, weights.normalized())
    });
    let weights: Vec<(f64, Weights)> = weights.collect();
    let sum: f64 = weights.iter().map(|(share, _)| share).sum();
    let parts = weights.iter().map(|(share, weights)| {
        let mut part = channel.weighed(weights, weights);
        part.values.iter_mut().for_each(|value| *value *= share / sum);
        part
    });
    parts.reduce(|all, part| all.with(&part, |a, b| a + b)).expect("a channel has a Gaussian")
}

impl Space {
    fn new() -> Self {
        let to_xyz = Primaries::REC709.to_xyz();
        Self { to_xyz, from_xyz: Primaries::REC709.from_xyz(), white: times(&to_xyz, [1.0; 3]) }
    }

    /// Converts linear RGB to YCxCz.
    fn opponents(&self, linear: Rgb) -> [f64; 3] {
        let [x, y, z] = self.relative(linear.to_array().map(f64::from));
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// Converts YCxCz to linear RGB, clamped to the range of a display.
    fn shown(&self, [luma, cx, cz]: [f64; 3]) -> [f64; 3] {
        let y = (luma + 16.0) / 116.0;
        let [xn, yn, zn] = self.white;
        let xyz = [(y + cx / 500.0) * xn, y * yn, (y - cz / 200.0) * zn];
        times(&self.from_xyz, xyz).map(|v| v.clamp(0.0, 1.0))
    }

    /// Converts linear RGB to `L*` and the scaled `a*`, `b*`.
    fn perceived(&self, linear: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.relative(linear).map(lightness);
        let l = 116.0 * y - 16.0;
        let hunt = 0.01 * l;
        [l, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
    }

    /// XYZ relative to the XYZ of white.
    fn relative(&self, linear: [f64; 3]) -> [f64; 3] {
        let xyz = times(&self.to_xyz, linear);
        [0, 1, 2].map(|i| xyz[i] / self.white[i])
    }
}

/// Function `f` of CIE L\*a\*b\*: the cube root, and a line near black.
fn lightness(relative: f64) -> f64 {
    const DELTA: f64 = 6.0 / 29.0;
    if relative > DELTA * DELTA * DELTA {
        powf_f64(relative, 1.0 / 3.0)
    } else {
        relative / (3.0 * DELTA * DELTA) + 4.0 / 29.0
    }
}

fn times(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
}
