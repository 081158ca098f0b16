//! Bounds of a cluster of lights: their positions and their directions.

use crate::bsdf::HenyeyGreenstein;
use crate::math::{Aabb, Cone};

/// Bounds of a cluster of lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBounds {
    /// Box around the positions (m); empty if all lights are directional.
    pub aabb: Aabb,
    /// Kinds and directions of the lights.
    pub shape: LightShape,
}

/// Kinds of lights in a cluster, and their directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// All shine equally in all directions.
    Omni,
    /// All shine with a cosine lobe around a normal in the cone.
    Oriented(Cone),
    /// All have a relative intensity of at most 1 within the angle `arccos cos_outer` around an
    /// axis in the cone, and zero outside that angle.
    Spot {
        /// Cone that holds the axes.
        axes: Cone,
        /// Cosine of the widest half-angle.
        cos_outer: f32,
    },
    /// All shine from infinity, travelling in a direction of the cone.
    Directional(Cone),
    /// All lie in media and scatter by phase functions around a direction of the cone.
    Volume {
        /// Directions in which light travelled before it was scattered at the lights.
        directions: Cone,
        /// Least and largest asymmetry of the phase functions.
        asymmetry: [f32; 2],
    },
    /// Lights of several kinds.
    Mixed {
        /// Upper bound of each light's intensity in any direction, relative to its nominal
        /// intensity; at least 1.
        peak: f32,
    },
}

impl LightShape {
    /// Upper bound of each light's intensity in any direction, relative to its nominal intensity;
    /// at least 1.
    pub fn upper_peak(&self) -> f32 {
        match *self {
            Self::Omni | Self::Oriented(_) | Self::Spot { .. } | Self::Directional(_) => 1.0,
            Self::Volume { asymmetry, .. } => upper_relative([-1.0, 1.0], asymmetry).max(1.0),
            Self::Mixed { peak } => peak,
        }
    }
}

/// Upper bound of `4π p` over intervals of cosines and asymmetries, as rounded by `contribution`.
pub(super) fn upper_relative(cos: [f32; 2], asymmetry: [f32; 2]) -> f32 {
    (4.0 * std::f32::consts::PI * HenyeyGreenstein::upper_density(cos, asymmetry)).next_up()
}

impl LightBounds {
    /// Returns true if some of the lights may be at infinity.
    pub fn reaches_infinity(&self) -> bool {
        matches!(self.shape, LightShape::Directional(_) | LightShape::Mixed { .. })
    }

    /// Bounds of the union of two clusters.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        use LightShape::{Directional, Mixed, Omni, Oriented, Spot, Volume};
        let shape = match (self.shape, other.shape) {
            (Omni, Omni) => Omni,
            (Oriented(a), Oriented(b)) => Oriented(a.union(b)),
            (Directional(a), Directional(b)) => Directional(a.union(b)),
            (Spot { axes: a, cos_outer: p }, Spot { axes: b, cos_outer: q }) => {
                Spot { axes: a.union(b), cos_outer: p.min(q) }
            }
            (Volume { directions: a, asymmetry: [p, q] }, Volume { directions: b, asymmetry: [r, s] }) => {
                Volume { directions: a.union(b), asymmetry: [p.min(r), q.max(s)] }
            }
            (a, b) => Mixed { peak: a.upper_peak().max(b.upper_peak()) },
        };
        Self { aabb: self.aabb.union(other.aabb), shape }
    }
}
