//! What Mitsuba files may name, and what becomes of it.
//!
//! Held to this by `suite::mitsuba::every_feature_gives_the_note_that_its_row_promises`.

use crate::io::features::{Feature, Support};

use Support::{Approximated, Full, Ignored};

const fn full(kind: &'static str, name: &'static str, how: &'static str) -> Feature {
    Feature::new(kind, name, Full, how)
}

const fn near(kind: &'static str, name: &'static str, how: &'static str) -> Feature {
    Feature::new(kind, name, Approximated, how)
}

const fn none(kind: &'static str, name: &'static str, how: &'static str) -> Feature {
    Feature::new(kind, name, Ignored, how)
}

/// What the Mitsuba loader knows.
pub(in crate::io) const FEATURES: &[Feature] = &[
    // Materials.
    full("material", "diffuse", "Lambertian"),
    near("material", "roughdiffuse", "Lambertian, as bright in even light: up to 6 % off"),
    full("material", "dielectric", "smooth glass"),
    full("material", "thindielectric", "a pane of glass without refraction"),
    full("material", "roughdielectric", "rough glass"),
    full("material", "conductor", "mirror with the Fresnel reflectance of the metal"),
    full("material", "roughconductor", "GGX with the Fresnel reflectance of the metal"),
    full("material", "plastic", "smooth dielectric coat over a Lambertian base"),
    full("material", "roughplastic", "rough dielectric coat over a Lambertian base"),
    near("material", "pplastic", "smooth or rough plastic, not polarized: up to 25 % off"),
    full("material", "principled", "Disney's principled material; glass where it transmits"),
    near("material", "principled anisotropic", "of glass by its factor alone where it is textured"),
    near("material", "principled clearcoat", "none over the share that is glass: up to 5 % off"),
    near(
        "material",
        "principled spec_trans",
        "beside textured metal: metal lets light through as the rest does",
    ),
    near(
        "material",
        "principledthin",
        "principled; thin glass or a diffuse sheet where it transmits: up to 197 % off",
    ),
    full("material", "phong", "modified Phong"),
    near("material", "ward", "metal of Beckmann's facets on Lambertian: up to 11 % off"),
    near("material", "hair", "Lambertian"),
    near("material", "measured", "Lambertian grey of reflectance 0.5: the data are not read"),
    near("material", "measured_polarized", "Lambertian grey of reflectance 0.5: the data are not read"),
    near("material", "irawan", "Lambertian grey of reflectance 0.5"),
    near("material", "hk", "Lambertian on both sides"),
    full("material", "coating", "smooth coat over a Lambertian base"),
    full("material", "roughcoating", "rough coat over a Lambertian base"),
    near("material", "coating over no diffuse", "the base without its coat: up to 25 % off"),
    near("material", "coating sigma_a", "a clear coat"),
    full("material", "bumpmap", "shading normals from heights"),
    full("material", "normalmap", "shading normals from a map"),
    full("material", "mask", "opacity"),
    full(
        "material",
        "twosided",
        "its material on both sides, or one on each; other opaque ones are black behind",
    ),
    full("material", "blendbsdf", "one of two at each point, at random"),
    full("material", "mixturebsdf", "one of several at each point, at random"),
    full("material", "difftrans", "Lambertian transmission"),
    full("material", "null", "invisible"),
    none("material", "polarizer", "invisible"),
    none("material", "retarder", "invisible"),
    none("material", "circular", "invisible"),
    near("material", "distribution phong", "Beckmann's of the same roughness"),
    near("material", "distribution as", "Beckmann's of the same roughness"),
    near(
        "material",
        "anisotropic roughness",
        "of ward the geometric mean in all directions, of plastic the root mean square in what the coat lets in",
    ),
    // Textures and spectra.
    full("texture", "bitmap", "image"),
    full("texture", "bitmap of 16 bits", "image of 16 bits a channel"),
    full("texture", "bitmap <UDIM>", "an image for each tile: 1001 + u + 10 v, rounded down, v running up"),
    full("texture", "bitmap .tx", "its largest level: TIFF in tiles or strips, or OpenEXR"),
    full("texture", "checkerboard", "checkerboard"),
    full("texture", "scale", "product"),
    near("texture", "gridtexture", "colour between its lines"),
    near("texture", "mesh_attribute", "grey of 0.5"),
    near("texture", "vertexcolors", "grey of 0.5"),
    near("texture", "volume", "grey of 0.5"),
    near("texture", "noise", "grey of 0.5"),
    near("texture", "curvature", "grey of 0.5"),
    near("texture", "wireframe", "colour between its edges"),
    full("texture", "uniform", "constant"),
    full("texture", "srgb", "constant"),
    full("texture", "d65", "white of the given scale"),
    full("texture", "regular", "constant: the spectrum's colour"),
    full("texture", "irregular", "constant: the spectrum's colour"),
    full("texture", "blackbody", "constant: the spectrum's colour"),
    near("texture", "opacity of an image with alpha", "the alpha, where Mitsuba takes the luminance"),
    near("texture", "filter ewa", "bilinear interpolation"),
    near("texture", "wrap one", "black outside of the image"),
    // Shapes.
    full("shape", "obj", "mesh"),
    full("shape", "ply", "mesh"),
    full("shape", "serialized", "mesh"),
    full("shape", "rectangle", "mesh"),
    full("shape", "cube", "mesh"),
    full("shape", "sphere", "fine mesh with exact normals"),
    full("shape", "disk", "fine mesh"),
    full("shape", "cylinder", "fine mesh with exact normals"),
    full("shape", "shapegroup", "meshes that its instances share"),
    full("shape", "instance", "instances of the group's meshes"),
    full("shape", "merge", "its shapes"),
    none("shape", "hair", "left out"),
    none("shape", "heightfield", "left out"),
    none("shape", "sdfgrid", "left out"),
    none("shape", "bsplinecurve", "left out"),
    none("shape", "linearcurve", "left out"),
    none("shape", "ellipsoids", "left out"),
    none("shape", "ellipsoidsmesh", "left out"),
    none("shape", "deformable", "left out"),
    near("shape", "max_smooth_angle", "flat faces where the angle is below 30°, else the mesh's own normals"),
    // Lights.
    full("light", "area", "emitting surface, on the side of its normals"),
    full("light", "point", "point"),
    full("light", "spot", "spot"),
    full("light", "spot texture", "the image as a slide"),
    full("light", "directional", "parallel light"),
    near("light", "directionalarea", "emitting surface with a cosine lobe"),
    full("light", "constant", "constant environment"),
    full("light", "envmap", "latitude-longitude environment"),
    near("light", "sky", "clear sky of Preetham, Shirley and Smits 1999"),
    near("light", "sun", "parallel light behind the atmosphere of Preetham, Shirley and Smits 1999"),
    near("light", "sunsky", "sun and clear sky of Preetham, Shirley and Smits 1999"),
    none("light", "collimated", "left out"),
    full("light", "projector", "the image as a slide"),
    none("light", "second environment", "left out: the first one is seen"),
    // Cameras and films.
    full("camera", "perspective", "pinhole"),
    full("camera", "thinlens", "thin lens"),
    full("camera", "orthographic", "orthographic"),
    near("camera", "perspective_rdist", "pinhole without distortion"),
    near("camera", "telecentric", "orthographic"),
    full("camera", "spherical", "all directions, by latitude and longitude"),
    none("camera", "irradiancemeter", "left out"),
    none("camera", "radiancemeter", "left out"),
    none("camera", "fluencemeter", "left out"),
    none("camera", "distant", "left out"),
    full("camera", "batch", "its cameras"),
    full("film", "hdrfilm", "its size and window"),
    full("film", "ldrfilm", "its size and window"),
    full("film", "specfilm", "its size and window"),
    full("film", "mfilm", "its size and window"),
    full("film", "tiledhdrfilm", "its size and window"),
    // Volumes.
    none("medium", "homogeneous", "vacuum"),
    none("medium", "heterogeneous", "vacuum"),
    none("medium", "dipole", "the surface alone"),
    none("medium", "singlescatter", "the surface alone"),
];
