//! glTF extensions as a whole: those that a file may require, and notes of those that are ignored.
//!
//! An extension that a file *requires* changes the meaning of the file: without support for it, the
//! file is refused, with advice. An extension that a file merely *uses* is read or ignored as
//! [`FEATURES`] states. Ignored extensions are noted with their place in the file; in materials,
//! they are noted only if they would have an effect.
//!
//! # Held to this by
//! `gltf::extensions_that_a_file_requires_are_read_or_refused_by_name`,
//! `gltf::what_is_left_out_is_noted_once`.

use gltf::json::Root;
use serde_json::{Map, Value};

use super::features::{FEATURES, extension, met};
use crate::error::{Error, Location, Result};
use crate::io::features::{Feature, Support};
use crate::io::notes::shown;
use crate::scene::{Notes, SceneBuilder};

/// Refuses a file that requires an unsupported extension.
pub(super) fn refuse_unhandled(required: &[String], file: &Location) -> Result<()> {
    for (i, name) in required.iter().enumerate() {
        let at = file.clone().item(format!("extensionsRequired[{i}]"));
        if let Some(refused) = Feature::find(FEATURES, "required extension", name) {
            refused.met(&at, &mut Notes::default())?;
        } else if extension(name).is_none() {
            let what = format!("required extension {:?}", shown(name));
            return Err(Error::unsupported(at, what, "export the scene without it"));
        }
    }
    Ok(())
}

/// Refuses data that exist only in compressed form, although the file does not list the compression
/// as required.
pub(super) fn refuse_compressed(extensions: &Map<String, Value>, at: &Location) -> Result<()> {
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"] {
        if extensions.contains_key(name)
            && let Some(refused) = Feature::find(FEATURES, "required extension", name)
        {
            refused.met(at, &mut Notes::default())?;
        }
    }
    Ok(())
}

/// Notes each ignored extension. The note of an unknown extension names its place in
/// `extensionsUsed`, other notes name the object that has the extension.
pub(super) fn note_unhandled(root: &Root, file: &Location, builder: &mut SceneBuilder) -> Result<()> {
    for (i, name) in root.extensions_used.iter().enumerate() {
        if extension(name).is_none() {
            met("extension", name, file.clone().item(format!("extensionsUsed[{i}]")), builder)?;
        }
    }
    let mut note = |item: &dyn Fn() -> String, extensions: Option<&Map<String, Value>>| {
        for name in extensions.into_iter().flat_map(Map::keys) {
            if extension(name).is_some_and(|e| e.support == Support::Ignored) {
                met("extension", name, file.clone().item(format!("{}.extensions.{name}", item())), builder)?;
            }
        }
        Ok::<(), Error>(())
    };
    note(&|| "glTF".to_owned(), root.extensions.as_ref().map(|e| &e.others))?;
    for (i, node) in root.nodes.iter().enumerate() {
        note(&|| format!("nodes[{i}]"), node.extensions.as_ref().map(|e| &e.others))?;
    }
    for (i, texture) in root.textures.iter().enumerate() {
        note(&|| format!("textures[{i}]"), texture.extensions.as_ref().map(|e| &e.others))?;
    }
    for (i, view) in root.buffer_views.iter().enumerate() {
        note(&|| format!("bufferViews[{i}]"), view.extensions.as_ref().map(|e| &e.others))?;
    }
    for (i, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let item = || format!("meshes[{i}].primitives[{p}]");
            note(&item, primitive.extensions.as_ref().map(|e| &e.others))?;
        }
    }
    Ok(())
}
