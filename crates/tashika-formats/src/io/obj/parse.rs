//! Statements of an OBJ file, as lists.
//!
//! The parser reads `v`, `vt`, `vn`, `f` (and its old name `fo`), `usemtl`, `mtllib`, `s`; `o` and
//! `g` only name parts. Other statements of the format are ignored, with the notes of the table in
//! [`features`](super::features). Statements that are not part of the format are noted by name.
//! Source: the Wavefront Advanced Visualizer manual, appendix B1.
//!
//! # Guarantee
//! Every index of every [`Corner`] is in range of its list or [`NONE`]; every face has at least
//! three corners. Memory is proportional to the text.
//!
//! Indices may point forward, so they are checked at the end. The line of each face is stored until
//! then.
//!
//! Tested by `suite::obj` and `suite::damaged_obj`.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use glam::{DVec3, Vec2, Vec3};

use super::features::{COMMANDS, DISPLAY, FREE_FORM, OUTER_MAPS, STATEMENT, VERTEX_COLORS};
use super::tally::Tally;
use super::text::{Lines, excerpt, name, number, split_keyword, values, wide_number};
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::notes::Named;
use crate::math::LocalPlaces;
use crate::scene::{NoteKind, Notes};

/// Index of an attribute that a corner does not have.
pub(super) const NONE: u32 = u32::MAX;

/// Most different unknown keywords that notes name.
pub(super) const MAX_UNKNOWN: usize = 20;

/// One corner of a face: positions in the lists of [`Geometry`], from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// A polygon with its material and smoothing group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Position of the first corner in [`Geometry::corners`].
    first: u32,
    /// Number of corners.
    count: u32,
    /// Number of the line in the file.
    pub(super) line: u32,
    /// Position in [`Geometry::materials`].
    pub(super) material: u32,
    /// Number of the smoothing group; 0 is none.
    pub(super) smoothing: u32,
}

impl Face {
    /// Range of the corners in [`Geometry::corners`].
    pub(super) fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..self.first as usize + self.count as usize
    }
}

/// A name with the line of its first use.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    pub(super) name: String,
    pub(super) line: u32,
}

/// Contents of an OBJ file.
#[derive(Default)]
pub(super) struct Geometry {
    /// Points of `v` (m); emptied at the end of the file.
    places: Vec<DVec3>,
    /// Points of `v` (m), relative to `origin`; filled at the end of the file.
    pub(super) positions: Vec<Vec3>,
    /// Origin of the positions (m).
    pub(super) origin: DVec3,
    /// Texture coordinates of `vt`, with `v` up.
    pub(super) uvs: Vec<Vec2>,
    /// Vectors of `vn`, of any length.
    pub(super) normals: Vec<Vec3>,
    pub(super) corners: Vec<Corner>,
    pub(super) faces: Vec<Face>,
    /// Names of `usemtl`; the first, which is empty, stands for faces before any `usemtl`.
    pub(super) materials: Vec<Reference>,
    /// Names of `mtllib`: the rest of each line, without repetitions.
    pub(super) libraries: Vec<Reference>,
}

/// Reads the statements of `text`; `file` is for messages.
///
/// # Errors
/// [`Error::Invalid`] with the line for words that are no numbers and indices out of range, and for
/// text without a single OBJ statement.
pub(super) fn parse(text: &[u8], file: &Path, notes: &mut Notes) -> Result<Geometry> {
    let mut parser = Parser::new(file);
    let mut lines = Lines::new(text);
    while let Some((line, statement)) = lines.next() {
        if !statement.is_empty() && statement[0] != b'#' {
            parser.statement(line, statement, notes)?;
        }
    }
    parser.finish(notes)
}

struct Parser<'a> {
    file: &'a Path,
    geometry: Geometry,
    material_ids: HashMap<String, u32>,
    library_names: HashSet<String>,
    material: u32,
    smoothing: u32,
    tally: Tally,
    unknown: Named,
    first_unknown: Option<(u32, String)>,
    known_statements: bool,
}

impl<'a> Parser<'a> {
    fn new(file: &'a Path) -> Self {
        let before_any = Reference { name: String::new(), line: 1 };
        Self {
            file,
            geometry: Geometry { materials: vec![before_any], ..Geometry::default() },
            material_ids: HashMap::from([(String::new(), 0)]),
            library_names: HashSet::new(),
            material: 0,
            smoothing: 0,
            tally: Tally::default(),
            unknown: Named::new(MAX_UNKNOWN),
            first_unknown: None,
            known_statements: false,
        }
    }

    fn invalid(&self, line: u32, found: impl Into<String>, expected: impl Into<String>) -> Error {
        Error::invalid(Location::line(self.file, line), found, expected)
    }

    fn statement(&mut self, line: u32, statement: &[u8], notes: &mut Notes) -> Result<()> {
        let (keyword, rest) = split_keyword(statement);
        let mut met = |name| self.tally.met(STATEMENT, name, line);
        match keyword {
            b"v" => {
                let (xyz, more) = self.numbers("v", line, (rest, wide_number), 3)?;
                // A fourth number is the weight `w`, which matters to rational curves only.
                if more >= 3 {
                    self.tally.met(STATEMENT, VERTEX_COLORS, line);
                }
                self.geometry.places.push(xyz.into());
            }
            b"vt" => {
                let (uv, _) = self.numbers("vt", line, (rest, number), 1)?;
                self.geometry.uvs.push(uv.into());
            }
            b"vn" => {
                let (n, _) = self.numbers("vn", line, (rest, number), 3)?;
                self.geometry.normals.push(n.into());
            }
            b"f" | b"fo" => self.face(line, rest)?,
            b"usemtl" => self.use_material(line, rest),
            b"mtllib" => self.library(line, rest),
            b"s" => self.smoothing_group(line, rest),
            b"o" | b"g" | b"mg" => {}
            b"p" => met("p"),
            b"l" => met("l"),
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm"
            | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"bzp" | b"bsp" | b"cdc" | b"cdp"
            | b"res" => {
                met(FREE_FORM);
            }
            b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj" | b"ctech"
            | b"stech" => {
                met(DISPLAY);
            }
            b"maplib" | b"usemap" => met(OUTER_MAPS),
            b"call" | b"csh" => met(COMMANDS),
            _ => {
                let word = excerpt(keyword);
                let at = Location::line(self.file, line);
                // Bytes that are not text are reported by an error of their own.
                let near = nearest_name(&word, ["usemtl", "mtllib"]).filter(|_| self.known_statements);
                if let Some(near) = near {
                    return Err(Error::misspelt(at, STATEMENT, &word, near));
                }
                let message = format!("statements {word:?}, which are not of the format");
                let further = "further statements that are not of the format";
                self.unknown.add(NoteKind::Ignored, message, further, at, notes);
                self.first_unknown.get_or_insert((line, word));
                return Ok(());
            }
        }
        self.known_statements = true;
        Ok(())
    }

    /// Reads the first `N` numbers of a statement, of which only the first `required` must be
    /// there. Returns them and the number of words after them.
    fn numbers<const N: usize, T: Copy + Default>(
        &self,
        keyword: &str,
        line: u32,
        (rest, number): (&[u8], impl Fn(&[u8]) -> Option<T>),
        required: usize,
    ) -> Result<([T; N], usize)> {
        let mut words = values(rest);
        let mut numbers = [T::default(); N];
        for (i, slot) in numbers.iter_mut().enumerate() {
            match words.next() {
                Some(word) => {
                    *slot = number(word).ok_or_else(|| {
                        self.invalid(line, format!("{keyword} with {:?}", excerpt(word)), "a number")
                    })?;
                }
                None if i >= required => break,
                None => {
                    let found = format!("{keyword} with {i} numbers");
                    return Err(self.invalid(line, found, format!("at least {required}")));
                }
            }
        }
        Ok((numbers, words.count()))
    }

    fn face(&mut self, line: u32, rest: &[u8]) -> Result<()> {
        let first = self.geometry.corners.len();
        for word in values(rest) {
            let corner = self.corner(line, word)?;
            self.geometry.corners.push(corner);
        }
        let corners = self.geometry.corners.len();
        if corners - first < 3 {
            self.geometry.corners.truncate(first);
            self.tally.add(NoteKind::Repaired, "faces of fewer than three corners: left out", line);
            return Ok(());
        }
        // The limit is one below the largest number, so that the length of any list made of corners
        // fits as well.
        if corners >= NONE as usize {
            return Err(Error::unsupported(
                Location::line(self.file, line),
                "more than 4294967294 face corners",
                "split the file",
            ));
        }
        self.geometry.faces.push(Face {
            first: first as u32,
            count: (corners - first) as u32,
            line,
            material: self.material,
            smoothing: self.smoothing,
        });
        Ok(())
    }

    /// Parses `v`, `v/t`, `v//n` or `v/t/n`. A trailing slash is tolerated, and so is an index 0,
    /// which exporters write for missing texture coordinates and normals.
    fn corner(&mut self, line: u32, word: &[u8]) -> Result<Corner> {
        let g = &self.geometry;
        let mut parts = word.split(|&b| b == b'/');
        let mut zeros = 0;
        let mut next = |kind: Kind, available: usize| match parts.next() {
            None | Some(b"") => Ok(NONE),
            Some(digits) if !matches!(kind, Kind::Position) && integer(digits) == Some(0) => {
                zeros += 1;
                Ok(NONE)
            }
            Some(digits) => self.index(line, word, digits, kind, available),
        };
        let corner = Corner {
            position: next(Kind::Position, g.places.len())?,
            uv: next(Kind::Uv, g.uvs.len())?,
            normal: next(Kind::Normal, g.normals.len())?,
        };
        if corner.position == NONE || parts.next().is_some() {
            return Err(self.malformed(line, word));
        }
        if zeros > 0 {
            let message = "face corners with index 0 of a texture coordinate or normal: without it";
            self.tally.add(NoteKind::Repaired, message, line);
        }
        Ok(corner)
    }

    fn malformed(&self, line: u32, word: &[u8]) -> Error {
        self.invalid(
            line,
            format!("face corner {:?}", excerpt(word)),
            "v, v/t, v//n or v/t/n with whole numbers",
        )
    }

    /// Converts an index to one from 0. Positive indices count from 1 and may point forward;
    /// negative ones count back from the `available` elements so far.
    fn index(&self, line: u32, word: &[u8], digits: &[u8], kind: Kind, available: usize) -> Result<u32> {
        let index = integer(digits).ok_or_else(|| self.malformed(line, word))?;
        let resolved = if index > 0 { index - 1 } else { available as i64 + index };
        if index == 0 {
            return Err(self.invalid(
                line,
                format!("{} index 0 in {:?}", kind.name(), excerpt(word)),
                "an index from 1, or from -1 backwards",
            ));
        }
        if resolved < 0 {
            return Err(self.invalid(
                line,
                format!("{} index {} in {:?}", kind.name(), excerpt(digits), excerpt(word)),
                match available {
                    0 => format!("a positive index, as there are no {} so far", kind.elements()),
                    1 => format!("-1, as there is 1 of the {} so far", kind.elements()),
                    n => format!("-1 to -{n}, as there are {n} {} so far", kind.elements()),
                },
            ));
        }
        u32::try_from(resolved).ok().filter(|&i| i != NONE).ok_or_else(|| {
            let found = format!("{} index {}", kind.name(), excerpt(digits));
            self.invalid(line, found, "an index of at most 4294967295")
        })
    }

    fn use_material(&mut self, line: u32, rest: &[u8]) {
        let materials = &mut self.geometry.materials;
        self.material = *self.material_ids.entry(name(rest)).or_insert_with_key(|name| {
            materials.push(Reference { name: name.clone(), line });
            materials.len() as u32 - 1
        });
    }

    fn library(&mut self, line: u32, rest: &[u8]) {
        let name = name(rest);
        // Exporters repeat the statement for each object.
        if !name.is_empty() && self.library_names.insert(name.clone()) {
            self.geometry.libraries.push(Reference { name, line });
        }
    }

    fn smoothing_group(&mut self, line: u32, rest: &[u8]) {
        let word = values(rest).next().unwrap_or_default();
        self.smoothing = match integer(word).map(u32::try_from) {
            Some(Ok(group)) => group,
            _ if word.eq_ignore_ascii_case(b"on") => 1,
            _ => {
                if !word.eq_ignore_ascii_case(b"off") {
                    self.tally.add(NoteKind::Repaired, "smoothing groups that are no number: off", line);
                }
                0
            }
        };
    }

    /// Checks the indices after the last statement, and places the points relative to their origin.
    fn finish(mut self, notes: &mut Notes) -> Result<Geometry> {
        if let (false, Some((line, word))) = (self.known_statements, &self.first_unknown) {
            return Err(self.invalid(
                *line,
                format!("{word:?}, and no OBJ statement in the whole file"),
                "v, vt, vn, f, g, o, s, usemtl or mtllib",
            ));
        }
        // A tool that removes the normals or texture coordinates of a file may leave the indices in
        // its faces.
        for kind in [Kind::Uv, Kind::Normal] {
            if kind.count(&self.geometry) == 0 {
                self.strip(kind);
            }
        }
        self.check_indices()?;
        self.tally.report(self.file, notes);
        let places = std::mem::take(&mut self.geometry.places);
        LocalPlaces { origin: self.geometry.origin, places: self.geometry.positions } =
            LocalPlaces::of(&places);
        Ok(self.geometry)
    }

    fn strip(&mut self, kind: Kind) {
        let g = &mut self.geometry;
        for face in &g.faces {
            for corner in &mut g.corners[face.range()] {
                let index = kind.of_mut(corner);
                if *index != NONE {
                    *index = NONE;
                    let message = match kind {
                        Kind::Normal => "normal indices in a file without any vn",
                        _ => "texture coordinate indices in a file without any vt",
                    };
                    self.tally.add(NoteKind::Ignored, message, face.line);
                }
            }
        }
    }

    fn check_indices(&self) -> Result<()> {
        let g = &self.geometry;
        let kinds = [Kind::Position, Kind::Uv, Kind::Normal];
        let counts = kinds.map(|kind| kind.count(g));
        for face in &g.faces {
            for corner in &g.corners[face.range()] {
                let indices = [corner.position, corner.uv, corner.normal];
                for ((kind, count), index) in kinds.into_iter().zip(counts).zip(indices) {
                    if index != NONE && index as usize >= count {
                        return Err(self.invalid(
                            face.line,
                            format!("{} index {}", kind.name(), u64::from(index) + 1),
                            match count {
                                0 => format!("{} in the file", kind.elements()),
                                1 => format!("1, as the file has 1 of the {}", kind.elements()),
                                n => format!("1 to {n}, as the file has {n} {}", kind.elements()),
                            },
                        ));
                    }
                }
            }
        }
        Ok(())
    }
}

/// List that a part of a corner indexes.
#[derive(Clone, Copy)]
enum Kind {
    Position,
    Uv,
    Normal,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Position => "vertex",
            Self::Uv => "texture coordinate",
            Self::Normal => "normal",
        }
    }

    fn elements(self) -> &'static str {
        match self {
            Self::Position => "vertices (v)",
            Self::Uv => "texture coordinates (vt)",
            Self::Normal => "normals (vn)",
        }
    }

    fn count(self, geometry: &Geometry) -> usize {
        match self {
            Self::Position => geometry.places.len(),
            Self::Uv => geometry.uvs.len(),
            Self::Normal => geometry.normals.len(),
        }
    }

    fn of_mut(self, corner: &mut Corner) -> &mut u32 {
        match self {
            Self::Position => &mut corner.position,
            Self::Uv => &mut corner.uv,
            Self::Normal => &mut corner.normal,
        }
    }
}

/// Parses a decimal integer; one that does not fit becomes the largest of its sign.
fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0_i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
    }
    Some(if negative { -value } else { value })
}
