//! Places in the text of a scene.
//!
//! A [`Place`] is small and becomes a [`Location`] when something is told about it.

use std::path::Path;
use std::sync::Arc;

use crate::error::Location;

/// A file of the scene, by the name that messages give it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Source(Arc<Path>);

impl Source {
    /// A file by its name.
    pub(super) fn new(file: &Path) -> Self {
        Self(file.into())
    }
}

/// A token's place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// The file.
    pub(super) source: Source,
    /// Line, from 1.
    pub(super) line: u32,
    /// Column, from 1, in bytes.
    pub(super) column: u32,
}

impl Place {
    /// The same place, for notes and errors.
    pub(super) fn location(&self) -> Location {
        Location::line(&*self.source.0, self.line).column(self.column)
    }
}
