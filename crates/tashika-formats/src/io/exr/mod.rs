//! Films as OpenEXR files.
//!
//! By default a film is one part, which every tool reads; see [`ExrLayout`]. The channels of the
//! main plane are named `R`, `G`, `B`, those of other planes `plane.channel` (`half_width.Y`). Each
//! channel is 32-bit float or unsigned integer as in the film, ZIP compressed (lossless). If there
//! are several parts, each plane is a part with the name of the plane (`rgb` for the main plane).
//! Channels keep their full names, and attributes of all planes are in the first part. The display
//! window is the full image; the data window is the film's window.
//!
//! Attributes: the metadata value `name` is stored as `tashika:name`, of type `int`, `double` or
//! `string`. Booleans and integers beyond 32 bits are stored as strings. Reading converts every
//! string that looks like a boolean or such an integer. Metadata of mattes (`cryptomatte/…`) has
//! the names that Cryptomatte defines, without the prefix. The attribute `tashika:planes` has the
//! units and meanings of all planes as a JSON list in UTF-8. Of the standard attributes, a file has
//! the required ones, `chromaticities` (Rec. 709), `software`, and `comments`: a line with the
//! contents of the image and its claim.
//!
//! # Guarantee
//! `read_exr(write_exr(film)) == film`, bit by bit, and equal films give equal bytes. [`ExrFile`]
//! reads the same samples, a range of rows at a time.
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

/// Prefix of the attributes that store metadata.
const PREFIX: &str = "tashika:";
/// Attribute with the properties of planes that channels do not store.
const PLANES: &str = "tashika:planes";

/// Description of a plane, apart from its samples.
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

/// Message of the crate for a file that ends within the data being read.
const CRATE_AT_END: &str = "reference to missing bytes";

/// Converts an error of reading. If the file ends early, the file is damaged; this is not an I/O
/// error.
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
