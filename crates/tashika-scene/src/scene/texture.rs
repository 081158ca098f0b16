//! Textures: a graph of images and simple operations, evaluated at texture coordinates.
//!
//! A texture is a function of `(u, v)` with a linear colour and an opacity. `u` runs to the right,
//! and `v` runs **down** from an image's top row. Loaders of formats with `v` up flip the
//! coordinates once.
//!
//! | node | value |
//! |---|---|
//! | [`Texture::Constant`] | `c` |
//! | [`Texture::Image`] | image at `T (u, v, 1)` |
//! | [`Texture::Tiles`] | the image of the tile that `T (u, v, 1)` is in, see [`TileSet`] |
//! | [`Texture::Product`] | `a · b` |
//! | [`Texture::Mix`] | `(1 − m) a + m b` |
//! | [`Texture::Checkerboard`] | `a` if `⌊u'⌋ + ⌊v'⌋` is even, else `b`; `(u', v') = T (u, v, 1)` |
//! | [`Texture::Power`] | `max(a, 0)ᵏ` |
//!
//! All nodes are evaluated channel by channel, opacity included. If a texture is used as a colour,
//! images are read as colours, and the result is at least 0. If it is used as a number, images are
//! read as they are stored ([`Values`]). The operands of a node are added before the node, so that
//! the graph has no cycles.

use glam::{Mat3, Vec2};

use super::{Image, ImageId, Sampling, TextureId, TileSet, TiledTexture, Values, Wrap};
use crate::color::Rgb;
use crate::math::elementary::powf;

/// An affine map of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform(pub Mat3);

impl Default for UvTransform {
    fn default() -> Self {
        Self(Mat3::IDENTITY)
    }
}

/// A lookup into an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageTexture {
    /// Image that is looked up.
    pub image: ImageId,
    /// Wrapping along `u` and along `v`.
    pub wrap: [Wrap; 2],
    /// Transform of the coordinates before the lookup.
    pub transform: UvTransform,
    /// Interpolation between texels.
    pub sampling: Sampling,
}

impl ImageTexture {
    /// The whole image, repeated, with bilinear interpolation.
    pub fn new(image: ImageId) -> Self {
        Self {
            image,
            wrap: [Wrap::Repeat; 2],
            transform: UvTransform::default(),
            sampling: Sampling::Bilinear,
        }
    }
}

/// A node of the texture graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Texture {
    /// The same colour everywhere, opaque.
    Constant(Rgb),
    /// An image, at transformed coordinates.
    Image(ImageTexture),
    /// An image for each unit square of the coordinates.
    Tiles(TiledTexture),
    /// The product of two textures.
    Product(TextureId, TextureId),
    /// A blend of two textures.
    Mix {
        /// Value where the amount is 0.
        first: TextureId,
        /// Value where the amount is 1.
        second: TextureId,
        /// Share of the second texture, 0 to 1.
        amount: TextureId,
    },
    /// Two textures in alternating squares.
    Checkerboard {
        /// Texture of the squares whose indices have an even sum.
        even: TextureId,
        /// Texture of the other squares.
        odd: TextureId,
        /// Maps the squares to unit squares.
        transform: UvTransform,
    },
    /// A power of a texture.
    Power {
        /// Base of the power; negative values count as 0.
        base: TextureId,
        /// Exponent `k`, the same for all channels.
        exponent: f32,
    },
}

/// One number of a texture's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Opacity; 1 for images without opacity.
    A,
    /// Luminance of red, green and blue.
    Luminance,
}

impl Texture {
    /// Textures that this node is made of.
    pub fn operands(&self) -> impl Iterator<Item = TextureId> + use<> {
        let all = match *self {
            Self::Constant(_) | Self::Image(_) | Self::Tiles(_) => [None; 3],
            Self::Product(a, b) => [Some(a), Some(b), None],
            Self::Mix { first, second, amount } => [Some(first), Some(second), Some(amount)],
            Self::Checkerboard { even, odd, .. } => [Some(even), Some(odd), None],
            Self::Power { base, .. } => [Some(base), None, None],
        };
        all.into_iter().flatten()
    }
}

/// The images and textures of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Textures<'a> {
    /// All images, in the order of their ids.
    pub images: &'a [Image],
    /// All textures, in the order of their ids.
    pub nodes: &'a [Texture],
    /// All sets of tiles, in the order of their ids.
    pub tile_sets: &'a [TileSet],
}

impl Textures<'_> {
    /// Returns linear colour, at least 0, and opacity of a texture at `uv`.
    pub fn lookup(&self, texture: TextureId, uv: Vec2) -> (Rgb, f32) {
        let (color, opacity) = self.value(Values::Colors, texture, uv);
        (color.map(|v| v.max(0.0)), opacity)
    }

    /// Returns three numbers of a texture at `uv`, of any sign, and its opacity.
    pub fn numbers(&self, texture: TextureId, uv: Vec2) -> (Rgb, f32) {
        self.value(Values::Numbers, texture, uv)
    }

    fn value(&self, values: Values, texture: TextureId, uv: Vec2) -> (Rgb, f32) {
        let of = |texture: &TextureId| self.value(values, *texture, uv);
        match &self.nodes[texture.index()] {
            Texture::Constant(c) => (*c, 1.0),
            Texture::Image(t) => {
                let (image, uv) = (&self.images[t.image.index()], t.transform.0.transform_point2(uv));
                image.sampled(values, uv, t.wrap, t.sampling)
            }
            Texture::Tiles(t) => {
                let uv = t.transform.0.transform_point2(uv);
                self.tile_sets[t.set.index()].sampled(values, self.images, uv, t.sampling)
            }
            Texture::Product(a, b) => {
                let ((c, o), (d, p)) = (of(a), of(b));
                (c * d, o * p)
            }
            Texture::Mix { first, second, amount } => {
                let (m, n) = of(amount);
                let ((c, o), (d, p)) = (of(first), of(second));
                (c * (Rgb::WHITE - m) + d * m, o * (1.0 - n) + p * n)
            }
            Texture::Checkerboard { even, odd, transform } => {
                let square = transform.0.transform_point2(uv).floor();
                let is_even = (square.x + square.y).rem_euclid(2.0) < 0.5;
                of(if is_even { even } else { odd })
            }
            Texture::Power { base, exponent } => {
                let (c, o) = of(base);
                let power = |v: f32| powf(v.max(0.0), *exponent);
                (c.map(power), power(o))
            }
        }
    }

    /// Returns one number of a texture at `uv`, of any sign.
    pub fn channel(&self, texture: TextureId, uv: Vec2, channel: Channel) -> f32 {
        let (color, alpha) = self.numbers(texture, uv);
        match channel {
            Channel::R => color.r,
            Channel::G => color.g,
            Channel::B => color.b,
            Channel::A => alpha,
            Channel::Luminance => color.luminance(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Pixels;

    const A: Rgb = Rgb::new(0.25, 0.5, 1.0);
    const B: Rgb = Rgb::new(0.5, 0.5, 0.0);

    fn value(node: Texture, uv: [f32; 2]) -> (Rgb, f32) {
        let image = Image {
            name: "i".into(),
            width: 2,
            height: 1,
            pixels: Pixels::Linear8(vec![[0, 0, 0, 255], [255, 255, 255, 51]]),
        };
        let mut half = ImageTexture::new(ImageId(0));
        half.sampling = Sampling::Nearest;
        let amount = Texture::Constant(Rgb::new(0.0, 0.5, 1.0));
        let nodes = [Texture::Constant(A), Texture::Constant(B), amount, Texture::Image(half), node];
        Textures { images: &[image], nodes: &nodes, tile_sets: &[] }.lookup(TextureId(4), uv.into())
    }

    #[test]
    fn nodes_follow_their_formulas() {
        let [a, b, amount, image] = [0, 1, 2, 3].map(TextureId);
        assert_eq!(value(Texture::Product(a, b), [0.0; 2]).0, A * B);
        assert_eq!(value(Texture::Product(a, image), [0.75, 0.0]), (A, 0.2));
        let mixed = value(Texture::Mix { first: a, second: b, amount }, [0.0; 2]).0;
        assert_eq!(mixed, Rgb::new(A.r, 0.5, B.b));
        let root = value(Texture::Power { base: a, exponent: 0.5 }, [0.0; 2]).0;
        assert_eq!(root, Rgb::new(0.5, 0.5f32.sqrt(), 1.0));
    }

    /// An image with texels `t` of −1 and 1 is the amount of a mix that yields `1 − 3 t`. As a
    /// number, the mix is 4 and −2. As a colour it is 1 and 0: the texel −1 counts as 0, and the
    /// result −2 is raised to 0.
    #[test]
    fn colours_are_at_least_zero_and_numbers_have_a_sign() {
        let pixels = Pixels::Float(vec![[-1.0; 3], [1.0; 3]]);
        let images = [Image { name: "i".into(), width: 2, height: 1, pixels }];
        let map =
            Texture::Image(ImageTexture { sampling: Sampling::Nearest, ..ImageTexture::new(ImageId(0)) });
        let [first, second] = [1.0, -2.0].map(|end| Texture::Constant(Rgb::gray(end)));
        let [amount, first_id, second_id, mix] = [0, 1, 2, 3].map(TextureId);
        let nodes = [map, first, second, Texture::Mix { first: first_id, second: second_id, amount }];
        let textures = Textures { images: &images, nodes: &nodes, tile_sets: &[] };
        let at = |u: f32| {
            let uv = Vec2::new(u, 0.5);
            [
                textures.lookup(mix, uv).0.g,
                textures.numbers(mix, uv).0.g,
                textures.channel(mix, uv, Channel::G),
            ]
        };
        assert_eq!([at(0.25), at(0.75)], [[1.0, 4.0, 4.0], [0.0, -2.0, -2.0]]);
    }

    #[test]
    fn squares_alternate_on_both_sides_of_zero() {
        let transform = UvTransform(Mat3::from_scale(Vec2::new(2.0, 4.0)));
        let board = Texture::Checkerboard { even: TextureId(0), odd: TextureId(1), transform };
        let is_even = |u, v| value(board, [u, v]).0 == A;
        assert!(is_even(0.1, 0.1) && !is_even(0.6, 0.1) && !is_even(0.1, 0.3) && is_even(0.6, 0.3));
        assert!(!is_even(-0.1, 0.1) && is_even(-0.1, -0.1) && is_even(0.6, -0.1));
    }
}
