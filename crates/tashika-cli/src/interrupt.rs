//! Handling of Ctrl-C and of SIGTERM, which schedulers and systems send to end a program. The first
//! signal requests a running render to finish early; the second ends the program.

use std::io::IsTerminal;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::args::LogStyle;
use crate::exit::INTERRUPTED;
use crate::plan::Common;
use crate::progress::note_in_json;

/// True while a render runs that can be asked to finish.
static RENDERING: AtomicBool = AtomicBool::new(false);
/// True once a signal has asked that render to finish.
static ASKED: AtomicBool = AtomicBool::new(false);

/// Installs handlers for Ctrl-C and SIGTERM; to be called once. Outside [`with_flag`], both signals
/// still end the program.
pub fn listen(common: &Common) {
    let json = common.log.style == LogStyle::Json;
    // If the handler cannot be installed, Ctrl-C ends the program at once. The render can still be
    // done.
    let _ = ctrlc::set_handler(move || asked(json));
    #[cfg(unix)]
    if let Ok(mut signals) = signal_hook::iterator::Signals::new([signal_hook::consts::SIGTERM]) {
        std::thread::spawn(move || signals.forever().for_each(|_| asked(json)));
    }
}

/// Sets the flag at the first signal during a render; otherwise ends the program.
fn asked(json: bool) {
    if !RENDERING.load(Ordering::SeqCst) || ASKED.swap(true, Ordering::SeqCst) {
        process::exit(i32::from(INTERRUPTED));
    }
    const ANSWER: &str = "interrupted: finishing what is in work; press Ctrl-C again to end at once";
    if json {
        eprintln!("{}", note_in_json(ANSWER));
        return;
    }
    // On a terminal the cursor is in the line of progress.
    let leave = if std::io::stderr().is_terminal() { "\n" } else { "" };
    eprintln!("{leave}{ANSWER}");
}

/// Runs `work` with a flag that the first Ctrl-C sets.
pub fn with_flag<T>(work: impl FnOnce(&AtomicBool) -> T) -> T {
    let before = heed(true);
    let result = work(&ASKED);
    heed(before);
    result
}

/// The flag that the first Ctrl-C sets while it is [heeded](heed).
pub fn flag() -> &'static AtomicBool {
    &ASKED
}

/// Chooses whether Ctrl-C sets the flag (`true`) or ends the program; returns the previous choice.
pub fn heed(whether: bool) -> bool {
    RENDERING.swap(whether, Ordering::SeqCst)
}
