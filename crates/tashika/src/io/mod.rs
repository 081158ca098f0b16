//! Files in and out: the only place that touches the file system.
//!
//! Whatever a file claims is checked before it is believed: sizes against the bytes that are there,
//! indices against what they index, references against the scene's own folder.

mod assets;
mod checkpoint;
mod clear_coats;
mod dielectrics;
mod exr;
mod features;
mod files;
mod gltf;
mod ies;
mod images;
mod light_changes;
mod mitsuba;
mod obj;
mod output;
mod pbrt;
mod ply;
mod png;
mod rough_diffuse;
mod shapes;
mod vpl_set;

use std::path::Path;

pub use self::png::{Exposure, ToneMap, encode_png, write_png};
pub use checkpoint::{Checkpoint, Resumed};
pub use exr::{ExrFile, ExrPlane, read_exr, write_exr};
pub use features::{Feature, FormatFeatures, Support, features};
pub use files::SceneFiles;
pub use light_changes::{AskedEnvironment, AskedLight, LightChanges};
pub use output::{check_writable, write_file};
pub use vpl_set::{load_vpls, save_vpls};

use crate::error::{Error, Location, Result};
use crate::scene::{NoteKind, Scene};

/// What a loader may do on the user's behalf.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Whether files outside the folder of the scene file may be read. Default: no.
    pub allow_outside: bool,
    /// Whether a scene may name files that are not there: notes tell of them then. Default: no.
    pub allow_missing: bool,
    /// Largest image that is decoded (texels). Default: 2²⁸.
    pub max_image_texels: u64,
    /// Largest file that is read (bytes). Default: 2³⁴.
    pub max_file_bytes: u64,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            allow_outside: false,
            allow_missing: false,
            max_image_texels: 1 << 28,
            max_file_bytes: 1 << 34,
        }
    }
}

/// Scene formats by file name ending.
pub const SCENE_FORMATS: &[(&str, &str)] = &[
    ("gltf", "glTF 2.0"),
    ("glb", "glTF 2.0, binary"),
    ("obj", "Wavefront OBJ + MTL"),
    ("pbrt", "pbrt-v3 and pbrt-v4"),
    ("xml", "Mitsuba 0.6 and 3"),
];

/// Reads a scene; the format is chosen by the file's ending, in either case of letters.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, [`Error::Unsupported`] for other endings, [`Error::Missing`] with
/// all files that it names and that are not there, unless [`LoadOptions::allow_missing`] is set,
/// and whatever the format's loader refuses.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let files = SceneFiles::open(path, options)?;
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let scene = match ending.as_str() {
        "gltf" | "glb" => gltf::load(&files),
        "obj" => obj::load(&files),
        "pbrt" => pbrt::load(&files),
        "xml" => mitsuba::load(&files),
        _ => {
            let known: Vec<String> = SCENE_FORMATS.iter().map(|(e, name)| format!(".{e} ({name})")).collect();
            Err(Error::unsupported(
                Location::file(path),
                format!("the ending {ending:?}"),
                format!("scenes are read from {}", known.join(", ")),
            ))
        }
    };
    let scene = scene?;
    let missing = scene.notes().iter().filter(|note| note.kind == NoteKind::Missing);
    let missing: Vec<String> = missing.map(|note| format!("{}: {}", note.first, note.message)).collect();
    if !missing.is_empty() && !options.allow_missing {
        return Err(Error::Missing { scene: path.to_owned(), files: missing });
    }
    Ok(scene.with_digest(files.digest()))
}
