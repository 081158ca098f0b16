//! Features of each format and their support here: one table a format.
//!
//! Loaders look up each feature that they meet, so that the tables describe the loaders. Every row
//! other than [`Support::Full`] gives a note or an error with the text of the row.
//!
//! # Held to this by
//! `suite::features`: for every row, a small scene with the feature gives exactly the note of the
//! row; the guide's tables equal these.

use super::notes::{excerpt, quoted};
use crate::error::{Error, Location, Result, nearest_name};
use crate::scene::{NoteKind, Notes};

/// Longest name in a message (characters); chosen.
const LONGEST: usize = 80;

/// Degree to which a feature is supported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Read as the format defines it.
    Full,
    /// Replaced by the nearest feature that exists here.
    Approximated,
    /// Ignored; the rest of the scene is loaded.
    Ignored,
    /// The scene is not loaded.
    Refused,
}

/// A feature that a file of a format may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Feature {
    /// Sort of feature: material, light, shape, texture, camera, film.
    pub kind: &'static str,
    /// Name of the feature, as it is spelt in the format.
    pub name: &'static str,
    /// Degree to which the feature is supported.
    pub support: Support,
    /// Counterpart in this renderer, for notes, errors and the guide.
    pub how: &'static str,
}

/// Table of features of a format.
#[derive(Clone, Copy, Debug)]
pub struct FormatFeatures {
    /// Name of the format in the guide, such as `glTF`.
    pub format: &'static str,
    /// Features by kind.
    pub rows: &'static [Feature],
}

/// A table of features: for each kind its rows, `name, support, how;`.
macro_rules! table {
    ($($kind:expr => { $($name:expr, $support:ident, $how:expr;)+ })+) => {
        &[$($(Feature { kind: $kind, name: $name, support: Support::$support, how: $how },)+)+]
    };
}
pub(super) use table;

impl Feature {
    /// Returns the row of a table for a feature of this kind and name.
    pub(super) fn find(rows: &'static [Self], kind: &str, name: &str) -> Option<&'static Self> {
        rows.iter().find(|f| f.kind == kind && f.name == name)
    }

    /// Notes a feature met at `at` with the text of its row. Returns false if the feature has no
    /// row.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the row refuses it.
    pub(super) fn look_up(
        rows: &'static [Self],
        [kind, name]: [&str; 2],
        at: &Location,
        notes: &mut Notes,
    ) -> Result<bool> {
        Self::find(rows, kind, name).map_or(Ok(false), |row| row.met(at, notes).map(|()| true))
    }

    /// Refuses a name that is in no row, but close to a name in some row.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the name that was probably meant.
    pub(super) fn refuse_slip(rows: &'static [Self], [kind, name]: [&str; 2], at: &Location) -> Result<()> {
        // Names with blanks belong to parts of features.
        let known = rows.iter().filter(|row| row.kind == kind && !row.name.contains(' '));
        match nearest_name(name, known.map(|row| row.name)) {
            Some(near) => Err(Error::misspelt(at.clone(), kind, &excerpt(name, LONGEST), near)),
            None => Ok(()),
        }
    }

    /// Message of a note about a feature without a row; `instead` states its replacement.
    pub(super) fn unknown([kind, name]: [&str; 2], instead: &str) -> String {
        format!("{kind} {} is unknown: {instead}", quoted(name))
    }

    /// Notes that the feature was met at `at`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it is refused.
    pub(super) fn met(&self, at: &Location, notes: &mut Notes) -> Result<()> {
        self.met_often(at, 1, notes)
    }

    /// Notes that the feature was met `count` times, first at `at`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it is refused.
    pub(super) fn met_often(&self, at: &Location, count: u64, notes: &mut Notes) -> Result<()> {
        let Self { kind, name, support, how } = self;
        let note = match support {
            Support::Full => return Ok(()),
            Support::Approximated => NoteKind::Approximated,
            Support::Ignored => NoteKind::Ignored,
            Support::Refused => {
                return Err(Error::unsupported(at.clone(), format!("{kind} {name:?}"), *how));
            }
        };
        notes.push_many(note, format!("{kind} {name:?}: {how}"), at.clone(), count);
        Ok(())
    }
}
