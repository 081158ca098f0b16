//! Places in the text of a scene.
//!
//! A [`Place`] is small and becomes a [`Location`] in notes and errors.

use std::path::Path;
use std::sync::Arc;

use crate::error::Location;

/// A file of the scene, by its name in messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Source(Arc<Path>);

impl Source {
    /// File of the given name.
    pub(super) fn new(file: &Path) -> Self {
        Self(file.into())
    }
}

/// Place of a token in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// File of the text.
    pub(super) source: Source,
    /// Number of the line, from 1.
    pub(super) line: u32,
    /// Number of the column, from 1, in bytes.
    pub(super) column: u32,
}

impl Place {
    /// Converts the place for notes and errors.
    pub(super) fn location(&self) -> Location {
        Location::line(&*self.source.0, self.line).column(self.column)
    }
}
