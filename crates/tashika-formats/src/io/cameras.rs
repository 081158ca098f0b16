//! Poses and names of cameras, shared by several formats.
//!
//! Held to this by the formats' tests.

use std::collections::BTreeSet;

use glam::{DAffine3, DMat3};

/// Returns the pose of a camera without its scale: the viewing direction is kept, and up is made
/// orthogonal to it.
pub(super) fn rigid(to_world: &DAffine3) -> Option<DAffine3> {
    let axes = to_world.matrix3;
    let back = axes.z_axis.try_normalize()?;
    let up = (axes.y_axis - back * axes.y_axis.dot(back)).try_normalize()?;
    let rotation = DMat3::from_cols(up.cross(back), up, back);
    Some(DAffine3 { matrix3: rotation, translation: to_world.translation })
}

/// Returns `name`, or `name-2`, `name-3`, … if it is taken.
pub(super) fn unique(name: String, names: &mut BTreeSet<String>) -> String {
    let mut candidate = name.clone();
    let mut number = 1;
    while !names.insert(candidate.clone()) {
        number += 1;
        candidate = format!("{name}-{number}");
    }
    candidate
}
