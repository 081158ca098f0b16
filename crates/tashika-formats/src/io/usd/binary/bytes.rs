//! Reads from the bytes of a binary file and unpacks its compressed parts.
//!
//! Integers are stored as differences from their predecessors. For each integer, a code of two bits
//! selects either the most common difference, which is stored once, or a difference that is stored
//! in 1, 2 or 4 bytes (2, 4 or 8 for long integers). Codes and differences together are compressed
//! by LZ4.[^lz4]
//!
//! # Guarantee
//! No allocation exceeds the largest size to which the compressed bytes can expand, nor the budget
//! of unpacked bytes.
//!
//! [^lz4]: Collet. "LZ4 Block Format Description." 2022.

use std::cell::Cell;
use std::rc::Rc;

/// Description of a fault in a file.
pub(super) type Wrong = String;
pub(super) type Read<T> = Result<T, Wrong>;

/// Largest ratio of unpacked to packed bytes: each byte of an LZ4 block lengthens a copied run by
/// at most 255 bytes.
const MOST_EXPANSION: usize = 255;

/// Part of the bytes of a file.
#[derive(Clone, Debug)]
pub(in crate::io::usd) struct Bytes {
    pub all: Rc<Vec<u8>>,
    pub from: usize,
    pub to: usize,
}

impl Bytes {
    pub fn get(&self) -> &[u8] {
        self.all.get(self.from..self.to).unwrap_or_default()
    }
}

/// A position in the bytes.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    /// Number of bytes that may still be unpacked.
    pub budget: &'a Cell<u64>,
}

impl<'a> Cursor<'a> {
    /// The next `count` bytes.
    pub fn take(&mut self, count: usize) -> Read<&'a [u8]> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.bytes.len());
        let end = end.ok_or_else(|| format!("{count} bytes at byte {}, beyond the end", self.at))?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    pub fn fixed<const N: usize>(&mut self) -> Read<[u8; N]> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        Ok(bytes)
    }

    pub fn u32(&mut self) -> Read<u32> {
        self.fixed().map(u32::from_le_bytes)
    }

    pub fn u64(&mut self) -> Read<u64> {
        self.fixed().map(u64::from_le_bytes)
    }

    pub fn i64(&mut self) -> Read<i64> {
        self.fixed().map(i64::from_le_bytes)
    }

    pub fn f64(&mut self) -> Read<f64> {
        self.fixed().map(f64::from_le_bytes)
    }

    /// Reads the number of items that follow, each of at least `size` bytes.
    pub fn count(&mut self, size: usize) -> Read<usize> {
        let count = self.u64()?;
        let left = (self.bytes.len() - self.at.min(self.bytes.len())) as u64;
        match usize::try_from(count).ok().filter(|_| count.saturating_mul(size as u64) <= left) {
            Some(count) => Ok(count),
            None => Err(format!("a list of {count} at byte {}, more than there are bytes", self.at)),
        }
    }

    /// Subtracts `bytes` from the budget of unpacked bytes.
    pub fn spend(&self, bytes: u64) -> Read<()> {
        let left = self.budget.get().checked_sub(bytes);
        self.budget.set(left.ok_or("more unpacked bytes than a file may have")?);
        Ok(())
    }

    /// Unpacks the next `packed` bytes into at most `most` bytes.
    pub fn unpacked(&mut self, packed: usize, most: usize) -> Read<Vec<u8>> {
        let (chunks, mut rest) = match self.take(packed)? {
            [] => return Err("an empty compressed part".to_owned()),
            [chunks, rest @ ..] => (*chunks, rest),
        };
        let most = most.min(packed.saturating_mul(MOST_EXPANSION).saturating_add(64));
        self.spend(most as u64)?;
        let mut out = vec![0; most];
        let damaged = |_| "a damaged compressed part".to_owned();
        if chunks == 0 {
            let length = lz4_flex::block::decompress_into(rest, &mut out).map_err(damaged)?;
            out.truncate(length);
            return Ok(out);
        }
        let mut length = 0;
        for _ in 0..chunks {
            let mut head = Cursor { bytes: rest, at: 0, budget: self.budget };
            let size = head.u32()? as usize;
            let chunk = head.take(size)?;
            rest = &rest[head.at..];
            length += lz4_flex::block::decompress_into(chunk, &mut out[length..]).map_err(damaged)?;
        }
        out.truncate(length);
        Ok(out)
    }

    /// Reads `count` compressed integers. Their compressed size precedes them.
    pub fn integers(&mut self, count: usize, kind: Kind) -> Read<Vec<i64>> {
        let packed = self.count(1)?;
        if count == 0 {
            self.take(packed)?;
            return Ok(Vec::new());
        }
        let width = if kind == Kind::Long { 8 } else { 4 };
        let codes = count.div_ceil(4);
        let most = codes.saturating_add(width).saturating_add(count.saturating_mul(width));
        let unpacked = self.unpacked(packed, most)?;
        // Each integer takes at least its code of two bits.
        if unpacked.len() < codes {
            return Err(format!("{count} integers in {} bytes", unpacked.len()));
        }
        self.spend(8 * count as u64)?;
        decoded(Cursor { bytes: &unpacked, at: 0, budget: self.budget }, count, codes, kind)
    }
}

/// Type of integers: `i32`, `u32` or `i64`. Sums wrap around in this type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Signed,
    Unsigned,
    Long,
}

fn decoded(mut cursor: Cursor<'_>, count: usize, codes: usize, kind: Kind) -> Read<Vec<i64>> {
    let is_long = kind == Kind::Long;
    let i32_of = |cursor: &mut Cursor<'_>| cursor.fixed().map(|b| i64::from(i32::from_le_bytes(b)));
    let common = if is_long { cursor.i64()? } else { i32_of(&mut cursor)? };
    let codes = cursor.take(codes)?;
    let mut previous = 0_i64;
    let mut integers = Vec::with_capacity(count);
    for i in 0..count {
        let code = codes[i / 4] >> (2 * (i % 4)) & 3;
        let step = match (code, is_long) {
            (0, _) => common,
            (1, false) => i64::from(i8::from_le_bytes(cursor.fixed()?)),
            (2, false) | (1, true) => i64::from(i16::from_le_bytes(cursor.fixed()?)),
            (3, false) | (2, true) => i32_of(&mut cursor)?,
            _ => cursor.i64()?,
        };
        previous = previous.wrapping_add(step);
        previous = match kind {
            Kind::Signed => i64::from(previous as i32),
            Kind::Unsigned => i64::from(previous as u32),
            Kind::Long => previous,
        };
        integers.push(previous);
    }
    Ok(integers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_their_differences() {
        // The most common difference is 1. Codes: most common, one byte, two bytes, four bytes.
        let mut bytes = vec![1, 0, 0, 0, 0b11_10_01_00, 0xfe];
        bytes.extend(1000_i16.to_le_bytes());
        bytes.extend((-2_000_000_i32).to_le_bytes());
        let budget = Cell::new(0);
        let cursor = Cursor { bytes: &bytes, at: 0, budget: &budget };
        assert_eq!(decoded(cursor, 4, 1, Kind::Signed).unwrap(), [1, -1, 999, -1_999_001]);
        assert_eq!(decoded(cursor, 2, 1, Kind::Unsigned).unwrap(), [1, i64::from(u32::MAX)]);
    }

    #[test]
    fn sizes_are_held_against_the_bytes_that_are_there() {
        let budget = Cell::new(100);
        let bytes = u64::MAX.to_le_bytes();
        let mut cursor = Cursor { bytes: &bytes, at: 0, budget: &budget };
        assert!(cursor.count(1).unwrap_err().contains("more than there are bytes"));
        assert!(Cursor { bytes: &bytes, at: 0, budget: &budget }.unpacked(8, 1 << 40).is_err());
        assert!(cursor.spend(101).is_err());
    }
}
