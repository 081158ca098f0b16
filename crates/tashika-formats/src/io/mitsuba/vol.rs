//! Mitsuba's volume files, `.vol`, of version 3.
//!
//! ```text
//! file = "VOL", version (1 byte), type (4 bytes, 1 is f32), cells along x, y, z (4 bytes each),
//!        channels (4 bytes), lowest corner, highest corner (3 f32 each),
//!        values (f32; channels fastest, then x, then y)
//! ```
//!
//! All little endian. Only numbers of type 1 in one or in three channels are read.
//!
//! # Guarantee
//! Memory grows only with the bytes of the file: counts that need more are refused.
//!
//! Source: [^mitsuba06], plugin `gridvolume`. Held to this by the tests below and
//! `suite::damaged_mitsuba`.

use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::scene::VolumeValues;

/// Type of numbers that is read.
const FLOAT: u32 = 1;
/// Bytes before the values.
const HEADER: usize = 48;

/// Contents of a volume file.
#[derive(Debug)]
pub(super) struct Vol {
    /// Cells along each axis.
    pub(super) counts: [u32; 3],
    /// Values of the cells, those along x fastest.
    pub(super) values: VolumeValues,
    /// Lowest and highest corner of the volume's box.
    pub(super) bounds: [[f32; 3]; 2],
}

/// Reads a file.
///
/// # Errors
/// [`Error::Invalid`] if the file is no such volume or ends too early, [`Error::Unsupported`] if
/// its numbers are of another type.
pub(super) fn read(bytes: &[u8], at: &Location) -> Result<Vol> {
    let invalid = |found: String, expected: &str| Err(Error::invalid(at.clone(), found, expected));
    let Some((header, rest)) = bytes.split_first_chunk::<HEADER>() else {
        return invalid(format!("a volume of {} bytes", bytes.len()), "a header of 48 bytes");
    };
    let (words, _) = header.as_chunks::<4>();
    let integer = |i: usize| u32::from_le_bytes(words[i]);
    let [v, o, l, version] = words[0];
    if [v, o, l] != *b"VOL" {
        return invalid(format!("a file that begins with {v:02x} {o:02x} {l:02x}"), "a volume: \"VOL\"");
    }
    if version != 3 {
        return invalid(format!("a volume of version {version}"), "version 3");
    }
    if integer(1) != FLOAT {
        let names = ["16-bit floats", "bytes", "quantized directions"];
        let name = (integer(1) as usize).checked_sub(2).and_then(|i| names.get(i)).copied();
        let what =
            format!("a volume of type {}{}", integer(1), name.map_or(String::new(), |n| format!(" ({n})")));
        return Err(Error::unsupported(at.clone(), what, "write it as type 1, 32-bit floats"));
    }
    let counts = [2, 3, 4].map(integer);
    let channels = integer(5);
    if channels != 1 && channels != 3 {
        return Err(Error::unsupported(
            at.clone(),
            format!("a volume of {channels} channels"),
            "write it with 1 channel, or with 3 for red, green and blue",
        ));
    }
    let [x, y, z] = counts.map(u128::from);
    let needed =
        (x * y).checked_mul(z * u128::from(channels) * 4).filter(|&n| n > 0 && n <= rest.len() as u128);
    let Some(needed) = needed else {
        let found = format!("a volume of {x}×{y}×{z} cells with {channels} channels in {} bytes", rest.len());
        return invalid(found, "at least one cell, and 4 bytes for each number");
    };
    let (numbers, _) = rest[..needed as usize].as_chunks::<4>();
    let number = |bytes: &[u8; 4]| f32::from_le_bytes(*bytes);
    let values = if channels == 1 {
        VolumeValues::Numbers(numbers.iter().map(number).collect())
    } else {
        let (colors, _) = numbers.as_chunks::<3>();
        VolumeValues::Colors(colors.iter().map(|c| Rgb::from(c.each_ref().map(number))).collect())
    };
    let corner = |first: usize| [0, 1, 2].map(|k| number(&words[first + k]));
    Ok(Vol { counts, values, bounds: [corner(6), corner(9)] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(kind: u32, counts: [u32; 3], channels: u32, values: &[f32]) -> Vec<u8> {
        let mut bytes = b"VOL\x03".to_vec();
        let header = [kind, counts[0], counts[1], counts[2], channels];
        header.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        [-1.0, -2.0, -3.0, 1.0, 2.0, 3.0]
            .iter()
            .chain(values)
            .for_each(|n: &f32| bytes.extend(n.to_le_bytes()));
        bytes
    }

    fn numbers<const N: usize>() -> [f32; N] {
        std::array::from_fn(|i| i as f32)
    }

    #[test]
    fn numbers_and_colours_are_read_in_their_order() {
        let at = Location::file("a.vol");
        let one = read(&file(1, [3, 2, 1], 1, &numbers::<6>()), &at).unwrap();
        assert_eq!((one.counts, one.values), ([3, 2, 1], VolumeValues::Numbers(numbers::<6>().to_vec())));
        assert_eq!(one.bounds, [[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]]);
        let three = read(&file(1, [1, 2, 1], 3, &numbers::<6>()), &at).unwrap();
        let colors = vec![Rgb::new(0.0, 1.0, 2.0), Rgb::new(3.0, 4.0, 5.0)];
        assert_eq!(three.values, VolumeValues::Colors(colors));
        // Bytes after the values are ignored.
        assert_eq!(read(&file(1, [1, 1, 1], 1, &numbers::<6>()), &at).unwrap().values.len(), 1);
    }

    #[test]
    fn other_files_are_refused_with_what_would_be_read() {
        let at = Location::file("a.vol");
        let said = |bytes: &[u8]| read(bytes, &at).unwrap_err().to_string();
        let whole = file(1, [3, 2, 1], 1, &numbers::<6>());
        assert!(said(b"VOL\x03").contains("a volume of 4 bytes; expected a header"));
        assert!(said(&[b"PLY".as_slice(), &whole[3..]].concat()).contains("begins with 50 4c 59"));
        assert!(
            said(&[b"VOL\x04".as_slice(), &whole[4..]].concat()).contains("version 4; expected version 3")
        );
        let bytes = said(&file(3, [3, 2, 1], 1, &numbers::<6>()));
        assert!(bytes.contains("type 3 (bytes)") && bytes.contains("32-bit floats"), "{bytes}");
        assert!(said(&file(0, [1; 3], 1, &[0.0])).contains("type 0 is not supported"));
        assert!(said(&file(1, [1; 3], 6, &numbers::<6>())).contains("6 channels"));
        for counts in [[0, 1, 1], [3, 3, 1], [u32::MAX, u32::MAX, u32::MAX], [1 << 31, 1 << 31, 4]] {
            for channels in [1, 3] {
                assert!(
                    said(&file(1, counts, channels, &numbers::<6>())).contains("4 bytes for each number")
                );
            }
        }
    }

    #[test]
    fn damaged_bytes_give_errors() {
        let whole = file(1, [3, 2, 1], 1, &numbers::<6>());
        let at = Location::file("a.vol");
        for length in 0..whole.len() {
            assert!(read(&whole[..length], &at).is_err(), "{length}");
        }
        for i in 0..whole.len() {
            for bit in 0..8 {
                let mut flipped = whole.clone();
                flipped[i] ^= 1 << bit;
                // A volume or an error is fine; a panic is not.
                let _ = read(&flipped, &at);
            }
        }
    }
}
