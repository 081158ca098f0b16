//! Interface between a server and an image: a description, tiles at several levels, and all samples
//! of one pixel.
//!
//! A tile of level `L` shows a square of `TILE · 2^L` pixels a side, clipped to the image's window.
//! Each sample stands for `2^L × 2^L` pixels: it is the least certain of them
//! ([`tashika::report::least_certain`]), never a mean. Tile (0, 0) begins at the window's first
//! pixel.
//!
//! # Guarantee
//! [`Description::part`] of any address, with numbers of any size, is inside the window, or a
//! [`Refusal`].
//!
//! # Held to this by
//! The tests below; for the samples of tiles, those of `live` and `stored`.

use serde::Serialize;
use serde_json::{Map, Value as Json};
use tashika::film::{CRYPTOMATTE, Film, Metadata, Plane, SampleKind, Samples, Value, Window};
use tashika::report::least_certain;

/// Side of a tile (samples).
pub const TILE: u32 = 256;

/// An image as a server shows it.
///
/// Methods may be called from several threads at once. [`Self::tile`] and [`Self::pixel`] may take
/// the time of reading a file; the others return at once.
pub trait Shown: Send + Sync {
    /// Description of the image; `None` until it is known.
    fn description(&self) -> Option<Description>;

    /// Number that grows whenever something visible has changed.
    fn version(&self) -> u64;

    /// Progress of the image.
    fn status(&self) -> Status;

    /// A tile of the planes of these names, all of one version.
    ///
    /// # Errors
    /// A [`Refusal`] if there is no such tile or plane, or its samples cannot be read.
    fn tile(&self, at: TileAddress, planes: &[&str]) -> Result<Tile, Refusal>;

    /// The samples of all planes at a pixel of the full image.
    ///
    /// # Errors
    /// A [`Refusal`] if the pixel is outside the window, or its samples cannot be read.
    fn pixel(&self, x: u32, y: u32) -> Result<Vec<Values>, Refusal>;
}

/// Progress of an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// True if the image is being rendered while it is shown.
    pub live: bool,
    /// True if the image will not change any more.
    pub finished: bool,
    /// Share of the image that is visible, 0 to 1.
    pub ready: f32,
    /// Headline and counts of a render.
    pub headline: Option<Headline>,
    /// Reason why part of the image will not become visible: a damaged file.
    pub failure: Option<String>,
}

/// Headline of a render, with its progress.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Headline {
    /// Headline as a sentence.
    pub text: String,
    /// Number of pixels that are finished.
    pub pixels: u64,
    /// Number of pixels to render in all.
    pub of: u64,
    /// Finished pixels that claim something within their budget.
    pub claiming: u64,
    /// Equal to `claiming`, for readers of earlier versions.
    pub promise_met: u64,
}

/// Description of an image: size, planes, metadata, and levels of tiles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Description {
    /// Size of the full image (pixels).
    pub size: [u32; 2],
    /// Part of the image that is shown: x, y, width, height (pixels).
    pub window: [u32; 4],
    /// Descriptions of all planes, in order.
    pub planes: Vec<PlaneDescription>,
    /// Provenance. Whole numbers that a browser would round, and numbers that are not finite, are
    /// strings.
    pub metadata: Map<String, Json>,
    /// Number of levels; the topmost is one tile.
    pub levels: u32,
}

/// Name, channels, unit, meaning and storage of a plane.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PlaneDescription {
    /// Name; empty for the main plane.
    pub name: String,
    /// Names of the channels, in their order.
    pub channels: Vec<String>,
    /// Unit of all channels: `W·m⁻²·sr⁻¹`, or `1` for counts.
    pub unit: String,
    /// Meaning of the numbers, in one sentence.
    pub doc: String,
    /// Storage type of the samples: `f32` or `u32`.
    pub kind: &'static str,
}

/// Position of a tile in the pyramid of levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileAddress {
    /// Binary logarithm of the side of a sample's block (pixels).
    pub level: u32,
    /// Number of tiles to the left of the tile.
    pub x: u32,
    /// Number of tiles above the tile.
    pub y: u32,
}

/// The samples of a tile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// A value of [`Shown::version`] that had been reached when the samples were read.
    pub version: u64,
    /// Plane after plane and channel after channel, each row by row, four bytes a sample, least
    /// significant byte first.
    pub bytes: Vec<u8>,
}

/// The samples of one plane at one pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Name of the plane; empty for the main plane.
    pub plane: String,
    /// A value for each channel.
    pub values: Samples,
}

/// Reason for not showing a tile or a pixel.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// There is no image yet.
    #[error("there is no image yet; ask again later")]
    NotYet,
    /// The address of the tile, or the pixel, is outside of the image.
    #[error("outside the image; expected {0}")]
    Outside(String),
    /// There is no plane of that name.
    #[error("no such plane; expected one that the state names")]
    NoPlane,
    /// The file could not be read.
    #[error("{0}")]
    Unreadable(String),
}

impl Description {
    pub(crate) fn new(
        size: [u32; 2],
        window: Window,
        planes: Vec<PlaneDescription>,
        metadata: &Metadata,
    ) -> Self {
        // Manifests of mattes may be large, and are not shown.
        let told = metadata.iter().filter(|(name, _)| !name.starts_with(CRYPTOMATTE));
        let metadata = told.map(|(name, value)| (name.to_owned(), json(value))).collect();
        let most = window.width.max(window.height).div_ceil(TILE);
        let levels = 1 + most.next_power_of_two().ilog2();
        let window = [window.x, window.y, window.width, window.height];
        Self { size, window, planes, metadata, levels }
    }

    /// Description of an image, of which `film` holds some rows of `window`.
    pub(crate) fn of(film: &Film, window: Window) -> Self {
        let planes = film
            .planes()
            .iter()
            .map(|p| PlaneDescription::new([p.name(), p.unit(), p.doc()], p.channels().to_vec(), p.kind()));
        Self::new(film.size(), window, planes.collect(), film.metadata())
    }

    /// Returns the pixels that a tile shows.
    pub(crate) fn part(&self, at: TileAddress) -> Result<Window, Refusal> {
        let TileAddress { level, x, y } = at;
        if level >= self.levels {
            return Err(Refusal::Outside(format!("a level from 0 to {}", self.levels - 1)));
        }
        let [left, top, width, height] = self.window;
        let side = TILE << level;
        let across = [width.div_ceil(side), height.div_ceil(side)];
        if x >= across[0] || y >= across[1] {
            let [last_x, last_y] = across.map(|n| n - 1);
            return Err(Refusal::Outside(format!(
                "x from 0 to {last_x} and y from 0 to {last_y} at this level"
            )));
        }
        let [from_left, from_top] = [x * side, y * side];
        Ok(Window {
            x: left + from_left,
            y: top + from_top,
            width: side.min(width - from_left),
            height: side.min(height - from_top),
        })
    }

    /// Returns a refusal unless the pixel is inside the window.
    pub(crate) fn check_pixel(&self, x: u32, y: u32) -> Result<(), Refusal> {
        let [left, top, width, height] = self.window;
        if (Window { x: left, y: top, width, height }).contains(x, y) {
            return Ok(());
        }
        let (right, bottom) = (left + width - 1, top + height - 1);
        Err(Refusal::Outside(format!("x from {left} to {right} and y from {top} to {bottom}")))
    }

    /// Returns the indices of planes in the list, given their names.
    pub(crate) fn places(&self, names: &[&str]) -> Result<Vec<usize>, Refusal> {
        let place = |name: &&str| self.planes.iter().position(|p| p.name == **name).ok_or(Refusal::NoPlane);
        names.iter().map(place).collect()
    }
}

impl PlaneDescription {
    /// Description of a plane by its `words`: name, unit, doc.
    pub(crate) fn new(words: [&str; 3], channels: Vec<String>, kind: SampleKind) -> Self {
        let [name, unit, doc] = words.map(str::to_owned);
        let kind = match kind {
            SampleKind::F32 => "f32",
            SampleKind::U32 => "u32",
        };
        Self { name, channels, unit, doc, kind }
    }
}

/// Bytes of a tile, one channel after the other, assembled from one or more films.
pub(crate) struct Collected<'a> {
    /// Indices of the planes in the film.
    planes: &'a [usize],
    /// Bytes of each channel of these planes.
    channels: Vec<Vec<u8>>,
}

impl<'a> Collected<'a> {
    pub(crate) fn new(planes: &'a [usize]) -> Self {
        Self { planes, channels: Vec::new() }
    }

    /// Adds the least certain pixel of each block of `part`.
    pub(crate) fn add(&mut self, film: &Film, part: Window, factor: u32) {
        let planes = || self.planes.iter().map(|&place| &film.planes()[place]);
        self.channels.resize(planes().map(|p| p.channels().len()).sum(), Vec::new());
        for [x, y] in least_certain(film, part, factor) {
            let pixel = planes().flat_map(|plane| bits(plane, x, y));
            for (channel, bits) in self.channels.iter_mut().zip(pixel) {
                channel.extend_from_slice(&bits.to_le_bytes());
            }
        }
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.channels.concat()
    }
}

/// Bits of a pixel's channels.
fn bits(plane: &Plane, x: u32, y: u32) -> impl Iterator<Item = u32> + '_ {
    let (floats, counts): (&[f32], &[u32]) = match plane.kind() {
        SampleKind::F32 => (plane.f32_at(x, y), &[]),
        SampleKind::U32 => (&[], plane.u32_at(x, y)),
    };
    floats.iter().map(|v| v.to_bits()).chain(counts.iter().copied())
}

/// Samples of all planes of a film at a pixel.
pub(crate) fn values(film: &Film, x: u32, y: u32) -> Vec<Values> {
    let of = |plane: &Plane| Values {
        plane: plane.name().to_owned(),
        values: match plane.kind() {
            SampleKind::F32 => Samples::F32(plane.f32_at(x, y).to_vec()),
            SampleKind::U32 => Samples::U32(plane.u32_at(x, y).to_vec()),
        },
    };
    film.planes().iter().map(of).collect()
}

fn json(value: &Value) -> Json {
    /// Largest integer up to which each whole number is a double.
    const EXACT: u64 = 1 << 53;
    match value {
        Value::Int(number) if number.unsigned_abs() <= EXACT => Json::from(*number),
        Value::Float(number) if number.is_finite() => Json::from(*number),
        Value::Bool(yes) => Json::from(*yes),
        Value::Text(_) | Value::Int(_) | Value::Float(_) => Json::from(value.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description(window: Window) -> Description {
        Description::new([65_536; 2], window, Vec::new(), &Metadata::default())
    }

    #[test]
    fn tiles_of_each_level_cover_the_window_once_and_the_topmost_is_one() {
        for (width, height, levels) in [(1, 1, 1), (256, 256, 1), (257, 3, 2), (700, 1300, 4), (65_536, 9, 9)]
        {
            let window = Window { x: 5, y: 7, width, height };
            let description = description(window);
            assert_eq!(description.levels, levels, "{width}x{height}");
            for level in 0..levels {
                let side = TILE << level;
                let mut area = 0;
                for y in 0..height.div_ceil(side) {
                    for x in 0..width.div_ceil(side) {
                        let part = description.part(TileAddress { level, x, y }).unwrap();
                        assert_eq!((part.x, part.y), (5 + x * side, 7 + y * side));
                        assert!(part.fits([5 + width, 7 + height]));
                        area += part.area();
                    }
                }
                assert_eq!(area, window.area(), "level {level} of {width}x{height}");
            }
            let top = description.part(TileAddress { level: levels - 1, x: 0, y: 0 }).unwrap();
            assert_eq!(top, window);
        }
    }

    #[test]
    fn addresses_beyond_all_bounds_are_refused() {
        let description = description(Window { x: 5, y: 7, width: 700, height: 1300 });
        for (level, x, y) in
            [(4, 0, 0), (u32::MAX, 0, 0), (32, 0, 0), (0, 3, 0), (0, 0, 6), (3, u32::MAX, u32::MAX)]
        {
            let refusal = description.part(TileAddress { level, x, y });
            assert!(matches!(refusal, Err(Refusal::Outside(_))), "{level} {x} {y}");
        }
        for (x, y) in [(4, 7), (5, 6), (705, 7), (5, 1307), (u32::MAX, u32::MAX)] {
            let said = description.check_pixel(x, y).unwrap_err().to_string();
            assert_eq!(said, "outside the image; expected x from 5 to 704 and y from 7 to 1306");
        }
        assert_eq!(description.check_pixel(704, 1306), Ok(()));
    }

    #[test]
    fn numbers_that_a_browser_would_change_are_strings() {
        let mut metadata = Metadata::default();
        metadata.set("small", -7_i64);
        metadata.set("large", (1_i64 << 53) + 1);
        metadata.set("real", 0.1);
        metadata.set("infinite", f64::INFINITY);
        metadata.set("complete", true);
        let window = Window { x: 0, y: 0, width: 1, height: 1 };
        let found = Description::new([1, 1], window, Vec::new(), &metadata).metadata;
        let expected =
            r#"{"complete":true,"infinite":"inf","large":"9007199254740993","real":0.1,"small":-7}"#;
        assert_eq!(Json::from(found).to_string(), expected);
    }
}
