//! Lines, words and numbers of OBJ and MTL files.
//!
//! Both formats are lines of blank-separated words, the first of which is a keyword. A `\` at the
//! end of a line joins the next one to it; lines end in LF, CR LF or CR. Text is UTF-8, or UTF-16
//! with a byte order mark; text that is not valid UTF-8 is read as Latin-1, so that names do not
//! depend on the exporter's encoding. A NUL byte means that the file is not text at all.
//!
//! Nothing is allocated beyond the text itself. Tested by the tests below and `suite::obj`.

use std::borrow::Cow;
use std::path::Path;

use crate::error::{Error, Location, Result};
use crate::io::notes;
use crate::io::text::{decoded, utf8_or_latin1};

/// The text of a file as bytes in which every keyword and number is ASCII.
///
/// # Errors
/// [`Error::Invalid`] with the line of the first NUL byte.
pub(super) fn decode<'a>(bytes: &'a [u8], file: &Path) -> Result<Cow<'a, [u8]>> {
    let text = decoded(bytes);
    if let Some(position) = text.iter().position(|&b| b == 0) {
        let line = 1 + text[..position].iter().filter(|&&b| b == b'\n').count();
        return Err(Error::invalid(
            Location::line(file, u32::try_from(line).unwrap_or(u32::MAX)),
            "a NUL byte: this is not a text file",
            "text in UTF-8, Latin-1, or UTF-16 with a byte order mark",
        ));
    }
    Ok(text)
}

/// Iterator over logical lines: a line that ends in `\` is joined with the next.
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    /// Number of the next physical line, from 1.
    next: u32,
    joined: Vec<u8>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self { rest: text, next: 1, joined: Vec::new() }
    }

    /// Returns the next line without blanks around it, and the number of its first physical line,
    /// from 1.
    pub(super) fn next(&mut self) -> Option<(u32, &[u8])> {
        let number = self.next;
        let mut line = self.physical()?;
        // A comment may end in a path separator; the next line does not belong to it.
        if line.last() != Some(&b'\\') || trim(line).first() == Some(&b'#') {
            return Some((number, trim(line)));
        }
        self.joined.clear();
        while let [start @ .., b'\\'] = line {
            self.joined.extend_from_slice(start);
            self.joined.push(b' ');
            line = self.physical().unwrap_or_default();
        }
        self.joined.extend_from_slice(line);
        Some((number, trim(&self.joined)))
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.next = self.next.saturating_add(1);
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = match rest {
            [b'\r', b'\n', after @ ..] | [_, after @ ..] => after,
            [] => rest,
        };
        Some(line)
    }
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c)
}

/// `text` without blanks at either end.
pub(super) fn trim(text: &[u8]) -> &[u8] {
    let start = text.iter().position(|&b| !is_blank(b)).unwrap_or(text.len());
    let end = text.iter().rposition(|&b| !is_blank(b)).map_or(start, |last| last + 1);
    &text[start..end]
}

/// Splits a trimmed line into its first word and the text after the following blanks.
pub(super) fn split_keyword(line: &[u8]) -> (&[u8], &[u8]) {
    let end = line.iter().position(|&b| is_blank(b)).unwrap_or(line.len());
    let (keyword, rest) = line.split_at(end);
    (keyword, trim(rest))
}

/// Returns the words of a text, separated by blanks.
pub(super) fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|&b| is_blank(b)).filter(|word| !word.is_empty())
}

/// Words up to a comment. Only for statements of numbers: names may contain `#`.
pub(super) fn values(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    words(text).take_while(|word| word[0] != b'#')
}

/// A name as text: UTF-8 or, failing that, Latin-1.
pub(super) fn name(bytes: &[u8]) -> String {
    utf8_or_latin1(bytes).into_owned()
}

/// At most 60 characters of a text, for messages.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 60;
    notes::excerpt(&name(&bytes[..bytes.len().min(4 * LONGEST)]), LONGEST)
}

/// Parses a number in the notation common to C's `strtof` and `printf`, or a non-finite value in
/// the spelling of C libraries.
///
/// Numbers too large for `f32` are infinite, as in C.
pub(super) fn number(word: &[u8]) -> Option<f32> {
    let text = std::str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| not_finite(text))
}

/// Parses a number in double precision, by the rules of [`number`].
pub(super) fn wide_number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| not_finite(text).map(f64::from))
}

/// Parses non-finite values in the spelling of C libraries: `1.#INF`, `-1.#IND00`, `nan(ind)`,
/// `-nan(snan)`.
fn not_finite(text: &str) -> Option<f32> {
    let lower = text.trim_start_matches(['+', '-']).to_ascii_lowercase();
    if lower.starts_with("1.#inf") {
        Some(f32::INFINITY)
    } else if ["1.#ind", "1.#qnan", "1.#snan", "nan("].iter().any(|start| lower.starts_with(start)) {
        Some(f32::NAN)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8]) -> Vec<(u32, String)> {
        let mut lines = Lines::new(text);
        let mut all = Vec::new();
        while let Some((number, line)) = lines.next() {
            all.push((number, name(line)));
        }
        all
    }

    #[test]
    fn lines_end_in_any_way_and_are_counted() {
        let expected = [(1, "a"), (2, "b"), (3, ""), (4, "c d")].map(|(n, s)| (n, s.to_owned()));
        for text in ["a\nb\n\nc d", "a\r\nb\r\n\r\nc d\r\n", "a\rb\r\rc d\r", " a\t\nb \n \n\tc d \n"] {
            assert_eq!(lines(text.as_bytes()), expected, "{text:?}");
        }
    }

    #[test]
    fn continued_lines_are_joined_but_comments_are_not() {
        let text = b"f 1 2\\\r\n 3 \\\n4\n# C:\\models\\\nv 1\nf 5\\";
        let expected = [(1, "f 1 2  3  4"), (4, "# C:\\models\\"), (5, "v 1"), (6, "f 5")];
        assert_eq!(lines(text), expected.map(|(n, s)| (n, s.to_owned())));
    }

    #[test]
    fn nul_bytes_are_refused_with_their_line() {
        let error = decode(b"v 1 2 3\nv \0", Path::new("a.obj")).unwrap_err().to_string();
        assert!(error.starts_with("a.obj:2: a NUL byte"), "{error}");
        let without_mark: Vec<u8> = "v 1".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert!(decode(&without_mark, Path::new("a.obj")).is_err());
    }

    #[test]
    fn numbers_are_read_as_c_writes_them() {
        for (word, value) in
            [("1.", 1.0), (".5", 0.5), ("+1", 1.0), ("-.8e-001", -0.08), ("1e05", 1e5), ("2E+2", 200.0)]
        {
            assert_eq!(number(word.as_bytes()), Some(value), "{word}");
        }
        for word in ["nan", "-nan", "NaN", "-nan(ind)", "1.#IND", "-1.#IND00", "1.#QNAN"] {
            assert!(number(word.as_bytes()).unwrap().is_nan(), "{word}");
        }
        for word in ["inf", "-inf", "1.#INF", "-1.#INF00", "1e400", "3E4570711268"] {
            assert!(number(word.as_bytes()).unwrap().is_infinite(), "{word}");
        }
        for word in ["", "-", "1,5", "0x10", "1.0f", "1/2", "e5", "\u{661}"] {
            assert_eq!(number(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn excerpts_are_short() {
        assert_eq!(excerpt(b"abc"), "abc");
        assert_eq!(excerpt(&[b'a'; 1000]).chars().count(), 61);
    }
}
