//! What is allowed: the layers, and the lists of exceptions, each entry with its reason.
//!
//! The layers are also in the documentation of `lib.rs`; a test compares the two. Entries of
//! [`DEPENDENCIES`] and [`HASHED`] that are no longer needed fail a test.

/// A module of the library and what it may use.
pub(super) struct Module {
    pub(super) name: &'static str,
    pub(super) layer: u8,
    /// Layers of which it may use every module.
    pub(super) layers: &'static [u8],
    /// Modules of its own layer that it may use.
    pub(super) beside: &'static [&'static str],
}

const fn module(
    name: &'static str,
    layer: u8,
    layers: &'static [u8],
    beside: &'static [&'static str],
) -> Module {
    Module { name, layer, layers, beside }
}

/// The layers, as in the documentation of `lib.rs`. Their numbers leave room for what is planned.
pub(super) const MODULES: &[Module] = &[
    module("math", 0, &[], &[]),
    module("color", 0, &[], &["math"]),
    module("rng", 0, &[], &[]),
    module("warp", 0, &[], &["math"]),
    module("stats", 0, &[], &["math"]),
    module("error", 0, &[], &[]),
    module("bsdf", 1, &[0], &[]),
    module("film", 1, &[0], &[]),
    module("scene", 2, &[0, 1], &[]),
    module("accel", 2, &[0, 1], &["scene"]),
    module("vpl", 3, &[0, 1, 2], &[]),
    module("gather", 3, &[0, 1, 2], &[]),
    module("contribution", 3, &[0, 1, 2], &["vpl", "gather"]),
    module("bounds", 4, &[0, 1], &[]),
    module("guidance", 4, &[0, 1, 2, 3], &[]),
    module("tree", 5, &[0, 1, 3, 4], &[]),
    module("cut", 6, &[0, 2, 3, 4, 5], &[]),
    module("compensation", 6, &[0, 1, 2, 3, 4, 5], &[]),
    module("integrator", 7, &[0, 1, 2, 3, 4, 5, 6], &[]),
    module("reconstruction", 8, &[0, 1], &[]),
    module("render", 8, &[0, 1, 2, 3, 7], &[]),
    module("report", 8, &[0, 1], &["reconstruction"]),
    module("request", 8, &[0, 1, 2, 3, 7], &["reconstruction"]),
    module("experiment", 9, &[0, 1, 2, 3, 4, 5, 6, 7, 8], &[]),
    module("io", 9, &[0, 1, 2, 3, 8], &[]),
    module("renderer", 10, &[0, 1, 2, 3, 5, 7, 8, 9], &[]),
];

/// A module whose files are alternatives to each other.
pub(super) struct SideBySide {
    pub(super) module: &'static str,
    /// Files that are no alternative but what several of them have in common: all may use them.
    pub(super) common: &'static [&'static str],
    /// Files that list the alternatives: they may use all.
    pub(super) lists: &'static [&'static str],
}

/// Modules whose files are alternatives to each other: they share what their `mod.rs` and their
/// common files offer, and no more.
pub(super) const SIDE_BY_SIDE: &[SideBySide] = &[
    SideBySide { module: "integrator", common: &["options", "published"], lists: &["method"] },
    // What is left are the readers of scenes.
    SideBySide {
        module: "io",
        common: &[
            "assets",
            "checkpoint",
            "dielectrics",
            "exr",
            "features",
            "files",
            "formats",
            "ies",
            "images",
            "kept_tiles",
            "light_changes",
            "lights",
            "limits",
            "mesh_files",
            "mixes",
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
            "vpl_set",
        ],
        lists: &["formats", "mesh_files"],
    },
];

/// Which modules may name a dependency of the library; none: all of them.
pub(super) const DEPENDENCIES: &[(&str, &[&str])] = &[
    ("base64", &["report"]),
    ("earcut", &["io"]),
    ("embedded_graphics", &["report"]),
    ("exr", &["io"]),
    ("flate2", &["io", "report"]),
    ("glam", &[]),
    ("gltf", &["io"]),
    ("image", &["io"]),
    ("libm", &["math"]),
    ("minijinja", &["report"]),
    ("plotters", &["report"]),
    ("png", &["report"]),
    ("rand_core", &["rng"]),
    ("rand_pcg", &["rng"]),
    ("rayon", &["accel", "guidance", "vpl", "tree", "compensation", "reconstruction", "render"]),
    ("roxmltree", &["io"]),
    ("serde", &[]),
    ("serde_json", &["io", "report"]),
    ("smallvec", &["cut", "io"]),
    ("sobol_burley", &["gather"]),
    ("thiserror", &["error"]),
    ("tiff", &["io"]),
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
    ("io/obj/meshes.rs", "vertices are only looked up; their numbers follow the file"),
    ("io/obj/mtl.rs", "definitions are only looked up by name"),
    ("io/obj/parse.rs", "names are only looked up; their numbers follow the file"),
    ("io/obj/shading_normals.rs", "sums are only looked up; their order follows the file"),
];

/// Files that may hold `unsafe` code, and why.
pub(super) const UNSAFE: &[(&str, &str)] = &[
    ("crates/tashika/src/math/simd/avx2.rs", "vector instructions"),
    ("crates/tashika/src/math/simd/avx512.rs", "vector instructions"),
    ("crates/tashika/src/math/simd/level.rs", "the call of what is compiled for an instruction set"),
    ("crates/tashika/src/math/simd/neon.rs", "vector instructions"),
    ("crates/tashika-bench/src/embree.rs", "a C library, loaded at run time"),
];

/// Where the names of planes and of values of the metadata are written.
pub(super) const SCHEMA_HOME: &str = "crates/tashika/src/film/";

/// Strings that look like the name of a plane or of a value of the metadata and mean something else:
/// file, strings, reason.
pub(super) const OTHER_NAMES: &[(&str, &[&str], &str)] = &[
    ("crates/tashika/src/request/mod.rs", &["max_pairs"], OPTION),
    ("crates/tashika/src/integrator/options.rs", &["max_pairs"], OPTION),
    ("crates/tashika/src/integrator/path_tracer.rs", &["max_depth"], OPTION),
    ("crates/tashika/src/vpl/trace.rs", &["max_depth"], OPTION),
];

/// Why such a name stands elsewhere.
const OPTION: &str = "an option, which a film may name by the same word";

/// Most lines of a file, and of one that holds tests only.
pub(super) const MOST_LINES: usize = 700;
pub(super) const MOST_LINES_OF_TESTS: usize = 900;

/// What marks unfinished work; put together so that this file does not hold them.
pub(super) const UNFINISHED: &[&str] =
    &[concat!("TO", "DO"), concat!("FIX", "ME"), concat!("XX", "X"), concat!("HA", "CK")];
