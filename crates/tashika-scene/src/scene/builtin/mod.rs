//! Scenes made by code, without files, bit for bit equal on every machine.
//!
//! | scene | purpose |
//! |---|---|
//! | [`room`] | the default: glossy room, many lights, many Phong exponents, supersampled detail |
//! | [`tiny`] | a box with two blocks and one light, for tests that must be fast |
//!
//! Lengths in metres, `y` up, radiance in W·m⁻²·sr⁻¹.
//!
//! # Guarantee
//! Two calls give equal scenes: randomness comes from [`rng`](crate::rng) with fixed keys,
//! elementary functions from [`math::elementary`](crate::math::elementary). Nothing has to be
//! repaired or defaulted: [`Scene::notes`](crate::scene::Scene::notes) is empty.
//!
//! # Held to this by
//! `builtin::tests`.

mod room;
mod shapes;
mod stage;
#[cfg(test)]
mod tests;
mod tiny;

pub use room::room;
pub use tiny::tiny;

use crate::error::{Error, Result};
use crate::scene::Scene;

/// Prefix of the names of these scenes in place of a file name.
pub const PREFIX: &str = "builtin:";

/// Returns the function that makes the scene named `name`, which has no [`PREFIX`].
///
/// # Errors
/// [`Error::Option`] naming `scene` if there is none.
pub fn by_name(name: &str) -> Result<fn() -> Scene> {
    match name {
        "room" => Ok(room),
        "tiny" => Ok(tiny),
        _ => Err(Error::option(
            "scene",
            format!("{PREFIX}{name}"),
            "builtin:room, builtin:tiny, or a scene file",
        )),
    }
}
