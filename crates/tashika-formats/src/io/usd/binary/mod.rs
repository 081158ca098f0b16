//! `.usdc`: layers as "crate" files of versions 0.4 to 0.13.
//!
//! A file is a head, a table of sections, and the sections: tokens, strings, fields, sets of
//! fields, paths, and the specs that join a path to a set of fields.
//!
//! | module | purpose |
//! |---|---|
//! | [`bytes`] | bytes within bounds, compressed parts |
//! | [`values`] | values by their type |
//! | [`specs`] | a layer from the sections |
//! | this one | the sections |
//!
//! # Guarantee
//! Any byte string gives a layer or an error. All counts are checked against the bytes that the
//! file has; unpacked bytes stay within the budgets of [`parse`].
//!
//! Held to this by `tests` with files that Pixar's own library wrote (`scripts/usd_samples.py`),
//! and by `damaged_usd` of the suite.

mod bytes;
mod specs;
#[cfg(test)]
mod tests;
mod values;

use std::cell::Cell;
use std::path::Path;

pub(super) use self::bytes::Bytes;
use self::bytes::{Cursor, Kind, Read};
use super::layer::Layer;
use super::value::{Text, Value};
use crate::error::{Error, Location, Result};

/// First bytes of a binary file.
pub(super) const MAGIC: &[u8] = b"PXR-USDC";

/// Versions that are read; 0.4 is the first with compressed sections.
const VERSIONS: std::ops::RangeInclusive<[u8; 2]> = [0, 4]..=[0, 13];

/// Largest depth of a path (names).
const MAX_DEPTH: usize = 200;

/// A value as stored in the file: type, flags, and either the value itself or its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rep(pub u64);

/// A file whose sections have been read.
#[derive(Debug)]
pub(super) struct Binary {
    bytes: Bytes,
    version: [u8; 2],
    tokens: Vec<Text>,
    /// For each string, the index of its token.
    strings: Vec<u32>,
    paths: Vec<Text>,
    budget: Cell<u64>,
}

/// Reads a file. The tables may unpack `budget` bytes in all; the values that are read later may
/// unpack as many again.
pub(super) fn parse(bytes: Bytes, name: &Path, budget: u64) -> Result<Layer> {
    let at = || Location::file(name);
    let version: [u8; 2] = match bytes.get().get(8..10) {
        Some(&[major, minor]) => [major, minor],
        _ => return Err(Error::invalid(at(), "a file that ends in its head", "88 bytes of head")),
    };
    if !VERSIONS.contains(&version) {
        let [major, minor] = version;
        let what = format!("version {major}.{minor} of binary USD");
        return Err(Error::unsupported(at(), what, "versions 0.4 to 0.13 are read; usdcat converts it"));
    }
    let result = sections(bytes, version, budget).and_then(|(binary, sections)| {
        let layer = specs::layer(&binary, &sections, name)?;
        Ok(Layer { binary: Some(binary), ..layer })
    });
    result.map_err(|wrong| Error::invalid(at(), wrong, "a sound file: is it cut off?"))
}

/// Sections from which the specs of a layer are built.
struct Sections {
    /// Name and value of each field.
    fields: Vec<(u32, Rep)>,
    /// Indices of the fields of all sets, one set after the other; [`u32::MAX`] ends a set.
    field_sets: Vec<i64>,
    /// Path, set of fields, and type of each spec.
    specs: Vec<[i64; 3]>,
}

fn sections(bytes: Bytes, version: [u8; 2], budget: u64) -> Read<(Binary, Sections)> {
    let mut binary = Binary {
        bytes,
        version,
        tokens: Vec::new(),
        strings: Vec::new(),
        paths: Vec::new(),
        budget: Cell::new(budget),
    };
    let mut head = binary.cursor(16)?;
    let table = head.u64()?;
    let mut table = binary.cursor(usize::try_from(table).unwrap_or(usize::MAX))?;
    let count = table.count(32)?;
    let mut places = Vec::new();
    for _ in 0..count {
        let name = table.fixed::<16>()?;
        let (start, size) = (table.u64()?, table.u64()?);
        let name: String = name.iter().take_while(|b| **b != 0).map(|&b| char::from(b)).collect();
        places.push((name, start, size));
    }
    let section = |binary: &Binary, name: &str| -> Read<Vec<u8>> {
        let (_, start, size) =
            places.iter().find(|p| p.0 == name).ok_or_else(|| format!("no section {name}"))?;
        let start = usize::try_from(*start).unwrap_or(usize::MAX);
        let size = usize::try_from(*size).unwrap_or(usize::MAX);
        binary.cursor(start)?.take(size).map(<[u8]>::to_vec)
    };
    // Sections are copied, because `binary` holds the file and is changed while they are read.
    let part = section(&binary, "TOKENS")?;
    binary.tokens = tokens(&mut binary.over(&part))?;
    let part = section(&binary, "STRINGS")?;
    binary.strings = {
        let mut cursor = binary.over(&part);
        let count = cursor.count(4)?;
        (0..count).map(|_| cursor.u32()).collect::<Read<_>>()?
    };
    let part = section(&binary, "FIELDS")?;
    let fields = fields(&mut binary.over(&part))?;
    let part = section(&binary, "FIELDSETS")?;
    let field_sets = {
        let mut cursor = binary.over(&part);
        let count = claimed(&mut cursor)?;
        cursor.integers(count, Kind::Unsigned)?
    };
    let part = section(&binary, "PATHS")?;
    binary.paths = paths(&mut binary.over(&part), &binary.tokens)?;
    let part = section(&binary, "SPECS")?;
    let specs = {
        let mut cursor = binary.over(&part);
        let count = claimed(&mut cursor)?;
        let columns = [(); 3].map(|()| cursor.integers(count, Kind::Unsigned));
        let [paths, sets, types] = columns;
        let (paths, sets, types) = (paths?, sets?, types?);
        (0..count).map(|i| [paths[i], sets[i], types[i]]).collect()
    };
    // The tables are complete. The values, which are read on demand, have the whole budget again.
    binary.budget.set(budget);
    Ok((binary, Sections { fields, field_sets, specs }))
}

/// Reads a count of compressed items. It can be checked only after the items are unpacked.
fn claimed(cursor: &mut Cursor<'_>) -> Read<usize> {
    let count = cursor.u64()?;
    usize::try_from(count).ok().filter(|_| count < 1 << 40).ok_or_else(|| format!("a list of {count}"))
}

fn tokens(cursor: &mut Cursor<'_>) -> Read<Vec<Text>> {
    let (count, size) = (claimed(cursor)?, claimed(cursor)?);
    let packed = cursor.count(1)?;
    let text = cursor.unpacked(packed, size)?;
    cursor.spend(32 * text.len() as u64)?;
    // Each token ends with a zero.
    let mut all: Vec<Text> = text.split(|b| *b == 0).map(|t| String::from_utf8_lossy(t).into()).collect();
    all.truncate(count);
    if all.len() < count {
        return Err(format!("{} tokens instead of {count}", all.len()));
    }
    Ok(all)
}

fn fields(cursor: &mut Cursor<'_>) -> Read<Vec<(u32, Rep)>> {
    let count = claimed(cursor)?;
    let names = cursor.integers(count, Kind::Unsigned)?;
    let packed = cursor.count(1)?;
    let reps = cursor.unpacked(packed, count.saturating_mul(8))?;
    let reps = reps.as_chunks::<8>().0;
    if reps.len() < names.len() {
        return Err(format!("{} values of {} fields", reps.len(), names.len()));
    }
    Ok(names.iter().zip(reps).map(|(&name, rep)| (name as u32, Rep(u64::from_le_bytes(*rep)))).collect())
}

/// Reads all paths into a list, at their indices in the file.
fn paths(cursor: &mut Cursor<'_>, tokens: &[Text]) -> Read<Vec<Text>> {
    let (total, count) = (claimed(cursor)?, claimed(cursor)?);
    let indices = cursor.integers(count, Kind::Unsigned)?;
    let elements = cursor.integers(count, Kind::Signed)?;
    let jumps = cursor.integers(count, Kind::Signed)?;
    if total > count {
        return Err(format!("{count} of {total} paths"));
    }
    let mut paths: Vec<Text> = vec![Text::from(""); total];
    // Branches that are still to be read: first element, path of the parent, and depth.
    let mut branches: Vec<(usize, Option<Text>, usize)> = vec![(0, None, 0)];
    let mut visited = 0;
    while let Some((mut at, mut parent, mut depth)) = branches.pop() {
        while at < count {
            visited += 1;
            if visited > count || depth > MAX_DEPTH {
                return Err("paths that form no tree, or are too deep".to_owned());
            }
            let path: Text = match &parent {
                None => "/".into(),
                Some(parent) => {
                    let element = elements[at];
                    let token = tokens.get(element.unsigned_abs() as usize);
                    let token = token.ok_or_else(|| format!("token {element} of a path"))?;
                    cursor.spend((parent.len() + token.len() + 24) as u64)?;
                    joined(parent, token, element < 0)
                }
            };
            let place = usize::try_from(indices[at]).ok().and_then(|i| paths.get_mut(i));
            *place.ok_or_else(|| format!("path {} of {total}", indices[at]))? = path.clone();
            let jump = jumps[at];
            let (has_child, has_sibling) = (jump > 0 || jump == -1, jump >= 0);
            if has_child {
                if has_sibling {
                    let sibling = at.saturating_add(jump as usize);
                    branches.push((sibling, parent, depth));
                }
                parent = Some(path);
                depth += 1;
            } else if !has_sibling {
                break;
            }
            at += 1;
        }
    }
    Ok(paths)
}

/// A path with one more element: a property, a variant or a prim.
fn joined(parent: &str, token: &str, is_property: bool) -> Text {
    if is_property {
        format!("{parent}.{token}").into()
    } else if token.starts_with('{') || parent == "/" || parent.ends_with('}') {
        format!("{parent}{token}").into()
    } else {
        format!("{parent}/{token}").into()
    }
}

impl Binary {
    /// Cursor at a position in the file.
    fn cursor(&self, at: usize) -> Read<Cursor<'_>> {
        let bytes = self.bytes.get();
        if at > bytes.len() {
            return Err(format!("byte {at} of {}", bytes.len()));
        }
        Ok(Cursor { bytes, at, budget: &self.budget })
    }

    fn over<'a>(&'a self, bytes: &'a [u8]) -> Cursor<'a> {
        Cursor { bytes, at: 0, budget: &self.budget }
    }

    fn token(&self, index: u32) -> Read<Text> {
        self.tokens.get(index as usize).cloned().ok_or_else(|| format!("token {index}"))
    }

    fn string(&self, index: u32) -> Read<Text> {
        let token = self.strings.get(index as usize).ok_or_else(|| format!("string {index}"))?;
        self.token(*token)
    }

    fn path(&self, index: u32) -> Read<Text> {
        self.paths.get(index as usize).cloned().ok_or_else(|| format!("path {index}"))
    }

    /// A value of the file.
    pub(super) fn value(&self, rep: Rep) -> Result<Value, String> {
        values::value(self, rep, 0)
    }
}
