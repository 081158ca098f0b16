//! Features of Radiance files, and their support.
//!
//! Held to this by `radiance::tests`: a file with the feature of a row gives the row's note and no
//! other, or its error.

use crate::io::features::{Feature, Support, table};

/// Kind of the rows about surfaces.
pub(super) const SURFACE: &str = "surface";
/// Kind of the rows about materials.
pub(super) const MATERIAL: &str = "material";
/// Kind of the rows about patterns, textures and mixtures.
pub(super) const MODIFIER: &str = "modifier";
/// Kind of the rows about command lines.
pub(super) const COMMAND: &str = "command";
/// Row of all commands without a row.
pub(super) const OTHER_COMMANDS: &str = "all other commands";

/// Remedy for a command that makes objects.
const RUN_BEFORE: &str =
    "no command is run: write its output to a file beforehand, and read that file by !xform or !cat";
/// Replacement of modifiers.
const NO_MODIFIER: &str = "left out: the material as it is without it";
/// Remedy for materials that are computed by a function, or measured.
const NO_FORMULA: &str = "write plastic, metal, trans, glass or dielectric instead";

/// Features by kind, for the loader and the guide.
pub(in crate::io) const FEATURES: &[Feature] = table! {
    SURFACE => {
        "polygon", Full, "triangles; concave ones, and holes by seams, too";
        "sphere", Full, "fine mesh with exact normals";
        "bubble", Full, "a sphere that faces inward";
        "cone", Full, "fine mesh with exact normals";
        "cup", Full, "a cone that faces inward";
        "cylinder", Full, "fine mesh with exact normals";
        "tube", Full, "a cylinder that faces inward";
        "ring", Full, "fine mesh";
        "source", Full, "up to 2° across parallel light, else a part of the environment";
        "surface of void", Full, "invisible";
        "mesh", Refused, "name the surfaces that obj2rad makes of the mesh";
        "instance", Refused, "include the scene of the octree by !xform";
    }
    MATERIAL => {
        "plastic", Approximated,
            "Lambertian beside Beckmann's facets for Ward's lobe (which is up to 9 % off at a roughness of 0.2), or under a smooth coat";
        "metal", Approximated, "as plastic, with a coloured lobe; smooth ones have Schlick's reflectance";
        "trans", Approximated, "as plastic, Lambertian on both sides, and a pane without refraction";
        "plastic2", Approximated, "plastic of the geometric mean of its two roughnesses";
        "metal2", Approximated, "metal of the geometric mean of its two roughnesses";
        "trans2", Approximated, "trans of the geometric mean of its two roughnesses";
        "dielectric", Full, "smooth glass with an absorbing inside";
        "dielectric dispersion", Ignored, "Hartmann's constant is left out";
        "interface", Full, "smooth glass between two absorbing sides";
        "glass", Approximated,
            "a pane without refraction: exact in diffuse light; in parallel light up to 2 % off where clear, 11 % where half dark";
        "mirror", Full, "mirror in front, black behind";
        "mirror alternate", Ignored, "the material for direct view is left out";
        "light", Full, "emitting surface, on the side of its normal";
        "light alternate", Ignored, "the material for direct view is left out";
        "glow", Full, "emitting surface, on the side of its normal";
        "glow maxrad below 0", Approximated, "lights the scene as others do";
        "spotlight", Approximated, "points of light on the surface, with the cone of the file";
        "spotlight focal length", Approximated,
            "none: brighter by (1 + f/r)² at the distance r, with f the length of the direction";
        "illum", Approximated, "emitting surface: the material for direct view is left out";
        "light of a luminaire", Approximated,
            "points of light on the surface, with the intensities of the data";
        "antimatter", Refused, "cut the surfaces themselves";
        "mist", Refused, "leave the mist out";
        "prism1", Refused, NO_FORMULA;
        "prism2", Refused, NO_FORMULA;
        "ashik2", Refused, NO_FORMULA;
        "plasfunc", Refused, NO_FORMULA;
        "metfunc", Refused, NO_FORMULA;
        "transfunc", Refused, NO_FORMULA;
        "BRTDfunc", Refused, NO_FORMULA;
        "plasdata", Refused, NO_FORMULA;
        "metdata", Refused, NO_FORMULA;
        "transdata", Refused, NO_FORMULA;
        "BSDF", Refused, NO_FORMULA;
        "aBSDF", Refused, NO_FORMULA;
        "WGMDfunc", Refused, NO_FORMULA;
    }
    MODIFIER => {
        "brightdata of ies2rad", Full, "intensities of a light, with corr, flatcorr, boxcorr or cylcorr of source.cal";
        "brightfunc of gensky", Full, "the sky of a source: skybr of skybright.cal";
        "brightfunc of gendaylit", Full, "the sky of a source: skybright of perezlum.cal";
        "colorfunc", Ignored, NO_MODIFIER;
        "brightfunc", Ignored, NO_MODIFIER;
        "colordata", Ignored, NO_MODIFIER;
        "brightdata", Ignored, NO_MODIFIER;
        "colorpict", Ignored, NO_MODIFIER;
        "colortext", Ignored, NO_MODIFIER;
        "brighttext", Ignored, NO_MODIFIER;
        "spectrum", Ignored, NO_MODIFIER;
        "specfile", Ignored, NO_MODIFIER;
        "specfunc", Ignored, NO_MODIFIER;
        "specdata", Ignored, NO_MODIFIER;
        "specpict", Ignored, NO_MODIFIER;
        "texfunc", Ignored, NO_MODIFIER;
        "texdata", Ignored, NO_MODIFIER;
        "mixfunc", Refused, "name one of its materials";
        "mixdata", Refused, "name one of its materials";
        "mixpict", Refused, "name one of its materials";
        "mixtext", Refused, "name one of its materials";
    }
    COMMAND => {
        "!xform", Full, "its files, with all transforms, arrays, -n, -m, -I and -f";
        "!cat", Full, "its files; also piped into xform";
        "!genbox", Refused, RUN_BEFORE;
        "!gensky", Refused, RUN_BEFORE;
        "!gendaylit", Refused, RUN_BEFORE;
        "!gensurf", Refused, RUN_BEFORE;
        "!genprism", Refused, RUN_BEFORE;
        "!genrev", Refused, RUN_BEFORE;
        "!genworm", Refused, RUN_BEFORE;
        "!genblinds", Refused, RUN_BEFORE;
        OTHER_COMMANDS, Refused, RUN_BEFORE;
    }
};
