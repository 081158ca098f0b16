//! How far the work is: one line that is drawn over on a terminal, a plain line now and then elsewhere.
//!
//! The time left is what the remaining pixels take at the rate observed so far; nothing is smoothed or guessed
//! before a first tile is done.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressStyle};
use tashika::render::Progress;

/// Time between lines where they are not drawn over.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);
/// Time between redrawings.
const REDRAW_INTERVAL: Duration = Duration::from_millis(100);

/// Tells on standard error what is being done.
pub struct Meter {
    display: Display,
    state: Mutex<State>,
}

enum Display {
    Silent,
    Plain,
    Line(ProgressBar),
}

struct State {
    begun: Instant,
    told: Instant,
    progress: Progress,
}

impl Meter {
    /// A meter that suits where standard error goes.
    pub fn new(quiet: bool) -> Self {
        let display = if quiet {
            Display::Silent
        } else if std::io::stderr().is_terminal() {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            bar.set_style(ProgressStyle::with_template("{spinner} {wide_msg}").expect("a valid template"));
            bar.enable_steady_tick(REDRAW_INTERVAL);
            Display::Line(bar)
        } else {
            Display::Plain
        };
        let now = Instant::now();
        let state = State { begun: now, told: now, progress: Progress::default() };
        Self { display, state: Mutex::new(state) }
    }

    /// Tells what begins now, and restarts the clock.
    pub fn phase(&self, what: &str) {
        let mut state = self.state();
        state.begun = Instant::now();
        state.told = state.begun;
        match &self.display {
            Display::Silent => {}
            Display::Plain => eprintln!("{what}"),
            Display::Line(bar) => bar.set_message(what.to_owned()),
        }
    }

    /// Tells something that stays.
    pub fn note(&self, what: &str) {
        match &self.display {
            Display::Silent => {}
            Display::Plain => eprintln!("note: {what}"),
            Display::Line(bar) => bar.suspend(|| eprintln!("note: {what}")),
        }
    }

    /// Tells how far the render is, if it is time to.
    pub fn update(&self, progress: &Progress) {
        let mut state = self.state();
        state.progress = *progress;
        let interval = match &self.display {
            Display::Silent => return,
            Display::Plain => PLAIN_INTERVAL,
            Display::Line(_) => REDRAW_INTERVAL,
        };
        let now = Instant::now();
        if now - state.told < interval {
            return;
        }
        state.told = now;
        let line = line(progress, now - state.begun);
        match &self.display {
            Display::Silent => {}
            Display::Plain => eprintln!("{line}"),
            Display::Line(bar) => bar.set_message(line),
        }
    }

    /// Ends the drawing; returns how far the render came.
    pub fn finish(&self) -> Progress {
        if let Display::Line(bar) = &self.display {
            bar.finish_and_clear();
        }
        self.state().progress
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// An error is not told beside a line that is no longer true.
impl Drop for Meter {
    fn drop(&mut self) {
        self.finish();
    }
}

fn line(progress: &Progress, elapsed: Duration) -> String {
    let Progress { pixels, of, rays, .. } = *progress;
    let seconds = elapsed.as_secs_f64();
    let share = pixels as f64 / of.max(1) as f64;
    let left = if pixels > 0 { clock(seconds * (1.0 - share) / share) } else { "unknown time".to_owned() };
    format!(
        "{:.1} %: {} of {} pixels, {}, {left} left",
        // Rounded down, so that 100 % means all.
        (share * 1000.0).floor() / 10.0,
        HumanCount(pixels),
        HumanCount(of),
        rate(rays as f64 / seconds.max(1e-9)),
    )
}

/// Rays a second, with a prefix.
pub fn rate(rays_per_second: f64) -> String {
    let (value, unit) = match rays_per_second {
        r if r >= 1e9 => (r / 1e9, "Grays/s"),
        r if r >= 1e6 => (r / 1e6, "Mrays/s"),
        r if r >= 1e3 => (r / 1e3, "krays/s"),
        r => (r, "rays/s"),
    };
    format!("{value:.1} {unit}")
}

/// Minutes and seconds, with hours from the first.
fn clock(seconds: f64) -> String {
    let s = seconds.round() as u64;
    let (hours, minutes, s) = (s / 3600, s / 60 % 60, s % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{s:02}") } else { format!("{minutes}:{s:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_extrapolates_what_was_observed() {
        let progress = Progress { pixels: 2_500, of: 10_000, rays: 50_000_000, ..Progress::default() };
        assert_eq!(
            line(&progress, Duration::from_secs(25)),
            "25.0 %: 2,500 of 10,000 pixels, 2.0 Mrays/s, 1:15 left"
        );
        let begun = Progress { pixels: 0, of: 10, ..Progress::default() };
        assert_eq!(line(&begun, Duration::ZERO), "0.0 %: 0 of 10 pixels, 0.0 rays/s, unknown time left");
        let almost = Progress { pixels: 999_999, of: 1_000_000, ..Progress::default() };
        assert!(line(&almost, Duration::from_secs(9)).starts_with("99.9 %"), "100 % means all");
        assert_eq!((clock(3_725.4), clock(59.6)), ("1:02:05".to_owned(), "1:00".to_owned()));
    }
}
