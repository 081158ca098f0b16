//! Optional checkpoint, in which a render stores its finished tiles while it runs.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::Checkpoint;
use crate::error::Result;
use crate::film::Film;
use crate::render::{Begun, Finished};

/// An optional checkpoint. Without a path, or after a failed write, the render continues and no
/// further tiles are stored.
#[derive(Debug, Default)]
pub struct KeptTiles {
    path: Option<PathBuf>,
    checkpoint: Mutex<Option<Checkpoint>>,
}

impl KeptTiles {
    /// Stores tiles in the file at `path`, or nowhere without one.
    pub fn new(path: Option<PathBuf>) -> Self {
        Self { path, checkpoint: Mutex::default() }
    }

    /// Path of the checkpoint's file, if any.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// Opens the checkpoint of the render that begins with this film. Returns the finished tiles
    /// with which the render continues. If the rest of the file is damaged, also returns a
    /// description of the damage.
    ///
    /// # Errors
    /// As [`Checkpoint::open`].
    pub fn begin(&self, film: Film) -> Result<(Begun, Option<String>)> {
        let Some(path) = &self.path else { return Ok((Begun { film, tiles: Vec::new() }, None)) };
        let (checkpoint, resumed) = Checkpoint::open(path, &film)?;
        *self.checkpoint.lock().unwrap_or_else(PoisonError::into_inner) = Some(checkpoint);
        Ok((Begun { film: resumed.film, tiles: resumed.tiles }, resumed.damage))
    }

    /// Stores a finished tile.
    ///
    /// # Errors
    /// As [`Checkpoint::add`]. After the first error, no further tiles are stored and no error is
    /// returned; tiles that are already in the file stay there.
    pub fn add(&self, done: &Finished<'_>) -> Result<()> {
        let mut checkpoint = self.checkpoint.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(Err(trouble)) = checkpoint.as_mut().map(|c| c.add(done.film, done.tile)) else {
            return Ok(());
        };
        *checkpoint = None;
        Err(trouble)
    }

    /// Returns true if tiles are being stored.
    pub fn is_open(&self) -> bool {
        self.checkpoint.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Removes the checkpoint, once the render is complete and its image is written.
    ///
    /// # Errors
    /// As [`Checkpoint::remove`].
    pub fn remove(self) -> Result<()> {
        let checkpoint = self.checkpoint.into_inner().unwrap_or_else(PoisonError::into_inner);
        checkpoint.map_or(Ok(()), Checkpoint::remove)
    }
}
