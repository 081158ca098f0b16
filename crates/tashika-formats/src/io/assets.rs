//! Images that scene files refer to, each decoded once for each encoding.
//!
//! An image that is missing, or damaged, or of another format does not stop the reading of a scene:
//! a note tells, and the caller puts something in its place. Whether notes of missing files stop it
//! in the end is [`load_scene`](super::load_scene)'s.
//!
//! Held to this by the tests below.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::PathBuf;

use super::SceneFiles;
use super::images::{self, Decoded, Encoding};
use super::udim::{self, Picture};
use crate::error::{Error, Location, Result};
use crate::scene::{Image, NoteKind, SceneBuilder};

/// The images of a scene so far.
#[derive(Debug, Default)]
pub(super) struct ImageCache {
    /// By the reference as it is spelt; the message of its note, where that failed.
    by_reference: BTreeMap<(String, Encoding), Result<Picture, Unreadable>>,
    /// By canonical path: one file may be spelt in several ways.
    by_path: BTreeMap<(PathBuf, Encoding), Picture>,
    /// Those with texels that are not opaque.
    transparent: BTreeSet<Picture>,
}

impl ImageCache {
    pub(super) fn new() -> Self {
        Self::default()
    }

    /// The image, or the tiles, that `reference`, found at `at`, stands for; nothing, with a note, if it cannot be
    /// read.
    ///
    /// # Errors
    /// If the scene cannot take it, see [`SceneBuilder::add_image`].
    pub(super) fn load(
        &mut self,
        files: &SceneFiles,
        reference: &str,
        encoding: Encoding,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<Option<Picture>> {
        let key = (reference.to_owned(), encoding);
        if let Some(known) = self.by_reference.get(&key) {
            return Ok(noted(known.clone(), at, builder));
        }
        if udim::is_pattern(reference) {
            let loaded = match udim::load(files, reference, encoding, at, builder) {
                Ok((tiles, opaque)) => {
                    let tiles = Picture::Tiles(tiles);
                    if !opaque {
                        self.transparent.insert(tiles);
                    }
                    Ok(tiles)
                }
                Err(error) => Err(unreadable(reference, &error)),
            };
            self.by_reference.insert(key, loaded.clone());
            return Ok(noted(loaded, at, builder));
        }
        let path = files.resolve(reference, at);
        let known = path.as_ref().ok().and_then(|p| self.by_path.get(&(p.clone(), encoding)).copied());
        let loaded = match known {
            Some(image) => Ok(image),
            None => match decode(files, reference, encoding, at) {
                Ok(decoded) => {
                    note_repairs(&decoded, at, builder);
                    let image = Picture::Image(builder.add_image(decoded.image)?);
                    if !decoded.opaque {
                        self.transparent.insert(image);
                    }
                    self.by_path.extend(path.ok().map(|p| ((p, encoding), image)));
                    Ok(image)
                }
                Err(error) => Err(unreadable(reference, &error)),
            },
        };
        self.by_reference.insert(key, loaded.clone());
        Ok(noted(loaded, at, builder))
    }

    /// Whether an image that was loaded here has texels that are not opaque.
    pub(super) fn has_opacity(&self, image: Picture) -> bool {
        self.transparent.contains(&image)
    }

    /// The picture itself, for callers that keep it themselves, such as environments; nothing, with
    /// a note, if it cannot be read. It is not kept here.
    ///
    /// # Errors
    /// None so far.
    pub(super) fn read(
        &self,
        files: &SceneFiles,
        reference: &str,
        encoding: Encoding,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<Option<Image>> {
        let decoded = decode(files, reference, encoding, at).map_err(|error| unreadable(reference, &error));
        let Some(decoded) = noted(decoded, at, builder) else { return Ok(None) };
        note_repairs(&decoded, at, builder);
        Ok(Some(decoded.image))
    }
}

fn decode(files: &SceneFiles, reference: &str, encoding: Encoding, at: &Location) -> Result<Decoded> {
    let bytes = files.read(reference, at)?;
    images::decode(&bytes, reference, encoding, files.options(), at)
}

/// What a note says of an image that could not be read.
pub(super) type Unreadable = (NoteKind, String);

fn unreadable(reference: &str, error: &Error) -> Unreadable {
    (kind(error), format!("image {reference:?} could not be read ({}): left out", reason(error)))
}

/// What was loaded, or a note why nothing was.
fn noted<T>(loaded: Result<T, Unreadable>, at: &Location, builder: &mut SceneBuilder) -> Option<T> {
    loaded.map_err(|(kind, message)| builder.note(kind, message, at.clone())).ok()
}

fn note_repairs(decoded: &Decoded, at: &Location, builder: &mut SceneBuilder) {
    if let Some(message) = decoded.repairs() {
        builder.note(NoteKind::Repaired, message, at.clone());
    }
}

/// The kind of a note about a file that could not be read.
pub(super) fn kind(error: &Error) -> NoteKind {
    match error {
        Error::Io { source, .. } if source.kind() == ErrorKind::NotFound => NoteKind::Missing,
        _ => NoteKind::Repaired,
    }
}

/// Why something could not be read, without the place, which its note has.
pub(super) fn reason(error: &Error) -> String {
    match error {
        Error::Io { source, .. } if source.kind() == ErrorKind::NotFound => "no such file".to_owned(),
        Error::Io { source, .. } => source.kind().to_string(),
        Error::Invalid { found, expected, .. } => format!("{found}; expected {expected}"),
        Error::Unsupported { what, instead, .. } => format!("{what} is not supported; {instead}"),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::io::LoadOptions;

    /// A grey float map of one texel.
    fn pfm(value: f32) -> Vec<u8> {
        b"Pf 1 1 -1\n".iter().copied().chain(value.to_le_bytes()).collect()
    }

    fn scene(folder: &tempfile::TempDir) -> (SceneFiles, SceneBuilder) {
        // One texel of 32 bits, half opaque.
        let mut glass = vec![0; 18];
        (glass[2], glass[12], glass[14], glass[16], glass[17]) = (2, 1, 1, 32, 8);
        glass.extend([1, 2, 3, 128]);
        for (name, bytes) in [
            ("s.pbrt", vec![]),
            ("a.pfm", pfm(1.0)),
            ("bad.pfm", b"PF 9 9".to_vec()),
            ("infinite.pfm", pfm(f32::INFINITY)),
            ("glass.tga", glass),
        ] {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        let files = SceneFiles::open(&folder.path().join("s.pbrt"), &LoadOptions::default()).unwrap();
        (files, SceneBuilder::new("s", Location::file("s.pbrt")))
    }

    fn notes(builder: SceneBuilder) -> Vec<(String, u64)> {
        let scene = builder.build().unwrap();
        let unread = scene.notes().iter().filter(|n| n.kind <= NoteKind::Repaired);
        unread.map(|n| (n.message, n.count)).collect()
    }

    #[test]
    fn images_are_decoded_once_for_each_encoding_however_they_are_spelt() {
        let folder = tempfile::tempdir().unwrap();
        let (files, mut builder) = scene(&folder);
        let mut cache = ImageCache::new();
        let at = Location::line("s.pbrt", 3);
        let mut load =
            |reference: &str, encoding| cache.load(&files, reference, encoding, &at, &mut builder).unwrap();
        let first = load("a.pfm", Encoding::Linear);
        assert!(first.is_some());
        for reference in ["a.pfm", "./A.PFM", ".\\a.pfm"] {
            assert_eq!(load(reference, Encoding::Linear), first, "{reference}");
        }
        assert_ne!(load("a.pfm", Encoding::Srgb), first);
        let glass = load("glass.tga", Encoding::Srgb);
        assert!(cache.has_opacity(glass.unwrap()) && !cache.has_opacity(first.unwrap()));
        assert!(notes(builder).is_empty());
    }

    #[test]
    fn what_cannot_be_read_is_noted_each_time_and_what_is_repaired_once() {
        let folder = tempfile::tempdir().unwrap();
        let (files, mut builder) = scene(&folder);
        let mut cache = ImageCache::new();
        let at = Location::line("s.pbrt", 3);
        for reference in ["gone.png", "gone.png", "bad.pfm", "../outside.png"] {
            assert_eq!(cache.load(&files, reference, Encoding::Srgb, &at, &mut builder).unwrap(), None);
        }
        for _ in 0..2 {
            assert!(cache.load(&files, "infinite.pfm", Encoding::Srgb, &at, &mut builder).unwrap().is_some());
        }
        let image = cache.read(&files, "a.pfm", Encoding::Linear, &at, &mut builder).unwrap().unwrap();
        assert_eq!((image.width, image.height), (1, 1));
        assert!(cache.read(&files, "gone.png", Encoding::Linear, &at, &mut builder).unwrap().is_none());
        let notes = notes(builder);
        let count = |part: &str| notes.iter().find(|(message, _)| message.contains(part)).map(|n| n.1);
        assert_eq!(count("\"gone.png\" could not be read (no such file)"), Some(3), "{notes:?}");
        assert_eq!(count("\"bad.pfm\" could not be read"), Some(1), "{notes:?}");
        assert_eq!(count("allow-outside"), Some(1), "{notes:?}");
        assert_eq!(count("\"infinite.pfm\" has texels that are not finite"), Some(1), "{notes:?}");
    }
}
