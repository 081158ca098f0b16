//! Archives (`.usdz`): several files in one ZIP archive without compression.
//!
//! Files are located by the list at the archive's end and are not copied. The first one is the
//! scene.
//!
//! # Guarantee
//! Any byte string gives either files that lie inside it, or an error.
//!
//! Held to this by the tests below, and `usd` and `damaged_usd` of the suite.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::binary::Bytes;
use crate::error::{Error, Location, Result};
use crate::io::notes::shown;
use crate::io::text::utf8_or_latin1;

/// First bytes of an archive.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";

const END_OF_LIST: &[u8] = b"PK\x05\x06";
const ENTRY: &[u8] = b"PK\x01\x02";

/// An archive.
#[derive(Debug)]
pub(super) struct Package {
    /// File name that messages give.
    pub name: PathBuf,
    bytes: Rc<Vec<u8>>,
    /// Beginning and end of each file (bytes), by name.
    files: BTreeMap<String, (usize, usize)>,
    /// Name of the first file.
    pub first: String,
}

impl Package {
    pub fn new(bytes: Vec<u8>, name: &Path) -> Result<Self> {
        let invalid = |found: &str, expected: &str| Error::invalid(Location::file(name), found, expected);
        let short = |at: usize| Some(usize::from(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?])));
        let long = |at: usize| Some(short(at)? | short(at + 2)? << 16);
        let is = |at: usize, mark: &[u8]| bytes.get(at..).is_some_and(|rest| rest.starts_with(mark));
        // The end record has 22 bytes, followed by a comment of at most 65,535 bytes.
        let last = bytes.len().saturating_sub(22);
        let first = last.saturating_sub(0xffff);
        let end = (first..=last).rev().find(|&at| is(at, END_OF_LIST));
        let end = end.ok_or_else(|| invalid("no list of files", "a whole archive: is it cut off?"))?;
        let cut = || invalid("a list of files beyond the end", "a whole archive");
        let (count, mut at) = (short(end + 10).ok_or_else(cut)?, long(end + 16).ok_or_else(cut)?);
        let (mut files, mut first) = (BTreeMap::new(), None);
        for _ in 0..count {
            if !is(at, ENTRY) {
                return Err(cut());
            }
            let [method, size, start] =
                [short(at + 10), long(at + 24), long(at + 42)].map(|v| v.ok_or_else(cut));
            let (method, size, start) = (method?, size?, start?);
            let [length, extra, comment] = [28, 30, 32].map(|field| short(at + field).ok_or_else(cut));
            let (length, extra, comment) = (length?, extra?, comment?);
            let text = bytes.get(at + 46..at + 46 + length).ok_or_else(cut)?;
            let text = utf8_or_latin1(text).into_owned();
            at += 46 + length + extra + comment;
            if text.ends_with('/') {
                continue;
            }
            if method != 0 {
                let at = Location::file(name).item(shown(&text));
                return Err(Error::unsupported(at, "a compressed file", "usdzip stores files as they are"));
            }
            let (own, more) = (short(start + 26).ok_or_else(cut)?, short(start + 28).ok_or_else(cut)?);
            let from = start + 30 + own + more;
            let to = from + size;
            if !is(start, MAGIC) || to > bytes.len() {
                return Err(invalid(&format!("{text:?} beyond the end"), "a whole archive"));
            }
            first.get_or_insert_with(|| text.clone());
            files.entry(text).or_insert((from, to));
        }
        let first = first.ok_or_else(|| invalid("an archive without files", "a scene in it"))?;
        Ok(Self { name: name.to_owned(), bytes: Rc::new(bytes), files, first })
    }

    /// The bytes of a file. The name may contain `..` if it does not lead out of the archive.
    pub fn file(&self, name: &str) -> Option<Bytes> {
        let (from, to) = *self.files.get(&plain(name)?)?;
        Some(Bytes { all: Rc::clone(&self.bytes), from, to })
    }
}

/// Resolves the steps `.` and `..` of a name; returns none if it leads out of the archive.
pub(super) fn plain(name: &str) -> Option<String> {
    let mut steps: Vec<&str> = Vec::new();
    for step in name.split(['/', '\\']).filter(|s| !s.is_empty() && *s != ".") {
        if step == ".." {
            steps.pop()?;
        } else {
            steps.push(step);
        }
    }
    Some(steps.join("/"))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// An archive of these files.
    fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
        let (mut bytes, mut list) = (Vec::new(), Vec::new());
        for (name, content) in files {
            let start = bytes.len() as u32;
            let (size, length) = ((content.len() as u32).to_le_bytes(), (name.len() as u16).to_le_bytes());
            bytes
                .extend([MAGIC, &[0; 14], &size, &size, &length, &[0; 2], name.as_bytes(), content].concat());
            list.extend([ENTRY, &[0; 16], &size, &size, &length, &[0; 12], &start.to_le_bytes()].concat());
            list.extend(name.as_bytes());
        }
        let start = bytes.len() as u32;
        bytes.extend(&list);
        let count = (files.len() as u16).to_le_bytes();
        bytes.extend([END_OF_LIST, &[0; 4], &count, &count].concat());
        bytes.extend([&(list.len() as u32).to_le_bytes()[..], &start.to_le_bytes(), &[0; 2]].concat());
        bytes
    }

    fn open(bytes: Vec<u8>) -> Result<Package> {
        Package::new(bytes, Path::new("a.usdz"))
    }

    #[test]
    fn files_are_found_by_their_names() {
        let package = open(archive(&[("b.usda", b"one"), ("t/c.png", b"two")])).unwrap();
        assert_eq!(package.first, "b.usda");
        let file = |name: &str| package.file(name).map(|bytes| bytes.get().to_vec());
        assert_eq!(file("t/../t/./c.png"), Some(b"two".to_vec()));
        assert_eq!([file("c.png"), file("../b.usda"), file("")], [None, None, None]);
    }

    #[test]
    fn archives_that_are_cut_off_or_changed_are_refused_or_read_within_their_bytes() {
        let whole = archive(&[("b.usda", b"one"), ("c", b"two")]);
        for length in 0..whole.len() {
            assert!(open(whole[..length].to_vec()).is_err(), "{length} bytes");
        }
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            if let Ok(package) = open(bytes) {
                assert!(package.file(&package.first).is_some());
            }
        }
        let mut bytes = whole.clone();
        let at = whole.windows(4).position(|w| w == ENTRY).unwrap();
        bytes[at + 10] = 8;
        assert!(open(bytes).unwrap_err().to_string().contains("a compressed file is not supported"));
    }
}
