//! What each format may say, and what becomes of it here: one table a format.
//!
//! Loaders look up in these tables what they meet, so that the table is what the loader does: a row
//! that is not
//! [`Support::Full`] gives a note, or an error, with the row's own words.
//!
//! # Held to this by
//! `suite::features`: every row, in a small scene of its own, gives the note that it promises and
//! no other; the guide's tables are these.

use super::notes::{excerpt, quoted};
use crate::error::{Error, Location, Result, nearest_name};
use crate::scene::{NoteKind, Notes};

/// Longest name in a message (characters); chosen.
const LONGEST: usize = 80;

/// How far something is understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// As the format defines it.
    Full,
    /// Replaced by the nearest that exists here.
    Approximated,
    /// Left out.
    Ignored,
    /// The scene is not loaded.
    Refused,
}

/// One thing that a file of a format may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Feature {
    /// What sort of thing it is: material, light, shape, texture, camera, film.
    pub kind: &'static str,
    /// Its name, as it is spelt in the format.
    pub name: &'static str,
    /// How far it is understood.
    pub support: Support,
    /// What it becomes.
    pub how: &'static str,
}

/// All features of a format.
#[derive(Clone, Copy, Debug)]
pub struct FormatFeatures {
    /// Name of the format.
    pub format: &'static str,
    /// Its rows.
    pub rows: &'static [Feature],
}

/// A table of features: for each kind its rows, `name, support, what it becomes;`.
macro_rules! table {
    ($($kind:expr => { $($name:expr, $support:ident, $how:expr;)+ })+) => {
        &[$($(Feature { kind: $kind, name: $name, support: Support::$support, how: $how },)+)+]
    };
}
pub(super) use table;

impl Feature {
    /// The row of a table for a thing of this kind and name.
    pub(super) fn find(rows: &'static [Self], kind: &str, name: &str) -> Option<&'static Self> {
        rows.iter().find(|f| f.kind == kind && f.name == name)
    }

    /// Tells what a table says about a thing met at `at`, and whether it says anything.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it is refused.
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
        // Rows with blanks describe parts of things.
        let known = rows.iter().filter(|row| row.kind == kind && !row.name.contains(' '));
        match nearest_name(name, known.map(|row| row.name)) {
            Some(near) => Err(Error::misspelt(at.clone(), kind, &excerpt(name, LONGEST), near)),
            None => Ok(()),
        }
    }

    /// What a note says of a thing that is in no row.
    pub(super) fn unknown([kind, name]: [&str; 2], instead: &str) -> String {
        format!("{kind} {} is unknown: {instead}", quoted(name))
    }

    /// Tells that the thing was met at `at`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it is refused.
    pub(super) fn met(&self, at: &Location, notes: &mut Notes) -> Result<()> {
        self.met_often(at, 1, notes)
    }

    /// Tells that the thing was met so often, first at `at`.
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
