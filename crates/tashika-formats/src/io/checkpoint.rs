//! Finished tiles of a render, stored in a file so that the render can continue after it was
//! stopped at any moment.
//!
//! The file begins with size, window, planes and metadata of the render's film, which identify the
//! render. A record follows for each finished tile, appended by a single write. Numbers are
//! little-endian:
//!
//! ```text
//! "TASHIKAC"  u32 version = 1  u32 length of the head  head (JSON)  u32 CRC-32 of the head
//! per tile:   u32 x, y, width, height   samples, pixel by pixel, plane by plane, four bytes each   u32 CRC-32 of all that
//! ```
//!
//! # Guarantee
//! [`Checkpoint::open`] returns tiles bit by bit as they were added. If a record is cut off or has
//! a wrong checksum, this record and all records after it are ignored. This is reported, and the
//! tiles of the ignored records must be rendered again. A file that belongs to another render, or
//! is no checkpoint, is refused and not changed. On a file system with locks, two programs cannot
//! write to one checkpoint. Memory is proportional to the film, whatever the file contains.
//!
//! # Held to this by
//! The tests below; the program's tests in `tests/parts.rs`, which kill it while it renders.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use flate2::Crc;
use serde_json::{Value as Json, json};

use crate::error::{Error, Location, Result};
use crate::film::{Film, Plane, SampleKind, Window};

const MAGIC: &[u8; 8] = b"TASHIKAC";
const VERSION: u32 = 1;
/// Largest head that is read (bytes).
const MAX_HEAD_BYTES: u32 = 1 << 20;

/// A file to which finished tiles are added.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    file: File,
    /// Tiles in the file: x, y, width, height.
    known: BTreeSet<[u32; 4]>,
}

/// Contents of a checkpoint that was opened.
#[derive(Clone, Debug)]
pub struct Resumed {
    /// The film with which the checkpoint was opened, with the restored tiles filled in.
    pub film: Film,
    /// Restored tiles, in the order of the file.
    pub tiles: Vec<Window>,
    /// Description of the fault in the rest of the file, if there is one.
    pub damage: Option<String>,
}

impl Checkpoint {
    /// Opens the checkpoint of the render that begins with this film, or creates one.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read or written or is locked by another program,
    /// [`Error::Invalid`] if it belongs to another render or is no checkpoint.
    pub fn open(path: &Path, film: &Film) -> Result<(Self, Resumed)> {
        let io = |e| Error::io(path, e);
        let mut file =
            File::options().read(true).write(true).create(true).truncate(false).open(path).map_err(io)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                return Err(io(io::Error::new(
                    io::ErrorKind::WouldBlock,
                    "another program is writing to it",
                )));
            }
            // Not every file system has locks.
            Err(TryLockError::Error(_)) | Ok(()) => {}
        }
        let mut resumed = Resumed { film: film.clone(), tiles: Vec::new(), damage: None };
        let head = head(film);
        let length = file.metadata().map_err(io)?.len();
        let end = if length == 0 {
            file.write_all(&head).map_err(io)?;
            head.len() as u64
        } else {
            check_head(path, &mut file, length, &head)?;
            let mut reader = io::BufReader::new(&file);
            records(&mut reader, head.len() as u64, length, &mut resumed).map_err(io)?
        };
        // Unused bytes are cut off, so that new records follow the used ones.
        file.set_len(end).map_err(io)?;
        file.seek(SeekFrom::Start(end)).map_err(io)?;
        let known = resumed.tiles.iter().map(place).collect();
        Ok((Self { path: path.to_owned(), file, known }, resumed))
    }

    /// Adds a finished tile, unless the file already has it.
    ///
    /// # Errors
    /// [`Error::Io`]; tiles that were added before remain.
    pub fn add(&mut self, film: &Film, tile: Window) -> Result<()> {
        if !self.known.contains(&place(&tile)) {
            self.file.write_all(&record(film, tile)).map_err(|e| Error::io(&self.path, e))?;
            self.known.insert(place(&tile));
        }
        Ok(())
    }

    /// Removes the file: the render is complete and written.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn remove(self) -> Result<()> {
        fs::remove_file(&self.path).map_err(|e| Error::io(&self.path, e))
    }
}

fn place(tile: &Window) -> [u32; 4] {
    [tile.x, tile.y, tile.width, tile.height]
}

fn kind(plane: &Plane) -> &'static str {
    match plane.kind() {
        SampleKind::F32 => "f32",
        SampleKind::U32 => "u32",
    }
}

/// Magic number, version, head and its checksum.
fn head(film: &Film) -> Vec<u8> {
    let w = film.window();
    let planes: Vec<Json> = film.planes().iter().map(|p| json!([p.name(), p.channels(), kind(p)])).collect();
    let metadata: Json = film
        .metadata()
        .iter()
        .map(|(name, value)| (name.to_owned(), Json::from(value.to_string())))
        .collect();
    let head = json!({
        "size": film.size(),
        "window": [w.x, w.y, w.width, w.height],
        "planes": planes,
        "metadata": metadata,
    });
    let head = head.to_string();
    let mut bytes = Vec::new();
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((head.len() as u32).to_le_bytes());
    bytes.extend(head.as_bytes());
    bytes.extend(sum(head.as_bytes()).to_le_bytes());
    bytes
}

fn sum(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// Refuses a file that does not begin as expected; the error states the difference.
fn check_head(path: &Path, file: &mut File, length: u64, expected: &[u8]) -> Result<()> {
    let io = |e| Error::io(path, e);
    let mut bytes = vec![0; length.min(u64::from(MAX_HEAD_BYTES)) as usize];
    file.read_exact(&mut bytes).map_err(io)?;
    file.seek(SeekFrom::Start(expected.len() as u64)).map_err(io)?;
    if bytes.starts_with(expected) {
        return Ok(());
    }
    let is_truncated = expected.starts_with(&bytes);
    let refuse = |found: String, expected: &str| Err(Error::invalid(Location::file(path), found, expected));
    let number = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if is_truncated {
        return refuse(
            "a truncated head".to_owned(),
            "a checkpoint as it was written; remove it to begin anew",
        );
    }
    if !bytes.starts_with(MAGIC) {
        return refuse(
            "something else".to_owned(),
            "a checkpoint; move it away, or write the image elsewhere",
        );
    }
    if number(8) != Some(VERSION) {
        return refuse(
            "another version of checkpoints".to_owned(),
            "one of this program; remove it to begin anew",
        );
    }
    let json = |bytes: &[u8]| serde_json::from_slice::<Json>(bytes).ok();
    let found = number(12)
        .and_then(|n| bytes.get(16..16 + n as usize).filter(|h| number(16 + n as usize) == Some(sum(h))));
    let (Some(found), Some(ours)) = (found.and_then(json), json(&expected[16..expected.len() - 4])) else {
        return refuse(
            "a damaged head".to_owned(),
            "a checkpoint as it was written; remove it to begin anew",
        );
    };
    refuse(difference(&found, &ours), "a checkpoint of this render; remove it to begin anew")
}

/// The first difference, in words.
fn difference(found: &Json, ours: &Json) -> String {
    for key in ["size", "window", "planes"] {
        if found[key] != ours[key] {
            return format!("a checkpoint with {key} {}, not {}", found[key], ours[key]);
        }
    }
    let names =
        [found, ours].into_iter().filter_map(|head| head["metadata"].as_object()).flat_map(|m| m.keys());
    let mut differing = names.filter(|name| found["metadata"][*name] != ours["metadata"][*name]);
    differing.next().map_or_else(
        || "another head".to_owned(),
        |name| {
            format!("a checkpoint with {name} = {}, not {}", found["metadata"][name], ours["metadata"][name])
        },
    )
}

/// Size of a tile's samples (bytes).
fn sample_bytes(film: &Film, tile: Window) -> u64 {
    let channels: usize = film.planes().iter().map(|p| p.channels().len()).sum();
    4 * tile.area() * channels as u64
}

fn record(film: &Film, tile: Window) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(20 + sample_bytes(film, tile) as usize);
    for number in place(&tile) {
        bytes.extend(number.to_le_bytes());
    }
    for (x, y) in tile.pixels() {
        for plane in film.planes() {
            match plane.kind() {
                SampleKind::F32 => plane.f32_at(x, y).iter().for_each(|v| bytes.extend(v.to_le_bytes())),
                SampleKind::U32 => plane.u32_at(x, y).iter().for_each(|v| bytes.extend(v.to_le_bytes())),
            }
        }
    }
    bytes.extend(sum(&bytes).to_le_bytes());
    bytes
}

/// Reads records up to the first that is not whole; returns the offset at which the last whole one
/// ends.
fn records(file: &mut impl Read, begin: u64, length: u64, resumed: &mut Resumed) -> io::Result<u64> {
    let mut at = begin;
    while at < length {
        let lost = length - at;
        let bytes = match next_record(file, lost, &resumed.film)? {
            Record::Whole(bytes) => bytes,
            Record::Truncated => {
                resumed.damage = Some(format!("it is truncated: its last {lost} bytes are not a whole tile"));
                break;
            }
            Record::Damaged => {
                resumed.damage =
                    Some(format!("it is damaged: its last {lost} bytes are not as they were written"));
                break;
            }
        };
        at += bytes.len() as u64;
        let tile = restore(&bytes, &mut resumed.film);
        resumed.tiles.push(tile);
    }
    Ok(at)
}

/// Result of reading a record.
enum Record {
    /// A record with the right checksum.
    Whole(Vec<u8>),
    /// The file ends within a record.
    Truncated,
    /// A record that does not fit this film, or that has a wrong checksum.
    Damaged,
}

fn next_record(file: &mut impl Read, left: u64, film: &Film) -> io::Result<Record> {
    if left < 20 {
        return Ok(Record::Truncated);
    }
    let mut bytes = vec![0; 16];
    file.read_exact(&mut bytes)?;
    let tile = window(&bytes);
    let all = film.window();
    // Checked against the film, not against claims of the file.
    let inside = tile.area() > 0
        && tile.x >= all.x
        && tile.y >= all.y
        && u64::from(tile.x - all.x) + u64::from(tile.width) <= u64::from(all.width)
        && u64::from(tile.y - all.y) + u64::from(tile.height) <= u64::from(all.height);
    if !inside {
        return Ok(Record::Damaged);
    }
    if sample_bytes(film, tile) + 20 > left {
        return Ok(Record::Truncated);
    }
    let end = 20 + sample_bytes(film, tile) as usize;
    bytes.resize(end, 0);
    file.read_exact(&mut bytes[16..])?;
    let told = [bytes[end - 4], bytes[end - 3], bytes[end - 2], bytes[end - 1]];
    let is_whole = sum(&bytes[..end - 4]) == u32::from_le_bytes(told);
    Ok(if is_whole { Record::Whole(bytes) } else { Record::Damaged })
}

fn window(bytes: &[u8]) -> Window {
    let number =
        |i: usize| u32::from_le_bytes([bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]]);
    Window { x: number(0), y: number(1), width: number(2), height: number(3) }
}

/// Restores the samples of a whole record; returns its tile.
fn restore(bytes: &[u8], film: &mut Film) -> Window {
    let tile = window(bytes);
    let mut samples = bytes[16..].chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    for (x, y) in tile.pixels() {
        for plane in film.planes_mut() {
            let bits: Vec<u32> = samples.by_ref().take(plane.channels().len()).collect();
            match plane.kind() {
                SampleKind::F32 => {
                    plane.set_f32(x, y, &bits.iter().map(|b| f32::from_bits(*b)).collect::<Vec<_>>())
                }
                SampleKind::U32 => plane.set_u32(x, y, &bits),
            }
        }
    }
    tile
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PlaneSpec;

    const fn spec(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
        PlaneSpec { name, channels, unit: "1", kind, doc: "" }
    }
    const SPECS: &[PlaneSpec] =
        &[spec("", &["R", "G", "B"], SampleKind::F32), spec("stop", &["id"], SampleKind::U32)];
    const WINDOW: Window = Window { x: 3, y: 2, width: 20, height: 12 };
    const TILES: [Window; 3] = [
        Window { x: 3, y: 2, width: 8, height: 8 },
        Window { x: 11, y: 2, width: 8, height: 8 },
        Window { x: 19, y: 10, width: 4, height: 4 },
    ];

    fn blank(seed: u32) -> Film {
        let mut film = Film::new([40, 30], WINDOW, SPECS).unwrap();
        film.metadata_mut().set("seed", seed);
        film.metadata_mut().set("method", "exact");
        film
    }

    fn film() -> Film {
        let mut film = blank(1);
        for (i, (x, y)) in WINDOW.pixels().enumerate() {
            film.plane_mut("").unwrap().set_f32(x, y, &[i as f32 / 3.0, -0.0, f32::INFINITY]);
            film.plane_mut("stop").unwrap().set_u32(x, y, &[3 + i as u32]);
        }
        film
    }

    /// A blank copy of the film into which only these tiles are copied.
    fn only(tiles: &[Window]) -> Film {
        let (mut out, film) = (blank(1), film());
        for tile in tiles {
            for y in tile.y..tile.y + tile.height {
                out.copy_pixels([tile.x, y], &film, [tile.x, y], tile.width);
            }
        }
        out
    }

    fn written(path: &Path, tiles: &[Window]) {
        let (mut checkpoint, resumed) = Checkpoint::open(path, &blank(1)).unwrap();
        assert!(resumed.tiles.is_empty() && resumed.damage.is_none());
        tiles.iter().for_each(|tile| checkpoint.add(&film(), *tile).unwrap());
    }

    #[test]
    fn tiles_come_back_bit_by_bit_and_more_are_added() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.checkpoint");
        written(&path, &TILES[..2]);
        let (mut checkpoint, resumed) = Checkpoint::open(&path, &blank(1)).unwrap();
        assert_eq!(
            (resumed.tiles, resumed.film, resumed.damage),
            (TILES[..2].to_vec(), only(&TILES[..2]), None)
        );
        checkpoint.add(&film(), TILES[2]).unwrap();
        let length = || fs::metadata(&path).unwrap().len();
        let before = length();
        TILES.iter().for_each(|tile| checkpoint.add(&film(), *tile).unwrap());
        assert_eq!(length(), before, "it has them");
        assert!(Checkpoint::open(&path, &blank(1)).unwrap_err().to_string().contains("another program"));
        drop(checkpoint);
        let (checkpoint, resumed) = Checkpoint::open(&path, &blank(1)).unwrap();
        assert_eq!((resumed.tiles, resumed.film), (TILES.to_vec(), only(&TILES)));
        checkpoint.remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn whatever_is_cut_off_or_changed_is_told_and_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.checkpoint");
        written(&path, &TILES);
        let whole = fs::read(&path).unwrap();
        let head = head(&blank(1)).len();
        let ends = [0, 1, 2, 3]
            .map(|n| head + TILES[..n].iter().map(|t| 20 + 16 * t.area() as usize).sum::<usize>());
        assert_eq!(ends[3], whole.len());
        for cut in head..whole.len() {
            fs::write(&path, &whole[..cut]).unwrap();
            let (checkpoint, resumed) = Checkpoint::open(&path, &blank(1)).unwrap();
            let n = ends.iter().rposition(|end| *end <= cut).unwrap();
            let is_truncated = resumed.damage.map(|damage| damage.contains("truncated"));
            let expected = (ends[n] != cut).then_some(true);
            assert_eq!((resumed.tiles.len(), is_truncated), (n, expected), "cut at {cut}");
            drop(checkpoint);
            assert_eq!(fs::metadata(&path).unwrap().len(), ends[n] as u64, "what is not used is gone");
        }
        for at in (head..whole.len()).step_by(7) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x40;
            fs::write(&path, &bytes).unwrap();
            let (_checkpoint, resumed) = Checkpoint::open(&path, &blank(1)).unwrap();
            let n = ends.iter().rposition(|end| *end <= at).unwrap();
            assert_eq!(resumed.tiles, TILES[..n], "changed at {at}");
            assert!(resumed.damage.is_some() && resumed.film == only(&TILES[..n]));
        }
    }

    #[test]
    fn checkpoints_of_other_renders_and_other_files_are_refused_and_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.checkpoint");
        written(&path, &TILES);
        let bytes = fs::read(&path).unwrap();
        let said = |film: &Film| Checkpoint::open(&path, film).unwrap_err().to_string();
        assert!(said(&blank(2)).contains("seed = \"1\", not \"2\""), "{}", said(&blank(2)));
        let other = Film::new([40, 30], Window { width: 19, ..WINDOW }, SPECS).unwrap();
        assert!(said(&other).contains("window [3,2,20,12], not [3,2,19,12]"), "{}", said(&other));
        assert_eq!(fs::read(&path).unwrap(), bytes, "left as it is");
        for (at, words) in [(3, "something else"), (8, "another version"), (30, "a damaged head")] {
            let mut changed = bytes.clone();
            changed[at] ^= 1;
            fs::write(&path, &changed).unwrap();
            assert!(said(&blank(1)).contains(words), "{at}: {}", said(&blank(1)));
            assert_eq!(fs::read(&path).unwrap(), changed);
        }
        fs::write(&path, &bytes[..12]).unwrap();
        assert!(said(&blank(1)).contains("a truncated head"), "{}", said(&blank(1)));
    }
}
