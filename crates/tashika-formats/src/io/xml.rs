//! XML parser whose time is proportional to the length of the text.
//!
//! The XML library compares each attribute of an element with those before it, and copies the
//! namespaces in scope for each element that declares one. Both are quadratic. A pass before it
//! therefore counts attributes and namespaces, and refuses a text with more than any scene or
//! MaterialX document has: [`MAX_ATTRIBUTES`] per element, [`MAX_NAMESPACES`] in all. With these
//! limits there are fewer than 200 comparisons per byte of the text.
//!
//! # Guarantee
//! Document types are refused, so that entities cannot multiply. Every error has file, line and
//! column.
//!
//! # Assumption
//! In well-formed text the pass sees the same tags as the library. In other text the two agree up
//! to the first fault, where the library stops.
//!
//! Held to this by the tests below, and by `suite::damaged_mitsuba` and `suite::damaged_usd`.

use std::path::Path;

use roxmltree::{Document, ParsingOptions};

use crate::error::{Error, Location, Result};

/// Most attributes of one element; chosen.
const MAX_ATTRIBUTES: usize = 1024;

/// Most declarations of namespaces in a document; chosen.
const MAX_NAMESPACES: usize = 64;

/// Parses a document of the file `path`.
///
/// # Errors
/// [`Error::Invalid`] for text that is not well-formed, has a document type, or has more attributes
/// or namespaces than permitted.
pub(super) fn parse<'t>(text: &'t str, path: &Path) -> Result<Document<'t>> {
    if let Some((position, found, expected)) = excess(text) {
        return Err(Error::invalid(place(text, position, path), found, expected));
    }
    let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| {
        if matches!(error, roxmltree::Error::DtdDetected) {
            let found = "a document type declaration";
            return Error::invalid(Location::file(path), found, "XML without one: entities are not expanded");
        }
        let at = Location::line(path, error.pos().row).column(error.pos().col);
        Error::invalid(at, format!("XML that cannot be read ({error})"), "well-formed XML")
    })
}

/// Returns line and column of a byte.
fn place(text: &str, position: usize, path: &Path) -> Location {
    let before = text.get(..position).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    let line = before.bytes().filter(|b| *b == b'\n').count() + 1;
    Location::line(path, line as u32).column(before[start..].chars().count() as u32 + 1)
}

/// Returns the position of the first tag that exceeds a limit, the count found, and the limit.
fn excess(text: &str) -> Option<(usize, String, String)> {
    let (mut from, mut namespaces) = (0, 0);
    while let Some(start) = text[from..].find('<').map(|offset| from + offset) {
        let markup = &text[start..];
        // Returns the length of the markup if it begins and ends with the given texts.
        let length = |begin: &str, end: &str| {
            let inner = markup.strip_prefix(begin)?;
            Some(inner.find(end).map_or(markup.len(), |at| begin.len() + at + end.len()))
        };
        let skipped = length("<!--", "-->")
            .or_else(|| length("<![CDATA[", "]]>"))
            .or_else(|| length("<?", "?>"))
            .or_else(|| length("</", ">"));
        from = start
            + match skipped {
                Some(length) => length,
                None => {
                    let tag = Tag::of(markup);
                    namespaces += tag.namespaces;
                    let most = |count: usize| format!("at most {count}");
                    if tag.attributes > MAX_ATTRIBUTES {
                        let found = format!("an element with {} attributes", tag.attributes);
                        return Some((start, found, most(MAX_ATTRIBUTES)));
                    }
                    if namespaces > MAX_NAMESPACES {
                        let found = format!("{namespaces} declarations of namespaces");
                        return Some((start, found, most(MAX_NAMESPACES)));
                    }
                    tag.length
                }
            };
    }
    None
}

/// Length and counts of a start tag.
struct Tag {
    /// Length in bytes, including both brackets.
    length: usize,
    attributes: usize,
    /// Number of attributes that declare a namespace, or whose name contains `xmlns`.
    namespaces: usize,
}

impl Tag {
    /// Reads the tag at the beginning of the text.
    fn of(markup: &str) -> Self {
        let mut tag = Self { length: markup.len(), attributes: 0, namespaces: 0 };
        let bytes = markup.as_bytes();
        // Text since the last value: names of attributes and separators.
        let mut names = 0;
        let mut at = 0;
        while at < bytes.len() {
            match bytes[at] {
                b'>' => {
                    tag.length = at + 1;
                    break;
                }
                quote @ (b'"' | b'\'') => {
                    tag.attributes += 1;
                    tag.namespaces += usize::from(markup[names..at].contains("xmlns"));
                    let value = bytes[at + 1..].iter().position(|b| *b == quote);
                    at = value.map_or(bytes.len(), |length| at + 1 + length);
                    names = at.min(bytes.len());
                }
                _ => {}
            }
            at += 1;
        }
        tag
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use super::*;

    fn message(text: &str) -> Option<String> {
        parse(text, Path::new("a.xml")).err().map(|error| error.to_string())
    }

    /// Returns an element `<e …/>` with the given number of attributes.
    fn element(attributes: usize) -> String {
        let mut text = "<e".to_owned();
        (0..attributes).for_each(|i| write!(text, " a{i}=\"'>'\"").unwrap());
        text + "/>"
    }

    #[test]
    fn elements_have_a_limited_number_of_attributes() {
        assert_eq!(message(&element(MAX_ATTRIBUTES)), None);
        let found = message(&format!("<r>\n <!-- <\"> -->{}</r>", element(MAX_ATTRIBUTES + 1)));
        let expected = "a.xml:2:14: an element with 1025 attributes; expected at most 1024";
        assert_eq!(found.as_deref(), Some(expected));
        // 300,000 attributes would need 4.5·10¹⁰ comparisons.
        assert!(message(&element(300_000)).unwrap().contains("300000 attributes"));
    }

    #[test]
    fn documents_have_a_limited_number_of_namespaces() {
        let document = |inside: usize| {
            let one = |i: usize| format!("<e xmlns:n{i} = 'u{i}' a=\"1\"/>");
            format!("<r xmlns=\"u\">{}</r>", (0..inside).map(one).collect::<String>())
        };
        assert_eq!(message(&document(MAX_NAMESPACES - 1)), None);
        let found = message(&document(6000)).unwrap();
        assert!(found.contains("65 declarations of namespaces; expected at most 64"), "{found}");
    }

    #[test]
    fn what_is_no_start_tag_is_passed_over() {
        let attributes = "a='' ".repeat(2000);
        for inside in [
            format!("<!--> <e {attributes} >-->"),
            format!("<![CDATA[ <e {attributes} > ]]>"),
            format!("<?p <e {attributes} > ?>"),
            format!("text &lt;e {attributes}"),
        ] {
            let text = format!("<r>{inside}<e a = '<'/></r>").replace("'<'", "'&lt;'");
            assert_eq!(message(&text), None, "{}", &inside[..20]);
        }
        for damaged in
            ["", "<", "<a", "<a b", "<a b='", "<!--", "<![CDATA[", "<?", "</", "<a b=''", "é<é é='é"]
        {
            assert!(message(damaged).unwrap().starts_with("a.xml"), "{damaged}");
        }
        let found = message("<!DOCTYPE a [<!ENTITY b 'c'>]><a/>").unwrap();
        assert_eq!(
            found,
            "a.xml: a document type declaration; expected XML without one: entities are not expanded"
        );
    }
}
