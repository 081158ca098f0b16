//! What OBJ and MTL files refer to: material libraries and images.
//!
//! A name is looked for, in this order: in the folder of the file that names it, in the folder of
//! the scene, in both with `\ ` read as a blank, and last, because exporters write paths of their
//! own machine, under its last part in the folder of the scene.
//!
//! What is not found is noted, and the scene goes on without it. Tested by `suite::obj`,
//! `suite::damaged_obj`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::map::Map;
use super::mtl::{self, Definition, Definitions};
use super::parse::Reference;
use super::tally::Named;
use super::text::decode;
use crate::error::{Error, Location, Result};
use crate::io::SceneFiles;
use crate::io::assets::{Unreadable, kind, reason};
use crate::io::images::{self, Encoding};
use crate::io::udim::{self, Picture};
use crate::scene::{ImageTexture, NoteKind, Notes, SceneBuilder, TextureId};

/// A file that was found.
struct Found {
    /// The spelling that led to it.
    reference: String,
    /// Canonical; of tiles as it is spelt.
    path: PathBuf,
    /// Whether it was not where the name says.
    moved: bool,
}

/// Finds `name`, written in a file in `folder` (a start of references, see [`Definition::folder`]).
fn find(files: &SceneFiles, folder: &str, name: &str, at: &Location) -> Result<Found> {
    let mut spellings = vec![name.to_owned()];
    if name.contains("\\ ") {
        spellings.push(name.replace("\\ ", " "));
    }
    let mut candidates: Vec<(String, bool)> = Vec::new();
    for spelling in &spellings {
        if !folder.is_empty() && !is_absolute(spelling) {
            candidates.push((format!("{folder}{spelling}"), false));
        }
        candidates.push((spelling.clone(), false));
    }
    for spelling in &spellings {
        let last = spelling.rsplit(['/', '\\']).next().unwrap_or_default();
        if !last.is_empty() && last.len() < spelling.len() {
            candidates.push((last.to_owned(), true));
        }
    }
    for (reference, moved) in candidates {
        if udim::is_pattern(&reference) {
            if udim::is_there(files, &reference, at) {
                let path = PathBuf::from(&reference);
                return Ok(Found { reference, path, moved });
            }
        } else if let Ok(path) = files.resolve(&reference, at)
            && path.is_file()
        {
            return Ok(Found { reference, path, moved });
        }
    }
    match files.resolve(name, at) {
        Err(error) => Err(error),
        Ok(_) => Err(Error::invalid(at.clone(), format!("{name:?}, which is no file"), "a file")),
    }
}

fn is_absolute(name: &str) -> bool {
    name.starts_with(['/', '\\']) || name.as_bytes().get(1) == Some(&b':')
}

/// How many different files that could not be read, or not where they should be, are named.
const MAX_NAMED: usize = 100;

/// How many material libraries are looked for; chosen.
const MAX_LIBRARIES: usize = 1000;
const TOO_MANY_LIBRARIES: &str = "material libraries after the thousandth";

/// After so many images that could not be read no further ones are looked for; chosen.
const MAX_FAILURES: usize = 1000;

/// Reads the material libraries.
///
/// A statement's whole line is one name if there is such a file, else a list of names.
///
/// # Errors
/// What [`mtl::parse`] refuses in a library that was found.
pub(super) fn read_libraries(
    files: &SceneFiles,
    references: &[Reference],
    notes: &mut Notes,
) -> Result<Definitions> {
    let mut definitions = Definitions::new();
    let mut seen = BTreeSet::new();
    let mut unreadable =
        Named::new(NoteKind::Repaired, MAX_NAMED, "further material libraries could not be read");
    let mut moved = moved_notes();
    let mut budget = MAX_LIBRARIES;
    for Reference { name, line } in references {
        let at = Location::line(files.path(), *line);
        if budget == 0 {
            notes.push(NoteKind::Ignored, TOO_MANY_LIBRARIES, at);
            continue;
        }
        let whole = find(files, "", name, &at);
        let mut names = split_names(name);
        let is_there = |name: &String| find(files, "", name, &at).is_ok_and(|found| !found.moved);
        let is_one = match &whole {
            _ if names.len() == 1 => true,
            Ok(found) => !found.moved || !names.iter().take(budget).any(is_there),
            Err(_) => false,
        };
        if is_one {
            names = vec![name.clone()];
        }
        for name in names {
            if budget == 0 {
                notes.push(NoteKind::Ignored, TOO_MANY_LIBRARIES, at.clone());
                continue;
            }
            budget -= 1;
            let found = find(files, "", &name, &at);
            match found.and_then(|found| files.read(&found.reference, &at).map(|bytes| (found, bytes))) {
                Ok((found, bytes)) => {
                    if found.moved {
                        moved.add(moved_message(&name, &found.reference), at.clone(), notes);
                    }
                    if seen.insert(found.path) {
                        let file = beside(files, &found.reference);
                        let folder = folder_of(&found.reference);
                        mtl::parse(&decode(&bytes, &file)?, &file, folder, &mut definitions, notes)?;
                    }
                }
                Err(error) => {
                    let message = format!("material library {name:?} could not be read ({})", reason(&error));
                    unreadable.add_as(kind(&error), message, at.clone(), notes);
                }
            }
        }
    }
    Ok(definitions)
}

/// Names of a list: blanks part them, unless a `\` stands before.
fn split_names(list: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for word in list.split([' ', '\t']).filter(|word| !word.is_empty()) {
        match names.last_mut() {
            Some(last) if last.ends_with('\\') => {
                last.pop();
                last.push(' ');
                last.push_str(word);
            }
            _ => names.push(word.to_owned()),
        }
    }
    names
}

/// A reference as a path for messages: relative to where the user named the scene.
fn beside(files: &SceneFiles, reference: &str) -> PathBuf {
    files.path().parent().unwrap_or(Path::new("")).join(reference)
}

fn folder_of(reference: &str) -> &str {
    reference.rfind(['/', '\\']).map_or("", |separator| &reference[..=separator])
}

fn moved_notes() -> Named {
    Named::new(NoteKind::Repaired, MAX_NAMED, "further files were found in the folder of the scene only")
}

fn moved_message(name: &str, reference: &str) -> String {
    format!("file {name:?} is not there: {reference:?} in the folder of the scene is used")
}

/// What a texture is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Content {
    /// Colours, through the sRGB curve.
    Color,
    /// Numbers, linear.
    Number,
    /// The alpha channel, or numbers if there is none.
    Opacity,
}

/// Loads each image once.
pub(super) struct Textures<'a> {
    files: &'a SceneFiles,
    /// By folder and name as written.
    by_name: BTreeMap<(String, String, Content), Result<Loaded, Unreadable>>,
    by_path: BTreeMap<(PathBuf, Encoding), Loaded>,
    /// How many different names led to nothing.
    failures: usize,
    unreadable: Named,
    moved: Named,
}

#[derive(Clone, Copy)]
struct Loaded {
    picture: Picture,
    has_alpha: bool,
}

impl<'a> Textures<'a> {
    pub(super) fn new(files: &'a SceneFiles) -> Self {
        Self {
            files,
            by_name: BTreeMap::new(),
            by_path: BTreeMap::new(),
            failures: 0,
            unreadable: Named::new(NoteKind::Repaired, MAX_NAMED, "further images could not be read"),
            moved: moved_notes(),
        }
    }

    /// The texture of a statement, if its image can be read, and whether that has opacities.
    pub(super) fn load(
        &mut self,
        map: &Map,
        definition: &Definition,
        content: Content,
        builder: &mut SceneBuilder,
        notes: &mut Notes,
    ) -> Option<(TextureId, bool)> {
        let key = (definition.folder.clone(), map.name.clone(), content);
        let loaded = match self.by_name.get(&key) {
            Some(known) => known.clone(),
            None if self.failures >= MAX_FAILURES => {
                Err((NoteKind::Repaired, "a thousand others could not be read".to_owned()))
            }
            None => {
                let loaded =
                    self.read(map, definition, content, builder, notes).map_err(|e| (kind(&e), reason(&e)));
                self.failures += usize::from(loaded.is_err());
                self.by_name.insert(key, loaded.clone());
                loaded
            }
        };
        match loaded {
            Ok(Loaded { picture, has_alpha }) => {
                let (wrap, transform) = (map.wrap(), map.transform());
                let lookup = picture.texture(|all| ImageTexture { wrap, transform, ..all });
                // Fails for transforms that are not finite, which maps do not have.
                Some((builder.add_texture(lookup).ok()?, has_alpha))
            }
            Err((kind, reason)) => {
                let message = format!(
                    "image {:?} could not be read ({reason}): its colour factor is used alone",
                    map.name
                );
                self.unreadable.add_as(kind, message, definition.at.clone(), notes);
                None
            }
        }
    }

    fn read(
        &mut self,
        map: &Map,
        definition: &Definition,
        content: Content,
        builder: &mut SceneBuilder,
        notes: &mut Notes,
    ) -> Result<Loaded> {
        let at = &definition.at;
        let Found { reference, path, moved } = find(self.files, &definition.folder, &map.name, at)?;
        if moved {
            self.moved.add(moved_message(&map.name, &reference), at.clone(), notes);
        }
        let encoding = if content == Content::Color { Encoding::Srgb } else { Encoding::Linear };
        if content == Content::Opacity
            && let Some(color) = self.by_path.get(&(path.clone(), Encoding::Srgb))
            && color.has_alpha
        {
            // Alpha is linear in either encoding: no second copy of the image for it.
            return Ok(*color);
        }
        if let Some(known) = self.by_path.get(&(path.clone(), encoding)) {
            return Ok(*known);
        }
        if udim::is_pattern(&reference) {
            let (tiles, opaque) = udim::load(self.files, &reference, encoding, at, builder)?;
            let loaded = Loaded { picture: Picture::Tiles(tiles), has_alpha: !opaque };
            self.by_path.insert((path, encoding), loaded);
            return Ok(loaded);
        }
        let bytes = self.files.read(&reference, at)?;
        let decoded = images::decode(&bytes, &reference, encoding, self.files.options(), at)?;
        if let Some(message) = decoded.repairs() {
            notes.push(NoteKind::Repaired, message, at.clone());
        }
        let picture = Picture::Image(builder.add_image(decoded.image)?);
        let loaded = Loaded { picture, has_alpha: !decoded.opaque };
        self.by_path.insert((path, encoding), loaded);
        Ok(loaded)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_names_are_split_at_blanks_without_a_backslash() {
        assert_eq!(split_names("a.mtl  b\\ c.mtl d"), ["a.mtl", "b c.mtl", "d"]);
        assert_eq!(split_names("  "), [""; 0]);
    }

    #[test]
    fn folders_are_starts_of_references() {
        assert_eq!([folder_of("a.mtl"), folder_of("m/n\\a.mtl")], ["", "m/n\\"]);
        assert!(is_absolute("C:/a") && is_absolute("\\a") && !is_absolute("a/b"));
    }
}
