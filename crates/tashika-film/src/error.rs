//! The error type of all crates: a fault of the system, of the input, or of the caller.

mod nearest;

use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};

pub use nearest::nearest_name;

/// Result of functions that read or write files or check options.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Returns the text with an escape, as `\u{1b}`, for each control character, each line break, and
/// each character that changes the direction of writing.
///
/// Names from files and folders are untrusted. Without escapes they could move the cursor of a
/// terminal, colour the text after them, or look like lines of the program.
pub fn visible(text: &str) -> Cow<'_, str> {
    let is_hidden = |c: char| {
        c.is_control()
            || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(is_hidden) {
        return text.into();
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if is_hidden(c) {
            escaped.extend(c.escape_unicode());
        } else {
            escaped.push(c);
        }
    }
    escaped.into()
}

/// Formats a path for messages.
fn shown(path: &Path) -> String {
    visible(&path.to_string_lossy()).into_owned()
}

/// Place in the input.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Location {
    /// File as the user named it, or as another file refers to it; empty if only the item is known.
    pub file: PathBuf,
    /// Line, from 1, for text formats.
    pub line: Option<u32>,
    /// Column in that line, from 1, in characters.
    pub column: Option<u32>,
    /// Name of an item inside the file: `meshes[3].primitives[0]`, `newmtl floor`.
    pub item: Option<String>,
}

impl Location {
    /// A whole file, without a line or an item.
    pub fn file(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), line: None, column: None, item: None }
    }

    /// A line of a text file, counted from 1.
    pub fn line(file: impl Into<PathBuf>, line: u32) -> Self {
        Self { file: file.into(), line: Some(line), column: None, item: None }
    }

    /// Adds a column, counted from 1, to a line.
    #[must_use]
    pub fn column(mut self, column: u32) -> Self {
        self.column = Some(column);
        self
    }

    /// Adds the name of the item at this place.
    #[must_use]
    pub fn item(mut self, item: impl Into<String>) -> Self {
        self.item = Some(item.into());
        self
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&shown(&self.file))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        if let Some(item) = &self.item {
            let after = if self.file.as_os_str().is_empty() { "" } else { ": " };
            write!(f, "{after}{}", visible(item))?;
        }
        Ok(())
    }
}

/// All errors of the library. Messages have no line breaks except those between the files of
/// [`Error::Missing`], and names in them are [`visible`].
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system could not read or write a file.
    #[error("{}: {}", shown(path), visible(&source.to_string()))]
    Io {
        /// File that was to be read or written.
        path: PathBuf,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The input contains an invalid value.
    #[error("{at}: {}; expected {}", visible(found), visible(expected))]
    Invalid {
        /// Place of the value.
        at: Location,
        /// Field and value as found.
        found: String,
        /// Description of accepted values.
        expected: String,
    },
    /// The input is valid, but uses a feature that this program does not support.
    #[error("{at}: {} is not supported; {}", visible(what), visible(instead))]
    Unsupported {
        /// Place of the feature.
        at: Location,
        /// Name of the feature.
        what: String,
        /// Remedy for the user.
        instead: String,
    },
    /// The input refers to a file outside of its folder. Such files are not read unless the user
    /// permits it.
    #[error("{at}: {reference:?} is outside of the folder of the scene file; --allow-outside permits it")]
    Outside {
        /// Place of the reference.
        at: Location,
        /// The file as the input names it.
        reference: String,
    },
    /// The input refers to files that do not exist or must not be read.
    #[error(
        "{}: names files that cannot be had (--allow-missing goes on without them):{}",
        shown(scene),
        in_lines(files)
    )]
    Missing {
        /// The scene that refers to them.
        scene: PathBuf,
        /// One entry for each file: the place, the file, and its replacement.
        files: Vec<String>,
    },
    /// An option of the caller is out of range.
    #[error("{option} = {}; expected {}", visible(value), visible(expected))]
    Option {
        /// Name of the option as the caller writes it.
        option: String,
        /// Value as the caller gave it.
        value: String,
        /// Description of accepted values.
        expected: String,
    },
}

fn in_lines(all: &[String]) -> String {
    all.iter().map(|one| format!("\n  {}", visible(one))).collect()
}

impl Error {
    /// Returns the error of the system for a file at `path` that it could not read or write.
    pub fn io(path: impl Into<PathBuf>, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), source }
    }

    /// Returns the error of an input at `at` that contains `found` instead of `expected`.
    pub fn invalid(at: Location, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Invalid { at, found: found.into(), expected: expected.into() }
    }

    /// Returns the error of an input at `at` with an unknown name `found`, where `known` was
    /// probably meant.
    pub fn misspelt(at: Location, kind: &str, found: &str, known: &str) -> Self {
        Self::invalid(at, format!("{kind} {found:?}"), format!("a known name: did you mean {known:?}?"))
    }

    /// Returns the error of an input at `at` that uses the feature `what`; the user can do
    /// `instead`.
    pub fn unsupported(at: Location, what: impl Into<String>, instead: impl Into<String>) -> Self {
        Self::Unsupported { at, what: what.into(), instead: instead.into() }
    }

    /// Returns the error of an `option` of the caller that has an unusable `value`.
    pub fn option(option: impl Into<String>, value: impl fmt::Display, expected: impl Into<String>) -> Self {
        Self::Option { option: option.into(), value: value.to_string(), expected: expected.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_file_line_item_value_and_what_is_allowed() {
        let at = Location::line("box.mtl", 14).item("newmtl floor");
        let e = Error::invalid(at, "Ns = -3", "a number from 0 to 100000");
        assert_eq!(e.to_string(), "box.mtl:14: newmtl floor: Ns = -3; expected a number from 0 to 100000");
    }

    /// A name that would clear a terminal, continue in red on another line, and read backwards.
    /// Messages contain it with escapes only.
    #[test]
    fn names_in_messages_cannot_steer_a_terminal() {
        let name = "a\u{1b}[2J\n\u{9b}31merror: \u{202e}b";
        let escaped = r"a\u{1b}[2J\u{a}\u{9b}31merror: \u{202e}b";
        assert_eq!(visible(name), escaped);
        assert!(matches!(visible("wände 漢字 👁 \u{301}"), Cow::Borrowed(_)));
        let at = || Location::line(name, 1).item(name);
        let missing = Error::Missing { scene: name.into(), files: vec![name.to_owned(); 2] };
        for error in [
            Error::invalid(at(), name, name),
            Error::unsupported(at(), name, name),
            Error::option("o", name, name),
            Error::io(name, std::io::Error::other(name)),
            Error::Outside { at: at(), reference: name.to_owned() },
            missing,
        ] {
            let message = error.to_string();
            let is_hidden = |c: char| c != '\n' && visible(c.encode_utf8(&mut [0; 4])).len() > 4;
            assert!(!message.contains(is_hidden) && message.contains("error: "), "{message:?}");
            assert!(message.lines().count() == 1 || matches!(error, Error::Missing { .. }), "{message:?}");
        }
    }
}
