//! Cameras: glTF's perspective projection as a pinhole, its orthographic one as parallel rays.
//!
//! The view is that of the node's transform without its scale (glTF 2.0 section 3.10): the axes are
//! made orthonormal again, the viewing direction `−z` first, then up. An orthographic film is
//! `2 · ymag` high. The aspect ratio (`aspectRatio`, `xmag`) and the clipping planes are not used:
//! the image's size gives the one, and rays need no others.
//!
//! # Held to this by
//! `gltf::cameras_keep_position_direction_and_field_of_view`,
//! `gltf_structure::orthographic_cameras_keep_their_height`.

use std::collections::BTreeSet;
use std::f32::consts::PI;

use glam::{Affine3A, DMat3};
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use super::nodes::PlacedNode;
use super::source::Source;
use crate::error::{Error, Result};
use crate::io::notes::shown;
use crate::scene::{Camera, Projection, SceneBuilder};

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
    let projection = match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(perspective), _) => {
            if !(perspective.yfov > 0.0 && perspective.yfov < PI) {
                let found = format!("{}", perspective.yfov);
                return Err(Error::invalid(at(".perspective.yfov"), found, "an angle between 0 and π"));
            }
            Projection::Perspective { vertical_fov: perspective.yfov }
        }
        (Checked::Valid(Type::Orthographic), _, Some(orthographic)) => {
            // Some exporters write it negative, which would turn the picture upside down.
            let height = 2.0 * orthographic.ymag.abs();
            if !(height > 0.0 && height.is_finite()) {
                let found = format!("{}", orthographic.ymag);
                return Err(Error::invalid(at(".orthographic.ymag"), found, "a finite number other than 0"));
            }
            Projection::Orthographic { height }
        }
        _ => {
            let expected = "the object perspective or orthographic, as its type says";
            return Err(Error::invalid(at(""), "a camera without its projection", expected));
        }
    };
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
    let name = unique(name.map_or_else(|| format!("camera-{index}"), shown), names);
    let position = placed.to_world.translation.as_vec3();
    let to_world = Affine3A::from_mat3_translation(rotation.as_mat3(), position);
    builder.add_camera(Camera::new(name, to_world, projection))
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
