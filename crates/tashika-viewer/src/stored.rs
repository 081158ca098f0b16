//! A film in a file, of any size, never loaded whole.
//!
//! A thread makes an overview from strips of rows, in an order that soon covers the image evenly.
//! So an image appears at once and sharpens. Levels finer than the overview are read on request.
//!
//! # Guarantee
//! Memory: the overview, of at most 2²¹ samples a channel, a cache of strips of at most
//! [`KEPT_BYTES`], and the strips in use. Rows of the overview that were not read yet repeat the
//! last row above them that was read.
//!
//! # Held to this by
//! The tests below.

use std::path::Path;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, Weak};
use std::thread;

use tashika::error::{Error, Result};
use tashika::film::{Metadata, Window};

use crate::overview::{Overview, factor};
use crate::rows::Rows;
use crate::shown::{Collected, Description, Refusal, Shown, Status, Tile, TileAddress, Values, values};
use crate::strips::Strips;

/// Size of the cache of strips (bytes).
const KEPT_BYTES: u64 = 1 << 29;

/// A film in an OpenEXR file.
pub struct StoredFilm {
    inner: Arc<Inner>,
}

struct Inner {
    description: Description,
    strips: Strips,
    state: RwLock<State>,
}

struct State {
    overview: Overview,
    /// True for strips that are in the overview.
    done: Vec<bool>,
    finished: bool,
    failure: Option<String>,
    version: u64,
}

impl StoredFilm {
    /// Opens a file and starts to read it. The main plane of `reference` becomes the plane
    /// `reference`.
    ///
    /// # Errors
    /// As [`ExrFile::open`](tashika::io::ExrFile::open); if a reference shows another part of an
    /// image or has no colours; if the first rows cannot be read; or if no thread can be started.
    pub fn open(path: &Path, reference: Option<&Path>) -> Result<Self> {
        let file = Rows::open(path, reference)?;
        let thinned = factor(file.window());
        let stored = Self::new(file, thinned, KEPT_BYTES)?;
        let inner = Arc::downgrade(&stored.inner);
        let build = thread::Builder::new().name("overview".to_owned()).spawn(move || build(&inner));
        build.map_err(|e| Error::io(path, e))?;
        Ok(stored)
    }

    /// Metadata of the film in the file.
    pub fn metadata(&self) -> &Metadata {
        self.inner.strips.metadata()
    }

    fn new(file: Rows, factor: u32, kept_bytes: u64) -> Result<Self> {
        let window = file.window();
        let first_row = file.read(window.y..window.y + 1)?;
        let description = Description::of(&first_row, window);
        let overview = Overview::thinned(&first_row, window, factor);
        let strips = Strips::new(file, factor, kept_bytes);
        let done = vec![false; strips.count() as usize];
        let state = State { overview, done, finished: false, failure: None, version: 1 };
        Ok(Self { inner: Arc::new(Inner { description, strips, state: RwLock::new(state) }) })
    }
}

/// Makes the overview, as long as the film is in use.
fn build(film: &Weak<Inner>) {
    let Some(count) = film.upgrade().map(|film| film.strips.count()) else { return };
    for strip in bit_reversed(count) {
        let Some(film) = film.upgrade() else { return };
        film.see(strip);
    }
    if let Some(film) = film.upgrade() {
        film.state.write().unwrap_or_else(PoisonError::into_inner).finished = true;
    }
}

/// The numbers below `count` in an order whose initial parts are spread evenly: bit-reversed.
fn bit_reversed(count: u32) -> impl Iterator<Item = u32> {
    let bits = count.next_power_of_two().trailing_zeros();
    let reversed = move |i: u64| ((i as u32).reverse_bits().checked_shr(32 - bits)).unwrap_or(0);
    (0..1_u64 << bits).map(reversed).filter(move |&i| i < count)
}

impl Inner {
    fn read(&self) -> RwLockReadGuard<'_, State> {
        self.state.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads a strip into the overview.
    fn see(&self, strip: u32) {
        // If all strips fit in the cache, each is read once. If not, building the overview through
        // the cache would evict strips that are in view.
        let film = if self.strips.fit() && self.read().overview.factor() > 1 {
            self.strips.get(strip)
        } else {
            self.strips.read(strip).map(Arc::new).map_err(|e| e.to_string())
        };
        let mut state = self.state.write().unwrap_or_else(PoisonError::into_inner);
        match film {
            Ok(film) => {
                let State { overview, done, .. } = &mut *state;
                overview.renew(&film, film.window());
                // The strips below this one, up to the next one that was read, repeat its last row.
                let unknown = done[strip as usize + 1..].iter().take_while(|known| !**known).count() as u32;
                if unknown > 0 {
                    let (first, last) = (self.strips.window(strip + 1), self.strips.window(strip + unknown));
                    overview.stand_in(Window { height: last.y + last.height - first.y, ..first });
                }
            }
            Err(said) => {
                state.failure.get_or_insert(said);
            }
        }
        state.done[strip as usize] = true;
        state.version += 1;
    }
}

impl Shown for StoredFilm {
    fn description(&self) -> Option<Description> {
        Some(self.inner.description.clone())
    }

    fn version(&self) -> u64 {
        self.inner.read().version
    }

    fn status(&self) -> Status {
        let state = self.inner.read();
        let ready = state.done.iter().filter(|d| **d).count() as f32 / state.done.len() as f32;
        let failure = state.failure.clone();
        Status { live: false, finished: state.finished, ready, headline: None, failure }
    }

    fn tile(&self, at: TileAddress, planes: &[&str]) -> Result<Tile, Refusal> {
        let Inner { description, strips, .. } = &*self.inner;
        let (part, planes) = (description.part(at)?, description.places(planes)?);
        let step = 1 << at.level;
        let version = {
            let state = self.inner.read();
            if state.overview.factor() <= step {
                return Ok(state.overview.tile(state.version, &planes, part, step));
            }
            state.version
        };
        let mut bytes = Collected::new(&planes);
        let end = part.y + part.height;
        for number in strips.of_row(part.y)..=strips.of_row(end - 1) {
            let strip = strips.window(number);
            let top = part.y.max(strip.y);
            let rows = Window { y: top, height: end.min(strip.y + strip.height) - top, ..part };
            bytes.add(&*strips.get(number).map_err(Refusal::Unreadable)?, rows, step);
        }
        Ok(Tile { version, bytes: bytes.into_bytes() })
    }

    fn pixel(&self, x: u32, y: u32) -> Result<Vec<Values>, Refusal> {
        let Inner { description, strips, .. } = &*self.inner;
        description.check_pixel(x, y)?;
        let strip = strips.get(strips.of_row(y)).map_err(Refusal::Unreadable)?;
        Ok(values(&strip, x, y))
    }
}

#[cfg(test)]
pub(crate) mod tests;
