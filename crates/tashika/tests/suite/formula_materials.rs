//! Reflectance of materials of pbrt, Mitsuba 0.6, glTF and MTL, compared with the formulas of their
//! formats. `scripts/material_formulas.py` computed the expected numbers.

use crate::material_rows::{MITSUBA_3, allowed, rows};

#[test]
fn materials_reflect_what_formulas_say() {
    let rows = rows().iter().filter(|row| row.format != MITSUBA_3);
    let wrong: Vec<_> = rows.filter_map(|row| row.disagreements(allowed(row))).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
