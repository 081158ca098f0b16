//! Who is told of the work, and may end it.

use std::sync::atomic::AtomicBool;

use crate::film::Window;
use crate::render::{Finished, Progress};

/// A part of the work.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Phase {
    /// Tracing VPLs.
    Vpls {
        /// About how many.
        count: u64,
    },
    /// Building the tree over given or traced VPLs.
    LightTree,
    /// Rendering.
    Pixels {
        /// Name of the method.
        method: &'static str,
        /// The part of the image.
        window: Window,
        /// Whether it is a sum over one set of VPLs.
        is_of_a_sum: bool,
        /// Whether pixels may claim something.
        promises: bool,
    },
    /// Making a picture of the estimates.
    Reconstruction,
    /// Adding mattes to a film that is rendered.
    Mattes,
    /// Adding planes of what camera rays meet first to a film that is rendered: motion vectors, times and
    /// what media leave of light.
    FirstSurfaces,
    /// Computing the truth of pixels at random.
    Audit {
        /// Name of what computes it.
        by: &'static str,
        /// How many.
        pixels: u64,
    },
    /// Rendering pixels at random with another set of VPLs.
    OtherSet,
}

/// Is told of the work, from any thread, one call at a time but for [`cancel`](Self::cancel).
///
/// The library reads no clock: who wants to know how long a phase took looks at one at its begin
/// and at its end.
pub trait Observer: Sync {
    /// A phase begins. Phases do not nest.
    fn begin(&self, _phase: &Phase) {}

    /// A phase has ended, by an error too.
    fn end(&self, _phase: &Phase) {}

    /// A tile was finished. Other threads wait with theirs meanwhile.
    fn tile(&self, done: &Finished<'_>) {
        self.progress(&done.progress);
    }

    /// So far is the phase.
    fn progress(&self, _progress: &Progress) {}

    /// Seconds that are left for the work, if there is an end; read between parts of the work of
    /// pictures that are audited. Without one, they have so many paths at most.
    fn seconds_left(&self) -> Option<f64> {
        None
    }

    /// Becomes true when the work is to end: nothing more is begun, and what is finished is
    /// returned.
    fn cancel(&self) -> &AtomicBool {
        static NEVER: AtomicBool = AtomicBool::new(false);
        &NEVER
    }
}

/// Nobody is told.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// Does `work`, and tells when it begins and ends.
pub(super) fn during<T>(observer: &dyn Observer, phase: Phase, work: impl FnOnce() -> T) -> T {
    observer.begin(&phase);
    let result = work();
    observer.end(&phase);
    result
}
