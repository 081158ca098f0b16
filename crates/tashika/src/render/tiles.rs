//! Which tiles an image has, and which of them one machine renders.

use std::fmt;

use crate::error::{Error, Result};
use crate::film::Window;

/// A share of the tiles: the `number`-th of `of`, counted from 1. All shares together are the image, and no two overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileShare {
    /// From 1 to `of`.
    pub number: u32,
    /// How many shares there are.
    pub of: u32,
}

impl Default for TileShare {
    fn default() -> Self {
        Self { number: 1, of: 1 }
    }
}

impl fmt::Display for TileShare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// Gather points of a tile: enough for fans that are worth a packet, few enough that a tile is soon done.
const POINTS_PER_TILE: u32 = 1024;

impl TileShare {
    /// The share's tiles of a window, row by row.
    pub(super) fn tiles(&self, window: &Window, points_per_pixel: u32) -> Result<Vec<Window>> {
        if self.of == 0 || self.number == 0 || self.number > self.of {
            return Err(Error::option("tiles", self, "K/N with K from 1 to N"));
        }
        let mut side = 4;
        while side < 32 && 4 * side * side * points_per_pixel <= POINTS_PER_TILE {
            side *= 2;
        }
        let mut tiles = Vec::new();
        let (right, bottom) = (window.x + window.width, window.y + window.height);
        for y in (window.y..bottom).step_by(side as usize) {
            for x in (window.x..right).step_by(side as usize) {
                tiles.push(Window { x, y, width: side.min(right - x), height: side.min(bottom - y) });
            }
        }
        // Neighbouring tiles go to different shares, so that shares cost about the same.
        let mine = (0..).zip(tiles).filter(|(i, _)| i % u64::from(self.of) == u64::from(self.number) - 1);
        Ok(mine.map(|(_, t)| t).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_cover_the_window_once() {
        let window = Window { x: 3, y: 5, width: 71, height: 50 };
        for of in [1, 2, 3, 7, 5000] {
            let mut seen = vec![0; 71 * 50];
            for number in 1..=of {
                for t in (TileShare { number, of }).tiles(&window, 4).unwrap() {
                    t.pixels().for_each(|(x, y)| seen[window.index(x, y)] += 1);
                }
            }
            assert!(seen.iter().all(|n| *n == 1), "{of} shares");
        }
        for (number, of) in [(0, 1), (2, 1), (1, 0)] {
            assert!(TileShare { number, of }.tiles(&window, 1).is_err());
        }
    }
}
