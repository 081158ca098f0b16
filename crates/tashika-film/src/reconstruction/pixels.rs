//! Irradiance, variance and features of pixels, from which their similarity follows.

use crate::color::Rgb;
use crate::film::{Film, Plane, PlaneSpec, planes};
use crate::math::elementary::ln;

/// Added to the albedo, so that the irradiance of dark surfaces stays finite.
const LEAST_ALBEDO: f32 = 0.02;
/// Luminance of the albedo below which a pixel is no surface, but emission or background.
const NO_SURFACE: f32 = 1e-3;
/// Scales `σ` of normals, of albedos, of logarithms of depths, of coverages. Chosen.
const SIGMAS: [f32; 4] = [0.15, 0.08, 0.05, 0.05];
/// Depth of the background (m).
const FAR: f32 = 1e6;

/// Features of a pixel that is similar to no other.
const UNLIKE_ANY: [f32; FEATURES] = [f32::INFINITY; FEATURES];

/// Number of features of the first surface: normal, albedo, depth and coverage.
const FEATURES: usize = 8;

/// Features, irradiance and variance of a film's pixels, row by row.
pub struct Pixels {
    pub width: usize,
    pub height: usize,
    /// Divisor of colours: the albedo plus 0.02; white if the pixel shows no surface.
    pub albedo: Vec<Rgb>,
    /// Irradiance `E`; black where it is not finite.
    pub irradiance: Vec<Rgb>,
    /// Variance of the luminance of `irradiance`.
    pub variance: Vec<f32>,
    /// Features in units of `√2 σ`, so that `F²` is the square of a distance.
    features: Vec<[f32; FEATURES]>,
}

impl Pixels {
    /// Reads a film; `None` if it lacks a plane.
    pub fn of(film: &Film) -> Option<Self> {
        let window = film.window();
        let plane = |spec: PlaneSpec| {
            let plane = film.plane(spec).filter(|p| p.channels().len() == spec.channels.len());
            plane.and_then(Plane::f32_samples)
        };
        let (albedo, normal) = (plane(planes::ALBEDO)?, plane(planes::NORMAL)?);
        let (depth, coverage) = (plane(planes::DEPTH)?, plane(planes::COVERAGE)?);
        let standard_error = plane(planes::STANDARD_ERROR)?;
        let albedo: Vec<Rgb> = albedo
            .chunks_exact(3)
            .map(|a| Rgb::new(a[0], a[1], a[2]))
            .map(|a| if a.luminance() > NO_SURFACE { a + Rgb::gray(LEAST_ALBEDO) } else { Rgb::WHITE })
            .collect();
        let irradiance =
            film.colors()?.zip(&albedo).map(|(color, albedo)| color.zip(*albedo, |c, a| c / a)).collect();
        let variance = standard_error.iter().zip(&albedo).map(|(error, albedo)| {
            let error = error / albedo.luminance();
            error * error
        });
        let scale = SIGMAS.map(|sigma| 1.0 / (std::f32::consts::SQRT_2 * sigma));
        let features = (0..albedo.len()).map(|i| {
            let depth = if depth[i] > 0.0 { depth[i].min(FAR) } else { FAR };
            let [x, y, z] = [0, 1, 2].map(|k| scale[0] * normal[3 * i + k]);
            let [r, g, b] = albedo[i].map(|c| scale[1] * c).to_array();
            [x, y, z, r, g, b, scale[2] * ln(depth), scale[3] * coverage[i]]
        });
        let mut features: Vec<_> = features.collect();
        let (mut irradiance, mut variance): (Vec<Rgb>, Vec<f32>) = (irradiance, variance.collect());
        for ((features, irradiance), variance) in features.iter_mut().zip(&mut irradiance).zip(&mut variance)
        {
            if !(irradiance.is_finite() && variance.is_finite()) {
                *features = UNLIKE_ANY;
                (*irradiance, *variance) = (Rgb::BLACK, 0.0);
            }
        }
        Some(Self {
            width: window.width as usize,
            height: window.height as usize,
            irradiance,
            variance,
            features,
            albedo,
        })
    }

    /// Excludes the pixels that `other`, the other half of the picture, excludes: the mean of both
    /// halves needs a value from each.
    pub fn without_those_of(&mut self, other: &Self) {
        for (p, features) in self.features.iter_mut().enumerate() {
            if other.features[p] == UNLIKE_ANY {
                *features = UNLIKE_ANY;
            }
        }
    }

    /// Distance `F²` of two pixels; infinite or NaN if the radiance or error of one is not finite.
    #[inline]
    pub fn distance(&self, p: usize, q: usize) -> f32 {
        let (p, q) = (&self.features[p], &self.features[q]);
        let mut sum = 0.0;
        for k in 0..FEATURES {
            let difference = p[k] - q[k];
            sum += difference * difference;
        }
        sum
    }

    /// Returns true if a pixel has a neighbour at this offset.
    pub fn has(&self, [x, y]: [usize; 2], [dx, dy]: [isize; 2]) -> bool {
        x.checked_add_signed(dx).is_some_and(|x| x < self.width)
            && y.checked_add_signed(dy).is_some_and(|y| y < self.height)
    }
}
