//! Position in a text, and its smallest parts.

use std::path::Path;

use crate::error::{Error, Location, Result};
use crate::io::notes::quoted;
use crate::io::text::utf8_or_latin1;

/// A position in a text. Blanks and comments after a token are skipped together with the token.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u32,
    name: &'a Path,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8], name: &'a Path) -> Self {
        Self { bytes, at: 0, line: 1, name }
    }

    /// Number of the current line, from 1.
    pub(super) fn line(&self) -> u32 {
        self.line
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    /// The next byte.
    pub(super) fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// An error at the current line.
    pub(super) fn invalid(&self, found: &str, expected: &str) -> Error {
        Error::invalid(Location::line(self.name, self.line), found, expected)
    }

    /// Text at the position, for messages.
    fn found(&self) -> String {
        match self.bytes.get(self.at..) {
            None | Some([]) => "the end of the file".to_owned(),
            Some(rest) => {
                let rest = &rest[..rest.len().min(20)];
                let end = rest.iter().position(|b| b.is_ascii_whitespace()).unwrap_or(rest.len());
                quoted(&utf8_or_latin1(&rest[..end.max(1)]))
            }
        }
    }

    /// Skips blanks and comments.
    pub(super) fn skip_blank(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' => {
                    self.line = self.line.saturating_add(1);
                    self.at += 1;
                }
                byte if byte.is_ascii_whitespace() => self.at += 1,
                b'#' => self.skip_line(),
                b'/' if self.bytes.get(self.at + 1) == Some(&b'/') => self.skip_line(),
                b'/' if self.bytes.get(self.at + 1) == Some(&b'*') => {
                    self.at += 2;
                    while self.at < self.bytes.len() && !self.bytes[self.at..].starts_with(b"*/") {
                        self.line += u32::from(self.bytes[self.at] == b'\n');
                        self.at += 1;
                    }
                    self.at = (self.at + 2).min(self.bytes.len());
                }
                _ => return,
            }
        }
    }

    fn skip_line(&mut self) {
        while self.at < self.bytes.len() && self.bytes[self.at] != b'\n' {
            self.at += 1;
        }
    }

    /// Consumes `byte` and the blanks after it, if it is the next byte; returns true if it is.
    pub(super) fn eat(&mut self, byte: u8) -> bool {
        let is_there = self.eat_at_once(byte);
        if is_there {
            self.skip_blank();
        }
        is_there
    }

    /// Consumes `byte` without the blanks after it, if it is the next byte; returns true if it is.
    pub(super) fn eat_at_once(&mut self, byte: u8) -> bool {
        let is_there = self.peek() == Some(byte);
        self.at += usize::from(is_there);
        is_there
    }

    /// Consumes `byte` and the blanks after it; any other next byte is an error.
    pub(super) fn expect(&mut self, byte: u8) -> Result<()> {
        if self.eat(byte) {
            return Ok(());
        }
        Err(self.invalid(&self.found(), &format!("{:?}", char::from(byte))))
    }

    /// Parses a name, which may contain colons; a dot ends it.
    pub(super) fn word(&mut self, expected: &str) -> Result<&'a str> {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let is_part = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'_' | b':') || *b >= 0x80;
        let end = rest.iter().position(|b| !is_part(b)).unwrap_or(rest.len());
        match std::str::from_utf8(&rest[..end]) {
            Ok(word) if end > 0 => {
                self.at += end;
                if self.peek() != Some(b'.') {
                    self.skip_blank();
                }
                Ok(word)
            }
            _ => Err(self.invalid(&self.found(), expected)),
        }
    }

    pub(super) fn number(&mut self) -> Result<f64> {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let is_part = |b: &u8| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.');
        let end = rest.iter().position(|b| !is_part(b)).unwrap_or(rest.len());
        let word = std::str::from_utf8(&rest[..end]).unwrap_or_default();
        let number = match word {
            "true" | "True" => Some(1.0),
            "false" | "False" => Some(0.0),
            word => word.parse().ok(),
        };
        let number = number.ok_or_else(|| self.invalid(&self.found(), "a number"))?;
        self.at += end;
        self.skip_blank();
        Ok(number)
    }

    /// Parses a string between one or three quotation marks of either kind.
    pub(super) fn string(&mut self) -> Result<String> {
        let Some(mark @ (b'"' | b'\'')) = self.peek() else {
            return Err(self.invalid(&self.found(), "a string"));
        };
        let first = self.line;
        let long = self.bytes[self.at..].starts_with(&[mark; 3]);
        self.at += if long { 3 } else { 1 };
        let mut text = Vec::new();
        loop {
            let rest = &self.bytes[self.at..];
            match rest {
                [] => return Err(self.unended(first, "a string")),
                [b'\n', ..] if !long => return Err(self.unended(first, "a string")),
                [b'\\', escaped, ..] => {
                    let escaped = *escaped;
                    self.line += u32::from(escaped == b'\n');
                    text.push(match escaped {
                        b'n' => b'\n',
                        b't' => b'\t',
                        b'r' => b'\r',
                        other => other,
                    });
                    self.at += 2;
                }
                _ if !long && rest[0] == mark => {
                    self.at += 1;
                    break;
                }
                _ if long && rest.starts_with(&[mark; 3]) => {
                    self.at += 3;
                    break;
                }
                [byte, ..] => {
                    self.line += u32::from(*byte == b'\n');
                    text.push(*byte);
                    self.at += 1;
                }
            }
        }
        self.skip_blank();
        Ok(utf8_or_latin1(&text).into_owned())
    }

    fn unended(&self, first: u32, what: &str) -> Error {
        Error::invalid(Location::line(self.name, first), format!("{what} without end"), "its end")
    }

    /// The name of a file between `@` or `@@@`.
    pub(super) fn asset(&mut self) -> Result<String> {
        let mark: &[u8] = if self.bytes[self.at..].starts_with(b"@@@") { b"@@@" } else { b"@" };
        self.expect_bytes(mark)?;
        self.until(mark, "the name of a file")
    }

    /// Text between `<` and `>`.
    pub(super) fn path(&mut self) -> Result<&'a str> {
        self.expect_bytes(b"<")?;
        let start = self.at;
        self.until(b">", "a path")?;
        let end = start + self.bytes[start..].iter().position(|&b| b == b'>').unwrap_or(0);
        std::str::from_utf8(&self.bytes[start..end])
            .map_err(|_| self.invalid("a path that is not UTF-8", "names"))
    }

    fn expect_bytes(&mut self, mark: &[u8]) -> Result<()> {
        if self.bytes[self.at.min(self.bytes.len())..].starts_with(mark) {
            self.at += mark.len();
            return Ok(());
        }
        Err(self.invalid(&self.found(), &quoted(&utf8_or_latin1(mark))))
    }

    /// Text up to the mark, which must be on the same line.
    fn until(&mut self, mark: &[u8], what: &str) -> Result<String> {
        let start = self.at;
        while !self.bytes[self.at..].starts_with(mark) {
            if self.at >= self.bytes.len() || self.bytes[self.at] == b'\n' {
                return Err(self.unended(self.line, what));
            }
            self.at += 1;
        }
        let text = utf8_or_latin1(&self.bytes[start..self.at]).into_owned();
        self.at += mark.len();
        self.skip_blank();
        Ok(text)
    }

    /// Skips the text in braces.
    pub(super) fn skip_block(&mut self) -> Result<()> {
        let first = self.line;
        self.expect(b'{')?;
        let mut open = 1_u64;
        while open > 0 {
            match self.peek() {
                None => return Err(self.unended(first, "a dictionary")),
                Some(b'{') => open += 1,
                Some(b'}') => open -= 1,
                Some(b'"' | b'\'') => {
                    self.string()?;
                    continue;
                }
                Some(b'@') => {
                    self.asset()?;
                    continue;
                }
                Some(_) => {}
            }
            self.at += 1;
            self.skip_blank();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cursor(text: &str) -> Cursor<'_> {
        let mut cursor = Cursor::new(text.as_bytes(), Path::new("a.usda"));
        cursor.skip_blank();
        cursor
    }

    #[test]
    fn comments_of_three_kinds_are_blank_and_lines_are_counted() {
        let mut c = cursor("# one\n// two\n/* three\n four */ word");
        assert_eq!((c.line(), c.word("a word").unwrap()), (4, "word"));
        assert!(c.is_at_end());
    }

    #[test]
    fn strings_names_of_files_and_paths_end_where_they_began() {
        let mut c = cursor("\"a\\\"b\" '''c\n'd''' @x@ @@@y@z@@@ </A/B.c> {a = {\"}\" @}@}} -1.5e3 inf");
        assert_eq!(c.string().unwrap(), "a\"b");
        assert_eq!(c.string().unwrap(), "c\n'd");
        assert_eq!((c.asset().unwrap(), c.asset().unwrap()), ("x".into(), "y@z".into()));
        assert_eq!(c.path().unwrap(), "/A/B.c");
        c.skip_block().unwrap();
        assert_eq!((c.number().unwrap(), c.number().unwrap(), c.line()), (-1500.0, f64::INFINITY, 2));
        for text in ["\"a", "@a", "{", "<a", "\"a\n\"", "@a\n@"] {
            let mut c = cursor(text);
            let read = match text.as_bytes()[0] {
                b'"' => c.string().map(drop),
                b'@' => c.asset().map(drop),
                b'<' => c.path().map(drop),
                _ => c.skip_block(),
            };
            assert!(read.unwrap_err().to_string().starts_with("a.usda:1: "), "{text}");
        }
    }
}
