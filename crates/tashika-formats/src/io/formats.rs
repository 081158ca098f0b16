//! Scene formats: names, readers and tables of features. A new format is a folder with its reader,
//! and a row here.

use std::path::Path;

use super::features::{Feature, FormatFeatures};
use super::{SceneFiles, gltf, mitsuba, obj, pbrt, radiance, usd};
use crate::error::{Error, Location, Result};
use crate::scene::Scene;

/// A format that scenes are read from.
struct Format {
    /// Name of its table of features.
    name: &'static str,
    /// Endings of its files in lower case, each with a description of such files.
    endings: &'static [(&'static str, &'static str)],
    load: fn(&SceneFiles) -> Result<Scene>,
    features: &'static [Feature],
}

const FORMATS: [Format; 6] = [
    Format {
        name: "pbrt",
        endings: &[("pbrt", "pbrt-v3 and pbrt-v4")],
        load: pbrt::load,
        features: pbrt::FEATURES,
    },
    Format {
        name: "Mitsuba",
        endings: &[("xml", "Mitsuba 0.6 and 3")],
        load: mitsuba::load,
        features: mitsuba::FEATURES,
    },
    Format {
        name: "glTF",
        endings: &[("gltf", "glTF 2.0"), ("glb", "glTF 2.0, binary")],
        load: gltf::load,
        features: gltf::FEATURES,
    },
    Format {
        name: "OBJ",
        endings: &[("obj", "Wavefront OBJ + MTL")],
        load: obj::load,
        features: obj::FEATURES,
    },
    Format {
        name: "USD",
        endings: &[
            ("usda", "USD, text"),
            ("usdc", "USD, binary"),
            ("usd", "USD, text or binary"),
            ("usdz", "USD, archive"),
        ],
        load: usd::load,
        features: usd::FEATURES,
    },
    Format {
        name: "Radiance",
        endings: &[("rad", "Radiance scene description")],
        load: radiance::load,
        features: radiance::FEATURES,
    },
];

/// The tables of features of all formats.
pub fn features() -> Vec<FormatFeatures> {
    FORMATS.iter().map(|format| FormatFeatures { format: format.name, rows: format.features }).collect()
}

/// Description of a scene file by the ending of its name, in any case of letters; none if no reader
/// accepts the ending.
pub fn scene_format(path: &Path) -> Option<&'static str> {
    known(path).map(|(_, name)| name)
}

/// Reads a scene with the reader that accepts the ending of the file.
pub(super) fn load(path: &Path, files: &SceneFiles) -> Result<Scene> {
    if let Some((format, _)) = known(path) {
        return (format.load)(files);
    }
    let endings = FORMATS.iter().flat_map(|format| format.endings);
    let known: Vec<String> = endings.map(|(ending, name)| format!(".{ending} ({name})")).collect();
    Err(Error::unsupported(
        Location::file(path),
        format!("the ending {:?}", ending_of(path)),
        format!("scenes are read from {}", known.join(", ")),
    ))
}

fn known(path: &Path) -> Option<(&'static Format, &'static str)> {
    let ending = ending_of(path);
    let named = |format: &'static Format| {
        let (_, name) = format.endings.iter().find(|(known, _)| *known == ending)?;
        Some((format, *name))
    };
    FORMATS.iter().find_map(named)
}

fn ending_of(path: &Path) -> String {
    path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase()
}
