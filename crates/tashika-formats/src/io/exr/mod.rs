//! Films as OpenEXR files.
//!
//! One part, so that every tool reads it, unless another [`ExrLayout`] is asked for: the main plane as channels `R`, `G`, `B`, other planes as
//! `plane.channel` (`half_width.Y`), each channel 32-bit float or unsigned integer as in the film,
//! ZIP compressed (lossless). In parts, each plane is one of its name, the main plane `rgb`, with the
//! same full names of channels; attributes that are about all planes are in the first. The display window is the full image, the data window the film's
//! window.
//!
//! Attributes: metadata `name` is `tashika:name` of type `int`, `double` or `string` (yes and no,
//! and whole numbers beyond 32 bits, are strings; text that reads as such comes back as such);
//! what mattes are about (`cryptomatte/…`) has the names that the format of mattes gives it;
//! units and meanings of all planes are the JSON list `tashika:planes`, in UTF-8. Of the standard
//! attributes there are those that every file must have, `chromaticities` (Rec. 709), `software`,
//! and `comments`: a line of what the image is and what it promises.
//!
//! # Guarantee
//! `read_exr(write_exr(film)) == film`, bit by bit, and equal films give equal bytes. [`ExrFile`]
//! gives the same samples, rows by rows.
//!
//! # Held to this by
//! The tests below and those of `rows`; `readers.py` among the program's tests, which reads files
//! by the reference implementation and by OpenImageIO and compares names, types, windows,
//! attributes and every bit.

mod choices;
mod layout;
mod read;
mod rows;
mod write;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use choices::{ExrCompression, ExrLayout};
pub use layout::ExrPlane;
pub(super) use layout::check_claims;
pub use read::read_exr;
pub use rows::ExrFile;
pub use write::{write_exr, write_exr_as};

use crate::error::{Error, Location};

/// Before the name of each value.
const PREFIX: &str = "tashika:";
/// Attribute with what the channels cannot say.
const PLANES: &str = "tashika:planes";

/// What a plane is, apart from its samples.
#[derive(Serialize, Deserialize)]
struct PlaneRecord {
    name: String,
    channels: Vec<String>,
    unit: String,
    doc: String,
}

fn unsupported(path: &Path, what: impl Into<String>) -> Error {
    Error::unsupported(Location::file(path), what, "save it as a flat OpenEXR image of usual size")
}

/// What the crate says of a file that ends within what it reads.
const CRATE_AT_END: &str = "reference to missing bytes";

/// A file that ends too early was read as far as it goes: it is the file's fault.
fn io(path: &Path, error: std::io::Error) -> Error {
    if error.kind() == std::io::ErrorKind::UnexpectedEof {
        return truncated(path, "it ends before the image does");
    }
    Error::io(path, error)
}

fn truncated(path: &Path, how: impl std::fmt::Display) -> Error {
    Error::invalid(
        Location::file(path),
        format!("a truncated file: {how}"),
        "an OpenEXR image as it was written",
    )
}

fn at(path: &Path, error: ::exr::error::Error) -> Error {
    use ::exr::error::Error as Exr;
    match error {
        Exr::Io(source) => io(path, source),
        Exr::NotSupported(what) => unsupported(path, what),
        Exr::Invalid(found) if found == CRATE_AT_END => truncated(path, "it ends before the image does"),
        Exr::Invalid(found) => Error::invalid(Location::file(path), found, "an OpenEXR image"),
        Exr::Aborted => Error::invalid(Location::file(path), "reading was given up", "an OpenEXR image"),
    }
}

#[cfg(test)]
mod tests;
