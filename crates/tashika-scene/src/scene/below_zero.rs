//! Notes of colours that have values below zero.
//!
//! A floating-point image may be used as a height, which may be negative, or as a colour, which
//! must not be. The materials of the finished scene determine the use ([`Values`]). A note is added
//! for each image that is used as a colour, directly or as an operand of a texture, and has values
//! below zero. Such values count as 0.
//!
//! Checked by the tests below and by the suite's `signed_images`.

use std::collections::BTreeSet;

use super::{ImageId, NoteKind, SceneBuilder, Texture, TextureId, Values};
use crate::color::Rgb;

/// Returns the message about texels below zero that count as 0. The count of its note is the number
/// of such texels.
pub fn below_zero_message(image: &str) -> String {
    format!("image {image:?} has texels below zero, which no colour is: taken as 0")
}

impl SceneBuilder {
    /// Returns the number of texels of an added image with a channel below zero.
    pub fn texels_below_zero(&self, image: ImageId) -> u64 {
        self.below_zero[image.index()]
    }

    /// Adds a note for each image that is used as a colour and has texels below zero, with their
    /// number. Adds a note for constants below zero, too.
    pub(super) fn note_colors_below_zero(&mut self) {
        let has_sign = |node: &Texture| matches!(node, Texture::Constant(c) if !is_color(*c));
        if self.below_zero.iter().all(|n| *n == 0) && !self.scene.textures.iter().any(has_sign) {
            return;
        }
        let (mut images, mut constants) = (BTreeSet::new(), 0);
        let mut known = BTreeSet::new();
        let inputs = self.scene.materials.iter().flat_map(|material| material.inputs());
        let mut textures: Vec<TextureId> =
            inputs.filter(|(_, values)| *values == Values::Colors).map(|(texture, _)| texture).collect();
        while let Some(texture) = textures.pop() {
            if !known.insert(texture) {
                continue;
            }
            let node = &self.scene.textures[texture.index()];
            match node {
                Texture::Image(image) => images.extend([image.image]),
                Texture::Tiles(tiles) => {
                    let set = &self.scene.tile_sets[tiles.set.index()];
                    images.extend(set.tiles.iter().map(|(_, image)| *image));
                }
                Texture::Constant(_) => constants += u64::from(has_sign(node)),
                // A constant below zero may be an end of a linear map. Only interpolated values of
                // the map are visible, so the constant itself is no error.
                Texture::Mix { first, second, amount } => {
                    let is_constant =
                        |end: &TextureId| matches!(self.scene.textures[end.index()], Texture::Constant(_));
                    textures.push(*amount);
                    textures.extend([first, second].into_iter().filter(|end| !is_constant(end)));
                    continue;
                }
                Texture::Product(..) | Texture::Checkerboard { .. } | Texture::Power { .. } => {}
            }
            textures.extend(node.operands());
        }
        let repaired = NoteKind::Repaired;
        for ImageId(index) in images {
            let message = below_zero_message(&self.scene.images[index as usize].name);
            let at = self.origin.clone();
            self.scene.notes.push_many(repaired, message, at, self.below_zero[index as usize]);
        }
        let message = "textures of colours with a constant below zero: taken as 0";
        self.scene.notes.push_many(repaired, message, self.origin.clone(), constants);
    }
}

fn is_color(c: Rgb) -> bool {
    c.to_array().into_iter().all(|v| v >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Location;
    use crate::scene::{
        Channel, ColorInput, FloatInput, Image, ImageTexture, Material, NormalInput, Pixels, Surface,
    };

    fn image(name: &str) -> Image {
        let pixels = Pixels::Float(vec![[-1.0, 0.0, 0.0], [0.0; 3], [1.0, -2.0, -3.0]]);
        Image { name: name.into(), width: 3, height: 1, pixels }
    }

    /// Notes of a scene with two images, `a` and `b`, whose product is a bump map. `use_of_a`
    /// returns the reflectance, which may use `a` as a colour.
    fn notes(use_of_a: impl Fn(TextureId) -> ColorInput) -> Vec<(String, u64)> {
        let mut builder = SceneBuilder::new("s", Location::file("s"));
        let mut texture = |name: &str| {
            let image = builder.add_image(image(name)).unwrap();
            builder.add_texture(Texture::Image(ImageTexture::new(image))).unwrap()
        };
        let [a, b] = ["a", "b"].map(&mut texture);
        let product = builder.add_texture(Texture::Product(a, b)).unwrap();
        let height = FloatInput { factor: 1.0, texture: Some((product, Channel::R)) };
        let mut material = Material::new("m", Surface::Lambert { reflectance: use_of_a(a) });
        material.normal = Some(NormalInput::Bump { height });
        builder.add_material(material).unwrap();
        let scene = builder.build().unwrap();
        let repaired = scene.notes().iter().filter(|note| note.kind == NoteKind::Repaired);
        repaired.map(|note| (note.message, note.count)).collect()
    }

    #[test]
    fn an_image_below_zero_is_noted_where_it_is_a_colour_and_only_there() {
        assert!(notes(|_| Rgb::WHITE.into()).is_empty(), "a height may be below zero");
        let color = |texture| ColorInput { factor: Rgb::WHITE, texture: Some(texture) };
        assert_eq!(notes(color), [(below_zero_message("a"), 2)]);
    }

    #[test]
    fn constants_below_zero_are_noted_but_for_the_ends_of_linear_maps() {
        let of = |as_end: bool| {
            let mut builder = SceneBuilder::new("s", Location::file("s"));
            let [low, high] = [-1.0, 1.0].map(|end| Texture::Constant(Rgb::gray(end)));
            let [low, high] = [low, high].map(|end| builder.add_texture(end).unwrap());
            let whole = if as_end {
                Texture::Mix { first: low, second: high, amount: high }
            } else {
                Texture::Product(low, high)
            };
            let texture = Some(builder.add_texture(whole).unwrap());
            let reflectance = ColorInput { factor: Rgb::WHITE, texture };
            builder.add_material(Material::new("m", Surface::Lambert { reflectance })).unwrap();
            let scene = builder.build().unwrap();
            scene.notes().iter().filter(|note| note.kind == NoteKind::Repaired).count()
        };
        assert_eq!([of(true), of(false)], [0, 1]);
    }
}
