//! Pairs of pixels of two films.

use super::compare::Named;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::film::{Film, Plane, RenderFilm};

/// A pixel of the image, paired with that of the reference.
#[derive(Clone, Copy, Debug)]
pub(super) enum Pixel {
    /// Not rendered in one of the films: its plane `stop` is 0.
    NotRendered,
    /// The reference is not finite, so that no comparison is possible.
    NoTruth,
    /// Only the image is not finite.
    Failed { truth: Rgb },
    /// Colour and truth are finite.
    Finite { color: Rgb, truth: Rgb },
}

/// An image and its reference, which show the same window; both have colours.
#[derive(Clone, Copy)]
pub(super) struct Pairs<'f> {
    films: [&'f Film; 2],
}

impl<'f> Pairs<'f> {
    /// Pairs the films of an image and of its reference.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the film that has no colours.
    pub(super) fn of(image: Named<'f>, reference: Named<'f>) -> Result<Self> {
        let films = [image, reference].map(|named| {
            if named.film.colors().is_some() {
                return Ok(named.film);
            }
            let planes: Vec<&str> = named.film.planes().iter().map(Plane::name).collect();
            Err(Error::invalid(
                Location::file(named.name),
                format!("an image without colours, of the layers {planes:?}"),
                "channels R, G and B, or one channel, that belong to no named layer",
            ))
        });
        let [image, reference] = films;
        Ok(Self { films: [image?, reference?] })
    }

    /// All pairs, in the order of [`Window::pixels`](crate::film::Window::pixels).
    pub(super) fn pixels(self) -> impl Iterator<Item = Pixel> + Clone + use<'f> {
        let read = self.films.map(RenderFilm::of);
        let pixels = 0..self.films[0].window().area() as usize;
        pixels.map(move |pixel| {
            let [color, truth] = read.map(|film| film.color(pixel).expect("both have colours"));
            if !read.iter().all(|film| film.is_rendered(pixel)) {
                Pixel::NotRendered
            } else if !truth.is_finite() {
                Pixel::NoTruth
            } else if !color.is_finite() {
                Pixel::Failed { truth }
            } else {
                Pixel::Finite { color, truth }
            }
        })
    }
}
