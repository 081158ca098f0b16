//! Features of pbrt-v3 and pbrt-v4, and their support.
//!
//! A name that both formats share has one row.
//! `suite::pbrt_appearance::every_feature_gives_the_note_of_its_row` loads every row.

use crate::io::features::{Feature, Support, table};

/// All rows.
pub(in crate::io) const FEATURES: &[Feature] = table! {
    "camera" => {
        "perspective", Full, "perspective camera with thin lens";
        "orthographic", Full, "orthographic camera";
        "environment", Full, "all directions, by latitude and longitude";
        "spherical", Full, "all directions, of equal areas or by latitude and longitude";
        "realistic", Approximated, "a pinhole with a field of view of 45°";
    }
    "film" => {
        "image", Full, "size and crop of the picture";
        "rgb", Full, "size and crop of the picture";
        "gbuffer", Full, "size and crop of the picture";
        "spectral", Approximated, "red, green and blue";
    }
    "shape" => {
        "sphere", Full, "triangles";
        "disk", Full, "triangles";
        "cylinder", Full, "triangles";
        "cone", Full, "triangles";
        "paraboloid", Full, "triangles";
        "hyperboloid", Full, "triangles";
        "trianglemesh", Full, "triangles";
        "plymesh", Full, "triangles";
        "bilinearmesh", Full, "triangles";
        "loopsubdiv", Full, "triangles";
        "heightfield", Full, "triangles";
        "curve", Ignored, "left out";
        "nurbs", Ignored, "left out";
    }
    "light" => {
        "point", Full, "point light";
        "spot", Full, "spot light with the fall-off of the version";
        "distant", Full, "directional light";
        "infinite", Full, "environment: constant, latitude-longitude (v3) or octahedral (v4) map";
        "goniometric", Full, "intensity by direction: latitude-longitude (v3) or octahedral (v4) map";
        "projection", Full, "the image as a slide";
    }
    "area light" => {
        "diffuse", Full, "emission of the material";
    }
    "material" => {
        "matte", Full, "Lambert";
        "matte sigma", Approximated, "Lambert, as bright in even light: up to 11 % off";
        "plastic", Full, "diffuse with a GGX lobe";
        "metal", Full, "conductor";
        "mirror", Full, "mirror";
        "glass", Full, "smooth or rough glass";
        "uber", Full, "diffuse with a GGX lobe, mixed with a mirror or glass; opacity is alpha";
        "substrate", Full, "GGX facets over a diffuse base, by Ashikhmin and Shirley";
        "translucent", Full, "Lambert on both sides, mixed with rough glass";
        "disney", Full, "Disney's principled material, mixed with glass";
        "disney metallic", Approximated, "between 0 and 1, brighter metal: up to 29 % off";
        "disney clearcoat", Approximated, "none over the share that is glass: up to 6 % off";
        "disney thin", Approximated, "reflects what it would let through diffusely: up to 8 % off";
        "disney scatterdistance", Approximated, "light leaves where it enters";
        "hair", Approximated, "Lambert of the hair's colour";
        "subsurface", Approximated, "light leaves where it enters, under a coat: up to 10 % off";
        "kdsubsurface", Approximated, "light leaves where it enters, under a coat";
        "fourier", Approximated, "grey";
        "measured", Approximated, "grey";
        "mix", Full, "one of the two at random";
        "none", Full, "invisible";
        "", Full, "invisible";
        "interface", Full, "invisible";
        "diffuse", Full, "Lambert";
        "coateddiffuse", Full, "diffuse under a GGX coat";
        "coatedconductor", Approximated, "a conductor that reflects as both do straight on: up to 38 % off";
        "coatedconductor interface.roughness", Approximated, "a smooth coat: up to 146 % off";
        "conductor", Full, "conductor";
        "dielectric", Full, "smooth or rough glass";
        "thindielectric", Full, "a pane of glass";
        "diffusetransmission", Full, "Lambert on both sides";
    }
    "texture" => {
        "constant", Full, "a constant";
        "imagemap", Full, "an image";
        "imagemap of 16 bits", Full, "16 bits a channel";
        "imagemap .tx", Full, "its largest level: TIFF in tiles or strips, or OpenEXR";
        "imagemap <UDIM>", Full, "an image for each tile: 1001 + s + 10 t, rounded down";
        "scale", Full, "a product";
        "mix", Full, "a blend";
        "checkerboard", Full, "a checkerboard; in three dimensions its mean, noted";
        "directionmix", Approximated, "an even blend";
        "bilerp", Approximated, "the mean of its corners";
        "dots", Approximated, "the mean of inside and outside";
        "fbm", Approximated, "a constant of 0.5";
        "wrinkled", Approximated, "a constant of 0.5";
        "windy", Approximated, "a constant of 0.5";
        "marble", Approximated, "its mean colour";
        "uv", Approximated, "a constant of 0.5";
        "ptex", Ignored, "a constant grey of 0.5";
    }
    "mapping" => {
        "uv", Full, "texture coordinates";
        "planar", Approximated, "the shape's own texture coordinates";
        "spherical", Approximated, "the shape's own texture coordinates";
        "cylindrical", Approximated, "the shape's own texture coordinates";
    }
    "color space" => {
        "srgb", Full, "linear Rec. 709";
        "rec2020", Full, "its primaries";
        "dci-p3", Full, "its primaries, with the white D65";
        "aces2065-1", Full, "its primaries and its white";
    }
    "medium" => {
        "homogeneous", Full, "the same everywhere, with a phase function of Henyey and Greenstein";
        "homogeneous preset", Approximated, "the coefficients of the file, else pbrt's own";
        "homogeneous Le", Ignored, "it does not glow";
        "heterogeneous", Full, "coefficients times a grid of densities";
        "uniformgrid", Full, "coefficients times a grid of densities";
        "uniformgrid Le", Ignored, "it does not glow";
        "rgbgrid", Full, "grids of coefficients";
        "cloud", Ignored, "vacuum";
        "nanovdb", Full, "coefficients times the grid of densities of a file";
    }
    "directive" => {
        "MakeNamedMedium", Full, "a medium, by its type";
        "MediumInterface", Full, "media on both sides of shapes, and about the camera";
        "Volume", Ignored, "left out";
    }
};
