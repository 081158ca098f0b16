//! TIFF images, including those of `maketx` (`.tx`): strips or tiles, interleaved or plane by
//! plane, of 8, 16 or 32 bits.
//!
//! Only the first image of a file is read, which in mip-mapped files is the largest level. If a
//! texel has three samples or more, the first three are its colour; otherwise the first is its grey
//! value. The next sample is opacity if the file declares it. If the file declares that colours
//! were multiplied by opacity, they are divided by it. Integers of 8 and 16 bits are unchanged;
//! floating point of 16, 32 and 64 bits becomes 32. Other kinds (bilevel, CMYK) are left to the
//! `image` crate. Two layouts are refused because the `tiff` crate (0.11) misreads them or panics:
//! separate planes in tiles that reach beyond the last row, and colours followed by samples other
//! than opacity.
//!
//! # Guarantee
//! No more than [`MOST_PACKED`] bytes are allocated for each byte of the file. Tested in [`super`].

use std::io::Cursor;

use ::tiff::ColorType;
use ::tiff::decoder::{ChunkType, Decoder, DecodingResult, Limits};
use ::tiff::tags::{ExtraSamples, Tag};

use super::{DECODER_SLACK, DecodedImage, Texels};

/// Largest number of bytes of texels for each byte of a file: LZW reaches 1335 with its longest
/// strings, Deflate 1032, JPEG 512 with blocks of two bits.
const MOST_PACKED: u64 = 2000;

/// Decodes texels from the top row, if there are at most `max_texels`; the error describes the
/// fault. Returns none for kinds that are left to the `image` crate.
pub(super) fn decode(bytes: &[u8], max_texels: u64) -> Result<Option<DecodedImage>, String> {
    let [width, height, samples] = claims(bytes).unwrap_or([1; 3]);
    super::check_size(width, height, max_texels)?;
    // The decoder multiplies height and samples before it checks them.
    if height.saturating_mul(samples) > u64::from(u32::MAX) {
        return Err(format!("{height} rows of {samples} samples a texel"));
    }
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let (width, height) = decoder.dimensions().map_err(|e| e.to_string())?;
    super::check_size(width, height, max_texels)?;
    let color = decoder.colortype().map_err(|e| e.to_string())?;
    let (colors, bits) = match color {
        ColorType::Gray(bits) | ColorType::Multiband { bit_depth: bits, .. } => (1, bits),
        ColorType::RGB(bits) | ColorType::RGBA(bits) => (3, bits),
        _ => return Ok(None),
    };
    if ![8, 16, 32, 64].contains(&bits) {
        return Ok(None);
    }
    let samples =
        decoder.find_tag_unsigned::<u16>(Tag::SamplesPerPixel).map_err(|e| e.to_string())?.unwrap_or(1);
    if samples != color.num_samples() {
        return Err(format!("{samples} samples a texel, of which some are neither colour nor opacity"));
    }
    let layout = decoder.image_buffer_layout().map_err(|e| e.to_string())?;
    if layout.planes > 1
        && decoder.get_chunk_type() == ChunkType::Tile
        && !height.is_multiple_of(decoder.chunk_dimensions().1)
    {
        return Err("planes in tiles that reach beyond the last row".to_owned());
    }
    let (claimed, packed) = (layout.complete_len as u64, bytes.len() as u64);
    if claimed > packed.saturating_mul(MOST_PACKED) {
        return Err(format!("{claimed} bytes of texels in a file of {packed} bytes"));
    }
    let extra = decoder.find_tag_unsigned_vec::<u16>(Tag::ExtraSamples).map_err(|e| e.to_string())?;
    let alpha = match extra.as_deref().and_then(<[u16]>::first).copied().map(ExtraSamples::from_u16) {
        Some(Some(ExtraSamples::AssociatedAlpha)) => Alpha::Multiplied,
        Some(Some(ExtraSamples::UnassociatedAlpha)) => Alpha::Straight,
        Some(_) => Alpha::None,
        // If a file has four samples of colour and declares no opacity, the fourth counts as
        // opacity.
        None if matches!(color, ColorType::RGBA(_)) => Alpha::Straight,
        None => Alpha::None,
    };
    let mut limits = Limits::default();
    limits.decoding_buffer_size = layout.complete_len;
    // Memory for a strip or a tile, which may be larger than the picture.
    limits.intermediate_buffer_size = usize::try_from(claimed + DECODER_SLACK).unwrap_or(usize::MAX);
    let mut decoder = decoder.with_limits(limits);
    let mut samples = DecodingResult::U8(Vec::new());
    decoder.read_image_to_buffer(&mut samples).map_err(|e| e.to_string())?;
    let arranged =
        Arranged { texels: width as usize * height as usize, colors, alpha, planes: layout.planes };
    let texels = match samples {
        DecodingResult::U8(all) => Texels::Eight(arranged.with_opacity(&all, u8::MAX)?),
        DecodingResult::U16(all) => Texels::Sixteen(arranged.with_opacity(&all, u16::MAX)?),
        DecodingResult::F16(all) => Texels::Floats(arranged.colors(&all, |v| v.to_f32())?),
        DecodingResult::F32(all) => Texels::Floats(arranged.colors(&all, |v| v)?),
        DecodingResult::F64(all) => Texels::Floats(arranged.colors(&all, |v| v as f32)?),
        _ => return Ok(None),
    };
    Ok(Some(DecodedImage::new(width, height, texels)))
}

/// Width, height and samples per texel of the first image. If the file states one of them several
/// times, the largest value counts. None if the file ends before them.
fn claims(bytes: &[u8]) -> Option<[u64; 3]> {
    let number = |at: u64, size: usize| {
        let at = usize::try_from(at).ok()?;
        let digits = bytes.get(at..at.checked_add(size)?)?;
        let add = |sum: u64, digit: &u8| sum << 8 | u64::from(*digit);
        Some(if bytes[0] == b'M' { digits.iter().fold(0, add) } else { digits.iter().rev().fold(0, add) })
    };
    // Files of more than 4 GB have addresses and counts of eight bytes.
    let big = number(2, 2)? == 43;
    let (start, count) = if big { (number(8, 8)?, 8) } else { (number(4, 4)?, 2) };
    let (entry, value) = if big { (20, 12) } else { (12, 8) };
    let mut claims = [1; 3];
    for i in 0..number(start, count)?.min(u64::from(u16::MAX)) {
        let at = start.checked_add(count as u64 + i * entry)?;
        let claim = match number(at, 2)? {
            256 => &mut claims[0],
            257 => &mut claims[1],
            277 => &mut claims[2],
            _ => continue,
        };
        let size = match number(at + 2, 2)? {
            1 => 1,
            3 => 2,
            4 => 4,
            16 if big => 8,
            _ => continue,
        };
        *claim = number(at + value, size)?.max(*claim);
    }
    Some(claims)
}

/// Meaning of the sample after the colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Alpha {
    None,
    Straight,
    /// Opacity that the colours have been multiplied by.
    Multiplied,
}

/// Arrangement of the samples of texels.
struct Arranged {
    texels: usize,
    /// 1 or 3.
    colors: usize,
    alpha: Alpha,
    /// Number of planes; if more than one, samples are stored plane by plane.
    planes: usize,
}

impl Arranged {
    /// Applies `at` to each texel, given the texel's samples by index.
    fn map<T: Copy, R>(&self, all: &[T], at: impl Fn(&dyn Fn(usize) -> T) -> R) -> Result<Vec<R>, String> {
        let samples = all.len() / self.texels;
        let least = self.colors + usize::from(self.alpha != Alpha::None);
        if !all.len().is_multiple_of(self.texels) || samples < least {
            return Err(format!("{} samples for {} texels of {least} samples", all.len(), self.texels));
        }
        let [of_texel, of_sample] = if self.planes > 1 { [1, self.texels] } else { [samples, 1] };
        Ok((0..self.texels).map(|i| at(&|sample| all[i * of_texel + sample * of_sample])).collect())
    }

    /// Integers with opacity. Colours that were multiplied by opacity are divided by it; `opaque`
    /// is the largest integer.
    fn with_opacity<T: Copy + Into<u64> + TryFrom<u64>>(
        &self,
        all: &[T],
        opaque: T,
    ) -> Result<Vec<[T; 4]>, String> {
        let most: u64 = opaque.into();
        self.map(all, |sample| {
            let alpha = if self.alpha == Alpha::None { opaque } else { sample(self.colors) };
            let color = |value: T| match (self.alpha, alpha.into()) {
                (Alpha::Multiplied, a @ 1..) => {
                    T::try_from(((value.into() * most + a / 2) / a).min(most)).unwrap_or(opaque)
                }
                _ => value,
            };
            let [r, g, b] = [0, 1, 2].map(|i: usize| color(sample(i.min(self.colors - 1))));
            [r, g, b, alpha]
        })
    }

    fn colors<T: Copy>(&self, all: &[T], of: impl Fn(T) -> f32) -> Result<Vec<[f32; 3]>, String> {
        self.map(all, |sample| [0, 1, 2].map(|i: usize| of(sample(i.min(self.colors - 1)))))
    }
}
