//! State shared by all parts of the loader: files, the scene so far, and notes.

use super::features::FEATURES;
use super::image_lights::Maps;
use super::known;
use super::names::Names;
use super::parameters::{Parameter, Parameters};
use super::version::Version;
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::assets::ImageCache;
use crate::io::limits::Budget;
use crate::io::notes::{Named, excerpt};
use crate::io::{Feature, SceneFiles};
use crate::scene::{NoteKind, SceneBuilder, TurnedAway};

/// Most different messages that contain names from the file; further ones are only counted; chosen.
const MAX_NAMED: usize = 100;

/// The scene while it is read.
pub(super) struct Loading<'f> {
    /// Access to the scene's folder.
    pub(super) files: &'f SceneFiles,
    /// The scene so far.
    pub(super) builder: SceneBuilder,
    /// Format of the scene.
    pub(super) version: Version,
    /// Images that were read, by reference.
    pub(super) images: ImageCache<'f>,
    /// Maps of lights that were made.
    pub(super) maps: Maps,
    named: Named,
    /// Names that the scene defines and uses.
    pub(super) names: Names,
    /// Budget for meshes, maps of lights, and grids of media: a small text can name the same large
    /// file again and again.
    pub(super) geometry: Budget,
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
            images: ImageCache::new(files),
            maps: Maps::new(),
            named: Named::new(MAX_NAMED),
            names: Names::default(),
            geometry: Budget::new(files.options().max_file_bytes, "geometry"),
        }
    }

    /// Adds a note about the input.
    pub(super) fn note(&mut self, kind: NoteKind, message: impl Into<String>, at: Location) {
        self.builder.note(kind, message, at);
    }

    /// As [`Self::note`], for messages that contain a name from the file. After `MAX_NAMED`
    /// different messages, a single note `further {otherwise}` replaces the rest.
    pub(super) fn note_named(&mut self, kind: NoteKind, message: String, otherwise: &str, at: Location) {
        let notes = self.builder.notes_mut();
        self.named.add(kind, message, &format!("further {otherwise}"), at, notes);
    }

    /// Adds the note that the feature table has for a feature. A name without a row is noted as
    /// ignored; `unknown` is the consequence that this note states.
    ///
    /// # Errors
    /// If the feature is refused, or the name is a slip of a name in the table.
    pub(super) fn met(&mut self, kind: &'static str, name: &str, unknown: &str, at: &Location) -> Result<()> {
        if !Feature::look_up(FEATURES, [kind, name], at, self.builder.notes_mut())? {
            Feature::refuse_slip(FEATURES, [kind, name], at)?;
            let message = Feature::unknown([kind, name], unknown);
            self.note_named(NoteKind::Ignored, message, "unknown names", at.clone());
        }
        Ok(())
    }

    /// Returns true if the feature table has that kind and name.
    pub(super) fn knows(kind: &str, name: &str) -> bool {
        Feature::find(FEATURES, kind, name).is_some()
    }

    /// Notes unused parameters of a `kind`, of type `class` if the kind has types.
    ///
    /// # Errors
    /// If an unused name is a slip of a known parameter.
    pub(super) fn note_unused(&mut self, kind: &str, class: &str, parameters: &Parameters) -> Result<()> {
        let owner = if class.is_empty() && kind != "material" {
            kind.to_owned()
        } else {
            format!("{kind} {class:?}")
        };
        for parameter in parameters.unused() {
            let is_known = known::names(kind, class).any(|known| known == parameter.name);
            if is_known && parameters.accepts_known() {
                continue;
            }
            self.note_unknown(&owner, known::names(kind, class), parameter)?;
        }
        Ok(())
    }

    /// Notes an unused parameter of an owner with the parameters `known`.
    ///
    /// # Errors
    /// If the name is a slip of one of `known`.
    pub(super) fn note_unknown(
        &mut self,
        owner: &str,
        known: impl Iterator<Item = &'static str>,
        parameter: &Parameter,
    ) -> Result<()> {
        let (name, at) = (&parameter.name, parameter.at());
        let near = if known::is_name(name) { None } else { nearest_name(name, known) };
        if let Some(near) = near {
            return Err(Error::misspelt(at, &format!("{owner}: parameter"), &excerpt(name, 60), near));
        }
        let message = format!("parameter {:?} of {owner} is not used", parameter.declaration);
        self.note_named(NoteKind::Ignored, message, "parameters are not used", at);
        Ok(())
    }
}
