//! What the program did with input that it could not take as it is.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::error::{Location, visible};

/// How the picture may differ from what the file's author saw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NoteKind {
    /// A file that the scene names is not there.
    Missing,
    /// Damaged data was removed or replaced.
    Repaired,
    /// A feature was replaced by the nearest that exists here.
    Approximated,
    /// A feature was left out.
    Ignored,
    /// The file does not say; a sensible value was chosen.
    Defaulted,
}

/// One thing worth telling, however often it occurred.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// How the picture may differ.
    pub kind: NoteKind,
    /// What it is about, with what was done instead.
    pub message: String,
    /// Where it was met first.
    pub first: Location,
    /// How often.
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

    /// Whether there is nothing to tell.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The first note that says that something of the file is not in the picture as it was meant:
    /// anything but a default.
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
