//! Order of lights in which consecutive lights are close to each other.

use rayon::prelude::*;

use super::{Vpl, VplKind};
use crate::math::Aabb;

/// Sorts lights by kind, then along a Z-order curve through `bounds`. Directional lights follow a
/// curve through their directions.
pub(super) fn sort_by_place(lights: &mut [Vpl], bounds: Aabb) {
    let size = bounds.size().max_element().max(f32::MIN_POSITIVE);
    let code = |l: &Vpl| {
        let (kind, unit) = match l.kind {
            VplKind::Omni => (0, (l.position - bounds.lo) / size),
            VplKind::Spot(_) | VplKind::Image(_) => (1, (l.position - bounds.lo) / size),
            VplKind::Directional => (2, l.direction * 0.5 + 0.5),
            VplKind::Oriented => (3, (l.position - bounds.lo) / size),
            VplKind::Volume(_) => (4, (l.position - bounds.lo) / size),
        };
        (kind, morton(unit.to_array()))
    };
    let mut places: Vec<_> = lights.par_iter().map(code).zip(0..lights.len() as u32).collect();
    places.par_sort_unstable();
    // The permutation is applied in place, since a second list of lights would need most of the
    // memory in use.
    let mut from: Vec<u32> = places.into_iter().map(|(_, from)| from).collect();
    for first in 0..lights.len() {
        let moved = lights[first];
        let mut to = first;
        loop {
            let source = std::mem::replace(&mut from[to], to as u32) as usize;
            if source == first {
                lights[to] = moved;
                break;
            }
            lights[to] = lights[source];
            to = source;
        }
    }
}

/// Interleaves 20 bits of each of three coordinates in `[0, 1]`.
fn morton(unit: [f32; 3]) -> u64 {
    let spread = |v: f32| {
        let mut x = (v.clamp(0.0, 1.0) * ((1 << 20) - 1) as f32) as u64;
        x = (x | x << 32) & 0x001f_0000_0000_ffff;
        x = (x | x << 16) & 0x001f_0000_ff00_00ff;
        x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
        x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
        (x | x << 2) & 0x1249_2492_4924_9249
    };
    spread(unit[0]) | spread(unit[1]) << 1 | spread(unit[2]) << 2
}
