//! Partition of an environment's directions into blocks, each with its probability of being
//! sampled.

use std::ops::Range;

use super::Environment;
use crate::math::Vec3;
use crate::stats::{Block, Piecewise2d};

/// Blocks of texels of an environment's image, roughly square.
#[derive(Clone, Debug)]
pub struct EnvironmentBlocks {
    /// Columns and rows of blocks.
    size: [usize; 2],
    /// Blocks in rows; `None` where the environment is dark.
    blocks: Vec<Option<Block>>,
    /// Uniform density that replaces the image of a constant environment.
    even: Option<Piecewise2d>,
}

impl EnvironmentBlocks {
    /// Divides an environment into nearly `most` blocks, never more.
    pub fn new(environment: &Environment, most: usize) -> Self {
        let even = environment.density().is_none().then(|| {
            let side = (most as f64).sqrt() as usize;
            Piecewise2d::new(&vec![1.0; side * side], side).expect("its weights are above zero")
        });
        let mut blocks = Self { size: [0; 2], blocks: Vec::new(), even };
        let density = blocks.density(environment);
        let [width, height] = density.size();
        let columns = ((most * width) as f64 / height as f64).sqrt() as usize;
        let columns = columns.clamp(1, width.min(most));
        let rows = (most / columns).clamp(1, height);
        let part =
            |k: usize, of: usize, cells: usize| -> Range<usize> { k * cells / of..(k + 1) * cells / of };
        let block =
            |k: usize| density.block([part(k % columns, columns, width), part(k / columns, rows, height)]);
        blocks.blocks = (0..columns * rows).map(block).collect();
        blocks.size = [columns, rows];
        blocks
    }

    fn density<'a>(&'a self, environment: &'a Environment) -> &'a Piecewise2d {
        environment.density().or(self.even.as_ref()).expect("a constant has an even density")
    }

    /// Number of blocks.
    pub fn count(&self) -> usize {
        self.blocks.len()
    }

    /// Probability that [`Environment::sample`] returns a direction of a block.
    pub fn probability(&self, block: usize) -> f64 {
        self.blocks[block].as_ref().map_or(0.0, Block::probability)
    }

    /// Returns the block that contains a unit direction.
    pub fn of(&self, environment: &Environment, direction: Vec3) -> usize {
        let place = environment.place(direction).map(f64::from);
        let cells = self.density(environment).size();
        let [column, row] = [0, 1].map(|axis| {
            let cell = ((place[axis] * cells[axis] as f64) as usize).min(cells[axis] - 1);
            // Inverts the assignment of cells to blocks in `new`.
            ((cell + 1) * self.size[axis] - 1) / cells[axis]
        });
        row * self.size[0] + column
    }

    /// Samples a direction within a block, in proportion to the density of [`Environment::sample`].
    /// The block must not be dark.
    pub fn sample(&self, environment: &Environment, block: usize, u: [f32; 2]) -> Vec3 {
        let block = self.blocks[block].as_ref().expect("a block that is not dark");
        let (place, _) = self.density(environment).sample_in(block, u.map(f64::from));
        environment.direction(place.map(|v| v as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::math::Mat3;
    use crate::rng::{Purpose, Stream};
    use crate::scene::{Image, Pixels};

    fn image() -> Image {
        let mut pixels = vec![[0.2, 0.3, 0.4]; 37 * 19];
        pixels[2 * 37 + 5] = [500.0, 400.0, 300.0];
        // The dark part of the image is so large that it contains whole blocks.
        pixels[12 * 37..].fill([0.0; 3]);
        Image { name: "test".into(), width: 37, height: 19, pixels: Pixels::Float(pixels) }
    }

    /// For an image of a single row, the number of blocks is limited as for other images.
    #[test]
    fn there_are_no_more_blocks_than_were_asked_for() {
        let pixels = Pixels::Float(vec![[1.0; 3]; 4000]);
        let row = Image { name: "row".into(), width: 4000, height: 1, pixels };
        let environment = Environment::lat_long(row, Rgb::WHITE, Mat3::IDENTITY);
        assert_eq!(EnvironmentBlocks::new(&environment, 50).count(), 50);
    }

    /// Directions sampled in a block lie in that block. Among samples of the environment, the
    /// frequency of each block agrees with its probability.
    #[test]
    fn blocks_share_the_directions_of_an_environment() {
        let turned = Mat3::from_rotation_x(0.4);
        for environment in [
            Environment::lat_long(image(), Rgb::WHITE, turned),
            Environment::octahedral(image(), Rgb::WHITE, turned),
            Environment::constant(Rgb::WHITE),
        ] {
            let blocks = EnvironmentBlocks::new(&environment, 50);
            assert!((30..=50).contains(&blocks.count()), "{} blocks", blocks.count());
            let mut s = Stream::new(1, Purpose::Test, 0);
            let mut found = vec![0; blocks.count()];
            for _ in 0..20_000 {
                found[blocks.of(&environment, environment.sample(s.uniform_2()).0)] += 1;
            }
            let mut all = 0.0;
            let mut elsewhere = 0;
            for (block, found) in found.into_iter().enumerate() {
                let said = blocks.probability(block);
                all += said;
                let error = (said * (1.0 - said) / 20_000.0).sqrt() + 2e-4;
                assert!((f64::from(found) / 20_000.0 - said).abs() < 5.0 * error, "{found} for {said}");
                for _ in 0..if said > 0.0 { 100 } else { 0 } {
                    let direction = blocks.sample(&environment, block, s.uniform_2());
                    elsewhere += u32::from(blocks.of(&environment, direction) != block);
                }
            }
            assert!((all - 1.0).abs() < 1e-9, "{all}");
            // Rounding may move directions across a boundary.
            assert!(elsewhere <= 3, "{elsewhere}");
        }
    }
}
