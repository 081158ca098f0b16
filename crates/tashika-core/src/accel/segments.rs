//! Batches of segments, as fans.

use std::ops::Range;

use glam::Vec3;

/// The end that all segments of a fan have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Apex {
    /// A point (m).
    Point(Vec3),
    /// Infinity: segments run from each target along this direction.
    Direction(Vec3),
}

/// Segments from one apex to several targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Fan {
    /// The common end.
    pub apex: Apex,
    /// The targets, as a range of the batch's.
    pub targets: Range<u32>,
}

/// What glass does to segments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Glass {
    /// Lets pass straight what would be refracted: the light comes through, its caustics do not.
    #[default]
    Passes,
    /// Panes let pass, as they do not bend light; solid glass stops, for those who follow refracted
    /// paths.
    SolidStops,
}

/// A batch of segments whose visibility is asked for at once.
///
/// Both ends of each segment must have left the surfaces that they lie on
/// ([`SurfacePoint::leave`](crate::scene::SurfacePoint::leave)).
#[derive(Clone, Debug, Default)]
pub struct SegmentBatch {
    /// What glass does to them.
    pub glass: Glass,
    fans: Vec<Fan>,
    targets: Vec<Vec3>,
}

impl SegmentBatch {
    /// An empty batch.
    pub fn new(glass: Glass) -> Self {
        Self { glass, ..Self::default() }
    }

    /// Forgets all segments but keeps the memory.
    pub fn clear(&mut self) {
        self.fans.clear();
        self.targets.clear();
    }

    /// Adds a fan; without targets it leaves no trace.
    pub fn push_fan(&mut self, apex: Apex, targets: impl IntoIterator<Item = Vec3>) {
        let start = self.targets.len() as u32;
        self.targets.extend(targets);
        let end = self.targets.len() as u32;
        if end > start {
            self.fans.push(Fan { apex, targets: start..end });
        }
    }

    /// How many segments there are.
    pub fn len(&self) -> usize {
        self.targets.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.targets.is_empty()
    }

    /// The fans, in order.
    pub fn fans(&self) -> &[Fan] {
        &self.fans
    }

    /// All targets, in order.
    pub fn targets(&self) -> &[Vec3] {
        &self.targets
    }
}
