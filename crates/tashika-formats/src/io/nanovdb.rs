//! NanoVDB files, `.nvdb`, of version 32: a grid of numbers as a box of cells.
//!
//! ```text
//! file    = segment … segment                                        (all little endian)
//! segment = "NanoVDB0" or "NanoVDB2", version, grids (2 bytes), codec (2 bytes), metadata …, data …
//! data    = grid (672 bytes), tree (64), root, nodes of 32³ × 16³ × 8³ values below each other
//! ```
//!
//! Grids of 32-bit floats are read, uncompressed or as zlib streams (codec 1). A node stores the
//! offsets of its children. A tile is one value for a whole child. Values outside the box of active
//! values, extended by one layer, are ignored.
//!
//! # Guarantee
//! Any bytes give a grid or an error. The cells take at most [`MAX_RATIO`] times the bytes of the
//! data, and cells and data each stay within the given limit: a larger box is refused.
//!
//! Source: the format description of NanoVDB at openvdb.org. Held to this by the tests below.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::Read;

use flate2::bufread::ZlibDecoder;
use glam::{DAffine3, DMat3, DVec3};

use crate::error::{Error, Location, Result};

/// Largest ratio of the bytes of the cells to the bytes of the data.
const MAX_RATIO: u64 = 16;
/// Largest compression ratio of a deflate stream: 258 bytes from two bits.
const MAX_DEFLATE: u64 = 1032;
/// Code of the grid type of 32-bit floats.
const FLOAT: u32 = 1;

/// Sizes of parts of a file (bytes).
const HEADER: usize = 16;
const METADATA: usize = 176;
const GRID: usize = 672;

/// A grid of a file.
#[derive(Debug)]
pub(super) struct NanoGrid {
    /// Lowest index along each axis.
    pub(super) lowest: [i32; 3],
    /// Number of values along each axis. The range ends one index beyond the highest active one, so
    /// that the density falls to an inactive value there.
    pub(super) counts: [u32; 3],
    /// Values, the first axis fastest.
    pub(super) values: Vec<f32>,
    /// Map from indices to world space: the value with index `k` lies at `k`.
    pub(super) to_world: DAffine3,
}

/// Reads the grid `name`, which may take at most `most` bytes.
///
/// # Errors
/// [`Error::Invalid`] if the file is not NanoVDB of version 32, is damaged, lacks the grid, or has
/// a grid far larger than its data; [`Error::Unsupported`] for other types and codecs.
pub(super) fn read(bytes: &[u8], name: &str, most: u64, at: &Location) -> Result<NanoGrid> {
    let data = data_of(bytes, name, most, at)?;
    let damaged = || {
        Error::invalid(at.clone(), "a NanoVDB grid whose nodes are not where they should be", "a whole file")
    };
    Tree::of(&data).ok_or_else(damaged)?.dense(most, at)?.ok_or_else(damaged)
}

/// The data of a grid, decompressed.
fn data_of<'a>(bytes: &'a [u8], name: &str, most: u64, at: &Location) -> Result<Cow<'a, [u8]>> {
    let invalid = |found: String, expected: &str| Error::invalid(at.clone(), found, expected);
    let ended = || invalid("a NanoVDB file that ends too early".to_owned(), "a whole file");
    let file = Bytes(bytes);
    let mut names = Vec::new();
    let mut place = 0;
    while place < bytes.len() {
        let magic = file.0.get(place..place + 8).ok_or_else(ended)?;
        if magic != b"NanoVDB0" && magic != b"NanoVDB2" {
            return Err(invalid("a file that is not of NanoVDB".to_owned(), "\"NanoVDB0\" or \"NanoVDB2\""));
        }
        let version = file.u32(place + 8).ok_or_else(ended)? >> 21;
        if version != 32 {
            return Err(invalid(format!("a NanoVDB file of version {version}"), "version 32"));
        }
        let grids = file.u16(place + 12).ok_or_else(ended)?;
        place += HEADER;
        let mut metadata = Vec::new();
        for _ in 0..grids {
            let name_at = place + METADATA;
            let size = file.u32(place + 136).ok_or_else(ended)? as usize;
            let name = bytes.get(name_at..).and_then(|rest| rest.get(..size)).ok_or_else(ended)?;
            metadata.push((place, String::from_utf8_lossy(name).trim_end_matches('\0').to_owned()));
            place = name_at + size;
        }
        for (metadata, found) in metadata {
            let size =
                file.u64(metadata + 8).and_then(|size| usize::try_from(size).ok()).ok_or_else(ended)?;
            let stored = bytes.get(place..).and_then(|rest| rest.get(..size)).ok_or_else(ended)?;
            place += size;
            if found != name {
                names.push(found);
                continue;
            }
            if file.u32(metadata + 32) != Some(FLOAT) {
                let what = format!("a NanoVDB grid of type {}", file.u32(metadata + 32).unwrap_or(0));
                return Err(Error::unsupported(at.clone(), what, "write it as 32-bit floats"));
            }
            let whole = file.u64(metadata).ok_or_else(ended)?;
            return match file.u16(metadata + 168) {
                Some(0) => Ok(Cow::Borrowed(stored)),
                Some(1) if whole <= most => inflated(stored, whole).map(Cow::Owned).ok_or_else(ended),
                Some(1) => {
                    Err(invalid(format!("a NanoVDB grid of {whole} bytes"), &format!("at most {most}")))
                }
                _ => {
                    let what = "a NanoVDB grid that is compressed by Blosc";
                    Err(Error::unsupported(at.clone(), what, "write it with codec none or zip"))
                }
            };
        }
    }
    names.truncate(8);
    Err(invalid(format!("grids {names:?}"), &format!("a grid {name:?}")))
}

/// Inflates the zlib stream in `stored`, after its compressed length, to `whole` bytes.
fn inflated(stored: &[u8], whole: u64) -> Option<Vec<u8>> {
    let stream = stored.get(8..)?;
    if whole / MAX_DEFLATE > stream.len() as u64 {
        return None;
    }
    let mut bytes = Vec::new();
    ZlibDecoder::new(stream).take(whole).read_to_end(&mut bytes).ok()?;
    (bytes.len() as u64 == whole).then_some(bytes)
}

/// Reads numbers at given offsets; none beyond the end.
#[derive(Clone, Copy)]
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn array<const N: usize>(self, at: usize) -> Option<[u8; N]> {
        self.0.get(at..)?.first_chunk::<N>().copied()
    }

    fn u16(self, at: usize) -> Option<u16> {
        self.array(at).map(u16::from_le_bytes)
    }

    fn u32(self, at: usize) -> Option<u32> {
        self.array(at).map(u32::from_le_bytes)
    }

    fn i32(self, at: usize) -> Option<i32> {
        self.array(at).map(i32::from_le_bytes)
    }

    fn u64(self, at: usize) -> Option<u64> {
        self.array(at).map(u64::from_le_bytes)
    }

    fn f32(self, at: usize) -> Option<f32> {
        self.array(at).map(f32::from_le_bytes)
    }

    fn f64(self, at: usize) -> Option<f64> {
        self.array(at).map(f64::from_le_bytes)
    }

    /// The offset `from` plus the number stored at `at`.
    fn place(self, from: usize, at: usize) -> Option<usize> {
        let offset = i64::try_from(self.u64(at)?).ok()?;
        from.checked_add(usize::try_from(offset).ok()?)
    }

    fn bit(self, mask: usize, k: usize) -> Option<bool> {
        self.0.get(mask + k / 8).map(|byte| byte >> (k % 8) & 1 == 1)
    }
}

/// Level of the tree whose nodes have nodes or tiles as children.
struct Level {
    /// Number of children along an axis, as a power of two.
    bits: u32,
    /// Number of values that a child spans along an axis.
    child: i32,
    children: usize,
    table: usize,
}

const UPPER: Level = Level { bits: 5, child: 128, children: 32 + 4096, table: 8256 };
const LOWER: Level = Level { bits: 4, child: 8, children: 32 + 512, table: 1088 };
/// Offset of the values in a leaf (bytes).
const LEAF_VALUES: usize = 96;
const LEAF: i32 = 8;

struct Tree<'a> {
    bytes: Bytes<'a>,
    root: usize,
    background: f32,
    lowest: [i32; 3],
    highest: [i32; 3],
    to_world: DAffine3,
}

impl<'a> Tree<'a> {
    fn of(data: &'a [u8]) -> Option<Self> {
        let bytes = Bytes(data);
        let root = bytes.place(GRID, GRID + 24)?;
        let corner = |at: usize| Some([bytes.i32(at)?, bytes.i32(at + 4)?, bytes.i32(at + 8)?]);
        let row = |at: usize| Some(DVec3::new(bytes.f64(at)?, bytes.f64(at + 8)?, bytes.f64(at + 16)?));
        let map = 296 + 88;
        let matrix = DMat3::from_cols(row(map)?, row(map + 24)?, row(map + 48)?).transpose();
        Some(Self {
            bytes,
            root,
            background: bytes.f32(root + 28)?,
            lowest: corner(root)?,
            highest: corner(root + 12)?,
            to_world: DAffine3::from_mat3_translation(matrix, row(map + 144)?),
        })
    }

    /// All values in the box of active values; none if an offset does not lead to a valid node.
    fn dense(&self, most: u64, at: &Location) -> Result<Option<NanoGrid>> {
        let size = [0, 1, 2].map(|k| i64::from(self.highest[k]) - i64::from(self.lowest[k]) + 2);
        let cells = size.into_iter().try_fold(1_u64, |all, n| all.checked_mul(u64::try_from(n).ok()?));
        let most = most.min(MAX_RATIO * self.bytes.0.len() as u64) / 4;
        let is_active = size.iter().all(|&n| n > 1 && n < i64::from(u32::MAX));
        let Some(cells) = cells.filter(|&cells| is_active && cells <= most) else {
            let found = format!(
                "a NanoVDB grid from {:?} to {:?} in {} bytes",
                self.lowest,
                self.highest,
                self.bytes.0.len()
            );
            return Err(Error::invalid(at.clone(), found, format!("at most {most} cells for so many bytes")));
        };
        let counts = size.map(|n| n as u32);
        let mut dense = Dense { lowest: self.lowest, counts, values: vec![self.background; cells as usize] };
        let Some(()) = self.fill(&mut dense) else { return Ok(None) };
        let Dense { lowest, counts, values } = dense;
        Ok(Some(NanoGrid { lowest, counts, values, to_world: self.to_world }))
    }

    fn fill(&self, dense: &mut Dense) -> Option<()> {
        let tiles = self.bytes.u32(self.root + 24)?;
        let mut seen = BTreeSet::new();
        for tile in 0..tiles as usize {
            let tile = self.root + 64 + 32 * tile;
            let key = self.bytes.u64(tile)?;
            // The key has 21 bits for each axis, z lowest. They are the index without its 12 lowest
            // bits.
            let axis = |shift: u32| ((key >> shift & 0x1f_ffff) as u32) << 12;
            let origin = [axis(42) as i32, axis(21) as i32, axis(0) as i32];
            if !seen.insert(origin) {
                return None;
            }
            if !dense.meets(origin, 4096) {
                continue;
            }
            if self.bytes.u64(tile + 8)? == 0 {
                dense.set(origin, 4096, self.bytes.f32(tile + 20)?);
            } else {
                let node = self.bytes.place(self.root, tile + 8)?;
                self.inner(node, origin, &UPPER, dense)?;
            }
        }
        Some(())
    }

    fn inner(&self, node: usize, origin: [i32; 3], level: &Level, dense: &mut Dense) -> Option<()> {
        let per_axis = 1 << level.bits;
        for k in 0..per_axis * per_axis * per_axis {
            let of = [k >> (2 * level.bits), k >> level.bits & (per_axis - 1), k & (per_axis - 1)];
            let child = [0, 1, 2].map(|axis: usize| origin[axis].wrapping_add(of[axis] as i32 * level.child));
            if !dense.meets(child, level.child) {
                continue;
            }
            let entry = node.checked_add(level.table + 8 * k)?;
            if !self.bytes.bit(node + level.children, k)? {
                dense.set(child, level.child, self.bytes.f32(entry)?);
                continue;
            }
            let below = self.bytes.place(node, entry)?;
            if level.child > LEAF {
                self.inner(below, child, &LOWER, dense)?;
            } else {
                self.leaf(below, child, dense)?;
            }
        }
        Some(())
    }

    fn leaf(&self, node: usize, origin: [i32; 3], dense: &mut Dense) -> Option<()> {
        for k in 0..512 {
            let of = [k >> 6, k >> 3 & 7, k & 7];
            let value = self.bytes.f32(node.checked_add(LEAF_VALUES + 4 * k)?)?;
            dense.set([0, 1, 2].map(|axis: usize| origin[axis].wrapping_add(of[axis] as i32)), 1, value);
        }
        Some(())
    }
}

/// A box of values.
struct Dense {
    lowest: [i32; 3],
    counts: [u32; 3],
    values: Vec<f32>,
}

impl Dense {
    /// Range of a cube along an axis, within the box.
    fn range(&self, axis: usize, origin: i32, size: i32) -> std::ops::Range<usize> {
        let from = i64::from(origin) - i64::from(self.lowest[axis]);
        let within = |at: i64| at.clamp(0, i64::from(self.counts[axis])) as usize;
        within(from)..within(from + i64::from(size))
    }

    fn meets(&self, origin: [i32; 3], size: i32) -> bool {
        (0..3).all(|axis| !self.range(axis, origin[axis], size).is_empty())
    }

    fn set(&mut self, origin: [i32; 3], size: i32, value: f32) {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| self.range(axis, origin[axis], size));
        let [nx, ny, _] = self.counts.map(|n| n as usize);
        for k in z {
            for j in y.clone() {
                let row = (k * ny + j) * nx;
                self.values[row + x.start..row + x.end].fill(value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
        bytes[at..at + value.len()].copy_from_slice(value);
    }

    /// A grid with one leaf at (−8, 0, 8), whose value at (x, y, z) in the leaf is
    /// `x + 8 y + 64 z`. The rest of its node of 16³ is tiles of 7. There is no other node. Indices
    /// are 2 m apart.
    fn grid() -> Vec<u8> {
        let (root, upper) = (GRID + 64, GRID + 64 + 64 + 32);
        let lower = upper + UPPER.table + 8 * (1 << 15);
        let leaf = lower + LOWER.table + 8 * (1 << 12);
        let mut bytes = vec![0; leaf + LEAF_VALUES + 4 * 512];
        for k in 0..3 {
            put(&mut bytes, 296 + 88 + 8 * (4 * k), &2.0_f64.to_le_bytes());
            put(&mut bytes, 296 + 232 + 8 * k, &(10.0 * k as f64).to_le_bytes());
        }
        put(&mut bytes, GRID + 24, &64_u64.to_le_bytes());
        for (k, end) in [-8_i32, 0, 8, 3, 7, 15].into_iter().enumerate() {
            put(&mut bytes, root + 4 * k, &end.to_le_bytes());
        }
        put(&mut bytes, root + 24, &1_u32.to_le_bytes());
        put(&mut bytes, root + 28, &0.5_f32.to_le_bytes());
        let x = u64::from((-4096_i32) as u32 >> 12);
        put(&mut bytes, root + 64, &(x << 42).to_le_bytes());
        put(&mut bytes, root + 64 + 8, &((upper - root) as u64).to_le_bytes());
        // Relative to the upper node's corner, (−8, 0, 8) is (4088, 0, 8): child (31, 0, 0), and in
        // it child (15, 0, 1).
        let child = 31 << 10;
        bytes[upper + UPPER.children + child / 8] |= 1 << (child % 8);
        put(&mut bytes, upper + UPPER.table + 8 * child, &((lower - upper) as u64).to_le_bytes());
        for k in 0..1 << 12 {
            put(&mut bytes, lower + LOWER.table + 8 * k, &7.0_f32.to_le_bytes());
        }
        let child = 15 << 8 | 1;
        bytes[lower + LOWER.children + child / 8] |= 1 << (child % 8);
        put(&mut bytes, lower + LOWER.table + 8 * child, &((leaf - lower) as u64).to_le_bytes());
        for k in 0..512_usize {
            let value = (k >> 6) + 8 * (k >> 3 & 7) + 64 * (k & 7);
            put(&mut bytes, leaf + LEAF_VALUES + 4 * k, &(value as f32).to_le_bytes());
        }
        bytes
    }

    /// A file of two grids; the second is `data`.
    fn file(data: &[u8], codec: u16) -> Vec<u8> {
        let mut stored = data.to_vec();
        if codec == 1 {
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(data).unwrap();
            let stream = encoder.finish().unwrap();
            stored = [&(stream.len() as u64).to_le_bytes(), stream.as_slice()].concat();
        }
        let mut bytes = b"NanoVDB0".to_vec();
        bytes.extend((32_u32 << 21 | 3 << 10).to_le_bytes());
        bytes.extend([2_u16, codec].iter().flat_map(|n| n.to_le_bytes()));
        for (name, length, size) in [("flame\0", 4, 4), ("density\0", data.len(), stored.len())] {
            let mut metadata = vec![0; METADATA];
            put(&mut metadata, 0, &(length as u64).to_le_bytes());
            put(&mut metadata, 8, &(size as u64).to_le_bytes());
            put(&mut metadata, 32, &FLOAT.to_le_bytes());
            put(&mut metadata, 136, &(name.len() as u32).to_le_bytes());
            put(&mut metadata, 168, &codec.to_le_bytes());
            bytes.extend(metadata);
            bytes.extend(name.as_bytes());
        }
        bytes.extend([9; 4]);
        bytes.extend(stored);
        bytes
    }

    fn open(bytes: &[u8]) -> Result<NanoGrid> {
        read(bytes, "density", 1 << 30, &Location::file("a.nvdb"))
    }

    #[test]
    fn values_of_leaves_tiles_and_the_background_are_where_their_indices_say() {
        for codec in [0, 1] {
            let grid = open(&file(&grid(), codec)).unwrap();
            assert_eq!((grid.lowest, grid.counts), ([-8, 0, 8], [13, 9, 9]));
            let at = |x: i32, y: i32, z: i32| grid.values[((z - 8) * 9 + y) as usize * 13 + (x + 8) as usize];
            assert_eq!([at(-8, 0, 8), at(-7, 0, 8), at(-8, 3, 8), at(-1, 7, 15)], [0.0, 1.0, 24.0, 511.0]);
            // The first two points are in tiles above and behind the leaf. The last two are beyond
            // x = 0, where there is no node.
            assert_eq!([at(-8, 8, 8), at(-1, 0, 16), at(0, 0, 8), at(4, 8, 16)], [7.0, 7.0, 0.5, 0.5]);
            assert_eq!(grid.to_world.transform_point3(DVec3::ONE), DVec3::new(2.0, 12.0, 22.0));
        }
    }

    #[test]
    fn other_files_are_refused_with_what_would_be_read() {
        let said = |bytes: &[u8]| open(bytes).unwrap_err().to_string();
        let whole = file(&grid(), 0);
        let changed = |at: usize, value: &[u8]| {
            let mut bytes = whole.clone();
            put(&mut bytes, at, value);
            said(&bytes)
        };
        assert!(said(b"VOL\x03").contains("ends too early"));
        assert!(changed(0, b"MonoVDB0").contains("not of NanoVDB"));
        assert!(changed(8, &(33_u32 << 21).to_le_bytes()).contains("version 33; expected version 32"));
        let second = HEADER + METADATA + 6;
        assert!(changed(second + 32, &2_u32.to_le_bytes()).contains("type 2 is not supported"));
        assert!(changed(second + 168, &2_u16.to_le_bytes()).contains("compressed by Blosc"));
        assert!(changed(second + METADATA, b"x").contains("\"xensity\"]; expected a grid \"density\""));
        let missing = read(&whole, "heat", 1 << 30, &Location::file("a.nvdb")).unwrap_err().to_string();
        assert!(missing.contains("grids [\"flame\", \"density\"]; expected a grid \"heat\""), "{missing}");
        let root = whole.len() - grid().len() + GRID + 64;
        let far = changed(root + 12, &2_000_000_000_i32.to_le_bytes());
        assert!(far.contains("cells for so many bytes"), "{far}");
        assert!(changed(root + 12, &(-9_i32).to_le_bytes()).contains("cells for so many bytes"));
        let small = read(&whole, "density", 1000, &Location::file("a.nvdb")).unwrap_err().to_string();
        assert!(small.contains("at most 250 cells"), "{small}");
    }

    #[test]
    fn damaged_bytes_give_errors() {
        for codec in [0, 1] {
            let whole = file(&grid(), codec);
            for length in (0..whole.len()).step_by(if codec == 0 { 997 } else { 7 }) {
                assert!(open(&whole[..length]).is_err(), "{length}");
            }
            let all = whole.len();
            for i in (0..all.min(1500)).chain((0..all).step_by(499)) {
                let mut flipped = whole.clone();
                flipped[i] ^= 1 << (i % 8);
                // A grid or an error is fine; a panic is not.
                let _ = open(&flipped);
            }
        }
    }
}
