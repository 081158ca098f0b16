//! Texture graphs that several formats share.
//!
//! A colour or a number is a factor on a texture. A combination of several is a node, with the
//! factors as constants. Coordinates of images run down ([`Texture`]). Formats whose `v` runs up
//! flip the coordinates of their meshes once; [`upward`] converts the transforms of their textures.
//!
//! Held to this by the tests below and by the formats' own.

use glam::{Mat3, Vec3};

use crate::color::Rgb;
use crate::error::Result;
use crate::scene::{Channel, ColorInput, FloatInput, SceneBuilder, Texture, TextureId, UvTransform};

/// A texture with a factor of 1.
pub(super) fn whole(texture: TextureId) -> ColorInput {
    ColorInput { factor: Rgb::WHITE, texture: Some(texture) }
}

/// A channel of a colour as a number, with the luminance of its factor.
pub(super) fn number(color: ColorInput, channel: Channel) -> FloatInput {
    FloatInput { factor: color.factor.luminance(), texture: color.texture.map(|texture| (texture, channel)) }
}

/// Returns a node with the values of a colour.
pub(super) fn node(builder: &mut SceneBuilder, color: ColorInput) -> Result<TextureId> {
    match color.texture {
        Some(texture) if color.factor == Rgb::WHITE => Ok(texture),
        Some(texture) => {
            let factor = builder.add_texture(Texture::Constant(color.factor))?;
            builder.add_texture(Texture::Product(factor, texture))
        }
        None => builder.add_texture(Texture::Constant(color.factor)),
    }
}

/// `a · b`.
pub(super) fn product(builder: &mut SceneBuilder, a: ColorInput, b: ColorInput) -> Result<ColorInput> {
    let texture = match (a.texture, b.texture) {
        (Some(a), Some(b)) => Some(builder.add_texture(Texture::Product(a, b))?),
        (one, other) => one.or(other),
    };
    Ok(ColorInput { factor: a.factor * b.factor, texture })
}

/// Returns `(1 − m) first + m second`, channel by channel.
pub(super) fn mix(
    builder: &mut SceneBuilder,
    [first, second]: [ColorInput; 2],
    amount: ColorInput,
) -> Result<ColorInput> {
    if let (None, None, None) = (first.texture, second.texture, amount.texture) {
        let m = amount.factor;
        return Ok((first.factor * (Rgb::WHITE - m) + second.factor * m).into());
    }
    let (first, second, amount) = (node(builder, first)?, node(builder, second)?, node(builder, amount)?);
    builder.add_texture(Texture::Mix { first, second, amount }).map(whole)
}

/// Texture `(1 − m) first + m second` with constant ends. This is any linear function of the
/// texture `m`, such as `1 − m`.
pub(super) fn between(builder: &mut SceneBuilder, ends: [Rgb; 2], amount: TextureId) -> Result<TextureId> {
    let [first, second] = ends.map(|end| builder.add_texture(Texture::Constant(end)));
    builder.add_texture(Texture::Mix { first: first?, second: second?, amount })
}

/// Checkerboard of two colours; `transform` maps each of its squares to a unit square.
pub(super) fn checkerboard(
    builder: &mut SceneBuilder,
    even: ColorInput,
    odd: ColorInput,
    transform: UvTransform,
) -> Result<ColorInput> {
    let (even, odd) = (node(builder, even)?, node(builder, odd)?);
    builder.add_texture(Texture::Checkerboard { even, odd, transform }).map(whole)
}

/// `u ↦ s_u u + o_u`, `v ↦ s_v v + o_v`.
pub(super) fn scaled([su, sv]: [f32; 2], [ou, ov]: [f32; 2]) -> UvTransform {
    UvTransform(Mat3::from_cols(Vec3::new(su, 0.0, 0.0), Vec3::new(0.0, sv, 0.0), Vec3::new(ou, ov, 1.0)))
}

/// Transform for images, from a scale and an offset for coordinates whose `v` runs up:
/// `ṽ = 1 − v ↦ s_v ṽ + (1 − s_v − o_v)`.
pub(super) fn upward(scale: [f32; 2], offset: [f32; 2]) -> UvTransform {
    scaled(scale, [offset[0], 1.0 - scale[1] - offset[1]])
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::error::Location;

    #[test]
    fn transforms_are_those_of_coordinates_that_run_up() {
        let (scale, offset) = ([2.0, 4.0], [0.1, 0.3]);
        for up in [Vec2::new(0.0, 0.0), Vec2::new(0.7, 0.2), Vec2::new(-1.0, 3.0)] {
            let down = |v: Vec2| Vec2::new(v.x, 1.0 - v.y);
            let expected = up * Vec2::from(scale) + Vec2::from(offset);
            assert!((scaled(scale, offset).0.transform_point2(up) - expected).length() < 1e-5, "{up}");
            let got = upward(scale, offset).0.transform_point2(down(up));
            assert!((got - down(expected)).length() < 1e-5, "{up}: {got}");
        }
    }

    #[test]
    fn combinations_have_the_values_of_their_formulas() {
        let mut builder = SceneBuilder::new("s", Location::file("s"));
        let at = |builder: SceneBuilder, color: ColorInput| {
            color.at(builder.build().unwrap().textures(), Vec2::ZERO)
        };
        let grey = builder.add_texture(Texture::Constant(Rgb::gray(0.25))).unwrap();
        let half = ColorInput { factor: Rgb::gray(0.5), texture: Some(grey) };
        let two = ColorInput::from(Rgb::gray(2.0));
        assert_eq!(product(&mut builder, half, two).unwrap(), whole(grey));
        let ends = [two, product(&mut builder, half, half).unwrap()];
        // 2 (1 − 1/8) + (1/8)² · 1/8
        let mixed = mix(&mut builder, ends, half).unwrap();
        let rest = between(&mut builder, [Rgb::WHITE, Rgb::gray(0.2)], grey).unwrap();
        let sum = product(&mut builder, mixed, whole(rest)).unwrap();
        let expected = (2.0 * 0.875 + 0.125 * 0.125 * 0.125) * (0.75 + 0.25 * 0.2);
        assert!((at(builder, sum).g - expected).abs() < 1e-6);
    }
}
