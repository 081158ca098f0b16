//! Batches of segments, grouped in fans.

use std::ops::Range;

use glam::Vec3;

/// The common end of the segments of a fan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Apex {
    /// A point in world space (m).
    Point(Vec3),
    /// Infinity: from each target a segment runs along this direction.
    Direction(Vec3),
}

/// Segments from one apex to several targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Fan {
    /// The common end.
    pub apex: Apex,
    /// Targets, as a range of [`SegmentBatch::targets`].
    pub targets: Range<u32>,
}

/// Effect of glass on segments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Glass {
    /// Glass transmits light without bending it: its shadow is partly lit, but has no caustics.
    #[default]
    Passes,
    /// Thin panes transmit light, since they do not bend it. Solid glass blocks it, for callers
    /// that follow refracted paths.
    SolidStops,
}

/// A batch of segments whose visibility is queried at once.
///
/// Ends that lie on surfaces must have been moved off them
/// ([`SurfacePoint::leave`](crate::scene::SurfacePoint::leave)).
#[derive(Clone, Debug, Default)]
pub struct SegmentBatch {
    /// Effect of glass on the segments.
    pub glass: Glass,
    fans: Vec<Fan>,
    targets: Vec<Vec3>,
}

impl SegmentBatch {
    /// An empty batch.
    pub fn new(glass: Glass) -> Self {
        Self { glass, ..Self::default() }
    }

    /// Removes all segments; keeps the allocated memory.
    pub fn clear(&mut self) {
        self.fans.clear();
        self.targets.clear();
    }

    /// Adds a fan, unless it has no targets.
    pub fn push_fan(&mut self, apex: Apex, targets: impl IntoIterator<Item = Vec3>) {
        let start = self.targets.len() as u32;
        self.targets.extend(targets);
        let end = self.targets.len() as u32;
        if end > start {
            self.fans.push(Fan { apex, targets: start..end });
        }
    }

    /// Number of segments.
    pub fn len(&self) -> usize {
        self.targets.len()
    }

    /// Returns true if there are no segments.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty()
    }

    /// The fans, in the order in which they were added.
    pub fn fans(&self) -> &[Fan] {
        &self.fans
    }

    /// The targets of all fans, in the order of the fans.
    pub fn targets(&self) -> &[Vec3] {
        &self.targets
    }
}
