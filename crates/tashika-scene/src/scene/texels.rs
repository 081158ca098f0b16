//! Images: storage of texels, and lookups between them.

use std::sync::LazyLock;

use glam::Vec2;

use crate::color::{Rgb, srgb_decode};
use crate::math::simd::prefetch;

/// Texels, row by row from the top, without padding.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// Eight bits a channel, RGBA, encoded with the sRGB curve (alpha is linear).
    Srgb8(Vec<[u8; 4]>),
    /// Eight bits a channel, RGBA, linear: roughness, metalness, masks.
    Linear8(Vec<[u8; 4]>),
    /// Sixteen bits a channel, RGBA, encoded with the sRGB curve (alpha is linear).
    Srgb16(Vec<[u16; 4]>),
    /// Sixteen bits a channel, RGBA, linear.
    Linear16(Vec<[u16; 4]>),
    /// Floating point, RGB, linear: radiance, or numbers of any sign.
    Float(Vec<[f32; 3]>),
}

impl Pixels {
    /// Number of texels.
    pub fn len(&self) -> usize {
        match self {
            Self::Srgb8(p) | Self::Linear8(p) => p.len(),
            Self::Srgb16(p) | Self::Linear16(p) => p.len(),
            Self::Float(p) => p.len(),
        }
    }

    /// Returns true if there are no texels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A decoded image with a name.
#[derive(Clone, Debug)]
pub struct Image {
    /// Name that identifies it in messages, usually the file's.
    pub name: String,
    /// Number of texels in a row; at least 1.
    pub width: u32,
    /// Number of rows; at least 1.
    pub height: u32,
    /// The texels, `width · height`.
    pub pixels: Pixels,
}

/// Meaning of the values of an image or a texture; it determines the treatment of values below
/// zero.
///
/// The meaning depends on the use: the same image may be read as a colour in one place and as a
/// height in another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Values {
    /// Reflectances and radiances: floating-point texels below zero count as 0.
    Colors,
    /// Heights, normals, roughnesses: texels keep their stored values.
    Numbers,
}

/// Continuation of an image outside `[0, 1]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image is repeated.
    #[default]
    Repeat,
    /// The texels at the edge continue.
    Clamp,
    /// The image is repeated, mirrored every other time.
    Mirror,
    /// Black with an opacity of 0.
    Black,
}

/// Interpolation between texel centres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Weighted mean of the four nearest texels.
    #[default]
    Bilinear,
    /// Value of the nearest texel.
    Nearest,
}

static SRGB_TO_LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_decode(i as f32 / 255.0)));

/// Decoded 16-bit sRGB values: 256 kB, computed at the first lookup in such an image.
static SRGB16_TO_LINEAR: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=u16::MAX).map(|i| srgb_decode(f32::from(i) / 65535.0)).collect());

impl Image {
    /// Size of the texels in memory (bytes).
    pub fn bytes(&self) -> usize {
        match &self.pixels {
            Pixels::Srgb8(p) | Pixels::Linear8(p) => p.len() * 4,
            Pixels::Srgb16(p) | Pixels::Linear16(p) => p.len() * 8,
            Pixels::Float(p) => p.len() * 12,
        }
    }

    /// Returns true if no floating-point texel is infinite or not a number.
    pub fn is_finite(&self) -> bool {
        match &self.pixels {
            Pixels::Float(p) => p.iter().flatten().all(|v| v.is_finite()),
            _ => true,
        }
    }

    /// Returns the number of floating-point texels with a channel below zero.
    pub fn texels_below_zero(&self) -> u64 {
        match &self.pixels {
            Pixels::Float(p) => p.iter().filter(|texel| texel.iter().any(|v| *v < 0.0)).count() as u64,
            _ => 0,
        }
    }

    /// Returns the colour of one texel, linear and at least 0, with opacity; coordinates must be in
    /// range.
    pub fn texel(&self, x: u32, y: u32) -> (Rgb, f32) {
        self.texel_as(Values::Colors, x, y)
    }

    fn texel_as(&self, values: Values, x: u32, y: u32) -> (Rgb, f32) {
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
            Pixels::Srgb16(p) => {
                let [r, g, b, a] = p[i];
                let linear = |c: u16| SRGB16_TO_LINEAR[usize::from(c)];
                (Rgb::new(linear(r), linear(g), linear(b)), f32::from(a) / 65535.0)
            }
            Pixels::Linear16(p) => {
                let [r, g, b, a] = p[i].map(|c| f32::from(c) / 65535.0);
                (Rgb::new(r, g, b), a)
            }
            Pixels::Float(p) => match values {
                Values::Colors => (p[i].map(|v| v.max(0.0)).into(), 1.0),
                Values::Numbers => (p[i].into(), 1.0),
            },
        }
    }

    /// Reads ahead two texels of each of the two rows next to a point of `[0, 1]²`.
    #[inline]
    pub(super) fn read_ahead(&self, [u, v]: [f32; 2]) {
        let before = |c: f32, n: u32| ((c * n as f32 - 0.5).max(0.0) as u32).min(n - 1);
        let (x, y) = (before(u, self.width), before(v, self.height));
        for y in [y, (y + 1).min(self.height - 1)] {
            let i = y as usize * self.width as usize + x as usize;
            match &self.pixels {
                Pixels::Srgb8(p) | Pixels::Linear8(p) => prefetch(&p[i]),
                Pixels::Srgb16(p) | Pixels::Linear16(p) => prefetch(&p[i]),
                Pixels::Float(p) => prefetch(&p[i]),
            }
        }
    }

    /// Bilinear lookup: linear colour and opacity.
    pub fn bilinear(&self, uv: Vec2, wrap: [Wrap; 2]) -> (Rgb, f32) {
        self.interpolated(Values::Colors, uv, wrap)
    }

    /// Returns linear colour and opacity of the texel at `uv`.
    pub fn nearest(&self, uv: Vec2, wrap: [Wrap; 2]) -> (Rgb, f32) {
        self.sampled(Values::Colors, uv, wrap, Sampling::Nearest)
    }

    /// Returns linear value and opacity at `uv`.
    pub(super) fn sampled(
        &self,
        values: Values,
        uv: Vec2,
        wrap: [Wrap; 2],
        sampling: Sampling,
    ) -> (Rgb, f32) {
        match sampling {
            Sampling::Bilinear => self.interpolated(values, uv, wrap),
            Sampling::Nearest => {
                let pick = |u, n, wrap| {
                    let (before, after, weight) = neighbours(u, n, wrap);
                    if weight < 0.5 { before } else { after }
                };
                let (x, y) = (pick(uv.x, self.width, wrap[0]), pick(uv.y, self.height, wrap[1]));
                self.texel_or_black(values, x, y)
            }
        }
    }

    fn interpolated(&self, values: Values, uv: Vec2, wrap: [Wrap; 2]) -> (Rgb, f32) {
        let (x0, x1, fx) = neighbours(uv.x, self.width, wrap[0]);
        let (y0, y1, fy) = neighbours(uv.y, self.height, wrap[1]);
        let row = |y| {
            let [(c0, a0), (c1, a1)] = [x0, x1].map(|x| self.texel_or_black(values, x, y));
            (c0.lerp(c1, fx), a0 + (a1 - a0) * fx)
        };
        let ((c0, a0), (c1, a1)) = (row(y0), row(y1));
        (c0.lerp(c1, fy), a0 + (a1 - a0) * fy)
    }

    fn texel_or_black(&self, values: Values, x: Option<u32>, y: Option<u32>) -> (Rgb, f32) {
        match (x, y) {
            (Some(x), Some(y)) => self.texel_as(values, x, y),
            _ => (Rgb::BLACK, 0.0),
        }
    }
}

/// Means of the bilinear interpolation over the area of each texel, row by row. Along each axis,
/// the weights are an eighth for each of the two neighbours and three quarters for the texel
/// itself.
///
/// The mean over a texel is above zero if the interpolation is above zero anywhere in the texel. A
/// density in proportion to the means is therefore above zero wherever the interpolation is.
pub(super) fn means_of_bilinear(texels: &[f64], width: usize, wrap: [Wrap; 2]) -> Vec<f64> {
    let height = texels.len() / width;
    // Indices of the texels before and after; `None` beyond the end of the image.
    let beside = |i: usize, n: usize, wrap: Wrap| {
        let (before, after) = (i.checked_sub(1), (i + 1 < n).then_some(i + 1));
        match wrap {
            Wrap::Repeat => (before.or(Some(n - 1)), after.or(Some(0))),
            Wrap::Clamp | Wrap::Mirror => (before.or(Some(i)), after.or(Some(i))),
            Wrap::Black => (before, after),
        }
    };
    let across = |x: usize, y: Option<usize>| {
        let Some(y) = y else { return 0.0 };
        let at = |x: Option<usize>| x.map_or(0.0, |x| texels[y * width + x]);
        let (left, right) = beside(x, width, wrap[0]);
        (at(left) + 6.0 * at(Some(x)) + at(right)) / 8.0
    };
    let mut means = Vec::with_capacity(texels.len());
    for y in 0..height {
        let (above, below) = beside(y, height, wrap[1]);
        means.extend(
            (0..width).map(|x| (across(x, above) + 6.0 * across(x, Some(y)) + across(x, below)) / 8.0),
        );
    }
    means
}

/// Returns the two texels around coordinate `u` of a row of `n`, `None` beyond the end of the
/// image, and the weight of the second.
fn neighbours(u: f32, n: u32, wrap: Wrap) -> (Option<u32>, Option<u32>, f32) {
    let size = n as f32;
    let u = if u.is_finite() { u } else { 0.0 };
    // Whole periods are removed, since they would cost precision.
    let u = match wrap {
        Wrap::Repeat => u - u.floor(),
        Wrap::Mirror => u - 2.0 * (u * 0.5).floor(),
        Wrap::Clamp | Wrap::Black => u.clamp(-1.0, 2.0),
    };
    let x = u * size - 0.5;
    let floor = x.floor();
    let index = |i: i64| -> Option<u32> {
        let n = i64::from(n);
        let inside = match wrap {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let j = i.rem_euclid(2 * n);
                if j < n { j } else { 2 * n - 1 - j }
            }
            Wrap::Black if (0..n).contains(&i) => i,
            Wrap::Black => return None,
        };
        Some(inside as u32)
    };
    let i = floor as i64;
    (index(i), index(i + 1), x - floor)
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
        assert_eq!([at(0.375, Wrap::Black), at(1.0, Wrap::Black), at(1.2, Wrap::Black)], [50.0, 75.0, 0.0]);
    }

    /// An image with texels −3 and 1. Read as colours the texels are 0 and 1, read as numbers −3
    /// and 1. Lookups interpolate between these values.
    #[test]
    fn texels_below_zero_are_zero_as_colours_and_themselves_as_numbers() {
        let pixels = Pixels::Float(vec![[-3.0, 0.5, -3.0], [1.0, 0.5, 1.0]]);
        let image = Image { name: "i".into(), width: 2, height: 1, pixels };
        assert_eq!(image.texels_below_zero(), 1);
        let at = |values, u, sampling| image.sampled(values, Vec2::new(u, 0.5), [Wrap::Clamp; 2], sampling).0;
        for sampling in [Sampling::Bilinear, Sampling::Nearest] {
            assert_eq!(at(Values::Colors, 0.25, sampling), Rgb::new(0.0, 0.5, 0.0));
            assert_eq!(at(Values::Numbers, 0.25, sampling), Rgb::new(-3.0, 0.5, -3.0));
            for values in [Values::Colors, Values::Numbers] {
                assert_eq!(at(values, 0.75, sampling), Rgb::new(1.0, 0.5, 1.0));
            }
        }
        let between = |values| at(values, 0.5, Sampling::Bilinear).r;
        assert_eq!([between(Values::Colors), between(Values::Numbers)], [0.5, -1.0]);
        assert_eq!(image.texel(0, 0).0, Rgb::new(0.0, 0.5, 0.0));
    }

    #[test]
    fn nearest_takes_the_texel_that_holds_the_point() {
        let image = ramp();
        let at = |u| (image.nearest(Vec2::new(u, 0.5), [Wrap::Repeat; 2]).0.r * 255.0).round();
        assert_eq!([at(0.01), at(0.24), at(0.26), at(0.99), at(1.26)], [0.0, 0.0, 50.0, 150.0, 50.0]);
    }

    /// For every wrapping, the means agree with a fine sum of interpolated values over each texel.
    #[test]
    fn means_of_texels_are_those_of_the_interpolation() {
        let (w, h) = (3, 2);
        let values = [0.1f32, 0.9, 0.3, 0.7, 0.0, 0.5];
        let pixels = Pixels::Float(values.iter().map(|v| [*v; 3]).collect());
        let image = Image { name: "i".into(), width: w as u32, height: h as u32, pixels };
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror, Wrap::Black] {
            let means = means_of_bilinear(&values.map(f64::from), w, [wrap; 2]);
            for (i, mean) in means.into_iter().enumerate() {
                let n = 64;
                let sum: f64 = (0..n * n)
                    .map(|k| {
                        let within = |k: usize| (k as f32 + 0.5) / n as f32;
                        let u = ((i % w) as f32 + within(k % n)) / w as f32;
                        let v = ((i / w) as f32 + within(k / n)) / h as f32;
                        f64::from(image.bilinear(Vec2::new(u, v), [wrap; 2]).0.r)
                    })
                    .sum();
                let found = sum / (n * n) as f64;
                assert!((found - mean).abs() < 1e-4, "{wrap:?}, texel {i}: {mean}, should be {found}");
            }
        }
    }

    /// The 16-bit value `257 v` stands for the same number as the 8-bit value `v`, since
    /// `257 v / 65535 = v / 255`. Both must be decoded to equal bits. Some other 16-bit values are
    /// checked as well.
    #[test]
    fn sixteen_bits_are_eight_bits_and_what_lies_between() {
        let image = |pixels| Image { name: "i".into(), width: 256, height: 1, pixels };
        let eight: Vec<[u8; 4]> = (0..=255).map(|v| [v, 255 - v, 7, v]).collect();
        let sixteen: Vec<[u16; 4]> = eight.iter().map(|t| t.map(|v| 257 * u16::from(v))).collect();
        for (narrow, wide) in [
            (Pixels::Srgb8(eight.clone()), Pixels::Srgb16(sixteen.clone())),
            (Pixels::Linear8(eight), Pixels::Linear16(sixteen)),
        ] {
            let (narrow, wide) = (image(narrow), image(wide));
            assert_eq!(wide.bytes(), 2 * narrow.bytes());
            for x in 0..256 {
                assert_eq!(wide.texel(x, 0), narrow.texel(x, 0), "{x}");
            }
        }
        // At its lower end the sRGB curve is v / 12.92; 32768 / 65535 is decoded by its power law.
        let pixels = vec![[1, 32768, 65535, 1]];
        let one = |pixels| Image { name: "i".into(), width: 1, height: 1, pixels }.texel(0, 0);
        let (c, a) = one(Pixels::Srgb16(pixels.clone()));
        assert_eq!((c.r, c.b, a), (1.0 / 65535.0 / 12.92, 1.0, 1.0 / 65535.0));
        let exact = ((32768.0 / 65535.0 + 0.055) / 1.055f64).powf(2.4);
        // Rounding of the quotient, amplified by the exponent, and of the power itself.
        assert!((f64::from(c.g) - exact).abs() < 4.0 * exact * f64::from(f32::EPSILON), "{} {exact}", c.g);
        assert_eq!(one(Pixels::Linear16(pixels)).0, Rgb::new(1.0 / 65535.0, 32768.0 / 65535.0, 1.0));
    }

    #[test]
    fn srgb_is_decoded_and_alpha_is_not() {
        let image =
            Image { name: "s".into(), width: 1, height: 1, pixels: Pixels::Srgb8(vec![[188, 0, 255, 128]]) };
        let (c, a) = image.texel(0, 0);
        assert!((c.r - 0.5029).abs() < 1e-3 && c.b == 1.0 && (a - 128.0 / 255.0).abs() < 1e-6);
    }
}
