//! Every material that a loader accepts has a row in a table of reflectances. The error that a note
//! states covers the errors of its rows.
//!
//! The list of materials is that of the features tables: a material that is added there without a
//! row fails here.

use tashika::io::{Feature, Support, features};

use crate::material_rows::{Row, rows, told};

/// Materials without rows: those of which no comparable part is read, and rows that do not describe
/// the reflectance of a surface.
const NOT_COMPARED: &[(&str, &str)] = &[
    // Fibres and cloth become their colour; measured data are not read.
    ("pbrt", "hair"),
    ("pbrt", "fourier"),
    ("pbrt", "measured"),
    ("Mitsuba", "hair"),
    ("Mitsuba", "hk"),
    ("Mitsuba", "irawan"),
    ("Mitsuba", "measured"),
    ("Mitsuba", "measured_polarized"),
    // Media below a surface.
    ("pbrt", "disney scatterdistance"),
    ("Mitsuba", "coating sigma_a"),
    // No surface.
    ("pbrt", ""),
    ("pbrt", "none"),
    ("pbrt", "interface"),
    ("Mitsuba", "null"),
    // Normals and emission, which have tests of their own.
    ("glTF", "normalTexture"),
    ("glTF", "emissiveTexture"),
    ("glTF", "doubleSided"),
    ("glTF", "KHR_materials_emissive_strength"),
    // A selection of a material.
    ("USD", "material:binding"),
    // The surfaces of glTF, which have rows; `usd_materials` tests the conversion of each input.
    ("USD", "UsdPreviewSurface"),
    // Shown without lighting.
    ("glTF", "KHR_materials_unlit"),
    // Inputs by texture, or by distances that are unknown at a surface.
    ("glTF", "baseColorTexture"),
    ("glTF", "attenuationDistance"),
    ("OBJ", "newmtl"),
    ("OBJ", "Ke"),
    ("OBJ", "Ka"),
    ("OBJ", "norm"),
    ("OBJ", "map_Kd -o -s -clamp -imfchan"),
    ("OBJ", "map_Kd with black Kd"),
    ("OBJ", "d 0"),
    // By texture.
    ("OBJ", "map_Kd of 16 bits"),
    ("OBJ", "map_Kd .tx"),
    ("OBJ", "map_Kd <UDIM>"),
    ("Mitsuba", "principled spec_trans"),
    ("Mitsuba", "principled anisotropic"),
    ("glTF", "specularFactor"),
    ("glTF", "anisotropyTexture"),
    // Anisotropic facets without a formula here, and distributions that only old versions had.
    ("Mitsuba", "anisotropic roughness"),
    ("Mitsuba", "distribution as"),
    ("Mitsuba", "distribution phong"),
    // Lobes and panes, which `io::radiance` compares with Radiance's formulas; lights.
    ("Radiance", "plastic"),
    ("Radiance", "metal"),
    ("Radiance", "trans"),
    ("Radiance", "plastic2"),
    ("Radiance", "metal2"),
    ("Radiance", "trans2"),
    ("Radiance", "dielectric"),
    ("Radiance", "interface"),
    ("Radiance", "glass"),
    ("Radiance", "mirror"),
    ("Radiance", "light"),
    ("Radiance", "glow"),
    ("Radiance", "glow maxrad below 0"),
    ("Radiance", "spotlight"),
    ("Radiance", "spotlight focal length"),
    ("Radiance", "illum"),
    ("Radiance", "light of a luminaire"),
];

/// Returns true if a row of a features table describes the material of a surface.
fn is_material(feature: &Feature) -> bool {
    let accepted = matches!(feature.support, Support::Full | Support::Approximated);
    let of_material = ["material", "material statement"].contains(&feature.kind)
        || feature.name.starts_with("KHR_materials_")
        || feature.kind.starts_with("KHR_materials_");
    accepted && of_material
}

fn message(feature: &Feature) -> String {
    format!("{} {:?}: {}", feature.kind, feature.name, feature.how)
}

/// Returns true if a row of the reflectance tables has the material of a feature, identified by its
/// note or by its name.
fn has(row: &Row, format: &str, feature: &Feature) -> bool {
    if feature.support != Support::Full {
        return row.notes.contains(&message(feature));
    }
    let name = feature.name;
    row.format.starts_with(match format {
        "OBJ" => "MTL",
        other => other,
    }) && match format {
        "Mitsuba" => row.text.contains(&format!("type=\"{name}\"")),
        "OBJ" => row.text.split("; ").any(|statement| statement.split(' ').next() == Some(name)),
        _ => row.text.contains(&format!("\"{name}\"")),
    }
}

#[test]
fn every_material_that_is_read_has_a_row() {
    let mut missing = Vec::new();
    let mut unused: Vec<_> = NOT_COMPARED.to_vec();
    for format in features() {
        for feature in format.rows.iter().filter(|feature| is_material(feature)) {
            let exception = (format.format, feature.name);
            let rows = rows().iter().filter(|row| has(row, format.format, feature)).count();
            if NOT_COMPARED.contains(&exception) {
                unused.retain(|known| *known != exception);
                assert_eq!(rows, 0, "{exception:?} can be compared");
            } else if rows == 0 {
                missing.push(exception);
            }
        }
    }
    assert!(missing.is_empty(), "without a row: {missing:?}");
    assert!(unused.is_empty(), "exceptions that are no materials: {unused:?}");
}

/// The percentage in a note is the smallest whole number that covers its rows.
#[test]
fn notes_say_how_far_materials_are_off() {
    let mut wrong = Vec::new();
    for format in features() {
        for feature in format.rows.iter().filter(|feature| is_material(feature)) {
            if feature.support == Support::Full || NOT_COMPARED.contains(&(format.format, feature.name)) {
                continue;
            }
            let said = told(feature.how).unwrap_or(0.01);
            // Rows that also have a note with a larger error are tested with that note.
            let most = |row: &&Row| row.notes.iter().filter_map(|note| told(note)).all(|t| t <= said);
            let rows = rows().iter().filter(|row| has(row, format.format, feature)).filter(most);
            let worst = rows.map(|row| row.off[0]).fold(0.0, f64::max);
            if worst > said || worst < said - 0.02 {
                wrong.push(format!("{worst:.3} {} {}", format.format, message(feature)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
