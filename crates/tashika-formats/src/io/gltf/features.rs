//! Features of glTF files and their support.
//!
//! The loader reports each feature with the words of its row, through [`met`]. Fields of an
//! extension have the extension's name as their kind. An extension is listed once as *used*, which
//! is optional by definition (glTF 2.0 section 3.12). An extension that cannot be ignored if a file
//! requires it has a second row as *required*.
//!
//! # Held to this by
//! `suite::gltf_features`: for every row, a file with the feature gives exactly the note or the
//! error of the row.

use crate::error::{Location, Result};
use crate::io::features::{Feature, Support, table};
use crate::scene::{NoteKind, SceneBuilder};

/// Table of the features of glTF.
pub(in crate::io) const FEATURES: &[Feature] = table! {
    "file" => {
        "gltf", Full, "JSON, with buffers and images in files of their own or in data URIs";
        "glb", Full, "binary container";
    }
    "scene" => {
        "scene", Full, "what is loaded; without it the first scene, without any all root nodes";
        "scenes", Ignored, "those other than the default one are left out";
        "animations", Ignored, "without a time (`--at`) left out, nodes stay where they are";
    }
    "animation" => {
        "translation", Full, "at a time: STEP, LINEAR and CUBICSPLINE; all animations of a file together";
        "rotation", Full, "at a time, by slerp";
        "scale", Full, "at a time";
        "weights", Full, "at a time: the weights of morph targets";
        "pointer", Ignored, "what it moves stays as it is";
    }
    "node" => {
        "mesh", Full, "instances of a mesh that is read once; axes and metres as they are";
        "matrix", Full, "transform";
        "rotation", Full, "transform, with translation and scale";
        "skin", Full, "vertices follow its joints; the node's own transform has no effect on them";
        "weights", Full, "of morph targets, in place of the mesh's";
    }
    "mesh" => {
        "weights", Full, "of morph targets";
    }
    "skin" => {
        "joints", Full, "where the nodes are, at a time or as the file has them";
        "inverseBindMatrices", Full, "matrices; without them the identity";
        "skeleton", Full, "a hint without effect on the picture";
    }
    "primitive" => {
        "TRIANGLES", Full, "triangles, with or without indices";
        "TRIANGLE_STRIP", Full, "triangles";
        "TRIANGLE_FAN", Full, "triangles";
        "POINTS", Ignored, "left out";
        "LINES", Ignored, "left out";
        "LINE_LOOP", Ignored, "left out";
        "LINE_STRIP", Ignored, "left out";
        "targets", Full, "morph targets, by their weights";
    }
    "target" => {
        "POSITION", Full, "differences of vertices";
        "NORMAL", Full, "differences of shading normals; flat shading follows the vertices";
        "TANGENT", Ignored, "tangents follow the texture coordinates of the surface as it is";
        "TEXCOORD_0", Ignored, "texture coordinates stay as they are";
        "COLOR_0", Ignored, "vertex colours stay as they are";
    }
    "attribute" => {
        "POSITION", Full, "vertices";
        "NORMAL", Full, "shading normals; flat shading without them";
        "TEXCOORD_0", Full, "texture coordinates; any set can be chosen";
        "JOINTS_0", Full, "joints that a vertex follows, of all sets";
        "WEIGHTS_0", Full, "by how much, made to add up to one";
        "TANGENT", Ignored,
            "normal maps and brushed surfaces take their tangents from the texture coordinates";
        "COLOR_0", Approximated, "the mean over the primitive multiplies the base colour";
    }
    "accessor" => {
        "sparse", Full, "elements replaced by others, with or without a buffer view";
        "normalized", Full, "integers as fractions";
    }
    "camera" => {
        "perspective", Full, "pinhole; the aspect ratio is that of the image";
        "orthographic", Full, "parallel rays; the height is twice ymag, the width follows from the image";
    }
    "material" => {
        "pbrMetallicRoughness", Full, "metallic-roughness with its textures";
        "normalTexture", Full, "normal map with its scale";
        "occlusionTexture", Ignored, "left out, light transport computes occlusion";
        "emissiveTexture", Full, "emission (W·m⁻²·sr⁻¹), with its factor";
        "alphaMode", Full, "MASK and BLEND with the base colour's opacity";
        "doubleSided", Full, "emission on both sides; every material reflects on both";
    }
    "texture" => {
        "source", Full, "PNG or JPEG, of 8 or 16 bits; also BMP, TIFF and .tx, TGA and Radiance HDR";
        "wrapS", Full, "wrapping in both directions";
        "magFilter", Full, "NEAREST, or between four texels; minFilter has no use";
        "texCoord", Approximated, "all textures of a material use the coordinates of its first";
    }
    "extension" => {
        "KHR_lights_punctual", Full, "point, spot and directional lights; cd and lx count as W/sr and W/m²";
    }
    "KHR_lights_punctual" => {
        "range", Ignored, "lights fade with distance alone";
    }
    "extension" => {
        "KHR_mesh_quantization", Full, "integer attributes";
        "EXT_mesh_gpu_instancing", Full, "one instance for each element of TRANSLATION, ROTATION, SCALE";
        "KHR_node_visibility", Full, "nodes that are not visible are left out with all below them";
        "KHR_texture_transform", Full, "transform of texture coordinates";
        "KHR_xmp_json_ld", Full, "metadata, without effect on the picture";
        "KHR_materials_emissive_strength", Full, "factor on the emission";
        "KHR_materials_ior", Full, "reflectance of the dielectric part, refraction of glass";
        "KHR_materials_specular", Full,
            "factor on a dielectric's reflection, and its colour at normal incidence, with both textures";
    }
    "KHR_materials_specular" => {
        "specularFactor", Approximated,
            "beside metal, where one of them is textured, the factor counts at normal incidence alone";
        "specularColorFactor", Approximated,
            "beside metal or a texture, each channel dims its own of what is below: up to 15 % off";
    }
    "extension" => {
        "KHR_materials_transmission", Full,
            "glass without thickness, tinted by the base colour, mixed with the opaque surface by the factor";
    }
    "KHR_materials_transmission" => {
        "thicknessFactor", Approximated,
            "smooth glass without thickness reflects at grazing angles as two faces do: up to 27 % off";
    }
    "extension" => {
        "KHR_materials_volume", Full,
            "where it has thickness, transmission is that of solid glass, smooth or rough";
    }
    "KHR_materials_volume" => {
        "attenuationDistance", Approximated,
            "light is absorbed as over the thickness, half of it at each crossing";
        "thicknessTexture", Ignored, "the factor counts alone";
        "baseColorTexture", Approximated, "solid glass has the tint of the factor alone";
    }
    "extension" => {
        "KHR_materials_diffuse_transmission", Approximated,
            "a share of the surface lets light through diffusely and has no highlight: up to 12 % off";
        "KHR_materials_clearcoat", Full, "a layer of GGX facets over the base";
    }
    "KHR_materials_clearcoat" => {
        "transmissionFactor", Ignored, "what lets light through has no coat";
        "emissiveFactor", Ignored, "the coat does not dim what the surface emits";
        "clearcoatNormalTexture", Ignored, "the coat has the normals of the base";
    }
    "KHR_materials_sheen" => {
        "sheenRoughnessFactor", Approximated, "fibres are at least as rough as 0.1: up to 4 % off";
        "transmissionFactor", Ignored, "what lets light through has no sheen";
        "emissiveFactor", Ignored, "the sheen does not dim what the surface emits";
    }
    "extension" => {
        "KHR_materials_anisotropy", Full, "facets of two roughnesses";
    }
    "KHR_materials_anisotropy" => {
        "anisotropyTexture", Approximated,
            "glass is as rough in all directions where its roughness or its anisotropy is textured";
    }
    "extension" => {
        "KHR_materials_pbrSpecularGlossiness", Approximated,
            "diffuse part and reflectance of metallic-roughness, by channel where textured";
        "KHR_materials_unlit", Approximated, "diffuse reflection of the same colour";
        "KHR_materials_sheen", Full, "fibres over the base, by the angle at which they are seen";
        "KHR_materials_iridescence", Ignored, "left out";
        "KHR_materials_dispersion", Ignored, "one index of refraction for all wavelengths";
        "KHR_materials_variants", Ignored, "the default materials are used";
        "KHR_animation_pointer", Ignored, "what it moves stays as it is";
        "EXT_lights_ies", Full, "lamps by photometry of type C; cd count as W/sr";
        "EXT_lights_image_based", Full,
            "the first level of its cube map as environment; numbers count as W/(m²·sr)";
        "KHR_texture_basisu", Ignored, "the texture's own source is used";
        "EXT_texture_webp", Ignored, "the texture's own source is used";
        "EXT_texture_avif", Ignored, "the texture's own source is used";
        "MSFT_texture_dds", Ignored, "the texture's own source is used";
        "KHR_draco_mesh_compression", Ignored, "the data beside it are used";
        "EXT_meshopt_compression", Ignored, "the data beside it are used";
        "KHR_meshopt_compression", Ignored, "the data beside it are used";
    }
    "required extension" => {
        "KHR_draco_mesh_compression", Refused, "export the scene without mesh compression";
        "EXT_meshopt_compression", Refused, "export the scene without mesh compression";
        "KHR_meshopt_compression", Refused, "export the scene without mesh compression";
        "KHR_texture_basisu", Refused, "export the scene with PNG or JPEG textures";
        "EXT_texture_webp", Refused, "export the scene with PNG or JPEG textures";
        "EXT_texture_avif", Refused, "export the scene with PNG or JPEG textures";
        "MSFT_texture_dds", Refused, "export the scene with PNG or JPEG textures";
    }
};

/// The row of an extension that a file uses.
pub(super) fn extension(name: &str) -> Option<&'static Feature> {
    Feature::find(FEATURES, "extension", name)
}

/// Reports a feature met at `at` as its row prescribes; an unknown one is noted as ignored.
///
/// # Errors
/// [`Error::Unsupported`](crate::error::Error::Unsupported) if it is refused.
pub(super) fn met(kind: &str, name: &str, at: Location, builder: &mut SceneBuilder) -> Result<()> {
    if !Feature::look_up(FEATURES, [kind, name], &at, builder.notes_mut())? {
        builder.note(NoteKind::Ignored, Feature::unknown([kind, name], "left out"), at);
    }
    Ok(())
}
