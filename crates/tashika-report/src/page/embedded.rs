//! Films as text inside of a page.
//!
//! The samples of a plane, channel after channel, are split into their four bytes (all lowest bytes
//! first). Each byte is replaced by its difference from the preceding one; the bytes are compressed
//! (zlib) and written in base 64. Neighbouring pixels agree in most of their upper bytes, so that
//! images of 640 × 360 pixels take approximately 2 bytes a sample.
//!
//! Only planes that the schema marks for pages are written. A plane that two images share is
//! written once.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use serde_json::{Map, Value as Json};

use super::Shown;
use crate::color::Rgb;
use crate::film::{
    CRYPTOMATTE, Film, Plane, PlaneSpec, RenderFilm, SCHEMA, SampleKind, Samples, Tone, ToneMap, Value,
    planes, srgb_png,
};
use crate::own_error::OwnError;
use crate::{count, least_certain};

/// Largest number of pixels of all images of a page together; 300,000 with eleven channels are
/// approximately 9 MB.
const MOST_PIXELS: u64 = 300_000;

/// Images of a page as text.
#[derive(Default)]
pub(super) struct Embedded {
    /// Images for the scripts of the page.
    pub images: Vec<Image>,
    /// Note for readers, if the page does not hold every pixel.
    pub note: Option<String>,
    /// The first image as a picture, for readers without scripts: a data address of a PNG file.
    pub still: Option<String>,
}

#[derive(Serialize)]
pub(super) struct Image {
    label: String,
    size: [u32; 2],
    window: [u32; 4],
    factor: u32,
    /// Position of the shown pixel inside each block, in reading order of the block's pixels.
    picks: Option<String>,
    metadata: Map<String, Json>,
    planes: Vec<PlaneText>,
}

#[derive(Serialize)]
struct PlaneText {
    name: String,
    channels: Vec<String>,
    unit: String,
    doc: String,
    kind: &'static str,
    data: Option<String>,
    /// Index of an earlier image that has this plane.
    same_as: Option<usize>,
}

/// Encodes the images, which all show the same window.
pub(super) fn embed(shown: &[Shown<'_>], tone: Tone) -> Embedded {
    let Some(first) = shown.first() else { return Embedded::default() };
    let window = first.film.window();
    let mut factor = 1;
    while u64::from(window.width.div_ceil(factor))
        * u64::from(window.height.div_ceil(factor))
        * shown.len() as u64
        > MOST_PIXELS
    {
        factor += 1;
    }
    // All images have the same pixels, so that they can be compared.
    let picks = least_certain(first.film, window, factor);
    let places = (factor > 1).then(|| {
        let place = |&[x, y]: &[u32; 2]| {
            let (u, v) = (x - window.x, y - window.y);
            let across = factor.min(window.width - u / factor * factor);
            v % factor * across + u % factor
        };
        packed(&Samples::U32(picks.iter().map(place).collect()), 1)
    });
    let images = shown.iter().enumerate().map(|(index, image)| {
        let film = image.film;
        // Without a map of half-widths, the standard error is shown instead.
        let has_map = RenderFilm::of(film).has_map();
        let asked_for = SCHEMA.iter().filter(|row| match row.spec.name {
            name if name == planes::HALF_WIDTH.name => has_map,
            name if name == planes::STANDARD_ERROR.name => !has_map && is_some(film, row.spec),
            _ => row.in_pages,
        });
        let mut texts: Vec<PlaneText> = asked_for
            .filter_map(|row| film.plane(row.spec))
            .map(|plane| text(plane, plane.name(), film, &picks))
            .collect();
        if let Some((reference, plane)) = image.reference.and_then(|r| Some((r, r.plane(planes::RADIANCE)?)))
        {
            let PlaneSpec { name, doc, .. } = planes::REFERENCE;
            let same = |other: &Shown<'_>| other.reference.is_some_and(|r| std::ptr::eq(r, reference));
            let mut plane = match shown[..index].iter().position(same) {
                Some(earlier) => PlaneText { same_as: Some(earlier), data: None, ..head(plane, name) },
                None => text(plane, name, reference, &picks),
            };
            plane.doc = doc.to_owned();
            let own_error = OwnError::of(reference);
            if own_error.is_some() {
                let plane = own_error.plane(reference.window());
                texts.push(text(&plane, plane.name(), reference, &picks));
            }
            texts.push(plane);
        }
        Image {
            label: image.label.clone(),
            size: film.size(),
            window: [window.x, window.y, window.width, window.height],
            factor,
            picks: places.clone(),
            metadata: film
                .metadata()
                .iter()
                // Planes of mattes, which these entries describe, are in no page.
                .filter(|(name, _)| !name.starts_with(CRYPTOMATTE))
                .map(|(name, value)| (name.to_owned(), json(value)))
                .collect(),
            planes: texts,
        }
    });
    let note = (factor > 1).then(|| {
        format!(
            "Of each block of {factor}×{factor} pixels this page holds the one that is least certain, of {} in all; \
             `tashika view` shows every pixel of the OpenEXR file.",
            count(window.area())
        )
    });
    let across = [window.width, window.height].map(|side| side.div_ceil(factor));
    Embedded { images: images.collect(), note, still: still(first, &picks, across, tone) }
}

/// Returns true if some sample of a plane is above zero.
fn is_some(film: &Film, spec: PlaneSpec) -> bool {
    film.plane(spec).and_then(Plane::f32_samples).is_some_and(|samples| samples.iter().any(|v| *v > 0.0))
}

/// Picture that the scripts show first.
fn still(shown: &Shown<'_>, picks: &[[u32; 2]], size: [u32; 2], tone: Tone) -> Option<String> {
    let film = shown.film;
    let plane = film.plane(planes::RADIANCE);
    let colors: Vec<Rgb> = plane?.colors()?.collect();
    let read = RenderFilm::of(film);
    let place = |&[x, y]: &[u32; 2]| film.window().index(x, y);
    let pixels: Vec<(Rgb, bool)> =
        picks.iter().map(place).map(|pixel| (colors[pixel], read.is_rendered(pixel))).collect();
    let map = ToneMap { tone, ..ToneMap::default() };
    let (bytes, _) = map.picture(&pixels).expect("the automatic exposure is in range");
    Some(format!("data:image/png;base64,{}", STANDARD.encode(srgb_png(size, &bytes))))
}

fn head(plane: &Plane, name: &str) -> PlaneText {
    PlaneText {
        name: name.to_owned(),
        channels: plane.channels().to_vec(),
        unit: plane.unit().to_owned(),
        doc: plane.doc().to_owned(),
        kind: match plane.kind() {
            SampleKind::F32 => "f32",
            SampleKind::U32 => "u32",
        },
        data: None,
        same_as: None,
    }
}

fn text(plane: &Plane, name: &str, film: &Film, picks: &[[u32; 2]]) -> PlaneText {
    let channels = plane.channels().len();
    let at = |&[x, y]: &[u32; 2]| film.window().index(x, y) * channels;
    let chosen = match plane.samples() {
        Samples::F32(s) => {
            Samples::F32(picks.iter().flat_map(|p| &s[at(p)..at(p) + channels]).copied().collect())
        }
        Samples::U32(s) => {
            Samples::U32(picks.iter().flat_map(|p| &s[at(p)..at(p) + channels]).copied().collect())
        }
    };
    PlaneText { data: Some(packed(&chosen, channels)), ..head(plane, name) }
}

/// Encodes samples as text; see the module.
fn packed(samples: &Samples, channels: usize) -> String {
    let words: Vec<u32> = match samples {
        Samples::F32(s) => s.iter().map(|v| v.to_bits()).collect(),
        Samples::U32(s) => s.clone(),
    };
    let in_order = || (0..channels).flat_map(|c| words.iter().skip(c).step_by(channels));
    let mut before = 0_u8;
    let mut bytes = Vec::with_capacity(4 * words.len());
    for shift in [0, 8, 16, 24] {
        for word in in_order() {
            let byte = (word >> shift) as u8;
            bytes.push(byte.wrapping_sub(before));
            before = byte;
        }
    }
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&bytes).expect("memory takes all bytes");
    STANDARD.encode(encoder.finish().expect("memory takes all bytes"))
}

fn json(value: &Value) -> Json {
    match value {
        Value::Text(text) => Json::from(text.as_str()),
        Value::Int(number) => Json::from(*number),
        Value::Float(number) => Json::from(*number),
        Value::Bool(yes) => Json::from(*yes),
    }
}
