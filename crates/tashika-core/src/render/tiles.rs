//! Tiles of an image, and shares of the tiles for several machines.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, Result};
use crate::film::Window;

/// Some of the `of` shares of an image's tiles, counted from 1. All shares together are the image,
/// and no two overlap.
///
/// Written as `K/N`, or as a list, `1,4,7/16`. If there are at most 16 shares, each consists of
/// every `N`-th tile, and its film covers the whole window. If there are more, each consists of a
/// run of neighbouring tiles, and its film covers the part of the window that contains them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileShare {
    /// Numbers of the shares, from 1 to `of`, each once, in rising order; at least one.
    numbers: Vec<u32>,
    of: u32,
}

impl Default for TileShare {
    fn default() -> Self {
        Self { numbers: vec![1], of: 1 }
    }
}

impl fmt::Display for TileShare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<String> = self.numbers.iter().map(u32::to_string).collect();
        write!(f, "{}/{}", numbers.join(","), self.of)
    }
}

impl FromStr for TileShare {
    type Err = Error;

    /// # Errors
    /// [`Error::Option`] naming `tiles` if the text has another form.
    fn from_str(text: &str) -> Result<Self> {
        let parsed = text.split_once('/').and_then(|(numbers, of)| {
            let numbers: Option<Vec<u32>> = numbers.split(',').map(|n| n.parse().ok()).collect();
            Self::checked(numbers?, of.parse().ok()?)
        });
        parsed.ok_or_else(|| Self::refused(text))
    }
}

/// Largest number of shares of which each consists of every `of`-th tile. These shares take about
/// the same time, as is best if each has its own machine. More shares are assumed to be handed out
/// one after the other. Each of those is a run of tiles, by columns, and so a small part of the
/// image.
const FEW: u32 = 16;

/// Number of gather points of a tile: enough for fans that fill a packet of rays, and few enough
/// that a tile is soon finished.
const POINTS_PER_TILE: u32 = 1024;

impl TileShare {
    /// Maximum number of shares.
    pub const MOST: u32 = 1 << 20;

    /// Returns share `number` of `of`.
    ///
    /// # Errors
    /// [`Error::Option`] naming `tiles` if there is no such share.
    pub fn new(number: u32, of: u32) -> Result<Self> {
        Self::of_numbers([number], of)
    }

    /// Returns the shares of these numbers, of `of`.
    ///
    /// # Errors
    /// [`Error::Option`] naming `tiles` if no number is given, or a share does not exist.
    pub fn of_numbers(numbers: impl IntoIterator<Item = u32>, of: u32) -> Result<Self> {
        let numbers: Vec<u32> = numbers.into_iter().collect();
        let told = Self { numbers: numbers.clone(), of };
        Self::checked(numbers, of).ok_or_else(|| Self::refused(&told.to_string()))
    }

    fn checked(mut numbers: Vec<u32>, of: u32) -> Option<Self> {
        numbers.sort_unstable();
        numbers.dedup();
        let fit = of <= Self::MOST && numbers.first()? > &0 && numbers.last()? <= &of;
        // All shares together are the whole, however many there are.
        let whole = numbers.len() as u64 == u64::from(of);
        fit.then(|| if whole { Self::default() } else { Self { numbers, of } })
    }

    fn refused(text: &str) -> Error {
        let expected = format!(
            "K/N with K from 1 to N, such as 1/4, or a list, such as 1,3/4; N at most {}",
            Self::MOST
        );
        Error::option("tiles", text, expected)
    }

    /// Returns the numbers of the shares, from 1, in rising order.
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// Returns the number of shares that the tiles are divided into.
    pub fn of(&self) -> u32 {
        self.of
    }

    /// Returns true if the shares are the whole image.
    pub fn is_whole(&self) -> bool {
        self.of == 1
    }

    /// Returns the share's tiles of a window, row by row.
    pub(super) fn tiles(&self, window: &Window, points_per_pixel: u32) -> Vec<Window> {
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
        let (count, of) = (tiles.len() as u64, u64::from(self.of));
        let is_run = self.of > FEW;
        if is_run {
            // Down one column and up the next, so that a run around a corner stays compact.
            let up = |tile: &Window| ((tile.x - window.x) / side) % 2 == 1;
            tiles.sort_unstable_by_key(|tile| (tile.x, if up(tile) { u32::MAX - tile.y } else { tile.y }));
        }
        let share = |i: u64| (if is_run { i * of / count } else { i % of }) as u32 + 1;
        let numbered = (0..).zip(tiles).filter(|(i, _)| self.numbers.binary_search(&share(*i)).is_ok());
        let mut mine: Vec<Window> = numbered.map(|(_, tile)| tile).collect();
        mine.sort_unstable_by_key(|tile| (tile.y, tile.x));
        mine
    }

    /// Returns the part of a window that the share's film covers. If shares are few, it is the
    /// whole window. If they are many, it is the smallest part with all of the share's tiles, or
    /// the first pixel if the share has no tile.
    pub(super) fn part(&self, window: &Window, points_per_pixel: u32) -> Window {
        if self.of <= FEW {
            return *window;
        }
        let tiles = self.tiles(window, points_per_pixel);
        tiles.into_iter().reduce(|a, b| a.union(&b)).unwrap_or(Window { width: 1, height: 1, ..*window })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_cover_the_window_once() {
        let window = Window { x: 3, y: 5, width: 71, height: 50 };
        for of in [1, 2, 3, 7, 16, 17, 20, 35, 5000] {
            let mut seen = vec![0; 71 * 50];
            for number in 1..=of {
                let share = TileShare::new(number, of).unwrap();
                let (tiles, part) = (share.tiles(&window, 4), share.part(&window, 4));
                assert!(tiles.is_sorted_by_key(|t| (t.y, t.x)) && tiles.iter().all(|t| part.covers(t)));
                assert!(window.covers(&part));
                for t in tiles {
                    t.pixels().for_each(|(x, y)| seen[window.index(x, y)] += 1);
                }
            }
            assert!(seen.iter().all(|n| *n == 1), "{of} shares");
        }
        let tiles = |share: &str| share.parse::<TileShare>().unwrap().tiles(&window, 4);
        let mut both = [tiles("2/5"), tiles("4/5")].concat();
        both.sort_by_key(|t| (t.y, t.x));
        assert_eq!(tiles("4,2,2/5"), both, "a list is its shares together");
        assert_eq!(tiles("3,1,2/3"), tiles("1/1"));
    }

    #[test]
    fn many_shares_are_small_and_even_parts_of_the_image() {
        let window = Window::full([1920, 1080]);
        for of in [17, 100, 1000, 5000] {
            let shares = (1..=of).map(|number| TileShare::new(number, of).unwrap());
            let (tiles, parts): (Vec<_>, Vec<_>) =
                shares.map(|s| (s.tiles(&window, 16).len(), s.part(&window, 16).area())).unzip();
            assert!(tiles.iter().max().unwrap() - tiles.iter().min().unwrap() <= 1, "{of} shares");
            // A run that turns from one column into the next has a part of at most twice the area
            // of its tiles.
            let all: u64 = parts.iter().sum();
            assert!(all < 2 * window.area(), "{of} shares have {all} pixels in their parts");
        }
        // Few shares are spread over the whole window.
        let few = TileShare::new(3, FEW).unwrap();
        assert_eq!(few.part(&window, 16), window);
    }

    #[test]
    fn shares_are_said_as_they_are_typed_and_others_are_refused() {
        for (typed, said) in [("1/1", "1/1"), ("3/7", "3/7"), ("4,2,2/5", "2,4/5"), ("1,2,3/3", "1/1")] {
            assert_eq!(typed.parse::<TileShare>().unwrap().to_string(), said);
        }
        for typed in ["0/1", "2/1", "1/0", "1", "/3", "1,/3", "1/x", "-1/3", "1,4/3", "1/4294967295", "1/2/3"]
        {
            let said = typed.parse::<TileShare>().unwrap_err().to_string();
            assert!(said.starts_with(&format!("tiles = {typed}; expected K/N")), "{said}");
        }
        assert!(TileShare::new(0, 3).is_err() && TileShare::of_numbers([], 3).is_err());
    }
}
