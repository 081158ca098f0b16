//! OpenEXR images as textures and environments: a flat part with colours, in scan lines or tiles,
//! of any sample type.
//!
//! # Windows
//! The image is the **display window**. Texels of the data window that lie outside of the display
//! window are cut off. Texels of the display window that lie outside of the data window are 0.
//!
//! # Channels
//! Channels are selected by name; upper and lower case count as equal. Among all parts and layers,
//! the one that matches the earliest row of the table is read; of several, the first one.
//!
//! | order | channels | colour |
//! |---|---|---|
//! | 1 | `R`, `G`, `B` | as named |
//! | 2 | `layer.R`, `layer.G`, `layer.B` | as named |
//! | 3 | `Y`, then `layer.Y`, without an `X` beside it | grey |
//! | 4 | some of `R`, `G`, `B`, then of a layer's | as named, 0 for missing channels |
//! | 5 | the only channel of a part, whatever its name | grey, with a note |
//!
//! Opacities and further channels are ignored. Colours with `chromaticities` other than those of
//! Rec. 709 are converted to Rec. 709; white stays white.
//!
//! # Guarantee
//! A display window that is larger than the data window takes at most [`FREE_BYTES`], or
//! [`MOST_PACKED`] bytes for each byte of the file if that is more.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use ::exr::block::chunk::CompressedBlock;
use ::exr::image::FlatSamples;
use ::exr::image::read::any_channels::ReadAnyChannels;
use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::layers::ReadChannels;
use ::exr::image::read::samples::ReadFlatSamples;
use ::exr::meta::BlockDescription;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{Chromaticities, IntegerBounds, LevelMode};
use ::exr::meta::header::Header;
use ::exr::prelude::Vec2;

use super::{DecodedImage, Texels};
use crate::color::{Primaries, White, transformed};
use crate::io::exr::check_claims;
use crate::scene::Channel;

/// First bytes of an OpenEXR file.
pub(super) const SIGNATURE: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Largest number of channels of a part; chosen.
const MAX_CHANNELS: usize = 256;

/// Bytes of texels permitted for every display window: 2048 × 2048.
const FREE_BYTES: u64 = 12 << 22;

/// Bytes of texels that a display window may take for each byte of the file: the largest ratio that
/// compression reaches.
const MOST_PACKED: u64 = 2000;

/// Decodes texels from the top row, if there are at most `max_texels`; the error describes the
/// fault.
pub(super) fn decode(bytes: &[u8], name: &str, max_texels: u64) -> Result<DecodedImage, String> {
    check_claims(Path::new(name), bytes).map_err(|e| e.to_string())?;
    let meta = MetaData::read_from_buffered(bytes, false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        super::check_size(width, height, max_texels)?;
        if header.channels.list.len() > MAX_CHANNELS {
            return Err(format!("{} channels", header.channels.list.len()));
        }
    }
    if meta.headers.iter().any(has_levels) {
        check_levels(bytes)?;
    }
    // The part with the lowest order in the table above, and the first of several.
    let of_parts = meta.headers.iter().filter_map(|part| Some((part, Colors::of(part)?)));
    let Some((part, colors)) = of_parts.min_by_key(|(_, colors)| colors.order) else {
        let names = meta.headers.iter().flat_map(|part| &part.channels.list).take(8);
        let names: Vec<String> = names.map(|channel| channel.name.to_string()).collect();
        return Err(format!("channels {} without R, G, B or Y", names.join(", ")));
    };
    let (display, data) = (part.shared_attributes.display_window, part.data_window());
    let Vec2(width, height) = display.size;
    super::check_size(width, height, max_texels)?;
    let claimed = 12 * width as u64 * height as u64;
    if display.size.area() > data.size.area()
        && claimed > FREE_BYTES.max(MOST_PACKED.saturating_mul(bytes.len() as u64))
    {
        let (data, length) = (data.size, bytes.len());
        return Err(format!(
            "a display window of {width}×{height} for {}×{} texels in a file of {length} bytes",
            data.0, data.1
        ));
    }
    let image = OfPart { part }
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let channels = image.layer_data.channel_data.list;
    let rows = of_chromaticities(image.attributes.chromaticities)?;
    let sample =
        |place: Option<usize>, i: usize| place.map_or(0.0, |place| value(&channels[place].sample_data, i));
    let color = |i: usize| {
        let color = colors.places.map(|place| sample(place, i));
        rows.map_or(color, |rows| transformed(&rows, color.into()).to_array())
    };
    let mut approximations = Vec::new();
    if let Some(channel) = &colors.only {
        approximations.push(format!("its only channel {channel:?} is taken as grey"));
    }
    let (texels, is_outside) = in_window(display, data, color);
    if is_outside {
        approximations.push("its data window lies outside of its display window: 0 everywhere".to_owned());
    }
    // Both fit into `u32`, as `check_size` requires.
    let (width, height) = (width as u32, height as u32);
    Ok(DecodedImage { width, height, texels: Texels::Floats(texels), lone: colors.lone(), approximations })
}

/// Copies the texels of the data window to the display window. The flag is true if the two windows
/// are disjoint.
fn in_window(
    display: IntegerBounds,
    data: IntegerBounds,
    texel: impl Fn(usize) -> [f32; 3],
) -> (Vec<[f32; 3]>, bool) {
    let Vec2(width, height) = display.size;
    let Vec2(data_width, data_height) = data.size;
    // Offset from a row or column of the data window to that of the display window.
    let shift = |data: i32, display: i32| i64::from(data) - i64::from(display);
    let [left, top] =
        [shift(data.position.0, display.position.0), shift(data.position.1, display.position.1)];
    let inside = |place: usize, shift: i64, size: usize| {
        usize::try_from(place as i64 + shift).ok().filter(|&place| place < size)
    };
    let mut texels = vec![[0.0; 3]; width * height];
    let mut is_outside = true;
    for y in 0..data_height {
        let Some(row) = inside(y, top, height) else { continue };
        for x in 0..data_width {
            let Some(column) = inside(x, left, width) else { continue };
            texels[row * width + column] = texel(y * data_width + x);
            is_outside = false;
        }
    }
    (texels, is_outside)
}

/// Colour channels of a part.
struct Colors {
    /// Row of the table above; plain names come before layers.
    order: u32,
    /// Indices of the red, green and blue channel.
    places: [Option<usize>; 3],
    /// Name of the channel, if it is the only one of the part.
    only: Option<String>,
}

impl Colors {
    fn of(part: &Header) -> Option<Self> {
        // Indices of R, G, B, Y and X by layer; plain names come first.
        let mut layers: BTreeMap<&[u8], [Option<usize>; 5]> = BTreeMap::new();
        let list = &part.channels.list;
        for (place, channel) in list.iter().enumerate() {
            let name = channel.name.as_slice();
            let (layer, letter) = match name.iter().rposition(|b| *b == b'.') {
                Some(point) => (&name[..point], &name[point + 1..]),
                None => (&name[..0], name),
            };
            let letter = match letter.to_ascii_lowercase().as_slice() {
                b"r" => 0,
                b"g" => 1,
                b"b" => 2,
                b"y" => 3,
                b"x" => 4,
                _ => continue,
            };
            // Of two names that differ only in case, the first counts, which is the one in upper
            // case.
            layers.entry(layer).or_default()[letter].get_or_insert(place);
        }
        let found = layers.iter().filter_map(|(layer, &[r, g, b, y, x])| {
            let (rgb, is_plain) = ([r, g, b], layer.is_empty());
            let (order, places) = if rgb.iter().all(Option::is_some) {
                (0, rgb)
            } else if y.is_some() && x.is_none() {
                (2, [y; 3])
            } else if rgb.iter().any(Option::is_some) {
                (4, rgb)
            } else {
                return None;
            };
            Some(Self { order: order + u32::from(!is_plain), places, only: None })
        });
        let only = || match list.as_slice() {
            [channel] => Some(Self { order: 6, places: [Some(0); 3], only: Some(channel.name.to_string()) }),
            _ => None,
        };
        found.min_by_key(|colors| colors.order).or_else(only)
    }

    /// Returns the only channel of the colour, if there is just one.
    fn lone(&self) -> Option<Channel> {
        match self.places.map(|place| place.is_some()) {
            [true, false, false] => Some(Channel::R),
            [false, true, false] => Some(Channel::G),
            [false, false, true] => Some(Channel::B),
            _ => None,
        }
    }
}

/// Reads the largest level of all channels of one part.
struct OfPart<'h> {
    part: &'h Header,
}

impl<'s> ReadChannels<'s> for OfPart<'_> {
    type Reader = <ReadAnyChannels<ReadFlatSamples> as ReadChannels<'s>>::Reader;

    fn create_channels_reader(&'s self, header: &Header) -> ::exr::error::Result<Self::Reader> {
        let named = |header: &Header| header.own_attributes.layer_name.clone();
        let is_it = named(header) == named(self.part)
            && header.channels == self.part.channels
            && header.layer_size == self.part.layer_size;
        if !is_it {
            return Err(::exr::error::Error::Invalid("another part".into()));
        }
        ReadAnyChannels { read_samples: ReadFlatSamples }.create_channels_reader(header)
    }
}

fn has_levels(header: &Header) -> bool {
    matches!(header.blocks, BlockDescription::Tiles(tiles) if tiles.level_mode != LevelMode::Singular)
}

/// Refuses files in which a tile states another level than the table of the file gives it. The
/// reader trusts the table and would not notice.
fn check_levels(bytes: &[u8]) -> Result<(), String> {
    const LARGEST: Vec2<usize> = Vec2(0, 0);
    let reader = ::exr::block::read(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    let chunks = reader.filter_chunks(false, |_, tile, _| tile.level_index == LARGEST);
    for chunk in chunks.map_err(|e| e.to_string())? {
        if let CompressedBlock::Tile(tile) = chunk.map_err(|e| e.to_string())?.compressed_block
            && tile.coordinates.level_index != LARGEST
        {
            return Err("a tile of another level than the file's table says".to_owned());
        }
    }
    Ok(())
}

/// Matrix to Rec. 709, by rows; none if it is the identity.
fn of_chromaticities(given: Option<Chromaticities>) -> Result<Option<[[f32; 3]; 3]>, String> {
    let Some(given) = given else { return Ok(None) };
    let [red, green, blue, white] =
        [given.red, given.green, given.blue, given.white].map(|Vec2(x, y)| [f64::from(x), f64::from(y)]);
    let primaries = Primaries { rgb: [red, green, blue], white };
    let rows = primaries.to_rec709(White::Adapted);
    let rows = rows.ok_or_else(|| format!("chromaticities {given:?} that span no colours"))?;
    // Rec. 709's own primaries, written with four digits, count as the identity.
    let is_identity = |(i, row): (usize, &[f32; 3])| {
        row.iter().enumerate().all(|(j, v)| (v - f32::from(u8::from(i == j))).abs() < 1e-3)
    };
    Ok((!rows.iter().enumerate().all(is_identity)).then_some(rows))
}

fn value(samples: &FlatSamples, i: usize) -> f32 {
    match samples {
        FlatSamples::F32(values) => values[i],
        FlatSamples::F16(values) => values[i].to_f32(),
        FlatSamples::U32(values) => values[i] as f32,
    }
}

#[cfg(test)]
mod tests;
