//! Work on tiles by several threads. Each result is stored in one film, and the observer is
//! notified.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::{Begun, Finished, Progress, Rendered, Totals, add_finite, mean};
use crate::color::RgbSum;
use crate::film::{Film, RenderFilm, Window, keys};

/// State that the threads write to.
struct Shared {
    film: Film,
    progress: Progress,
    totals: Totals,
}

impl Shared {
    /// Counts a finished tile from the values in the film, so that totals are equal whether tiles
    /// are rendered or read. Returns the sum of the tile's radiance.
    fn count(&mut self, tile: &Window) -> RgbSum {
        let mut sum = RgbSum::default();
        let film = RenderFilm::of(&self.film);
        for (x, y) in tile.pixels() {
            let record = film.at(x, y);
            add_finite(&mut sum, &record);
            self.totals.tally.count(record.claim, record.stop);
            self.totals.pairs += record.pairs;
            self.totals.rays += record.rays;
        }
        self.progress.tally = self.totals.tally;
        self.progress.rays = self.totals.rays;
        sum
    }
}

/// Fills the tiles that are not finished, after calls of `watch` for the finished ones.
///
/// * `work`: returns the result of a tile; `None` if it was cancelled. `store` puts the result into
///   the film.
pub(super) fn fill<T>(
    begun: Begun,
    tiles: &[Window],
    work: &(dyn Fn(&Window) -> Option<T> + Sync),
    store: &(dyn Fn(&mut Film, &Window, &T) + Sync),
    watch: &(dyn Fn(&Finished<'_>) + Sync),
    cancel: &AtomicBool,
) -> Rendered {
    let of = tiles.iter().map(Window::area).sum();
    let mut shared = Shared {
        film: begun.film,
        progress: Progress { of, ..Progress::default() },
        totals: Totals::default(),
    };
    let place = |tile: &Window| (tile.y, tile.x, tile.height, tile.width);
    let known: BTreeSet<_> = begun.tiles.iter().map(place).collect();
    let finished: Vec<Option<RgbSum>> = tiles
        .iter()
        .map(|tile| {
            let sum = known.contains(&place(tile)).then(|| shared.count(tile))?;
            watch(&Finished { progress: shared.progress, film: &shared.film, tile: *tile });
            Some(sum)
        })
        .collect();
    let shared = Mutex::new(shared);
    let sums: Vec<Option<RgbSum>> = tiles
        .par_iter()
        .zip(finished)
        .map(|(tile, finished)| {
            if finished.is_some() || cancel.load(Ordering::Relaxed) {
                return finished;
            }
            let found = work(tile)?;
            let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
            store(&mut shared.film, tile, &found);
            let sum = shared.count(tile);
            watch(&Finished { progress: shared.progress, film: &shared.film, tile: *tile });
            Some(sum)
        })
        .collect();
    let Shared { mut film, mut totals, .. } = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut sum = RgbSum::default();
    // Sums are added in the order of the tiles, so that the total does not depend on the speed of
    // threads.
    for s in sums.iter().flatten() {
        sum.merge(s);
    }
    totals.mean = mean(&sum, &totals.tally);
    let complete = sums.iter().all(Option::is_some);
    film.metadata_mut().set(keys::COMPLETE, complete);
    Rendered { film, complete, totals }
}
