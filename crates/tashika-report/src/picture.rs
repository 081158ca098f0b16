//! Eight-bit sRGB pictures that can be drawn and written on.
//!
//! Text and rectangles are drawn by `embedded-graphics`, whose fonts are bitmaps of ASCII.

use std::convert::Infallible;

use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};
use embedded_graphics::text::{Baseline, Text};

use crate::film::srgb_png;

/// Eight-bit sRGB picture without transparency.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    size: [u32; 2],
    /// Three bytes for each pixel, row by row.
    bytes: Vec<u8>,
}

impl Picture {
    /// A picture of one colour.
    pub(super) fn filled(size: [u32; 2], color: [u8; 3]) -> Self {
        Self { size, bytes: color.repeat(size[0] as usize * size[1] as usize) }
    }

    /// A picture of given pixels, row by row.
    pub(super) fn of_pixels(size: [u32; 2], pixels: impl Iterator<Item = [u8; 3]>) -> Self {
        let bytes: Vec<u8> = pixels.flatten().collect();
        assert_eq!(
            bytes.len() as u64,
            3 * u64::from(size[0]) * u64::from(size[1]),
            "a colour for each pixel"
        );
        Self { size, bytes }
    }

    /// Width and height (pixels).
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Colour of a pixel, from the top left.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        let i = self.index(x, y).expect("a pixel of the picture");
        [self.bytes[i], self.bytes[i + 1], self.bytes[i + 2]]
    }

    /// Encodes the picture as a PNG file that declares sRGB.
    pub fn png(&self) -> Vec<u8> {
        srgb_png(self.size, &self.bytes)
    }

    /// Fills a rectangle, clipped to the picture.
    pub(super) fn fill(&mut self, corner: [u32; 2], size: [u32; 2], color: [u8; 3]) {
        let [right, bottom] = [0, 1].map(|i| corner[i].saturating_add(size[i]).min(self.size[i]));
        for y in corner[1]..bottom {
            for x in corner[0]..right {
                self.set(x, y, color);
            }
        }
    }

    /// Draws a picture at `corner`, with each of its pixels as a square of `magnification` pixels.
    pub(super) fn put(&mut self, corner: [u32; 2], picture: &Self, magnification: u32) {
        let m = magnification;
        for y in 0..picture.size[1] {
            for x in 0..picture.size[0] {
                self.fill([corner[0] + x * m, corner[1] + y * m], [m, m], picture.pixel(x, y));
            }
        }
    }

    /// Writes a line of ASCII text; `at` is its left end.
    pub(super) fn write(&mut self, text: &str, at: [u32; 2], baseline: Baseline, font: &MonoFont<'_>) {
        let at = Point::new(at[0] as i32, at[1] as i32);
        let Ok(_) = embedded_graphics::Drawable::draw(
            &Text::with_baseline(text, at, MonoTextStyle::new(font, Rgb888::BLACK), baseline),
            self,
        );
    }

    fn set(&mut self, x: u32, y: u32, color: [u8; 3]) {
        if let Some(i) = self.index(x, y) {
            self.bytes[i..i + 3].copy_from_slice(&color);
        }
    }

    fn index(&self, x: u32, y: u32) -> Option<usize> {
        let inside = x < self.size[0] && y < self.size[1];
        inside.then(|| 3 * (y as usize * self.size[0] as usize + x as usize))
    }
}

impl OriginDimensions for Picture {
    fn size(&self) -> Size {
        Size::new(self.size[0], self.size[1])
    }
}

impl DrawTarget for Picture {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(point, color) in pixels {
            if let (Ok(x), Ok(y)) = (u32::try_from(point.x), u32::try_from(point.y)) {
                self.set(x, y, [color.r(), color.g(), color.b()]);
            }
        }
        Ok(())
    }
}
