//! How the program ends: the exit codes that scripts rely on.

use std::fmt;
use std::process::ExitCode;

use tashika::error::Error;

/// Files were written, and this is to be known of them; of several images the last of these counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// Done (0).
    Done,
    /// Done, but some pixels ran out of budget (4).
    BudgetHit,
    /// Done, but the audit contradicts the claim (5).
    Contradicted,
    /// Done, but some pixels are infinite or not a number (6).
    NotFinite,
    /// Ctrl-C: what was finished is written and says that it is not complete (130).
    Interrupted,
}

impl Outcome {
    /// The exit code.
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

/// What a shell says of a program that Ctrl-C ended: 128 and the number of the signal.
pub const INTERRUPTED: u8 = 130;

/// Nothing useful was written.
#[derive(Debug)]
pub struct Failure {
    code: u8,
    message: String,
    told: bool,
}

impl Failure {
    /// The command line asks for what cannot be (2).
    pub fn usage(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into(), told: false }
    }

    /// An option has an unusable value (2); worded as the library words it.
    pub fn option(option: &str, value: impl fmt::Display, expected: impl Into<String>) -> Self {
        Error::option(option, value, expected).into()
    }

    /// The exit code.
    pub fn code(&self) -> u8 {
        self.code
    }

    /// The same, after it was told where standard error goes.
    pub fn told(self) -> Self {
        Self { told: true, ..self }
    }

    /// Whether it was told already.
    pub fn is_told(&self) -> bool {
        self.told
    }

    /// A file could not be used (3).
    pub fn file(message: impl Into<String>) -> Self {
        Self { code: 3, message: message.into(), told: false }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            // The library's names of options are those of the fields that hold them.
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
