//! Colours and numbers of materials, possibly textured.

use glam::Vec2;

use super::{Channel, TextureId, Textures};
use crate::color::Rgb;

/// A colour, possibly textured: `factor · texture(uv)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorInput {
    /// Constant factor of the texture, linear.
    pub factor: Rgb,
    /// Texture; `None` stands for a factor of 1.
    pub texture: Option<TextureId>,
}

/// A number, possibly textured: `factor · texture(uv)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloatInput {
    /// Constant factor of the texture's channel.
    pub factor: f32,
    /// Texture and the channel that holds the number, if any.
    pub texture: Option<(TextureId, Channel)>,
}

impl ColorInput {
    /// Returns the colour at `uv`; values of the texture below 0 count as 0.
    pub fn at(&self, textures: Textures<'_>, uv: Vec2) -> Rgb {
        self.texture.map_or(self.factor, |t| self.factor * textures.lookup(t, uv).0)
    }
}

impl From<Rgb> for ColorInput {
    fn from(factor: Rgb) -> Self {
        Self { factor, texture: None }
    }
}

impl FloatInput {
    /// Returns the number at `uv`, of any sign; 0 if a product of textured numbers is NaN.
    pub fn at(&self, textures: Textures<'_>, uv: Vec2) -> f32 {
        self.texture.map_or(self.factor, |(texture, channel)| {
            let number = self.factor * textures.channel(texture, uv, channel);
            if number.is_nan() { 0.0 } else { number }
        })
    }
}

impl From<f32> for FloatInput {
    fn from(factor: f32) -> Self {
        Self { factor, texture: None }
    }
}
