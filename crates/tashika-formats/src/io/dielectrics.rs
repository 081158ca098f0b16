//! Refractive indices of transparent materials by their names in scene formats.
//!
//! Indices are for visible light at room temperature. Names without a prefix are Mitsuba's, with
//! the values of its documentation, which authors of scenes rely on: its `bk7` is not the glass of
//! the catalogue. Names with `glass-` are pbrt-v4's, which has whole spectra; these indices are at
//! 587.6 nm (helium's d line).
//!
//! Sources: [^mitsuba3], plugin `dielectric`; [^schott2017]. Held to this by the test below.

/// Names in lower case, with their indices.
const INDICES: [(&str, f32); 30] = [
    ("vacuum", 1.0),
    ("helium", 1.000_04),
    ("hydrogen", 1.000_13),
    ("air", 1.000_28),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.472_9),
    ("benzene", 1.501),
    ("silicone oil", 1.520_45),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.504_6),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
    ("glass-bk7", 1.516_8),
    ("glass-baf10", 1.670_03),
    ("glass-fk51a", 1.486_56),
    ("glass-lasf9", 1.850_25),
    // SF5, SF10 and SF11 of the catalogue.
    ("glass-f5", 1.672_70),
    ("glass-f10", 1.728_25),
    ("glass-f11", 1.784_72),
];

/// Returns the index of `bk7`, `glass-BK7`, `fused quartz` and so on; case is ignored.
pub(super) fn refractive_index(name: &str) -> Option<f32> {
    let name = name.trim().to_ascii_lowercase();
    INDICES.iter().find(|(known, _)| *known == name).map(|(_, index)| *index)
}

/// Range of refractive indices that surfaces accept. An index of 1 would be no boundary; diamond
/// has 2.4.
pub(super) const IOR_RANGE: [f32; 2] = [1.0001, 5.0];

/// Nearest index that a surface accepts.
pub(super) fn rendered(ior: f32) -> f32 {
    ior.clamp(IOR_RANGE[0], IOR_RANGE[1])
}

/// Reflectance of one face of the given index at normal incidence.
pub(super) fn normal_reflectance(ior: f32) -> f32 {
    let amplitude = (ior - 1.0) / (ior + 1.0);
    amplitude * amplitude
}

/// Index of a pane, for formats that define a thin surface by one face of index `ior`. At normal
/// incidence, the two faces of the pane together reflect as much as that face: two faces of
/// reflectance `F` reflect `2F/(1 + F)`.
pub(super) fn single_face(ior: f32) -> f32 {
    let one = normal_reflectance(ior);
    let each = (one / (2.0 - one)).sqrt();
    ((1.0 + each) / (1.0 - each)).max(1.0001)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_as_formats_spell_them() {
        assert_eq!(refractive_index("bk7"), Some(1.5046));
        assert_eq!(refractive_index("glass-BK7"), Some(1.5168));
        assert_eq!(refractive_index(" Water Ice "), Some(1.31));
        for name in ["", "glass-", "glass-water", "unobtainium"] {
            assert_eq!(refractive_index(name), None, "{name:?}");
        }
        assert!(
            INDICES.iter().all(|(name, index)| *name == name.to_lowercase() && (1.0..2.5).contains(index))
        );
    }
}
