//! Observers, which receive the progress of a render and may cancel it.

use std::sync::atomic::AtomicBool;

use crate::film::Window;
use crate::render::{Finished, Progress};

/// A phase of the work.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Phase {
    /// Tracing VPLs from the emitters.
    Vpls {
        /// Approximate number of VPLs.
        count: u64,
    },
    /// Building the tree over given or traced VPLs.
    LightTree,
    /// Rendering the pixels of the window.
    Pixels {
        /// Name of the method that renders.
        method: &'static str,
        /// Part of the image.
        window: Window,
        /// True if pixels are sums over one set of VPLs.
        is_of_a_sum: bool,
        /// True if pixels may claim something.
        promises: bool,
    },
    /// Reconstructing a picture from the estimates.
    Reconstruction,
    /// Adding mattes to a rendered film.
    Mattes,
    /// Adding planes of first surfaces to a rendered film: motion vectors, times and
    /// transmittances.
    FirstSurfaces,
    /// Computing the truth of random pixels.
    Audit {
        /// Name of the method that computes truths.
        by: &'static str,
        /// Number of pixels that are audited.
        pixels: u64,
    },
    /// Rendering random pixels with another set of VPLs.
    OtherSet,
}

/// Receives the progress of the work. Calls may come from any thread. Only [`cancel`](Self::cancel)
/// is called by several threads at the same time.
///
/// The library reads no clock: to measure the duration of a phase, observers read a clock at its
/// beginning and end.
pub trait Observer: Sync {
    /// Called when a phase begins. Phases do not nest.
    fn begin(&self, _phase: &Phase) {}

    /// Called when a phase has ended, whether it succeeded or failed.
    fn end(&self, _phase: &Phase) {}

    /// Called when a tile is finished. Until this call returns, other threads cannot deliver their
    /// tiles.
    fn tile(&self, done: &Finished<'_>) {
        self.progress(&done.progress);
    }

    /// Called with the progress of the phase.
    fn progress(&self, _progress: &Progress) {}

    /// Seconds left for the work, if there is a time limit. Audited pictures read this between
    /// parts of the work; without a time limit, the number of their paths is limited instead.
    fn seconds_left(&self) -> Option<f64> {
        None
    }

    /// Flag that becomes true when the work is to end. No work is begun after that, and the
    /// finished part is returned.
    fn cancel(&self) -> &AtomicBool {
        static NEVER: AtomicBool = AtomicBool::new(false);
        &NEVER
    }
}

/// Observer that ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// Does `work`, and reports its beginning and end.
pub(super) fn during<T>(observer: &dyn Observer, phase: Phase, work: impl FnOnce() -> T) -> T {
    observer.begin(&phase);
    let result = work();
    observer.end(&phase);
    result
}
