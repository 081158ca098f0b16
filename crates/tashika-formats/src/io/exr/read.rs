//! Reads an OpenEXR file into a film, all at once.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::layers::ReadChannels;
use ::exr::image::{AnyChannels, FlatSamples, Layer};
use ::exr::prelude::read;

use super::layout::{ExrPlane, Layout, Place, checked_header};
use super::rows::check_places;
use super::{at, unsupported};
use crate::error::{Error, Result};
use crate::film::{Film, Plane, SampleKind, Samples, Window};

/// Largest file that is read (bytes).
const MAX_FILE_BYTES: u64 = 1 << 34;

/// Reads a film: one written by [`write_exr`](super::write_exr) in any layout, or the first flat
/// part of any OpenEXR file.
///
/// In other programs' files, channels are gathered into planes by the part of their names before
/// the last point, and 16-bit samples become 32-bit ones. Each channel of unsigned integers becomes
/// a separate plane with the full name of the channel. Samples outside the display window are
/// omitted.
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
    let mut rest = bytes;
    let meta = checked_header(path, &mut rest, bytes.len() as u64)?;
    let Layout { size, window, offset, planes, metadata, parts } = Layout::of(path, &meta)?;
    check_places(path, bytes, rest, &meta, parts)?;
    let reader = read().no_deep_data().largest_resolution_level().all_channels();
    let bytes = Cursor::new(bytes);
    let layers: Vec<Layer<AnyChannels<FlatSamples>>> = if parts > 1 {
        let image = reader.all_layers().all_attributes().from_buffered(bytes).map_err(|e| at(path, e))?;
        image.layer_data.into_iter().collect()
    } else {
        // All layers are flat, so the first valid layer is the first layer of the file.
        let reader = reader.first_valid_layer().all_attributes();
        vec![reader.from_buffered(bytes).map_err(|e| at(path, e))?.layer_data]
    };
    let crop = Crop { row: layers[0].size.0, offset, window };
    let samples = |layer: Layer<AnyChannels<FlatSamples>>| {
        layer.channel_data.list.into_iter().map(|c| Some(c.sample_data)).collect()
    };
    let mut channels: Vec<Vec<Option<FlatSamples>>> = layers.into_iter().map(samples).collect();
    let planes = planes.into_iter().map(|plane| crop.plane(plane, &mut channels)).collect();
    Ok(Film::from_planes(size, window, planes, metadata))
}

/// Region of the file's data that becomes the film.
struct Crop {
    /// Number of samples in a row of the data.
    row: usize,
    /// First column and row of the region.
    offset: [usize; 2],
    window: Window,
}

impl Crop {
    /// Samples of the region in several channels, interleaved.
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

    /// Builds a plane of the film from its channels, which are taken out of `channels`.
    fn plane(&self, plane: ExrPlane, channels: &mut [Vec<Option<FlatSamples>>]) -> Plane {
        let mut take =
            |&[part, place]: &Place| channels[part][place].take().expect("a channel is in one plane");
        let own = plane.places.iter().map(&mut take);
        let samples = match plane.kind {
            SampleKind::U32 => Samples::U32(self.side_by_side(&own.map(u32_samples).collect::<Vec<_>>())),
            SampleKind::F32 => Samples::F32(self.side_by_side(&own.map(f32_samples).collect::<Vec<_>>())),
        };
        Plane::from_samples([plane.name, plane.unit, plane.doc], plane.channels, self.window, samples)
    }
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
        FlatSamples::F32(_) | FlatSamples::F16(_) => unreachable!("the layout says which kind"),
    }
}
