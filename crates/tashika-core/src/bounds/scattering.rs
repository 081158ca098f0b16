//! Bound of the material term of gather points on surfaces and in media.
//!
//! ```text
//! M ≤ max( M_ub of the surfaces, p_ub of the media )          p_ub = max of p_g(ω·ω_i) over the directions ω, ω_i and the asymmetries g
//! ```
//!
//! Surfaces are bounded by any [`UpperMaterial`]. Phase functions are bounded by the extremes of
//! the cosine between the directions of paths from the viewer, which are in a cone, and the
//! directions to the lights ([`HenyeyGreenstein::upper_density`]).
//!
//! # Guarantee
//! The bound is at least `M` of every point merged, in the `f32` arithmetic of
//! [`contribution`](crate::contribution). If all points are on surfaces it is the bound of the
//! surfaces, to the bit.
//!
//! # Held to this by
//! `bounds::tests::scattering`.

use super::{Reflector, Towards, UpperMaterial};
use crate::bsdf::HenyeyGreenstein;
use crate::math::{Cone, Vec3};

/// A bound of the material term of gather points, some of which may lie in media.
#[derive(Clone, Copy, Debug)]
pub struct UpperScattering<B> {
    surfaces: Option<B>,
    media: Option<UpperPhase>,
}

/// Bounds of the phase functions of several points.
#[derive(Clone, Copy, Debug)]
struct UpperPhase {
    /// Directions in which the paths from the viewer arrived.
    before: Cone,
    /// Least and largest asymmetry of the phase functions.
    asymmetry: [f32; 2],
}

impl<B: UpperMaterial> UpperScattering<B> {
    /// Creates the bound of one point on a surface.
    pub fn of_surface(point: &Reflector) -> Self {
        Self { surfaces: Some(B::of_point(point)), media: None }
    }

    /// Creates the bound of one point in a medium; `before` is the unit direction in which the path
    /// from the viewer arrived.
    pub fn of_medium(before: Vec3, phase: HenyeyGreenstein) -> Self {
        let media = UpperPhase { before: Cone::of(before), asymmetry: [phase.asymmetry; 2] };
        Self { surfaces: None, media: Some(media) }
    }

    /// Extends the bound to all points of `other`.
    pub fn merge(&mut self, other: &Self) {
        match (&mut self.surfaces, &other.surfaces) {
            (Some(own), Some(others)) => own.merge(others),
            (own @ None, others) => own.clone_from(others),
            (Some(_), None) => {}
        }
        match (&mut self.media, &other.media) {
            (Some(own), Some(others)) => own.merge(others),
            (own @ None, others) => *own = *others,
            (Some(_), None) => {}
        }
    }

    /// Upper bound of the largest channel of `M` (sr⁻¹) over all points merged into `self` and all
    /// directions of `towards`.
    pub fn upper_material(&self, towards: &Towards) -> f32 {
        let of_surfaces = self.surfaces.as_ref().map_or(0.0, |surfaces| surfaces.upper_material(towards));
        match &self.media {
            None => of_surfaces,
            Some(media) => {
                let cos = towards.bounds_of_cos(&media.before);
                of_surfaces.max(HenyeyGreenstein::upper_density(cos, media.asymmetry))
            }
        }
    }
}

impl UpperPhase {
    fn merge(&mut self, other: &Self) {
        self.before = self.before.union(other.before);
        let ([least, largest], [a, b]) = (self.asymmetry, other.asymmetry);
        self.asymmetry = [least.min(a), largest.max(b)];
    }
}
