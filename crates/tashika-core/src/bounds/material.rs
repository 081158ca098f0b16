//! What a bound of the material term can do.

use super::{Reflector, Towards};

/// A bound of the material term `M` of gather points, merged up the gather tree.
pub trait UpperMaterial: Clone + Send + Sync {
    /// The bound of one point.
    fn of_point(point: &Reflector) -> Self;

    /// Makes `self` hold for what `other` holds for, too.
    fn merge(&mut self, other: &Self);

    /// At least the largest channel of `M` (sr⁻¹) over all points merged into `self` and all
    /// directions of `towards`.
    fn upper_material(&self, towards: &Towards) -> f32;
}
