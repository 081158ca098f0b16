//! The bytes of an OpenEXR file to a film.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

use ::exr::image::FlatSamples;
use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::layers::ReadChannels;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use ::exr::prelude::{Vec2, read};

use super::{PLANES, PREFIX, PlaneRecord, at, unsupported};
use crate::error::{Error, Location, Result};
use crate::film::{Film, Metadata, Plane, Samples, Value, Window, channel_name};

/// Largest file that is read (bytes).
const MAX_FILE_BYTES: u64 = 1 << 34;
/// More samples (bytes) for each byte of the file than any of the format's compressions can hold: ZIP's
/// limit is 1032, DWA's 64 times that.
const MAX_EXPANSION: u64 = 1 << 16;

/// Reads a film: one written by [`write_exr`](super::write_exr), or the first flat part of any OpenEXR file.
///
/// In other programs' files channels are gathered into planes by what stands before the last point of
/// their names, 16-bit samples become 32-bit ones, unsigned integers beside floating point are a plane
/// of their own named by the whole channel name, and what lies outside the display window is left out.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, [`Error::Invalid`] if it is damaged, and
/// [`Error::Unsupported`] for deep or subsampled data and images that are too large.
pub fn read_exr(path: &Path) -> Result<Film> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(|e| Error::io(path, e))?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(unsupported(path, format!("a file of more than {MAX_FILE_BYTES} bytes")));
    }
    decode(path, &bytes)
}

pub(super) fn decode(path: &Path, bytes: &[u8]) -> Result<Film> {
    check_claims(path, bytes)?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| at(path, e))?;
    let layer = image.layer_data;
    let display = image.attributes.display_window;
    let (size, window, data_offset) = windows(path, display, layer.absolute_bounds())?;
    let crop = Crop { row: layer.size.0, offset: data_offset, window };
    let mut channels: BTreeMap<String, FlatSamples> =
        layer.channel_data.list.into_iter().map(|c| (string(&c.name), c.sample_data)).collect();

    let mut planes = Vec::new();
    let mut metadata = Metadata::default();
    let named =
        layer.attributes.other.iter().filter(|(name, _)| name.as_slice().starts_with(PREFIX.as_bytes()));
    for (name, value) in named {
        let name = string(name);
        if name == PLANES {
            planes = recorded_planes(path, value, &mut channels, &crop)?;
        } else if let Some(value) = metadata_value(value) {
            let name = &name[PREFIX.len()..];
            let fits = !name.is_empty() && name.len() <= Metadata::MAX_NAME_BYTES;
            if fits && name.bytes().all(|b| b.is_ascii_graphic()) {
                metadata.set(name, value);
            }
        }
    }
    for plane in gathered_planes(channels, &crop) {
        if planes.iter().any(|p: &Plane| p.name() == plane.name()) {
            let found = format!("channels of plane {:?} that {PLANES} does not name", plane.name());
            return Err(Error::invalid(Location::file(path), found, "all channels of a plane, or none"));
        }
        planes.push(plane);
    }
    Ok(Film::from_planes(size, window, planes, metadata))
}

/// Refuses, before memory is taken, sizes that the bytes cannot hold, and what is not read here.
pub(in crate::io) fn check_claims(path: &Path, bytes: &[u8]) -> Result<()> {
    let meta = MetaData::read_from_buffered(bytes, false).map_err(|e| at(path, e))?;
    MetaData::validate(&meta.headers, false).map_err(|e| at(path, e))?;
    for header in &meta.headers {
        if header.deep {
            return Err(unsupported(path, "deep data"));
        }
        if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
            return Err(unsupported(path, "a subsampled channel"));
        }
        let Vec2(width, height) = header.layer_size;
        let samples = (width as u64).saturating_mul(height as u64);
        let claimed = samples.saturating_mul(4 * header.channels.list.len() as u64);
        if claimed > (bytes.len() as u64).saturating_mul(MAX_EXPANSION) {
            let found = format!("an image of {width}x{height} in {} bytes", bytes.len());
            return Err(Error::invalid(Location::file(path), found, "as many bytes as the image needs"));
        }
    }
    Ok(())
}

/// Size of the image, the film's window in it, and where that window begins in the file's data.
fn windows(
    path: &Path,
    display: IntegerBounds,
    data: IntegerBounds,
) -> Result<([u32; 2], Window, [usize; 2])> {
    let (mut size, mut start, mut length, mut offset) = ([0_u32; 2], [0_u32; 2], [0_u32; 2], [0_usize; 2]);
    let axes = |v: Vec2<i32>| [i64::from(v.0), i64::from(v.1)];
    let lengths = |v: Vec2<usize>| [v.0 as i64, v.1 as i64];
    for axis in 0..2 {
        let origin = axes(display.position)[axis];
        let first = axes(data.position)[axis] - origin;
        let last = (first + lengths(data.size)[axis]).min(lengths(display.size)[axis]);
        if last <= first.max(0) {
            let found = "a data window that does not meet the display window";
            return Err(Error::invalid(Location::file(path), found, "pixels inside the display window"));
        }
        size[axis] = u32::try_from(lengths(display.size)[axis]).unwrap_or(u32::MAX);
        start[axis] = first.max(0) as u32;
        length[axis] = (last - first.max(0)) as u32;
        offset[axis] = (-first).max(0) as usize;
    }
    let window = Window { x: start[0], y: start[1], width: length[0], height: length[1] };
    Film::check(size, window)
        .map_err(|_| unsupported(path, format!("an image of {}x{}", size[0], size[1])))?;
    Ok((size, window, offset))
}

/// Which samples of the file's data are kept.
struct Crop {
    /// Samples a row of the data.
    row: usize,
    /// First column and row kept.
    offset: [usize; 2],
    window: Window,
}

impl Crop {
    /// The kept samples of several channels, side by side.
    fn side_by_side<T: Copy + Default>(&self, channels: &[Vec<T>]) -> Vec<T> {
        let mut out = Vec::with_capacity(self.window.area() as usize * channels.len());
        for y in 0..self.window.height as usize {
            let begin = (y + self.offset[1]) * self.row + self.offset[0];
            for i in begin..begin + self.window.width as usize {
                out.extend(channels.iter().map(|c| c[i]));
            }
        }
        out
    }

    fn plane(&self, words: [String; 3], channels: Vec<(String, FlatSamples)>) -> Plane {
        let (names, samples): (Vec<_>, Vec<_>) = channels.into_iter().unzip();
        let samples = if is_u32(&samples[0]) {
            let counts: Vec<Vec<u32>> = samples.into_iter().map(u32_samples).collect();
            Samples::U32(self.side_by_side(&counts))
        } else {
            let floats: Vec<Vec<f32>> = samples.into_iter().map(f32_samples).collect();
            Samples::F32(self.side_by_side(&floats))
        };
        Plane::from_samples(words, names, self.window, samples)
    }
}

/// The planes that the file says it has; takes their channels.
fn recorded_planes(
    path: &Path,
    attribute: &AttributeValue,
    channels: &mut BTreeMap<String, FlatSamples>,
    crop: &Crop,
) -> Result<Vec<Plane>> {
    let damaged = |found: String| {
        let at = Location::file(path).item(PLANES);
        Error::invalid(at, found, "a list of the file's planes with name, channels, unit, doc")
    };
    let AttributeValue::Text(json) = attribute else {
        return Err(damaged("not a string".to_owned()));
    };
    let records: Vec<PlaneRecord> =
        serde_json::from_slice(json.as_slice()).map_err(|e| damaged(e.to_string()))?;
    let mut planes: Vec<Plane> = Vec::new();
    for record in records {
        if record.channels.is_empty() || planes.iter().any(|p| p.name() == record.name) {
            return Err(damaged(format!("plane {:?} without channels, or twice", record.name)));
        }
        let mut taken = Vec::new();
        for channel in record.channels {
            let name = channel_name(&record.name, &channel);
            let samples = channels.remove(&name).ok_or_else(|| damaged(format!("no channel {name:?}")))?;
            taken.push((channel, samples));
        }
        if taken.iter().any(|(_, s)| is_u32(s) != is_u32(&taken[0].1)) {
            return Err(damaged(format!("plane {:?} of two kinds of samples", record.name)));
        }
        planes.push(crop.plane([record.name, record.unit, record.doc], taken));
    }
    Ok(planes)
}

/// Planes by what stands before the last point of the channels' names.
fn gathered_planes(channels: BTreeMap<String, FlatSamples>, crop: &Crop) -> Vec<Plane> {
    let mut floats: BTreeMap<String, Vec<(String, FlatSamples)>> = BTreeMap::new();
    let mut planes = Vec::new();
    for (name, samples) in channels {
        let (plane, channel) = name.rsplit_once('.').unwrap_or(("", &name));
        if is_u32(&samples) {
            planes.push((name.clone(), vec![("value".to_owned(), samples)]));
        } else {
            floats.entry(plane.to_owned()).or_default().push((channel.to_owned(), samples));
        }
    }
    for channels in floats.values_mut() {
        let rank = |name: &str| "RGBA".find(name).filter(|_| name.len() == 1).unwrap_or(usize::MAX);
        channels.sort_by_key(|(name, _)| rank(name));
    }
    floats
        .into_iter()
        .chain(planes)
        .map(|(name, channels)| crop.plane([name, String::new(), String::new()], channels))
        .collect()
}

fn metadata_value(attribute: &AttributeValue) -> Option<Value> {
    match attribute {
        AttributeValue::I32(number) => Some(Value::Int(i64::from(*number))),
        AttributeValue::F64(number) => Some(Value::Float(*number)),
        AttributeValue::F32(number) => Some(Value::Float(f64::from(*number))),
        AttributeValue::Text(words) => {
            let words = string(words);
            let long = words.parse().ok().filter(|&n: &i64| i32::try_from(n).is_err());
            Some(match (words.as_str(), long) {
                ("true", _) => Value::Bool(true),
                ("false", _) => Value::Bool(false),
                (_, Some(number)) if number.to_string() == words => Value::Int(number),
                _ => Value::Text(words),
            })
        }
        _ => None,
    }
}

fn is_u32(samples: &FlatSamples) -> bool {
    matches!(samples, FlatSamples::U32(_))
}

fn f32_samples(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        FlatSamples::F16(values) => values.into_iter().map(|v| v.to_f32()).collect(),
        FlatSamples::U32(values) => values.into_iter().map(|v| v as f32).collect(),
    }
}

fn u32_samples(samples: FlatSamples) -> Vec<u32> {
    match samples {
        FlatSamples::U32(values) => values,
        FlatSamples::F32(_) | FlatSamples::F16(_) => unreachable!("asked for after `is_u32`"),
    }
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}
