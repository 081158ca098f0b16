//! Features of USD files and their support.

use crate::error::{Location, Result};
use crate::io::features::{Feature, Support, table};
use crate::io::notes::Named;
use crate::scene::{NoteKind, SceneBuilder};

/// Largest number of unknown types of prims that are noted by name.
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
        "relocates", Ignored, "prims keep their paths";
        "clips", Ignored, "values of the layers themselves are used";
    }
    "attribute" => {
        "default", Full, "what counts where no time is asked for";
        "timeSamples", Approximated, "the first one, where there is no default; `--at` chooses a time";
        "spline", Ignored, "the default is used";
        "xformOpOrder", Full, "all operations, `!invert!` and `!resetXformStack!`";
        "xformOpOrder without Xform", Ignored, "prims without a type and a `Scope` are not moved, as the format has it";
        "visibility", Full, "`invisible` hides a prim and those below it";
        "purpose", Full, "`default` and `render` are drawn, `proxy` and `guide` are not; as the prim or the nearest above it says, of prototypes too";
        "model:drawMode", Ignored, "the prims themselves are drawn";
        "colorSpace:name", Ignored, "colours are linear Rec. 709";
        "lod:heuristics", Ignored, "all levels of detail are drawn";
        "of other renderers", Ignored, "`arnold:`, `karma:`, `ri:` and the like have no effect here";
        "renderVisibility", Full, "of `VisibilityAPI`: prims of purpose `render`";
    }
    "prim" => {
        "Xform", Full, "a transform";
        "Scope", Full, "a group";
        "Mesh", Full, "a mesh a material";
        "GeomSubset", Full, "faces with a material of their own";
        "GeomSubset of other elements", Ignored, "materials of points, edges and tetrahedra: the mesh's is used";
        "GeomSubset of another family", Ignored, "its material is not used, as the format has it: the family `materialBind` is for them";
        "Cube", Full, "a mesh";
        "Sphere", Full, "a mesh of the same area";
        "Cylinder", Full, "a mesh of the same area, with its ends";
        "Cone", Full, "a mesh of nearly the same area, with its base";
        "Plane", Full, "a mesh";
        "ParticleField", Ignored, "left out";
        "ParticleField3DGaussianSplat", Ignored, "left out";
        "GenerativeProcedural", Ignored, "left out";
        "Field3DAsset", Ignored, "left out with its volume";
        "OpenVDBAsset", Ignored, "left out with its volume";
        "LightFilter", Ignored, "the light itself is used";
        "PluginLightFilter", Ignored, "the light itself is used";
        "LODDistanceHeuristic", Ignored, "all levels of detail are drawn";
        "LODScreenSizeHeuristic", Ignored, "all levels of detail are drawn";
        "RenderPass", Ignored, "size and quality are options";
        "BlendShape", Full, "no effect: meshes are as they are at rest, which their `SkelRoot` is noted for";
        "SkelAnimation", Full, "no effect: meshes are as they are at rest, which their `SkelRoot` is noted for";
        "SpatialAudio", Full, "no effect on pictures";
        "Backdrop", Full, "no effect on pictures";
        "PhysicsScene", Full, "no effect: nothing is simulated";
        "PhysicsCollisionGroup", Full, "no effect: nothing is simulated";
        "PhysicsJoint", Full, "no effect: nothing is simulated";
        "PhysicsDistanceJoint", Full, "no effect: nothing is simulated";
        "PhysicsFixedJoint", Full, "no effect: nothing is simulated";
        "PhysicsPrismaticJoint", Full, "no effect: nothing is simulated";
        "PhysicsRevoluteJoint", Full, "no effect: nothing is simulated";
        "PhysicsSphericalJoint", Full, "no effect: nothing is simulated";
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
        "PointInstancer", Full, "instances of its prototypes, without `inactiveIds` and `invisibleIds`";
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
        "holeIndices", Full, "these faces are not there";
        "orientation of a shape", Ignored, "its outside is its front";
        "doubleSided", Full, "of meshes whose material shines: both sides do; all others are seen from both sides anyhow";
    }
    "primvar" => {
        "normals", Full, "shading normals: `constant`, `uniform`, `vertex`, `varying` or `faceVarying`, with indices";
        "st", Full, "texture coordinates, by the name that the material asks for";
        "displayColor", Approximated, "of prims without a material, one colour: the mean where it varies; of prims above where it is constant";
        "displayOpacity", Approximated, "as the colour: the share that is there; the mean where it varies";
    }
    "material" => {
        "material:binding", Full, "also of prims above, of prototypes in their own place, with `bindMaterialAs`; `material:binding:full` before others";
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
        "scale and bias of normals", Approximated, "2 and −1 are used where neither is given and no texel is below zero";
        "bias below 0 or of opacity", Ignored, "of colours, below 0; of opacity: the texture times `scale` is used";
        "one channel as a colour", Approximated, "all three are used";
    }
    "camera" => {
        "Camera", Full, "perspective or orthographic; the vertical aperture counts, and a lens where there are `fStop` and `focusDistance`";
        "clippingPlanes", Ignored, "nothing is clipped";
        "exposure", Ignored, "also `exposure:iso` and others: films hold radiance, and `--exposure` makes pictures of them";
        "shutter:open", Ignored, "nothing is blurred";
        "backPlate", Ignored, "there is no picture behind the scene";
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
        "inputs:shaping:ies:angleScale", Ignored, "the profile is used as it is";
        "inputs:shaping:ies:normalize", Ignored, "the profile is used as it is";
        "inputs:shadow", Ignored, "shadows are where no light comes";
        "treatAsLine", Ignored, "the cylinder shines";
        "inputs:texture:format", Ignored, "but for `latlong`: the light's colour without its texture";
        "second DomeLight texture", Ignored, "the first is used, and no dome without a texture beside it";
        "inputs:diffuse", Ignored, "light is reflected as surfaces do it";
        "inputs:specular", Ignored, "light is reflected as surfaces do it";
        "light:filters", Ignored, "the light itself is used";
        "collection:lightLink", Ignored, "lights shine on everything";
        "MeshLightAPI", Ignored, "the mesh with its material; `emissiveColor` shines";
        "light of a prototype", Ignored, "left out";
    }
    "no effect" => {
        "extent", Full, "bounds are computed";
        "proxyPrim", Full, "proxies are not drawn";
        "guideVisibility", Full, "also `proxyVisibility`: guides and proxies are not drawn";
        "material:binding:preview", Full, "pictures are final renders";
        "velocities", Full, "also accelerations: where things are between two samples is blended";
        "motion:blurScale", Full, "nothing is blurred";
        "model:applyDrawMode", Full, "also cards: see `model:drawMode`";
        "colorSpaceDefinition", Full, "see `colorSpace:name`";
        "skel:skeleton", Full, "meshes are as they are at rest, which their `SkelRoot` is noted for";
        "creaseIndices", Full, "also corners and boundaries: a subdivision surface is its cage";
        "clippingRange", Full, "surfaces before and beyond it are seen as well";
        "stereoRole", Full, "each camera is one of its own";
        "collection", Full, "collections matter by what uses them";
        "coordSys", Full, "no shader that is read uses them";
        "lightList", Full, "lights are found where they are";
        "light:shaderId", Full, "also `light:materialSyncMode`: lights are what their type says";
        "portals", Full, "lights find their way without";
        "guideRadius", Full, "of what viewers draw for a dome";
        "shaping:focusTint", Full, "see `inputs:shaping:focus`";
        "shadow:falloffGamma", Full, "see `inputs:shadow`";
        "hydra", Full, "of viewers";
        "physics", Full, "nothing is simulated";
        "accessibility", Full, "also authorship, labels and places in windows: words for people";
    }
};

/// Returns true if the table has a row for a feature.
pub(super) fn is_known(kind: &str, name: &str) -> bool {
    Feature::find(FEATURES, kind, name).is_some()
}

/// Reports a feature met at `at` as its row prescribes.
///
/// # Errors
/// [`Error::Unsupported`](crate::error::Error::Unsupported) if it is refused.
pub(super) fn met(kind: &str, name: &str, at: Location, builder: &mut SceneBuilder) -> Result<()> {
    Feature::look_up(FEATURES, [kind, name], &at, builder.notes_mut()).map(drop)
}

/// Notes an unknown type of prim.
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
