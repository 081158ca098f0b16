//! What OBJ and MTL files may say, and what becomes of it.
//!
//! Statements that only make sense together share a row. [`Met`] counts what was met in one file;
//! the notes have the rows' words.
//!
//! Held to this by `suite::obj_features`: every row, in a file of its own, gives the note that it
//! promises and no other.

use std::path::Path;

use crate::error::Location;
use crate::io::features::{Feature, Support};
use crate::scene::Notes;

use Support::{Approximated, Full, Ignored};

const fn row(kind: &'static str, name: &'static str, support: Support, how: &'static str) -> Feature {
    Feature::new(kind, name, support, how)
}

/// Kind of what an OBJ file says.
pub(super) const STATEMENT: &str = "statement";

/// Kind of what an MTL file says.
pub(super) const MATERIAL: &str = "material statement";

/// Kind of what a definition means as a whole.
pub(super) const MEANING: &str = "material";

/// Free-form geometry.
pub(super) const FREE_FORM: &str = "vp, cstype, curv, surf";
/// Attributes of display.
pub(super) const DISPLAY: &str = "lod, bevel, shadow_obj";
/// Images outside materials.
pub(super) const OUTER_MAPS: &str = "maplib, usemap";
/// Other files and programs.
pub(super) const COMMANDS: &str = "call, csh";
/// Vertices with more than a position.
pub(super) const VERTEX_COLORS: &str = "v x y z r g b";
/// Heights.
pub(super) const BUMP: &str = "bump, map_bump, disp";
/// The physically based extension beyond metal and roughness.
pub(super) const SHEEN: &str = "Ps, Pc, aniso, map_RMA";
/// Colours that are not red, green and blue.
pub(super) const SPECTRAL: &str = "Kd spectral, Kd xyz";
/// Options of texture statements that change values.
pub(super) const MODIFIED: &str = "-mm, -t, -bm, -boost, -cc";

/// All rows.
pub(in crate::io) const FEATURES: &[Feature] = &[
    row(STATEMENT, "v", Full, "vertices (m)"),
    row(STATEMENT, "vt", Full, "texture coordinates"),
    row(STATEMENT, "vn", Full, "shading normals"),
    row(STATEMENT, "f", Full, "polygons, cut into triangles; also under its old name fo"),
    row(STATEMENT, "s", Full, "smoothing groups: normals where there are none"),
    row(STATEMENT, "usemtl", Full, "one mesh for each material"),
    row(STATEMENT, "mtllib", Full, "definitions of materials; of a name the first counts"),
    row(STATEMENT, "o", Full, "names a part, and so do g and mg"),
    row(STATEMENT, VERTEX_COLORS, Ignored, "vertex colours are left out"),
    row(STATEMENT, "p", Ignored, "points are left out"),
    row(STATEMENT, "l", Ignored, "line elements are left out"),
    row(STATEMENT, FREE_FORM, Ignored, "free-form curves and surfaces are left out"),
    row(STATEMENT, DISPLAY, Ignored, "display and render attributes are left out"),
    row(STATEMENT, OUTER_MAPS, Ignored, "texture maps outside materials are left out"),
    row(STATEMENT, COMMANDS, Ignored, "other files and commands are left out"),
    row(MATERIAL, "newmtl", Full, "starts a material"),
    row(MATERIAL, "Kd", Full, "diffuse reflectance or base colour, with map_Kd"),
    row(MATERIAL, "Ks", Full, "specular reflectance, with map_Ks"),
    row(MATERIAL, "Ns", Full, "exponent about the mirror direction"),
    row(MATERIAL, "Ke", Full, "radiance of both sides (W·m⁻²·sr⁻¹), with map_Ke"),
    row(
        MATERIAL,
        "Ka",
        Full,
        "without effect, as is map_Ka: light transport takes the place of ambient light",
    ),
    row(MATERIAL, "d", Full, "opacity, with map_d"),
    row(MATERIAL, "Tr", Full, "one minus opacity"),
    row(MATERIAL, "Tf", Full, "transmittance of glass"),
    row(MATERIAL, "Ni", Full, "index of refraction"),
    row(MATERIAL, "illum", Full, "which of the surfaces below; 0 and 1 have no highlight"),
    row(MATERIAL, "Pr", Full, "roughness of metallic-roughness, with map_Pr"),
    row(MATERIAL, "Pm", Full, "metalness of metallic-roughness, with map_Pm"),
    row(MATERIAL, "norm", Full, "normal map, also as map_norm and map_Kn"),
    row(MATERIAL, "map_Kd -o -s -clamp -imfchan", Full, "offset, scale, wrapping and channel of any map"),
    row(MATERIAL, "map_Kd of 16 bits", Full, "16 bits a channel, of any map"),
    row(MATERIAL, "map_Kd .tx", Full, "its largest level: TIFF in tiles or strips, or OpenEXR; of any map"),
    row(MATERIAL, "map_Kd <UDIM>", Full, "an image for each tile: 1001 + u + 10 v, rounded down; of any map"),
    row(MATERIAL, MODIFIED, Ignored, "these options of maps are left out"),
    row(MATERIAL, SPECTRAL, Ignored, "colours of files and of CIE XYZ are left out, the default is used"),
    row(MATERIAL, BUMP, Ignored, "bump and displacement maps are left out"),
    row(MATERIAL, "refl", Ignored, "reflection maps are left out"),
    row(MATERIAL, "decal", Ignored, "decals are left out"),
    row(MATERIAL, "map_Ns", Ignored, "maps of specular exponents are left out"),
    row(MATERIAL, SHEEN, Ignored, "sheen, clear coat, anisotropy and packed maps are left out"),
    row(
        MEANING,
        "illum 3, 5",
        Approximated,
        "where Ks is brighter than Kd, a perfect mirror of Ks beside Kd: up to 24 % off",
    ),
    row(
        MEANING,
        "illum 4, 6, 7, 9",
        Approximated,
        "where d or Tf let light through, smooth glass of Ni: up to 61 % off",
    ),
    row(MEANING, "illum 0, 1 with Ks", Ignored, "materials without highlights have no Ks"),
    row(MEANING, "map_Kd with black Kd", Approximated, "the map alone is used"),
    row(MEANING, "d 0", Approximated, "materials that are wholly transparent are not seen"),
];

/// What was met in one file: rows with their first line and how often.
#[derive(Default)]
pub(super) struct Met(Vec<(&'static Feature, u32, u64)>);

impl Met {
    /// A thing of a row, on `line`.
    pub(super) fn add(&mut self, kind: &str, name: &str, line: u32) {
        match self.0.iter_mut().find(|(row, ..)| (row.kind, row.name) == (kind, name)) {
            Some(entry) => entry.2 += 1,
            None => self.0.extend(Feature::find(FEATURES, kind, name).map(|row| (row, line, 1))),
        }
    }

    /// Hands the counts over.
    pub(super) fn report(self, file: &Path, notes: &mut Notes) {
        for (row, line, count) in self.0 {
            meet(row, &Location::line(file, line), count, notes);
        }
    }
}

/// Says what the table says about the meaning of a definition at `at`.
pub(super) fn meaning(name: &str, at: &Location, notes: &mut Notes) {
    if let Some(row) = Feature::find(FEATURES, MEANING, name) {
        meet(row, at, 1, notes);
    }
}

fn meet(row: &Feature, at: &Location, count: u64, notes: &mut Notes) {
    let mut said = Notes::default();
    // Nothing in the table is refused.
    if row.met(at, &mut said).is_ok() {
        for note in said.iter() {
            notes.push_many(note.kind, note.message, note.first, count);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_met_is_counted_from_its_first_line_and_nothing_is_refused() {
        let mut met = Met::default();
        for line in [4, 9] {
            met.add(STATEMENT, "p", line);
        }
        met.add(STATEMENT, "v", 1);
        let mut notes = Notes::default();
        met.report(Path::new("a.obj"), &mut notes);
        let all: Vec<_> = notes.iter().map(|n| (n.message, n.first.line, n.count)).collect();
        assert_eq!(all, [("statement \"p\": points are left out".to_owned(), Some(4), 2)]);
        assert!(FEATURES.iter().all(|row| row.support != Support::Refused));
    }
}
