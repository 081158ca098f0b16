//! What stopped segments lately: tried before a walk, which it saves if it stops the next one, too.
//!
//! Neighbouring pixels look at the same clusters of lights past the same things: of the segments
//! that are blocked, two fifths or more are blocked by the leaf that stopped the last one with
//! about their direction.
//!
//! # Guarantee
//! The answer is the one of the walk: what is tried is a leaf whose box the segment meets, so that
//! the walk would come to it (`beam`), and only if nothing at all passes it. Held to this by
//! `accel::tests::what_was_asked_before_does_not_matter`, and on the segments of whole renders by
//! the benchmark `tracing`.

use glam::Vec3;

/// Cells of directions along each side of a cube's face.
const CELLS: usize = 8;

/// A leaf of a tree: a child of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Leaf {
    pub node: u32,
    pub slot: u32,
}

/// The leaves that stopped the last segments of each cell of directions.
pub(super) struct Occluders([Leaf; 6 * CELLS * CELLS]);

impl Occluders {
    /// None: the first child of the first node is as good a guess as any.
    pub const fn new() -> Self {
        Self([Leaf { node: 0, slot: 0 }; 6 * CELLS * CELLS])
    }

    /// That of the cell of a direction.
    #[inline(always)]
    pub fn of(&mut self, direction: Vec3) -> &mut Leaf {
        &mut self.0[cell(direction)]
    }
}

/// The cell of a cube's surface that a direction points to; of no direction, any.
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
