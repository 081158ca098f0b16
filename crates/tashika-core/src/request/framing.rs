//! Size of an image, the rendered part of it, and the camera for that size.

use crate::error::{Error, Location, Result};
use crate::film::{Film, Window};
use crate::scene::Camera;

/// Default image size, if the camera has none (pixels).
pub(super) const SIZE: [u32; 2] = [640, 360];

/// The given options; `None` keeps the camera's value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Framing {
    /// Size of the full image (pixels).
    pub size: Option<[u32; 2]>,
    /// Rendered part, in pixels of the full image.
    pub crop: Option<Window>,
}

/// An image that can be rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Framed {
    /// Camera for this size: see [`Camera::of_size`].
    pub camera: Camera,
    /// Size of the full image (pixels).
    pub size: [u32; 2],
    /// Rendered part of the image (pixels).
    pub window: Window,
}

impl Framing {
    /// Size of the image, the rendered part of it, and the camera for both. The camera's crop is in
    /// pixels of the camera's size, so it applies only with that size.
    ///
    /// # Errors
    /// As [`Film::check`]; [`Error::Invalid`] at the camera, without a file, if the camera's own
    /// size is impossible.
    pub fn of(&self, camera: &Camera) -> Result<Framed> {
        let size = self.size.or(camera.resolution).unwrap_or(SIZE);
        let own_size = self.size.is_none() && camera.resolution.is_some();
        let own = camera.crop.filter(|_| self.size.is_none());
        let window = self.crop.or(own).unwrap_or(Window::full(size));
        Film::check(size, window).map_err(|error| match error {
            Error::Option { option, value, expected } if option == "size" && own_size => {
                let at = Location::default().item(format!("camera {}", camera.name));
                Error::invalid(at, format!("a film of {value}"), format!("{expected}, or another size"))
            }
            error => error,
        })?;
        Ok(Framed { camera: camera.of_size(size), size, window })
    }

    /// Checks the size and the crop as far as possible without a camera.
    ///
    /// # Errors
    /// As [`Film::check`].
    pub fn check(&self) -> Result<()> {
        let Some(size) = self.size else { return Ok(()) };
        Film::check(size, self.crop.unwrap_or(Window::full(size)))
    }
}
