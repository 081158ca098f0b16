//! Images that scene files refer to, each decoded once for each encoding.
//!
//! An image that is missing, damaged or of another format does not stop the reading of a scene: it
//! is noted, and the caller puts something in its place. [`load_scene`](super::load_scene) decides
//! at the end if missing files are an error.
//!
//! Held to this by the tests below.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::PathBuf;

use super::images::{self, Decoded, Encoding};
use super::udim::{self, Picture};
use super::{LoadOptions, SceneFiles};
use crate::error::{Error, Location, Result};
use crate::scene::{Channel, Image, NoteKind, SceneBuilder, below_zero_message};

/// Images of a scene that were loaded so far.
#[derive(Debug)]
pub(super) struct ImageCache<'f> {
    files: &'f SceneFiles,
    /// Results by reference, as the scene file spells it.
    by_reference: BTreeMap<(String, Encoding), Result<Picture, Unreadable>>,
    /// Images by canonical path, because references may spell one file in several ways.
    by_path: BTreeMap<(PathBuf, Encoding), Picture>,
    /// Images with texels that are not opaque.
    transparent: BTreeSet<Picture>,
    /// For each image with a single colour channel, which channel it is; grey images are not
    /// listed.
    lone: BTreeMap<Picture, Channel>,
}

impl<'f> ImageCache<'f> {
    pub(super) fn new(files: &'f SceneFiles) -> Self {
        Self {
            files,
            by_reference: BTreeMap::new(),
            by_path: BTreeMap::new(),
            transparent: BTreeSet::new(),
            lone: BTreeMap::new(),
        }
    }

    /// Returns the image or tiles that `reference` names; none, with a note at `at`, if they cannot
    /// be read.
    ///
    /// # Errors
    /// If the scene refuses the image, see [`SceneBuilder::add_image`].
    pub(super) fn load(
        &mut self,
        reference: &str,
        encoding: Encoding,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<Option<Picture>> {
        let found = self.find(reference, encoding, at, builder)?;
        Ok(noted(found, reference, at, builder))
    }

    /// Like [`Self::load`], but with the reason instead of a note, for callers that replace the
    /// image.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub(super) fn find(
        &mut self,
        reference: &str,
        encoding: Encoding,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<Result<Picture, Unreadable>> {
        let key = (reference.to_owned(), encoding);
        if let Some(known) = self.by_reference.get(&key) {
            return Ok(known.clone());
        }
        let found = if let Some(known) = self.known(reference, encoding, at) {
            Ok((known, true))
        } else if udim::is_pattern(reference) {
            udim::load(self.files, reference, encoding, at, builder)
                .map(|(tiles, opaque)| (Picture::Tiles(tiles), opaque))
        } else {
            match read(self.files, reference, encoding, at, builder) {
                Ok(decoded) => {
                    let image = Picture::Image(builder.add_image(decoded.image)?);
                    self.lone.extend(decoded.lone.map(|channel| (image, channel)));
                    let path = self.files.resolve(reference, at);
                    self.by_path.extend(path.ok().map(|path| ((path, encoding), image)));
                    Ok((image, decoded.opaque))
                }
                Err(error) => Err(error),
            }
        };
        let found = found.map_err(|error| (kind(&error), reason(&error))).map(|(picture, opaque)| {
            self.transparent.extend((!opaque).then_some(picture));
            picture
        });
        self.by_reference.insert(key, found.clone());
        Ok(found)
    }

    /// The image that was loaded by this name, or from the same file.
    pub(super) fn known(&self, reference: &str, encoding: Encoding, at: &Location) -> Option<Picture> {
        if let Some(known) = self.by_reference.get(&(reference.to_owned(), encoding)) {
            return known.as_ref().ok().copied();
        }
        self.by_path.get(&(self.files.resolve(reference, at).ok()?, encoding)).copied()
    }

    /// Returns true if an image that was loaded here has texels that are not opaque.
    pub(super) fn has_opacity(&self, image: Picture) -> bool {
        self.transparent.contains(&image)
    }

    /// Returns the channel from which a number is read if the file selects none: the luminance, or
    /// the only channel of an image that is not grey.
    pub(super) fn number_channel(&self, image: Picture) -> Channel {
        self.lone.get(&image).copied().unwrap_or(Channel::Luminance)
    }

    /// Decodes an image of colours, such as an environment. The caller stores the image; the cache
    /// does not. Returns none, with a note, if the image cannot be read.
    ///
    /// # Errors
    /// No error is returned at present.
    pub(super) fn read(
        &self,
        reference: &str,
        encoding: Encoding,
        at: &Location,
        builder: &mut SceneBuilder,
    ) -> Result<Option<Image>> {
        let bytes = self.files.read(reference, at);
        let options = self.files.options();
        let decoded =
            bytes.and_then(|bytes| decode_colors(&bytes, reference, encoding, options, at, builder));
        let decoded = decoded.map_err(|error| (kind(&error), reason(&error)));
        Ok(noted(decoded, reference, at, builder))
    }
}

fn read(
    files: &SceneFiles,
    reference: &str,
    encoding: Encoding,
    at: &Location,
    builder: &mut SceneBuilder,
) -> Result<Decoded> {
    decode(&files.read(reference, at)?, reference, encoding, files.options(), at, builder)
}

/// Decodes an image file by [`images::decode`], with notes of repairs.
pub(super) fn decode(
    bytes: &[u8],
    name: &str,
    encoding: Encoding,
    options: &LoadOptions,
    at: &Location,
    builder: &mut SceneBuilder,
) -> Result<Decoded> {
    let decoded = images::decode(bytes, name, encoding, options, at)?;
    decoded.note(builder.notes_mut(), at);
    Ok(decoded)
}

/// Decodes an image file used only for colours, with notes of repaired texels and of texels below
/// zero.
pub(super) fn decode_colors(
    bytes: &[u8],
    name: &str,
    encoding: Encoding,
    options: &LoadOptions,
    at: &Location,
    builder: &mut SceneBuilder,
) -> Result<Image> {
    let image = decode(bytes, name, encoding, options, at, builder)?.image;
    let count = image.texels_below_zero();
    builder.notes_mut().push_many(NoteKind::Repaired, below_zero_message(name), at.clone(), count);
    Ok(image)
}

/// Kind of the note, and the reason, if something could not be read.
pub(super) type Unreadable = (NoteKind, String);

/// Note of an image that could not be read, with the reason and the replacement.
pub(super) fn unreadable_image(name: &str, why: &str, instead: &str) -> String {
    format!("image {name:?} could not be read ({why}): {instead}")
}

/// Replacement of a texture that could not be read, if it has a factor.
pub(super) const FACTOR_ALONE: &str = "its colour factor is used alone";

/// Returns the loaded value, or notes the reason that there is none.
fn noted<T>(
    loaded: Result<T, Unreadable>,
    reference: &str,
    at: &Location,
    builder: &mut SceneBuilder,
) -> Option<T> {
    let note = |(kind, why): Unreadable| {
        builder.note(kind, unreadable_image(reference, &why, "left out"), at.clone());
    };
    loaded.map_err(note).ok()
}

/// The kind of a note about a file that could not be read.
pub(super) fn kind(error: &Error) -> NoteKind {
    match error {
        Error::Io { source, .. } if source.kind() == ErrorKind::NotFound => NoteKind::Missing,
        Error::Outside { .. } => NoteKind::Missing,
        _ => NoteKind::Repaired,
    }
}

/// Reason that something could not be read. The place is omitted, because the note has it.
pub(super) fn reason(error: &Error) -> String {
    match error {
        Error::Io { source, .. } if source.kind() == ErrorKind::NotFound => "no such file".to_owned(),
        Error::Io { source, .. } => source.kind().to_string(),
        Error::Outside { .. } => {
            "outside of the folder of the scene file; --allow-outside permits it".to_owned()
        }
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
            ("below.pfm", pfm(-1.0)),
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
        let mut cache = ImageCache::new(&files);
        let at = Location::line("s.pbrt", 3);
        let mut load =
            |reference: &str, encoding| cache.load(reference, encoding, &at, &mut builder).unwrap();
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
        let mut cache = ImageCache::new(&files);
        let at = Location::line("s.pbrt", 3);
        for reference in ["gone.png", "gone.png", "bad.pfm", "../outside.png"] {
            assert_eq!(cache.load(reference, Encoding::Srgb, &at, &mut builder).unwrap(), None);
        }
        for _ in 0..2 {
            assert!(cache.load("infinite.pfm", Encoding::Srgb, &at, &mut builder).unwrap().is_some());
        }
        let image = cache.read("a.pfm", Encoding::Linear, &at, &mut builder).unwrap().unwrap();
        assert_eq!((image.width, image.height), (1, 1));
        assert!(cache.read("gone.png", Encoding::Linear, &at, &mut builder).unwrap().is_none());
        // `read` is for colours only and notes values below zero itself. After `load`, they are
        // noted only if the scene uses the image for colours.
        assert!(cache.read("below.pfm", Encoding::Linear, &at, &mut builder).unwrap().is_some());
        assert!(cache.load("below.pfm", Encoding::Linear, &at, &mut builder).unwrap().is_some());
        let notes = notes(builder);
        let count = |part: &str| notes.iter().find(|(message, _)| message.contains(part)).map(|n| n.1);
        assert_eq!(count("\"gone.png\" could not be read (no such file)"), Some(3), "{notes:?}");
        assert_eq!(count("\"bad.pfm\" could not be read"), Some(1), "{notes:?}");
        assert_eq!(count("allow-outside"), Some(1), "{notes:?}");
        assert_eq!(count("\"infinite.pfm\" has texels that are not finite"), Some(1), "{notes:?}");
        assert_eq!(count("\"below.pfm\" has texels below zero"), Some(1), "{notes:?}");
    }
}
