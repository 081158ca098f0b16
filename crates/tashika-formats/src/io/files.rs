//! Files of a scene: the scene file itself and the files that it refers to.
//!
//! Input: the scene file as the user names it, and references as the file spells them (relative,
//! with `/` or `\`, in any case of letters). Output: paths and bytes.
//!
//! # Guarantee
//! * Unless [`LoadOptions::allow_outside`] is set, no byte is read from outside the folder of the
//!   scene file, whatever a reference says: absolute paths and paths that climb out are refused by
//!   their spelling, symbolic links by their targets.
//! * No more than [`LoadOptions::max_file_bytes`] are read from a file, and only regular files are
//!   opened.
//! * With the same files in the folder, a reference always gives the same path: among names that
//!   differ only in case, the exact one is taken, otherwise the first in byte order.
//!
//! # Assumption
//! No file is replaced by a link between the check and the reading.
//!
//! # Held to this by
//! The tests below; `damaged_gltf::references_out_of_the_folder_are_refused`.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::LoadOptions;
use crate::error::{Error, Location, Result};

/// A scene file, its folder, and the options of the loader.
#[derive(Clone, Debug)]
pub struct SceneFiles {
    path: PathBuf,
    /// Canonical path of the folder, so that other canonical paths can be compared with it.
    folder: PathBuf,
    options: LoadOptions,
    /// Digest of all bytes read so far; shared by clones.
    digest: Arc<AtomicU64>,
    /// Bytes read so far; shared by clones.
    bytes: Arc<AtomicU64>,
}

/// Instances of meshes permitted in a scene of any size; chosen.
const FREE_INSTANCES: u64 = 1 << 21;

/// Further instances for each byte of the scene's files; chosen.
const INSTANCES_PER_BYTE: u64 = 8;

impl SceneFiles {
    /// Checks that the scene file exists and is a regular file.
    ///
    /// # Errors
    /// [`Error::Io`] if it does not exist, [`Error::Invalid`] if it is a folder or a device.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self> {
        let metadata = fs::metadata(path).map_err(|e| Error::io(path, e))?;
        require_regular(&metadata, &Location::file(path))?;
        let folder = match path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let folder = folder.canonicalize().map_err(|e| Error::io(folder, e))?;
        let (path, options) = (path.to_owned(), options.clone());
        Ok(Self { path, folder, options, digest: Arc::default(), bytes: Arc::default() })
    }

    /// The scene file as the user named it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Name of the scene: the file's name without its ending.
    pub fn name(&self) -> String {
        self.path.file_stem().map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned())
    }

    /// Options with which the scene is loaded.
    pub fn options(&self) -> &LoadOptions {
        &self.options
    }

    /// Digest of all files read so far, independent of their order. It detects accidental changes
    /// of the contents, not deliberate ones.
    pub fn digest(&self) -> u64 {
        self.digest.load(Ordering::Relaxed)
    }

    /// Returns the number of instances that the bytes read so far permit.
    pub(super) fn most_instances(&self) -> usize {
        let bytes = self.bytes.load(Ordering::Relaxed);
        usize::try_from(bytes.saturating_mul(INSTANCES_PER_BYTE) + FREE_INSTANCES).unwrap_or(usize::MAX)
    }

    /// Path of the file `reference` in messages: relative to the folder of the scene as the user
    /// named it.
    pub(super) fn beside(&self, reference: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(reference)
    }

    /// The bytes of the scene file.
    ///
    /// # Errors
    /// [`Error::Io`], or [`Error::Invalid`] if it is larger than permitted.
    pub fn read_scene(&self) -> Result<Vec<u8>> {
        self.read_limited(&self.path, &Location::file(&self.path)).map_err(|e| match e {
            ReadError::Io(source) => Error::io(&self.path, source),
            ReadError::Refused(error) => error,
        })
    }

    /// Returns the canonical path of the file that `reference`, which stands at `at`, refers to.
    ///
    /// References are relative to the folder of the scene file. If no file has the exact name, one
    /// whose name differs only in case is taken.
    ///
    /// # Errors
    /// [`Error::Outside`] if the reference leads out of the folder and that is not permitted,
    /// [`Error::Invalid`] if it is no name, [`Error::Io`] if there is no such file.
    pub fn resolve(&self, reference: &str, at: &Location) -> Result<PathBuf> {
        let refuse =
            |expected: &str| Error::invalid(at.clone(), format!("reference {reference:?}"), expected);
        let outside = || Error::Outside { at: at.clone(), reference: reference.to_owned() };
        if reference.is_empty() || reference.contains('\0') {
            return Err(refuse("the name of a file"));
        }
        let unified = reference.replace('\\', "/");
        let has_drive = matches!(unified.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic());
        let path = if unified.starts_with('/') || has_drive {
            if !self.options.allow_outside {
                return Err(outside());
            }
            PathBuf::from(&unified)
        } else {
            // Depth below the folder; a path that is above the folder at any step is refused.
            let mut depth = 0_i64;
            let mut path = self.folder.clone();
            for step in unified.split('/').filter(|s| !s.is_empty() && *s != ".") {
                depth += if step == ".." { -1 } else { 1 };
                if depth < 0 && !self.options.allow_outside {
                    return Err(outside());
                }
                path = if step == ".." { path.join(step) } else { in_any_case(&path, step) };
            }
            path
        };
        let canonical = path.canonicalize().map_err(|e| named_by(&path, e, at))?;
        if !self.options.allow_outside && !canonical.starts_with(&self.folder) {
            return Err(outside());
        }
        Ok(canonical)
    }

    /// The bytes of the file that `reference`, which stands at `at`, refers to.
    ///
    /// # Errors
    /// As [`Self::resolve`]; [`Error::Invalid`] if it is no file or larger than permitted.
    pub fn read(&self, reference: &str, at: &Location) -> Result<Vec<u8>> {
        let path = self.resolve(reference, at)?;
        self.read_limited(&path, at).map_err(|e| match e {
            ReadError::Io(source) => named_by(&path, source, at),
            ReadError::Refused(error) => error,
        })
    }

    fn read_limited(&self, path: &Path, at: &Location) -> Result<Vec<u8>, ReadError> {
        // Checked before opening: opening a pipe would wait for a writer.
        let metadata = fs::metadata(path).map_err(ReadError::Io)?;
        require_regular(&metadata, at).map_err(ReadError::Refused)?;
        let limit = self.options.max_file_bytes;
        let too_large = |bytes: u64| {
            let found = format!("{} of {bytes} bytes", path.display());
            ReadError::Refused(Error::invalid(at.clone(), found, format!("a file of at most {limit} bytes")))
        };
        if metadata.len() > limit {
            return Err(too_large(metadata.len()));
        }
        let mut bytes = Vec::new();
        let expected = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
        bytes.try_reserve_exact(expected).map_err(|_| ReadError::Io(io::ErrorKind::OutOfMemory.into()))?;
        let file = File::open(path).map_err(ReadError::Io)?;
        // The length in the metadata was checked above, but some files contain more.
        file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(ReadError::Io)?;
        if bytes.len() as u64 > limit {
            return Err(too_large(bytes.len() as u64));
        }
        self.digest.fetch_add(digest(&bytes), Ordering::Relaxed);
        self.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        Ok(bytes)
    }
}

/// Folder part of a reference: empty, or ending in a separator.
pub(super) fn folder_of(reference: &str) -> &str {
    reference.rfind(['/', '\\']).map_or("", |separator| &reference[..=separator])
}

/// Returns true if a reference begins at the root, or at a drive.
pub(super) fn is_absolute(reference: &str) -> bool {
    reference.starts_with(['/', '\\']) || reference.as_bytes().get(1) == Some(&b':')
}

/// CRC-32 and length of a file, mixed by the finalizer of SplitMix64. Sums of these values over all
/// files therefore differ if one of the files differs, except by chance.
pub(super) fn digest(bytes: &[u8]) -> u64 {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    let mut z = (bytes.len() as u64) << 32 ^ u64::from(crc.sum());
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

enum ReadError {
    Io(io::Error),
    Refused(Error),
}

/// The system's error for `path`, with the place that names the file.
fn named_by(path: &Path, source: io::Error, at: &Location) -> Error {
    Error::io(path, io::Error::new(source.kind(), format!("{source} (named by {at})")))
}

fn require_regular(metadata: &fs::Metadata, at: &Location) -> Result<()> {
    if metadata.is_file() {
        return Ok(());
    }
    let found = if metadata.is_dir() { "a folder" } else { "a device or pipe" };
    Err(Error::invalid(at.clone(), found, "a file"))
}

/// `folder/name`, or the path of a name that differs only in case.
fn in_any_case(folder: &Path, name: &str) -> PathBuf {
    let exact = folder.join(name);
    if exact.symlink_metadata().is_ok() {
        return exact;
    }
    let wanted = name.to_lowercase();
    let names = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name());
    let similar = names.filter(|n| n.to_str().is_some_and(|n| n.to_lowercase() == wanted)).min();
    similar.map_or(exact, |n| folder.join(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates `scene/s.gltf`, `scene/Textures/Wood.png`, and `secret.txt` beside `scene`.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("scene/Textures")).unwrap();
        for (name, text) in
            [("scene/s.gltf", "{}"), ("scene/Textures/Wood.png", "wood"), ("secret.txt", "secret")]
        {
            fs::write(folder.path().join(name), text).unwrap();
        }
        folder
    }

    fn open(folder: &tempfile::TempDir, options: &LoadOptions) -> SceneFiles {
        SceneFiles::open(&folder.path().join("scene/s.gltf"), options).unwrap()
    }

    #[test]
    fn folders_are_starts_of_references() {
        assert_eq!([folder_of("a.mtl"), folder_of("m/n\\a.mtl"), folder_of("/a")], ["", "m/n\\", "/"]);
        assert!(is_absolute("C:/a") && is_absolute("\\a") && !is_absolute("a/b"));
    }

    #[test]
    fn references_are_found_in_any_case_and_with_either_separator() {
        let folder = folder();
        let files = open(&folder, &LoadOptions::default());
        assert_eq!(files.name(), "s");
        assert_eq!(files.read_scene().unwrap(), b"{}");
        assert_eq!(files.clone().most_instances(), (1 << 21) + 2 * 8);
        let at = Location::file("s.gltf");
        for reference in ["Textures/Wood.png", "textures\\WOOD.PNG", "./Textures//../textures/wood.png"] {
            assert_eq!(files.read(reference, &at).unwrap(), b"wood", "{reference}");
        }
    }

    #[test]
    fn the_exact_name_wins_over_the_first_in_order() {
        let folder = folder();
        let textures = folder.path().join("scene/Textures");
        fs::write(textures.join("WOOD.png"), "first").unwrap();
        // A file system that ignores case has only one file.
        if fs::read(textures.join("Wood.png")).unwrap() == b"wood" {
            let files = open(&folder, &LoadOptions::default());
            let at = Location::default();
            assert_eq!(files.read("Textures/Wood.png", &at).unwrap(), b"wood");
            assert_eq!(files.read("Textures/wood.png", &at).unwrap(), b"first");
        }
    }

    #[test]
    fn paths_out_of_the_folder_are_refused_unless_permitted() {
        let folder = folder();
        let secret = folder.path().join("secret.txt");
        let references =
            ["../secret.txt", "Textures/../../secret.txt", "..\\secret.txt", secret.to_str().unwrap()];
        let at = Location::file("s.gltf").item("images[0]");
        let (strict, free) =
            (LoadOptions::default(), LoadOptions { allow_outside: true, ..Default::default() });
        for reference in references {
            let error = open(&folder, &strict).read(reference, &at).unwrap_err();
            let text = error.to_string();
            assert!(matches!(error, Error::Outside { .. }), "{text}");
            assert!(text.contains("images[0]") && text.contains("allow-outside"), "{text}");
            assert_eq!(open(&folder, &free).read(reference, &at).unwrap(), b"secret");
        }
        let error = open(&folder, &strict).read("", &at).unwrap_err();
        assert!(matches!(error, Error::Invalid { .. }), "{error}");
        for reference in ["../no-such-file", "../scene/s.gltf", "C:\\secret.txt"] {
            let error = open(&folder, &strict).read(reference, &at).unwrap_err();
            assert!(matches!(error, Error::Outside { .. }), "tells nothing about what is outside: {error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_inside_the_folder_only() {
        let folder = folder();
        let scene = folder.path().join("scene");
        std::os::unix::fs::symlink("../secret.txt", scene.join("out")).unwrap();
        std::os::unix::fs::symlink("..", scene.join("up")).unwrap();
        std::os::unix::fs::symlink("Textures/Wood.png", scene.join("in")).unwrap();
        let files = open(&folder, &LoadOptions::default());
        let at = Location::default();
        assert_eq!(files.read("in", &at).unwrap(), b"wood");
        assert!(matches!(files.read("out", &at), Err(Error::Outside { .. })));
        assert!(matches!(files.read("up/secret.txt", &at), Err(Error::Outside { .. })));
        let free = LoadOptions { allow_outside: true, ..Default::default() };
        assert_eq!(open(&folder, &free).read("out", &at).unwrap(), b"secret");
    }

    #[test]
    fn what_is_missing_too_large_or_no_file_is_an_error_that_says_so() {
        let folder = folder();
        let files = open(&folder, &LoadOptions { max_file_bytes: 3, ..Default::default() });
        let at = Location::file("s.gltf").item("buffers[1]");
        let missing = files.read("gone.bin", &at).unwrap_err();
        assert!(matches!(missing, Error::Io { .. }));
        assert!(missing.to_string().contains("gone.bin") && missing.to_string().contains("buffers[1]"));
        let large = files.read("Textures/Wood.png", &at).unwrap_err().to_string();
        assert!(large.contains("of 4 bytes; expected a file of at most 3 bytes"), "{large}");
        assert!(files.read("Textures", &at).unwrap_err().to_string().contains("a folder; expected a file"));
        let none = SceneFiles::open(&folder.path().join("none.gltf"), &LoadOptions::default());
        assert!(matches!(none, Err(Error::Io { .. })));
        assert!(matches!(
            SceneFiles::open(folder.path(), &LoadOptions::default()),
            Err(Error::Invalid { .. })
        ));
    }
}
