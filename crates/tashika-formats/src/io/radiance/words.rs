//! Words and primitives of a file.
//!
//! ```text
//! file       = { comment | command | alias | primitive }
//! primitive  = modifier type identifier  n string…  n integer…  n real…
//! alias      = modifier "alias" identifier reference
//! command    = "!" text to the end of the line; a "\" at the end of a line continues it
//! ```
//!
//! Words are separated by white space; quotation marks, single or double, hold a word together. A
//! `#` begins a comment between primitives and where a number is expected.
//!
//! # Guarantee
//! Memory is proportional to the text: a count of arguments allocates nothing.
//!
//! Source: the Radiance reference manual, "Scene Description". Held to this by `radiance::tests`.

use std::path::Path;

use super::definitions::check_type;
use crate::error::{Error, Location, Result};
use crate::io::notes::quoted;

/// A primitive, as it is written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Primitive {
    pub(super) modifier: String,
    pub(super) kind: String,
    pub(super) name: String,
    pub(super) strings: Vec<String>,
    pub(super) reals: Vec<f64>,
    /// Line in which the modifier of the primitive stands.
    pub(super) line: u32,
}

/// An item of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Statement {
    Primitive(Primitive),
    Alias { modifier: String, name: String, reference: String, line: u32 },
    Command { text: String, line: u32 },
}

/// Reads the statements of `text`; `file` is for messages.
///
/// # Errors
/// [`Error::Invalid`] with the line for types that do not exist, for counts and numbers that are
/// none, and for a primitive that the end of the file cuts off.
pub(super) fn parse(text: &str, file: &Path) -> Result<Vec<Statement>> {
    let mut reader = Reader { text, line: 1, file };
    let mut statements = Vec::new();
    loop {
        reader.skip_blank_and_comments();
        let line = reader.line;
        if reader.text.is_empty() {
            return Ok(statements);
        }
        if reader.text.starts_with('!') {
            statements.push(Statement::Command { text: reader.command(), line });
            continue;
        }
        let modifier = reader.word("a modifier", line)?;
        let kind = reader.word("the type of a primitive", line)?;
        let name = reader.word("an identifier", line)?;
        if kind == "alias" {
            let reference = reader.word("the name that an alias stands for", line)?;
            statements.push(Statement::Alias { modifier, name, reference, line });
            continue;
        }
        check_type(&kind, &name, Location::line(file, line))?;
        let (strings, reals) = reader.arguments(&kind, line)?;
        statements.push(Statement::Primitive(Primitive { modifier, kind, name, strings, reals, line }));
    }
}

/// Reads numbers that are separated by white space, with comments between them, to the end of the
/// text.
///
/// # Errors
/// As [`parse`], for a word that is no number.
pub(super) fn numbers(text: &str, file: &Path) -> Result<Vec<f64>> {
    let mut reader = Reader { text, line: 1, file };
    let mut all = Vec::new();
    loop {
        reader.skip_blank_and_comments();
        if reader.text.is_empty() {
            return Ok(all);
        }
        all.push(reader.real("a number", 1)?);
    }
}

struct Reader<'t> {
    /// Text that is not read.
    text: &'t str,
    line: u32,
    file: &'t Path,
}

impl<'t> Reader<'t> {
    fn take(&mut self, bytes: usize) -> &'t str {
        let (taken, rest) = self.text.split_at(bytes);
        self.line += taken.bytes().filter(|b| *b == b'\n').count() as u32;
        self.text = rest;
        taken
    }

    fn skip_blank(&mut self) {
        let blank = self.text.len() - self.text.trim_start().len();
        self.take(blank);
    }

    fn skip_blank_and_comments(&mut self) {
        self.skip_blank();
        while self.text.starts_with('#') {
            self.take(self.text.find('\n').unwrap_or(self.text.len()));
            self.skip_blank();
        }
    }

    /// Text of a command without its `!`, with continued lines joined.
    fn command(&mut self) -> String {
        let mut text = String::new();
        self.take(1);
        loop {
            let end = self.text.find('\n').unwrap_or(self.text.len());
            let part = self.take(end).trim_end_matches('\r');
            match part.strip_suffix('\\') {
                Some(part) if !self.text.is_empty() => {
                    text.push_str(part);
                    text.push(' ');
                    self.take(1);
                }
                _ => {
                    text.push_str(part);
                    return text;
                }
            }
        }
    }

    /// The next word; `first` is the line of the primitive.
    fn word(&mut self, expected: &str, first: u32) -> Result<String> {
        self.skip_blank();
        let Some(mark) = self.text.chars().next() else {
            let at = Location::line(self.file, self.line);
            let found = format!("the end of the file in the primitive of line {first}");
            return Err(Error::invalid(at, found, expected));
        };
        if mark == '"' || mark == '\'' {
            let Some(end) = self.text[1..].find(mark) else {
                let at = Location::line(self.file, self.line);
                return Err(Error::invalid(at, "a quotation mark", "a second one that ends the word"));
            };
            let word = self.text[1..=end].to_owned();
            self.take(end + 2);
            return Ok(word);
        }
        let end = self.text.find(char::is_whitespace).unwrap_or(self.text.len());
        Ok(self.take(end).to_owned())
    }

    fn number(&mut self, expected: &str, first: u32) -> Result<(String, Location)> {
        self.skip_blank_and_comments();
        let at = Location::line(self.file, self.line);
        Ok((self.word(expected, first)?, at))
    }

    fn count(&mut self, expected: &str, first: u32) -> Result<usize> {
        let (word, at) = self.number(expected, first)?;
        word.parse().map_err(|_| Error::invalid(at, quoted(&word), expected))
    }

    fn real(&mut self, expected: &str, first: u32) -> Result<f64> {
        let (word, at) = self.number(expected, first)?;
        // The words "inf" and "nan" are numbers of Rust, but not of the format.
        let number = word.parse::<f64>().ok().filter(|value| value.is_finite());
        number.ok_or_else(|| Error::invalid(at, quoted(&word), expected))
    }

    fn arguments(&mut self, kind: &str, first: u32) -> Result<(Vec<String>, Vec<f64>)> {
        let (mut strings, mut reals) = (Vec::new(), Vec::new());
        for _ in 0..self.count(&format!("the number of strings of a {kind}"), first)? {
            strings.push(self.word(&format!("a string of a {kind}"), first)?);
        }
        for _ in 0..self.count(&format!("the number of integers of a {kind}"), first)? {
            self.real(&format!("an integer of a {kind}"), first)?;
        }
        for _ in 0..self.count(&format!("the number of real arguments of a {kind}"), first)? {
            reals.push(self.real(&format!("a real argument of a {kind}"), first)?);
        }
        Ok((strings, reals))
    }
}
