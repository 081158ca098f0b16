//! Reading and writing of files. No other module accesses the file system.
//!
//! Claims of a file are checked before use: sizes against the bytes present, indices against the
//! length of their list, references against the scene's own folder.

mod assets;
mod cameras;
mod checkpoint;
mod dielectrics;
mod epw;
mod eulumdat;
mod exr;
mod features;
mod files;
mod formats;
mod gltf;
mod ies;
mod images;
mod light_changes;
mod lights;
mod limits;
mod mesh_files;
mod mitsuba;
mod mixes;
mod nanovdb;
mod notes;
mod obj;
mod output;
mod pbrt;
mod ply;
mod png;
mod polygon;
mod principled;
mod radiance;
mod rough_diffuse;
mod sensor_points;
mod shapes;
mod text;
mod textures;
mod udim;
mod usd;
mod xml;

use std::path::Path;

pub use self::png::{encode_png, write_png};
pub use checkpoint::{Checkpoint, Resumed};
pub use exr::{ExrCompression, ExrFile, ExrLayout, ExrPlane, read_exr, write_exr, write_exr_as};
pub use features::{Feature, FormatFeatures, Support};
pub use files::SceneFiles;
pub use formats::{features, scene_format};
pub use light_changes::{AskedEnvironment, AskedLight, LightChanges};
pub use output::{check_writable, write_file};
pub use sensor_points::{decode_sensor_points, load_sensor_points};

pub use crate::film::{Exposure, Tone, ToneMap};

use crate::error::{Error, Location, Result};
use crate::scene::{NoteKind, Scene, builtin};

/// Permissions, limits and times for loading a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadOptions {
    /// True if files outside the folder of the scene file may be read. Default: no.
    pub allow_outside: bool,
    /// True if a scene may name files that do not exist; notes list them. Default: no.
    pub allow_missing: bool,
    /// Largest image that is decoded (texels). Default: 2²⁸.
    pub max_image_texels: u64,
    /// Largest file that is read (bytes). Default: 2³⁴.
    pub max_file_bytes: u64,
    /// Time at which a scene that moves is loaded (s): any finite number. Times before or after the
    /// motion show its beginning or end. Default: none. Animations then have no effect: the scene
    /// is as at its first keys (pbrt, Mitsuba), or as its nodes are at rest (glTF).
    pub at: Option<f64>,
    /// Times (s) at which the shutter of cameras opens and closes, relative to [`Self::at`], or to
    /// zero if that is not set. Both are finite, and the first is not above the second. Cameras and
    /// objects that move while the shutter is open are blurred; lights without a surface stay at
    /// their position in the middle of this time. Default: none. Then nothing is blurred if
    /// [`Self::at`] is set, and otherwise the shutter is that of the file (pbrt, Mitsuba).
    pub shutter: Option<[f64; 2]>,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            allow_outside: false,
            allow_missing: false,
            max_image_texels: 1 << 28,
            max_file_bytes: 1 << 34,
            at: None,
            shutter: None,
        }
    }
}

impl LoadOptions {
    /// Checks the ranges of the options.
    ///
    /// # Errors
    /// Names the option that is out of range, and the range.
    pub fn validate(&self) -> Result<()> {
        if let Some(at) = self.at.filter(|at| !at.is_finite()) {
            return Err(Error::option("at", at, "a finite number of seconds"));
        }
        match self.shutter {
            Some([open, close]) if !(open <= close && open.is_finite() && close.is_finite()) => {
                let expected = "two finite numbers of seconds, the first not above the second";
                Err(Error::option("shutter", format!("{open},{close}"), expected))
            }
            _ => Ok(()),
        }
    }

    /// Time at which objects are loaded (s), if one is set: the middle of the shutter's time, or
    /// else `at`.
    fn time(&self) -> Option<f64> {
        match self.shutter {
            Some([open, close]) => Some(self.at.unwrap_or(0.0) + open + 0.5 * (close - open)),
            None => self.at,
        }
    }

    /// Times at which a camera's shutter opens and closes (s). `own` are the times in the camera's
    /// file. Returns none if nothing is blurred; the camera then stands as at [`Self::time`].
    fn exposure(&self, own: Option<[f64; 2]>) -> Option<[f64; 2]> {
        match (self.shutter, self.at) {
            (Some(shutter), at) => Some(shutter.map(|seconds| at.unwrap_or(0.0) + seconds)),
            (None, Some(_)) => None,
            (None, None) => own.filter(|[open, close]| open < close),
        }
    }
}

/// Opens the scene that a user names (`builtin:room`, `builtin:tiny` or a file) and applies the
/// changes of `lights`. A scene without lights gets the light of [`Scene::with_default_light`].
///
/// # Errors
/// As [`load_scene`] and [`LightChanges::apply`]; [`Error::Invalid`] for a file without surfaces,
/// unless it moves and a time is requested; [`Error::Option`] for another built-in scene.
pub fn open_scene(name: &Path, lights: &LightChanges, options: &LoadOptions) -> Result<Scene> {
    let scene = match name.to_str().and_then(|name| name.strip_prefix(builtin::PREFIX)) {
        Some(name) => builtin::by_name(name)?(),
        None => {
            let scene = load_scene(name, options)?;
            // At the given time, a scene that moves may have no surface. The picture is then the
            // background.
            let is_moment = options.time().is_some() && scene.animated_seconds().is_some();
            if scene.instances().is_empty() && !is_moment {
                let found = "nothing to render: no surface that this program reads";
                return Err(Error::invalid(Location::file(name), found, "a scene with a shape"));
            }
            scene
        }
    };
    Ok(lights.apply(scene, options)?.with_default_light(Location::file(name)))
}

/// Reads a scene; the format is chosen by the file's ending, in any case of letters.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, [`Error::Unsupported`] for other endings,
/// [`Error::Missing`] with all files that the scene names and that do not exist, unless
/// [`LoadOptions::allow_missing`] is set, [`Error::Option`] for options out of range, and the
/// errors of the format's loader.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Scene> {
    options.validate()?;
    let files = SceneFiles::open(path, options)?;
    let scene = formats::load(path, &files)?;
    let missing = scene.notes().iter().filter(|note| note.kind == NoteKind::Missing);
    let missing: Vec<String> = missing.map(|note| format!("{}: {}", note.first, note.message)).collect();
    if !missing.is_empty() && !options.allow_missing {
        return Err(Error::Missing { scene: path.to_owned(), files: missing });
    }
    Ok(match options.time().filter(|_| scene.animated_seconds().is_some()) {
        None => scene.with_digest(files.digest()),
        Some(time) => {
            let [open, close] = options.exposure(None).unwrap_or([time; 2]);
            let times = [time, open, close].map(f64::to_bits).map(u64::to_le_bytes).concat();
            let digest = files.digest().rotate_left(1).wrapping_add(files::digest(&times));
            scene.with_digest(digest).with_time(time)
        }
    })
}
