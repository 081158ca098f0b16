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

use glam::DAffine3;
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

use super::exposure::Exposure;
use super::nodes::PlacedNode;
use super::source::Source;
use crate::error::{Error, Result};
use crate::io::cameras::{rigid, unique};
use crate::io::notes::shown;
use crate::math::motion::Track;
use crate::scene::{Camera, Projection, SceneBuilder};

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
    let pose = |to_world: &DAffine3| {
        rigid(to_world).ok_or_else(|| {
            let at = source.at(format!("nodes[{}]", placed.index));
            let found = "a camera with a transform of rank below 2";
            Error::invalid(at, found, "one that keeps directions")
        })
    };
    let to_world = pose(&placed.to_world)?;
    let name = camera.name.as_deref().or(node.name.as_deref()).filter(|n| !n.is_empty());
    let name = unique(name.map_or_else(|| format!("camera-{index}"), shown), names);
    let camera = Camera::new(name, to_world.as_affine3a(), projection);
    let Some(exposure) = exposure else { return builder.add_camera_at(camera, to_world) };
    let keys = exposure.of(source, placed.index).into_iter();
    let keys = keys.map(|(seconds, to_world)| Ok((seconds, pose(&to_world)?))).collect::<Result<Vec<_>>>()?;
    match Track::new(keys).filter(|track| track.moves_between(exposure.shutter)) {
        Some(track) => builder.add_camera(camera.moving(track, exposure.shutter)),
        None => builder.add_camera_at(camera, to_world),
    }
}
