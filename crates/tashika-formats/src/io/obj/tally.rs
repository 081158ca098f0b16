//! Counts of notes about lines: a file of a million lines can give rise to a million notes.

use std::path::Path;

use super::features::FEATURES;
use crate::error::Location;
use crate::io::features::Feature;
use crate::scene::{NoteKind, Notes};

/// Subject of a note: a message, or a row of the features table.
#[derive(Clone, Copy, PartialEq)]
enum Told {
    Message(NoteKind, &'static str),
    Row(&'static Feature),
}

/// Counts of the notes about one file, without an allocation for each line.
#[derive(Default)]
pub(super) struct Tally(Vec<(Told, u32, u64)>);

impl Tally {
    /// Counts an occurrence of `message` on `line`.
    pub(super) fn add(&mut self, kind: NoteKind, message: &'static str, line: u32) {
        self.count(Told::Message(kind, message), line);
    }

    /// Counts a feature on `line`, if the table has a row for it.
    pub(super) fn met(&mut self, kind: &str, name: &str, line: u32) {
        if let Some(row) = Feature::find(FEATURES, kind, name) {
            self.count(Told::Row(row), line);
        }
    }

    fn count(&mut self, told: Told, line: u32) {
        match self.0.iter_mut().find(|entry| entry.0 == told) {
            Some(entry) => entry.2 += 1,
            None => self.0.push((told, line, 1)),
        }
    }

    /// Adds a note for each count.
    pub(super) fn report(self, file: &Path, notes: &mut Notes) {
        for (told, line, count) in self.0 {
            let at = Location::line(file, line);
            match told {
                Told::Message(kind, message) => notes.push_many(kind, message, at, count),
                // No row of this format refuses the file, so this cannot fail.
                Told::Row(row) => row.met_often(&at, count, notes).unwrap_or_default(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::features::Support;
    use crate::io::obj::features::STATEMENT;

    #[test]
    fn what_is_told_is_counted_from_its_first_line_and_nothing_is_refused() {
        let mut tally = Tally::default();
        for line in [4, 9, 11] {
            tally.add(NoteKind::Ignored, "lines", line);
        }
        for line in [5, 6] {
            tally.met(STATEMENT, "p", line);
        }
        tally.met(STATEMENT, "v", 1);
        tally.add(NoteKind::Ignored, "points", 10);
        let mut notes = Notes::default();
        tally.report(Path::new("a.obj"), &mut notes);
        let all: Vec<_> = notes.iter().map(|n| (n.message, n.first.line, n.count)).collect();
        let expected = [("lines", 4, 3), ("points", 10, 1), ("statement \"p\": points are left out", 5, 2)];
        assert_eq!(all, expected.map(|(message, line, count)| (message.to_owned(), Some(line), count)));
        assert!(FEATURES.iter().all(|row| row.support != Support::Refused));
    }
}
