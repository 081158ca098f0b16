//! Textures in tiles (UDIM): one image for each unit square of the texture coordinates.
//!
//! Columns are `⌊u⌋`, 0 to 9. Rows are `⌊1 − v⌋`, 0 to 899; they are counted **up**, whereas the
//! scene's `v` runs down. The square in a column and a row has the number
//!
//! ```text
//! 1001 + ⌊u⌋ + 10 ⌊1 − v⌋
//! ```
//!
//! A lookup uses only the image of its square. Beyond the edge of the image the outermost texels
//! continue, so that tiles do not bleed into each other. Squares without an image have the value
//! [`NO_TILE`]; if a mesh uses such a square, a note reports a missing file.
//!
//! # Held to this by
//! The tests below; `suite::udim`.

use std::collections::BTreeSet;

use glam::Vec2;

use super::{
    Image, ImageId, Mesh, NoteKind, Sampling, SceneBuilder, Texture, TextureId, TileSetId, UvTransform,
    Values, Wrap,
};
use crate::color::Rgb;
use crate::error::{Error, Result};

/// Value of squares without an image: a medium grey.
pub const NO_TILE: Rgb = Rgb::gray(0.5);

/// Images of tiles, by their numbers.
#[derive(Clone, Debug)]
pub struct TileSet {
    /// Name that identifies the set in messages, usually the pattern of the files' names.
    pub name: String,
    /// Numbers and images of the tiles, in the order of their numbers; each number once.
    pub tiles: Vec<(u32, ImageId)>,
}

/// A lookup into a set of tiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiledTexture {
    /// The images, by tile.
    pub set: TileSetId,
    /// Transform of the coordinates before the lookup.
    pub transform: UvTransform,
    /// Interpolation between texels.
    pub sampling: Sampling,
}

/// Returns the number of a tile and the coordinates inside it; `None` beyond the numbered columns
/// and rows.
fn tile(uv: Vec2) -> Option<(u32, Vec2)> {
    let square = Vec2::new(uv.x, 1.0 - uv.y).floor();
    let inside = (0.0..10.0).contains(&square.x) && (0.0..900.0).contains(&square.y);
    inside
        .then(|| (1001 + square.x as u32 + 10 * square.y as u32, Vec2::new(uv.x - square.x, uv.y + square.y)))
}

impl TileSet {
    fn picture(&self, number: u32) -> Option<ImageId> {
        self.tiles.binary_search_by_key(&number, |t| t.0).ok().map(|i| self.tiles[i].1)
    }

    /// Returns linear value and opacity at coordinates after the texture's transform.
    pub(super) fn sampled(
        &self,
        values: Values,
        images: &[Image],
        uv: Vec2,
        sampling: Sampling,
    ) -> (Rgb, f32) {
        let Some((number, inside)) = tile(uv) else { return (NO_TILE, 1.0) };
        let Some(picture) = self.picture(number) else { return (NO_TILE, 1.0) };
        images[picture.index()].sampled(values, inside, [Wrap::Clamp; 2], sampling)
    }
}

/// Largest number of missing tiles of a set for which each has its own note; chosen.
const MAX_NAMED: usize = 100;

impl SceneBuilder {
    /// Adds a set of tiles, whose images must have been added before.
    ///
    /// # Errors
    /// Numbers outside 1001 to 9999, not in order, or repeated; images that are not of this scene.
    pub fn add_tiles(&mut self, set: TileSet) -> Result<TileSetId> {
        let numbered = set.tiles.iter().all(|t| (1001..=9999).contains(&t.0));
        let ordered = set.tiles.is_sorted_by(|a, b| a.0 < b.0);
        if !numbered || !ordered || set.tiles.iter().any(|t| t.1.index() >= self.scene.images.len()) {
            let found = format!("tiles {:?}", set.tiles);
            let at = self.origin.clone().item(format!("tiles {}", set.name));
            return Err(Error::invalid(at, found, "images of this scene, by numbers from 1001 to 9999"));
        }
        self.scene.tile_sets.push(set);
        Ok(TileSetId(self.scene.tile_sets.len() as u32 - 1))
    }

    /// Notes tiles without an image that contain the centre of any triangle of a mesh.
    pub(super) fn note_missing_tiles(&mut self) {
        if self.scene.tile_sets.is_empty() {
            return;
        }
        let mut missing: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); self.scene.tile_sets.len()];
        // Meshes without coordinates use no tile.
        for mesh in self.scene.meshes.iter().filter(|mesh| !mesh.uvs.is_empty()) {
            for texture in self.tiled_textures(mesh) {
                let TiledTexture { set, transform, .. } = texture;
                let (tiles, missing) = (&self.scene.tile_sets[set.index()], &mut missing[set.index()]);
                for triangle in &mesh.triangles {
                    let middle = triangle.iter().map(|&i| mesh.uvs[i as usize]).sum::<Vec2>() / 3.0;
                    // Squares beyond the numbered columns and rows have no file that could be
                    // missing.
                    let reached = tile(transform.0.transform_point2(middle));
                    missing.extend(reached.map(|t| t.0).filter(|n| tiles.picture(*n).is_none()));
                }
            }
        }
        for (set, numbers) in missing.into_iter().enumerate() {
            let name = self.scene.tile_sets[set].name.clone();
            let more = numbers.len().saturating_sub(MAX_NAMED);
            for number in numbers.into_iter().take(MAX_NAMED) {
                let message = format!("image {name:?} has no tile {number}: grey of 0.5");
                self.note(NoteKind::Missing, message, self.origin.clone());
            }
            if more > 0 {
                let message = format!("image {name:?} has no file for {more} further tiles: grey of 0.5");
                self.note(NoteKind::Missing, message, self.origin.clone());
            }
        }
    }

    /// Textures in tiles that the material of a mesh looks up, each once.
    fn tiled_textures(&self, mesh: &Mesh) -> Vec<TiledTexture> {
        let scene = &self.scene;
        let (mut materials, mut known) = (vec![mesh.material], BTreeSet::new());
        let mut textures: Vec<TextureId> = Vec::new();
        while let Some(material) = materials.pop() {
            if known.insert(material) {
                let material = &scene.materials[material.index()];
                materials.extend(material.others());
                textures.extend(material.textures());
            }
        }
        let (mut known, mut tiled) = (BTreeSet::new(), Vec::new());
        while let Some(texture) = textures.pop() {
            if known.insert(texture) {
                let texture = &scene.textures[texture.index()];
                textures.extend(texture.operands());
                if let Texture::Tiles(t) = texture {
                    tiled.push(*t);
                }
            }
        }
        tiled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Pixels;

    #[test]
    fn squares_are_numbered_from_the_lower_left_in_rows_of_ten() {
        // `number` takes `v` upwards, for which the first row is between 0 and 1.
        let number = |u: f32, up: f32| tile(Vec2::new(u, 1.0 - up)).map(|t| t.0);
        assert_eq!([number(0.5, 0.5), number(0.0, 0.0)], [Some(1001); 2]);
        assert_eq!([number(9.9, 0.5), number(0.5, 1.5), number(3.25, 2.75)], [1010, 1011, 1024].map(Some));
        assert_eq!([number(1.0, 0.5), number(0.5, 1.0)], [1002, 1011].map(Some), "by floor");
        assert_eq!(number(9.0, 898.5), Some(9990));
        for outside in [number(-0.1, 0.5), number(10.0, 0.5), number(0.5, -0.1), number(0.5, 900.5)] {
            assert_eq!(outside, None);
        }
        assert_eq!(tile(Vec2::new(f32::NAN, 0.0)), None);
        let inside = tile(Vec2::new(3.25, 1.0 - 2.75)).unwrap().1;
        assert_eq!(inside, Vec2::new(0.25, 0.25), "a quarter below the picture's top");
    }

    #[test]
    fn every_tile_shows_its_own_picture_up_to_the_edge() {
        // Each image has two texels. The left one is 10 times the number of the image, the right
        // one is larger by 1.
        let image = |k: u8| Image {
            name: "i".into(),
            width: 2,
            height: 1,
            pixels: Pixels::Float(vec![[f32::from(k) * 10.0; 3], [f32::from(k) * 10.0 + 1.0; 3]]),
        };
        let images = [image(1), image(2), image(3)];
        let set = TileSet {
            name: "w".into(),
            tiles: vec![(1001, ImageId(2)), (1002, ImageId(0)), (1011, ImageId(1))],
        };
        let sampled = |uv, sampling| set.sampled(Values::Colors, &images, uv, sampling);
        let at = |u, up: f32| sampled(Vec2::new(u, 1.0 - up), Sampling::Bilinear).0.r;
        assert_eq!([at(0.1, 0.5), at(0.999, 0.5), at(0.5, 0.5)], [30.0, 31.0, 30.5]);
        assert_eq!([at(1.0, 0.5), at(1.9, 0.1), at(0.2, 1.5)], [10.0, 11.0, 20.0]);
        assert_eq!([at(1.5, 1.5), at(-0.5, 0.5)], [0.5; 2], "no picture");
        assert_eq!(sampled(Vec2::new(0.6, 0.5), Sampling::Nearest), (Rgb::gray(31.0), 1.0));
    }
}
