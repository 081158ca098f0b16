//! Films in OpenEXR files that are too large for memory: rows on demand.
//!
//! [`ExrFile::open`] reads the header and the offset of each block of rows, or tile.
//! [`ExrFile::read_rows`] then reads and decompresses only the blocks that meet the given rows.
//! Files may have scan lines or tiles, and one part or several.
//!
//! # Guarantee
//! The rows, put together, are the film that [`read_exr`](super::read_exr) returns, bit by bit. A
//! file that is damaged, or was cut short or replaced meanwhile, gives an error that names the
//! file. Memory consists of eight bytes for each block, the requested rows, and one block at a time
//! in compressed and decompressed form. It is allocated only after a check that the file is long
//! enough.
//!
//! # Limits
//! A block is decompressed whole: if a file is one tile, each call decompresses all of it. If a
//! block states the expected position, its contents are trusted, because the format has no
//! checksums beyond those of ZIP.
//!
//! # Held to this by
//! The tests in `rows/tests.rs`, with films of this program, and with files in the style of other
//! programs under any compression.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::{
    Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates,
};
use ::exr::meta::attribute::SampleType;
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::{Vec2, f16};

use super::layout::{ExrPlane, Layout, checked_header};
use super::{at, io, truncated};
use crate::error::{Error, Location, Result};
use crate::film::{Film, Metadata, Plane, SampleKind, Samples, Window};

/// An OpenEXR file whose header was read. The file stays open. If another file replaces it under
/// this name, data of the two are not mixed.
#[derive(Debug)]
pub struct ExrFile {
    path: PathBuf,
    file: Mutex<File>,
    /// Length of the file when it was opened (bytes).
    length: u64,
    meta: MetaData,
    layout: Layout,
    /// Blocks of each part of the film.
    blocks: Vec<Blocks>,
}

/// Offsets of the blocks of a part's largest level.
#[derive(Debug)]
struct Blocks {
    /// Index of the part in the file.
    part: usize,
    /// Columns and rows of a block; blocks at the right and at the bottom may be smaller.
    size: [usize; 2],
    /// Number of blocks beside each other.
    across: usize,
    /// First byte of each block, row by row.
    offsets: Vec<u64>,
}

impl ExrFile {
    /// Reads the header of a file. Refuses the files that [`read_exr`](super::read_exr) refuses,
    /// but accepts any length.
    ///
    /// # Errors
    /// As [`read_exr`](super::read_exr), for the header.
    pub fn open(path: &Path) -> Result<Self> {
        let io = |e| Error::io(path, e);
        let file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        let mut read = BufReader::new(file);
        checked_header(path, &mut read, length)?;
        // Damaged attributes are refused now, as when whole images are read.
        read.rewind().map_err(io)?;
        let meta = MetaData::read_from_buffered(&mut read, true).map_err(|e| at(path, e))?;
        let layout = Layout::of(path, &meta)?;
        let blocks = Blocks::of_parts(path, &mut read, &meta, length, layout.parts)?;
        Ok(Self { path: path.to_owned(), file: Mutex::new(read.into_inner()), length, meta, layout, blocks })
    }

    /// Size of the full image (pixels).
    pub fn size(&self) -> [u32; 2] {
        self.layout.size
    }

    /// The part of the image that the file holds.
    pub fn window(&self) -> Window {
        self.layout.window
    }

    /// All planes, in the order of the film's planes.
    pub fn planes(&self) -> &[ExrPlane] {
        &self.layout.planes
    }

    /// Provenance.
    pub fn metadata(&self) -> &Metadata {
        &self.layout.metadata
    }

    /// Number of rows that are decompressed at once; the first block begins at the window's first
    /// row, if the file has no data above the image.
    pub fn rows_per_block(&self) -> u32 {
        u32::try_from(self.blocks[0].size[1]).unwrap_or(u32::MAX)
    }

    /// Reads rows of the full image into a film as wide as the window.
    ///
    /// # Errors
    /// [`Error::Option`] naming `rows` if there are none or some are outside the window,
    /// [`Error::Io`] if the file cannot be read, [`Error::Invalid`] if it is damaged there.
    pub fn read_rows(&self, rows: Range<u32>) -> Result<Film> {
        let Layout { size, window, offset, planes, metadata, .. } = &self.layout;
        if rows.is_empty() || rows.start < window.y || rows.end > window.y + window.height {
            let expected = format!("rows inside {}..{}", window.y, window.y + window.height);
            return Err(Error::option("rows", format!("{}..{}", rows.start, rows.end), expected));
        }
        let part = Window { y: rows.start, height: rows.end - rows.start, ..*window };
        let mut filled: Vec<Samples> = planes
            .iter()
            .map(|plane| {
                let count = part.area() as usize * plane.channels.len();
                match plane.kind {
                    SampleKind::F32 => Samples::F32(vec![0.0; count]),
                    SampleKind::U32 => Samples::U32(vec![0; count]),
                }
            })
            .collect();
        // Columns and rows to read, in the coordinates of the file's data.
        let top = (rows.start - window.y) as usize + offset[1];
        let kept = [offset[0]..offset[0] + window.width as usize, top..top + part.height as usize];
        let [columns, lines] = &kept;
        for blocks in &self.blocks {
            let [width, height] = blocks.size;
            for down in lines.start / height..lines.end.div_ceil(height) {
                for right in columns.start / width..columns.end.div_ceil(width) {
                    let block = self.block(blocks, right, down)?;
                    self.place(blocks.part, &block, &kept, &mut filled);
                }
            }
        }
        let planes = planes
            .iter()
            .zip(filled)
            .map(|(p, samples)| {
                let words = [p.name.clone(), p.unit.clone(), p.doc.clone()];
                Plane::from_samples(words, p.channels.clone(), part, samples)
            })
            .collect();
        Ok(Film::from_planes(*size, part, planes, metadata.clone()))
    }

    /// A block of the largest level, decompressed.
    fn block(&self, blocks: &Blocks, right: usize, down: usize) -> Result<UncompressedBlock> {
        let chunk = self.chunk(blocks, right, down)?;
        UncompressedBlock::decompress_chunk(chunk, &self.meta, false).map_err(|e| at(&self.path, e))
    }

    /// Reads a block as stored in the file; an error if the block states another position.
    fn chunk(&self, blocks: &Blocks, right: usize, down: usize) -> Result<Chunk> {
        let header = &self.meta.headers[blocks.part];
        let offset = blocks.offset(right, down);
        let damaged = |found, expected| damaged(&self.path, [right, down], offset, found, expected);
        let io = |e| io(&self.path, e);
        let place = blocks.place(&self.meta, right, down);

        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(offset)).map_err(io)?;
        let mut number = || {
            let mut bytes = [0; 4];
            file.read_exact(&mut bytes).map(|()| i32::from_le_bytes(bytes)).map_err(io)
        };
        let found: Vec<i32> = place.iter().map(|_| number()).collect::<Result<_>>()?;
        if found != place {
            return Err(damaged(format!("the place {found:?}"), format!("{place:?}")));
        }
        let length = number()?;
        let begin = offset + 4 * (place.len() as u64 + 1);
        let left = self.length.saturating_sub(begin);
        let most = header.max_block_byte_size() as u64;
        let Some(length) = usize::try_from(length).ok().filter(|&length| length as u64 <= most) else {
            return Err(damaged(format!("a length of {length} bytes"), format!("0 to {most}")));
        };
        if length as u64 > left {
            let how = format!("{left} of the {length} bytes of the block at byte {offset} are there");
            return Err(truncated(&self.path, how));
        }
        let mut compressed_pixels_le = vec![0; length];
        file.read_exact(&mut compressed_pixels_le).map_err(io)?;
        let compressed_block = match header.blocks {
            BlockDescription::Tiles(_) => {
                let coordinates = TileCoordinates { tile_index: Vec2(right, down), level_index: Vec2(0, 0) };
                CompressedBlock::Tile(CompressedTileBlock { coordinates, compressed_pixels_le })
            }
            BlockDescription::ScanLines => {
                let y_coordinate = blocks.first_row(&self.meta, down);
                CompressedBlock::ScanLine(CompressedScanLineBlock { y_coordinate, compressed_pixels_le })
            }
        };
        Ok(Chunk { layer_index: blocks.part, compressed_block })
    }

    /// Copies the kept columns and rows of a part's block to their places in the planes.
    fn place(
        &self,
        part: usize,
        block: &UncompressedBlock,
        kept: &[Range<usize>; 2],
        filled: &mut [Samples],
    ) {
        let [columns, rows] = kept;
        let channels = &self.meta.headers[part].channels;
        // For each channel of the file, the index of its plane and the index of the channel in the
        // plane. If two channels have the same name, one of them has none.
        let mut homes = vec![None; channels.list.len()];
        for (p, plane) in self.layout.planes.iter().enumerate() {
            for (c, [_, place]) in plane.places.iter().enumerate().filter(|(_, [of, _])| *of == part) {
                homes[*place] = Some((p, c));
            }
        }
        for line in block.lines(channels) {
            let Vec2(left, row) = line.location.position;
            let Some((plane, channel)) = homes[line.location.channel].filter(|_| rows.contains(&row)) else {
                continue;
            };
            let begin = left.max(columns.start);
            let end = (left + line.location.sample_count).min(columns.end);
            if begin >= end {
                continue;
            }
            let count = self.layout.planes[plane].channels.len();
            let to = ((row - rows.start) * columns.len() + begin - columns.start) * count + channel;
            let kind = channels.list[line.location.channel].sample_type;
            let bytes = kind.bytes_per_sample();
            let from = &line.value[(begin - left) * bytes..(end - left) * bytes];
            let four = |b: &[u8]| [b[0], b[1], b[2], b[3]];
            match (&mut filled[plane], kind) {
                (Samples::F32(samples), SampleType::F16) => {
                    let values = from.chunks_exact(2).map(|b| f16::from_ne_bytes([b[0], b[1]]).to_f32());
                    spread(values, &mut samples[to..], count);
                }
                (Samples::F32(samples), _) => {
                    let values = from.chunks_exact(4).map(|b| f32::from_ne_bytes(four(b)));
                    spread(values, &mut samples[to..], count);
                }
                (Samples::U32(samples), _) => {
                    let values = from.chunks_exact(4).map(|b| u32::from_ne_bytes(four(b)));
                    spread(values, &mut samples[to..], count);
                }
            }
        }
    }
}

fn damaged(path: &Path, [right, down]: [usize; 2], offset: u64, found: String, expected: String) -> Error {
    let item = format!("block {right},{down} at byte {offset}");
    Error::invalid(Location::file(path).item(item), found, expected)
}

/// Refuses a file in which a block states another position than the table of offsets gives it. If
/// two blocks stated the same position, the reader would use only one of them, and the position of
/// the other would stay empty. `table` begins after the headers; the first `parts` parts are
/// checked.
pub(super) fn check_places(
    path: &Path,
    bytes: &[u8],
    mut table: &[u8],
    meta: &MetaData,
    parts: usize,
) -> Result<()> {
    let of_parts = Blocks::of_parts(path, &mut table, meta, bytes.len() as u64, parts)?;
    let numbered =
        of_parts.iter().flat_map(|blocks| blocks.offsets.iter().enumerate().map(move |n| (blocks, n)));
    for (blocks, (number, &offset)) in numbered {
        let (right, down) = (number % blocks.across, number / blocks.across);
        let place = blocks.place(meta, right, down);
        let numbers = bytes[offset as usize..].as_chunks().0.iter().map(|b| i32::from_le_bytes(*b));
        let found: Vec<i32> = numbers.take(place.len()).collect();
        if found.len() < place.len() {
            return Err(truncated(path, format!("it ends within the block at byte {offset}")));
        }
        if found != place {
            let (found, expected) = (format!("the place {found:?}"), format!("{place:?}"));
            return Err(damaged(path, [right, down], offset, found, expected));
        }
    }
    Ok(())
}

/// Writes values to every `step`-th element.
fn spread<T>(values: impl Iterator<Item = T>, to: &mut [T], step: usize) {
    for (place, value) in to.iter_mut().step_by(step).zip(values) {
        *place = value;
    }
}

impl Blocks {
    /// Reads the tables of offsets of the first `parts` parts, which follow the headers.
    fn of_parts(
        path: &Path,
        read: &mut impl Read,
        meta: &MetaData,
        length: u64,
        parts: usize,
    ) -> Result<Vec<Self>> {
        (0..parts).map(|part| Self::read(path, read, meta, length, part)).collect()
    }

    /// Reads the table of a part, which begins where the table of the previous part ends.
    fn read(path: &Path, read: &mut impl Read, meta: &MetaData, length: u64, part: usize) -> Result<Self> {
        let header = &meta.headers[part];
        let (Vec2(width, height), Vec2(columns, rows)) = (header.layer_size, header.max_block_pixel_size());
        let size = [columns.max(1), rows.max(1)];
        // The table lists the largest level first, and rows of blocks from the top, whatever the
        // order of the blocks themselves.
        let across = width.div_ceil(size[0]);
        let count = across.saturating_mul(height.div_ceil(size[1]));
        if count > header.chunk_count || (count as u64).saturating_mul(8) > length {
            let found = format!("{count} blocks of {} in {length} bytes", header.chunk_count);
            return Err(truncated(path, found));
        }
        let mut bytes = vec![0; 8 * count];
        read.read_exact(&mut bytes).map_err(|e| io(path, e))?;
        // Offsets of smaller levels are skipped.
        let rest = 8 * (header.chunk_count - count) as u64;
        std::io::copy(&mut read.by_ref().take(rest), &mut std::io::sink()).map_err(|e| io(path, e))?;
        let number = |b: &[u8]| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]);
        let offsets: Vec<u64> = bytes.chunks_exact(8).map(number).collect();
        // Offsets below the file's length leave room to add the size of a block's position and
        // length without overflow.
        if let Some(beyond) = offsets.iter().find(|&&offset| offset >= length) {
            return Err(truncated(path, format!("a block is at byte {beyond} of {length}")));
        }
        Ok(Self { part, size, across, offsets })
    }

    /// First byte of a block.
    fn offset(&self, right: usize, down: usize) -> u64 {
        self.offsets[down * self.across + right]
    }

    /// First row of a row of blocks, in the file's coordinates.
    fn first_row(&self, meta: &MetaData, down: usize) -> i32 {
        let first = meta.headers[self.part].own_attributes.layer_position.1;
        first.saturating_add((down * self.size[1]) as i32)
    }

    /// Numbers with which a block begins: the part, if the file has several, and the position of
    /// the block in the part.
    fn place(&self, meta: &MetaData, right: usize, down: usize) -> Vec<i32> {
        let mut place = Vec::new();
        if meta.requirements.is_multilayer() {
            place.push(self.part as i32);
        }
        match meta.headers[self.part].blocks {
            BlockDescription::Tiles(_) => place.extend([right as i32, down as i32, 0, 0]),
            BlockDescription::ScanLines => place.push(self.first_row(meta, down)),
        }
        place
    }
}

#[cfg(test)]
mod tests;
