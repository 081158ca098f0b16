//! The texts of a scene: the main file and included files.
//!
//! Names are relative to the folder of the main file, as in pbrt; a file that does not exist there
//! is searched for beside the including file. Texts may be compressed with gzip.
//!
//! # Guarantee
//! The nesting, the number of included files and their total size are limited, so that files which
//! include each other end in an error.
//!
//! Tested by `suite::pbrt::includes_*`, `suite::damaged_pbrt::includes_*`.

use std::io::Read;

use flate2::read::MultiGzDecoder;

use super::lexer::Lexer;
use super::place::Source;
use super::version::{Evidence, Version, next_evidence};
use crate::error::{Error, Location, Result};
use crate::io::SceneFiles;
use crate::io::files::folder_of;
use crate::io::limits::{Budget, Includes};

/// Deepest nesting of includes.
pub(super) const MAX_DEPTH: usize = 32;

/// Most files that are included in all; large scenes have hundreds.
const MAX_INCLUDES: usize = 10_000;

/// First bytes of a gzip file.
const GZIP: &[u8] = b"\x1f\x8b";

/// The main file or an included file.
pub(super) struct Text {
    /// Text without compression.
    pub(super) bytes: Vec<u8>,
    /// Name of the file in messages.
    pub(super) source: Source,
    /// Folder relative to that of the main file, with a separator at the end; empty if equal.
    pub(super) folder: String,
}

/// Reads texts and counts their files and bytes.
pub(super) struct Texts<'f> {
    files: &'f SceneFiles,
    includes: Includes,
    budget: Budget,
}

impl<'f> Texts<'f> {
    /// Reader of a scene's texts.
    pub(super) fn new(files: &'f SceneFiles) -> Self {
        let budget = Budget::new(files.options().max_file_bytes, "texts");
        Self { files, includes: Includes::new(MAX_INCLUDES, MAX_DEPTH), budget }
    }

    /// Reads the scene's own file.
    pub(super) fn main(&mut self) -> Result<Text> {
        let bytes = self.files.read_scene()?;
        let bytes = self.unpacked(bytes, &Location::file(self.files.path()))?;
        Ok(Text { bytes, source: Source::new(self.files.path()), folder: String::new() })
    }

    /// Reads the file `name`, included from folder `from` while `depth` texts are open.
    pub(super) fn include(&mut self, name: &str, from: &str, depth: usize, at: &Location) -> Result<Text> {
        self.includes.enter(name, depth, at)?;
        let beside = format!("{from}{name}");
        let (reference, bytes) = match self.files.read(name, at) {
            Ok(bytes) => (name.to_owned(), bytes),
            Err(Error::Io { .. }) if beside != name && self.files.resolve(&beside, at).is_ok() => {
                let bytes = self.files.read(&beside, at)?;
                (beside, bytes)
            }
            Err(error) => return Err(error),
        };
        let bytes = self.unpacked(bytes, at)?;
        self.includes.count(&reference, bytes.len() as u64, at)?;
        let source = Source::new(&self.files.beside(&reference));
        Ok(Text { bytes, source, folder: folder_of(&reference).to_owned() })
    }

    /// Decompresses a text, if it is compressed, and counts its bytes.
    fn unpacked(&self, bytes: Vec<u8>, at: &Location) -> Result<Vec<u8>> {
        let bytes = if bytes.starts_with(GZIP) {
            let mut unpacked = Vec::new();
            let limit = self.budget.left().saturating_add(1);
            MultiGzDecoder::new(&bytes[..]).take(limit).read_to_end(&mut unpacked).map_err(|e| {
                Error::invalid(at.clone(), format!("a text that cannot be decompressed ({e})"), "gzip")
            })?;
            unpacked
        } else {
            bytes
        };
        self.budget.take(bytes.len() as u64, at)?;
        Ok(bytes)
    }
}

/// Determines the format of the scene, see [`super::version`].
///
/// Texts are read up to the first evidence. Their errors are reported when they are read in full.
pub(super) fn version(files: &SceneFiles, main: &Text) -> Version {
    fn decide(texts: &mut Texts<'_>, text: &Text, depth: usize) -> Option<Version> {
        let mut lexer = Lexer::new(&text.bytes, text.source.clone());
        loop {
            match next_evidence(&mut lexer).ok()? {
                Evidence::Decisive(version) => return Some(version),
                Evidence::None => return None,
                Evidence::Include(name) => {
                    let at = lexer.place().location();
                    let included = texts.include(&name, &text.folder, depth, &at).ok();
                    if let Some(version) = included.and_then(|text| decide(texts, &text, depth + 1)) {
                        return Some(version);
                    }
                }
            }
        }
    }
    decide(&mut Texts::new(files), main, 1).unwrap_or(Version::V4)
}
