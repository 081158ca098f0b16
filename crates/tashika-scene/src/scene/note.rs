//! Notes of input that is missing, repaired, approximated, ignored or replaced by a default.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::error::{Location, visible};

/// Kind of difference between the image and the one that the file's author intended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NoteKind {
    /// A file that the scene names does not exist.
    Missing,
    /// Damaged data was removed or replaced.
    Repaired,
    /// A feature was replaced by the nearest one that this renderer supports.
    Approximated,
    /// A feature was omitted.
    Ignored,
    /// The file specifies no value; a default was chosen.
    Defaulted,
}

/// Report that input of one kind was treated in some way, with the number of occurrences.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Kind of difference in the image.
    pub kind: NoteKind,
    /// Description of the input and of its treatment.
    pub message: String,
    /// Location of the first occurrence.
    pub first: Location,
    /// Number of occurrences.
    pub count: u64,
}

/// Notes, merged by kind and message.
#[derive(Clone, Debug, Default)]
pub struct Notes(BTreeMap<(NoteKind, String), (Location, u64)>);

impl Notes {
    /// Adds one occurrence.
    pub fn push(&mut self, kind: NoteKind, message: impl Into<String>, at: Location) {
        self.push_many(kind, message, at, 1);
    }

    /// Adds `count` occurrences of a note, unless `count` is zero. Names in the message are made
    /// [`visible`].
    pub fn push_many(&mut self, kind: NoteKind, message: impl Into<String>, at: Location, count: u64) {
        if count > 0 {
            let message = message.into();
            let message = match visible(&message) {
                Cow::Borrowed(_) => message,
                Cow::Owned(escaped) => escaped,
            };
            self.0.entry((kind, message)).or_insert((at, 0)).1 += count;
        }
    }

    /// All notes, by kind and message.
    pub fn iter(&self) -> impl Iterator<Item = Note> + '_ {
        self.0.iter().map(|((kind, message), (first, count))| Note {
            kind: *kind,
            message: message.clone(),
            first: first.clone(),
            count: *count,
        })
    }

    /// Returns true if there are no notes.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the first note of an intended feature that the image lacks or alters: any kind
    /// except a default.
    pub fn first_departure(&self) -> Option<Note> {
        self.iter().find(|n| n.kind != NoteKind::Defaulted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_notes_are_counted_and_the_first_place_is_kept() {
        let mut notes = Notes::default();
        notes.push(NoteKind::Ignored, "line elements", Location::line("a.obj", 3));
        notes.push(NoteKind::Ignored, "line elements", Location::line("a.obj", 9));
        notes.push_many(NoteKind::Repaired, "nothing", Location::file("a.obj"), 0);
        let all: Vec<Note> = notes.iter().collect();
        assert_eq!(all.len(), 1);
        assert_eq!((all[0].count, all[0].first.line), (2, Some(3)));
        assert!(notes.first_departure().is_some());
        notes.push(NoteKind::Missing, "image a\u{1b}[2J", Location::file("a.obj"));
        assert_eq!(notes.first_departure().unwrap().message, r"image a\u{1b}[2J");
    }
}
