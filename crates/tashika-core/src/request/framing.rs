//! Size of an image, the part of it that is rendered, and the camera as it stands for that size.

use crate::error::{Error, Location, Result};
use crate::film::{Film, Window};
use crate::scene::Camera;

/// Image size where neither the caller nor the camera says.
pub(super) const SIZE: [u32; 2] = [640, 360];

/// What was said of the image; nothing stands for what the camera says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Framing {
    /// Size of the full image (pixels).
    pub size: Option<[u32; 2]>,
    /// The part that is rendered, in pixels of that.
    pub crop: Option<Window>,
}

/// An image that can be rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Framed {
    /// The camera, where it stands for this size: see [`Camera::of_size`].
    pub camera: Camera,
    /// Size of the full image (pixels).
    pub size: [u32; 2],
    /// The part of it that is rendered.
    pub window: Window,
}

impl Framing {
    /// Size of the image, the part of it that is rendered, and the camera for it. The camera's own
    /// crop counts only with its own size, whose pixels it is in.
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

    /// Checks what can be checked without a camera.
    ///
    /// # Errors
    /// As [`Film::check`].
    pub fn check(&self) -> Result<()> {
        let Some(size) = self.size else { return Ok(()) };
        Film::check(size, self.crop.unwrap_or(Window::full(size)))
    }
}
