//! A film reduced to a size that can be held and shown as a whole: the least certain pixel of each
//! block, with the complete record of that pixel.
//!
//! The level of the overview and all coarser ones are made from it, since choosing in two steps
//! gives the pixels of one step, up to ties ([`tashika::report::least_certain`]). Pixels that were
//! not read yet are zeros, as are pixels that were not rendered.
//!
//! # Held to this by
//! The tests of `live` and `stored`.

use tashika::film::{Film, Window};
use tashika::report::least_certain;

use crate::shown::{Collected, Tile};

/// Largest number of samples of a channel.
const MOST_SAMPLES: u64 = 1 << 21;

/// The smallest power of two by which a window must be reduced to fit.
pub(crate) fn factor(window: Window) -> u32 {
    let thinned = |k: u32| u64::from(window.width.div_ceil(k)) * u64::from(window.height.div_ceil(k));
    let mut factor = 1;
    while thinned(factor) > MOST_SAMPLES {
        factor *= 2;
    }
    factor
}

/// A film of the least certain pixels of another film.
pub(crate) struct Overview {
    /// Side of a block (pixels).
    factor: u32,
    /// Window of the film that is reduced.
    window: Window,
    film: Film,
}

impl Overview {
    /// An overview of zeros, for a film that has the given window and the planes of `like`.
    pub(crate) fn new(like: &Film, window: Window) -> Self {
        Self::thinned(like, window, factor(window))
    }

    pub(crate) fn thinned(like: &Film, window: Window, factor: u32) -> Self {
        let size = [window.width.div_ceil(factor), window.height.div_ceil(factor)];
        let film = like.blank(size, Window::full(size)).expect("a smaller size than one that was checked");
        Self { factor, window, film }
    }

    pub(crate) fn factor(&self) -> u32 {
        self.factor
    }

    /// Renews the choice for all blocks that `part` meets, from a film that contains these blocks.
    pub(crate) fn renew(&mut self, film: &Film, part: Window) {
        let k = self.factor;
        let first = [(part.x - self.window.x) / k, (part.y - self.window.y) / k];
        let end = [
            (part.x + part.width - self.window.x).div_ceil(k),
            (part.y + part.height - self.window.y).div_ceil(k),
        ];
        let blocks = Window {
            x: self.window.x + first[0] * k,
            y: self.window.y + first[1] * k,
            width: (end[0] * k).min(self.window.width) - first[0] * k,
            height: (end[1] * k).min(self.window.height) - first[1] * k,
        };
        if k == 1 {
            for y in blocks.y..blocks.y + blocks.height {
                self.film.copy_pixels([first[0], y - self.window.y], film, [blocks.x, y], blocks.width);
            }
            return;
        }
        let across = (end[0] - first[0]) as usize;
        for (i, pixel) in least_certain(film, blocks, k).into_iter().enumerate() {
            let to = [first[0] + (i % across) as u32, first[1] + (i / across) as u32];
            self.film.copy_pixels(to, film, pixel, 1);
        }
    }

    /// Fills `part` with the last row of blocks above it, until its own pixels are known.
    pub(crate) fn stand_in(&mut self, part: Window) {
        let top = (part.y - self.window.y) / self.factor;
        let end = (part.y + part.height - self.window.y).div_ceil(self.factor);
        let width = self.film.window().width;
        let above = Window { x: 0, y: top - 1, width, height: 1 };
        let mut row = self.film.blank(self.film.size(), above).expect("a row of the film");
        row.copy_pixels([0, above.y], &self.film, [0, above.y], width);
        for y in top..end {
            self.film.copy_pixels([0, y], &row, [0, above.y], width);
        }
    }

    /// A tile of a level that is not finer than the overview, for the pixels of `part`; `step` is
    /// the side of the block of a sample (pixels).
    pub(crate) fn tile(&self, version: u64, planes: &[usize], part: Window, step: u32) -> Tile {
        let k = self.factor;
        let part = Window {
            x: (part.x - self.window.x) / k,
            y: (part.y - self.window.y) / k,
            width: part.width.div_ceil(k),
            height: part.height.div_ceil(k),
        };
        let mut bytes = Collected::new(planes);
        bytes.add(&self.film, part, step / k);
        Tile { version, bytes: bytes.into_bytes() }
    }
}
