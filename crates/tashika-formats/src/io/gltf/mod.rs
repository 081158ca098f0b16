//! glTF 2.0: `.gltf` with buffers and images in files or `data:` URIs, and `.glb`.[^gltf]
//!
//! What becomes of what a file may hold is the table [`FEATURES`]; notes and errors have its words.
//!
//! | module | what it does |
//! |---|---|
//! | [`container`] | bytes into a checked document |
//! | [`features`], [`extensions`] | the table, and what it says about extensions |
//! | [`source`], [`uri`], [`accessor`] | the bytes that the document refers to |
//! | [`nodes`], [`animations`], [`instancing`] | what stands where |
//! | [`exposure`] | what moves while the shutter is open |
//! | [`meshes`] | primitives into meshes |
//! | [`materials`], [`textures`] | materials with their extensions |
//! | [`cameras`], [`lights`], [`light_profiles`], [`image_light`] | cameras and lights |
//!
//! # Guarantee
//! No file makes the loader panic. What it allocates is bounded by the bytes that are there, and
//! where a file may name the same bytes many times or claim texels, by [`LoadOptions`] (see
//! `source`). What cannot be read is an error that names file, item, value and expectation; a
//! texture image that cannot be read is only noted.
//!
//! # Held to this by
//! The test modules `gltf`, `gltf_animations`, `gltf_features`, `gltf_materials`, `gltf_structure` and `damaged_gltf`.
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
mod nodes;
mod source;
mod textures;
mod uri;

use std::collections::{BTreeMap, BTreeSet};

use glam::DAffine3;

use self::exposure::Exposure;
use self::features::met;
use self::light_profiles::Profiles;
use self::meshes::Meshes;
use self::nodes::PlacedNode;
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
    let animated = std::mem::take(&mut parsed.animations);
    let source = Source::new(files, parsed);
    animations::tell_span(&source, &animated, &mut builder);
    let poses = match files.options().time() {
        Some(seconds) => animations::at(&source, &animated, seconds, None, &mut builder)?,
        None if animated.is_empty() => BTreeMap::new(),
        None => {
            met("scene", "animations", file.item("animations"), &mut builder)?;
            BTreeMap::new()
        }
    };
    let exposure = match files.options().exposure(None) {
        Some(shutter) => Exposure::new(&source, &animated, shutter, &mut builder)?,
        None => None,
    };
    image_light::add(&source, &mut builder)?;
    let mut meshes = Meshes::new(&source);
    let mut camera_names = BTreeSet::new();
    let mut profiles = Profiles::default();
    for placed in nodes::place(&source, &poses, &mut builder)? {
        place_mesh(&source, &placed, exposure.as_ref(), &mut meshes, &mut builder)?;
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
    meshes: &mut Meshes,
    builder: &mut SceneBuilder,
) -> Result<()> {
    let node = &source.root.nodes[placed.index];
    let Some(mesh) = node.mesh else { return Ok(()) };
    if node.skin.is_some() {
        met("node", "skin", source.at(format!("nodes[{}].skin", placed.index)), builder)?;
    }
    let parts = meshes.get(source, builder, mesh.value())?;
    match node.name.as_deref().filter(|name| !name.is_empty()) {
        Some(name) => builder.begin_object(name),
        None => builder.begin_unnamed_object(&meshes::name(&source.root.meshes[mesh.value()], mesh.value())),
    }
    if let Some(exposure) = exposure
        && let Some(keys) = exposure.of_moving(source, placed.index)
    {
        return place_moving(source, placed, (keys, exposure.shutter), parts, builder);
    }
    for to_world in instancing::placements(source, placed, parts.len(), builder)? {
        for &mesh in parts {
            builder.add_instance(mesh, to_world.as_affine3a())?;
        }
    }
    Ok(())
}

/// The meshes of a node that moves, by its keys, while the shutter is open.
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
                None => builder.add_instance(mesh, (placed.to_world * to_node).as_affine3a())?,
            };
        }
    }
    Ok(())
}
