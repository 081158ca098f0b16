//! Transmittance of a rough dielectric boundary for light from one direction.
//!
//! ```text
//! T(c) ≈ k T₀(c) + q₀ + q₁ c + q₂ c² + q₃ c³          in [0, 1]
//! ```
//!
//! with the transmittance `T₀ = 1 − F` of the smooth boundary. The coefficients come from tables
//! over roughness and index, one table for each [`FacetModel`], fitted to single scattering at
//! facets (Walter et al. 2007). Smooth boundaries are exact. For rough ones, `T` is off by at most
//! 2 % at cosines above 0.1 and by at most 8 % below, and `F_int` by at most 0.02. For Mitsuba's
//! models, 0.01 of the latter is due to the quadrature of `F_int`, which follows Mitsuba's.
//!
//! # Held to this by
//! The tests below, which compare the tables with light at randomly drawn facets.
//! `bounds::lobes::fresnel` relies on the form of the fit.

mod table;

use super::{FacetModel, MIN_ALPHA, Microfacets, fresnel};
use crate::math::Real;
use table::{ALPHAS, BECKMANN, Fits, GGX, GGX_INDEPENDENT, IORS};

/// A rough or smooth boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    ior: f32,
    /// Coefficient `k`.
    smooth: f32,
    /// Coefficients `q₀` to `q₃`.
    cubic: [f32; 4],
    inside: f32,
}

/// Returns the index of the interval between increasing nodes that contains a value, and the share
/// of the interval that lies below the value. Values outside are clamped to the nearest node.
fn between(nodes: &[f32], value: f32) -> (usize, f32) {
    let first = nodes.partition_point(|node| *node <= value).clamp(1, nodes.len() - 1) - 1;
    (first, ((value - nodes[first]) / (nodes[first + 1] - nodes[first])).clamp(0.0, 1.0))
}

impl Boundary {
    /// Creates the boundary to a medium of relative index `ior`, from 1.0001 to 5, with facets of a
    /// roughness in `[0, 1]`. Up to [`MIN_ALPHA`] the boundary is smooth. Brushed facets count as
    /// isotropic ones of their root mean square roughness. The error of this was measured for a
    /// coat of index 1.5 with roughnesses of 0.1 and 0.4: seen from at least 40° above the surface,
    /// the reflectance of coat and base is within 2 % of a simulation. Seen from 12° above the
    /// surface, along the axis of the smaller roughness, it is 8 % too high.
    #[inline]
    pub fn new(facets: Microfacets, ior: f32) -> Self {
        let entering = 1.0 - fresnel::dielectric_average(ior);
        let smooth = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0 - entering / (ior * ior)];
        let alpha = facets.root_mean_square();
        let [k, q @ .., inside] =
            if alpha > MIN_ALPHA { fitted(alpha, facets.model, ior, smooth) } else { smooth };
        Self { ior, smooth: k, cubic: q, inside }
    }

    /// `T` at the cosine of the angle of incidence, from the outside.
    #[inline(always)]
    pub fn transmittance<R: Real>(&self, cos: R) -> R {
        let [a, b, c, d] = self.cubic.map(R::splat);
        let smooth = R::splat(1.0) - fresnel::dielectric(cos, self.ior);
        let fit = R::splat(self.smooth) * smooth + (((d * cos + c) * cos + b) * cos + a);
        fit.max(R::splat(0.0)).min(R::splat(1.0))
    }

    /// `2 ∫₀¹ T(c) c dc`: transmittance for uniform light from outside.
    #[inline]
    pub fn mean_transmittance(&self) -> f32 {
        let [a, b, c, d] = self.cubic;
        let smooth = 1.0 - fresnel::dielectric_average(self.ior);
        self.smooth * smooth + a + b * (2.0 / 3.0) + c * 0.5 + d * 0.4
    }

    /// `F_int`: reflectance from the inside for uniform light.
    #[inline]
    pub fn inside(&self) -> f32 {
        self.inside
    }

    /// Coefficients `k`, and `q₀` to `q₃`.
    pub fn fit(&self) -> (f32, [f32; 4]) {
        (self.smooth, self.cubic)
    }
}

/// Coefficients of the table, interpolated at a roughness and an index.
fn fitted(alpha: f32, model: FacetModel, ior: f32, smooth: [f32; 6]) -> [f32; 6] {
    let fits: &Fits = match model {
        FacetModel::Ggx => &GGX,
        FacetModel::GgxIndependent => &GGX_INDEPENDENT,
        FacetModel::Beckmann => &BECKMANN,
    };
    let (column, across) = between(&IORS, ior);
    let row = |row: &[[f32; 6]; IORS.len()]| mixed(&row[column], &row[column + 1], across);
    if alpha < ALPHAS[0] {
        return mixed(&smooth, &row(&fits[0]), (alpha - MIN_ALPHA) / (ALPHAS[0] - MIN_ALPHA));
    }
    let (first, along) = between(&ALPHAS, alpha);
    mixed(&row(&fits[first]), &row(&fits[first + 1]), along)
}

fn mixed(a: &[f32; 6], b: &[f32; 6], share: f32) -> [f32; 6] {
    std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::math::elementary::{erfc, exp_f64};
    use crate::rng::{Purpose, Stream};

    /// `G₂ / G₁(o)` for directions at these cosines.
    fn unshadowed(seen: f32, cos: f32, facets: Microfacets) -> f32 {
        let (alpha, model) = (facets.mean(), facets.model);
        let slope = |cos: f32| alpha * (1.0 - cos * cos).max(0.0).sqrt() / cos;
        let inverse = |cos: f32| 0.5 * (1.0 + (1.0 + slope(cos) * slope(cos)).sqrt());
        let slope = slope(cos);
        match model {
            FacetModel::Ggx => return inverse(seen) / (inverse(seen) + inverse(cos) - 1.0),
            FacetModel::GgxIndependent => return 1.0 / inverse(cos),
            FacetModel::Beckmann => {}
        }
        let a = f64::from(1.0 / slope.max(1e-6));
        let (gauss, root_pi) = (exp_f64(-a * a), std::f64::consts::PI.sqrt());
        (1.0 / (1.0 + 0.5 * (gauss / (a * root_pi) - erfc(a)).max(0.0))) as f32
    }

    /// Share of the light arriving at cosine `cos` that facets transmit (`through`), or reflect.
    fn drawn(cos: f32, facets: Microfacets, eta: f32, through: bool, draws: u32, s: &mut Stream) -> f64 {
        let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
        let mut sum = 0.0;
        for _ in 0..draws {
            let h = facets.sample_visible_normal(wo, s.uniform_2());
            let incidence = wo.dot(h);
            let reflected = fresnel::dielectric(incidence, eta);
            let behind2 = 1.0 - (1.0 - incidence * incidence) / (eta * eta);
            let (on, passed) = if through {
                (h * (incidence / eta - behind2.max(0.0).sqrt()) - wo / eta, 1.0 - reflected)
            } else {
                (h * (2.0 * incidence) - wo, reflected)
            };
            if (on.z < 0.0) == through && passed > 0.0 {
                sum += f64::from(unshadowed(cos, on.z.abs(), facets) * passed);
            }
        }
        sum / f64::from(draws)
    }

    #[test]
    fn the_table_is_what_facets_let_through() {
        let mut s = Stream::new(11, Purpose::Test, 0);
        let alphas = [0.01, 0.03, 0.1, 0.2, 0.42, 0.75, 1.0];
        for facets in
            FacetModel::ALL.iter().flat_map(|&model| alphas.map(|alpha| Microfacets::even(alpha, model)))
        {
            for ior in [1.2, 1.5, 1.62, 2.4, 4.0] {
                let boundary = Boundary::new(facets, ior);
                for cos in [0.03, 0.12, 0.3, 0.6, 1.0] {
                    let (found, expected) = (
                        f64::from(boundary.transmittance(cos)),
                        drawn(cos, facets, ior, true, 40_000, &mut s),
                    );
                    // Four standard errors of a mean of numbers in [0, 1], and the stated error of
                    // the table.
                    let allowed = 0.006 + if cos < 0.1 { 0.08 } else { 0.02 } * expected;
                    let at = (facets, ior, cos);
                    assert!((found - expected).abs() < allowed, "{at:?}: {found} for {expected}");
                }
                // Many cosines are needed, since total reflection begins abruptly at one cosine.
                let cosines = 200;
                let inside: f64 = (0..cosines)
                    .map(|i| (i as f32 + 0.5) / cosines as f32)
                    .map(|c| {
                        2.0 * f64::from(c) * drawn(c, facets, 1.0 / ior, false, 1000, &mut s)
                            / f64::from(cosines)
                    })
                    .sum();
                let found = f64::from(boundary.inside());
                assert!((found - inside).abs() < 0.02, "{facets:?} {ior}: inside {found} for {inside}");
                let mean: f64 = (0..1000)
                    .map(|i| (i as f32 + 0.5) / 1000.0)
                    .map(|c| 2e-3 * f64::from(c * boundary.transmittance(c)))
                    .sum();
                assert!((mean - f64::from(boundary.mean_transmittance())).abs() < 1e-3, "{facets:?} {ior}");
            }
        }
    }
}
