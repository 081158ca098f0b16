//! Cells of an image, each with learned data.
//!
//! The data of a cell are learned once, from separate random numbers, when a pixel near by first
//! uses them. A cell has 16 × 16 pixels: small enough that lights and surfaces hardly differ within
//! it, and large enough that each pixel bears only 1/256 of the cost.

use std::sync::OnceLock;

use crate::film::Window;
use crate::rng::{self, Purpose};

/// Cells of an image, row by row, each with the data learned for it.
///
/// # Guarantee
/// If `learn` is a function of the image and of the cell's place, so are the data of the cell. They
/// do not depend on the order or the number of queries.
#[derive(Debug)]
pub struct Grid<T> {
    cells: Vec<OnceLock<T>>,
    size: [u32; 2],
}

impl<T> Grid<T> {
    /// Side of a cell (pixels).
    pub const SIDE: u32 = 16;

    /// Makes the cells of an image of the given size (pixels), without any data.
    pub fn new(size: [u32; 2]) -> Self {
        let cells = columns_and_rows(size).map(|n| n as usize).iter().product();
        Self { cells: std::iter::repeat_with(OnceLock::new).take(cells).collect(), size }
    }

    /// Returns the data of a cell, which `learn` makes at the first query.
    ///
    /// # Panics
    /// If the image has no such cell.
    pub fn at(&self, [column, row]: [u32; 2], learn: impl FnOnce() -> T) -> &T {
        let [columns, _] = columns_and_rows(self.size);
        assert!(column < columns, "column {column} of {columns}");
        self.cells[row as usize * columns as usize + column as usize].get_or_init(learn)
    }

    /// Returns a cell and its neighbours within the image, row by row.
    pub fn about(&self, [column, row]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> + use<T> {
        let [columns, rows] = columns_and_rows(self.size);
        let near = |at: u32, end: u32| at.saturating_sub(1)..(at + 2).min(end);
        near(row, rows).flat_map(move |row| near(column, columns).map(move |column| [column, row]))
    }
}

/// Returns the cell that contains a pixel, as column and row.
pub fn cell_of(pixel: [u32; 2]) -> [u32; 2] {
    pixel.map(|at| at / Grid::<()>::SIDE)
}

/// Returns the pixels of a cell, of an image of the given size (pixels).
pub fn pixels_of(cell: [u32; 2], size: [u32; 2]) -> Window {
    let [x, y] = cell.map(|at| at * Grid::<()>::SIDE);
    let side = |first: u32, end: u32| end.min(first + Grid::<()>::SIDE) - first;
    Window { x, y, width: side(x, size[0]), height: side(y, size[1]) }
}

/// Returns the key of random numbers that only guide the pixels of a cell.
pub fn key_of([column, row]: [u32; 2], seed: u64) -> u64 {
    rng::key(seed, Purpose::Guidance, u64::from(row) << 32 | u64::from(column))
}

fn columns_and_rows(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.div_ceil(Grid::<()>::SIDE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_learned_once_and_cover_the_image() {
        let size = [40, 17];
        let grid = Grid::new(size);
        let mut area = 0;
        for row in 0..2 {
            for column in 0..3 {
                let window = pixels_of([column, row], size);
                area += window.area();
                assert!(window.pixels().all(|(x, y)| cell_of([x, y]) == [column, row]));
                assert_eq!(*grid.at([column, row], || [column, row]), [column, row]);
                assert_eq!(*grid.at([column, row], || unreachable!("it is known")), [column, row]);
            }
        }
        assert_eq!(area, 40 * 17);
        let about = |cell| grid.about(cell).collect::<Vec<_>>();
        assert_eq!(about([0, 0]), [[0, 0], [1, 0], [0, 1], [1, 1]]);
        assert_eq!(about([2, 1]), [[1, 0], [2, 0], [1, 1], [2, 1]]);
        assert_eq!(about([1, 0]).len(), 6);
    }

    #[test]
    #[should_panic(expected = "column 3 of 3")]
    fn cells_beyond_the_image_are_no_others() {
        Grid::new([40, 17]).at([3, 0], || ());
    }
}
