//! Layouts of a film in an OpenEXR file, other than the default.
//!
//! Only lossless compressions are offered, because the claims of a film hold for its exact pixel
//! values.

use std::fmt;
use std::str::FromStr;

use ::exr::image::{Blocks, Encoding};
use ::exr::meta::attribute::LineOrder;
use ::exr::prelude::{Compression, Vec2};

use crate::error::{Error, Result};

/// Side of a tile (pixels).
const TILE: usize = 64;

/// Layout of an OpenEXR file. A film that is read back from any layout is the same, bit by bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExrLayout {
    /// True if each plane is stored as a separate part with the name of the plane. By default, all
    /// planes are channels of a single part, which every program reads.
    pub parts: bool,
    /// True if samples are in tiles of 64×64 pixels, not in lines.
    pub tiles: bool,
    /// Lossless compression of all samples.
    pub compression: ExrCompression,
}

/// A lossless compression.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExrCompression {
    /// No compression.
    None,
    /// Runs of equal bytes.
    Rle,
    /// ZIP, line by line.
    Zips,
    /// ZIP, 16 lines at a time.
    #[default]
    Zip,
    /// Wavelets, 32 lines at a time.
    Piz,
}

impl ExrCompression {
    /// All compressions that can be chosen.
    pub const ALL: [Self; 5] = [Self::None, Self::Rle, Self::Zips, Self::Zip, Self::Piz];

    /// Name of the compression in the text form of an [`ExrLayout`].
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rle => "rle",
            Self::Zips => "zips",
            Self::Zip => "zip",
            Self::Piz => "piz",
        }
    }

    fn of_format(self) -> Compression {
        match self {
            Self::None => Compression::Uncompressed,
            Self::Rle => Compression::RLE,
            Self::Zips => Compression::ZIP1,
            Self::Zip => Compression::ZIP16,
            Self::Piz => Compression::PIZ,
        }
    }
}

impl ExrLayout {
    pub(super) fn encoding(&self) -> Encoding {
        Encoding {
            compression: self.compression.of_format(),
            blocks: if self.tiles { Blocks::Tiles(Vec2(TILE, TILE)) } else { Blocks::ScanLines },
            line_order: LineOrder::Increasing,
        }
    }
}

impl fmt::Display for ExrLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words = [(self.parts, "parts"), (self.tiles, "tiles")];
        words.iter().filter(|(is, _)| *is).try_for_each(|(_, word)| write!(f, "{word},"))?;
        f.write_str(self.compression.name())
    }
}

impl FromStr for ExrLayout {
    type Err = Error;

    /// Parses words with commas between them, each at most once: `parts`, `tiles`, and a
    /// compression.
    ///
    /// # Errors
    /// [`Error::Option`] naming `exr` if the text is anything else. For a lossy compression, the
    /// error gives the reason.
    fn from_str(text: &str) -> Result<Self> {
        let refused = |expected: &str| {
            let lossless = ExrCompression::ALL.map(ExrCompression::name).join(", ");
            let expected = format!("{expected}parts, tiles and one of {lossless}, with commas between them");
            Error::option("exr", text, expected)
        };
        let (mut layout, mut compression) = (Self::default(), None);
        for word in text.split(',').map(str::trim) {
            let known = ExrCompression::ALL.into_iter().find(|known| known.name() == word);
            let again = match (word, known) {
                ("parts", _) => std::mem::replace(&mut layout.parts, true),
                ("tiles", _) => std::mem::replace(&mut layout.tiles, true),
                (_, Some(known)) => compression.replace(known).is_some(),
                ("pxr24" | "b44" | "b44a" | "dwaa" | "dwab" | "htj2k", _) => {
                    return Err(refused("what keeps all bits, of which claims are, as that does not: "));
                }
                _ => return Err(refused("")),
            };
            if again {
                return Err(refused("each word once: "));
            }
        }
        Ok(Self { compression: compression.unwrap_or_default(), ..layout })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_said_as_they_are_typed_and_what_loses_bits_is_refused() {
        for (typed, said) in [
            ("zip", "zip"),
            ("parts", "parts,zip"),
            ("piz,tiles", "tiles,piz"),
            ("tiles, none ,parts", "parts,tiles,none"),
            ("rle", "rle"),
            ("zips", "zips"),
        ] {
            let layout: ExrLayout = typed.parse().unwrap();
            assert_eq!(layout.to_string(), said);
            assert_eq!(said.parse::<ExrLayout>().unwrap(), layout);
        }
        let refusal = |typed: &str| typed.parse::<ExrLayout>().unwrap_err().to_string();
        for typed in ["", "deep", "zip,", "PIZ"] {
            assert_eq!(
                refusal(typed),
                format!(
                    "exr = {typed}; expected parts, tiles and one of none, rle, zips, zip, piz, with commas between them"
                )
            );
        }
        assert!(refusal("tiles,dwaa").contains("keeps all bits, of which claims are"), "{}", refusal("dwaa"));
        for twice in ["zip,piz", "parts,parts", "tiles,zip,tiles"] {
            assert!(refusal(twice).contains("each word once"), "{twice}");
        }
    }
}
