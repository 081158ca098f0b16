//! Typed records of a rendered film: claims of pixels, reasons why work ended, and costs.
//!
//! | file | contents |
//! |---|---|
//! | `claim` | [`Claim`] and [`Stop`]: the codes, with their words and colours |
//! | `schema` | [`SCHEMA`]: the table of planes, which [`PixelRecord`] and [`planes`] follow |
//! | `keys` | [`keys`]: a row for each value of the metadata |
//! | `tally` | [`Tally`]: numbers of pixels by claim |
//! | `found_light` | [`FoundLight`]: light of the image by estimator and by route |
//! | `matte` | [`Matte`]: numbers of objects and materials, and how much of a pixel each covers |
//! | `picture_claim` | [`PictureClaim`]: claim of an audit about all pixels together |
//!
//! No code outside this module spells out the number of a code, the name of a plane, or the name of
//! a metadata value. Pages receive these tables as data. *(tidy)*
//!
//! # Films of other programs
//! Without a plane `stop`, every pixel counts as rendered; without a plane `claim`, every
//! half-width counts as a published claim.

mod claim;
mod found_light;
pub mod keys;
mod matte;
mod picture_claim;
mod schema;
mod tally;

pub use claim::{Claim, Code, Stop};
pub use found_light::{FoundLight, Routes};
pub use keys::Key;
pub use matte::{CRYPTOMATTE, Matte, MatteOf, matte_id};
pub use picture_claim::PictureClaim;
pub use schema::{HalfWidths, LuminanceParts, PixelRecord, PlaneRow, SCHEMA, Shown, planes};
pub use tally::Tally;

use super::{Film, Plane, PlaneSpec};
use crate::color::{Controlled, Rgb};
use serde::Serialize;

/// Interval of the mean luminance of an image of `n` pixels:
///
/// ```text
/// (1/n) Σ L_i  ±  (1/n) Σ h_i
/// ```
///
/// # Guarantee
/// It holds if the intervals of all pixels hold, however their errors are correlated (triangle
/// inequality). If some of them do not hold, it still holds as long as the slack of the other
/// intervals makes up for the excess. A pixel whose samples missed a bright spot can break it.
/// Measured: in a scene behind a lens it was broken for one of eight seeds; in five other scenes
/// with caustics, for none of eight seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanInterval {
    /// Mean luminance (W·m⁻²·sr⁻¹).
    pub mean: f64,
    /// Half-width (W·m⁻²·sr⁻¹).
    pub half_width: f64,
}

/// Typed view of a film's records.
///
/// Pixels are addressed by their index in the order of [`Window::pixels`](super::Window::pixels),
/// except in [`Self::at`]. All methods panic if there is no such pixel.
///
/// # Example
/// ```
/// use tashika_film::film::{Claim, Film, PixelRecord, RenderFilm, Stop, Window};
///
/// let size = [2, 1];
/// let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES)?;
/// let record = PixelRecord { claim: Claim::Exact, stop: Stop::Complete, ..Default::default() };
/// record.store(&mut film, 1, 0);
/// let read = RenderFilm::of(&film);
/// assert_eq!(read.at(1, 0), record);
/// assert_eq!((read.tally().of(Claim::Exact), read.tally().not_rendered), (1, 1));
/// # Ok::<(), tashika_film::error::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RenderFilm<'f> {
    film: &'f Film,
    claims: Option<&'f [u32]>,
    stops: Option<&'f [u32]>,
    half_widths: Option<&'f [f32]>,
    colors: Option<(&'f Plane, [usize; 3])>,
}

impl<'f> RenderFilm<'f> {
    /// Makes a view of the film in constant time.
    pub fn of(film: &'f Film) -> Self {
        let single = |spec: PlaneSpec| film.plane(spec).filter(|plane| plane.channels().len() == 1);
        Self {
            film,
            claims: single(planes::CLAIM).and_then(Plane::u32_samples),
            stops: single(planes::STOP).and_then(Plane::u32_samples),
            half_widths: single(planes::HALF_WIDTH).and_then(Plane::f32_samples),
            colors: film.plane(planes::RADIANCE).and_then(|plane| Some((plane, plane.color_channels()?))),
        }
    }

    /// Record of a pixel in coordinates of the full image; fields whose plane the film lacks are
    /// zero.
    pub fn at(&self, x: u32, y: u32) -> PixelRecord {
        PixelRecord::load(self.film, x, y).as_told()
    }

    /// Number of pixels, rendered or not.
    pub fn pixels(&self) -> usize {
        self.film.window().area() as usize
    }

    /// Returns true if the film has a map of half-widths: some pixel claims an interval, or all
    /// pixels are exact.
    pub fn has_map(&self) -> bool {
        let mut claims = (0..self.pixels()).map(|pixel| self.claim(pixel));
        let is_map = claims.clone().any(Claim::states_interval) || claims.all(|claim| claim == Claim::Exact);
        self.has_half_widths() && is_map
    }

    /// Returns true if the film has a plane of reasons why work ended. Only this plane marks pixels
    /// that were not rendered.
    pub fn has_stops(&self) -> bool {
        self.stops.is_some()
    }

    /// Returns true if the film has a plane of claims.
    pub fn has_claims(&self) -> bool {
        self.claims.is_some()
    }

    /// Returns true if the film has a plane of half-widths.
    pub fn has_half_widths(&self) -> bool {
        self.half_widths.is_some()
    }

    /// Reason why work on the pixel ended: [`Stop::Complete`] in a film without the plane `stop`,
    /// and [`Stop::NotFinite`] for every rendered pixel whose colour is infinite or not a number.
    pub fn stop(&self, pixel: usize) -> Stop {
        let said = self.stops.map_or(Stop::Complete, |stops| Stop::of_id(stops[pixel]));
        let is_finite = || self.color(pixel).is_none_or(Rgb::is_finite);
        if said == Stop::NotRendered || is_finite() { said } else { Stop::NotFinite }
    }

    /// Returns true if the pixel was rendered.
    pub fn is_rendered(&self, pixel: usize) -> bool {
        self.stops.is_none_or(|stops| Stop::of_id(stops[pixel]) != Stop::NotRendered)
    }

    /// Claim of the pixel; in a film without the plane `claim`, [`Claim::Published`] if it has
    /// half-widths.
    pub fn claim(&self, pixel: usize) -> Claim {
        match (self.claims, self.half_widths) {
            (Some(claims), _) => Claim::of_id(claims[pixel]),
            (None, Some(_)) => Claim::Published,
            (None, None) => Claim::None,
        }
    }

    /// Claimed half-width of the pixel (W·m⁻²·sr⁻¹), 0 if it is exact; `None` if nothing is
    /// claimed, or the film has no half-widths.
    pub fn half_width(&self, pixel: usize) -> Option<f32> {
        let half_widths = self.half_widths?;
        self.claim(pixel).is_some().then(|| half_widths[pixel])
    }

    /// Half-width relative to the pixel's own colour, in the error metric of the film. The result
    /// is 0 for a half-width of 0. For any other half-width it is infinite at a black pixel; a
    /// colour that is NaN counts as black. `None` without a half-width or without colours.
    pub fn relative_half_width(&self, pixel: usize) -> Option<f64> {
        let (half_width, color) = (self.half_width(pixel)?, self.color(pixel)?);
        let size = self.controlled().size_and_distance(color, color).0;
        Some(if half_width == 0.0 { 0.0 } else { f64::from(half_width) / size })
    }

    /// Error metric of the film; luminance if the metadata do not name one.
    pub fn controlled(&self) -> Controlled {
        self.film.metadata().text(keys::CONTROL).and_then(Controlled::named).unwrap_or_default()
    }

    /// Numbers of pixels by claim.
    pub fn tally(&self) -> Tally {
        let mut tally = Tally::default();
        for pixel in 0..self.film.window().area() as usize {
            tally.count(self.claim(pixel), self.stop(pixel));
        }
        tally
    }

    /// Interval of the mean luminance of the rendered pixels. `None` if a rendered pixel has no
    /// finite half-width, claims nothing, or has an audited claim, which is not about the single
    /// pixel.
    pub fn mean_interval(&self) -> Option<MeanInterval> {
        let mut sums = [0.0; 2];
        let mut rendered = 0_u64;
        for pixel in (0..self.pixels()).filter(|pixel| self.is_rendered(*pixel)) {
            let claims = ![Claim::None, Claim::Audited].contains(&self.claim(pixel));
            let half_width = self.half_width(pixel).filter(|h| claims && h.is_finite())?;
            sums[0] += f64::from(self.color(pixel)?.luminance());
            sums[1] += f64::from(half_width);
            rendered += 1;
        }
        let [mean, half_width] = sums.map(|sum| sum / rendered as f64);
        (rendered > 0).then_some(MeanInterval { mean, half_width })
    }

    /// Colour of the pixel (W·m⁻²·sr⁻¹); `None` if the film has no colours.
    pub fn color(&self, pixel: usize) -> Option<Rgb> {
        let (plane, channels) = self.colors?;
        let samples = plane.f32_samples()?;
        let at = pixel * plane.channels().len();
        let [r, g, b] = channels.map(|channel| samples[at + channel]);
        Some(Rgb::new(r, g, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Window;

    fn film(specs: &[PlaneSpec]) -> Film {
        let size = [3, 1];
        Film::new(size, Window::full(size), specs).unwrap()
    }

    #[test]
    fn a_film_of_others_is_whole_and_its_half_widths_are_claims() {
        let bare = film(&[planes::RADIANCE]);
        let read = RenderFilm::of(&bare);
        assert_eq!((read.tally().of(Claim::None), read.half_width(0)), (3, None));
        let mut stated = film(&[planes::RADIANCE, planes::HALF_WIDTH]);
        stated.plane_mut(planes::HALF_WIDTH).unwrap().set_f32(1, 0, &[0.5]);
        let read = RenderFilm::of(&stated);
        assert_eq!((read.tally().of(Claim::Published), read.half_width(1)), (3, Some(0.5)));
        assert!(read.is_rendered(2) && !read.has_stops());
    }

    /// A film of another program, with radiance alone, has one infinite and one NaN pixel. Both
    /// count as not finite although no plane `stop` marks them.
    #[test]
    fn pixels_that_are_not_finite_are_counted_whoever_made_the_film() {
        let mut bare = film(&[planes::RADIANCE]);
        bare.plane_mut(planes::RADIANCE).unwrap().set_f32(1, 0, &[1.0, f32::INFINITY, 0.0]);
        bare.plane_mut(planes::RADIANCE).unwrap().set_f32(2, 0, &[1.0, f32::NAN, 0.0]);
        let read = RenderFilm::of(&bare);
        assert_eq!([0, 1, 2].map(|k| read.stop(k)), [Stop::Complete, Stop::NotFinite, Stop::NotFinite]);
        assert_eq!((read.tally().not_finite, read.tally().rendered()), (2, 3));
    }

    #[test]
    fn the_mean_has_an_interval_if_all_pixels_claim() {
        let mut film = film(PixelRecord::PLANES);
        let of = |luminance: f32, half_width: f32| PixelRecord {
            radiance: Rgb::gray(luminance),
            half_width,
            claim: Claim::Calibrated,
            stop: Stop::RuleMet,
            ..PixelRecord::default()
        };
        of(1.0, 0.2).store(&mut film, 0, 0);
        of(4.0, 0.4).store(&mut film, 1, 0);
        let found = RenderFilm::of(&film).mean_interval().unwrap();
        assert!((found.mean - 2.5).abs() < 1e-6 && (found.half_width - 0.3).abs() < 1e-6, "{found:?}");
        PixelRecord { claim: Claim::None, ..of(0.0, 0.0) }.store(&mut film, 2, 0);
        assert_eq!(RenderFilm::of(&film).mean_interval(), None);
    }

    #[test]
    fn half_widths_are_relative_to_what_is_controlled() {
        let mut film = film(PixelRecord::PLANES);
        let blue = PixelRecord {
            radiance: Rgb::new(0.0, 0.0, 2.0),
            half_width: 0.5,
            claim: Claim::Certified,
            ..PixelRecord::default()
        };
        blue.store(&mut film, 0, 0);
        PixelRecord { claim: Claim::None, ..blue }.store(&mut film, 1, 0);
        PixelRecord { claim: Claim::Exact, half_width: 0.0, ..PixelRecord::default() }.store(&mut film, 2, 0);
        let luminance = RenderFilm::of(&film);
        let of_blue = luminance.relative_half_width(0).unwrap();
        assert!((of_blue - 0.25 / 0.0722).abs() < 1e-3, "{of_blue}");
        assert_eq!((luminance.relative_half_width(1), luminance.relative_half_width(2)), (None, Some(0.0)));
        film.metadata_mut().set(keys::CONTROL, "channels");
        assert_eq!(RenderFilm::of(&film).relative_half_width(0), Some(0.25));
    }
}
