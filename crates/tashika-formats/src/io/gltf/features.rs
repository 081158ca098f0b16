//! What a glTF file may hold, and what becomes of it.
//!
//! The loader says of these things what their rows say, through [`met`]. Fields of an extension
//! have the extension's name as their kind; an extension stands once as what a file *uses*, which
//! is optional by definition (glTF 2.0 section 3.12), and, if what it changes cannot be done
//! without, once more as what a file *requires*.
//!
//! # Held to this by
//! `suite::gltf_features`: every row, in a file of its own, gives the note or the error that it
//! promises and no other.

use super::shown;
use crate::error::{Location, Result};
use crate::io::features::{Feature, Support};
use crate::scene::{NoteKind, Notes, SceneBuilder};

use Support::{Approximated, Full, Ignored, Refused};

const fn row(kind: &'static str, name: &'static str, support: Support, how: &'static str) -> Feature {
    Feature::new(kind, name, support, how)
}

/// All rows.
pub(in crate::io) const FEATURES: &[Feature] = &[
    row("file", "gltf", Full, "JSON, with buffers and images in files of their own or in data URIs"),
    row("file", "glb", Full, "binary container"),
    row("scene", "scene", Full, "what is loaded; without it the first scene, without any all root nodes"),
    row("scene", "scenes", Ignored, "those other than the default one are left out"),
    row("scene", "animations", Ignored, "left out, nodes stay where they are"),
    row("node", "mesh", Full, "instances of a mesh that is read once; axes and metres as they are"),
    row("node", "matrix", Full, "transform"),
    row("node", "rotation", Full, "transform, with translation and scale"),
    row("node", "skin", Ignored, "the bind pose is shown"),
    row("primitive", "TRIANGLES", Full, "triangles, with or without indices"),
    row("primitive", "TRIANGLE_STRIP", Full, "triangles"),
    row("primitive", "TRIANGLE_FAN", Full, "triangles"),
    row("primitive", "POINTS", Ignored, "left out"),
    row("primitive", "LINES", Ignored, "left out"),
    row("primitive", "LINE_LOOP", Ignored, "left out"),
    row("primitive", "LINE_STRIP", Ignored, "left out"),
    row("primitive", "targets", Ignored, "the base mesh is shown, without morph targets"),
    row("attribute", "POSITION", Full, "vertices"),
    row("attribute", "NORMAL", Full, "shading normals; flat shading without them"),
    row("attribute", "TEXCOORD_0", Full, "texture coordinates; any set can be chosen"),
    row(
        "attribute",
        "TANGENT",
        Ignored,
        "normal maps and brushed surfaces take their tangents from the texture coordinates",
    ),
    row("attribute", "COLOR_0", Approximated, "the mean over the primitive multiplies the base colour"),
    row("accessor", "sparse", Full, "elements replaced by others, with or without a buffer view"),
    row("accessor", "normalized", Full, "integers as fractions"),
    row("camera", "perspective", Full, "pinhole; the aspect ratio is that of the image"),
    row(
        "camera",
        "orthographic",
        Full,
        "parallel rays; the height is twice ymag, the width follows from the image",
    ),
    row("material", "pbrMetallicRoughness", Full, "metallic-roughness with its textures"),
    row("material", "normalTexture", Full, "normal map with its scale"),
    row("material", "occlusionTexture", Ignored, "left out, light transport computes occlusion"),
    row("material", "emissiveTexture", Full, "emission (W·m⁻²·sr⁻¹), with its factor"),
    row("material", "alphaMode", Full, "MASK and BLEND with the base colour's opacity"),
    row("material", "doubleSided", Full, "emission on both sides; every material reflects on both"),
    row(
        "texture",
        "source",
        Full,
        "PNG or JPEG, of 8 or 16 bits; also BMP, TIFF and .tx, TGA and Radiance HDR",
    ),
    row("texture", "wrapS", Full, "wrapping in both directions"),
    row("texture", "magFilter", Full, "NEAREST, or between four texels; minFilter has no use"),
    row("texture", "texCoord", Approximated, "all textures of a material use the coordinates of its first"),
    row(
        "extension",
        "KHR_lights_punctual",
        Full,
        "point, spot and directional lights; cd and lx count as W/sr and W/m²",
    ),
    row("KHR_lights_punctual", "range", Ignored, "lights fade with distance alone"),
    row("extension", "KHR_mesh_quantization", Full, "integer attributes"),
    row(
        "extension",
        "EXT_mesh_gpu_instancing",
        Full,
        "one instance for each element of TRANSLATION, ROTATION, SCALE",
    ),
    row(
        "extension",
        "KHR_node_visibility",
        Full,
        "nodes that are not visible are left out with all below them",
    ),
    row("extension", "KHR_texture_transform", Full, "transform of texture coordinates"),
    row("extension", "KHR_xmp_json_ld", Full, "metadata, without effect on the picture"),
    row("extension", "KHR_materials_emissive_strength", Full, "factor on the emission"),
    row("extension", "KHR_materials_ior", Full, "reflectance of the dielectric part, refraction of glass"),
    row(
        "extension",
        "KHR_materials_specular",
        Full,
        "factor on a dielectric's reflection, and its colour at normal incidence, with both textures",
    ),
    row(
        "KHR_materials_specular",
        "specularFactor",
        Approximated,
        "beside metal, where one of them is textured, the factor counts at normal incidence alone",
    ),
    row(
        "KHR_materials_specular",
        "specularColorFactor",
        Approximated,
        "beside metal or a texture, each channel dims its own of what is below: up to 15 % off",
    ),
    row(
        "extension",
        "KHR_materials_transmission",
        Full,
        "glass without thickness, tinted by the base colour, mixed with the opaque surface by the factor",
    ),
    row(
        "KHR_materials_transmission",
        "thicknessFactor",
        Approximated,
        "glass without thickness reflects at grazing angles as two faces do: up to 27 % off",
    ),
    row(
        "KHR_materials_transmission",
        "roughnessFactor",
        Approximated,
        "through glass without thickness light passes straight, as if it were smooth: up to 249 % off",
    ),
    row(
        "extension",
        "KHR_materials_volume",
        Full,
        "where it has thickness, transmission is that of solid glass, smooth or rough",
    ),
    row(
        "KHR_materials_volume",
        "attenuationDistance",
        Approximated,
        "light is absorbed as over the thickness, half of it at each crossing",
    ),
    row("KHR_materials_volume", "thicknessTexture", Ignored, "the factor counts alone"),
    row(
        "KHR_materials_volume",
        "baseColorTexture",
        Approximated,
        "solid glass has the tint of the factor alone",
    ),
    row(
        "extension",
        "KHR_materials_diffuse_transmission",
        Approximated,
        "a share of the surface lets light through diffusely and has no highlight: up to 12 % off",
    ),
    row("extension", "KHR_materials_clearcoat", Full, "a layer of GGX facets over the base"),
    row("KHR_materials_clearcoat", "transmissionFactor", Ignored, "what lets light through has no coat"),
    row("KHR_materials_clearcoat", "emissiveFactor", Ignored, "the coat does not dim what the surface emits"),
    row("KHR_materials_clearcoat", "clearcoatNormalTexture", Ignored, "the coat has the normals of the base"),
    row("extension", "KHR_materials_anisotropy", Full, "facets of two roughnesses"),
    row(
        "KHR_materials_anisotropy",
        "anisotropyTexture",
        Approximated,
        "glass is as rough in all directions where its roughness or its anisotropy is textured",
    ),
    row(
        "extension",
        "KHR_materials_pbrSpecularGlossiness",
        Approximated,
        "diffuse part and reflectance of metallic-roughness, by channel where textured",
    ),
    row("extension", "KHR_materials_unlit", Approximated, "diffuse reflection of the same colour"),
    row("extension", "KHR_materials_sheen", Ignored, "left out"),
    row("extension", "KHR_materials_iridescence", Ignored, "left out"),
    row("extension", "KHR_materials_dispersion", Ignored, "one index of refraction for all wavelengths"),
    row("extension", "KHR_materials_variants", Ignored, "the default materials are used"),
    row("extension", "KHR_animation_pointer", Ignored, "left out with all animations"),
    row("extension", "EXT_lights_ies", Full, "lamps by photometry of type C; cd count as W/sr"),
    row(
        "extension",
        "EXT_lights_image_based",
        Full,
        "the first level of its cube map as environment; numbers count as W/(m²·sr)",
    ),
    row("extension", "KHR_texture_basisu", Ignored, "the texture's own source is used"),
    row("extension", "EXT_texture_webp", Ignored, "the texture's own source is used"),
    row("extension", "EXT_texture_avif", Ignored, "the texture's own source is used"),
    row("extension", "MSFT_texture_dds", Ignored, "the texture's own source is used"),
    row("extension", "KHR_draco_mesh_compression", Ignored, "the data beside it are used"),
    row("extension", "EXT_meshopt_compression", Ignored, "the data beside it are used"),
    row("extension", "KHR_meshopt_compression", Ignored, "the data beside it are used"),
    row(
        "required extension",
        "KHR_draco_mesh_compression",
        Refused,
        "export the scene without mesh compression",
    ),
    row(
        "required extension",
        "EXT_meshopt_compression",
        Refused,
        "export the scene without mesh compression",
    ),
    row(
        "required extension",
        "KHR_meshopt_compression",
        Refused,
        "export the scene without mesh compression",
    ),
    row("required extension", "KHR_texture_basisu", Refused, "export the scene with PNG or JPEG textures"),
    row("required extension", "EXT_texture_webp", Refused, "export the scene with PNG or JPEG textures"),
    row("required extension", "EXT_texture_avif", Refused, "export the scene with PNG or JPEG textures"),
    row("required extension", "MSFT_texture_dds", Refused, "export the scene with PNG or JPEG textures"),
];

/// The row of an extension that a file uses.
pub(super) fn extension(name: &str) -> Option<&'static Feature> {
    Feature::find(FEATURES, "extension", name)
}

/// Says what the table says about a thing met at `at`.
///
/// # Errors
/// [`Error::Unsupported`](crate::error::Error::Unsupported) if it is refused.
pub(super) fn met(kind: &str, name: &str, at: Location, builder: &mut SceneBuilder) -> Result<()> {
    let Some(feature) = Feature::find(FEATURES, kind, name) else {
        builder.note(NoteKind::Ignored, format!("{kind} {:?} is unknown: left out", shown(name)), at);
        return Ok(());
    };
    let mut notes = Notes::default();
    feature.met(&at, &mut notes)?;
    builder.extend_notes(notes.iter());
    Ok(())
}
