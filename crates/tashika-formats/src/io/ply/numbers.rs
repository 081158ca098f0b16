//! The numbers after the header of a PLY file, one after the other.

use super::header::{Scalar, line_of};
use crate::error::{Error, Location, Result};

/// Fault that is found in place of a number or an index.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Wrong {
    /// The file is at its end.
    End,
    /// A word that is no number.
    Word(String),
    /// Index of a missing vertex, and number of vertices.
    Index(f64, u64),
}

/// Reader of the numbers after a header.
pub(super) trait Numbers {
    /// The next number, of this type. `f64` represents every integer of the format exactly.
    fn next(&mut self, scalar: Scalar) -> Result<f64, Wrong>;
    /// Skips numbers of one type.
    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Wrong>;
    /// Upper bound on the count of numbers of a type in the remaining bytes.
    fn capacity(&self, scalar: Scalar) -> u64;
    /// Place of the number that was read last.
    fn place(&self, at: &Location) -> Location;
}

/// Numbers as text, separated by white space.
pub(super) struct Text<'a> {
    rest: &'a [u8],
    line: u32,
}

impl<'a> Text<'a> {
    /// Numbers of `bytes`, which begin after `lines` lines.
    pub(super) fn new(bytes: &'a [u8], lines: u32) -> Self {
        Self { rest: bytes, line: lines.saturating_add(1) }
    }

    fn word(&mut self) -> Result<&'a [u8], Wrong> {
        let start = self.rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or(Wrong::End)?;
        let breaks = self.rest[..start].iter().filter(|b| **b == b'\n').count();
        self.line = self.line.saturating_add(u32::try_from(breaks).unwrap_or(u32::MAX));
        let rest = &self.rest[start..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        Ok(word)
    }
}

impl Numbers for Text<'_> {
    fn next(&mut self, _: Scalar) -> Result<f64, Wrong> {
        let word = self.word()?;
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.ok_or_else(|| Wrong::Word(String::from_utf8_lossy(&word[..word.len().min(60)]).into_owned()))
    }

    fn skip(&mut self, _: Scalar, count: u64) -> Result<(), Wrong> {
        (0..count).try_for_each(|_| self.word().map(drop))
    }

    fn capacity(&self, _: Scalar) -> u64 {
        // Each number takes at least a digit and a blank; the last one needs no blank.
        (self.rest.len() as u64).div_ceil(2)
    }

    fn place(&self, at: &Location) -> Location {
        line_of(at, self.line)
    }
}

/// Numbers as bytes; with `BIG`, the most significant byte is first.
pub(super) struct Binary<'a, const BIG: bool> {
    rest: &'a [u8],
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Wrong> {
        let (&bytes, rest) = self.rest.split_first_chunk::<N>().ok_or(Wrong::End)?;
        self.rest = rest;
        let mut bytes = bytes;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Numbers for Binary<'_, BIG> {
    #[inline]
    fn next(&mut self, scalar: Scalar) -> Result<f64, Wrong> {
        Ok(match scalar {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), Wrong> {
        let bytes = usize::try_from(count).ok().and_then(|n| n.checked_mul(scalar.size()));
        self.rest = bytes.and_then(|n| self.rest.get(n..)).ok_or(Wrong::End)?;
        Ok(())
    }

    fn capacity(&self, scalar: Scalar) -> u64 {
        (self.rest.len() / scalar.size()) as u64
    }

    fn place(&self, at: &Location) -> Location {
        at.clone()
    }
}

impl Wrong {
    /// Error of a row that cannot be read.
    pub(super) fn error(self, place: Location, element: &str, row: u64) -> Error {
        let (found, expected) = match self {
            Self::End => ("the end of the file, which is truncated".to_owned(), "a number".to_owned()),
            Self::Word(word) => (format!("{word:?}"), "a number".to_owned()),
            Self::Index(index, 0) => {
                (format!("vertex {index}"), "no index: there are no vertices".to_owned())
            }
            Self::Index(index, vertices) => {
                (format!("vertex {index}"), format!("an index from 0 to {}", vertices - 1))
            }
        };
        let within = place.item.as_deref().map_or(String::new(), |item| format!("{item}: "));
        Error::invalid(place.item(format!("{within}{element} {row}")), found, expected)
    }
}
