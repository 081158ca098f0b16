//! Features of Mitsuba files, and their support.
//!
//! Held to this by `suite::mitsuba::every_feature_gives_the_note_that_its_row_promises`.

use crate::io::features::{Feature, Support, table};

/// Features by kind, for the loader and the guide.
pub(in crate::io) const FEATURES: &[Feature] = table! {
    "material" => {
        "diffuse", Full, "Lambertian";
        "roughdiffuse", Approximated, "Lambertian, as bright in even light: up to 6 % off";
        "dielectric", Full, "smooth glass";
        "thindielectric", Full, "a pane of glass without refraction";
        "roughdielectric", Full, "rough glass";
        "conductor", Full, "mirror with the Fresnel reflectance of the metal";
        "roughconductor", Full, "GGX with the Fresnel reflectance of the metal";
        "plastic", Full, "smooth dielectric coat over a Lambertian base";
        "roughplastic", Full, "rough dielectric coat over a Lambertian base";
        "pplastic", Approximated, "smooth or rough plastic, not polarized: up to 25 % off";
        "principled", Full, "Disney's principled material; glass where it transmits";
        "principled anisotropic", Approximated, "of glass by its factor alone where it is textured";
        "principled clearcoat", Approximated, "none over the share that is glass: up to 5 % off";
        "principled spec_trans", Approximated,
            "beside textured metal: metal lets light through as the rest does";
        "principledthin", Approximated,
            "principled; thin glass or a diffuse sheet where it transmits: up to 197 % off";
        "phong", Full, "modified Phong";
        "ward", Approximated, "metal of Beckmann's facets on Lambertian: up to 11 % off";
        "hair", Approximated, "Lambertian";
        "measured", Approximated, "Lambertian grey of reflectance 0.5: the data are not read";
        "measured_polarized", Approximated, "Lambertian grey of reflectance 0.5: the data are not read";
        "irawan", Approximated, "Lambertian grey of reflectance 0.5";
        "hk", Approximated, "Lambertian on both sides";
        "coating", Full, "smooth coat over a Lambertian base";
        "roughcoating", Full, "rough coat over a Lambertian base";
        "coating over no diffuse", Approximated, "the base without its coat: up to 25 % off";
        "coating sigma_a", Approximated, "a clear coat";
        "bumpmap", Full, "shading normals from heights";
        "normalmap", Full, "shading normals from a map";
        "mask", Full, "opacity";
        "twosided", Full, "its material on both sides, or one on each; other opaque ones are black behind";
        "blendbsdf", Full, "one of two at each point, at random";
        "mixturebsdf", Full, "one of several at each point, at random";
        "difftrans", Full, "Lambertian transmission";
        "null", Full, "invisible";
        "polarizer", Ignored, "invisible";
        "retarder", Ignored, "invisible";
        "circular", Ignored, "invisible";
        "distribution phong", Approximated, "Beckmann's of the same roughness";
        "distribution as", Approximated, "Beckmann's of the same roughness";
        "anisotropic roughness", Approximated,
            "of plastics, the root mean square for the light that the coat lets in";
    }
    "texture" => {
        "bitmap", Full, "image";
        "bitmap of 16 bits", Full, "image of 16 bits a channel";
        "bitmap <UDIM>", Full, "an image for each tile: 1001 + u + 10 v, rounded down, v running up";
        "bitmap .tx", Full, "its largest level: TIFF in tiles or strips, or OpenEXR";
        "checkerboard", Full, "checkerboard";
        "scale", Full, "product";
        "gridtexture", Approximated, "colour between its lines";
        "mesh_attribute", Approximated, "grey of 0.5";
        "vertexcolors", Approximated, "grey of 0.5";
        "volume", Approximated, "grey of 0.5";
        "noise", Approximated, "grey of 0.5";
        "curvature", Approximated, "grey of 0.5";
        "wireframe", Approximated, "colour between its edges";
        "uniform", Full, "constant";
        "srgb", Full, "constant";
        "d65", Full, "white of the given scale";
        "regular", Full, "constant: the spectrum's colour";
        "irregular", Full, "constant: the spectrum's colour";
        "blackbody", Full, "constant: the spectrum's colour";
        "opacity of an image with alpha", Approximated, "the alpha, where Mitsuba takes the luminance";
        "filter ewa", Approximated, "bilinear interpolation";
        "wrap one", Approximated, "black outside of the image";
    }
    "shape" => {
        "obj", Full, "mesh";
        "ply", Full, "mesh";
        "serialized", Full, "mesh";
        "rectangle", Full, "mesh";
        "cube", Full, "mesh";
        "sphere", Full, "fine mesh with exact normals";
        "disk", Full, "fine mesh";
        "cylinder", Full, "fine mesh with exact normals";
        "shapegroup", Full, "meshes that its instances share";
        "instance", Full, "instances of the group's meshes";
        "merge", Full, "its shapes";
        "hair", Ignored, "left out";
        "heightfield", Ignored, "left out";
        "sdfgrid", Ignored, "left out";
        "bsplinecurve", Ignored, "left out";
        "linearcurve", Ignored, "left out";
        "ellipsoids", Ignored, "left out";
        "ellipsoidsmesh", Ignored, "left out";
        "deformable", Ignored, "left out";
        "max_smooth_angle", Approximated,
            "flat faces where the angle is below 30°, else the mesh's own normals";
    }
    "light" => {
        "area", Full, "emitting surface, on the side of its normals";
        "point", Full, "point";
        "spot", Full, "spot";
        "spot texture", Full, "the image as a slide";
        "directional", Full, "parallel light";
        "directionalarea", Approximated, "emitting surface with a cosine lobe";
        "constant", Full, "constant environment";
        "envmap", Full, "latitude-longitude environment";
        "sky", Approximated, "clear sky of Preetham, Shirley and Smits 1999";
        "sun", Approximated, "parallel light behind the atmosphere of Preetham, Shirley and Smits 1999";
        "sunsky", Approximated, "sun and clear sky of Preetham, Shirley and Smits 1999";
        "collimated", Ignored, "left out";
        "projector", Full, "the image as a slide";
        "second environment", Ignored, "left out: the first one is seen";
    }
    "camera" => {
        "perspective", Full, "pinhole";
        "thinlens", Full, "thin lens";
        "orthographic", Full, "orthographic";
        "perspective_rdist", Approximated, "pinhole without distortion";
        "telecentric", Approximated, "orthographic";
        "spherical", Full, "all directions, by latitude and longitude";
        "irradiancemeter", Ignored, "left out";
        "radiancemeter", Ignored, "left out";
        "fluencemeter", Ignored, "left out";
        "distant", Ignored, "left out";
        "batch", Full, "its cameras";
    }
    "film" => {
        "hdrfilm", Full, "its size and window";
        "ldrfilm", Full, "its size and window";
        "specfilm", Full, "its size and window";
        "mfilm", Full, "its size and window";
        "tiledhdrfilm", Full, "its size and window";
    }
    "medium" => {
        "homogeneous", Full, "the same everywhere: in shapes, about them, and about cameras";
        "homogeneous material", Approximated, "the coefficients of the file, else an extinction of 1 and an albedo of 0.75";
        "heterogeneous", Full, "extinction and albedo by grids";
        "dipole", Ignored, "the surface alone";
        "singlescatter", Ignored, "the surface alone";
    }
    "volume" => {
        "constvolume", Full, "its value";
        "gridvolume", Full, "a file of numbers or colours, trilinear, for sigma_t (density) and albedo";
        "gridvolume nearest", Approximated, "trilinear";
        "gridvolume repeat", Approximated, "clamp";
        "gridvolume mirror", Approximated, "clamp";
    }
    "phase function" => {
        "isotropic", Full, "isotropic";
        "hg", Full, "that of Henyey and Greenstein";
        "rayleigh", Approximated, "isotropic";
        "tabphase", Approximated, "isotropic";
        "blendphase", Approximated, "isotropic";
        "mixturephase", Approximated, "isotropic";
        "sggx", Approximated, "isotropic";
        "microflake", Approximated, "isotropic";
        "kkay", Approximated, "isotropic";
    }
};
