//! Features of OBJ and MTL files, and their support.
//!
//! Statements that only make sense together share a row. [`Tally`](super::tally::Tally) counts the
//! features of one file. The text of each note comes from its row.
//!
//! Held to this by `suite::obj_features`: for every row, a file with only that feature gives the
//! row's note and no other.

use crate::error::Location;
use crate::io::features::{Feature, Support, table};
use crate::scene::Notes;

/// Kind of the rows about statements of OBJ files.
pub(super) const STATEMENT: &str = "statement";

/// Kind of the rows about statements of MTL files.
pub(super) const MATERIAL: &str = "material statement";

/// Kind of the rows about a material definition as a whole.
pub(super) const MEANING: &str = "material";

/// Row of free-form curves and surfaces.
pub(super) const FREE_FORM: &str = "vp, cstype, curv, surf";
/// Row of display and render attributes.
pub(super) const DISPLAY: &str = "lod, bevel, shadow_obj";
/// Images outside materials.
pub(super) const OUTER_MAPS: &str = "maplib, usemap";
/// Other files and programs.
pub(super) const COMMANDS: &str = "call, csh";
/// Vertices with more numbers than a position.
pub(super) const VERTEX_COLORS: &str = "v x y z r g b";
/// Height maps.
pub(super) const BUMP: &str = "bump, map_bump, disp";
/// The physically based extension, except metalness and roughness.
pub(super) const SHEEN: &str = "Ps, Pc, aniso, map_RMA";
/// Colours that are given as spectra or XYZ.
pub(super) const SPECTRAL: &str = "Kd spectral, Kd xyz";
/// Options of texture statements that change values.
pub(super) const MODIFIED: &str = "-mm, -t, -bm, -boost, -cc";

/// Features by kind, for the loader and the guide.
pub(in crate::io) const FEATURES: &[Feature] = table! {
    STATEMENT => {
        "v", Full, "vertices (m)";
        "vt", Full, "texture coordinates";
        "vn", Full, "shading normals";
        "f", Full, "polygons, cut into triangles; also under its old name fo";
        "s", Full, "smoothing groups: normals where there are none";
        "usemtl", Full, "one mesh for each material";
        "mtllib", Full, "definitions of materials; of a name the first counts";
        "o", Full, "names a part, and so do g and mg";
        VERTEX_COLORS, Ignored, "vertex colours are left out";
        "p", Ignored, "points are left out";
        "l", Ignored, "line elements are left out";
        FREE_FORM, Ignored, "free-form curves and surfaces are left out";
        DISPLAY, Ignored, "display and render attributes are left out";
        OUTER_MAPS, Ignored, "texture maps outside materials are left out";
        COMMANDS, Ignored, "other files and commands are left out";
    }
    MATERIAL => {
        "newmtl", Full, "starts a material";
        "Kd", Full, "diffuse reflectance or base colour, with map_Kd";
        "Ks", Full, "specular reflectance, with map_Ks";
        "Ns", Full, "exponent about the mirror direction";
        "Ke", Full, "radiance of both sides (W·m⁻²·sr⁻¹), with map_Ke";
        "Ka", Full, "without effect, as is map_Ka: light transport takes the place of ambient light";
        "d", Full, "opacity, with map_d";
        "Tr", Full, "one minus opacity";
        "Tf", Full, "transmittance of glass";
        "Ni", Full, "index of refraction";
        "illum", Full, "which of the surfaces below; 0 and 1 have no highlight";
        "Pr", Full, "roughness of metallic-roughness, with map_Pr";
        "Pm", Full, "metalness of metallic-roughness, with map_Pm";
        "norm", Full, "normal map, also as map_norm and map_Kn";
        "map_Kd -o -s -clamp -imfchan", Full, "offset, scale, wrapping and channel of any map";
        "map_Kd of 16 bits", Full, "16 bits a channel, of any map";
        "map_Kd .tx", Full, "its largest level: TIFF in tiles or strips, or OpenEXR; of any map";
        "map_Kd <UDIM>", Full, "an image for each tile: 1001 + u + 10 v, rounded down; of any map";
        MODIFIED, Ignored, "these options of maps are left out";
        SPECTRAL, Ignored, "colours of files and of CIE XYZ are left out, the default is used";
        BUMP, Ignored, "bump and displacement maps are left out";
        "refl", Ignored, "reflection maps are left out";
        "decal", Ignored, "decals are left out";
        "map_Ns", Ignored, "maps of specular exponents are left out";
        SHEEN, Ignored, "sheen, clear coat, anisotropy and packed maps are left out";
    }
    MEANING => {
        "illum 3, 5", Approximated,
            "where Ks is brighter than Kd, a perfect mirror of Ks beside Kd: up to 24 % off";
        "illum 4, 6, 7, 9", Approximated,
            "where d or Tf let light through, smooth glass of Ni: up to 61 % off";
        "illum 0, 1 with Ks", Ignored, "materials without highlights have no Ks";
        "map_Kd with black Kd", Approximated, "the map alone is used";
        "d 0", Approximated, "materials that are wholly transparent are not seen";
    }
};

/// Adds the note of the row `name` about a definition as a whole, at the location `at`.
pub(super) fn meaning(name: &str, at: &Location, notes: &mut Notes) {
    if let Some(row) = Feature::find(FEATURES, MEANING, name) {
        // No row of this kind refuses the file, so this cannot fail.
        row.met(at, notes).unwrap_or_default();
    }
}
