//! The film: named planes of samples with units, for a window of an image.
//!
//! A film covers the pixels of a [`Window`] of an image of `size` pixels. The origin is the top
//! left pixel, `x` to the right, `y` down; pixels are always addressed in coordinates of the full
//! image. A [`Plane`] holds one quantity: the plane without a name is the radiance, others hold
//! half-widths, claims, costs. Samples are stored pixel by pixel in rows, the channels of a pixel
//! adjacent.
//!
//! # Guarantee
//! Two films are equal (`==`) exactly if sizes, names, units, metadata and all sample *bits* are
//! equal.
//!
//! # Assumption
//! A sample may be infinite or NaN: half-widths of pixels without a claim are NaN, and a radiance
//! may have left the range of the numbers. A pixel outside the window, a plane without the
//! requested kind of sample, and a wrong number of channels are programming errors and panic.

mod exposure;
mod metadata;
mod plane;
mod record;
mod srgb_png;
mod tone;
mod words;

pub use exposure::automatic_stops;
pub use metadata::{Metadata, Value};
pub use plane::{Plane, PlaneSpec, SampleKind, Samples, channel_name};
pub use record::{
    CRYPTOMATTE, Claim, Code, FoundLight, HalfWidths, Key, LuminanceParts, Matte, MatteOf, MeanInterval,
    PictureClaim, PixelRecord, PlaneRow, RenderFilm, Routes, SCHEMA, Shown, Stop, Tally, keys, matte_id,
    planes,
};
pub use srgb_png::srgb_png;
pub use tone::{Curve, Exposure, Published, Tone, ToneMap};
pub use words::{
    about_light_not_found, about_not_finite, about_truth, count, percent_of_error, percent_of_share,
    percent_of_tolerance, truth_in_short,
};

use std::fmt;
use std::str::FromStr;

use crate::color::Rgb;
use crate::error::{Error, Result};

/// Most pixels along one side of an image.
pub const MAX_SIDE: u32 = 65_536;

/// Most pixels in a window: 2²⁸, a 16,384 × 16,384 image.
pub const MAX_PIXELS: u64 = 1 << 28;

/// The rendered part of the full image (pixels).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Window {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x, self.y, self.width, self.height)
    }
}

impl FromStr for Window {
    type Err = Error;

    /// Parses four numbers with commas between them: `x,y,width,height`.
    ///
    /// # Errors
    /// [`Error::Option`] naming `window` if the text is anything else.
    fn from_str(text: &str) -> Result<Self> {
        let numbers: std::result::Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[x, y, width, height]) => Ok(Self { x, y, width, height }),
            _ => Err(Error::option("window", text, "X,Y,W,H in pixels from the top left")),
        }
    }
}

impl Window {
    /// The whole image.
    pub const fn full(size: [u32; 2]) -> Self {
        Self { x: 0, y: 0, width: size[0], height: size[1] }
    }

    /// Number of pixels.
    pub const fn area(&self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// Returns true if the pixel lies inside.
    pub const fn contains(&self, x: u32, y: u32) -> bool {
        x >= self.x && y >= self.y && x - self.x < self.width && y - self.y < self.height
    }

    /// Returns true if the window is not empty and lies inside an image of `size` pixels.
    pub const fn fits(&self, size: [u32; 2]) -> bool {
        self.area() > 0
            && self.x as u64 + self.width as u64 <= size[0] as u64
            && self.y as u64 + self.height as u64 <= size[1] as u64
    }

    /// Returns true if all of another window lies inside.
    pub const fn covers(&self, other: &Self) -> bool {
        other.x >= self.x
            && other.y >= self.y
            && other.x as u64 + other.width as u64 <= self.x as u64 + self.width as u64
            && other.y as u64 + other.height as u64 <= self.y as u64 + self.height as u64
    }

    /// The smallest window that covers both.
    pub fn union(&self, other: &Self) -> Self {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let width = (self.x + self.width).max(other.x + other.width) - x;
        let height = (self.y + self.height).max(other.y + other.height) - y;
        Self { x, y, width, height }
    }

    /// All pixels, row by row, in coordinates of the full image.
    pub fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let w = *self;
        (w.y..w.y + w.height).flat_map(move |y| (w.x..w.x + w.width).map(move |x| (x, y)))
    }

    /// Position of a pixel in the order of [`Self::pixels`].
    ///
    /// # Panics
    /// If the pixel is outside.
    #[inline]
    pub fn index(&self, x: u32, y: u32) -> usize {
        assert!(self.contains(x, y), "pixel ({x}, {y}) is outside {self:?}");
        (y - self.y) as usize * self.width as usize + (x - self.x) as usize
    }
}

/// Named planes for a window of an image, with provenance.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    size: [u32; 2],
    window: Window,
    planes: Vec<Plane>,
    metadata: Metadata,
}

impl Film {
    /// A film of zeros for `window` of an image of `size` pixels.
    ///
    /// # Errors
    /// [`Error::Option`] naming `size` or `crop` if a side is zero or above [`MAX_SIDE`], if the
    /// window is empty or not inside the image, or if it has more than [`MAX_PIXELS`] pixels.
    ///
    /// # Panics
    /// If two specs have the same name, or one has no channels.
    pub fn new(size: [u32; 2], window: Window, specs: &[PlaneSpec]) -> Result<Self> {
        Self::check(size, window)?;
        let planes = specs.iter().map(|spec| Plane::zeros(spec, window)).collect();
        Ok(Self::from_planes(size, window, planes, Metadata::default()))
    }

    /// A film of given planes; sizes must have been checked.
    pub fn from_planes(size: [u32; 2], window: Window, planes: Vec<Plane>, metadata: Metadata) -> Self {
        for (i, plane) in planes.iter().enumerate() {
            assert!(planes[..i].iter().all(|p| p.name() != plane.name()), "two planes {:?}", plane.name());
        }
        Self { size, window, planes, metadata }
    }

    /// Performs the checks of [`Self::new`] without allocating memory.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn check(size: [u32; 2], window: Window) -> Result<()> {
        let [width, height] = size;
        let Window { x, y, width: w, height: h } = window;
        if size.iter().any(|side| !(1..=MAX_SIDE).contains(side)) {
            return Err(Error::option(
                "size",
                format!("{width}x{height}"),
                format!("1 to {MAX_SIDE} pixels a side"),
            ));
        }
        if !window.fits(size) {
            return Err(Error::option(
                "crop",
                format!("{x},{y},{w},{h}"),
                format!("X,Y,W,H: at least one pixel, inside the image of {width}x{height}"),
            ));
        }
        if window.area() > MAX_PIXELS {
            return Err(Error::option(
                "size",
                format!("{w}x{h}"),
                format!("at most {MAX_PIXELS} pixels at a time; render a larger image in parts with a crop"),
            ));
        }
        Ok(())
    }

    /// A film of zeros with the same planes and metadata, for a window of an image of another size.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn blank(&self, size: [u32; 2], window: Window) -> Result<Self> {
        Self::check(size, window)?;
        let planes = self.planes.iter().map(|plane| plane.blank(window)).collect();
        Ok(Self::from_planes(size, window, planes, self.metadata.clone()))
    }

    /// The part of the film inside `window`. A part does not inherit the claim about the picture as
    /// a whole.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// # Panics
    /// If the window is not inside the film's window.
    pub fn cropped(&self, window: Window) -> Result<Self> {
        let mut part = self.blank(self.size, window)?;
        for y in window.y..window.y + window.height {
            part.copy_pixels([window.x, y], self, [window.x, y], window.width);
        }
        if window != self.window {
            PictureClaim::forget(&mut part);
        }
        Ok(part)
    }

    /// Copies `count` pixels of a row of another film, bit by bit. The leftmost of them is read at
    /// `at` and written at `to`.
    ///
    /// # Panics
    /// If a pixel is outside its film's window, or the films do not have equal planes in equal
    /// order.
    pub fn copy_pixels(&mut self, to: [u32; 2], from: &Self, at: [u32; 2], count: u32) {
        assert_eq!(self.planes.len(), from.planes.len(), "films of different planes");
        for (own, other) in self.planes.iter_mut().zip(&from.planes).filter(|_| count > 0) {
            assert!(
                own.name() == other.name() && own.channels() == other.channels(),
                "films of different planes"
            );
            own.copy(to, other, at, count);
        }
    }

    /// Moves the main plane of another film of the same window into this film, under another name.
    ///
    /// # Panics
    /// If the windows differ, or there is a plane of that name.
    pub fn adopt_main(&mut self, mut from: Self, name: impl AsRef<str>) {
        let name = name.as_ref();
        assert_eq!(self.window, from.window, "films of different windows");
        assert!(self.plane(name).is_none(), "two planes {name:?}");
        if let Some(at) = from.planes.iter().position(|p| p.name().is_empty()) {
            self.planes.push(from.planes.swap_remove(at).renamed(name));
        }
    }

    /// Adds a plane of given samples, pixel by pixel in rows.
    ///
    /// # Panics
    /// If there is a plane of that name, or the number of samples is not pixels times channels.
    pub fn add_plane(&mut self, spec: &PlaneSpec, samples: Samples) {
        let words = [spec.name, spec.unit, spec.doc].map(str::to_owned);
        let channels = spec.channels.iter().map(|&channel| channel.to_owned()).collect();
        self.take_plane(Plane::from_samples(words, channels, self.window, samples));
    }

    /// Adds a plane of the same window.
    ///
    /// # Panics
    /// If there is a plane of that name.
    pub fn take_plane(&mut self, plane: Plane) {
        assert!(self.plane(plane.name()).is_none(), "two planes {:?}", plane.name());
        self.planes.push(plane);
    }

    /// Film with the plane of this name alone, as its main plane. Planes that describe the former
    /// main plane are omitted. `None` if there is no plane of this name.
    #[must_use]
    pub fn only(&self, name: impl AsRef<str>) -> Option<Self> {
        let planes = vec![self.plane(name)?.clone().renamed(planes::RADIANCE.name)];
        Some(Self::from_planes(self.size, self.window, planes, self.metadata.clone()))
    }

    /// Size of the full image (pixels).
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The part of the image that the film holds.
    pub fn window(&self) -> Window {
        self.window
    }

    /// All planes, in the order of their specs.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// All planes, to be filled.
    pub fn planes_mut(&mut self) -> &mut [Plane] {
        &mut self.planes
    }

    /// The plane of that name; the main one has the empty name.
    pub fn plane(&self, name: impl AsRef<str>) -> Option<&Plane> {
        let name = name.as_ref();
        self.planes.iter().find(|p| p.name() == name)
    }

    /// The plane of that name, to be filled.
    pub fn plane_mut(&mut self, name: impl AsRef<str>) -> Option<&mut Plane> {
        let name = name.as_ref();
        self.planes.iter_mut().find(|p| p.name() == name)
    }

    /// Provenance.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// Provenance, to be filled.
    pub fn metadata_mut(&mut self) -> &mut Metadata {
        &mut self.metadata
    }

    /// Colours of the main plane; `None` if the film has no such plane. See [`Plane::colors`].
    pub fn colors(&self) -> Option<impl Iterator<Item = Rgb> + '_> {
        self.plane(planes::RADIANCE)?.colors()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPECS: &[PlaneSpec] = &[
        PlaneSpec {
            name: "",
            channels: &["R", "G", "B"],
            unit: "W·m⁻²·sr⁻¹",
            kind: SampleKind::F32,
            doc: "radiance",
        },
        PlaneSpec {
            name: "cost",
            channels: &["pairs", "rays"],
            unit: "1",
            kind: SampleKind::U32,
            doc: "work",
        },
    ];
    const WINDOW: Window = Window { x: 3, y: 1, width: 4, height: 2 };

    #[test]
    fn pixels_are_named_in_coordinates_of_the_full_image() {
        let mut film = Film::new([10, 5], WINDOW, SPECS).unwrap();
        for (i, (x, y)) in WINDOW.pixels().enumerate() {
            assert_eq!(WINDOW.index(x, y), i);
            film.plane_mut("").unwrap().set_f32(x, y, &[x as f32, y as f32, 0.5]);
            film.plane_mut("cost").unwrap().set_u32(x, y, &[x, y * 100]);
        }
        assert_eq!(film.plane("cost").unwrap().u32_at(6, 2), [6, 200]);
        let colors: Vec<Rgb> = film.colors().unwrap().collect();
        assert_eq!(colors[0], Rgb::new(3.0, 1.0, 0.5));
        assert_eq!(colors[7], Rgb::new(6.0, 2.0, 0.5));
        assert!(film.plane("half_width").is_none());
    }

    #[test]
    fn windows_are_said_joined_and_held_against_each_other() {
        let window = |x, y, width, height| Window { x, y, width, height };
        assert_eq!(WINDOW.to_string(), "3,1,4,2");
        assert_eq!("3, 1,4,2".parse::<Window>().unwrap(), WINDOW);
        for wrong in ["", "3,1,4", "3,1,4,2,1", "3,1,-4,2", "3,1,4,x"] {
            assert!(wrong.parse::<Window>().unwrap_err().to_string().contains("X,Y,W,H"), "{wrong}");
        }
        assert_eq!(WINDOW.union(&window(0, 2, 1, 5)), window(0, 1, 7, 6));
        assert_eq!(WINDOW.union(&window(4, 1, 2, 1)), WINDOW);
        assert!(WINDOW.covers(&WINDOW) && WINDOW.covers(&window(6, 2, 1, 1)));
        for beyond in [window(2, 1, 1, 1), window(3, 0, 1, 1), window(6, 1, 2, 1), window(3, 2, 1, 2)] {
            assert!(!WINDOW.covers(&beyond), "{beyond}");
        }
    }

    #[test]
    fn a_part_has_the_pixels_at_their_places() {
        let mut film = Film::new([10, 5], WINDOW, SPECS).unwrap();
        for (x, y) in WINDOW.pixels() {
            film.plane_mut("cost").unwrap().set_u32(x, y, &[x, y]);
        }
        film.metadata_mut().set("seed", 7_u32);
        let part = film.cropped(Window { x: 4, y: 2, width: 2, height: 1 }).unwrap();
        let cost = part.plane("cost").unwrap();
        assert_eq!((cost.u32_at(4, 2), cost.u32_at(5, 2)), (&[4, 2][..], &[5, 2][..]));
        assert_eq!((part.size(), part.metadata()), (film.size(), film.metadata()));
    }

    #[test]
    fn a_plane_can_stand_alone() {
        let mut film = Film::new([10, 5], WINDOW, SPECS).unwrap();
        film.plane_mut("cost").unwrap().set_u32(4, 2, &[1, 2]);
        let only = film.only("cost").unwrap();
        assert_eq!((only.planes().len(), only.plane("").unwrap().u32_at(4, 2)), (1, &[1, 2][..]));
        assert!(film.only("absent").is_none());
    }

    #[test]
    fn equality_sees_every_bit() {
        let film = Film::new([10, 5], WINDOW, SPECS).unwrap();
        let mut other = film.clone();
        other.plane_mut("").unwrap().set_f32(3, 1, &[-0.0, 0.0, 0.0]);
        assert_ne!(film, other, "minus zero is another bit pattern");
        let mut other = film.clone();
        other.metadata_mut().set("seed", 1_u32);
        assert_ne!(film, other);
        assert_eq!(film, film.clone());
    }

    #[test]
    fn pixels_are_copied_between_films_of_other_windows_bit_by_bit() {
        let mut film = Film::new([10, 5], WINDOW, SPECS).unwrap();
        film.metadata_mut().set("seed", 1_u32);
        for (x, y) in WINDOW.pixels() {
            film.plane_mut("").unwrap().set_f32(x, y, &[-0.0, x as f32, y as f32]);
            film.plane_mut("cost").unwrap().set_u32(x, y, &[x, y]);
        }
        let window = Window { x: 0, y: 0, width: 3, height: 2 };
        let mut other = film.blank([3, 2], window).unwrap();
        assert_eq!((other.metadata(), other.planes().len()), (film.metadata(), 2));
        other.copy_pixels([1, 1], &film, [5, 2], 2);
        other.copy_pixels([0, 0], &film, [5, 2], 0);
        for (x, y) in window.pixels() {
            let is_copied = y == 1 && x > 0;
            let expected = if is_copied { [-0.0, x as f32 + 4.0, 2.0] } else { [0.0; 3] };
            let found = other.plane("").unwrap().f32_at(x, y);
            assert_eq!(found.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), expected.map(f32::to_bits));
            assert_eq!(
                other.plane("cost").unwrap().u32_at(x, y),
                if is_copied { [x + 4, 2] } else { [0, 0] }
            );
        }
        assert!(film.blank([3, 2], WINDOW).is_err(), "a window outside the image");
    }

    #[test]
    fn a_film_takes_the_main_plane_of_another_under_another_name() {
        let mut film = Film::new([10, 5], WINDOW, SPECS).unwrap();
        let mut other = film.clone();
        other.plane_mut("").unwrap().set_f32(4, 2, &[1.0, 2.0, 3.0]);
        film.adopt_main(other, "reference");
        assert_eq!(film.plane("reference").unwrap().f32_at(4, 2), [1.0, 2.0, 3.0]);
        assert_eq!((film.plane("").unwrap().f32_at(4, 2), film.planes().len()), (&[0.0; 3][..], 3));
    }

    #[test]
    #[should_panic(expected = "is outside")]
    fn a_copy_over_the_edge_is_a_bug() {
        let mut film = Film::new([10, 5], WINDOW, SPECS).unwrap();
        let other = film.clone();
        film.copy_pixels([3, 1], &other, [5, 1], 3);
    }

    #[test]
    fn sizes_are_refused_by_name_and_value() {
        let message = |size, window| Film::new(size, window, SPECS).unwrap_err().to_string();
        let full = Window::full;
        assert!(message([0, 5], full([0, 5])).starts_with("size = 0x5; expected 1 to 65536"));
        assert!(message([70_000, 1], full([70_000, 1])).starts_with("size = 70000x1"));
        assert!(message([40_000, 40_000], full([40_000, 40_000])).contains("in parts with a crop"));
        let beyond = Window { x: u32::MAX, y: 0, width: 2, height: 1 };
        assert!(message([10, 5], beyond).starts_with("crop = 4294967295,0,2,1; expected"));
        assert!(message([10, 5], Window { width: 0, ..WINDOW }).starts_with("crop = 3,1,0,2"));
    }

    #[test]
    #[should_panic(expected = "is outside")]
    fn a_pixel_beside_the_window_is_a_bug() {
        WINDOW.index(2, 1);
    }
}
