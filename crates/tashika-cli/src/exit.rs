//! Exit codes of the program, which scripts rely on.

use std::fmt;
use std::process::ExitCode;

use tashika::error::Error;

/// Exit code of a run that wrote its files; with several images, the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// All files are written, and there is nothing to report (0).
    Done,
    /// Done, but some pixels ran out of budget (4).
    BudgetHit,
    /// Done, but the audit contradicts the claim (5).
    Contradicted,
    /// Done, but some pixels are infinite or not a number (6).
    NotFinite,
    /// Ended by Ctrl-C: the finished part of the work is written and marked as incomplete (130).
    Interrupted,
}

impl Outcome {
    /// Exit code of the process for this outcome.
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::BudgetHit => 4,
            Self::Contradicted => 5,
            Self::NotFinite => 6,
            Self::Interrupted => INTERRUPTED,
        }
    }
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(outcome.code())
    }
}

/// Returns the name of an option as it is typed after its hyphens, from its name in the library.
pub fn typed(name: &str) -> String {
    match name {
        "lights" => "vpl-file".to_owned(),
        _ => name.replace('_', "-"),
    }
}

/// Exit code by which shells mark a program that Ctrl-C ended: 128 and the number of the signal.
pub const INTERRUPTED: u8 = 130;

/// Exit code and message of a run that wrote nothing useful.
#[derive(Debug)]
pub struct Failure {
    code: u8,
    message: String,
    told: bool,
}

impl Failure {
    /// Failure for a command line that asks for something impossible (2).
    pub fn usage(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into(), told: false }
    }

    /// Failure for an unusable value of an option (2), in the words of the library's errors.
    pub fn option(option: &str, value: impl fmt::Display, expected: impl Into<String>) -> Self {
        Error::option(option, value, expected).into()
    }

    /// Exit code of the process for this failure.
    pub fn code(&self) -> u8 {
        self.code
    }

    /// Marks the failure as printed already, as JSON on standard error.
    pub fn told(self) -> Self {
        Self { told: true, ..self }
    }

    /// Returns true if the failure was printed already.
    pub fn is_told(&self) -> bool {
        self.told
    }

    /// Failure for a file that could not be used (3).
    pub fn file(message: impl Into<String>) -> Self {
        Self { code: 3, message: message.into(), told: false }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            // The library names an option by its field, which differs from the typed name.
            Error::Option { option, value, expected } => {
                let option = typed(&option);
                Self::usage(format!("--{}", Error::Option { option, value, expected }))
            }
            _ => Self::file(error.to_string()),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<Failure> for ExitCode {
    fn from(failure: Failure) -> Self {
        Self::from(failure.code)
    }
}
