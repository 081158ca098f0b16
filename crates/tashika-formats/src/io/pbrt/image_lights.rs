//! Lights with an image: `goniometric` and `projection`.
//!
//! With `I`, `scale` and `power` as the file gives them:
//!
//! ```text
//! goniometric   intensity   I · scale · map(ω)             · power / ∫ map dω     of pbrt-v4: the mean of the map's channels
//! projection    intensity   scale · map(u, v)              · power / ∫ map dω     of pbrt-v3: times I
//! ```
//!
//! The last factor applies in pbrt-v4 if `power` is given; its integral is over the luminance of
//! the map. Maps of pbrt-v4 are sampled at the nearest texel. Maps of pbrt-v3 are sampled
//! bilinearly and repeat beyond their sides.
//!
//! * A goniometric map is latitude-longitude in pbrt-v3 and octahedral in pbrt-v4. In both the pole
//!   is the light's `+y`. The latitude-longitude map has `u = 0` at the light's `+x` and turns
//!   towards `+z`. Both formats first swap `y` and `z` of a direction, which is a reflection.
//! * A slide shines along `+z`; `fov` spans its shorter side. Its top row lies towards the light's
//!   `−y` in pbrt-v3, and towards `+y` in pbrt-v4.
//!
//! A map that several lights share is kept once. Source: Pharr et al. 2023, chapter 12; the format
//! descriptions. Held to this by `suite::light_images`.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3, Vec3};

use super::lights::{FOUR_PI, LAT_LONG_OF_PBRT, colored, intensity, orthonormal, point, positive, scale};
use super::loading::Loading;
use super::parameters::Parameters;
use super::version::Version;
use crate::color::Rgb;
use crate::error::Result;
use crate::io::images::{Encoding, one_texel};
use crate::io::lights::{BYTES_OF_TEXEL, add_image_light};
use crate::math::elementary::tan;
use crate::scene::{
    Emitter, Image, IntensityMap, Lookup, NoteKind, Pixels, Sampling, SlideWeight, SphereMap, Spread, Wrap,
};

/// Maps of lights read so far, by file and kind; none if the image is black or could not be read.
pub(super) type Maps = std::collections::BTreeMap<(String, MapKind), Option<Arc<IntensityMap>>>;

/// Kinds of map that an image may become.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum MapKind {
    /// Map over all directions.
    Goniometric,
    /// Slide, with its field of view as the bits of an `f32`.
    Slide(u32),
}

/// Range that fields of view are clamped to (degrees).
const FIELD_OF_VIEW: (f32, f32) = (0.1, 179.0);

/// Frame of a light with `y` and `z` swapped.
const SWAPPED: Mat3 = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::Y);

/// Frame turned upside down.
const FLIPPED: Mat3 = Mat3::from_cols(Vec3::X, Vec3::NEG_Y, Vec3::Z);

/// `LightSource "goniometric"`.
pub(super) fn goniometric(loading: &mut Loading<'_>, p: &Parameters, to_world: &DAffine3) -> Result<()> {
    let own = (colored(loading, p, "I")? * scale(loading, p)?, positive(p, "power", loading.version));
    let place = point(to_world, DVec3::ZERO);
    let Some(name) = name_of_map(loading, p) else {
        let intensity = intensity(loading, p, FOUR_PI)?;
        return super::lights::add(
            loading,
            p,
            Emitter::Point { position: place.as_vec3(), intensity },
            place,
        );
    };
    let v4 = loading.version == Version::V4;
    let map = map(loading, p, &name, MapKind::Goniometric, |image| {
        let spread = Spread::Sphere(if v4 { SphereMap::EqualArea } else { SphereMap::LatLong });
        let image = if v4 { grey(&image) } else { image };
        IntensityMap::new(image, spread, lookup(v4))
    })?;
    let frame = if v4 { SWAPPED } else { SWAPPED * LAT_LONG_OF_PBRT };
    let turn = orthonormal(loading, p, to_world);
    add(loading, p, map, own, place, turn * frame)
}

/// `LightSource "projection"`.
pub(super) fn projection(loading: &mut Loading<'_>, p: &Parameters, to_world: &DAffine3) -> Result<()> {
    let v4 = loading.version == Version::V4;
    let factor = if v4 { Rgb::WHITE } else { colored(loading, p, "I")? };
    let own = (factor * scale(loading, p)?, positive(p, "power", loading.version));
    let said = p.float("fov").unwrap_or(if v4 { 90.0 } else { 45.0 });
    let fov = said.clamp(FIELD_OF_VIEW.0, FIELD_OF_VIEW.1);
    if fov != said {
        loading.note(NoteKind::Repaired, "fields of view of projections: moved to 0.1° to 179°", p.at());
    }
    let place = point(to_world, DVec3::ZERO);
    let spread = |image: &Image| {
        let half = tan(0.5 * fov.to_radians());
        let aspect = image.width as f32 / image.height as f32;
        let tan = if aspect > 1.0 { [half * aspect, half] } else { [half, half / aspect] };
        Spread::Slide { tan, weight: SlideWeight::Even }
    };
    let slide = |image: Image| {
        let spread = spread(&image);
        IntensityMap::new(image, spread, lookup(v4))
    };
    let map = match name_of_map(loading, p) {
        Some(name) => map(loading, p, &name, MapKind::Slide(fov.to_bits()), slide)?,
        None => {
            if v4 {
                let message = "projections without an image: a white square";
                loading.note(NoteKind::Repaired, message, p.at());
            }
            slide(one_texel("white", Rgb::WHITE)).map(Arc::new)
        }
    };
    let frame = if v4 { FLIPPED } else { Mat3::IDENTITY };
    let turn = orthonormal(loading, p, to_world);
    add(loading, p, map, own, place, turn * frame)
}

/// Sampling and wrapping of a map in each format.
fn lookup(v4: bool) -> Lookup {
    let sampling = if v4 { Sampling::Nearest } else { Sampling::Bilinear };
    Lookup { sampling, wrap: [if v4 { Wrap::Clamp } else { Wrap::Repeat }; 2] }
}

/// Name of the light's image, if it has one.
fn name_of_map(loading: &Loading<'_>, p: &Parameters) -> Option<String> {
    let name = p.string(if loading.version == Version::V3 { "mapname" } else { "filename" });
    name.filter(|name| !name.is_empty()).map(str::to_owned)
}

/// Returns the map of that name, made once.
fn map(
    loading: &mut Loading<'_>,
    p: &Parameters,
    name: &str,
    kind: MapKind,
    make: impl FnOnce(Image) -> Option<IntensityMap>,
) -> Result<Option<Arc<IntensityMap>>> {
    let key = (name.to_owned(), kind);
    if let Some(known) = loading.maps.get(&key) {
        return Ok(known.clone());
    }
    let at = p.place_of(if loading.version == Version::V3 { "mapname" } else { "filename" });
    let image = loading.images.read(name, Encoding::Srgb, &at, &mut loading.builder)?;
    let mut found = None;
    if let Some(image) = image {
        loading.geometry.take(image.pixels.len() as u64 * BYTES_OF_TEXEL, &at)?;
        found = make(image).map(Arc::new);
    }
    loading.maps.insert(key, found.clone());
    Ok(found)
}

/// Adds a light whose intensity is `intensity` where the map is 1. A `power`, if given, multiplies
/// the intensity by the power over the map's integral.
fn add(
    loading: &mut Loading<'_>,
    p: &Parameters,
    map: Option<Arc<IntensityMap>>,
    (mut intensity, power): (Rgb, Option<f32>),
    place: DVec3,
    to_world: Mat3,
) -> Result<()> {
    // The image was black, or could not be read, which is already noted.
    let Some(map) = map else { return Ok(()) };
    if let Some(power) = power {
        intensity *= power / map.integral().luminance().max(f32::MIN_POSITIVE);
    }
    add_image_light(&mut loading.builder, &map, (place, to_world), intensity, p.at())
}

/// Grey image: each channel is the mean of the three channels of `image`.
fn grey(image: &Image) -> Image {
    let texels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| (x, y)));
    let mean = |(x, y)| {
        let Rgb { r, g, b } = image.texel(x, y).0;
        // Divided first: the sum may overflow.
        [r / 3.0 + g / 3.0 + b / 3.0; 3]
    };
    Image { pixels: Pixels::Float(texels.map(mean).collect()), name: image.name.clone(), ..*image }
}
