//! Perceived difference in edges and points (Andersson et al. 2020, section 4.2).
//!
//! Features are found in the luminance `Y` (0 to 1) by the derivatives of a Gaussian `g` of the
//! standard deviation `σ = 0.082°/2`, the width of easily detected features:
//!
//! ```text
//! edge  = |∇|,  by −x g(x) g(y)              point = |∇²|,  by (x²/σ² − 1) g(x) g(y)      and the same along y
//! ΔE_f  = ( max(|edge_x − edge_r|, |point_x − point_r|) / √2 )^½
//! ```
//!
//! Positive weights add up to 1, negative weights to −1, so that features are in 0 to √2.

use super::super::Pictures;
use super::super::grid::{Grid, Weights};
use crate::color::Primaries;
use crate::math::elementary::exp_f64;

/// Width of features, `2σ`, in degrees of the visual field.
const WIDTH: f64 = 0.082;

/// Difference in features at each pixel, 0 to 1.
pub(super) fn differences(pictures: &Pictures, pixels_per_degree: f64) -> Grid {
    let deviation = 0.5 * WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let gaussian = |x: f64| exp_f64(-x * x / (2.0 * deviation * deviation));
    let smooth = Weights::of(radius, gaussian).normalized();
    let slope = Weights::of(radius, |x| -x * gaussian(x)).balanced();
    let bend = Weights::of(radius, |x| (x * x / (deviation * deviation) - 1.0) * gaussian(x)).balanced();

    let [_, to_y, _] = Primaries::REC709.to_xyz();
    let luminances = [0, 1].map(|picture| {
        let luminance = |v: [f32; 3]| v.iter().zip(to_y).map(|(v, weight)| f64::from(*v) * weight).sum();
        Grid::new(pictures.width, pictures.colors[picture].iter().map(|c| luminance(c.to_array())))
    });
    let difference = |derivative: &Weights| {
        let [a, b] = luminances.each_ref().map(|luminance| {
            let along_x = luminance.weighed(derivative, &smooth);
            along_x.with(&luminance.weighed(&smooth, derivative), |x, y| (x * x + y * y).sqrt())
        });
        a.with(&b, |a, b| (a - b).abs())
    };
    difference(&slope)
        .with(&difference(&bend), |edge, point| (edge.max(point) / std::f64::consts::SQRT_2).sqrt().min(1.0))
}
