//! glTF extensions: which are read, and what is said about the others.
//!
//! An extension that a file merely *uses* is optional by definition (glTF 2.0 section 3.12): it is left out and
//! noted. One that it *requires* changes the meaning of the file: it is refused, with advice.

use gltf::json::Root;

use super::shown;
use crate::error::{Error, Location, Result};
use crate::scene::{NoteKind, SceneBuilder};

/// Extensions that this loader reads, wholly or as the table in the parent module says.
const HANDLED: [&str; 8] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Refuses a file that requires what is not here.
pub(super) fn refuse_unhandled(required: &[String], file: &Location) -> Result<()> {
    let Some((i, name)) = required.iter().enumerate().find(|(_, name)| !HANDLED.contains(&name.as_str()))
    else {
        return Ok(());
    };
    let advice = match name.as_str() {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export the scene without mesh compression"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "export the scene with PNG or JPEG textures"
        }
        "KHR_materials_pbrSpecularGlossiness" => "export the scene with metallic-roughness materials",
        _ => "export the scene without it",
    };
    let at = file.clone().item(format!("extensionsRequired[{i}]"));
    Err(Error::unsupported(at, format!("the extension {}", shown(name)), advice))
}

/// Notes each extension in use that is left out.
pub(super) fn note_unhandled(root: &Root, file: &Location, builder: &mut SceneBuilder) {
    for (i, name) in root.extensions_used.iter().enumerate() {
        if !HANDLED.contains(&name.as_str()) {
            let at = file.clone().item(format!("extensionsUsed[{i}]"));
            builder.note(NoteKind::Ignored, format!("the extension {}: left out", shown(name)), at);
        }
    }
}
