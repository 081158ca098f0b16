//! Cameras: glTF's perspective projection as a pinhole.
//!
//! The view is that of the node's transform without its scale (glTF 2.0 section 3.10): the axes are made
//! orthonormal again, the viewing direction `−z` first, then up. The aspect ratio and the clipping planes are
//! not used: the image's size gives the one, and rays need no others.
//!
//! # Held to this by
//! `gltf::cameras_keep_position_direction_and_field_of_view`.

use std::collections::BTreeSet;
use std::f32::consts::PI;

use glam::{Affine3A, DMat3};
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use super::nodes::PlacedNode;
use super::source::Source;
use crate::error::{Error, Result};
use crate::scene::{Camera, Lens, NoteKind, SceneBuilder};

/// Adds the node's camera, if it has one, under a name that is not among `names` yet.
pub(super) fn add(
    source: &Source<'_>,
    placed: &PlacedNode,
    names: &mut BTreeSet<String>,
    builder: &mut SceneBuilder,
) -> Result<()> {
    let node = &source.root.nodes[placed.index];
    let Some(index) = node.camera.map(|c| c.value()) else { return Ok(()) };
    let camera = &source.root.cameras[index];
    let at = |field: &str| source.at(format!("cameras[{index}]{field}"));
    let (Checked::Valid(Type::Perspective), Some(perspective)) = (camera.type_, &camera.perspective) else {
        builder.note(NoteKind::Ignored, "orthographic cameras: left out", at(""));
        return Ok(());
    };
    if !(perspective.yfov > 0.0 && perspective.yfov < PI) {
        let found = format!("{}", perspective.yfov);
        return Err(Error::invalid(at(".perspective.yfov"), found, "an angle between 0 and π"));
    }
    let axes = placed.to_world.matrix3;
    let back = axes.z_axis.try_normalize();
    let up = back.and_then(|back| (axes.y_axis - back * axes.y_axis.dot(back)).try_normalize());
    let (Some(back), Some(up)) = (back, up) else {
        let at = source.at(format!("nodes[{}]", placed.index));
        return Err(Error::invalid(
            at,
            "a camera with a transform of rank below 2",
            "one that keeps directions",
        ));
    };
    let rotation = DMat3::from_cols(up.cross(back), up, back);
    let name = camera.name.as_deref().or(node.name.as_deref()).filter(|n| !n.is_empty());
    let name = unique(name.map_or_else(|| format!("camera-{index}"), super::shown), names);
    builder.add_camera(Camera {
        name,
        to_world: Affine3A::from_mat3_translation(rotation.as_mat3(), placed.to_world.translation.as_vec3()),
        vertical_fov: perspective.yfov,
        lens: Lens { radius: 0.0, focus_distance: 1.0 },
        resolution: None,
    })
}

/// `name`, or `name-2`, `name-3`, … if it is taken.
fn unique(name: String, names: &mut BTreeSet<String>) -> String {
    let mut candidate = name.clone();
    let mut number = 1;
    while !names.insert(candidate.clone()) {
        number += 1;
        candidate = format!("{name}-{number}");
    }
    candidate
}
