//! Names from files in notes and errors.
//!
//! Held to this by the tests below.

use std::collections::BTreeSet;

use crate::error::Location;
use crate::scene::{NoteKind, Notes};

/// Longest name that [`shown`] and [`quoted`] repeat (characters); chosen.
const LONGEST: usize = 80;

/// At most `longest` characters of a name from a file.
pub(super) fn excerpt(name: &str, longest: usize) -> String {
    match name.char_indices().nth(longest) {
        Some((end, _)) => format!("{}…", &name[..end]),
        None => name.to_owned(),
    }
}

/// A name from a file, fit for messages: without control characters, and not too long.
pub(super) fn shown(name: &str) -> String {
    excerpt(name, LONGEST).replace(char::is_control, "\u{fffd}")
}

/// A name from a file between quotation marks, with escapes for invisible characters.
pub(super) fn quoted(name: &str) -> String {
    format!("{:?}", excerpt(name, LONGEST))
}

/// Notes whose messages contain names from a file. Their number is limited, because a hostile file
/// may have millions of names.
pub(super) struct Named {
    limit: usize,
    messages: BTreeSet<String>,
}

impl Named {
    /// Permits `limit` different messages.
    pub(super) fn new(limit: usize) -> Self {
        Self { limit, messages: BTreeSet::new() }
    }

    /// Adds a note of `message`; beyond the limit of different messages, a note of `rest` instead.
    pub(super) fn add(
        &mut self,
        kind: NoteKind,
        message: String,
        rest: &str,
        at: Location,
        notes: &mut Notes,
    ) {
        if self.messages.contains(&message) {
            notes.push(kind, message, at);
        } else if self.messages.len() < self.limit {
            self.messages.insert(message.clone());
            notes.push(kind, message, at);
        } else {
            notes.push(kind, rest, at);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_messages_are_short_and_visible() {
        assert_eq!((excerpt("wände", 5), excerpt("wände", 2)), ("wände".to_owned(), "wä…".to_owned()));
        assert_eq!(shown("a\u{7}b\n"), "a\u{fffd}b\u{fffd}");
        assert_eq!(quoted("a\u{7}b\n"), r#""a\u{7}b\n""#);
        assert_eq!(shown(&"é".repeat(81)), format!("{}…", "é".repeat(80)));
        assert_eq!(shown(&"é".repeat(80)), "é".repeat(80));
    }

    #[test]
    fn different_messages_are_limited() {
        let mut named = Named::new(2);
        let mut notes = Notes::default();
        for message in ["a", "b", "c", "a", "d"] {
            named.add(NoteKind::Ignored, message.to_owned(), "more", Location::file("x"), &mut notes);
        }
        let all: Vec<_> = notes.iter().map(|n| (n.message, n.count)).collect();
        assert_eq!(all, [("a".to_owned(), 2), ("b".to_owned(), 1), ("more".to_owned(), 2)]);
    }
}
