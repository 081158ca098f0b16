//! Bound of the material term that uses no directions except the cone of normals.
//!
//! ```text
//! M ≤ K cos⁺(normals, lights) + P          K = max of the diffuse parts, P = max over all directions of lobe · cos⁺          (sr⁻¹)
//! ```
//!
//! Sakai et al. 2018 bound diffuse surfaces by the largest value of the BRDF times the largest
//! cosine. The bound of diffuse surfaces here is the same, except for roundings. A lobe is bounded
//! by `P`, the peak of the lobe times the cosine. Without the cosine, GGX lobes have no useful
//! maximum, as they grow without bound towards grazing angles.
//!
//! # Guarantee
//! The bound is at least `M` of every point merged, in the `f32` arithmetic of
//! [`contribution`](crate::contribution). It is zero where all lights are below the plane of every
//! shading normal.
//!
//! # Held to this by
//! `bounds::tests::analytic`.

use super::lobes::round_up;
use super::{Reflector, Towards, UpperMaterial};
use crate::bsdf::MIN_COSINE;
use crate::math::Cone;

/// Maxima over all directions of the diffuse part and of the rest, and the cone of normals.
#[derive(Clone, Copy, Debug)]
pub struct UpperConstant {
    /// Shading normals on the side of the viewer.
    normals: Cone,
    /// `K` (sr⁻¹).
    diffuse: f32,
    /// `P` (sr⁻¹).
    peak: f32,
}

impl UpperMaterial for UpperConstant {
    fn of_point(point: &Reflector) -> Self {
        if point.wo.z.abs() <= MIN_COSINE {
            return Self { normals: Cone::EMPTY, diffuse: 0.0, peak: 0.0 };
        }
        let bounds = point.upper_over_all();
        let normals = Cone::of(point.normal());
        Self { normals, diffuse: round_up(bounds.diffuse), peak: round_up(bounds.lobe_cos + bounds.coat_cos) }
    }

    fn merge(&mut self, other: &Self) {
        self.normals = self.normals.union(other.normals);
        self.diffuse = self.diffuse.max(other.diffuse);
        self.peak = self.peak.max(other.peak);
    }

    fn upper_material(&self, towards: &Towards) -> f32 {
        if self.normals.is_empty() {
            return 0.0;
        }
        let cos = towards.upper_cos(&self.normals);
        if cos <= 0.0 {
            return 0.0;
        }
        round_up(f64::from(self.diffuse) * f64::from(cos) + f64::from(self.peak))
    }
}
