//! What every part of the loader needs: the files, the scene so far, what is to be told.

use std::collections::BTreeSet;

use super::features::FEATURES;
use super::image_lights::Maps;
use super::lexer::excerpt;
use super::parameters::Parameters;
use super::version::Version;
use crate::error::{Error, Location, Result};
use crate::io::assets::ImageCache;
use crate::io::{Feature, SceneFiles};
use crate::scene::{NoteKind, Notes, SceneBuilder, TurnedAway};

/// After so many different names that mean nothing the further ones are counted only; chosen.
const MAX_NAMED: usize = 100;

/// Longest name that a message repeats (characters); chosen.
const LONGEST_NAME: usize = 60;

/// The scene while it is read.
pub(super) struct Loading<'f> {
    /// The scene's files.
    pub(super) files: &'f SceneFiles,
    /// The scene so far.
    pub(super) builder: SceneBuilder,
    /// Which format it is.
    pub(super) version: Version,
    /// Images by reference.
    pub(super) images: ImageCache,
    /// The maps of lights.
    pub(super) maps: Maps,
    /// What is to be told.
    pub(super) notes: Notes,
    named: BTreeSet<String>,
    /// Bytes of geometry that may still be held.
    geometry_left: u64,
}

impl<'f> Loading<'f> {
    /// An empty scene.
    pub(super) fn new(files: &'f SceneFiles, version: Version) -> Self {
        let mut builder = SceneBuilder::new(files.name(), Location::file(files.path()));
        if version == Version::V4 {
            builder.set_turned_away(TurnedAway::Opposite);
        }
        Self {
            files,
            builder,
            version,
            images: ImageCache::new(),
            maps: Maps::new(),
            notes: Notes::default(),
            named: BTreeSet::new(),
            geometry_left: files.options().max_file_bytes,
        }
    }

    /// Tells what was done with the input.
    pub(super) fn note(&mut self, kind: NoteKind, message: impl Into<String>, at: Location) {
        self.notes.push(kind, message, at);
    }

    /// As [`Self::note`], for messages with a name from the file, of which there may be any number.
    pub(super) fn note_named(&mut self, kind: NoteKind, message: String, otherwise: &str, at: Location) {
        if self.named.contains(&message) || self.named.len() < MAX_NAMED {
            self.named.insert(message.clone());
            self.notes.push(kind, message, at);
        } else {
            self.notes.push(kind, format!("further {otherwise}"), at);
        }
    }

    /// Tells that something of the feature table was met. Names that are not in it are noted as
    /// `unknown` says.
    ///
    /// # Errors
    /// If the feature is refused.
    pub(super) fn met(&mut self, kind: &'static str, name: &str, unknown: &str, at: &Location) -> Result<()> {
        match Feature::find(FEATURES, kind, name) {
            Some(feature) => feature.met(at, &mut self.notes),
            None => {
                let shown = excerpt(name, LONGEST_NAME);
                let message = format!("{kind} {shown:?} is unknown: {unknown}");
                self.note_named(NoteKind::Ignored, message, "unknown names", at.clone());
                Ok(())
            }
        }
    }

    /// Whether this format has a feature of that kind and name.
    pub(super) fn knows(kind: &str, name: &str) -> bool {
        Feature::find(FEATURES, kind, name).is_some()
    }

    /// Tells which parameters nothing looked at; `owner` says whose they are.
    pub(super) fn note_unused(&mut self, owner: &str, parameters: &Parameters) {
        for parameter in parameters.unused() {
            let message = format!("parameter {:?} of {owner} is not used", parameter.declaration);
            self.note_named(NoteKind::Ignored, message, "parameters are not used", parameter.at());
        }
    }

    /// Takes `bytes` of geometry from what may be held.
    ///
    /// # Errors
    /// If too little is left: a small text can ask for the same large file again and again.
    pub(super) fn hold(&mut self, bytes: usize, at: &Location) -> Result<()> {
        let left = u64::try_from(bytes).ok().and_then(|bytes| self.geometry_left.checked_sub(bytes));
        self.geometry_left = left.ok_or_else(|| {
            let limit = self.files.options().max_file_bytes;
            Error::invalid(at.clone(), "geometry beyond the limit", format!("at most {limit} bytes in all"))
        })?;
        Ok(())
    }
}
