//! Textures: images decoded once for each encoding they are used with, samplers, coordinate
//! transforms.
//!
//! `KHR_texture_transform` maps texture coordinates by `T · R · S` with
//!
//! ```text
//! R = | cos  sin |
//!     | −sin cos |
//! ```
//!
//! which turns counter-clockwise where `v` runs down. (The sample code in early versions of the
//! extension turns the other way and contradicts its own example, which is the test here.)
//!
//! A sampler's `magFilter` chooses between the nearest texel and bilinear interpolation;
//! `minFilter` has no use, because each path samples a point.
//!
//! # Held to this by
//! The tests below; `gltf::textures_are_decoded_once_for_each_encoding`,
//! `gltf_materials::samplers_choose_the_nearest_texel_or_four`,
//! `damaged_gltf::a_texture_that_cannot_be_read_is_left_out`.

use std::collections::BTreeMap;

use glam::{Mat3, Vec3};
use gltf::json;
use gltf::json::texture::{MagFilter, WrappingMode};
use gltf::json::validation::Checked;

use super::source::Source;
use super::uri;
use crate::error::{Error, Result};
use crate::io::assets::{FACTOR_ALONE, decode as decode_image, kind, reason, unreadable_image};
use crate::io::images::Encoding;
use crate::io::notes::shown;
use crate::math::elementary::sin_cos;
use crate::scene::{
    ImageId, ImageTexture, NoteKind, Pixels, Sampling, SceneBuilder, Texture, TextureId, UvTransform, Wrap,
};

/// Largest coefficient of a texture transform; beyond it, `f32` does not resolve neighbouring
/// texels.
const MAX_COEFFICIENT: f32 = 1e6;

/// A texture in use.
#[derive(Clone, Copy, Debug)]
pub(super) struct UsedTexture {
    /// Lookup in the image.
    pub texture: TextureId,
    /// Set of the mesh's texture coordinates for the lookup.
    pub uv_set: u32,
    /// True if every texel is opaque.
    pub opaque: bool,
}

/// Interpretation of an image's channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Content {
    /// Colours, decoded by the sRGB curve.
    Color,
    /// Independent numbers, one in each channel.
    Numbers,
    /// The number in this channel, 0 to 3, copied to red, green and blue: for products with other
    /// textures, which are formed by channel.
    Spread(usize),
}

/// Images decoded so far, by index and content; none where decoding failed.
#[derive(Debug, Default)]
pub(super) struct Textures {
    images: BTreeMap<(usize, Content), Option<(ImageId, bool)>>,
}

impl Textures {
    /// Returns the texture that `info` names by an index, which must be in range; none, with a
    /// note, if its image cannot be read. `item` is the place of `info` in the file.
    pub fn get(
        &mut self,
        source: &Source<'_>,
        builder: &mut SceneBuilder,
        info: &json::texture::Info,
        content: Content,
        item: &str,
    ) -> Option<UsedTexture> {
        let index = info.index.value();
        let texture = &source.root.textures[index];
        if texture.source.value() >= source.root.images.len() {
            let message = "textures without an image in a format that is read: their factor is used alone";
            builder.note(NoteKind::Repaired, message, source.at(format!("textures[{index}].source")));
            return None;
        };
        let image = texture.source.value();
        let decoded = self.images.entry((image, content)).or_insert_with(|| {
            let decoded = decode(source, builder, image, content);
            let note = |error: Error| {
                let name = shown(&image_name(source, image));
                let message = unreadable_image(&name, &reason(&error), FACTOR_ALONE);
                builder.note(kind(&error), message, source.at(format!("images[{image}]")));
            };
            decoded.map_err(note).ok()
        });
        let (image, opaque) = (*decoded)?;
        let mut lookup = ImageTexture::new(image);
        if let Some(sampler) = texture.sampler {
            let sampler = &source.root.samplers[sampler.value()];
            lookup.wrap = [wrap(sampler.wrap_s), wrap(sampler.wrap_t)];
            if sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)) {
                lookup.sampling = Sampling::Nearest;
            }
        }
        let extension = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        lookup.transform = extension.map_or(Some(UvTransform::default()), transform).unwrap_or_else(|| {
            let message = "texture transforms that are not finite or huge: left out";
            builder.note(NoteKind::Repaired, message, source.at(item));
            UvTransform::default()
        });
        let uv_set = extension.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord);
        // Fails only for transforms that are not finite, and these were replaced above.
        let texture = builder.add_texture(Texture::Image(lookup)).ok()?;
        Some(UsedTexture { texture, uv_set, opaque })
    }
}

/// Decodes an image of the document and adds it. The second value is true if every texel is opaque.
fn decode(
    source: &Source<'_>,
    builder: &mut SceneBuilder,
    index: usize,
    content: Content,
) -> Result<(ImageId, bool)> {
    let at = source.at(format!("images[{index}]"));
    let bytes = source.image(index)?;
    let encoding = if content == Content::Color { Encoding::Srgb } else { Encoding::Linear };
    let name = image_name(source, index);
    let mut decoded = decode_image(&bytes, &name, encoding, source.options(), &at, builder)?;
    source.image_budget.take(decoded.image.bytes() as u64, &at)?;
    if let Content::Spread(channel) = content {
        spread(&mut decoded.image.pixels, channel);
    }
    Ok((builder.add_image(decoded.image)?, decoded.opaque))
}

/// Copies a channel to red, green and blue.
fn spread(pixels: &mut Pixels, channel: usize) {
    fn to_colors<T: Copy>(texels: &mut [[T; 4]], channel: usize) {
        for texel in texels {
            let number = texel[channel];
            texel[..3].fill(number);
        }
    }
    match pixels {
        Pixels::Srgb8(texels) | Pixels::Linear8(texels) => to_colors(texels, channel),
        Pixels::Srgb16(texels) | Pixels::Linear16(texels) => to_colors(texels, channel),
        // Images of floats have no opacity; it counts as one.
        Pixels::Float(texels) => {
            texels.iter_mut().for_each(|t| *t = [t.get(channel).copied().unwrap_or(1.0); 3]);
        }
    }
}

/// The image's file, else its name, else its place.
fn image_name(source: &Source<'_>, index: usize) -> String {
    let image = &source.root.images[index];
    let file = image.uri.as_deref().filter(|uri| image.buffer_view.is_none() && !uri::is_data(uri));
    file.or(image.name.as_deref()).map_or_else(|| format!("images[{index}]"), str::to_owned)
}

fn wrap(mode: Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    }
}

/// The transform, unless a coefficient is not finite or too large.
fn transform(t: &json::extensions::texture::TextureTransform) -> Option<UvTransform> {
    let ([x, y], [sx, sy]) = (t.offset.0, t.scale.0);
    let (sin, cos) = sin_cos(t.rotation.0);
    let columns =
        [Vec3::new(cos * sx, -sin * sx, 0.0), Vec3::new(sin * sy, cos * sy, 0.0), Vec3::new(x, y, 1.0)];
    let usable = columns.iter().all(|c| c.abs().max_element() <= MAX_COEFFICIENT && c.is_finite());
    usable.then(|| UvTransform(Mat3::from_cols(columns[0], columns[1], columns[2])))
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    fn map(json: &str, uv: [f32; 2]) -> Option<Vec2> {
        let t = transform(&json::deserialize::from_str(json).unwrap());
        t.map(|t| t.0.transform_point2(Vec2::from_array(uv)))
    }

    #[test]
    fn the_extensions_example_shows_the_lower_left_quadrant_turned_clockwise() {
        let example = r#"{"offset":[0,1],"rotation":1.57079632679,"scale":[0.5,0.5]}"#;
        // The corners of the quad are looked up clockwise from the top left. They must show the
        // corners of the lower left quadrant after a quarter turn: the quadrant's top left appears
        // at the top right.
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let expected = [[0.0, 1.0], [0.0, 0.5], [0.5, 0.5], [0.5, 1.0]];
        for (uv, seen) in corners.into_iter().zip(expected) {
            let mapped = map(example, uv).unwrap();
            assert!((mapped - Vec2::from_array(seen)).length() < 1e-6, "{uv:?} sees {mapped}");
        }
    }

    #[test]
    fn a_channel_is_copied_to_the_others() {
        let mut pixels = Pixels::Linear8(vec![[1, 2, 3, 4], [5, 6, 7, 8]]);
        spread(&mut pixels, 3);
        assert!(matches!(pixels, Pixels::Linear8(t) if t == [[4, 4, 4, 4], [8, 8, 8, 8]]));
        let mut wide = Pixels::Linear16(vec![[1, 2, 3, 400]]);
        spread(&mut wide, 3);
        assert!(matches!(wide, Pixels::Linear16(t) if t == [[400; 4]]));
        let mut float = Pixels::Float(vec![[0.1, 0.2, 0.3]]);
        spread(&mut float, 1);
        assert!(matches!(&float, Pixels::Float(t) if t == &[[0.2; 3]]));
        spread(&mut float, 3);
        assert!(matches!(float, Pixels::Float(t) if t == [[1.0; 3]]), "opaque");
    }

    #[test]
    fn defaults_change_nothing_and_unusable_transforms_are_refused() {
        assert_eq!(map("{}", [0.3, 0.7]), Some(Vec2::new(0.3, 0.7)));
        assert_eq!(map(r#"{"offset":[0,1],"scale":[1,-1]}"#, [0.25, 0.25]), Some(Vec2::new(0.25, 0.75)));
        assert_eq!(map(r#"{"scale":[1e300,1]}"#, [0.0; 2]), None, "infinite in f32");
        assert_eq!(map(r#"{"offset":[0,1e9]}"#, [0.0; 2]), None);
        assert_eq!(map(r#"{"rotation":1e300}"#, [0.0; 2]), None);
    }
}
