//! The words of MaterialX's surface shaders: which input is what, and what it is where nothing is said.
//!
//! Sources: [^materialx2024]. Held to this by `usd_materialx` of the suite.

/// An input, and what it is where nothing is said.
pub(super) type Input = (&'static str, f32);

/// Which glass is a pane.
pub(super) enum Pane {
    /// Where an input is true.
    Where(&'static str),
    /// Where an input is zero; it reflects as one face, as glTF has it.
    Without(&'static str),
}

/// The words of a surface shader.
pub(super) struct Model {
    /// Its node definition, without what follows in names of other versions.
    pub definition: &'static str,
    /// Its row of the table.
    pub row: &'static str,
    pub base: Option<Input>,
    pub base_color: Input,
    pub metalness: Input,
    pub specular: &'static str,
    pub roughness: Input,
    pub ior: &'static str,
    pub subsurface: Option<[Input; 2]>,
    pub transmission: &'static str,
    /// None: that of the base.
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
    /// Inputs that say what opacity does, as in glTF, and where a hole begins; none: it stops light.
    pub alpha_mode: Option<[&'static str; 2]>,
    pub normal: &'static str,
    pub left_out: &'static [LeftOut],
}

/// An input that nothing is made of.
pub(super) struct LeftOut {
    pub input: &'static str,
    /// What it is where nothing is said.
    pub fallback: f64,
    /// What it may be without a difference.
    pub neutral: f64,
    /// The row that says so.
    pub row: &'static str,
    /// The input without which it means nothing.
    pub of: Option<&'static str>,
}

impl LeftOut {
    /// One that is neutral where nothing is said.
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
    /// The surface shader of that name, if it is one of these.
    pub fn of(id: &str) -> Option<&'static Self> {
        [&STANDARD_SURFACE, &OPEN_PBR, &GLTF_PBR].into_iter().find(|model| id.starts_with(model.definition))
    }
}
