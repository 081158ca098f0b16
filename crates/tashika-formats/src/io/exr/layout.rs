//! Layout of an OpenEXR file: image, planes and metadata, checked before a sample is read.
//!
//! The reader of whole files and the reader of rows on demand share this layout, so that they
//! cannot disagree about it.
//!
//! # Guarantee
//! A file that passes [`checked_header`] claims no more samples than its bytes could hold, and is
//! flat and not subsampled.
//!
//! # Held to this by
//! The module's tests: files of other programs, damaged files, and headers that claim more samples
//! than the bytes can hold.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, SampleType, Text};
use ::exr::prelude::Vec2;

use super::{PLANES, PREFIX, PlaneRecord, at, truncated, unsupported};
use crate::error::{Error, Location, Result};
use crate::film::{CRYPTOMATTE, Film, Metadata, SampleKind, Value, Window, channel_name};

/// Largest accepted ratio of bytes of samples to bytes of the file. The format's compressions reach
/// about this ratio: ZIP's limit is 1032, DWA's 64 times that.
const MAX_EXPANSION: u64 = 1 << 16;

/// A plane of an OpenEXR file, apart from its samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrPlane {
    /// Name; empty for the main plane.
    pub name: String,
    /// Names of the channels, at least one.
    pub channels: Vec<String>,
    /// Unit of all channels; empty if the file gives none.
    pub unit: String,
    /// Meaning of the numbers; empty if the file gives none.
    pub doc: String,
    /// Type of the samples in a film; 16-bit samples become 32-bit ones.
    pub kind: SampleKind,
    /// Places of the channels in the file.
    pub(super) places: Vec<Place>,
}

/// A channel of a file: its part, and its index in the header of that part.
pub(super) type Place = [usize; 2];

/// Properties of a file, apart from its samples.
#[derive(Debug)]
pub(super) struct Layout {
    pub(super) size: [u32; 2],
    pub(super) window: Window,
    /// First column and row of the file's data that are inside the image. Data outside are not
    /// loaded.
    pub(super) offset: [usize; 2],
    pub(super) planes: Vec<ExrPlane>,
    pub(super) metadata: Metadata,
    /// Number of parts, counted from the first, that hold the channels of these planes.
    pub(super) parts: usize,
}

/// Place of a channel, and the type of its samples.
type Channel = (Place, SampleKind);

impl Layout {
    /// Layout of a file. All parts of a film written by this program form one image. If another
    /// program wrote the file, only its first part is read.
    pub(super) fn of(path: &Path, meta: &MetaData) -> Result<Self> {
        let header = &meta.headers[0];
        let is_ours =
            header.own_attributes.other.contains_key(&Text::from_slice_unchecked(PLANES.as_bytes()));
        let parts = if is_ours { meta.headers.len() } else { 1 };
        for part in &meta.headers[1..parts] {
            if part.data_window() != header.data_window() {
                let found = format!(
                    "parts of a film with the data windows {:?} and {:?}",
                    header.data_window(),
                    part.data_window()
                );
                return Err(Error::invalid(Location::file(path), found, "one for all of them"));
            }
        }
        let (size, window, offset) =
            windows(path, header.shared_attributes.display_window, header.data_window())?;
        let kind = |t| if t == SampleType::U32 { SampleKind::U32 } else { SampleKind::F32 };
        let mut channels: BTreeMap<String, Channel> = BTreeMap::new();
        for (number, part) in meta.headers[..parts].iter().enumerate() {
            let listed = part.channels.list.iter().enumerate();
            channels.extend(listed.map(|(i, c)| (string(&c.name), ([number, i], kind(c.sample_type)))));
        }
        let mut planes = Vec::new();
        let mut metadata = Metadata::default();
        let attributes = header.own_attributes.other.iter();
        for (name, value) in attributes {
            let name = string(name);
            let own = name.strip_prefix(PREFIX);
            if name == PLANES {
                planes = recorded_planes(path, value, &mut channels)?;
            } else if let Some(name) = own.or(Some(&*name).filter(|name| name.starts_with(CRYPTOMATTE)))
                && let Some(value) = metadata_value(value)
            {
                let fits = !name.is_empty() && name.len() <= Metadata::MAX_NAME_BYTES;
                if fits && name.bytes().all(|b| b.is_ascii_graphic()) {
                    metadata.set(name, value);
                }
            }
        }
        for plane in gathered_planes(channels) {
            if planes.iter().any(|p: &ExrPlane| p.name == plane.name) {
                let found = format!("channels of plane {:?} that {PLANES} does not name", plane.name);
                return Err(Error::invalid(Location::file(path), found, "all channels of a plane, or none"));
            }
            planes.push(plane);
        }
        Ok(Self { size, window, offset, planes, metadata, parts })
    }
}

/// Rejects sizes that the bytes cannot hold and unsupported kinds of data, before memory is
/// allocated.
pub(in crate::io) fn check_claims(path: &Path, bytes: &[u8]) -> Result<()> {
    checked_header(path, &mut &bytes[..], bytes.len() as u64).map(drop)
}

/// Reads the header of a file of `length` bytes, with the checks of [`check_claims`]. Damaged
/// attributes are omitted.
pub(super) fn checked_header(path: &Path, read: &mut impl Read, length: u64) -> Result<MetaData> {
    let meta = MetaData::read_from_buffered(read, false).map_err(|e| at(path, e))?;
    MetaData::validate(&meta.headers, false).map_err(|e| at(path, e))?;
    let mut claimed = 0_u64;
    for header in &meta.headers {
        if header.deep {
            return Err(unsupported(path, "deep data"));
        }
        if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
            return Err(unsupported(path, "a subsampled channel"));
        }
        let Vec2(width, height) = header.layer_size;
        let samples = (width as u64).saturating_mul(height as u64);
        claimed = claimed.saturating_add(samples.saturating_mul(4 * header.channels.list.len() as u64));
        if claimed > length.saturating_mul(MAX_EXPANSION) {
            return Err(truncated(path, format!("an image of {width}x{height} in {length} bytes")));
        }
    }
    Ok(meta)
}

/// Size of the image, the film's window, and the window's first column and row in the file's data.
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

/// Planes that the file lists; their channels are removed from `channels`.
fn recorded_planes(
    path: &Path,
    attribute: &AttributeValue,
    channels: &mut BTreeMap<String, Channel>,
) -> Result<Vec<ExrPlane>> {
    let damaged = |found: String| {
        let at = Location::file(path).item(PLANES);
        Error::invalid(at, found, "a list of the file's planes with name, channels, unit, doc")
    };
    let AttributeValue::Text(json) = attribute else {
        return Err(damaged("not a string".to_owned()));
    };
    let records: Vec<PlaneRecord> =
        serde_json::from_slice(json.as_slice()).map_err(|e| damaged(e.to_string()))?;
    let mut planes: Vec<ExrPlane> = Vec::new();
    for PlaneRecord { name, channels: own, unit, doc } in records {
        if own.is_empty() || planes.iter().any(|p| p.name == name) {
            return Err(damaged(format!("plane {name:?} without channels, or twice")));
        }
        let mut taken = Vec::new();
        for channel in &own {
            let full = channel_name(&name, channel);
            taken.push(channels.remove(&full).ok_or_else(|| damaged(format!("no channel {full:?}")))?);
        }
        let kind = taken[0].1;
        if taken.iter().any(|channel| channel.1 != kind) {
            return Err(damaged(format!("plane {name:?} of two kinds of samples")));
        }
        let places = taken.into_iter().map(|channel| channel.0).collect();
        planes.push(ExrPlane { name, channels: own, unit, doc, kind, places });
    }
    Ok(planes)
}

/// Groups channels into planes by the part of their names before the last dot. Each channel of
/// integers becomes a separate plane.
fn gathered_planes(channels: BTreeMap<String, Channel>) -> Vec<ExrPlane> {
    let mut floats: BTreeMap<String, Vec<(String, Place)>> = BTreeMap::new();
    let mut counts = Vec::new();
    for (name, (place, kind)) in channels {
        let (plane, channel) = name.rsplit_once('.').unwrap_or(("", &name));
        if kind == SampleKind::U32 {
            counts.push((name.clone(), vec![("value".to_owned(), place)]));
        } else {
            floats.entry(plane.to_owned()).or_default().push((channel.to_owned(), place));
        }
    }
    for channels in floats.values_mut() {
        let rank = |name: &str| "RGBA".find(name).filter(|_| name.len() == 1).unwrap_or(usize::MAX);
        channels.sort_by_key(|(name, _)| rank(name));
    }
    let plane = |kind, (name, channels): (String, Vec<(String, Place)>)| {
        let (channels, places) = channels.into_iter().unzip();
        ExrPlane { name, channels, unit: String::new(), doc: String::new(), kind, places }
    };
    let floats = floats.into_iter().map(|p| plane(SampleKind::F32, p));
    floats.chain(counts.into_iter().map(|p| plane(SampleKind::U32, p))).collect()
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

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}
