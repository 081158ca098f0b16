//! Tokens of pbrt's text: words, strings and brackets, with their lines and columns.
//!
//! Blanks separate tokens, `#` begins a comment that ends with its line, strings stand between
//! double quotes and do not cross a line's end. Tokens borrow from the text, without allocation.
//!
//! Source: the format descriptions of pbrt-v3 and pbrt-v4 (Pharr et al. 2023, appendix C). Tested
//! by the tests below.

use crate::error::{Error, Result};
use crate::io::notes::excerpt;
use crate::io::text::utf8_or_latin1;

use super::place::{Place, Source};

/// The smallest parts of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Token<'a> {
    /// A directive, a number, or `true` and `false`.
    Word(&'a [u8]),
    /// Text between two quotation marks, escapes included.
    Quoted(&'a [u8]),
    /// `[`
    Open,
    /// `]`
    Close,
}

impl Token<'_> {
    /// Text of the token in errors.
    pub(super) fn shown(&self) -> String {
        const LONGEST: usize = 40;
        match self {
            Self::Word(bytes) => format!("{:?}", excerpt(&utf8_or_latin1(bytes), LONGEST)),
            Self::Quoted(bytes) => format!("the string {:?}", excerpt(&utf8_or_latin1(bytes), LONGEST)),
            Self::Open => "\"[\"".to_owned(),
            Self::Close => "\"]\"".to_owned(),
        }
    }
}

/// Reads tokens one after another.
pub(super) struct Lexer<'a> {
    source: Source,
    bytes: &'a [u8],
    next: usize,
    line: u32,
    line_start: usize,
    /// Line of the last token, and offset in it.
    token: (u32, usize),
}

impl<'a> Lexer<'a> {
    /// Lexer at the start of a file's text.
    pub(super) fn new(bytes: &'a [u8], source: Source) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { source, bytes, next: 0, line: 1, line_start: 0, token: (1, 0) }
    }

    /// Place where the last token begins.
    pub(super) fn place(&self) -> Place {
        let (line, column) = self.token;
        let column = u32::try_from(column).map_or(u32::MAX, |c| c.saturating_add(1));
        Place { source: self.source.clone(), line, column }
    }

    /// Reads the next token; none at the end.
    pub(super) fn next(&mut self) -> Result<Option<Token<'a>>> {
        self.skip_blanks();
        let bytes = self.bytes;
        let start = self.next;
        self.token = (self.line, start - self.line_start);
        let Some(&first) = bytes.get(start) else { return Ok(None) };
        let token = match first {
            b'[' => Token::Open,
            b']' => Token::Close,
            b'"' => return self.quoted().map(Some),
            _ => {
                let length = bytes[start..].iter().position(|&b| ends_word(b)).unwrap_or(bytes.len() - start);
                self.next = start + length;
                return Ok(Some(Token::Word(&bytes[start..self.next])));
            }
        };
        self.next = start + 1;
        Ok(Some(token))
    }

    /// Returns the first byte of the next token: it distinguishes a string, a list, and a word.
    pub(super) fn peek(&mut self) -> Option<u8> {
        self.skip_blanks();
        self.bytes.get(self.next).copied()
    }

    fn skip_blanks(&mut self) {
        while let Some(&byte) = self.bytes.get(self.next) {
            match byte {
                b'\n' => {
                    self.next += 1;
                    self.line = self.line.saturating_add(1);
                    self.line_start = self.next;
                }
                b' ' | b'\t' | b'\r' | 0x0b | 0x0c => self.next += 1,
                b'#' => {
                    let rest = &self.bytes[self.next..];
                    self.next += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                }
                _ => break,
            }
        }
    }

    fn quoted(&mut self) -> Result<Token<'a>> {
        let start = self.next + 1;
        let mut end = start;
        loop {
            match self.bytes.get(end) {
                Some(b'"') => break,
                Some(b'\\') if self.bytes.get(end + 1).is_some_and(|&b| b != b'\n') => end += 2,
                Some(b'\n') | None => {
                    let begun = Token::Quoted(&self.bytes[start..end.min(self.bytes.len())]);
                    let found = format!("{} without end", begun.shown());
                    return Err(Error::invalid(
                        self.place().location(),
                        found,
                        "a quotation mark on its line",
                    ));
                }
                Some(_) => end += 1,
            }
        }
        self.next = end + 1;
        Ok(Token::Quoted(&self.bytes[start..end]))
    }
}

fn ends_word(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | b'"' | b'[' | b']' | b'#')
}

/// Value of a string, with its escapes resolved. A `\` that begins no escape stands for itself, as
/// in paths.
pub(super) fn unescape(bytes: &[u8]) -> String {
    let raw = utf8_or_latin1(bytes);
    if !raw.contains('\\') {
        return raw.into_owned();
    }
    let mut value = String::with_capacity(raw.len());
    let mut characters = raw.chars();
    while let Some(c) = characters.next() {
        if c != '\\' {
            value.push(c);
            continue;
        }
        match characters.next() {
            Some('n') => value.push('\n'),
            Some('t') => value.push('\t'),
            Some('r') => value.push('\r'),
            Some('b') => value.push('\u{8}'),
            Some('f') => value.push('\u{c}'),
            Some(same @ ('\\' | '"' | '\'')) => value.push(same),
            Some(other) => value.extend(['\\', other]),
            None => value.push('\\'),
        }
    }
    value
}

/// Parses a finite number; words that spell one, such as `nan`, are refused.
pub(super) fn number(word: &[u8]) -> Option<f32> {
    if !matches!(word.first()?, b'0'..=b'9' | b'+' | b'-' | b'.') {
        return None;
    }
    let value: f32 = std::str::from_utf8(word).ok()?.parse().ok()?;
    value.is_finite().then_some(value)
}

/// Parses a finite number in double precision; numbers beyond the range of single precision are
/// refused.
pub(super) fn wide_number(word: &[u8]) -> Option<f64> {
    number(word)?;
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Parses a whole number; a fraction is cut off, as in pbrt-v3.
pub(super) fn integer(word: &[u8]) -> Option<i32> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    number(word)?;
    let value: f64 = text.parse().ok()?;
    (value.abs() <= f64::from(i32::MAX)).then_some(value as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<(String, u32, u32)> {
        let mut lexer = Lexer::new(text.as_bytes(), Source::new("a.pbrt".as_ref()));
        let mut all = Vec::new();
        while let Some(token) = lexer.next().unwrap() {
            let place = lexer.place();
            all.push((token.shown(), place.line, place.column));
        }
        all
    }

    #[test]
    fn tokens_are_found_with_line_and_column() {
        let found = tokens("\u{feff}Shape\"a b\"[1 -2.5]# [comment\n\r\n  \"float x\" 3#end");
        let expected = [
            ("\"Shape\"", 1, 1),
            ("the string \"a b\"", 1, 6),
            ("\"[\"", 1, 11),
            ("\"1\"", 1, 12),
            ("\"-2.5\"", 1, 14),
            ("\"]\"", 1, 18),
            ("the string \"float x\"", 3, 3),
            ("\"3\"", 3, 13),
        ];
        assert_eq!(found, expected.map(|(s, line, column)| (s.to_owned(), line, column)));
    }

    #[test]
    fn strings_end_on_their_line_and_escapes_are_resolved() {
        for open in ["a\n \"abc", "a\n \"abc\ndef\"", "a\n \"abc\\\"", "a\n \"abc\\"] {
            let mut lexer = Lexer::new(open.as_bytes(), Source::new("a.pbrt".as_ref()));
            assert!(lexer.next().unwrap().is_some());
            let error = lexer.next().unwrap_err().to_string();
            assert!(error.starts_with("a.pbrt:2:2: the string "), "{error}");
        }
        assert_eq!(unescape(br#"a\"b\\c\nd\te\qf"#), "a\"b\\c\nd\te\\qf");
        assert_eq!(unescape(b"W\xe4nde\\"), "Wände\\");
    }

    #[test]
    fn numbers_are_finite_and_integers_whole() {
        for (word, value) in [("1.", 1.0), (".5", 0.5), ("+1", 1.0), ("-8e-1", -0.8), ("1e+006", 1e6)] {
            assert_eq!(number(word.as_bytes()), Some(value), "{word}");
        }
        for word in ["nan", "inf", "-inf", "1e99", "", "-", "true", "0x10", "1.5f", "1,5"] {
            assert_eq!(number(word.as_bytes()), None, "{word}");
        }
        for (word, value) in
            [("16777217", Some(16_777_217)), ("-3", Some(-3)), ("2.9", Some(2)), ("3e9", None)]
        {
            assert_eq!(integer(word.as_bytes()), value, "{word}");
        }
    }
}
