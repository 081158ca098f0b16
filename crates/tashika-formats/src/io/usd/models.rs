//! Inputs of MaterialX's surface shaders: their names, meanings and default values.
//!
//! Sources: [^materialx2024]. Held to this by `usd_materialx` of the suite.

/// Name of an input, and its default value.
pub(super) type Input = (&'static str, f32);

/// Condition for glass to be a thin pane.
pub(super) enum Pane {
    /// If the input is true.
    Where(&'static str),
    /// If the input is zero. The pane reflects as one face, as in glTF.
    Without(&'static str),
}

/// Inputs of a surface shader, by meaning.
pub(super) struct Model {
    /// Node definition, without the suffixes of other versions.
    pub definition: &'static str,
    /// Name of its row in the table of features.
    pub row: &'static str,
    pub base: Option<Input>,
    pub base_color: Input,
    pub metalness: Input,
    pub specular: &'static str,
    pub roughness: Input,
    pub ior: &'static str,
    pub subsurface: Option<[Input; 2]>,
    pub transmission: &'static str,
    /// Colour of transmitted light; if the model has no such input, it is the base colour.
    pub transmission_color: Option<&'static str>,
    pub transmission_depth: Option<&'static str>,
    pub pane: Pane,
    pub sheen: Option<&'static str>,
    pub sheen_color: Input,
    pub sheen_roughness: Input,
    pub coat: &'static str,
    pub coat_roughness: Input,
    pub emission: Input,
    pub emission_color: Input,
    pub opacity: &'static str,
    /// Inputs for the alpha mode and its cutoff, as in glTF. Without them, the mode is blending.
    pub alpha_mode: Option<[&'static str; 2]>,
    pub normal: &'static str,
    pub left_out: &'static [LeftOut],
}

/// An input that is ignored.
pub(super) struct LeftOut {
    pub input: &'static str,
    /// Default value.
    pub fallback: f64,
    /// Value without an effect.
    pub neutral: f64,
    /// Name of the table's row with the text of the note.
    pub row: &'static str,
    /// Input that this one modifies. If that input is absent or zero, this one has no effect.
    pub of: Option<&'static str>,
}

impl LeftOut {
    /// An input whose default value has no effect.
    const fn new(input: &'static str, neutral: f64, row: &'static str, of: Option<&'static str>) -> Self {
        Self { input, fallback: neutral, neutral, row, of }
    }
}

const COAT: &str = "colour and index of the coat";

const STANDARD_SURFACE: Model = Model {
    definition: "ND_standard_surface_surfaceshader",
    row: "standard_surface",
    base: Some(("base", 1.0)),
    base_color: ("base_color", 0.8),
    metalness: ("metalness", 0.0),
    specular: "specular",
    roughness: ("specular_roughness", 0.2),
    ior: "specular_IOR",
    subsurface: Some([("subsurface", 0.0), ("subsurface_color", 1.0)]),
    transmission: "transmission",
    transmission_color: Some("transmission_color"),
    transmission_depth: Some("transmission_depth"),
    pane: Pane::Where("thin_walled"),
    sheen: Some("sheen"),
    sheen_color: ("sheen_color", 1.0),
    sheen_roughness: ("sheen_roughness", 0.3),
    coat: "coat",
    coat_roughness: ("coat_roughness", 0.1),
    emission: ("emission", 0.0),
    emission_color: ("emission_color", 1.0),
    opacity: "opacity",
    alpha_mode: None,
    normal: "normal",
    left_out: &[
        LeftOut::new("diffuse_roughness", 0.0, "diffuse roughness", None),
        LeftOut::new("specular_anisotropy", 0.0, "anisotropy", None),
        LeftOut::new("coat_anisotropy", 0.0, "anisotropy", Some("coat")),
        LeftOut::new("transmission_scatter", 0.0, "scattering inside", Some("transmission")),
        LeftOut::new("transmission_dispersion", 0.0, "dispersion", Some("transmission")),
        LeftOut::new("transmission_extra_roughness", 0.0, "extra roughness", Some("transmission")),
        LeftOut::new("coat_color", 1.0, COAT, Some("coat")),
        LeftOut::new("coat_IOR", 1.5, COAT, Some("coat")),
        LeftOut::new("coat_normal", 0.0, "normals of the coat", Some("coat")),
        LeftOut::new("thin_film_thickness", 0.0, "thin film", None),
    ],
};

const OPEN_PBR: Model = Model {
    definition: "ND_open_pbr_surface_surfaceshader",
    row: "open_pbr_surface",
    base: Some(("base_weight", 1.0)),
    base_color: ("base_color", 0.8),
    metalness: ("base_metalness", 0.0),
    specular: "specular_weight",
    roughness: ("specular_roughness", 0.3),
    ior: "specular_ior",
    subsurface: Some([("subsurface_weight", 0.0), ("subsurface_color", 0.8)]),
    transmission: "transmission_weight",
    transmission_color: Some("transmission_color"),
    transmission_depth: Some("transmission_depth"),
    pane: Pane::Where("geometry_thin_walled"),
    sheen: Some("fuzz_weight"),
    sheen_color: ("fuzz_color", 1.0),
    sheen_roughness: ("fuzz_roughness", 0.5),
    coat: "coat_weight",
    coat_roughness: ("coat_roughness", 0.0),
    emission: ("emission_luminance", 0.0),
    emission_color: ("emission_color", 1.0),
    opacity: "geometry_opacity",
    alpha_mode: None,
    normal: "geometry_normal",
    left_out: &[
        LeftOut::new("base_diffuse_roughness", 0.0, "diffuse roughness", None),
        LeftOut::new("specular_roughness_anisotropy", 0.0, "anisotropy", None),
        LeftOut::new("coat_roughness_anisotropy", 0.0, "anisotropy", Some("coat_weight")),
        LeftOut::new("transmission_scatter", 0.0, "scattering inside", Some("transmission_weight")),
        LeftOut::new("transmission_dispersion_scale", 0.0, "dispersion", Some("transmission_weight")),
        LeftOut::new("coat_color", 1.0, COAT, Some("coat_weight")),
        LeftOut { fallback: 1.6, ..LeftOut::new("coat_ior", 1.5, COAT, Some("coat_weight")) },
        LeftOut::new("geometry_coat_normal", 0.0, "normals of the coat", Some("coat_weight")),
        LeftOut::new("thin_film_weight", 0.0, "thin film", None),
    ],
};

const GLTF_PBR: Model = Model {
    definition: "ND_gltf_pbr_surfaceshader",
    row: "gltf_pbr",
    base: None,
    base_color: ("base_color", 1.0),
    metalness: ("metallic", 1.0),
    specular: "specular",
    roughness: ("roughness", 1.0),
    ior: "ior",
    subsurface: None,
    transmission: "transmission",
    transmission_color: None,
    transmission_depth: None,
    pane: Pane::Without("thickness"),
    sheen: None,
    sheen_color: ("sheen_color", 0.0),
    sheen_roughness: ("sheen_roughness", 0.0),
    coat: "clearcoat",
    coat_roughness: ("clearcoat_roughness", 0.0),
    emission: ("emissive_strength", 1.0),
    emission_color: ("emissive", 0.0),
    opacity: "alpha",
    alpha_mode: Some(["alpha_mode", "alpha_cutoff"]),
    normal: "normal",
    left_out: &[
        LeftOut::new("anisotropy_strength", 0.0, "anisotropy", None),
        LeftOut::new("attenuation_color", 1.0, "scattering inside", Some("transmission")),
        LeftOut::new("dispersion", 0.0, "dispersion", Some("transmission")),
        LeftOut::new("clearcoat_normal", 0.0, "normals of the coat", Some("clearcoat")),
        LeftOut::new("iridescence", 0.0, "thin film", None),
    ],
};

impl Model {
    /// Model of the shader `id`, if the shader is one of the three surfaces.
    pub fn of(id: &str) -> Option<&'static Self> {
        [&STANDARD_SURFACE, &OPEN_PBR, &GLTF_PBR].into_iter().find(|model| id.starts_with(model.definition))
    }
}
