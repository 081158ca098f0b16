//! Cameras: glTF's perspective projection as a pinhole, its orthographic one as parallel rays.
//!
//! The view is that of the node's transform without its scale (glTF 2.0 section 3.10): the axes are
//! made orthonormal again, the viewing direction `−z` first, then up. An orthographic film is
//! `2 · ymag` high. The aspect ratio (`aspectRatio`, `xmag`) and the clipping planes are not used:
//! the image's size gives the aspect ratio, and rays need no clipping planes.
//!
//! # Held to this by
//! `gltf::cameras_keep_position_direction_and_field_of_view`,
//! `gltf_structure::orthographic_cameras_keep_their_height`.

use std::collections::BTreeSet;
use std::f32::consts::PI;

use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use super::exposure::Exposure;
use super::nodes::PlacedNode;
use super::source::Source;
use crate::error::Result;
use crate::io::cameras::{rigid, unique};
use crate::io::notes::shown;
use crate::math::motion::Track;
use crate::scene::{Camera, NoteKind, Projection, SceneBuilder};

/// Range of vertical fields of view (rad).
const YFOV: (f32, f32) = (1e-4, PI - 1e-2);

/// Vertical field of view of cameras without a finite one (rad); chosen.
const DEFAULT_YFOV: f32 = 0.8;

/// Adds the node's camera, if it has one, under a name that is not among `names` yet.
pub(super) fn add(
    source: &Source<'_>,
    placed: &PlacedNode,
    exposure: Option<&Exposure>,
    names: &mut BTreeSet<String>,
    builder: &mut SceneBuilder,
) -> Result<()> {
    let node = &source.root.nodes[placed.index];
    let Some(index) = node.camera.map(|c| c.value()) else { return Ok(()) };
    let camera = &source.root.cameras[index];
    let at = |field: &str| source.at(format!("cameras[{index}]{field}"));
    let projection = match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(perspective), _) => {
            let said = perspective.yfov;
            let vertical_fov = if said.is_finite() { said.clamp(YFOV.0, YFOV.1) } else { DEFAULT_YFOV };
            if !(said > 0.0 && said < PI) {
                let message = "fields of view outside 0 to π: the nearer end";
                builder.note(NoteKind::Repaired, message, at(".perspective.yfov"));
            }
            Projection::Perspective { vertical_fov }
        }
        (Checked::Valid(Type::Orthographic), _, Some(orthographic)) => {
            // Some exporters write a negative height, which would turn the picture upside down.
            let mut height = 2.0 * orthographic.ymag.abs();
            if !(height > 0.0 && height.is_finite()) {
                let message = "orthographic cameras of height 0 or without end: ymag 1";
                builder.note(NoteKind::Repaired, message, at(".orthographic.ymag"));
                height = 2.0;
            }
            Projection::Orthographic { height }
        }
        _ => {
            let message = "cameras without the projection that their type names: left out";
            builder.note(NoteKind::Repaired, message, at(""));
            return Ok(());
        }
    };
    let of_node = || source.at(format!("nodes[{}]", placed.index));
    let Some(to_world) = rigid(&placed.to_world) else {
        let message = "cameras with a transform that loses their directions: left out";
        builder.note(NoteKind::Repaired, message, of_node());
        return Ok(());
    };
    let name = camera.name.as_deref().or(node.name.as_deref()).filter(|n| !n.is_empty());
    let name = unique(name.map_or_else(|| format!("camera-{index}"), shown), names);
    let camera = Camera::new(name, to_world.as_affine3a(), projection);
    let Some(exposure) = exposure else { return builder.add_camera_at(camera, to_world) };
    let keys = exposure.of(source, placed.index).into_iter();
    let keys = keys.map(|(seconds, to_world)| Some((seconds, rigid(&to_world)?)));
    let Some(keys) = keys.collect::<Option<Vec<_>>>() else {
        let message = "cameras that lose their directions at a time: where they are first";
        builder.note(NoteKind::Repaired, message, of_node());
        return builder.add_camera_at(camera, to_world);
    };
    match Track::new(keys).filter(|track| track.moves_between(exposure.shutter)) {
        Some(track) => builder.add_camera(camera.moving(track, exposure.shutter)),
        None => builder.add_camera_at(camera, to_world),
    }
}
