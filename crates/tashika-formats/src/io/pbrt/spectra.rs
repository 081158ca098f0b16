//! Colours of parameters: `rgb`, `xyz`, `blackbody`, `spectrum`.
//!
//! All colours become linear RGB with the primaries of Rec. 709, as in pbrt's images. A reflectance
//! or factor of 1 at all wavelengths is white. Radiances, intensities and irradiances have the
//! values that a pixel of pbrt's default film would record:
//!
//! | parameter | pbrt-v3 | pbrt-v4 |
//! |---|---|---|
//! | `rgb` | the value | the value: its factor `1 / ∫ Y E` and the film's response cancel |
//! | `blackbody` | Planck's law, largest value 1, times a scale | Planck's law, luminance 1 |
//! | `spectrum` | as it is | luminance 1: lights are divided by the luminance of their spectrum |
//!
//! `rgb` values are in the primaries of the `ColorSpace` at their place.
//!
//! A `spectrum` is a list that alternates wavelengths (nm) and values, the name of a file with such
//! a list, or a name that [`illuminant_rgb`] accepts. Negative channels of colours outside the
//! gamut are set to 0.
//!
//! Source: Pharr et al. 2023, sections 4.5 and 12.1; pbrt-v3's format description. Tested by
//! `suite::pbrt_appearance::lights_*`, `suite::pbrt_appearance::spectra_*`.

use super::lexer::number;
use super::loading::Loading;
use super::parameters::{Kind, Parameter, Parameters};
use super::version::Version;
use crate::color::spectrum::{
    blackbody_rgb, blackbody_rgb_of_unit_peak, illuminant_rgb, rgb_of_emission, rgb_of_reflectance,
};
use crate::color::{Primaries, Rgb, White, transformed};
use crate::error::{Error, Location, Result};
use crate::io::assets::kind;
use crate::io::notes::excerpt;
use crate::scene::NoteKind;

/// Note about colours below zero.
const NEGATIVE: &str = "colours with negative channels: those are set to 0";

/// All types by which a colour can be given.
pub(super) const SPECTRAL: &[Kind] = &[Kind::Rgb, Kind::Xyz, Kind::Blackbody, Kind::Spectrum];

/// Physical meaning of a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// A fraction or a factor.
    Factor,
    /// Radiance, intensity or irradiance.
    Light,
}

/// XYZ (2° observer) to linear Rec. 709 RGB (ITU-R BT.709-6, white D65), rows.
const RGB_OF_XYZ: [[f32; 3]; 3] = [
    [3.240_97, -1.537_383, -0.498_611],
    [-0.969_244, 1.875_968, 0.041_555],
    [0.055_63, -0.203_977, 1.056_972],
];

/// Reads the colour of a parameter, if it exists.
pub(super) fn color(
    loading: &mut Loading<'_>,
    parameters: &Parameters,
    name: &str,
    quantity: Quantity,
) -> Result<Option<Rgb>> {
    match parameters.find(SPECTRAL, name) {
        Some(parameter) => convert(loading, parameter, quantity).map(Some),
        None => Ok(None),
    }
}

/// Reads a list of `rgb` colours; channels that a wider gamut makes negative are set to 0.
pub(super) fn colors(loading: &mut Loading<'_>, parameters: &Parameters, name: &str) -> Option<Vec<Rgb>> {
    let parameter = parameters.find(&[Kind::Rgb], name)?;
    let of = |c: &[f32; 3]| {
        let color = Rgb::from(*c);
        in_rec709(color, &parameter.primaries, Quantity::Factor).unwrap_or(color)
    };
    let mut colors: Vec<Rgb> = parameter.numbers().as_chunks::<3>().0.iter().map(of).collect();
    if colors.iter().any(|c| !c.is_valid()) {
        loading.note(NoteKind::Repaired, NEGATIVE, parameter.at());
    }
    for color in &mut colors {
        *color = color.map(|v| v.max(0.0));
    }
    Some(colors)
}

/// Converts a parameter of one of the [`SPECTRAL`] types to a colour.
pub(super) fn convert(loading: &mut Loading<'_>, parameter: &Parameter, quantity: Quantity) -> Result<Rgb> {
    let numbers = parameter.numbers();
    let at = parameter.at();
    let found = match (parameter.kind, numbers) {
        (Kind::Rgb, [r, g, b, ..]) => in_rec709(Rgb::new(*r, *g, *b), &parameter.primaries, quantity),
        (Kind::Xyz, [x, y, z, ..]) => {
            let row = |r: [f32; 3]| r[0] * x + r[1] * y + r[2] * z;
            Some(Rgb::new(row(RGB_OF_XYZ[0]), row(RGB_OF_XYZ[1]), row(RGB_OF_XYZ[2])))
        }
        (Kind::Blackbody, [kelvin, rest @ ..]) => match loading.version {
            Version::V3 => {
                blackbody_rgb_of_unit_peak(*kelvin).map(|c| c * rest.first().copied().unwrap_or(1.0))
            }
            Version::V4 => blackbody_rgb(*kelvin),
        },
        (Kind::Spectrum, _) if !parameter.strings().is_empty() => {
            named(loading, &parameter.strings()[0], quantity, &at)?
        }
        (Kind::Spectrum, pairs) => sampled(pairs.as_chunks().0, quantity, loading.version),
        _ => None,
    };
    let Some(found) = found.filter(|c| c.is_finite()) else {
        let expected = match parameter.kind {
            Kind::Blackbody => "a temperature in kelvin",
            Kind::Spectrum => "wavelengths (nm), ascending, each with a value",
            _ => "three finite numbers",
        };
        let found = format!("parameter {:?} that gives no colour", parameter.declaration);
        return Err(Error::invalid(at, found, expected));
    };
    if !found.is_valid() {
        loading.note(NoteKind::Repaired, NEGATIVE, at);
    }
    Ok(found.map(|v| v.max(0.0)))
}

/// Primaries of a `ColorSpace`; those of sRGB for unknown names.
pub(super) fn primaries(color_space: &str) -> Primaries {
    match color_space {
        "rec2020" => Primaries::REC2020,
        "dci-p3" => Primaries::P3,
        "aces2065-1" => Primaries::ACES2065_1,
        _ => Primaries::REC709,
    }
}

/// Converts a colour to Rec. 709. In a space with another white, a reflectance of 1 becomes white,
/// and light of 1 keeps the space's white.
fn in_rec709(color: Rgb, primaries: &Primaries, quantity: Quantity) -> Option<Rgb> {
    if *primaries == Primaries::REC709 {
        return Some(color);
    }
    let white = match quantity {
        Quantity::Factor => White::Adapted,
        Quantity::Light => White::Kept,
    };
    primaries.to_rec709(white).map(|rows| transformed(&rows, color))
}

fn sampled(pairs: &[[f32; 2]], quantity: Quantity, version: Version) -> Option<Rgb> {
    let samples: Vec<(f32, f32)> = pairs.iter().map(|&[nm, value]| (nm, value)).collect();
    match quantity {
        Quantity::Factor => rgb_of_reflectance(&samples),
        Quantity::Light => {
            let emitted = rgb_of_emission(&samples)?;
            let luminance = emitted.luminance();
            match version {
                Version::V4 if luminance > 0.0 => Some(emitted * (1.0 / luminance)),
                _ => Some(emitted),
            }
        }
    }
}

/// Reads a spectrum by its name: an illuminant, or a file of samples.
fn named(loading: &mut Loading<'_>, name: &str, quantity: Quantity, at: &Location) -> Result<Option<Rgb>> {
    if let Some(color) = illuminant_rgb(name) {
        return Ok(Some(match quantity {
            Quantity::Light => color,
            Quantity::Factor => Rgb::WHITE,
        }));
    }
    let is_file = name.contains(['.', '/', '\\']);
    match loading.files.read(name, at) {
        Ok(bytes) => sampled_file(&bytes, name, quantity, loading.version, at).map(Some),
        Err(error) => {
            // A name without a file extension is one of pbrt's built-in spectra.
            let (what, kind) =
                if is_file { ("file of a spectrum", kind(&error)) } else { ("spectrum", NoteKind::Repaired) };
            let message = format!("{what} {:?} is not there: a grey of 0.5 is used", excerpt(name, 60));
            loading.note_named(kind, message, "spectra are not there", at.clone());
            Ok(Some(Rgb::gray(0.5)))
        }
    }
}

/// Reads a file of wavelengths and values, with comments after `#`.
fn sampled_file(
    bytes: &[u8],
    name: &str,
    quantity: Quantity,
    version: Version,
    at: &Location,
) -> Result<Rgb> {
    let lines =
        bytes.split(|&b| b == b'\n').map(|line| line.split(|&b| b == b'#').next().unwrap_or_default());
    let words = lines.flat_map(|line| line.split(|&b| b.is_ascii_whitespace() || b == b','));
    let numbers: Option<Vec<f32>> = words.filter(|w| !w.is_empty()).map(number).collect();
    let color = numbers.and_then(|numbers| sampled(numbers.as_chunks().0, quantity, version));
    color.ok_or_else(|| {
        let found = format!("spectrum file {:?}", excerpt(name, 60));
        Error::invalid(at.clone(), found, "lines of a wavelength (nm), ascending, and a value")
    })
}
