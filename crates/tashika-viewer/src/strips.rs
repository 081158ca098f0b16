//! Rows of a file in strips, with a cache of the most recently used strips.
//!
//! # Guarantee
//! The cache takes no more than the given number of bytes, unless a single strip does. If several
//! threads request a strip at the same time, one reads it. A failed read is tried again next time.
//!
//! # Held to this by
//! The tests below.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use crate::rows::Rows;
use tashika::error::Result;
use tashika::film::{Film, Metadata, Window};

/// A strip that was read, or is being read.
type Slot = Arc<OnceLock<std::result::Result<Arc<Film>, String>>>;

/// A file, read in strips of whole rows.
pub(crate) struct Strips {
    file: Rows,
    /// Number of rows of a strip.
    rows: u32,
    /// Size of the cache (bytes).
    most: u64,
    /// Numbers and strips, the most recently used one last.
    kept: Mutex<Vec<(u32, Slot)>>,
}

impl Strips {
    /// Divides a file into strips. The number of rows of a strip is a multiple of `multiple`. It is
    /// at least 16, and at least the number of rows that are decompressed at once.
    pub(crate) fn new(file: Rows, multiple: u32, most: u64) -> Self {
        let rows = file.rows_per_block().clamp(16, file.window().height.max(16));
        let rows = rows.next_multiple_of(multiple);
        Self { file, rows, most, kept: Mutex::default() }
    }

    /// Metadata of the film in the file.
    pub(crate) fn metadata(&self) -> &Metadata {
        self.file.metadata()
    }

    /// Number of strips of the file.
    pub(crate) fn count(&self) -> u32 {
        self.file.window().height.div_ceil(self.rows)
    }

    /// Pixels of a strip, as a window of the full image.
    pub(crate) fn window(&self, strip: u32) -> Window {
        let window = self.file.window();
        let from_top = strip * self.rows;
        Window { y: window.y + from_top, height: self.rows.min(window.height - from_top), ..window }
    }

    /// Number of the strip that has a row of the full image.
    pub(crate) fn of_row(&self, y: u32) -> u32 {
        (y - self.file.window().y) / self.rows
    }

    /// Returns true if all strips fit in the cache.
    pub(crate) fn fit(&self) -> bool {
        self.bytes(self.file.window()) <= self.most
    }

    fn bytes(&self, window: Window) -> u64 {
        4 * window.area() * self.file.channels() as u64
    }

    fn kept(&self) -> MutexGuard<'_, Vec<(u32, Slot)>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads a strip, without the cache.
    pub(crate) fn read(&self, strip: u32) -> Result<Film> {
        let Window { y, height, .. } = self.window(strip);
        self.file.read(y..y + height)
    }

    /// Returns a strip through the cache, or the message about an unreadable file.
    pub(crate) fn get(&self, strip: u32) -> std::result::Result<Arc<Film>, String> {
        let slot = self.slot(strip);
        let film = slot.get_or_init(|| self.read(strip).map(Arc::new).map_err(|e| e.to_string()));
        if film.is_err() {
            self.kept().retain(|(_, kept)| !Arc::ptr_eq(kept, &slot));
        }
        film.clone()
    }

    /// Returns the slot of a strip, marks it as the most recently used one, and evicts others.
    fn slot(&self, strip: u32) -> Slot {
        let mut kept = self.kept();
        let found = kept.iter().position(|(number, _)| *number == strip);
        let slot = found.map_or_else(Slot::default, |i| kept.remove(i).1);
        kept.push((strip, slot.clone()));
        let mut bytes: u64 = kept.iter().map(|(number, _)| self.bytes(self.window(*number))).sum();
        while bytes > self.most && kept.len() > 1 {
            bytes -= self.bytes(self.window(kept.remove(0).0));
        }
        slot
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stored::tests::{film, written};

    #[test]
    fn strips_cover_the_film_and_the_last_used_are_kept_within_the_bound() {
        let film = film(Window { x: 3, y: 5, width: 40, height: 100 });
        let (_folder, path) = written(&film);
        let strip = 4 * 40 * 32 * film.planes().iter().map(|p| p.channels().len() as u64).sum::<u64>();
        let strips = Strips::new(Rows::open(&path, None).unwrap(), 32, 2 * strip + strip / 8);
        assert_eq!((strips.count(), strips.fit()), (4, false));
        let mut next = 5;
        for i in 0..4 {
            let part = strips.get(i).unwrap();
            assert_eq!((part.window(), part.window().y), (strips.window(i), next));
            assert_eq!((strips.of_row(next), strips.of_row(next + part.window().height - 1)), (i, i));
            next += part.window().height;
            assert_eq!(
                part.plane("").unwrap().f32_at(40, next - 1),
                film.plane("").unwrap().f32_at(40, next - 1)
            );
        }
        assert_eq!(next, 105);
        let numbers = |strips: &Strips| strips.kept().iter().map(|k| k.0).collect::<Vec<_>>();
        assert_eq!(numbers(&strips), [1, 2, 3], "two of 32 rows and one of 4");
        let second = strips.get(1).unwrap();
        assert!(Arc::ptr_eq(&second, &strips.get(1).unwrap()), "read once");
        strips.get(0).unwrap();
        assert_eq!(numbers(&strips), [3, 1, 0], "those used long ago go first");
    }

    #[test]
    fn a_bound_below_one_strip_keeps_one_and_damage_none() {
        let film = film(Window { x: 0, y: 0, width: 40, height: 100 });
        let (_folder, path) = written(&film);
        let strips = Strips::new(Rows::open(&path, None).unwrap(), 1, 1);
        strips.get(0).unwrap();
        strips.get(5).unwrap();
        assert_eq!(strips.kept().len(), 1);
        std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(1000).unwrap();
        let said = strips.get(3).unwrap_err();
        assert!(said.contains("film.exr"), "{said}");
        assert!(strips.kept().is_empty());
    }
}
