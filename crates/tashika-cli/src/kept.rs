//! Finished tiles of a render that are kept until the image is written.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use tashika::film::{Film, Window};
use tashika::io::Checkpoint;
use tashika::render::{Begun, Finished};

use crate::exit::Failure;
use crate::progress::Meter;
use crate::summary::counted;

/// Takes finished tiles, if they are to be kept.
pub struct Kept(Mutex<Option<Checkpoint>>);

impl Kept {
    /// Opens the checkpoint of the render that begins with this film, and says what it has; without
    /// a path nothing is kept.
    pub fn open(path: Option<&Path>, film: Film, meter: &Meter) -> Result<(Self, Begun), Failure> {
        let Some(path) = path else {
            return Ok((Self(Mutex::new(None)), Begun { film, tiles: Vec::new() }));
        };
        let (checkpoint, resumed) = Checkpoint::open(path, &film)?;
        if let Some(damage) = resumed.damage {
            meter.note(&format!("{}: {damage}; what was lost is rendered again", path.display()));
        }
        if !resumed.tiles.is_empty() {
            let pixels = counted(resumed.tiles.iter().map(Window::area).sum(), "pixel", "pixels");
            meter.note(&format!("going on from {}: {pixels} are finished", path.display()));
        }
        Ok((Self(Mutex::new(Some(checkpoint))), Begun { film: resumed.film, tiles: resumed.tiles }))
    }

    /// Keeps a tile; a file that takes no more is told about, once, and the render goes on without.
    pub fn add(&self, done: &Finished<'_>, meter: &Meter) {
        let mut checkpoint = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Err(trouble)) = checkpoint.as_mut().map(|c| c.add(done.film, done.tile)) {
            meter.note(&format!("no more tiles are kept, those before are safe: {trouble}"));
            *checkpoint = None;
        }
    }

    /// Removes the checkpoint of a render that is complete and written; says what to do with that
    /// of another.
    pub fn end(self, complete: bool, meter: &Meter) -> Result<(), Failure> {
        let checkpoint = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        match checkpoint {
            Some(checkpoint) if complete => Ok(checkpoint.remove()?),
            Some(_) => {
                meter.note("the finished tiles are kept; the same command goes on from them");
                Ok(())
            }
            None => Ok(()),
        }
    }
}
