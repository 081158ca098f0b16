//! Route of light to the place where a VPL stands: kind of emitter, and way from there.

use super::VplKind;

/// Kind of an emitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An emissive surface, drawn at a point of its area.
    Surface,
    /// A point: an omnidirectional light, a spot light or an image of one.
    Point,
    /// Infinity: an environment or a directional light.
    Infinity,
}

impl Origin {
    /// Number of kinds.
    pub const COUNT: usize = 3;

    /// The kind of emitter that a light of this kind is drawn on.
    pub(super) fn of(kind: VplKind) -> Self {
        match kind {
            VplKind::Oriented | VplKind::Volume(_) => Self::Surface,
            VplKind::Omni | VplKind::Spot(_) | VplKind::Image(_) => Self::Point,
            VplKind::Directional => Self::Infinity,
        }
    }
}

/// Way of light from an emitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Along a straight line, also through thin panes and holes.
    Straight,
    /// Over specular surfaces only, at least one of which bent it.
    Specular,
    /// Over at least one surface or medium that scatters light.
    Scattered,
}

impl Way {
    /// Number of ways.
    pub const COUNT: usize = 3;
}

/// Route of the light of a VPL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Route {
    /// Kind of emitter.
    pub origin: Origin,
    /// Way from the emitter to the VPL.
    pub way: Way,
}
