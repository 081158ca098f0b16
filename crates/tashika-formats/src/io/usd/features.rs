//! What a USD file may hold, and what becomes of it here.

use crate::error::{Location, Result};
use crate::io::features::{Feature, Support, table};
use crate::io::notes::Named;
use crate::scene::{NoteKind, SceneBuilder};

/// Most unknown types of prims that are noted by name.
pub(super) const MAX_UNKNOWN: usize = 50;

/// All features, by kind and name.
pub(in crate::io) const FEATURES: &[Feature] = table! {
    "file" => {
        "usda", Full, "text";
        "usdc", Full, "\"crate\" files of versions 0.4 to 0.13";
        "usd", Full, "either, as it begins";
        "usdz", Full, "an archive of files that are not compressed; the first one is the scene";
    }
    "stage" => {
        "metersPerUnit", Full, "lengths become metres; 0.01 where it is not said, as the format has it";
        "upAxis", Full, "a scene whose up is `Z` is turned so that its up is `+y`: `(x, z, −y)`";
        "timeCodesPerSecond", Full, "what `--at` counts in; else `framesPerSecond`, else 24";
    }
    "composition" => {
        "subLayers", Full, "layers below a layer, the first the strongest";
        "references", Full, "prims of this or another file, with edits of the list";
        "payload", Full, "as references, and weaker; always loaded";
        "inherits", Full, "classes of the same file";
        "specializes", Full, "classes, weaker than what is beside them";
        "variants", Full, "the variant that is selected";
        "over", Full, "opinions about a prim that something else defines";
        "instanceable", Full, "meshes are shared between all prims that the same is said of";
        "layer offset", Ignored, "times of sublayers and references are not shifted or scaled";
    }
    "attribute" => {
        "default", Full, "what counts where no time is asked for";
        "timeSamples", Approximated, "the first one, where there is no default; `--at` chooses a time";
        "spline", Ignored, "the default is used";
        "xformOpOrder", Full, "all operations, `!invert!` and `!resetXformStack!`";
        "visibility", Full, "`invisible` hides a prim and those below it";
        "purpose", Full, "`default` and `render` are drawn, `proxy` and `guide` are not";
    }
    "prim" => {
        "Xform", Full, "a transform";
        "Scope", Full, "a group";
        "Mesh", Full, "a mesh a material";
        "GeomSubset", Full, "faces with a material of their own";
        "Cube", Full, "a mesh";
        "Sphere", Full, "a mesh of the same area";
        "Cylinder", Full, "a mesh of the same area, with its ends";
        "Cone", Full, "a mesh of nearly the same area, with its base";
        "Plane", Full, "a mesh";
        "Capsule", Ignored, "left out";
        "Capsule_1", Ignored, "left out";
        "Cylinder_1", Ignored, "left out";
        "BasisCurves", Ignored, "left out";
        "NurbsCurves", Ignored, "left out";
        "HermiteCurves", Ignored, "left out";
        "NurbsPatch", Ignored, "left out";
        "TetMesh", Ignored, "left out";
        "Points", Ignored, "left out";
        "Volume", Ignored, "left out";
        "SkelRoot", Approximated, "meshes are as they are at rest";
        "Skeleton", Approximated, "meshes are as they are at rest";
        "PointInstancer", Full, "instances of its prototypes";
        "PointInstancer in a PointInstancer", Ignored, "left out";
        "GeometryLight", Ignored, "left out";
        "PortalLight", Ignored, "left out: lights find their way without";
        "PluginLight", Ignored, "left out";
        "RenderSettings", Ignored, "size and quality are options";
        "RenderProduct", Ignored, "size and quality are options";
        "RenderVar", Ignored, "size and quality are options";
    }
    "mesh" => {
        "subdivisionScheme", Approximated, "a subdivision surface is its cage; `none` is a mesh of polygons, but `catmullClark` where it is not said";
        "orientation", Full, "faces of `leftHanded` meshes run the other way round";
        "doubleSided", Full, "of meshes whose material shines: both sides do; all others are seen from both sides anyhow";
    }
    "primvar" => {
        "normals", Full, "shading normals: `constant`, `uniform`, `vertex`, `varying` or `faceVarying`, with indices";
        "st", Full, "texture coordinates, by the name that the material asks for";
        "displayColor", Approximated, "of prims without a material, one colour: the mean where it varies";
    }
    "material" => {
        "material:binding", Full, "also of prims above, with `bindMaterialAs`; `material:binding:full` before others";
        "material:binding:collection", Ignored, "what is bound without collections is used";
        "UsdPreviewSurface", Full, "metallic-roughness, under a clear coat";
        "another surface of MaterialX", Ignored, "the `UsdPreviewSurface` of the same material is used, or else the prim's `displayColor`, or grey";
        "another surface", Ignored, "the prim's `displayColor`, or grey";
        "outputs:volume", Ignored, "there is no medium";
    }
    "UsdPreviewSurface" => {
        "diffuseColor", Full, "base colour";
        "metallic", Full, "metalness";
        "roughness", Full, "α is its square";
        "useSpecularWorkflow", Full, "`specularColor` is the reflectance at normal incidence";
        "ior", Full, "reflectance at normal incidence of what is no metal";
        "clearcoat", Full, "a clear coat, with `clearcoatRoughness`";
        "emissiveColor", Full, "radiance";
        "normal", Full, "a normal map";
        "opacityThreshold", Full, "holes where the opacity is below it";
        "opacity", Approximated, "the share that is not opaque is a pane that light passes straight; with `opacityMode` `presence` nothing is there";
        "displacement", Ignored, "the surface is not moved";
        "occlusion", Full, "light is computed, so it is not needed";
        "UsdPrimvarReader as a value", Approximated, "its fallback, or that of the input";
        "another shader", Ignored, "the input's fallback is used";
    }
    "MaterialX" => {
        "standard_surface", Full, "base, gloss, sheen, coat, glass, emission and opacity, where all of its nodes are understood or there is no `UsdPreviewSurface`";
        "open_pbr_surface", Full, "the same; `emission_luminance` is radiance";
        "gltf_pbr", Full, "the same, as in glTF";
        "ND_UsdPreviewSurface", Full, "as `UsdPreviewSurface`";
        "image", Full, "a texture, as `tiledimage` and `gltf_image`, with `colorSpace`: sRGB or linear; without one, colours are sRGB";
        "place2d", Full, "mapped texture coordinates, of `texcoord`, `geompropvalue` and readers; also `multiply`";
        "multiply", Full, "also `mix`, `invert`, `constant`, `convert`, `dot`, `extract` and `separate`";
        "normalmap", Full, "a normal map";
        "subsurface", Approximated, "light leaves where it enters: that share of the base has the colour";
        "transmission depth", Approximated, "the root of the tint at each crossing";
        "textures of the tint of solid glass", Ignored, "the factor is used";
        "diffuse roughness", Ignored, "the base is Lambertian";
        "anisotropy", Ignored, "facets are as rough in all directions";
        "scattering inside", Ignored, "nothing is scattered inside of glass";
        "dispersion", Ignored, "one index for all colours";
        "extra roughness", Ignored, "glass is as rough as it reflects";
        "colour and index of the coat", Ignored, "a clear coat of index 1.5";
        "normals of the coat", Ignored, "those of the surface";
        "thin film", Ignored, "there is no film";
    }
    "UsdUVTexture" => {
        "file", Full, "a texture, also in tiles (`<UDIM>`)";
        "wrapS", Full, "`repeat`, `clamp`, `mirror`, `black`; `useMetadata` is black beyond the sides";
        "scale", Full, "a factor, with `bias` after it";
        "sourceColorSpace", Full, "`raw` or `sRGB`; `auto` is sRGB for colours";
        "sourceColorSpace auto", Approximated, "of numbers: raw";
        "UsdPrimvarReader_float2", Full, "texture coordinates";
        "UsdTransform2d", Full, "scaled, turned and moved texture coordinates";
        "st from another shader", Ignored, "`st` itself is used";
        "second set of coordinates", Approximated, "all textures of a material use the first one's";
        "scale and bias of normals", Approximated, "2 and −1 are used";
        "bias below 0 or of opacity", Ignored, "the texture times `scale` is used";
        "one channel as a colour", Approximated, "all three are used";
    }
    "camera" => {
        "Camera", Full, "perspective or orthographic; the vertical aperture counts, and a lens where there are `fStop` and `focusDistance`";
    }
    "light" => {
        "DistantLight", Full, "parallel light";
        "SphereLight", Full, "a sphere that shines, or with `treatAsPoint` a point";
        "RectLight", Full, "a rectangle that shines, with its texture";
        "DiskLight", Full, "a disk that shines";
        "CylinderLight", Full, "a cylinder that shines, without its ends";
        "DomeLight", Full, "what is seen where no surface is, also `DomeLight_1`";
        "inputs:normalize", Full, "divides by the area in the scene's own units";
        "inputs:colorTemperature", Full, "the colour of a black body, of luminance 1";
        "inputs:angle", Approximated, "of distant lights: all light comes from the middle, as strong as it is";
        "inputs:shaping:cone:angle", Approximated, "of spheres: a spot in the middle; it fades by the cosine between its two angles";
        "shaping of other lights", Ignored, "they shine in all directions";
        "inputs:shaping:focus", Ignored, "light is as strong in all directions";
        "inputs:shaping:ies:file", Approximated, "of spheres: a point that shines by the profile";
        "inputs:texture:format", Ignored, "but for `latlong`: the light's colour without its texture";
        "second DomeLight texture", Ignored, "the first is used, and no dome without a texture beside it";
        "inputs:diffuse", Ignored, "light is reflected as surfaces do it";
        "inputs:specular", Ignored, "light is reflected as surfaces do it";
        "light:filters", Ignored, "the light itself is used";
        "collection:lightLink", Ignored, "lights shine on everything";
        "MeshLightAPI", Ignored, "the mesh with its material; `emissiveColor` shines";
        "light of a prototype", Ignored, "left out";
    }
};

/// Whether the table has a row for it.
pub(super) fn is_known(kind: &str, name: &str) -> bool {
    Feature::find(FEATURES, kind, name).is_some()
}

/// Says what the table says about a thing met at `at`.
///
/// # Errors
/// [`Error::Unsupported`](crate::error::Error::Unsupported) if it is refused.
pub(super) fn met(kind: &str, name: &str, at: Location, builder: &mut SceneBuilder) -> Result<()> {
    Feature::look_up(FEATURES, [kind, name], &at, builder.notes_mut()).map(drop)
}

/// Says that a type of prim is not known.
pub(super) fn unknown(name: &str, at: Location, named: &mut Named, builder: &mut SceneBuilder) {
    let message = Feature::unknown(["prim", name], "what is below it is read");
    named.add(
        NoteKind::Ignored,
        message,
        "prims of other unknown types: what is below them is read",
        at,
        builder.notes_mut(),
    );
}
