//! glTF 2.0: `.gltf` with buffers and images in files or `data:` URIs, and `.glb`.[^gltf]
//!
//! [`FEATURES`] lists the features of the format and their support; notes and errors quote its
//! rows.
//!
//! | module | purpose |
//! |---|---|
//! | [`container`] | bytes into a checked document |
//! | [`features`], [`extensions`] | the table of features, and its use for extensions |
//! | [`schema`] | properties that no table knows |
//! | [`source`], [`uri`], [`accessor`] | the bytes that the document refers to |
//! | [`nodes`], [`animations`], [`instancing`] | transforms of nodes and instances |
//! | [`exposure`] | motion while the shutter is open |
//! | [`meshes`] | primitives into meshes |
//! | [`shapes`], [`morphs`], [`skins`] | positions and normals of vertices |
//! | [`materials`], [`textures`] | materials with their extensions |
//! | [`cameras`], [`lights`], [`light_profiles`], [`image_light`] | cameras and lights |
//!
//! # Guarantee
//! No file makes the loader panic. Allocations are bounded by the bytes of the files and, where a
//! file may name the same bytes many times or declare texels, by [`LoadOptions`] (see `source`).
//! Unreadable content is an error that names file, item, value and expectation; an unreadable
//! texture image is only noted.
//!
//! # Held to this by
//! The test modules `gltf`, `gltf_animations`, `gltf_features`, `gltf_materials`, `gltf_shapes`,
//! `gltf_structure` and `damaged_gltf`.
//!
//! [^gltf]: Khronos Group. "glTF 2.0 Specification." ISO/IEC 12113:2022.
//!
//! [`LoadOptions`]: super::LoadOptions

mod accessor;
mod animations;
mod cameras;
mod container;
mod exposure;
mod extensions;
mod features;
mod image_light;
mod instancing;
mod light_profiles;
mod lights;
mod materials;
mod meshes;
mod morphs;
mod nodes;
mod schema;
mod shapes;
mod skins;
mod source;
mod textures;
mod uri;

use std::collections::BTreeSet;

use glam::DAffine3;

use self::animations::Poses;
use self::exposure::Exposure;
use self::features::met;
use self::light_profiles::Profiles;
use self::meshes::Meshes;
use self::nodes::PlacedNode;
use self::shapes::Shapes;
use self::source::Source;
use super::SceneFiles;
use crate::error::{Location, Result};
use crate::math::motion::Track;
use crate::scene::{MeshId, NoteKind, Scene, SceneBuilder};

pub(super) use self::features::FEATURES;

/// Reads a glTF scene.
pub(super) fn load(files: &SceneFiles) -> Result<Scene> {
    let bytes = files.read_scene()?;
    let file = Location::file(files.path());
    let mut parsed = container::parse(&bytes, &file)?;
    let mut builder = SceneBuilder::new(files.name(), file.clone());
    extensions::note_unhandled(&parsed.root, &file, &mut builder)?;
    parsed.unknown.tell(&parsed.root.extensions_used, &file, &mut builder)?;
    morphs::tell_others(&file, std::mem::take(&mut parsed.other_targets), &mut builder)?;
    let animated = std::mem::take(&mut parsed.animations);
    let source = Source::new(files, parsed);
    animations::add_time_span(&source, &animated, &mut builder);
    let poses = match files.options().time() {
        Some(seconds) => animations::at(&source, &animated, seconds, None, &mut builder)?,
        None if animated.is_empty() => Poses::default(),
        None => {
            met("scene", "animations", file.item("animations"), &mut builder)?;
            Poses::default()
        }
    };
    let exposure = match files.options().exposure(None) {
        Some(shutter) => Exposure::new(&source, &animated, shutter, &mut builder)?,
        None => None,
    };
    image_light::add(&source, &mut builder)?;
    let mut meshes = Meshes::new(exposure.as_ref().map(|exposure| exposure.shutter));
    let mut shapes = match &exposure {
        Some(Exposure { ends: [open, close], .. }) => Shapes::new(&source, &[open, close])?,
        None => Shapes::new(&source, &[&poses])?,
    };
    let mut camera_names = BTreeSet::new();
    let mut profiles = Profiles::default();
    for placed in nodes::place(&source, &poses.places, &mut builder)? {
        place_mesh(&source, &placed, exposure.as_ref(), (&mut meshes, &mut shapes), &mut builder)?;
        cameras::add(&source, &placed, exposure.as_ref(), &mut camera_names, &mut builder)?;
        lights::add(&source, &placed, &mut builder)?;
        profiles.add(&source, &placed, &mut builder)?;
    }
    builder.build()
}

fn place_mesh(
    source: &Source<'_>,
    placed: &PlacedNode,
    exposure: Option<&Exposure>,
    (meshes, shapes): (&mut Meshes, &mut Shapes),
    builder: &mut SceneBuilder,
) -> Result<()> {
    let node = &source.root.nodes[placed.index];
    let Some(mesh) = node.mesh else { return Ok(()) };
    let shape = shapes.of(source, placed.index, builder)?;
    let parts = meshes.get(source, builder, mesh.value(), &shape)?;
    match node.name.as_deref().filter(|name| !name.is_empty()) {
        Some(name) => builder.begin_object(name),
        None => builder.begin_unnamed_object(&meshes::name(&source.root.meshes[mesh.value()], mesh.value())),
    }
    let of_joints: Vec<MeshId> = parts.iter().filter(|part| part.is_placed).map(|part| part.mesh).collect();
    let of_node: Vec<MeshId> = parts.iter().filter(|part| !part.is_placed).map(|part| part.mesh).collect();
    if !of_joints.is_empty() {
        let world = PlacedNode { index: placed.index, to_world: DAffine3::IDENTITY };
        place_still(source, &world, &of_joints, builder)?;
    }
    if of_node.is_empty() && !of_joints.is_empty() {
        return Ok(());
    }
    match exposure.and_then(|exposure| Some((exposure.of_moving(source, placed.index)?, exposure.shutter))) {
        Some(moving) => place_moving(source, placed, moving, &of_node, builder),
        None => place_still(source, placed, &of_node, builder),
    }
}

/// Adds the meshes of a node that does not move.
fn place_still(
    source: &Source<'_>,
    placed: &PlacedNode,
    meshes: &[MeshId],
    builder: &mut SceneBuilder,
) -> Result<()> {
    builder.set_most_instances(source.files.most_instances());
    for to_world in instancing::placements(source, placed, meshes.len(), builder)? {
        for &mesh in meshes {
            builder.add_instance(mesh, to_world)?;
        }
    }
    Ok(())
}

/// Adds the meshes of a node that moves along its keys while the shutter is open.
fn place_moving(
    source: &Source<'_>,
    placed: &PlacedNode,
    (keys, shutter): (Vec<(f64, DAffine3)>, [f64; 2]),
    meshes: &[MeshId],
    builder: &mut SceneBuilder,
) -> Result<()> {
    let at = || source.at(format!("nodes[{}]", placed.index));
    let track = Track::new(keys);
    let node = PlacedNode { index: placed.index, to_world: DAffine3::IDENTITY };
    for to_node in instancing::placements(source, &node, meshes.len(), builder)? {
        let track = track.as_ref().and_then(|track| track.after(to_node)).filter(Track::can_place);
        let bytes = track.as_ref().map_or(0, Track::bytes).saturating_mul(meshes.len() as u64);
        source.geometry_budget.take(bytes, &at())?;
        if track.is_none() {
            let message = "meshes that cannot be inverted at all times that the shutter is open: where they are in the middle of it";
            builder.note(NoteKind::Approximated, message, at());
        }
        for &mesh in meshes {
            match &track {
                Some(track) => builder.add_moving_instance(mesh, track.clone(), shutter)?,
                None => builder.add_instance(mesh, placed.to_world * to_node)?,
            };
        }
    }
    Ok(())
}
