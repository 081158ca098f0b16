//! Route of light to a VPL: the kind of its emitter, and the way from there.

use super::VplKind;

/// Kind of an emitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A surface of the scene that emits light.
    Surface,
    /// A point: an omnidirectional light, a spot light or a light with an image.
    Point,
    /// Infinity: an environment or a directional light.
    Infinity,
}

impl Origin {
    /// Number of kinds.
    pub const COUNT: usize = 3;

    /// Returns the kind of emitter that corresponds to a kind of light.
    pub(super) fn of(kind: VplKind) -> Self {
        match kind {
            VplKind::Oriented | VplKind::Volume(_) => Self::Surface,
            VplKind::Omni | VplKind::Spot(_) | VplKind::Image(_) => Self::Point,
            VplKind::Directional => Self::Infinity,
        }
    }
}

/// Way of light from an emitter to a VPL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Along a straight line, perhaps through thin panes.
    Straight,
    /// Only over specular surfaces, at least one of which changed the direction of the light.
    Specular,
    /// Over at least one surface or medium that scattered the light.
    Scattered,
}

impl Way {
    /// Number of ways.
    pub const COUNT: usize = 3;
}

/// Route of the light of a VPL.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Route {
    /// Kind of the emitter that sent the light.
    pub origin: Origin,
    /// Way from the emitter to the VPL.
    pub way: Way,
}
