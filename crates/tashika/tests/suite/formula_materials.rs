//! What materials of pbrt-v4, glTF and MTL reflect here, against the formulas of their formats:
//! numbers that `crates/tashika-bench/material_formulas.py` wrote.

use tashika::scene::Scene;

use crate::gltf::Document;
use crate::mitsuba_materials::disagreements;
use crate::{obj, pbrt};

/// How far albedos and values may be off.
const ALLOWED: [f64; 2] = [0.01; 2];

fn load(format: &str, text: &str) -> Scene {
    match format {
        "pbrt-v4" => pbrt::scene(&format!("WorldBegin Material {text} {}", pbrt::TRIANGLE)),
        "glTF" => {
            let mut d = Document::triangle();
            d.json["materials"][0] = serde_json::from_str(text).unwrap();
            d.load().unwrap()
        }
        "MTL" => obj::load_material(&text.replace("; ", "\n"), &[]),
        _ => panic!("{format}"),
    }
}

#[test]
fn materials_reflect_what_formulas_say() {
    let mut wrong = Vec::new();
    for row in include_str!("formula_materials.txt").lines().filter(|row| !row.starts_with('#')) {
        let [format, text, numbers] = row.split(" | ").collect::<Vec<_>>()[..] else { panic!("{row}") };
        wrong.extend(disagreements(row, numbers, &load(format, text), ALLOWED));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
