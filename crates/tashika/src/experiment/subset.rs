//! Choice of the pixels of an experiment.
//!
//! Draws `n` of the `N` pixels of a window; every subset of `n` pixels is equally probable. Pixels
//! are visited row by row. Each is taken with the probability `(pixels still to take)/(pixels still
//! to visit)` (selection sampling):
//!
//! ```text
//! P(pixel t is taken) = (n − taken)/(N − t)        t = 0, 1, …, N − 1
//! ```
//!
//! # Guarantee
//! Exactly `n` different pixels, in row order. They are a function of count, window and seed.
//!
//! # Held to this by
//! `experiment::tests`.

use std::sync::atomic::AtomicBool;

use crate::error::{Error, Result};
use crate::film::Window;
use crate::integrator::{Integrator, Setting};
use crate::render::{Progress, RenderOptions, Rendered, TileShare, render, render_pixels};
use crate::rng::{Purpose, Stream};

/// Key that separates this choice from others with the same seed.
const STREAM: u64 = 1;

/// Draws `count` different pixels of the window, row by row, in coordinates of the full image.
///
/// # Errors
/// [`Error::Option`] naming `pixels` if there are not that many, or `count` is zero.
pub fn subset(count: u64, window: &Window, seed: u64) -> Result<Vec<[u32; 2]>> {
    let of = window.area();
    if count == 0 || count > of {
        return Err(Error::option("pixels", count, format!("1 to {of}, the pixels of the image")));
    }
    let mut stream = Stream::new(seed, Purpose::Subset, STREAM);
    let mut chosen = Vec::with_capacity(count as usize);
    for ((x, y), seen) in window.pixels().zip(0..) {
        let wanted = count - chosen.len() as u64;
        if wanted == 0 {
            break;
        }
        if stream.below(of - seen) < wanted {
            chosen.push([x, y]);
        }
    }
    Ok(chosen)
}

/// The pixels of an experiment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pixels {
    /// Every pixel of a window.
    All(Window),
    /// Some pixels, each once.
    Chosen(Vec<[u32; 2]>),
}

impl Pixels {
    /// Returns `count` random pixels of the window, or all of them.
    ///
    /// # Errors
    /// As [`subset()`].
    pub fn of(window: Window, count: Option<u64>, seed: u64) -> Result<Self> {
        Ok(match count {
            None => Self::All(window),
            Some(count) => Self::Chosen(subset(count, &window, seed)?),
        })
    }

    /// Number of pixels to render.
    pub fn count(&self) -> u64 {
        match self {
            Self::All(window) => window.area(),
            Self::Chosen(pixels) => pixels.len() as u64,
        }
    }

    /// Renders the pixels; `progress` and `cancel` as in [`render`].
    ///
    /// # Errors
    /// As [`render`] and [`render_pixels`].
    pub fn render(
        &self,
        setting: &Setting<'_>,
        integrator: &dyn Integrator,
        progress: &(dyn Fn(&Progress) + Sync),
        cancel: &AtomicBool,
    ) -> Result<Rendered> {
        match self {
            Self::All(window) => {
                let options = RenderOptions { window: *window, share: TileShare::default() };
                render(setting, integrator, &options, &|done| progress(&done.progress), cancel)
            }
            Self::Chosen(pixels) => render_pixels(setting, integrator, pixels, progress, cancel),
        }
    }
}
