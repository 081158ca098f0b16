//! glTF 2.0: `.gltf` with buffers and images in files or `data:` URIs, and `.glb`.[^gltf]
//!
//! Axes and units are taken as they are: `+y` up, metres. What becomes what:
//!
//! | glTF | here |
//! |---|---|
//! | default scene, else the first, else all root nodes | what is loaded; other scenes are noted |
//! | primitive: triangles, strip, fan | one mesh, read once; each node that shows it places one instance |
//! | primitive: points, lines | left out, noted |
//! | no `NORMAL` | flat shading |
//! | `COLOR_0`, skins, morph targets, animations | left out, noted: the bind pose is shown |
//! | metallic-roughness | [`Surface::MetallicRoughness`]; roughness from G, metalness from B |
//! | `KHR_materials_ior`, `KHR_materials_specular` | reflectance of its dielectric part (see `materials`); textures left out, noted |
//! | `specularFactor` 0 and `metallicFactor` 0 | [`Surface::Lambert`] |
//! | `KHR_materials_transmission` ≥ 0.5 with roughness < 0.1 | [`Surface::Glass`], noted as approximated: solid, where the extension alone means a thin sheet |
//! | other transmission | opaque, noted |
//! | `KHR_materials_unlit` | [`Surface::Lambert`], noted as approximated |
//! | `emissiveFactor`, its texture, `KHR_materials_emissive_strength` | [`Emission`]; two-sided if `doubleSided` |
//! | `alphaMode` `MASK`, `BLEND` | [`Alpha`] from the base colour's fourth channel |
//! | base colour and emission textures | sRGB; metallic-roughness textures are linear |
//! | samplers | wrapping; filters are not read |
//! | `TEXCOORD_n` | one set a material: that of its first texture; others are noted |
//! | `KHR_texture_transform` | [`UvTransform`] |
//! | `normalTexture`, `occlusionTexture` | left out, noted |
//! | `KHR_lights_punctual` | [`Emitter`]s; photometric numbers (cd, lx) are used as they are |
//! | perspective camera | [`Camera`]; name: its own, else its node's, else `camera-i`, made unique by a number |
//! | orthographic camera | left out, noted |
//! | `KHR_mesh_quantization` | read |
//! | other extensions | used: left out, noted; required: refused |
//!
//! # Guarantee
//! No file makes the loader panic. What it allocates is bounded by the bytes that are there, and where a file
//! may name the same bytes many times or claim texels, by [`LoadOptions`] (see `source`). What
//! cannot be read is an error that names file, item, value and expectation; a texture image that cannot be
//! read is only noted.
//!
//! # Held to this by
//! The test modules `gltf` and `damaged_gltf`.
//!
//! [^gltf]: Khronos Group. "glTF 2.0 Specification." ISO/IEC 12113:2022.
//!
//! [`LoadOptions`]: super::LoadOptions
//! [`Alpha`]: crate::scene::Alpha
//! [`Camera`]: crate::scene::Camera
//! [`Emission`]: crate::scene::Emission
//! [`Emitter`]: crate::scene::Emitter
//! [`Surface::Glass`]: crate::scene::Surface::Glass
//! [`Surface::Lambert`]: crate::scene::Surface::Lambert
//! [`Surface::MetallicRoughness`]: crate::scene::Surface::MetallicRoughness
//! [`UvTransform`]: crate::scene::UvTransform

mod accessor;
mod cameras;
mod container;
mod extensions;
mod lights;
mod materials;
mod meshes;
mod nodes;
mod source;
mod textures;
mod uri;

use std::collections::BTreeSet;

use self::meshes::Meshes;
use self::nodes::PlacedNode;
use self::source::Source;
use super::SceneFiles;
use crate::error::{Location, Result};
use crate::scene::{Instance, NoteKind, Scene, SceneBuilder};

/// Reads a glTF scene.
pub(super) fn load(files: &SceneFiles) -> Result<Scene> {
    let bytes = files.read_scene()?;
    let file = Location::file(files.path());
    let parsed = container::parse(&bytes, &file)?;
    let mut builder = SceneBuilder::new(files.name(), file.clone());
    extensions::note_unhandled(&parsed.root, &file, &mut builder);
    if parsed.animations > 0 {
        builder.note(NoteKind::Ignored, "animations: left out", file.item("animations"));
    }
    let source = Source::new(files, parsed);
    let mut meshes = Meshes::new(&source);
    let mut camera_names = BTreeSet::new();
    for placed in nodes::place(&source, &mut builder)? {
        place_mesh(&source, &placed, &mut meshes, &mut builder)?;
        cameras::add(&source, &placed, &mut camera_names, &mut builder)?;
        lights::add(&source, &placed, &mut builder)?;
    }
    builder.build()
}

fn place_mesh(
    source: &Source<'_>,
    placed: &PlacedNode,
    meshes: &mut Meshes,
    builder: &mut SceneBuilder,
) -> Result<()> {
    let node = &source.root.nodes[placed.index];
    let Some(mesh) = node.mesh else { return Ok(()) };
    let at = |field: &str| source.at(format!("nodes[{}]{field}", placed.index));
    if node.skin.is_some() {
        builder.note(NoteKind::Ignored, "skins: the bind pose is shown", at(".skin"));
    }
    let meshes = meshes.get(source, builder, mesh.value())?;
    source.geometry_budget.take(meshes.len() as u64 * size_of::<Instance>() as u64, &at(".mesh"))?;
    let to_world = placed.to_world.as_affine3a();
    for &mesh in meshes {
        builder.add_instance(mesh, to_world)?;
    }
    Ok(())
}

/// A name from a file, fit for messages: without control characters, and not too long.
fn shown(name: &str) -> String {
    const LONGEST: usize = 80;
    let visible = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
    let mut shown: String = name.chars().take(LONGEST).map(visible).collect();
    if name.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}
