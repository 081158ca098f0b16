//! Reflectance of Mitsuba's materials in this renderer, compared with numbers of Mitsuba 3 that
//! `scripts/mitsuba_materials.py` wrote.

use crate::material_rows::{MITSUBA_3, allowed, rows};

#[test]
fn materials_reflect_what_mitsuba_says() {
    let mut wrong = Vec::new();
    for row in rows().iter().filter(|row| row.format == MITSUBA_3) {
        let mut allowed = allowed(row);
        // For rough glass only the sampled albedos are compared; the table has no values.
        if row.text.contains("roughdielectric") || row.text.contains("spec_trans") {
            allowed[1] = f64::INFINITY;
        }
        wrong.extend(row.disagreements(allowed));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
