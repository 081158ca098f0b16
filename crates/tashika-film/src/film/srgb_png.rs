//! Eight-bit pictures as PNG files that declare their colour space.
//!
//! Without a declaration, viewers may interpret the samples in any colour space. So the file has
//! the chunk `sRGB` (intent: perceptual). Readers that do not know it find `gAMA` and `cHRM`, with
//! the values that the specification gives for such files (Portable Network Graphics, third
//! edition, section 11.3.2.5).
//!
//! # Guarantee
//! Equal pictures give equal bytes.
//!
//! # Held to this by
//! The tests below.

use png::{BitDepth, ColorType, Compression, Encoder, Filter, ScaledFloat, SourceChromaticities};

/// Encodes a picture as a PNG file and returns the bytes of the file.
///
/// * `bytes`: three (R, G, B) or four (with opacity) sRGB bytes for each pixel, row by row.
///
/// # Panics
/// If the picture has no pixels, or `bytes` has neither three nor four bytes per pixel.
pub fn srgb_png(size: [u32; 2], bytes: &[u8]) -> Vec<u8> {
    let pixels = size[0] as usize * size[1] as usize;
    let color = match bytes.len() {
        count if count == 3 * pixels => ColorType::Rgb,
        count if count == 4 * pixels => ColorType::Rgba,
        count => panic!("{count} bytes for {pixels} pixels"),
    };
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_source_gamma(ScaledFloat::from_scaled(45_455));
    let [white, red, green, blue] = [[31_270, 32_900], [64_000, 33_000], [30_000, 60_000], [15_000, 6_000]]
        .map(|[x, y]| {
            let [x, y] = [x, y].map(ScaledFloat::from_scaled);
            (x, y)
        });
    encoder.set_source_chromaticities(SourceChromaticities { white, red, green, blue });
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(bytes)?;
        writer.finish()
    });
    written.expect("a picture of some pixels, written to memory");
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names and contents of the chunks, in order.
    fn chunks(file: &[u8]) -> Vec<(&str, &[u8])> {
        let mut rest = file.strip_prefix(b"\x89PNG\r\n\x1a\n").expect("the signature");
        let mut chunks = Vec::new();
        while !rest.is_empty() {
            let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
            chunks.push((std::str::from_utf8(&rest[4..8]).unwrap(), &rest[8..8 + length]));
            rest = &rest[12 + length..];
        }
        chunks
    }

    #[test]
    fn the_file_says_what_its_numbers_mean_before_it_tells_them() {
        let file = srgb_png([2, 1], &[0, 128, 255, 1, 2, 3]);
        let chunks = chunks(&file);
        let place = |name| chunks.iter().position(|(n, _)| *n == name).expect(name);
        let content = |name| chunks[place(name)].1;
        assert_eq!(content("sRGB"), [0], "perceptual");
        assert_eq!(content("gAMA"), 45_455_u32.to_be_bytes());
        let fallback = [31_270, 32_900, 64_000, 33_000, 30_000, 60_000, 15_000, 6_000_u32];
        assert_eq!(content("cHRM"), fallback.map(u32::to_be_bytes).concat());
        for name in ["sRGB", "gAMA", "cHRM"] {
            assert!(place(name) < place("IDAT"), "{name}");
            assert_eq!(chunks.iter().filter(|(n, _)| *n == name).count(), 1, "{name}");
        }
        assert_eq!((chunks[0].0, chunks[chunks.len() - 1].0), ("IHDR", "IEND"));
    }

    #[test]
    fn the_bytes_come_back_with_and_without_opacity() {
        let bytes: Vec<u8> = (0..24).map(|i| (i * 37) as u8).collect();
        let opaque = image::load_from_memory(&srgb_png([4, 2], &bytes)).unwrap();
        assert_eq!(opaque.as_rgb8().expect("three channels").as_raw(), &bytes);
        let other = image::load_from_memory(&srgb_png([2, 3], &bytes)).unwrap();
        assert_eq!(other.as_rgba8().expect("four channels").as_raw(), &bytes);
        assert_eq!(srgb_png([2, 3], &bytes), srgb_png([2, 3], &bytes));
    }

    #[test]
    #[should_panic(expected = "5 bytes for 2 pixels")]
    fn a_missing_byte_is_a_bug() {
        srgb_png([2, 1], &[0; 5]);
    }
}
