//! Finished tiles of a render that are kept in a file, and what was wrong with that.

use std::mem;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use tashika::error::Result;
use tashika::film::Film;
use tashika::io::Checkpoint;
use tashika::render::{Begun, Finished};

/// Takes finished tiles, if there is a file for them.
pub struct Kept {
    path: Option<PathBuf>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    checkpoint: Option<Checkpoint>,
    troubles: Vec<String>,
}

impl Kept {
    /// Keeps them there; without a path nothing is kept.
    pub fn new(path: Option<PathBuf>) -> Self {
        Self { path, state: Mutex::default() }
    }

    /// Opens the file; what the render that begins with this film goes on from.
    pub fn begin(&self, film: Film) -> Result<Begun> {
        let Some(path) = &self.path else { return Ok(Begun { film, tiles: Vec::new() }) };
        let (checkpoint, resumed) = Checkpoint::open(path, &film)?;
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let damage =
            resumed.damage.map(|damage| format!("{}: {damage}; it was rendered again", path.display()));
        state.troubles.extend(damage);
        state.checkpoint = Some(checkpoint);
        Ok(Begun { film: resumed.film, tiles: resumed.tiles })
    }

    /// Keeps a tile; after a file that takes no more the render goes on without.
    pub fn add(&self, done: &Finished<'_>) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Err(trouble)) = state.checkpoint.as_mut().map(|c| c.add(done.film, done.tile)) {
            state.troubles.push(format!("not all tiles were kept: {trouble}"));
            state.checkpoint = None;
        }
    }

    /// What was wrong, in words.
    pub fn troubles(&self) -> Vec<String> {
        mem::take(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner).troubles)
    }
}
