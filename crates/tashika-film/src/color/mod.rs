//! Linear RGB with the primaries of Rec. 709 / sRGB, and its transfer function.

mod controlled;
pub mod metals;
mod primaries;
pub mod spectrum;

pub use controlled::{Controlled, Part};
pub use primaries::{Primaries, White, transformed};

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Index, Mul, MulAssign, Sub};

use serde::{Deserialize, Serialize};

use crate::math::elementary::powf;

/// Luminance weights of linear Rec. 709 red, green and blue (ITU-R BT.709-6).
pub const LUMINANCE_WEIGHTS: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// A linear RGB value; its unit is that of the quantity it colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rgb {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
}

impl Rgb {
    /// Zero in each channel.
    pub const BLACK: Self = Self::gray(0.0);
    /// One in each channel.
    pub const WHITE: Self = Self::gray(1.0);

    /// A colour from its channels.
    #[inline]
    pub const fn new(r: f32, g: f32, b: f32) -> Self {
        Self { r, g, b }
    }

    /// The same value in each channel.
    #[inline]
    pub const fn gray(v: f32) -> Self {
        Self { r: v, g: v, b: v }
    }

    /// Luminance `0.2126 R + 0.7152 G + 0.0722 B` in the unit of the colour.
    #[inline]
    pub fn luminance(self) -> f32 {
        LUMINANCE_WEIGHTS[0] * self.r + LUMINANCE_WEIGHTS[1] * self.g + LUMINANCE_WEIGHTS[2] * self.b
    }

    /// The largest channel.
    #[inline]
    pub fn max_channel(self) -> f32 {
        self.r.max(self.g).max(self.b)
    }

    /// Returns true if every channel is exactly zero.
    #[inline]
    pub fn is_black(self) -> bool {
        self == Self::BLACK
    }

    /// Returns true if every channel is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }

    /// Returns true if every channel is finite and not negative.
    #[inline]
    pub fn is_valid(self) -> bool {
        self.is_finite() && self.r >= 0.0 && self.g >= 0.0 && self.b >= 0.0
    }

    /// Applies `f` to each channel.
    #[must_use]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self::new(f(self.r), f(self.g), f(self.b))
    }

    /// Combines the channels of two colours.
    #[must_use]
    pub fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self::new(f(self.r, other.r), f(self.g, other.g), f(self.b, other.b))
    }

    /// `(1 − t) · self + t · other`.
    #[must_use]
    #[inline]
    pub fn lerp(self, other: Self, t: f32) -> Self {
        self * (1.0 - t) + other * t
    }

    /// The channels as an array.
    #[inline]
    pub fn to_array(self) -> [f32; 3] {
        [self.r, self.g, self.b]
    }
}

impl From<[f32; 3]> for Rgb {
    #[inline]
    fn from(c: [f32; 3]) -> Self {
        Self::new(c[0], c[1], c[2])
    }
}

impl Index<usize> for Rgb {
    type Output = f32;
    #[inline]
    fn index(&self, channel: usize) -> &f32 {
        match channel {
            0 => &self.r,
            1 => &self.g,
            2 => &self.b,
            _ => panic!("an RGB colour has channels 0 to 2, not {channel}"),
        }
    }
}

impl Add for Rgb {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        self.zip(o, |a, b| a + b)
    }
}

impl AddAssign for Rgb {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Rgb {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self.zip(o, |a, b| a - b)
    }
}

impl Mul for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        self.zip(o, |a, b| a * b)
    }
}

impl Mul<f32> for Rgb {
    type Output = Self;
    #[inline]
    fn mul(self, k: f32) -> Self {
        self.map(|a| a * k)
    }
}

impl Mul<Rgb> for f32 {
    type Output = Rgb;
    #[inline]
    fn mul(self, c: Rgb) -> Rgb {
        c * self
    }
}

impl MulAssign<f32> for Rgb {
    #[inline]
    fn mul_assign(&mut self, k: f32) {
        *self = *self * k;
    }
}

impl MulAssign for Rgb {
    #[inline]
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl Div<f32> for Rgb {
    type Output = Self;
    #[inline]
    fn div(self, k: f32) -> Self {
        self.map(|a| a / k)
    }
}

impl Sum for Rgb {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::BLACK, Self::add)
    }
}

/// A running sum of colours in `f64`: with millions of terms it is exact to the precision of `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RgbSum([f64; 3]);

impl RgbSum {
    /// Adds one term.
    #[inline]
    pub fn add(&mut self, c: Rgb) {
        self.0[0] += f64::from(c.r);
        self.0[1] += f64::from(c.g);
        self.0[2] += f64::from(c.b);
    }

    /// Subtracts a term that was added before.
    #[inline]
    pub fn remove(&mut self, c: Rgb) {
        self.0[0] -= f64::from(c.r);
        self.0[1] -= f64::from(c.g);
        self.0[2] -= f64::from(c.b);
    }

    /// Adds another sum.
    #[inline]
    pub fn merge(&mut self, other: &Self) {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += b;
        }
    }

    /// The sum times a factor.
    #[must_use]
    #[inline]
    pub fn scaled(self, factor: f64) -> Self {
        Self(self.0.map(|c| c * factor))
    }

    /// The sum, rounded once.
    #[inline]
    pub fn total(&self) -> Rgb {
        Rgb::new(self.0[0] as f32, self.0[1] as f32, self.0[2] as f32)
    }

    /// The sum of each channel.
    #[inline]
    pub fn channels(&self) -> [f64; 3] {
        self.0
    }

    /// Luminance of the sum, in the unit of the colours.
    #[inline]
    pub fn luminance(&self) -> f64 {
        self.0.iter().zip(LUMINANCE_WEIGHTS).map(|(c, w)| c * f64::from(w)).sum()
    }
}

/// sRGB transfer function (IEC 61966-2-1): linear `[0, 1]` to encoded `[0, 1]`.
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * powf(linear, 1.0 / 2.4) - 0.055 }
}

/// Inverse of [`srgb_encode`].
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { powf((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips_and_meets_at_the_knee() {
        for i in 0..=1000 {
            let x = i as f32 / 1000.0;
            assert!((srgb_decode(srgb_encode(x)) - x).abs() < 1e-5);
        }
        assert!((srgb_encode(0.5) - 0.735_36).abs() < 1e-4);
    }

    #[test]
    fn a_sum_of_millions_keeps_small_terms() {
        let mut sum = RgbSum::default();
        sum.add(Rgb::gray(1e8));
        for _ in 0..1000 {
            sum.add(Rgb::gray(0.5));
        }
        assert_eq!(sum.total(), Rgb::gray(100_000_500.0_f64 as f32));
        assert!((sum.luminance() - 100_000_500.0).abs() < 20.0);
    }
}
