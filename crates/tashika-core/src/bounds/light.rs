//! What is known of a cluster of lights: where they are, and where they shine.

use crate::math::{Aabb, Cone};

/// Bounds of a cluster of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    /// Box about the positions (m); empty if all lights are directional.
    pub aabb: Aabb,
    /// What the lights have in common.
    pub shape: LightShape,
}

/// Kinds of lights in a cluster, and their directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// All shine equally in all directions.
    Omni,
    /// All shine with a cosine lobe about a normal in the cone.
    Oriented(Cone),
    /// All shine at most 1 into the angle `arccos cos_outer` about an axis in the cone, and nothing
    /// beyond.
    Spot {
        /// The axes.
        axes: Cone,
        /// Cosine of the widest half-angle.
        cos_outer: f32,
    },
    /// All shine from infinity, travelling in a direction of the cone.
    Directional(Cone),
    /// Several kinds.
    Mixed,
}

impl LightBounds {
    /// Whether some of the lights are infinitely far away.
    pub fn reaches_infinity(&self) -> bool {
        matches!(self.shape, LightShape::Directional(_) | LightShape::Mixed)
    }

    /// Bounds of both clusters together.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        use LightShape::{Directional, Mixed, Omni, Oriented, Spot};
        let shape = match (self.shape, other.shape) {
            (Omni, Omni) => Omni,
            (Oriented(a), Oriented(b)) => Oriented(a.union(b)),
            (Directional(a), Directional(b)) => Directional(a.union(b)),
            (Spot { axes: a, cos_outer: p }, Spot { axes: b, cos_outer: q }) => {
                Spot { axes: a.union(b), cos_outer: p.min(q) }
            }
            _ => Mixed,
        };
        Self { aabb: self.aabb.union(other.aabb), shape }
    }
}
