//! Images and how surfaces look them up.

use std::sync::LazyLock;

use glam::{Mat3, Vec2};

use super::ImageId;
use crate::color::{Rgb, srgb_decode};

/// Texels, row by row from the top, without padding.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// Eight bits a channel, RGBA, encoded with the sRGB curve (alpha is linear).
    Srgb8(Vec<[u8; 4]>),
    /// Eight bits a channel, RGBA, linear: roughness, metalness, masks.
    Linear8(Vec<[u8; 4]>),
    /// Linear floating point, RGB: radiance.
    Float(Vec<[f32; 3]>),
}

/// A decoded image.
#[derive(Clone, Debug)]
pub struct Image {
    /// Name for messages, usually the file's.
    pub name: String,
    /// Texels a row; at least 1.
    pub width: u32,
    /// Rows; at least 1.
    pub height: u32,
    /// The texels, `width · height`.
    pub pixels: Pixels,
}

/// What happens outside `[0, 1]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Starts again.
    #[default]
    Repeat,
    /// The edge's texel goes on.
    Clamp,
    /// Starts again mirrored.
    Mirror,
}

/// A map of texture coordinates: rotation and scale, then offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform(pub Mat3);

impl Default for UvTransform {
    fn default() -> Self {
        Self(Mat3::IDENTITY)
    }
}

/// A lookup into an image.
///
/// `u` runs to the right, `v` runs **down** from the image's top row; loaders of formats with `v` up flip
/// the coordinates once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// The image.
    pub image: ImageId,
    /// Wrapping of `u` and `v`.
    pub wrap: [Wrap; 2],
    /// Applied to the coordinates first.
    pub transform: UvTransform,
}

/// One channel of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Opacity; one for images without.
    A,
}

static SRGB_TO_LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_decode(i as f32 / 255.0)));

impl Image {
    /// Bytes held.
    pub fn bytes(&self) -> usize {
        match &self.pixels {
            Pixels::Srgb8(p) | Pixels::Linear8(p) => p.len() * 4,
            Pixels::Float(p) => p.len() * 12,
        }
    }

    /// One texel, linear, with opacity; coordinates must be in range.
    pub fn texel(&self, x: u32, y: u32) -> (Rgb, f32) {
        let i = y as usize * self.width as usize + x as usize;
        match &self.pixels {
            Pixels::Srgb8(p) => {
                let [r, g, b, a] = p[i];
                let linear = |c: u8| SRGB_TO_LINEAR[usize::from(c)];
                (Rgb::new(linear(r), linear(g), linear(b)), f32::from(a) / 255.0)
            }
            Pixels::Linear8(p) => {
                let [r, g, b, a] = p[i].map(|c| f32::from(c) / 255.0);
                (Rgb::new(r, g, b), a)
            }
            Pixels::Float(p) => (p[i].into(), 1.0),
        }
    }

    /// Bilinear lookup: linear colour and opacity.
    pub fn bilinear(&self, uv: Vec2, wrap: [Wrap; 2]) -> (Rgb, f32) {
        let (x0, x1, fx) = neighbours(uv.x, self.width, wrap[0]);
        let (y0, y1, fy) = neighbours(uv.y, self.height, wrap[1]);
        let row = |y| {
            let ((c0, a0), (c1, a1)) = (self.texel(x0, y), self.texel(x1, y));
            (c0.lerp(c1, fx), a0 + (a1 - a0) * fx)
        };
        let ((c0, a0), (c1, a1)) = (row(y0), row(y1));
        (c0.lerp(c1, fy), a0 + (a1 - a0) * fy)
    }
}

/// The two texels about coordinate `u` of a row of `n`, and the weight of the second.
fn neighbours(u: f32, n: u32, wrap: Wrap) -> (u32, u32, f32) {
    let size = n as f32;
    let u = if u.is_finite() { u } else { 0.0 };
    // Whole turns carry no information and would cost precision.
    let u = match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::Mirror => u - 2.0 * (u * 0.5).floor(),
        Wrap::Clamp => u.clamp(-1.0, 2.0),
    };
    let x = u * size - 0.5;
    let floor = x.floor();
    let index = |i: i64| -> u32 {
        let n = i64::from(n);
        (match wrap {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
        }) as u32
    };
    let i = floor as i64;
    (index(i), index(i + 1), x - floor)
}

impl Texture {
    /// The whole image, repeated.
    pub fn new(image: ImageId) -> Self {
        Self { image, wrap: [Wrap::Repeat; 2], transform: UvTransform::default() }
    }

    /// Linear colour and opacity at `uv`.
    pub fn lookup(&self, images: &[Image], uv: Vec2) -> (Rgb, f32) {
        let uv = self.transform.0.transform_point2(uv);
        images[self.image.index()].bilinear(uv, self.wrap)
    }

    /// One channel at `uv`.
    pub fn channel(&self, images: &[Image], uv: Vec2, channel: Channel) -> f32 {
        let (color, alpha) = self.lookup(images, uv);
        match channel {
            Channel::R => color.r,
            Channel::G => color.g,
            Channel::B => color.b,
            Channel::A => alpha,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Image {
        let pixels = (0..4u8).map(|i| [i * 50, 0, 255, 255 - i]).collect();
        Image { name: "ramp".into(), width: 4, height: 1, pixels: Pixels::Linear8(pixels) }
    }

    #[test]
    fn texel_centres_are_exact_and_midpoints_are_averages() {
        let image = ramp();
        let at = |u| image.bilinear(Vec2::new(u, 0.5), [Wrap::Clamp; 2]).0.r * 255.0;
        assert!((at(0.125) - 0.0).abs() < 1e-4 && (at(0.375) - 50.0).abs() < 1e-4);
        assert!((at(0.25) - 25.0).abs() < 1e-4);
    }

    #[test]
    fn wrapping_continues_repeats_or_mirrors() {
        let image = ramp();
        let at = |u, wrap| (image.bilinear(Vec2::new(u, 0.5), [wrap; 2]).0.r * 255.0).round();
        assert_eq!([at(1.125, Wrap::Clamp), at(9.0, Wrap::Clamp)], [150.0, 150.0]);
        assert_eq!([at(1.125, Wrap::Repeat), at(-0.125, Wrap::Repeat)], [0.0, 150.0]);
        assert_eq!([at(1.125, Wrap::Mirror), at(-0.125, Wrap::Mirror)], [150.0, 0.0]);
        assert_eq!(at(0.0, Wrap::Repeat), 75.0, "first and last texel meet");
    }

    #[test]
    fn srgb_is_decoded_and_alpha_is_not() {
        let image =
            Image { name: "s".into(), width: 1, height: 1, pixels: Pixels::Srgb8(vec![[188, 0, 255, 128]]) };
        let (c, a) = image.texel(0, 0);
        assert!((c.r - 0.5029).abs() < 1e-3 && c.b == 1.0 && (a - 128.0 / 255.0).abs() < 1e-6);
    }
}
