//! 8-bit sRGB picture of a film: its radiance, mapped by a [`ToneMap`].
//!
//! The file is marked as sRGB. The picture shows the film's window. Pixels that were not rendered
//! have 0 in the plane `stop`; they are transparent and do not affect the exposure.
//!
//! # Guarantee
//! Equal films give equal bytes.
//!
//! # Held to this by
//! The tests below; tone mappings by those of `film::tone`.

use std::path::Path;

use super::output::write_file;
use crate::color::Rgb;
use crate::error::{Error, Location, Result};
use crate::film::{Film, Plane, RenderFilm, ToneMap, planes, srgb_png};

/// Writes the picture of a film to a PNG file; returns the exposure used (stops).
///
/// # Errors
/// [`Error::Invalid`] if the film has no main plane of colours, [`Error::Option`] for an exposure
/// out of range, [`Error::Io`] if the file cannot be written.
pub fn write_png(path: &Path, film: &Film, tone_map: &ToneMap) -> Result<f32> {
    let (bytes, stops) = encode_png(path, film, tone_map)?;
    write_file(path, &bytes)?;
    Ok(stops)
}

/// Encodes the picture of a film as the bytes of a PNG file; returns them with the exposure used
/// (stops). `path` is for messages.
///
/// # Errors
/// As [`write_png`], except errors of files.
pub fn encode_png(path: &Path, film: &Film, tone_map: &ToneMap) -> Result<(Vec<u8>, f32)> {
    let Some(colors) = film.plane(planes::RADIANCE).and_then(Plane::colors) else {
        let planes: Vec<&str> = film.planes().iter().map(|p| p.name()).collect();
        let found = format!("a film of the planes {planes:?}");
        return Err(Error::invalid(
            Location::file(path),
            found,
            "a main plane with channels R, G, B or one channel",
        ));
    };
    let pixels: Vec<(Rgb, bool)> = colors.zip(rendered(film)).collect();
    let (samples, stops) = tone_map.picture(&pixels)?;
    let window = film.window();
    Ok((srgb_png([window.width, window.height], &samples), stops))
}

/// Returns a flag for each pixel, true if rendered, in the order of [`Plane::colors`].
fn rendered(film: &Film) -> Vec<bool> {
    let read = RenderFilm::of(film);
    (0..film.window().area() as usize).map(|pixel| read.is_rendered(pixel)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Exposure, PlaneSpec, SampleKind, Tone, Window, planes};
    use crate::math::elementary::powf;

    const SPECS: &[PlaneSpec] = &[
        PlaneSpec {
            name: "",
            channels: &["R", "G", "B"],
            unit: "W·m⁻²·sr⁻¹",
            kind: SampleKind::F32,
            doc: "radiance",
        },
        PlaneSpec {
            name: "stop",
            channels: &["id"],
            unit: "1",
            kind: SampleKind::U32,
            doc: "0 not rendered",
        },
    ];

    /// A film of one row; a pixel whose fourth number is 0 was not rendered.
    fn film(pixels: &[[f32; 4]]) -> Film {
        let window = Window { x: 2, y: 1, width: pixels.len() as u32, height: 1 };
        let mut film = Film::new([pixels.len() as u32 + 2, 2], window, SPECS).unwrap();
        for (i, p) in pixels.iter().enumerate() {
            film.plane_mut(planes::RADIANCE).unwrap().set_f32(2 + i as u32, 1, &p[..3]);
            film.plane_mut(planes::STOP).unwrap().set_u32(2 + i as u32, 1, &[p[3] as u32]);
        }
        film
    }

    fn picture(pixels: &[[f32; 4]], exposure: Exposure) -> (Vec<[u8; 4]>, f32) {
        toned(pixels, &ToneMap { exposure, ..ToneMap::default() })
    }

    fn toned(pixels: &[[f32; 4]], map: &ToneMap) -> (Vec<[u8; 4]>, f32) {
        let (png, stops) = encode_png(Path::new("a.png"), &film(pixels), map).unwrap();
        let picture = image::load_from_memory(&png).unwrap().into_rgba8();
        assert_eq!(picture.dimensions(), (pixels.len() as u32, 1), "the window, not the full image");
        (picture.pixels().map(|p| p.0).collect(), stops)
    }

    fn gray(v: f32) -> [f32; 4] {
        [v, v, v, 1.0]
    }

    #[test]
    fn below_the_knee_pixels_are_the_srgb_code_of_the_radiance() {
        let (p, _) = picture(&[gray(0.0), gray(0.25), [0.5, 0.1, 0.0, 1.0]], Exposure::Stops(0.0));
        // sRGB codes of 0.25, 0.5, 0.1 by the standard: 0.5371, 0.7354, 0.3492.
        assert_eq!(p, [[0, 0, 0, 255], [137, 137, 137, 255], [188, 89, 0, 255]]);
        let (p, _) = picture(&[gray(1.0)], Exposure::Stops(-2.0));
        assert_eq!(p[0][0], 137, "two stops are a factor of four");
    }

    #[test]
    fn tones_are_seen_in_the_picture_and_a_ramp_is_one() {
        let ramp: Vec<[f32; 4]> = (0..400).map(|i| gray(powf(10.0, i as f32 / 40.0 - 5.0))).collect();
        for tone in Tone::ALL {
            let map = ToneMap { exposure: Exposure::Stops(0.0), tone };
            let (shown, _) = toned(&ramp, &map);
            assert!(shown.windows(2).all(|w| w[1] >= w[0]), "{tone}");
            assert_eq!((shown[0][0], shown[399]), (0, [255; 4]), "{tone}: from black to white");
            // sRGB code of middle gray under each tone, by the table of `film::tone`.
            let code = [118, 118, 100, 91, 128][tone as usize];
            assert_eq!(toned(&[gray(0.18)], &map).0[0][0], code, "{tone}");
        }
        let same = |a: &ToneMap, b: &ToneMap| toned(&ramp, a).0 == toned(&ramp, b).0;
        let natural = ToneMap { exposure: Exposure::Auto, tone: Tone::Natural };
        assert!(same(&ToneMap::default(), &natural), "the default");
        assert!(!same(&natural, &ToneMap { tone: Tone::Agx, ..natural }));
    }

    #[test]
    fn exposure_ignores_what_was_not_rendered_and_what_is_almost_black() {
        let (_, stops) = picture(&[gray(0.09), gray(0.36)], Exposure::Auto);
        assert!(stops.abs() < 1e-5, "the log-average is middle gray already: {stops}");
        let hidden = [900.0, 900.0, 900.0, 0.0];
        let (p, same) = picture(&[gray(0.09), gray(0.36), hidden, gray(0.0), gray(1e-7)], Exposure::Auto);
        assert_eq!(same, stops);
        assert_eq!(p[2][3], 0, "transparent");
        let (_, brighter) = picture(&[gray(0.09 / 8.0), gray(0.36 / 8.0)], Exposure::Auto);
        assert!((brighter - 3.0).abs() < 1e-5);
    }

    #[test]
    fn black_and_blinding_films_are_pictures_too() {
        let (p, stops) = picture(&[gray(0.0), gray(0.0)], Exposure::Auto);
        assert_eq!((p[0], stops), ([0, 0, 0, 255], 0.0));
        for exposure in [Exposure::Auto, Exposure::Stops(64.0)] {
            let (p, stops) = picture(&[gray(f32::MAX), gray(f32::INFINITY), gray(1e-38)], exposure);
            assert!(stops.is_finite());
            assert_eq!(p[1], [255, 255, 255, 255]);
        }
        let (p, _) = picture(&[[f32::MAX, 0.0, 0.0, 1.0]], Exposure::Stops(0.0));
        assert_eq!(p[0], [255, 255, 255, 255], "too bright for a hue");
    }

    #[test]
    fn what_has_no_colours_is_refused() {
        let specs =
            [PlaneSpec { name: "depth", channels: &["Z"], unit: "m", kind: SampleKind::F32, doc: "Depth." }];
        let film = Film::new([1, 1], Window::full([1, 1]), &specs).unwrap();
        let said = encode_png(Path::new("a.png"), &film, &ToneMap::default()).unwrap_err().to_string();
        assert!(said.contains(r#"a.png: a film of the planes ["depth"]"#), "{said}");
        let stops = ToneMap { exposure: Exposure::Stops(f32::NAN), ..ToneMap::default() };
        assert!(encode_png(Path::new("a.png"), &self::film(&[gray(1.0)]), &stops).is_err());
    }
}
