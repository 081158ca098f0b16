//! Leaves that blocked recent segments. The leaf is tested before the traversal: if it blocks the
//! next segment, too, the traversal is saved.
//!
//! Neighbouring pixels see the same clusters of lights past the same geometry. At least two fifths
//! of the blocked segments are blocked by the leaf that blocked the last segment of nearly the same
//! direction.
//!
//! # Guarantee
//! The answer is the same as that of the traversal. A leaf is tested only if the segment meets its
//! box, in which case the traversal would reach the leaf (`beam`). It ends the query only if its
//! transmittance is zero. Held to this by `accel::tests::what_was_asked_before_does_not_matter`,
//! and on the segments of whole renders by the benchmark `tracing`.

use glam::Vec3;

/// Number of cells along each side of a face of the cube of directions.
const CELLS: usize = 8;

/// A leaf of a tree, as a child of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Leaf {
    pub node: u32,
    pub slot: u32,
}

/// For each cell of directions, the leaf that blocked the last segment in that cell.
pub(super) struct Occluders([Leaf; 6 * CELLS * CELLS]);

impl Occluders {
    /// Starts with the first child of the root in all cells, an arbitrary guess.
    pub const fn new() -> Self {
        Self([Leaf { node: 0, slot: 0 }; 6 * CELLS * CELLS])
    }

    /// Leaf that is stored for the cell of a direction.
    #[inline(always)]
    pub fn of(&mut self, direction: Vec3) -> &mut Leaf {
        &mut self.0[cell(direction)]
    }
}

/// Index of the cell of the cube's surface that a direction points to; an arbitrary cell if the
/// direction is zero or NaN.
#[inline(always)]
fn cell(direction: Vec3) -> usize {
    let d = direction.to_array();
    let size = direction.abs().to_array();
    let axis = if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 1 + usize::from(size[1] < size[2]) };
    let scale = 0.5 * CELLS as f32 / size[axis];
    let along = |other: usize| {
        let at = 0.5 * CELLS as f32 + d[(axis + other) % 3] * scale;
        (at as usize).min(CELLS - 1)
    };
    ((2 * axis + usize::from(d[axis] > 0.0)) * CELLS + along(1)) * CELLS + along(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};
    use crate::warp;

    #[test]
    fn every_direction_has_a_cell_and_every_cell_directions_that_are_close() {
        let mut s = Stream::new(1, Purpose::Test, 0);
        let mut first = [None; 6 * CELLS * CELLS];
        for _ in 0..100_000 {
            let d = warp::sphere(s.uniform_2());
            let first = first[cell(d * 1e3)].get_or_insert(d);
            assert!(first.dot(d) > 0.9, "{first} and {d}");
        }
        assert!(first.iter().all(Option::is_some));
        for odd in [Vec3::ZERO, Vec3::X, Vec3::NEG_Z, Vec3::splat(1e-40), Vec3::splat(3e38), Vec3::NAN] {
            assert!(cell(odd) < first.len());
        }
    }
}
