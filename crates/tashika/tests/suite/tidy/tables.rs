//! Permissions: the layers, and the lists of exceptions, each entry with its reason.
//!
//! The layers are also in the documentation of `lib.rs`; a test compares the two. Entries of
//! [`DEPENDENCIES`] and [`HASHED`] that are not needed fail a test.

/// Crates of the library: folder below `crates`, and the module of its root, if that is a single
/// one.
pub(super) const LIBRARY: &[(&str, Option<&str>)] = &[
    ("tashika-math", None),
    ("tashika-stats", Some("stats")),
    ("tashika-film", None),
    ("tashika-scene", None),
    ("tashika-core", None),
    ("tashika-formats", None),
    ("tashika-report", Some("report")),
    ("tashika", None),
];

/// A module of the library and the modules that it may use: all of lower layers, with exceptions.
/// Cargo ensures that crates use only those below them.
pub(super) struct Module {
    pub(super) name: &'static str,
    pub(super) layer: u8,
    /// Modules of its own layer that it may use.
    pub(super) beside: &'static [&'static str],
    /// Modules of lower layers that it may not use.
    pub(super) never: &'static [&'static str],
}

const fn module(
    name: &'static str,
    layer: u8,
    beside: &'static [&'static str],
    never: &'static [&'static str],
) -> Module {
    Module { name, layer, beside, never }
}

/// The layers, as in the documentation of `lib.rs`.
pub(super) const MODULES: &[Module] = &[
    module("math", 0, &[], &[]),
    module("rng", 0, &[], &[]),
    module("warp", 0, &["math"], &[]),
    module("stats", 0, &["math"], &[]),
    module("color", 0, &["math"], &[]),
    module("error", 0, &[], &[]),
    module("bsdf", 1, &[], &[]),
    module("film", 1, &[], &[]),
    module("scene", 2, &[], &[]),
    module("accel", 2, &["scene"], &[]),
    module("media", 2, &["scene", "accel"], &[]),
    module("vpl", 3, &[], &[]),
    module("gather", 3, &[], &[]),
    module("contribution", 3, &["vpl", "gather"], &[]),
    module("bounds", 4, &[], &["scene", "accel", "vpl", "gather", "contribution"]),
    module("guidance", 4, &[], &[]),
    module("tree", 5, &[], &["scene", "accel"]),
    module("cut", 6, &[], &["bsdf", "film"]),
    module("compensation", 6, &[], &[]),
    module("integrator", 7, &[], &[]),
    module("reconstruction", 8, &[], &[]),
    module("render", 8, &[], INNER),
    module("report", 8, &[], &[]),
    module("request", 8, &[], INNER),
    module("picture", 9, &[], INNER),
    module("experiment", 9, &[], &[]),
    module("io", 9, &[], &["bounds", "guidance", "tree", "cut", "compensation", "integrator"]),
    module("renderer", 10, &[], &["bounds", "guidance", "cut", "compensation"]),
    module("glare", 11, &["sensors"], INNER),
    module("sensors", 11, &[], INNER),
];

/// Parts of integrators, which modules above them do not use.
const INNER: &[&str] = &["bounds", "guidance", "tree", "cut", "compensation"];

/// A module whose files are alternatives to each other.
pub(super) struct SideBySide {
    /// The file of the module.
    pub(super) owner: &'static str,
    /// Files that are no alternatives but common code: all may use them.
    pub(super) common: &'static [&'static str],
    /// Files that list the alternatives: they may use all.
    pub(super) lists: &'static [&'static str],
}

/// Modules whose files are alternatives to each other: they share their `mod.rs` and their common
/// files, and nothing else.
pub(super) const SIDE_BY_SIDE: &[SideBySide] = &[
    SideBySide {
        owner: "crates/tashika-core/src/integrator/mod.rs",
        common: &["looks", "options", "path_samples", "path_spread", "published"],
        lists: &["method"],
    },
    // The other files are the readers of scenes.
    SideBySide {
        owner: "crates/tashika-formats/src/io/mod.rs",
        common: &[
            "assets",
            "cameras",
            "checkpoint",
            "dielectrics",
            "epw",
            "eulumdat",
            "exr",
            "features",
            "files",
            "formats",
            "ies",
            "images",
            "light_changes",
            "lights",
            "limits",
            "mesh_files",
            "mixes",
            "nanovdb",
            "notes",
            "output",
            "ply",
            "png",
            "polygon",
            "principled",
            "rough_diffuse",
            "shapes",
            "text",
            "textures",
            "udim",
            "xml",
        ],
        lists: &["formats", "mesh_files"],
    },
];

/// Dependencies that only some modules of their crate may name.
pub(super) const DEPENDENCIES: &[(&str, &str, &[&str])] = &[
    ("tashika-math", "libm", &["math"]),
    ("tashika-math", "rand_core", &["rng"]),
    ("tashika-math", "rand_pcg", &["rng"]),
    ("tashika-film", "png", &["film"]),
    ("tashika-film", "rayon", &["reconstruction"]),
    ("tashika-film", "thiserror", &["error"]),
    ("tashika-core", "rayon", &["accel", "guidance", "vpl", "tree", "compensation", "picture", "render"]),
    ("tashika-core", "smallvec", &["cut"]),
    ("tashika-core", "sobol_burley", &["compensation", "gather"]),
    ("tashika", "serde_json", &["io"]),
];

/// Parts of `std` that the library's code does not use, except in the modules named, and why.
pub(super) const STD: &[(&str, &[&str], &str)] = &[
    ("fs", &["io"], "files are read and written in `io` alone"),
    ("net", &[], "the library talks to no other machine"),
    ("env", &[], "the environment of the process is no input; take an option"),
    ("thread", &[], "parallel work goes through rayon, in the pool of the caller"),
];

/// Words that the library's code does not use, and why.
pub(super) const FORBIDDEN: &[(&[&str], &str)] = &[
    (&["print", "println", "eprint", "eprintln", "dbg"], "the library prints nothing; return it, or note it"),
    (&["Instant", "SystemTime"], "the library reads no clock; results would hang on it"),
];

/// Functions of `f32` and `f64` whose last bits differ between machines. (clippy.toml covers `f32`,
/// tests included.)
pub(super) const ELEMENTARY: &[&str] = &[
    "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "exp2",
    "exp_m1", "ln", "ln_1p", "log", "log2", "log10", "powf", "powi", "cbrt", "hypot",
];

/// Functions of `glam` that call those.
pub(super) const ELEMENTARY_INSIDE: &[&str] = &[
    "from_rotation_x",
    "from_rotation_y",
    "from_rotation_z",
    "from_axis_angle",
    "from_scaled_axis",
    "from_euler",
    "from_angle",
    "to_euler",
    "to_axis_angle",
    "angle_between",
    "rotate_axis",
    "slerp",
];

/// Files that may use hash tables, and why their order never reaches a result.
pub(super) const HASHED: &[(&str, &str)] = &[
    (
        "crates/tashika-formats/src/io/obj/meshes.rs",
        "vertices are only looked up; their numbers follow the file",
    ),
    ("crates/tashika-formats/src/io/obj/mtl.rs", "definitions are only looked up by name"),
    ("crates/tashika-formats/src/io/obj/parse.rs", "names are only looked up; their numbers follow the file"),
    (
        "crates/tashika-formats/src/io/obj/shading_normals.rs",
        "sums are only looked up; their order follows the file",
    ),
];

/// Files that may hold `unsafe` code, and why.
pub(super) const UNSAFE: &[(&str, &str)] = &[
    ("crates/tashika-math/src/math/simd/avx2.rs", "vector instructions"),
    ("crates/tashika-math/src/math/simd/avx512.rs", "vector instructions"),
    ("crates/tashika-math/src/math/simd/level.rs", "the call of what is compiled for an instruction set"),
    ("crates/tashika-math/src/math/simd/neon.rs", "vector instructions"),
    ("crates/tashika-math/src/math/simd/prefetch.rs", "an instruction without a safe function"),
    ("crates/tashika-bench/src/embree.rs", "a C library, loaded at run time"),
    ("crates/tashika-oidn/src/library.rs", "a C library, loaded at run time"),
    ("crates/tashika-oidn/src/lib.rs", "the call that loads it"),
];

/// Folder with the names of planes and of values of the metadata.
pub(super) const SCHEMA_HOME: &str = "crates/tashika-film/src/film/";

/// Strings that look like the name of a plane or of a value of the metadata and mean something
/// else: file, strings, reason.
pub(super) const OTHER_NAMES: &[(&str, &[&str], &str)] = &[
    ("crates/tashika-core/src/request/contradictions.rs", &["max_pairs"], OPTION),
    ("crates/tashika-formats/src/io/mitsuba/known.rs", &["max_depth"], "a parameter of Mitsuba"),
    ("crates/tashika-core/src/integrator/options.rs", &["max_pairs"], OPTION),
    ("crates/tashika-core/src/integrator/path_tracer/mod.rs", &["max_depth"], OPTION),
    ("crates/tashika-core/src/vpl/options.rs", &["max_depth"], OPTION),
    ("crates/tashika-cli/src/sensors/table.rs", &["half_width"], "a column of a table of sensors, in lux"),
    ("crates/tashika-python/src/sensors.rs", &["half_width"], "an array of sensors, in lux"),
];

/// Reason for such a name elsewhere.
const OPTION: &str = "an option, which a film may name by the same word";

/// Largest number of lines of a file, and of one that holds tests only.
pub(super) const MOST_LINES: usize = 700;
pub(super) const MOST_LINES_OF_TESTS: usize = 900;

/// Marks of unfinished work, put together so that this file does not hold them.
pub(super) const UNFINISHED: &[&str] =
    &[concat!("TO", "DO"), concat!("FIX", "ME"), concat!("XX", "X"), concat!("HA", "CK")];
