//! Events of a running command. Each is formatted in words for people, or as one JSON object on a
//! line for programs.

use indicatif::HumanCount;
use serde::Serialize;
use tashika::error::visible;

/// Event that is reported. In JSON, the key `event` has the event's name.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event<'a> {
    /// Beginning of a phase of the work.
    Phase {
        /// Description of the phase.
        what: &'a str,
    },
    /// Remark for the user.
    Note {
        /// Text of the remark.
        what: &'a str,
    },
    /// Progress within the current phase.
    Progress(Standing),
    /// End of a command that wrote its files.
    Done {
        /// Exit code of the program.
        exit_code: u8,
        /// Time since the command began (s).
        seconds: f64,
        /// Memory in use (bytes), if the system reports it.
        memory_bytes: Option<u64>,
    },
    /// End of a command that wrote nothing useful.
    Error {
        /// Message of the error.
        what: &'a str,
        /// Exit code of the program.
        exit_code: u8,
    },
}

/// Progress of a phase.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Standing {
    /// Number of pixels that are finished.
    pub pixels: u64,
    /// Number of pixels of the whole phase.
    pub of: u64,
    /// Finished pixels that claim something within their budget; none if no pixel may claim
    /// anything.
    pub claiming: Option<u64>,
    /// `claiming` as a share of the finished pixels.
    pub claiming_share: Option<f64>,
    /// `claiming`, by its name in earlier versions.
    pub promise_met: Option<u64>,
    /// `claiming_share`, by its name in earlier versions.
    pub promise_share: Option<f64>,
    /// Number of rays and segments that were traced.
    pub rays: u64,
    /// Number of rays and segments that were traced a second.
    pub rays_per_second: f64,
    /// Time since the phase began (s).
    pub seconds: f64,
    /// Time for the remaining pixels (s), as `pace` estimates it.
    pub seconds_left: Option<f64>,
    /// Memory in use (bytes), if the system reports it.
    pub memory_bytes: Option<u64>,
}

impl Event<'_> {
    /// Formats the event for people, on one line. `None` for [`Done`](Self::Done), which is not
    /// printed for people.
    pub fn words(&self) -> Option<String> {
        match self {
            Self::Phase { what } => Some(visible(what).into_owned()),
            Self::Note { what } => Some(format!("note: {}", visible(what))),
            Self::Progress(standing) => Some(standing.words()),
            Self::Error { what, .. } => Some(format!("error: {}", visible_lines(what))),
            Self::Done { .. } => None,
        }
    }

    /// Formats the event for programs, on one line.
    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("events are plain data")
    }
}

/// Returns the text with control characters escaped in each line, so that no name in it can control
/// a terminal.
pub fn visible_lines(text: &str) -> String {
    text.split('\n').map(visible).collect::<Vec<_>>().join("\n")
}

impl Standing {
    fn words(&self) -> String {
        let Self { pixels, of, rays_per_second, .. } = *self;
        let mut words =
            format!("{} %: {} of {} pixels", floored(pixels, of), HumanCount(pixels), HumanCount(of));
        if let Some(claiming) = self.claiming.filter(|_| pixels > 0) {
            words += &format!(", {} % with a claim", floored(claiming, pixels));
        }
        let left = self.seconds_left.map_or_else(|| "unknown time".to_owned(), clock);
        words += &format!(", {}, {left} left", rate(rays_per_second));
        if let Some(bytes) = self.memory_bytes {
            words += &format!(", {}", memory(bytes));
        }
        words
    }
}

/// A share in percent, rounded down, so that 100 % means all.
fn floored(part: u64, of: u64) -> String {
    let thousandths = u128::from(part) * 1000 / u128::from(of.max(1));
    format!("{}.{}", thousandths / 10, thousandths % 10)
}

/// Formats rays a second, with a prefix.
pub fn rate(rays_per_second: f64) -> String {
    let (value, unit) = match rays_per_second {
        r if r >= 1e9 => (r / 1e9, "Grays/s"),
        r if r >= 1e6 => (r / 1e6, "Mrays/s"),
        r if r >= 1e3 => (r / 1e3, "krays/s"),
        r => (r, "rays/s"),
    };
    format!("{value:.1} {unit}")
}

/// Formats bytes as megabytes, or as gigabytes from ten gigabytes.
fn memory(bytes: u64) -> String {
    let bytes = bytes as f64;
    if bytes < 1e10 { format!("{:.0} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) }
}

/// Formats seconds as minutes and seconds, with hours from one hour.
fn clock(seconds: f64) -> String {
    let s = seconds.round() as u64;
    let (hours, minutes, s) = (s / 3600, s / 60 % 60, s % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{s:02}") } else { format!("{minutes}:{s:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STANDING: Standing = Standing {
        pixels: 2_500,
        of: 10_000,
        claiming: Some(2_500),
        claiming_share: Some(1.0),
        promise_met: Some(2_500),
        promise_share: Some(1.0),
        rays: 50_000_000,
        rays_per_second: 2e6,
        seconds: 25.0,
        seconds_left: Some(75.0),
        memory_bytes: Some(412_300_000),
    };

    #[test]
    fn the_line_has_what_is_known() {
        assert_eq!(
            STANDING.words(),
            "25.0 %: 2,500 of 10,000 pixels, 100.0 % with a claim, 2.0 Mrays/s, 1:15 left, 412 MB"
        );
        let little = Standing { claiming: None, memory_bytes: None, ..STANDING };
        assert_eq!(little.words(), "25.0 %: 2,500 of 10,000 pixels, 2.0 Mrays/s, 1:15 left");
        let begun = Standing {
            pixels: 0,
            of: 10,
            claiming: Some(0),
            rays_per_second: 0.0,
            seconds_left: None,
            memory_bytes: None,
            ..STANDING
        };
        assert_eq!(begun.words(), "0.0 %: 0 of 10 pixels, 0.0 rays/s, unknown time left");
    }

    #[test]
    fn shares_are_rounded_down() {
        let almost = Standing { pixels: 999_999, of: 1_000_000, claiming: Some(999_998), ..STANDING }.words();
        assert!(almost.starts_with("99.9 %") && almost.contains("99.9 % with"), "100 % means all: {almost}");
        assert_eq!(
            (floored(3, 3), floored(0, 0), floored(1, 3)),
            ("100.0".into(), "0.0".into(), "33.3".into())
        );
    }

    #[test]
    fn times_and_sizes_have_their_units() {
        assert_eq!((clock(3_725.4), clock(59.6)), ("1:02:05".to_owned(), "1:00".to_owned()));
        assert_eq!((memory(1_400_000), memory(12_340_000_000)), ("1 MB".to_owned(), "12.3 GB".to_owned()));
    }

    #[test]
    fn programs_read_one_object_with_the_events_name() {
        let read = |event: Event<'_>| serde_json::from_str::<serde_json::Value>(&event.json()).unwrap();
        let note = read(Event::Note { what: "two\n\"lines\"" });
        assert_eq!((note["event"].as_str(), note["what"].as_str()), (Some("note"), Some("two\n\"lines\"")));
        assert!(!Event::Note { what: "two\nlines" }.json().contains('\n'), "on one line");
        let standing = read(Event::Progress(STANDING));
        assert_eq!((standing["event"].as_str(), standing["of"].as_u64()), (Some("progress"), Some(10_000)));
        assert_eq!(standing["seconds_left"].as_f64(), Some(75.0));
        let done = read(Event::Done { exit_code: 4, seconds: 1.5, memory_bytes: None });
        assert_eq!((done["exit_code"].as_u64(), done["memory_bytes"].is_null()), (Some(4), true));
    }
}
