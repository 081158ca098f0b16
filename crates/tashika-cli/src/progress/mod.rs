//! Progress of a command and its destinations. On a terminal, one line is redrawn; elsewhere plain
//! lines are printed, or JSON for programs. A file receives lines of either form.
//!
//! [`event`] formats the events, [`pace`] estimates the remaining time.

mod event;
mod pace;

use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use memory_stats::memory_stats;
use tashika::render::{Progress, with_threads};

use crate::args::LogStyle;
use crate::exit::{Failure, Outcome};
use crate::plan::{Common, is_standard_stream};
use event::{Event, Standing};
use pace::Pace;

pub use event::{rate, visible_lines};

/// Time between lines of progress for people.
const WORDS_INTERVAL: Duration = Duration::from_secs(10);
/// Time between lines of progress for programs.
const JSON_INTERVAL: Duration = Duration::from_secs(1);
/// Time between redrawings.
const REDRAW_INTERVAL: Duration = Duration::from_millis(100);

/// Runs a command on the requested number of threads, with a meter that also reports the end of the
/// command.
pub fn metered(
    common: &Common,
    work: impl FnOnce(&Meter) -> Result<Outcome, Failure> + Send,
) -> Result<Outcome, Failure> {
    let meter = Meter::new(common)?;
    let result = with_threads(common.threads, || work(&meter)).map_err(Failure::from).flatten();
    meter.end(result)
}

/// Formats a note as a line for programs.
pub fn note_in_json(what: &str) -> String {
    Event::Note { what }.json()
}

/// Reporter of phases, notes and progress.
pub struct Meter {
    created: Instant,
    state: Mutex<State>,
}

struct State {
    begun: Instant,
    progress: Progress,
    /// True if pixels of this phase may claim something.
    promises: bool,
    pace: Pace,
    sinks: Vec<Sink>,
}

/// Destination of events, with their format and interval.
struct Sink {
    place: Place,
    json: bool,
    interval: Duration,
    told: Instant,
}

enum Place {
    /// One line of a terminal, redrawn.
    Line(ProgressBar),
    /// Separate lines on standard error.
    StandardError,
    /// Lines appended to a file.
    File(File),
}

impl Sink {
    fn new(place: Place, json: bool) -> Self {
        let interval = match (&place, json) {
            (Place::Line(_), _) => REDRAW_INTERVAL,
            (_, true) => JSON_INTERVAL,
            (_, false) => WORDS_INTERVAL,
        };
        Self { place, json, interval, told: Instant::now() }
    }

    fn tell(&mut self, event: &Event<'_>) -> io::Result<()> {
        let Some(line) = (if self.json { Some(event.json()) } else { event.words() }) else { return Ok(()) };
        match (&mut self.place, event) {
            (Place::Line(bar), Event::Phase { .. } | Event::Progress(_)) => bar.set_message(line),
            (Place::Line(bar), _) => bar.suspend(|| eprintln!("{line}")),
            (Place::StandardError, _) => eprintln!("{line}"),
            // Each line is one write, so that lines of several programs in one file are not
            // interleaved.
            (Place::File(file), _) => file.write_all(format!("{line}\n").as_bytes())?,
        }
        Ok(())
    }
}

impl Meter {
    /// Makes a meter with the destinations that the options name.
    fn new(common: &Common) -> Result<Self, Failure> {
        let json = common.log.style == LogStyle::Json;
        let mut sinks = Vec::new();
        let to_standard_error = common.log.file.as_deref().is_some_and(is_standard_stream);
        if !common.quiet || to_standard_error {
            let redraw =
                common.log.style == LogStyle::Auto && io::stderr().is_terminal() && !to_standard_error;
            sinks.push(Sink::new(if redraw { line() } else { Place::StandardError }, json));
        }
        if let Some(path) = common.log.file.as_deref().filter(|path| !is_standard_stream(path)) {
            sinks.push(Sink::new(Place::File(open(path)?), json));
        }
        let now = Instant::now();
        let state = State {
            begun: now,
            progress: Progress::default(),
            promises: false,
            pace: Pace::default(),
            sinks,
        };
        Ok(Self { created: now, state: Mutex::new(state) })
    }

    /// Reports the beginning of a phase, and restarts the clock.
    pub fn phase(&self, what: &str) {
        self.begin(what, false);
    }

    /// Begins the phase of a render whose pixels may claim something.
    pub fn claiming_phase(&self, what: &str) {
        self.begin(what, true);
    }

    fn begin(&self, what: &str, promises: bool) {
        let mut state = self.state();
        let now = Instant::now();
        (state.begun, state.pace, state.promises) = (now, Pace::default(), promises);
        state.sinks.iter_mut().for_each(|sink| sink.told = now);
        state.tell(&Event::Phase { what });
    }

    /// Reports a remark, which stays on a terminal.
    pub fn note(&self, what: &str) {
        self.state().tell(&Event::Note { what });
    }

    /// Reports the progress of a render to each destination whose interval has passed since its
    /// last report.
    pub fn update(&self, progress: &Progress) {
        let mut state = self.state();
        let now = Instant::now();
        let seconds = (now - state.begun).as_secs_f64();
        state.progress = *progress;
        let pixels = progress.tally.rendered();
        state.pace.observe(pixels, progress.of, seconds);
        let all = pixels == progress.of;
        // Programs always receive the report of the last pixel.
        let due = |sink: &Sink| now - sink.told >= sink.interval || (all && sink.json);
        if state.sinks.iter().any(due) {
            let event = Event::Progress(state.standing(seconds));
            state.report_to(&event, |sink| {
                let due = due(sink);
                if due {
                    sink.told = now;
                }
                due
            });
        }
    }

    /// Progress of the render, in words.
    pub fn words(&self) -> String {
        let state = self.state();
        Event::Progress(state.standing(state.begun.elapsed().as_secs_f64())).words().unwrap_or_default()
    }

    /// Clears the line on a terminal; returns the last progress of the render.
    pub fn finish(&self) -> Progress {
        let state = self.state();
        for sink in &state.sinks {
            if let Place::Line(bar) = &sink.place {
                bar.finish_and_clear();
            }
        }
        state.progress
    }

    /// Reports the end of the command.
    fn end(&self, result: Result<Outcome, Failure>) -> Result<Outcome, Failure> {
        self.finish();
        let mut state = self.state();
        match result {
            Ok(outcome) => {
                let seconds = self.created.elapsed().as_secs_f64();
                state.tell(&Event::Done { exit_code: outcome.code(), seconds, memory_bytes: memory_bytes() });
                Ok(outcome)
            }
            Err(failure) => {
                let what = failure.to_string();
                let event = Event::Error { what: &what, exit_code: failure.code() };
                // On a terminal, `main` prints the error, in the same way as errors in options.
                state.report_to(&event, |sink| sink.json || matches!(sink.place, Place::File(_)));
                let told = state.sinks.iter().any(|s| s.json && matches!(s.place, Place::StandardError));
                Err(if told { failure.told() } else { failure })
            }
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Clears the line on a terminal, so that no outdated progress stands beside an error.
impl Drop for Meter {
    fn drop(&mut self) {
        self.finish();
    }
}

impl State {
    fn tell(&mut self, event: &Event<'_>) {
        self.report_to(event, |_| true);
    }

    /// Reports the event to the chosen destinations. A destination that fails is removed, and the
    /// others receive a note about it.
    fn report_to(&mut self, event: &Event<'_>, mut chosen: impl FnMut(&mut Sink) -> bool) {
        let mut trouble = None;
        self.sinks.retain_mut(|sink| {
            let told = if chosen(sink) { sink.tell(event) } else { Ok(()) };
            told.map_err(|e| trouble = Some(e)).is_ok()
        });
        if let Some(e) = trouble {
            self.tell(&Event::Note { what: &format!("the log file takes no more: {e}") });
        }
    }

    fn standing(&self, seconds: f64) -> Standing {
        let Progress { tally, of, rays } = self.progress;
        let (pixels, claiming) = (tally.rendered(), tally.claiming());
        let share = claiming as f64 / pixels.max(1) as f64;
        let claiming_share = (self.promises && pixels > 0).then_some(share);
        let claiming = self.promises.then_some(claiming);
        Standing {
            pixels,
            of,
            claiming,
            claiming_share,
            promise_met: claiming,
            promise_share: claiming_share,
            rays,
            rays_per_second: rays as f64 / seconds.max(1e-9),
            seconds,
            seconds_left: self.pace.seconds_left(),
            memory_bytes: memory_bytes(),
        }
    }
}

fn line() -> Place {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    bar.set_style(ProgressStyle::with_template("{spinner} {wide_msg}").expect("a valid template"));
    bar.enable_steady_tick(REDRAW_INTERVAL);
    Place::Line(bar)
}

fn open(path: &Path) -> Result<File, Failure> {
    let file = File::options().append(true).create(true).open(path);
    file.map_err(|e| Failure::file(format!("cannot write {}: {e}", path.display())))
}

/// Memory that the program occupies now (bytes), if the system reports it.
fn memory_bytes() -> Option<u64> {
    memory_stats().map(|memory| memory.physical_mem as u64)
}
