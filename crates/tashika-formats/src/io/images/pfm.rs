//! Portable float maps: `PF` (colour) or `Pf` (grey), width, height, a scale whose sign gives the
//! byte order (negative: the least significant byte first), then rows from the bottom up.
//!
//! There is no specification. Values are multiplied by the magnitude of the scale, which most
//! programs write as 1. Tested in [`super`].

use super::{DecodedImage, Texels};

/// Returns true if the bytes begin like a float map.
pub(super) fn matches(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'F' | b'f', b' ' | b'\t' | b'\r' | b'\n', ..])
}

/// Decodes texels from the top row, if there are at most `max_texels`; the error describes the
/// fault.
pub(super) fn decode(bytes: &[u8], max_texels: u64) -> Result<DecodedImage, String> {
    let channels = if bytes[1] == b'F' { 3 } else { 1 };
    let mut rest = &bytes[2..];
    let mut word = |name: &str| {
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        let length = rest[start..].iter().position(u8::is_ascii_whitespace);
        let Some(length) = length else { return Err(format!("no {name} in its header")) };
        let word = String::from_utf8_lossy(&rest[start..start + length.min(40)]).into_owned();
        // One blank ends the header; the numbers follow.
        rest = &rest[start + length + 1..];
        Ok(word)
    };
    let mut size = [0_u32; 2];
    for (size, name) in size.iter_mut().zip(["width", "height"]) {
        let word = word(name)?;
        *size = word.parse().map_err(|_| format!("{name} {word:?}"))?;
    }
    let [width, height] = size;
    let scale = word("scale")?;
    let scale: f32 = scale
        .parse()
        .ok()
        .filter(|s: &f32| s.is_finite() && *s != 0.0)
        .ok_or_else(|| format!("scale {scale:?}"))?;
    super::check_size(width, height, max_texels)?;
    // After this check, the number of bytes to allocate is bounded by the length of the file.
    let needed = u64::from(width) * u64::from(height) * channels * 4;
    if needed > rest.len() as u64 {
        return Err(format!("{} bytes for {width}×{height} texels of {channels} channels", rest.len()));
    }
    let row = width as usize * channels as usize * 4;
    let number = |bytes: &[u8; 4]| {
        let value = if scale < 0.0 { f32::from_le_bytes(*bytes) } else { f32::from_be_bytes(*bytes) };
        value * scale.abs()
    };
    let rows = rest[..row * height as usize].chunks_exact(row).rev();
    let numbers = rows.flat_map(|row| row.as_chunks::<4>().0.iter().map(number));
    let texels = if channels == 1 {
        numbers.map(|v| [v; 3]).collect()
    } else {
        let flat: Vec<f32> = numbers.collect();
        flat.as_chunks::<3>().0.to_vec()
    };
    Ok(DecodedImage::new(width, height, Texels::Floats(texels)))
}
