//! Observer of a render, which passes progress to the meter, measures the seconds of each part,
//! keeps finished tiles, and shows them in viewers.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tashika::film::{Film, Window, keys, percent_of_error};
use tashika::io::KeptTiles;
use tashika::render::{Begun, Finished, Progress};
use tashika::renderer::{Observer, Phase};

use crate::exit::Failure;
use crate::interrupt;
use crate::progress::Meter;
use crate::serve::LivePage;
use crate::summary::{Seconds, counted};
use crate::tev::Viewer;

/// Observer of one render.
pub struct Watcher<'a> {
    meter: &'a Meter,
    clock: Mutex<Clock>,
    kept: KeptTiles,
    viewer: Option<Viewer>,
    page: Option<LivePage>,
    /// Time at which the work is to end, if there is a limit.
    end: Option<Instant>,
}

struct Clock {
    begun: Instant,
    seconds: Seconds,
    /// True if [`interrupt::heed`] was on before the phase.
    heeded: bool,
}

impl<'a> Watcher<'a> {
    /// Makes a watcher that reports to the meter alone.
    pub fn new(meter: &'a Meter, seconds: Seconds) -> Self {
        let clock = Mutex::new(Clock { begun: Instant::now(), seconds, heeded: false });
        Self { meter, clock, kept: KeptTiles::default(), viewer: None, page: None, end: None }
    }

    /// Adds a file for finished tiles, and viewers that show them.
    pub fn with(self, kept: KeptTiles, viewer: Option<Viewer>, page: Option<LivePage>) -> Self {
        Self { kept, viewer, page, ..self }
    }

    /// Limits the work to about `time` from now on; `None` is no limit.
    pub fn ending_in(self, time: Option<Duration>) -> Self {
        Self { end: time.map(|time| Instant::now() + time), ..self }
    }

    /// Returns the state from which the render that begins with this film resumes.
    pub fn begin_film(&self, film: Film) -> tashika::error::Result<Begun> {
        let (begun, damage) = self.kept.begin(film)?;
        let path = || self.kept.path().map_or_else(String::new, |path| path.display().to_string());
        if let Some(damage) = damage {
            self.meter.note(&format!("{}: {damage}; what was lost is rendered again", path()));
        }
        if !begun.tiles.is_empty() {
            let pixels = counted(begun.tiles.iter().map(Window::area).sum(), "pixel", "pixels");
            self.meter.note(&format!("going on from {}: {pixels} are finished", path()));
        }
        Ok(begun)
    }

    /// Returns the file that has the finished tiles, if there is one.
    pub fn checkpoint(&self) -> Option<&Path> {
        self.kept.path().filter(|_| self.kept.is_open())
    }

    /// Returns the seconds of each part so far.
    pub fn seconds(&self) -> Seconds {
        self.clock().seconds.clone()
    }

    /// Runs `work` and adds its seconds to a part.
    pub fn timed<T>(&self, of: fn(&mut Seconds) -> &mut f64, work: impl FnOnce() -> T) -> T {
        let begun = Instant::now();
        let result = work();
        *of(&mut self.clock().seconds) += begun.elapsed().as_secs_f64();
        result
    }

    /// Closes the connection to tev, and reports its error if there is one.
    pub fn close_viewer(&mut self) {
        if let Some(trouble) = self.viewer.take().and_then(Viewer::finish) {
            self.meter.note(&trouble);
        }
    }

    /// Ends a render whose files are written: removes the finished tiles of a complete render,
    /// reports those of an incomplete one, and returns the page.
    pub fn end(self, complete: bool) -> Result<Option<LivePage>, Failure> {
        if complete {
            self.kept.remove()?;
        } else if self.kept.is_open() {
            self.meter.note("the finished tiles are kept; the same command goes on from them");
        }
        Ok(self.page)
    }

    fn clock(&self) -> MutexGuard<'_, Clock> {
        self.clock.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Watcher<'_> {
    fn begin(&self, phase: &Phase) {
        match phase {
            Phase::Vpls { count } => {
                self.meter.phase(&format!("tracing about {}", counted(*count, "VPL", "VPLs")));
            }
            Phase::LightTree => self.meter.phase("building the light tree"),
            Phase::Pixels { method, window, is_of_a_sum, promises } => {
                let about = if *is_of_a_sum { " of the sum over these VPLs" } else { "" };
                let what = format!("rendering {}x{}, {method}{about}", window.width, window.height);
                if *promises {
                    self.meter.claiming_phase(&what);
                } else {
                    self.meter.phase(&what);
                }
            }
            Phase::Audit { by, pixels } => {
                self.meter.phase(&format!("audit by {by}: {}", counted(*pixels, "pixel", "pixels")));
            }
            Phase::OtherSet => self.meter.phase("another set of VPLs"),
            _ => {}
        }
        let mut clock = self.clock();
        if can_be_ended(phase) {
            clock.heeded = interrupt::heed(true);
        }
        clock.begun = Instant::now();
    }

    fn end(&self, phase: &Phase) {
        let mut clock = self.clock();
        if can_be_ended(phase) {
            interrupt::heed(clock.heeded);
        }
        let passed = clock.begun.elapsed().as_secs_f64();
        let seconds = &mut clock.seconds;
        *match phase {
            Phase::Vpls { .. } => &mut seconds.vpls,
            Phase::LightTree => &mut seconds.trees,
            Phase::Reconstruction => &mut seconds.reconstruction,
            Phase::Mattes | Phase::FirstSurfaces => &mut seconds.mattes,
            Phase::Audit { .. } => &mut seconds.audit,
            Phase::OtherSet => &mut seconds.other_set,
            _ => &mut seconds.render,
        } += passed;
    }

    fn tile(&self, done: &Finished<'_>) {
        self.meter.update(&done.progress);
        if let Err(trouble) = self.kept.add(done) {
            self.meter.note(&format!("no more tiles are kept, those before are safe: {trouble}"));
        }
        if let Some(trouble) = self.viewer.as_ref().and_then(|viewer| viewer.show(done)) {
            self.meter.note(&trouble);
        }
        let of_pass = of_pass(done.film);
        if let Some(of_pass) = &of_pass {
            self.meter.phase(of_pass);
        }
        if let Some(page) = &self.page {
            page.show(done, of_pass.unwrap_or_else(|| self.meter.words()));
        }
    }

    fn progress(&self, progress: &Progress) {
        self.meter.update(progress);
    }

    fn seconds_left(&self) -> Option<f64> {
        self.end.map(|end| end.saturating_duration_since(Instant::now()).as_secs_f64())
    }

    fn cancel(&self) -> &AtomicBool {
        interrupt::flag()
    }
}

/// Predicted error of a picture in passes, in words; `None` for other films.
fn of_pass(film: &Film) -> Option<String> {
    let metadata = film.metadata();
    let (passes, foreseen) = (metadata.number(keys::PASSES)?, metadata.number(keys::FORESEEN)?);
    let foreseen = percent_of_error(foreseen);
    Some(format!("pass {passes}: about {foreseen} off in the median, an estimate that the audit checks"))
}

/// Returns true if the phase reads the flag that Ctrl-C sets, or must not be lost by it; in other
/// phases Ctrl-C ends the program.
fn can_be_ended(phase: &Phase) -> bool {
    matches!(
        phase,
        Phase::Pixels { .. } | Phase::Mattes | Phase::FirstSurfaces | Phase::Audit { .. } | Phase::OtherSet
    )
}
