//! Errors of the library as exceptions of Python, mapped here and nowhere else.
//!
//! | of the library | in Python | which is also |
//! |---|---|---|
//! | `Error::Io`, `Error::Outside`, `Error::Missing` | `FileError` | `OSError` |
//! | `Error::Invalid` | `InputError` | `ValueError` |
//! | `Error::Unsupported` | `UnsupportedError` | `ValueError` |
//! | `Error::Option` | `OptionError` | `ValueError` |
//!
//! All are a `tashika.Error`, with the message of the library.

use pyo3::PyErr;
use tashika::error::Error;

/// The classes, which are written in Python so that each can have two bases.
mod classes {
    pyo3::import_exception!(tashika._errors, FileError);
    pyo3::import_exception!(tashika._errors, InputError);
    pyo3::import_exception!(tashika._errors, UnsupportedError);
    pyo3::import_exception!(tashika._errors, OptionError);
}

/// Returns a message of the library with Python keywords in place of the program's options.
pub fn in_python(message: &str) -> String {
    let keywords = ["missing", "outside"].map(|of| (format!("--allow-{of}"), format!("allow_{of}=True")));
    keywords.iter().fold(message.to_owned(), |said, (option, keyword)| said.replace(option, keyword))
}

/// Converts an error of the library to an exception.
pub fn raised(error: Error) -> PyErr {
    let message = in_python(&error.to_string());
    match error {
        Error::Io { .. } | Error::Outside { .. } | Error::Missing { .. } => {
            classes::FileError::new_err(message)
        }
        Error::Invalid { .. } => classes::InputError::new_err(message),
        Error::Unsupported { .. } => classes::UnsupportedError::new_err(message),
        // The enum may grow; an unknown error is taken to be about an argument.
        _ => classes::OptionError::new_err(message),
    }
}

/// Exception for an argument that has an unusable value.
pub fn option(name: &str, value: impl std::fmt::Display, expected: impl Into<String>) -> PyErr {
    raised(Error::option(name, value, expected))
}
