//! Files that OBJ and MTL files refer to: material libraries and images.
//!
//! A name is searched for in the folder of the file that names it and in the folder of the scene;
//! then in both with `\ ` read as a blank; then by its last part in the folder of the scene. The
//! last step is needed because exporters write paths of the machine that they run on.
//!
//! A file that is not found is noted, and the scene is loaded without it. Tested by `suite::obj`,
//! `suite::damaged_obj`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use super::map::Map;
use super::mtl::{self, Definition, Definitions};
use super::parse::Reference;
use super::text::decode;
use crate::error::{Error, Location, Result};
use crate::io::SceneFiles;
use crate::io::assets::{FACTOR_ALONE, ImageCache, Unreadable, kind, reason, unreadable_image};
use crate::io::files::{folder_of, is_absolute};
use crate::io::images::Encoding;
use crate::io::notes::Named;
use crate::io::udim::{self, Picture};
use crate::scene::{ImageTexture, NoteKind, Notes, SceneBuilder, TextureId};

/// A file that was found.
struct Found {
    /// Spelling that led to the file.
    reference: String,
    /// Canonical path; for tiles, the pattern as it is spelt.
    path: PathBuf,
    /// True if the file was found in another place than its name states.
    moved: bool,
}

/// Finds `name`, which is written in a file in `folder` (see [`Definition::folder`]).
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

/// Most different files that notes mention by name, because they could not be read or were found
/// elsewhere.
const MAX_NAMED: usize = 100;

/// Most material libraries that are searched for; chosen.
const MAX_LIBRARIES: usize = 1000;
const TOO_MANY_LIBRARIES: &str = "material libraries after the thousandth";

/// Number of images that could not be read after which no further ones are searched for; chosen.
const MAX_FAILURES: usize = 1000;

/// Reads the material libraries.
///
/// The rest of a statement's line is one name if a file of that name exists, otherwise a list of
/// names.
///
/// # Errors
/// Errors of [`mtl::parse`] in a library that was found.
pub(super) fn read_libraries(
    files: &SceneFiles,
    references: &[Reference],
    notes: &mut Notes,
) -> Result<Definitions> {
    let mut definitions = Definitions::new();
    let mut seen = BTreeSet::new();
    let (mut unreadable, mut moved) = (Named::new(MAX_NAMED), Named::new(MAX_NAMED));
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
                    note_moved(&name, &found, &mut moved, &at, notes);
                    if seen.insert(found.path) {
                        let file = files.beside(&found.reference);
                        let folder = folder_of(&found.reference);
                        mtl::parse(&decode(&bytes, &file)?, &file, folder, &mut definitions, notes)?;
                    }
                }
                Err(error) => {
                    let message = format!("material library {name:?} could not be read ({})", reason(&error));
                    let further = "further material libraries could not be read";
                    unreadable.add(kind(&error), message, further, at.clone(), notes);
                }
            }
        }
    }
    Ok(definitions)
}

/// Splits a list of names at blanks, except after a `\`.
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

/// Notes a file that was found in another place than its name states.
fn note_moved(name: &str, found: &Found, moved: &mut Named, at: &Location, notes: &mut Notes) {
    if found.moved {
        let reference = &found.reference;
        let message = format!("file {name:?} is not there: {reference:?} in the folder of the scene is used");
        let further = "further files were found in the folder of the scene only";
        moved.add(NoteKind::Repaired, message, further, at.clone(), notes);
    }
}

/// Kind of values that a texture is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Content {
    /// Colours, through the sRGB curve.
    Color,
    /// Numbers, linear.
    Number,
    /// The alpha channel, or numbers if there is none.
    Opacity,
}

/// Images of materials, each name read once.
pub(super) struct Textures<'a> {
    files: &'a SceneFiles,
    images: ImageCache<'a>,
    /// Images by folder and name as written, and by content.
    by_name: BTreeMap<(String, String, Content), Result<Picture, Unreadable>>,
    /// Number of different names whose image could not be read.
    failures: usize,
    unreadable: Named,
    moved: Named,
}

impl<'a> Textures<'a> {
    pub(super) fn new(files: &'a SceneFiles) -> Self {
        Self {
            files,
            images: ImageCache::new(files),
            by_name: BTreeMap::new(),
            failures: 0,
            unreadable: Named::new(MAX_NAMED),
            moved: Named::new(MAX_NAMED),
        }
    }

    /// Adds the texture of a statement, if its image can be read; the flag is true if the image has
    /// opacities.
    pub(super) fn load(
        &mut self,
        map: &Map,
        definition: &Definition,
        content: Content,
        builder: &mut SceneBuilder,
    ) -> Option<(TextureId, bool)> {
        let key = (definition.folder.clone(), map.name.clone(), content);
        let loaded = match self.by_name.get(&key) {
            Some(known) => known.clone(),
            None if self.failures >= MAX_FAILURES => {
                Err((NoteKind::Repaired, "a thousand others could not be read".to_owned()))
            }
            None => {
                let read = self.read(map, definition, content, builder);
                let loaded = read.unwrap_or_else(|error| Err((kind(&error), reason(&error))));
                self.failures += usize::from(loaded.is_err());
                self.by_name.insert(key, loaded.clone());
                loaded
            }
        };
        match loaded {
            Ok(picture) => {
                let (wrap, transform) = (map.wrap(), map.transform());
                let lookup = picture.texture(|all| ImageTexture { wrap, transform, ..all });
                // This fails only for transforms that are not finite; the transforms of maps are.
                Some((builder.add_texture(lookup).ok()?, self.images.has_opacity(picture)))
            }
            Err((kind, reason)) => {
                let message = unreadable_image(&map.name, &reason, FACTOR_ALONE);
                let further = "further images could not be read";
                let at = Location { line: Some(map.line.0), ..definition.at.clone() };
                self.unreadable.add(kind, message, further, at, builder.notes_mut());
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
    ) -> Result<Result<Picture, Unreadable>> {
        let at = &Location { line: Some(map.line.0), ..definition.at.clone() };
        let found = find(self.files, &definition.folder, &map.name, at)?;
        note_moved(&map.name, &found, &mut self.moved, at, builder.notes_mut());
        if content == Content::Opacity
            && let Some(color) = self.images.known(&found.reference, Encoding::Srgb, at)
            && self.images.has_opacity(color)
        {
            // Alpha is linear in either encoding: it needs no second copy of the image.
            return Ok(Ok(color));
        }
        let encoding = if content == Content::Color { Encoding::Srgb } else { Encoding::Linear };
        self.images.find(&found.reference, encoding, at, builder)
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
}
