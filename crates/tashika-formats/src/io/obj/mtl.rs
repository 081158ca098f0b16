//! Statements of MTL files, as lists; [`materials`](super::materials) converts them to materials.
//!
//! The parser reads colours (`Kd`, `Ks`, `Ke`, `Tf`), numbers (`Ns`, `Ni`, `d`, `Tr`, `illum`, and
//! `Pr`, `Pm` of the physically based extension) and texture statements (`map_Kd`, `map_Ks`,
//! `map_Ke`, `map_d`, `map_Pr`, `map_Pm`, `norm`), with keywords in any case of letters. Other
//! statements of the format are ignored and noted by the table of [`features`](super::features),
//! except the ambient terms, which global illumination replaces.
//!
//! Sources: the Wavefront MTL specification, version 4.2 (1995); the extension by
//! Exocortex/Clara.io.
//!
//! # Guarantee
//! If a name is defined several times, also in several libraries, the first definition counts.
//!
//! Tested by `suite::obj` and `suite::damaged_obj`.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use super::features::{BUMP, MATERIAL, MODIFIED, SHEEN, SPECTRAL};
use super::map::Map;
use super::parse::MAX_UNKNOWN;
use super::tally::Tally;
use super::text::{Lines, excerpt, name, number, split_keyword, values, words};
use crate::color::Rgb;
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::notes::Named;
use crate::scene::{NoteKind, Notes};

/// A `newmtl` with its statements.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Definition {
    /// Location of the `newmtl`.
    pub(super) at: Location,
    /// Folder of the library, as the start of a reference: empty, or ending in a separator.
    pub(super) folder: String,
    pub(super) kd: Option<Rgb>,
    pub(super) ks: Option<Rgb>,
    pub(super) ke: Option<Rgb>,
    pub(super) tf: Option<Rgb>,
    pub(super) ns: Option<f32>,
    pub(super) ni: Option<f32>,
    pub(super) d: Option<f32>,
    pub(super) tr: Option<f32>,
    pub(super) pr: Option<f32>,
    pub(super) pm: Option<f32>,
    /// Rounded; the specification has 0 to 10.
    pub(super) illum: Option<u32>,
    pub(super) map_kd: Option<Map>,
    pub(super) map_ks: Option<Map>,
    pub(super) map_ke: Option<Map>,
    pub(super) map_d: Option<Map>,
    pub(super) map_pr: Option<Map>,
    pub(super) map_pm: Option<Map>,
    pub(super) norm: Option<Map>,
}

/// The definitions of all libraries of a scene, by name.
pub(super) type Definitions = HashMap<String, Definition>;

/// Adds the definitions in `text`.
///
/// * `file`: the library, for messages.
/// * `folder`: see [`Definition::folder`].
///
/// # Errors
/// [`Error::Invalid`] with line and material for words that are no numbers.
pub(super) fn parse(
    text: &[u8],
    file: &Path,
    folder: &str,
    definitions: &mut Definitions,
    notes: &mut Notes,
) -> Result<()> {
    let mut parser = Parser {
        file,
        folder,
        current: None,
        definitions,
        tally: Tally::default(),
        unknown: Named::new(MAX_UNKNOWN),
    };
    let mut lines = Lines::new(text);
    while let Some((line, statement)) = lines.next() {
        if !statement.is_empty() && statement[0] != b'#' {
            parser.statement(line, statement, notes)?;
        }
    }
    parser.close();
    parser.tally.report(file, notes);
    Ok(())
}

struct Parser<'a> {
    file: &'a Path,
    folder: &'a str,
    current: Option<(String, Definition)>,
    definitions: &'a mut Definitions,
    tally: Tally,
    unknown: Named,
}

impl Parser<'_> {
    fn close(&mut self) {
        let Some((name, definition)) = self.current.take() else { return };
        match self.definitions.entry(name) {
            Entry::Vacant(slot) => {
                slot.insert(definition);
            }
            Entry::Occupied(slot) => {
                // Some exporters write a material at each use and repeat it word by word.
                let first = Definition { at: definition.at.clone(), ..slot.get().clone() };
                if first != definition {
                    let message = "materials defined again in another way: the first definition counts";
                    self.tally.add(NoteKind::Ignored, message, definition.at.line.unwrap_or(1));
                }
            }
        }
    }

    fn statement(&mut self, line: u32, statement: &[u8], notes: &mut Notes) -> Result<()> {
        let (keyword, rest) = split_keyword(statement);
        let lower = keyword.to_ascii_lowercase();
        if lower == b"newmtl" {
            self.close();
            let name = name(rest);
            let at = Location::line(self.file, line).item(format!("newmtl {name}"));
            self.current =
                Some((name, Definition { at, folder: self.folder.to_owned(), ..Definition::default() }));
            return Ok(());
        }
        let Some((material, definition)) = &mut self.current else {
            self.tally.add(NoteKind::Ignored, "material statements before the first newmtl", line);
            return Ok(());
        };
        let reader = Reader { file: self.file, line, material, keyword, rest };
        let mut met = |name| self.tally.met(MATERIAL, name, line);
        match lower.as_slice() {
            b"kd" | b"ks" | b"ke" | b"tf" => {
                let slot = match lower.as_slice() {
                    b"kd" => &mut definition.kd,
                    b"ks" => &mut definition.ks,
                    b"ke" => &mut definition.ke,
                    _ => &mut definition.tf,
                };
                match reader.color()? {
                    Some(color) => *slot = Some(color),
                    None => met(SPECTRAL),
                }
            }
            b"ns" => definition.ns = Some(reader.number()?),
            b"ni" => definition.ni = Some(reader.number()?),
            b"d" => definition.d = Some(reader.number()?),
            b"tr" => definition.tr = Some(reader.number()?),
            b"pr" => definition.pr = Some(reader.number()?),
            b"pm" => definition.pm = Some(reader.number()?),
            // Numbers that are not finite become 0, the largest or the smallest.
            b"illum" => definition.illum = Some(reader.number()?.round() as u32),
            b"map_kd" | b"map_ks" | b"map_ke" | b"map_d" | b"map_pr" | b"map_pm" | b"norm" | b"map_norm"
            | b"map_kn" => {
                let slot = match lower.as_slice() {
                    b"map_kd" => &mut definition.map_kd,
                    b"map_ks" => &mut definition.map_ks,
                    b"map_ke" => &mut definition.map_ke,
                    b"map_d" => &mut definition.map_d,
                    b"map_pr" => &mut definition.map_pr,
                    b"map_pm" => &mut definition.map_pm,
                    _ => &mut definition.norm,
                };
                match Map::parse(rest, line) {
                    None => self.tally.add(NoteKind::Ignored, "texture statements without a file name", line),
                    Some(map) => {
                        if map.modified {
                            met(MODIFIED);
                        }
                        *slot = Some(map);
                    }
                }
            }
            b"ka" | b"map_ka" | b"map_aat" | b"sharpness" => {}
            b"bump" | b"map_bump" | b"disp" | b"map_disp" => met(BUMP),
            b"refl" | b"map_refl" => met("refl"),
            b"decal" => met("decal"),
            b"map_ns" => met("map_Ns"),
            b"ps" | b"pc" | b"pcr" | b"aniso" | b"anisor" | b"map_ps" | b"map_pc" | b"map_pcr"
            | b"map_aniso" | b"map_anisor" | b"map_rma" | b"map_orm" => {
                met(SHEEN);
            }
            _ => {
                let word = name(keyword);
                if let Some(near) = nearest_name(&word, ["newmtl", "illum"]) {
                    let at = Location::line(self.file, line);
                    return Err(Error::misspelt(at, MATERIAL, &excerpt(keyword), near));
                }
                let message = format!("material statements {:?}, which are not known", excerpt(keyword));
                let further = "further material statements that are not known";
                let at = Location::line(self.file, line);
                self.unknown.add(NoteKind::Ignored, message, further, at, notes);
            }
        }
        Ok(())
    }
}

/// Arguments of one statement.
struct Reader<'a> {
    file: &'a Path,
    line: u32,
    material: &'a str,
    keyword: &'a [u8],
    rest: &'a [u8],
}

impl Reader<'_> {
    fn invalid(&self, expected: &str) -> Error {
        let found = format!("{} {}", name(self.keyword), excerpt(self.rest));
        let at = Location::line(self.file, self.line).item(format!("newmtl {}", self.material));
        Error::invalid(at, found.trim_end(), expected)
    }

    /// Reads the first argument after any options (`d -halo 0.5`).
    fn number(&self) -> Result<f32> {
        let word = values(self.rest).find(|word| *word != b"-halo");
        word.and_then(number).ok_or_else(|| self.invalid("a number"))
    }

    /// Reads red, green and blue, or one number for all; none if the colour is spectral or in XYZ.
    fn color(&self) -> Result<Option<Rgb>> {
        if words(self.rest).next().is_some_and(|w| w == b"spectral" || w == b"xyz") {
            return Ok(None);
        }
        let expected = "one number, or three";
        let mut channels = [0.0; 3];
        let mut given = 0;
        for (slot, word) in channels.iter_mut().zip(values(self.rest)) {
            *slot = number(word).ok_or_else(|| self.invalid(expected))?;
            given += 1;
        }
        match given {
            1 => Ok(Some(Rgb::gray(channels[0]))),
            3 => Ok(Some(channels.into())),
            _ => Err(self.invalid(expected)),
        }
    }
}
