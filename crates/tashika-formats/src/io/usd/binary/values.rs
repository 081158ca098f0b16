//! Decodes values by their type.
//!
//! A value is stored as eight bytes: flags, a type, and 48 bits. These hold the value itself if it
//! is small, and otherwise its position in the file.

use std::rc::Rc;

use super::super::value::{ListOp, Reference, Text, Value};
use super::bytes::{Cursor, Kind, Read};
use super::{Binary, Rep};

/// Largest depth of nested values.
const MAX_DEPTH: usize = 32;

/// Shortest array that is compressed.
const SHORTEST_COMPRESSED: usize = 16;

/// Binary types of numbers, as files store them.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stored {
    Bool,
    I8,
    I32,
    U32,
    I64,
    U64,
    Half,
    Float,
    Double,
}

impl Stored {
    fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 => 1,
            Self::Half => 2,
            Self::I32 | Self::U32 | Self::Float => 4,
            Self::I64 | Self::U64 | Self::Double => 8,
        }
    }

    /// Decodes the number at the beginning of `b`.
    fn read(self, b: &[u8]) -> f64 {
        let four = || [b[0], b[1], b[2], b[3]];
        let eight = || [b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]];
        match self {
            Self::Bool => f64::from(b[0]),
            Self::I8 => f64::from(b[0] as i8),
            Self::I32 => f64::from(i32::from_le_bytes(four())),
            Self::U32 => f64::from(u32::from_le_bytes(four())),
            Self::I64 => i64::from_le_bytes(eight()) as f64,
            Self::U64 => u64::from_le_bytes(eight()) as f64,
            Self::Half => half(u16::from_le_bytes([b[0], b[1]])),
            Self::Float => f64::from(f32::from_le_bytes(four())),
            Self::Double => f64::from_le_bytes(eight()),
        }
    }
}

/// `(−1)^s 2^(e − 15) (1 + m / 1024)`, with subnormal numbers, infinities and NaN.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, mantissa) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let power = |e: i32| if e >= 0 { f64::from(1_u32 << e) } else { 1.0 / f64::from(1_u32 << -e) };
    sign * match exponent {
        0 => mantissa * power(-24),
        31 if mantissa == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        e => (1.0 + mantissa / 1024.0) * power(e - 15),
    }
}

/// Stored type and number of components of a value that consists of numbers.
fn shape(kind: u8) -> Option<(Stored, usize)> {
    use Stored::{Bool, Double, Float, Half, I8, I32, I64, U32, U64};
    Some(match kind {
        1 => (Bool, 1),
        2 => (I8, 1),
        3 => (I32, 1),
        4 => (U32, 1),
        5 => (I64, 1),
        6 => (U64, 1),
        7 => (Half, 1),
        8 => (Float, 1),
        9 | 56 => (Double, 1),
        13 => (Double, 4),
        14 => (Double, 9),
        15 => (Double, 16),
        16 => (Double, 4),
        17 => (Float, 4),
        18 => (Half, 4),
        // Vectors of two, three and four: double, float, half, int.
        19..=30 => {
            let stored = [Double, Float, Half, I32][usize::from(kind - 19) % 4];
            (stored, 2 + usize::from(kind - 19) / 4)
        }
        _ => return None,
    })
}

/// Returns true if a rep stands for integers or booleans.
pub(super) fn is_whole(rep: Rep) -> bool {
    matches!(rep.0 >> 48 & 0xff, 1..=6 | 22 | 26 | 30)
}

const IS_ARRAY: u64 = 1 << 63;
const IS_INLINED: u64 = 1 << 62;
const IS_COMPRESSED: u64 = 1 << 61;

/// The value that a rep stands for.
pub(super) fn value(binary: &Binary, rep: Rep, depth: usize) -> Read<Value> {
    if depth > MAX_DEPTH {
        return Err("values too deep in each other".to_owned());
    }
    let (kind, payload) = ((rep.0 >> 48 & 0xff) as u8, rep.0 & 0xffff_ffff_ffff);
    let is = |flag| rep.0 & flag != 0;
    let there = || binary.cursor(payload as usize);
    if is(IS_ARRAY) {
        return if payload == 0 {
            Ok(Value::Array { width: 1, numbers: Vec::new() })
        } else {
            array(binary, there()?, kind, is(IS_COMPRESSED))
        };
    }
    if let Some((stored, width)) = shape(kind) {
        let mut numbers = if is(IS_INLINED) {
            inlined(kind, stored, width, payload)
        } else {
            raw(&mut there()?, stored, width)?
        };
        real_part_first(kind, &mut numbers);
        return Ok(if width == 1 { Value::Number(numbers[0]) } else { Value::Tuple(numbers) });
    }
    Ok(match kind {
        10 if is(IS_INLINED) => Value::Text(binary.string(payload as u32)?),
        11 | 12 if is(IS_INLINED) => Value::Text(binary.token(payload as u32)?),
        // Specifier, permission, variability.
        42..=44 => Value::Number((payload & 0xffff_ffff) as f64),
        32..=34 => {
            let names = match kind {
                32 => |b: &Binary, c: &mut Cursor<'_>| b.token(c.u32()?),
                33 => |b: &Binary, c: &mut Cursor<'_>| b.string(c.u32()?),
                _ => |b: &Binary, c: &mut Cursor<'_>| b.path(c.u32()?),
            };
            Value::Paths(list_op(&mut there()?, 4, |c| names(binary, c))?)
        }
        37 => Value::Ids(list_op(&mut there()?, 8, |c| c.i64())?),
        35 => Value::References(list_op(&mut there()?, 32, |c| reference(binary, c, true, depth))?),
        55 => {
            let (offset, size) = has_payload_offset(binary);
            Value::References(list_op(&mut there()?, size, |c| reference(binary, c, offset, 64))?)
        }
        47 => {
            let reference = reference(binary, &mut there()?, has_payload_offset(binary).0, 64)?;
            Value::References(ListOp { explicit: Some(vec![reference]), ..ListOp::default() })
        }
        40 | 41 | 50 => {
            let mut cursor = there()?;
            let count = cursor.count(4)?;
            let name = |cursor: &mut Cursor<'_>| {
                let index = cursor.u32()?;
                match kind {
                    40 => binary.path(index),
                    41 => binary.token(index),
                    _ => binary.string(index),
                }
            };
            Value::Texts((0..count).map(|_| name(&mut cursor)).collect::<Read<_>>()?)
        }
        45 => {
            let mut cursor = there()?;
            let count = cursor.count(8)?;
            let pair =
                |cursor: &mut Cursor<'_>| Ok((binary.string(cursor.u32()?)?, binary.string(cursor.u32()?)?));
            Value::Selections((0..count).map(|_| pair(&mut cursor)).collect::<Read<_>>()?)
        }
        48 => {
            let mut cursor = there()?;
            let count = cursor.count(8)?;
            Value::Array { width: 1, numbers: raw(&mut cursor, Stored::Double, count)? }
        }
        49 => {
            let mut cursor = there()?;
            let count = cursor.count(16)?;
            Value::Array { width: 2, numbers: raw(&mut cursor, Stored::Double, 2 * count)? }
        }
        51 | 60 => Value::Blocked,
        _ => Value::Other,
    })
}

/// Consecutive numbers.
fn raw(cursor: &mut Cursor<'_>, stored: Stored, count: usize) -> Read<Vec<f64>> {
    let size = stored.size();
    let bytes = cursor.take(count.checked_mul(size).ok_or("a size beyond all bytes")?)?;
    cursor.spend(8 * count as u64)?;
    Ok(bytes.chunks_exact(size).map(|b| stored.read(b)).collect())
}

/// Decodes numbers that are stored in the rep itself.
fn inlined(kind: u8, stored: Stored, width: usize, payload: u64) -> Vec<f64> {
    let bytes = payload.to_le_bytes();
    match kind {
        // Numbers of up to four bytes are stored unchanged, longer ones as four-byte numbers.
        1..=4 | 7 | 8 => vec![stored.read(&bytes)],
        5 => vec![Stored::I32.read(&bytes)],
        6 => vec![Stored::U32.read(&bytes)],
        9 | 56 => vec![Stored::Float.read(&bytes)],
        // A vector of two halves takes four bytes.
        21 => bytes[..4].chunks_exact(2).map(|b| stored.read(b)).collect(),
        // The diagonal of a matrix.
        13..=15 => {
            let side = usize::from(kind - 11);
            let mut all = vec![0.0; width];
            for (i, byte) in bytes[..side].iter().enumerate() {
                all[i * (side + 1)] = f64::from(*byte as i8);
            }
            all
        }
        _ => bytes[..width.min(8)].iter().map(|&b| f64::from(b as i8)).collect(),
    }
}

/// Moves the real part of quaternions to the front; files store it last.
fn real_part_first(kind: u8, numbers: &mut [f64]) {
    if (16..=18).contains(&kind) {
        numbers.as_chunks_mut::<4>().0.iter_mut().for_each(|q| q.rotate_right(1));
    }
}

fn array(binary: &Binary, mut cursor: Cursor<'_>, kind: u8, is_compressed: bool) -> Read<Value> {
    if binary.version < [0, 5] {
        // Skips the rank of the array, which is always 1.
        cursor.u32()?;
    }
    let count = if binary.version < [0, 7] { u64::from(cursor.u32()?) } else { cursor.u64()? };
    let count = usize::try_from(count).map_err(|_| "an array beyond all bytes")?;
    let Some((stored, width)) = shape(kind) else {
        let name = |cursor: &mut Cursor<'_>| {
            let index = cursor.u32()?;
            if kind == 11 { binary.token(index) } else { binary.string(index) }
        };
        if !(10..=12).contains(&kind) {
            return Ok(Value::Other);
        }
        let mut names = Cursor { bytes: cursor.take(count.saturating_mul(4))?, at: 0, budget: cursor.budget };
        return Ok(Value::Texts((0..count).map(|_| name(&mut names)).collect::<Read<Vec<Text>>>()?));
    };
    let mut numbers = if !is_compressed || count < SHORTEST_COMPRESSED {
        raw(&mut cursor, stored, count.checked_mul(width).ok_or("an array beyond all bytes")?)?
    } else {
        compressed(&mut cursor, stored, count)?
    };
    real_part_first(kind, &mut numbers);
    Ok(Value::Array { width, numbers })
}

fn compressed(cursor: &mut Cursor<'_>, stored: Stored, count: usize) -> Read<Vec<f64>> {
    let integers = |kind| match kind {
        Stored::U32 => Kind::Unsigned,
        Stored::I64 | Stored::U64 => Kind::Long,
        _ => Kind::Signed,
    };
    let numbers = |all: Vec<i64>| all.into_iter().map(|i| i as f64).collect();
    if matches!(stored, Stored::I32 | Stored::U32 | Stored::I64) {
        return cursor.integers(count, integers(stored)).map(numbers);
    }
    if stored == Stored::U64 {
        return Ok(cursor.integers(count, Kind::Long)?.into_iter().map(|i| i as u64 as f64).collect());
    }
    match cursor.fixed::<1>()? {
        // Whole numbers.
        [b'i'] => cursor.integers(count, Kind::Signed).map(numbers),
        // A table of the distinct numbers, followed by an index for each element.
        [b't'] => {
            let size = cursor.u32()? as usize;
            let table = raw(cursor, stored, size)?;
            let all = cursor.integers(count, Kind::Unsigned)?;
            let of = |i: i64| table.get(i as usize).copied().ok_or_else(|| format!("entry {i} of a table"));
            all.into_iter().map(of).collect()
        }
        [other] => Err(format!("numbers compressed in the way {other}")),
    }
}

/// Reads the edits of a list. Its items take at least `size` bytes each.
fn list_op<T>(
    cursor: &mut Cursor<'_>,
    size: usize,
    mut item: impl FnMut(&mut Cursor<'_>) -> Read<T>,
) -> Read<ListOp<T>> {
    let [flags] = cursor.fixed::<1>()?;
    let mut op = ListOp::default();
    if flags & 1 != 0 {
        op.explicit = Some(Vec::new());
    }
    // Flags in the order of the lists: explicit, added, prepended, appended, deleted, ordered.
    for flag in [2, 4, 32, 64, 8, 16] {
        if flags & flag == 0 {
            continue;
        }
        let count = cursor.count(size.min(8))?;
        let items = (0..count).map(|_| item(cursor)).collect::<Read<Vec<T>>>()?;
        match flag {
            2 => op.explicit = Some(items),
            4 | 64 => op.appended.extend(items),
            32 => op.prepended = items,
            8 => op.deleted = items,
            _ => {}
        }
    }
    Ok(op)
}

/// Returns true if payloads have a time offset, and the size of a payload (bytes).
fn has_payload_offset(binary: &Binary) -> (bool, usize) {
    if binary.version >= [0, 8] { (true, 24) } else { (false, 8) }
}

/// Reads a reference or a payload. A payload (`depth` 64) is not followed by a dictionary.
fn reference(binary: &Binary, cursor: &mut Cursor<'_>, has_offset: bool, depth: usize) -> Read<Reference> {
    let (asset, prim) = (binary.string(cursor.u32()?)?, binary.path(cursor.u32()?)?);
    let (offset, scale) = if has_offset { (cursor.f64()?, cursor.f64()?) } else { (0.0, 1.0) };
    if depth < 64 {
        skip_dictionary(cursor)?;
    }
    let prim = if &*prim == "/" { Rc::from("") } else { prim };
    Ok(Reference { asset, prim, has_offset: offset != 0.0 || scale != 1.0 })
}

fn skip_dictionary(cursor: &mut Cursor<'_>) -> Read<()> {
    for _ in 0..cursor.count(20)? {
        cursor.u32()?;
        let start = cursor.at;
        let offset = cursor.i64()?;
        let end =
            i64::try_from(start).ok().and_then(|s| s.checked_add(offset)).and_then(|e| e.checked_add(8));
        cursor.at = end.and_then(|e| usize::try_from(e).ok()).ok_or("a dictionary beyond all bytes")?;
    }
    Ok(())
}

/// Times and values of an animated attribute, sorted by time.
pub(super) fn samples(binary: &Binary, rep: Rep) -> Read<Vec<(f64, Rep)>> {
    let mut cursor = binary.cursor((rep.0 & 0xffff_ffff_ffff) as usize)?;
    let jump = |cursor: &mut Cursor<'_>| -> Read<()> {
        let start = cursor.at;
        let to = (start as i64).checked_add(cursor.i64()?).and_then(|to| usize::try_from(to).ok());
        cursor.at = to.ok_or("times beyond all bytes")?;
        Ok(())
    };
    jump(&mut cursor)?;
    let times = value(binary, Rep(cursor.u64()?), 0)?;
    let times = times.numbers().ok_or("times that are no numbers")?;
    jump(&mut cursor)?;
    let count = cursor.count(8)?;
    if count != times.len() || !times.iter().all(|t| t.is_finite()) {
        return Err(format!("{count} values at {} times", times.len()));
    }
    let values = (0..count).map(|_| cursor.u64().map(Rep)).collect::<Read<Vec<_>>>()?;
    let mut all: Vec<(f64, Rep)> = times.iter().copied().zip(values).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_what_their_bits_say() {
        let cases =
            [(0x3c00, 1.0), (0xc000, -2.0), (0x3555, 0.333_251_953_125), (0x0001, 5.960_464_477_539_063e-8)];
        for (bits, expected) in cases {
            assert_eq!(half(bits), expected, "{bits:#x}");
        }
        assert!(half(0x7c00).is_infinite() && half(0x7e00).is_nan());
    }
}
