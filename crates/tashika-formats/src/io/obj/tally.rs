//! Notes that many lines of a file give rise to.
//!
//! A file of a million lines can deserve a million notes, and a hostile one a million *different*
//! notes.
//! [`Tally`] counts the former without allocating; [`Named`] names at most so many of the latter and
//! counts the rest together.

use std::collections::BTreeSet;
use std::path::Path;

use crate::error::Location;
use crate::scene::{NoteKind, Notes};

/// Counts of fixed messages about lines of one file.
#[derive(Default)]
pub(super) struct Tally(Vec<(NoteKind, &'static str, u32, u64)>);

impl Tally {
    /// One more occurrence of `message`, on `line`.
    pub(super) fn add(&mut self, kind: NoteKind, message: &'static str, line: u32) {
        match self.0.iter_mut().find(|entry| entry.1 == message) {
            Some(entry) => entry.3 += 1,
            None => self.0.push((kind, message, line, 1)),
        }
    }

    /// Hands the counts over.
    pub(super) fn report(self, file: &Path, notes: &mut Notes) {
        for (kind, message, line, count) in self.0 {
            notes.push_many(kind, message, Location::line(file, line), count);
        }
    }
}

/// Notes whose messages contain names out of the file.
pub(super) struct Named {
    kind: NoteKind,
    limit: usize,
    rest: &'static str,
    messages: BTreeSet<String>,
}

impl Named {
    /// At most `limit` different messages; further ones become the message `rest`.
    pub(super) fn new(kind: NoteKind, limit: usize, rest: &'static str) -> Self {
        Self { kind, limit, rest, messages: BTreeSet::new() }
    }

    /// One more occurrence of `message`.
    pub(super) fn add(&mut self, message: String, at: Location, notes: &mut Notes) {
        self.add_as(self.kind, message, at, notes);
    }

    /// The same as a note of another kind.
    pub(super) fn add_as(&mut self, kind: NoteKind, message: String, at: Location, notes: &mut Notes) {
        if self.messages.contains(&message) {
            notes.push(kind, message, at);
        } else if self.messages.len() < self.limit {
            self.messages.insert(message.clone());
            notes.push(kind, message, at);
        } else {
            notes.push(kind, self.rest, at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_messages_are_counted_from_their_first_line() {
        let mut tally = Tally::default();
        for line in [4, 9, 11] {
            tally.add(NoteKind::Ignored, "lines", line);
        }
        tally.add(NoteKind::Ignored, "points", 10);
        let mut notes = Notes::default();
        tally.report(Path::new("a.obj"), &mut notes);
        let all: Vec<_> = notes.iter().map(|n| (n.message, n.first.line, n.count)).collect();
        assert_eq!(all, [("lines".to_owned(), Some(4), 3), ("points".to_owned(), Some(10), 1)]);
    }

    #[test]
    fn different_messages_are_limited() {
        let mut named = Named::new(NoteKind::Ignored, 2, "more");
        let mut notes = Notes::default();
        for message in ["a", "b", "c", "a", "d"] {
            named.add(message.to_owned(), Location::file("x"), &mut notes);
        }
        let all: Vec<_> = notes.iter().map(|n| (n.message, n.count)).collect();
        assert_eq!(all, [("a".to_owned(), 2), ("b".to_owned(), 1), ("more".to_owned(), 2)]);
    }
}
