//! What is to be seen of a film as an 8-bit sRGB picture: the
//! [reconstruction](crate::reconstruction), or else the main plane.
//!
//! With radiance `c`, luminance `L(c)` and exposure `e` in stops, a pixel becomes
//!
//! ```text
//! c′ = 2ᵉ c      L′ = L(c′)
//! f(L′) = L′                                    up to the knee K = 0.6
//! f(L′) = K + (1 − K)(1 − exp(−(L′ − K)/(1 − K)))   above
//! c″ = c′ f(L′)/L′, moved towards the gray f(L′) until no channel exceeds 1
//! 8 bits = round(255 · sRGB(c″))
//! ```
//!
//! so that pictures are proportional to radiance up to the knee, which the shoulder meets with the
//! same slope, and hue and luminance are those of the radiance where the gamut allows.
//!
//! [`Exposure::Auto`] puts the log-average luminance of the pixels that are not black at middle gray
//! ([`automatic_stops`]). It depends on nothing but the samples.
//!
//! The file says that it is sRGB. The picture shows the film's window. Pixels that were not
//! rendered, which a plane `stop` marks by 0, are transparent and left out of the average.
//!
//! # Guarantee
//! Black stays black, a brighter gray is never darker, infinite radiance is white. Equal films give
//! equal bytes.
//!
//! # Held to this by
//! The tests below.

use std::path::Path;

use super::output::write_file;
use crate::color::{Rgb, srgb_encode};
use crate::error::{Error, Location, Result};
use crate::film::{Film, Plane, RenderFilm, automatic_stops, srgb_png};
use crate::math::elementary::{exp, powf};
use crate::reconstruction::seen;

/// Luminance up to which pictures are proportional to radiance; chosen so that a white wall at
/// three times middle gray is still in proportion.
const KNEE: f32 = 0.6;

/// How bright the picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// By the log-average of the film.
    #[default]
    Auto,
    /// Radiance times two to this power. Higher values are brighter; at 0, radiance 1 is near
    /// white. Accepted: −64 to 64.
    Stops(f32),
}

/// How radiance becomes a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMap {
    /// How bright the picture is. Default: automatic.
    pub exposure: Exposure,
}

impl ToneMap {
    /// # Errors
    /// [`Error::Option`] for an exposure out of range.
    pub fn validate(&self) -> Result<()> {
        match self.exposure {
            Exposure::Stops(stops) if stops.is_nan() || stops.abs() > 64.0 => {
                Err(Error::option("exposure", stops, "auto, or stops from -64 to 64"))
            }
            Exposure::Auto | Exposure::Stops(_) => Ok(()),
        }
    }
}

/// Writes what is to be seen of a film as a PNG file; returns the exposure used (stops).
///
/// # Errors
/// [`Error::Invalid`] if the film has no main plane of colours, [`Error::Option`] for an exposure out of
/// range, [`Error::Io`] if the file cannot be written.
pub fn write_png(path: &Path, film: &Film, tone_map: &ToneMap) -> Result<f32> {
    let (bytes, stops) = encode_png(path, film, tone_map)?;
    write_file(path, &bytes)?;
    Ok(stops)
}

/// What is to be seen of a film as the bytes of a PNG file, and the exposure used (stops); `path`
/// is for messages.
///
/// # Errors
/// As [`write_png`], but for what concerns files.
pub fn encode_png(path: &Path, film: &Film, tone_map: &ToneMap) -> Result<(Vec<u8>, f32)> {
    let Some(colors) = seen(film).and_then(Plane::colors) else {
        let planes: Vec<&str> = film.planes().iter().map(|p| p.name()).collect();
        let found = format!("a film of the planes {planes:?}");
        return Err(Error::invalid(
            Location::file(path),
            found,
            "a main plane with channels R, G, B or one channel",
        ));
    };
    let pixels: Vec<(Rgb, bool)> = colors.zip(rendered(film)).collect();
    let stops = match tone_map.exposure {
        Exposure::Auto => {
            let shown = pixels.iter().filter(|(_, rendered)| *rendered);
            automatic_stops(shown.map(|(color, _)| color.luminance()))
        }
        Exposure::Stops(stops) if stops.abs() <= 64.0 => stops,
        Exposure::Stops(stops) => {
            return Err(Error::option("exposure", stops, "auto, or stops from -64 to 64"));
        }
    };
    let scale = powf(2.0, stops);
    let bytes = |(color, rendered): (Rgb, bool)| {
        let [r, g, b] = display(color, scale).to_array().map(|v| to_8_bits(srgb_encode(v)));
        [r, g, b, if rendered { 255 } else { 0 }]
    };
    let samples: Vec<u8> = pixels.into_iter().flat_map(bytes).collect();
    let window = film.window();
    Ok((srgb_png([window.width, window.height], &samples), stops))
}

/// Whether each pixel was rendered, in the order of [`Plane::colors`].
fn rendered(film: &Film) -> Vec<bool> {
    let read = RenderFilm::of(film);
    (0..film.window().area() as usize).map(|pixel| read.is_rendered(pixel)).collect()
}

/// Radiance to display-linear colour in `[0, 1]`.
fn display(radiance: Rgb, scale: f32) -> Rgb {
    // Brighter than this is white whatever the hue, and sums of channels stay finite.
    let c = radiance.map(|v| if v > 0.0 { (v * scale).min(1e30) } else { 0.0 });
    let luminance = c.luminance();
    if luminance <= 0.0 {
        return Rgb::BLACK;
    }
    let shown = shoulder(luminance);
    let c = c * (shown / luminance);
    let largest = c.max_channel();
    if largest <= 1.0 {
        return c;
    }
    let towards_gray = (largest - 1.0) / (largest - shown);
    c.lerp(Rgb::gray(shown), towards_gray).map(|v| v.clamp(0.0, 1.0))
}

/// `f` of the module's formula.
fn shoulder(luminance: f32) -> f32 {
    if luminance <= KNEE {
        luminance
    } else {
        KNEE + (1.0 - KNEE) * (1.0 - exp(-(luminance - KNEE) / (1.0 - KNEE)))
    }
}

fn to_8_bits(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{PlaneSpec, SampleKind, Window, planes};

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

    /// A film of one row; the fourth number says whether the pixel was rendered.
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
        let (png, stops) = encode_png(Path::new("a.png"), &film(pixels), &ToneMap { exposure }).unwrap();
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
        // sRGB of 0.25, 0.5, 0.1 by the standard: 0.5371, 0.7354, 0.3492.
        assert_eq!(p, [[0, 0, 0, 255], [137, 137, 137, 255], [188, 89, 0, 255]]);
        let (p, _) = picture(&[gray(1.0)], Exposure::Stops(-2.0));
        assert_eq!(p[0][0], 137, "two stops are a factor of four");
    }

    #[test]
    fn more_light_is_never_darker_and_the_knee_is_smooth() {
        let steps: Vec<f32> = (0..4000).map(|i| powf(10.0, i as f32 / 400.0 - 5.0)).collect();
        assert!(steps.windows(2).all(|w| shoulder(w[1]) >= shoulder(w[0])));
        let (shown, _) = picture(&steps.iter().map(|&v| gray(v)).collect::<Vec<_>>(), Exposure::Stops(0.0));
        assert!(shown.windows(2).all(|w| w[1] >= w[0]));
        assert_eq!((shown[0][0], shown[3999][0]), (0, 255), "from black to white");
        let slope = |a: f32, b: f32| (shoulder(b) - shoulder(a)) / (b - a);
        // The curve's second derivative above the knee is at most 1/(1 − K) = 2.5.
        assert!((slope(KNEE - 0.01, KNEE) - slope(KNEE, KNEE + 0.01)).abs() < 2.5 * 0.01);
    }

    #[test]
    fn hue_and_luminance_survive_where_the_gamut_allows() {
        let bright = display(Rgb::new(8.0, 0.5, 0.1), 1.0);
        let luminance = Rgb::new(8.0, 0.5, 0.1).luminance();
        assert!((bright.luminance() - shoulder(luminance)).abs() < 1e-6);
        assert_eq!(bright.max_channel(), bright.r);
        assert!(bright.r <= 1.0 && bright.r > bright.g && bright.g > bright.b, "{bright:?}");
        // The direction from gray is that of the radiance: (c − L) in the same proportions.
        let ratio = |c: Rgb| (c.r - c.luminance()) / (c.b - c.luminance());
        assert!((ratio(bright) - ratio(Rgb::new(8.0, 0.5, 0.1))).abs() < 1e-4 * ratio(bright).abs());
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
        let stops = ToneMap { exposure: Exposure::Stops(f32::NAN) };
        assert!(encode_png(Path::new("a.png"), &self::film(&[gray(1.0)]), &stops).is_err());
    }
}
