//! Writes a film as the bytes of an OpenEXR file.

use std::io::Cursor;
use std::path::Path;

use ::exr::image::write::WritableImage;
use ::exr::image::{AnyChannel, AnyChannels, FlatSamples, Image, Layer, Layers};
use ::exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds, Text};
use ::exr::meta::header::{ImageAttributes, LayerAttributes};
use ::exr::prelude::Vec2;

use super::{ExrLayout, PLANES, PREFIX, PlaneRecord, at};
use crate::color::Controlled;
use crate::error::Result;
use crate::film::{
    CRYPTOMATTE, Claim, Film, Plane, RenderFilm, Samples, Stop, Value, channel_name, keys,
    percent_of_tolerance, planes,
};
use crate::io::output::write_file;

/// Rec. 709 / sRGB primaries and white.
const PRIMARIES: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

/// Name of the main plane's part, if each plane is a part.
const MAIN_PART: &str = "rgb";

/// Writes a film; an earlier file is replaced only when the new one is complete.
///
/// # Errors
/// [`Error::Io`](crate::error::Error::Io) if the file cannot be written.
pub fn write_exr(path: &Path, film: &Film) -> Result<()> {
    write_exr_as(path, film, &ExrLayout::default())
}

/// Writes a film like [`write_exr`], in a given layout.
///
/// # Errors
/// As [`write_exr`].
pub fn write_exr_as(path: &Path, film: &Film, layout: &ExrLayout) -> Result<()> {
    let bytes = encode(film, layout).map_err(|e| at(path, e))?;
    write_file(path, &bytes)
}

pub(super) fn encode(film: &Film, layout: &ExrLayout) -> ::exr::error::Result<Vec<u8>> {
    let window = film.window();
    let size = Vec2(window.width as usize, window.height as usize);
    let of_part = |name: Option<&str>, planes: &[Plane]| {
        let attributes = LayerAttributes {
            layer_name: name.map(text),
            layer_position: Vec2(window.x as i32, window.y as i32),
            software_name: Some(text(concat!("tashika ", env!("CARGO_PKG_VERSION")))),
            ..LayerAttributes::default()
        };
        let channels = AnyChannels::sort(planes.iter().flat_map(channels).collect());
        Layer::new(size, attributes, layout.encoding(), channels)
    };
    let mut parts: Layers<_> = if layout.parts {
        let name = |plane: &Plane| if plane.name().is_empty() { MAIN_PART } else { plane.name() }.to_owned();
        film.planes().iter().map(|plane| of_part(Some(&name(plane)), std::slice::from_ref(plane))).collect()
    } else {
        [of_part(None, film.planes())].into_iter().collect()
    };
    // Attributes of all planes are stored in the first part, because programs that read a single
    // part read the first.
    if let Some(first) = parts.first_mut() {
        first.attributes.comments = comments(film).as_deref().map(text);
        describe(film, &mut first.attributes);
    }
    let [width, height] = film.size();
    let display = IntegerBounds::new(Vec2(0, 0), Vec2(width as usize, height as usize));
    let mut shared = ImageAttributes::new(display);
    shared.chromaticities = Some(PRIMARIES);
    let mut bytes = Cursor::new(Vec::new());
    let count = parts.len();
    Image::from_layers(shared, parts).write().to_buffered(&mut bytes)?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes, count);
    Ok(bytes)
}

/// Channels of a plane, by their full names.
fn channels(plane: &Plane) -> impl Iterator<Item = AnyChannel<FlatSamples>> {
    let count = plane.channels().len();
    plane.channels().iter().enumerate().map(move |(c, channel)| {
        let samples = match plane.samples() {
            Samples::F32(s) => FlatSamples::F32(s.iter().skip(c).step_by(count).copied().collect()),
            Samples::U32(s) => FlatSamples::U32(s.iter().skip(c).step_by(count).copied().collect()),
        };
        // The short name (such as `R`) is passed to `new`: it decides the lossy compression that
        // other programs may apply to the channel. The full name is set afterwards.
        let full_name = text(&channel_name(plane.name(), channel));
        AnyChannel { name: full_name, ..AnyChannel::new(text(channel), samples) }
    })
}

/// Adds descriptions of the planes, and the metadata of the film.
fn describe(film: &Film, attributes: &mut LayerAttributes) {
    let record = |plane: &Plane| PlaneRecord {
        name: plane.name().to_owned(),
        channels: plane.channels().to_vec(),
        unit: plane.unit().to_owned(),
        doc: plane.doc().to_owned(),
    };
    let records: Vec<PlaneRecord> = film.planes().iter().map(record).collect();
    let planes = serde_json::to_string(&records).expect("words and lists of words");
    attributes.other.insert(text(PLANES), AttributeValue::Text(text(&planes)));
    for (name, value) in film.metadata().iter() {
        let prefix = if name.starts_with(CRYPTOMATTE) { "" } else { PREFIX };
        attributes.other.insert(text(&format!("{prefix}{name}")), attribute(value));
    }
}

/// Contents and claim of the image, in a line of ASCII; none for a film without scene or method.
fn comments(film: &Film) -> Option<String> {
    let metadata = film.metadata();
    let (scene, method) = (metadata.text(keys::SCENE)?, metadata.text(keys::METHOD)?);
    let mut line = format!("{scene} by {method}: radiance in W/(m^2 sr), linear Rec. 709");
    if let Some(error) = metadata.number(keys::ERROR) {
        let truth = match metadata.text(keys::TRUTH) {
            Some("transport") => "light transport",
            Some("clamped") => "what its virtual point lights give on average",
            _ => "the sum over its virtual point lights",
        };
        let read = RenderFilm::of(film);
        let what = match read.controlled() {
            Controlled::Luminance => "luminance",
            Controlled::Channels => "each channel",
        };
        line += &format!("; {what} within {} of {truth}", percent_of_tolerance(error));
        if let Some(absolute) = metadata.number(keys::ERROR_ABSOLUTE).filter(|absolute| *absolute > 0.0) {
            line += &format!(", or {absolute} where it is dark,");
        }
        if let Some(confidence) = metadata.number(keys::CONFIDENCE) {
            line += &format!(" at {}", percent_of_tolerance(confidence));
        }
        let (claim, stop) = (planes::CLAIM, planes::STOP);
        line += &format!(
            " in each pixel whose {} is not {} and whose {} is not {}",
            channel_name(claim.name, claim.channels[0]),
            Claim::None.id(),
            channel_name(stop.name, stop.channels[0]),
            Stop::Budget.id()
        );
    }
    if metadata.bool(keys::COMPLETE) == Some(false) {
        line += "; NOT COMPLETE";
    }
    Some(line)
}

/// Sorts the attributes of each part of a file by name.
///
/// The writer stores custom attributes in a hash table, whose order differs each time. Sorting does
/// not change the length of a header, so all offsets stay valid.
fn sort_attributes(file: &mut [u8], parts: usize) {
    // Magic number and version; then, for each part, its attributes and a zero. An attribute is its
    // name and type, each ended by a zero, its length, and its bytes.
    let mut start = 8;
    for _ in 0..parts {
        let mut end = start;
        let mut attributes = Vec::new();
        while file[end] != 0 {
            let begin = end;
            for _ in 0..2 {
                end += file[end..].iter().position(|&b| b == 0).expect("a name ends with a zero") + 1;
            }
            let length = u32::from_le_bytes(file[end..end + 4].try_into().expect("four bytes"));
            end += 4 + length as usize;
            attributes.push(file[begin..end].to_vec());
        }
        attributes.sort();
        file[start..end].copy_from_slice(&attributes.concat());
        start = end + 1;
    }
}

fn attribute(value: &Value) -> AttributeValue {
    let short = |number: &i64| i32::try_from(*number).ok();
    match value {
        Value::Text(words) => AttributeValue::Text(text(words)),
        Value::Int(number) => {
            short(number).map_or_else(|| AttributeValue::Text(text(&number.to_string())), AttributeValue::I32)
        }
        Value::Float(number) => AttributeValue::F64(*number),
        Value::Bool(yes) => AttributeValue::Text(text(&yes.to_string())),
    }
}

/// Text in UTF-8. The format leaves the encoding open, but its reference library has specified
/// UTF-8 since version 3.0.
fn text(words: &str) -> Text {
    Text::from_slice_unchecked(words.as_bytes())
}
