//! Interface for bounds of the material term.

use super::{Reflector, Towards};

/// An upper bound of the material term `M` of gather points; bounds are merged up the gather tree.
pub trait UpperMaterial: Clone + Send + Sync {
    /// Creates the bound of one point.
    fn of_point(point: &Reflector) -> Self;

    /// Extends the bound to all points of `other`.
    fn merge(&mut self, other: &Self);

    /// Upper bound of the largest channel of `M` (sr⁻¹) over all points merged into `self` and all
    /// directions of `towards`.
    fn upper_material(&self, towards: &Towards) -> f32;
}
