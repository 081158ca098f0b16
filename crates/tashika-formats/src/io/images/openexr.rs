//! OpenEXR images as textures and environments: the first flat part, by scan lines or tiles, of any
//! sample type.
//!
//! Colour is in the channels `R G B`, or in those of the first layer that has some (`layer.R`);
//! else `Y` is grey. The image is the data window; opacities and further channels are left out.
//! Colours of other `chromaticities` than Rec. 709's become Rec. 709's, white becoming white.
//! Tested in [`super`].

use std::io::Cursor;
use std::path::Path;

use ::exr::block::chunk::CompressedBlock;
use ::exr::image::FlatSamples;
use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::layers::ReadChannels;
use ::exr::meta::BlockDescription;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{Chromaticities, LevelMode};
use ::exr::meta::header::Header;
use ::exr::prelude::{Vec2, read};

use super::{Picture, Texels};
use crate::color::{Primaries, White, transformed};
use crate::io::exr::check_claims;

/// First bytes of such a file.
pub(super) const SIGNATURE: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Most channels of an image; chosen.
const MAX_CHANNELS: usize = 256;

/// The texels from the top row, if there are no more than `max_texels`; what is wrong, otherwise.
pub(super) fn decode(bytes: &[u8], name: &str, max_texels: u64) -> Result<Picture, String> {
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
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let layer = image.layer_data;
    let channels: Vec<(String, FlatSamples)> = layer
        .channel_data
        .list
        .into_iter()
        .map(|c| (String::from_utf8_lossy(c.name.as_slice()).into_owned(), c.sample_data))
        .collect();
    let find = |name: &str| channels.iter().find(|(n, _)| n == name).map(|(_, samples)| samples);
    // Names are sorted, so that a layer's blue comes first; the plain name sorts anywhere.
    let prefixes = || channels.iter().filter_map(|(name, _)| name.strip_suffix('R'));
    let layers = std::iter::once("").chain(prefixes().filter(|p| p.ends_with('.')));
    let color = |prefix: &str| {
        let channel = |letter: char| find(&format!("{prefix}{letter}"));
        Some([channel('R')?, channel('G')?, channel('B')?])
    };
    let grey = || find("Y").map(|y| [y; 3]);
    let Some(rgb) = layers.into_iter().find_map(color).or_else(grey) else {
        let names: Vec<&str> = channels.iter().take(8).map(|(name, _)| name.as_str()).collect();
        return Err(format!("channels {} without R, G, B or Y", names.join(", ")));
    };
    let rows = of_chromaticities(image.attributes.chromaticities)?;
    let Vec2(width, height) = layer.size;
    let rgb = rgb.map(|samples| (0..width * height).map(move |i| value(samples, i)));
    let [r, g, b] = rgb;
    let texels = r.zip(g).zip(b).map(|((r, g), b)| [r, g, b]);
    let texels = match rows {
        Some(rows) => texels.map(|c| transformed(&rows, c.into()).map(|v| v.max(0.0)).to_array()).collect(),
        None => texels.collect(),
    };
    // Not above `u32::MAX`: checked with the header.
    Ok(Picture { width: width as u32, height: height as u32, texels: Texels::Floats(texels) })
}

fn has_levels(header: &Header) -> bool {
    matches!(header.blocks, BlockDescription::Tiles(tiles) if tiles.level_mode != LevelMode::Singular)
}

/// Refuses files in which a tile is not of the level that the table of tiles says, which the reader
/// takes for granted.
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

/// The matrix, by rows, to Rec. 709; none where nothing changes.
fn of_chromaticities(given: Option<Chromaticities>) -> Result<Option<[[f32; 3]; 3]>, String> {
    let Some(given) = given else { return Ok(None) };
    let [red, green, blue, white] =
        [given.red, given.green, given.blue, given.white].map(|Vec2(x, y)| [f64::from(x), f64::from(y)]);
    let primaries = Primaries { rgb: [red, green, blue], white };
    let rows = primaries.to_rec709(White::Adapted);
    let rows = rows.ok_or_else(|| format!("chromaticities {given:?} that span no colours"))?;
    // Written with four digits, Rec. 709's are not told from others.
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
