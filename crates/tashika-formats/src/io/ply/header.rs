//! The header of a PLY file: lines of text up to `end_header`.

use crate::error::{Error, Location, Result};

/// Encoding of the numbers after the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Text,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Size in binary files (bytes).
    pub(super) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// One value of each row of an element, or a list of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub name: String,
    /// Type of the number of values, for lists.
    pub count: Option<Scalar>,
    /// Type of the values.
    pub value: Scalar,
}

/// A table: rows with the same properties.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    pub rows: u64,
    pub properties: Vec<Property>,
}

/// Format and elements of a file.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub format: Format,
    pub elements: Vec<Element>,
    /// Bytes before the first number.
    pub length: usize,
    /// Lines before the first number.
    pub lines: u32,
}

impl Header {
    pub(super) fn parse(bytes: &[u8], at: &Location) -> Result<Self> {
        let mut lines = Lines { bytes, position: 0, number: 0 };
        if lines.next().as_deref().map(str::trim_end) != Some("ply") {
            return Err(Error::invalid(at.clone(), "a file that does not begin with \"ply\"", "a PLY mesh"));
        }
        let mut format = None;
        let mut elements: Vec<Element> = Vec::new();
        while let Some(line) = lines.next() {
            let here = || lines.place(at);
            let refuse =
                |expected: &str| Err(Error::invalid(here(), format!("{:?}", shown(&line)), expected));
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match *words.as_slice() {
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, ..] => {
                    format = Some(match name {
                        "ascii" => Format::Text,
                        "binary_little_endian" => Format::LittleEndian,
                        "binary_big_endian" => Format::BigEndian,
                        _ => return refuse("ascii, binary_little_endian or binary_big_endian"),
                    });
                }
                ["element", name, rows] => {
                    let Ok(rows) = rows.parse() else { return refuse("a number of rows") };
                    elements.push(Element { name: name.to_owned(), rows, properties: Vec::new() });
                }
                ["property", ref rest @ ..] => {
                    let Some(element) = elements.last_mut() else { return refuse("an element first") };
                    match property(rest) {
                        Some(property) => element.properties.push(property),
                        None => return refuse("\"property TYPE NAME\" or \"property list TYPE TYPE NAME\""),
                    }
                }
                ["end_header", ..] => {
                    let Some(format) = format else { return refuse("a line \"format\" before it") };
                    let (length, lines) = (lines.position, lines.number);
                    return Ok(Self { format, elements, length, lines });
                }
                _ => return refuse("format, element, property, comment or end_header"),
            }
        }
        Err(Error::invalid(lines.place(at), "the end of the file, which is truncated", "\"end_header\""))
    }
}

/// Parses the words after `property`.
fn property(words: &[&str]) -> Option<Property> {
    let (count, value, name) = match *words {
        ["list", count, value, name] => (Some(Scalar::parse(count)?), value, name),
        [value, name] => (None, value, name),
        _ => return None,
    };
    Some(Property { name: name.to_owned(), count, value: Scalar::parse(value)? })
}

/// The start of a line, for messages.
fn shown(line: &str) -> &str {
    let end = line.char_indices().nth(60).map_or(line.len(), |(i, _)| i);
    &line[..end]
}

struct Lines<'a> {
    bytes: &'a [u8],
    position: usize,
    number: u32,
}

impl Lines<'_> {
    /// The next line; it ends with `\n`, `\r\n`, or `\r` as old systems wrote it.
    fn next(&mut self) -> Option<String> {
        let rest = &self.bytes[self.position..];
        if rest.is_empty() {
            return None;
        }
        let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        let terminator = match rest[end..] {
            [b'\r', b'\n', ..] => 2,
            [_, ..] => 1,
            [] => 0,
        };
        self.position += end + terminator;
        self.number = self.number.saturating_add(1);
        Some(String::from_utf8_lossy(&rest[..end]).into_owned())
    }

    fn place(&self, at: &Location) -> Location {
        line_of(at, self.number)
    }
}

/// Location of a line of the file. If `at` already is a line of another file, that line is kept,
/// and this line becomes its item.
pub(super) fn line_of(at: &Location, line: u32) -> Location {
    match at.line {
        None => Location { line: Some(line), ..at.clone() },
        Some(_) => at.clone().item(format!("line {line} of the mesh")),
    }
}
