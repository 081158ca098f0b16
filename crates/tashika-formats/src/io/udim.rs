//! Pictures in tiles: file names in which `<UDIM>` stands for the number of a tile.
//!
//! The tiles are the files that exist: `wood.<UDIM>.png` stands for `wood.1001.png`,
//! `wood.1002.png` and so on in one folder, with four digits from 1001. If no such file exists, the
//! picture is missing. A tile that cannot be read is noted and grey. The scene notes tiles that a
//! mesh uses and that do not exist, see [`TileSet`].
//!
//! # Held to this by
//! `suite::udim`.

use std::collections::BTreeMap;
use std::io;

use super::SceneFiles;
use super::assets::{decode, kind, reason, unreadable_image};
use super::images::{Encoding, one_texel};
use crate::error::{Error, Location, Result};
use crate::scene::{ImageId, ImageTexture, NO_TILE, SceneBuilder, Texture, TileSet, TileSetId, TiledTexture};

/// Image or set of tiles that the name of an image stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Picture {
    /// A single file.
    Image(ImageId),
    /// An image for each tile.
    Tiles(TileSetId),
}

impl Picture {
    /// Returns true for an image with texels below zero; tiles are not searched.
    pub(super) fn has_values_below_zero(self, builder: &SceneBuilder) -> bool {
        matches!(self, Self::Image(image) if builder.texels_below_zero(image) > 0)
    }

    /// Texture that looks up the picture; `how` sets transform, sampling and, for an image,
    /// wrapping.
    pub(super) fn texture(self, how: impl FnOnce(ImageTexture) -> ImageTexture) -> Texture {
        match self {
            Self::Image(image) => Texture::Image(how(ImageTexture::new(image))),
            Self::Tiles(set) => {
                let ImageTexture { transform, sampling, .. } = how(ImageTexture::new(ImageId::at(0)));
                Texture::Tiles(TiledTexture { set, transform, sampling })
            }
        }
    }
}

/// Splits a name into its folder and the text before and after `<UDIM>`, if its last part has it.
fn parts(reference: &str) -> Option<[&str; 3]> {
    let name = reference.rfind(['/', '\\']).map_or(0, |i| i + 1);
    // Conversion of ASCII letters to upper case moves no byte.
    let place = name + reference[name..].to_ascii_uppercase().find("<UDIM>")?;
    Some([&reference[..name], &reference[name..place], &reference[place + "<UDIM>".len()..]])
}

/// Returns true if a name stands for tiles.
pub(super) fn is_pattern(reference: &str) -> bool {
    parts(reference).is_some()
}

/// Returns true if there is a file of that name, or any tile.
pub(super) fn is_there(files: &SceneFiles, reference: &str, at: &Location) -> bool {
    if is_pattern(reference) {
        tiles(files, reference, at).is_ok()
    } else {
        files.resolve(reference, at).is_ok()
    }
}

/// Returns numbers and names of the tiles that exist, at least one.
///
/// # Errors
/// As [`SceneFiles::resolve`] for the folder; [`Error::Io`] if there is no tile in it.
pub(super) fn tiles(files: &SceneFiles, pattern: &str, at: &Location) -> Result<BTreeMap<u32, String>> {
    let [folder, before, after] = parts(pattern).unwrap_or_default();
    let path = files.resolve(if folder.is_empty() { "." } else { folder }, at)?;
    let names = std::fs::read_dir(&path).map_err(|e| Error::io(&path, e))?;
    let mut found = BTreeMap::new();
    for name in names.flatten().filter_map(|entry| entry.file_name().into_string().ok()) {
        let (Some(head), Some(tail)) = (name.get(..before.len()), name.get(before.len() + 4..)) else {
            continue;
        };
        let same = head.eq_ignore_ascii_case(before) && tail.eq_ignore_ascii_case(after);
        let digits = &name[before.len()..before.len() + 4];
        let number = digits.parse().ok().filter(|n| (1001..=9999).contains(n));
        if let Some(number) = number.filter(|_| same) {
            let reference = format!("{folder}{name}");
            // If names differ only in case, the exact one is taken, or else the first in order.
            let rank = |r: &str| (r != format!("{folder}{before}{digits}{after}"), r.to_owned());
            let known = found.entry(number).or_insert_with(|| reference.clone());
            if rank(&reference) < rank(known) {
                *known = reference;
            }
        }
    }
    if found.is_empty() {
        let none = io::Error::new(io::ErrorKind::NotFound, format!("no tile of it (named by {at})"));
        return Err(Error::io(path.join(format!("{before}<UDIM>{after}")), none));
    }
    Ok(found)
}

/// Adds the pictures of all tiles that exist; returns the set, and true if all are opaque.
///
/// # Errors
/// As [`tiles`]; if the scene cannot take an image.
pub(super) fn load(
    files: &SceneFiles,
    pattern: &str,
    encoding: Encoding,
    at: &Location,
    builder: &mut SceneBuilder,
) -> Result<(TileSetId, bool)> {
    let (mut all, mut opaque) = (Vec::new(), true);
    for (number, reference) in tiles(files, pattern, at)? {
        let bytes = files.read(&reference, at);
        let decoded =
            bytes.and_then(|bytes| decode(&bytes, &reference, encoding, files.options(), at, builder));
        let image = match decoded {
            Ok(decoded) => {
                opaque &= decoded.opaque;
                decoded.image
            }
            Err(error) => {
                let message = unreadable_image(&reference, &reason(&error), "grey of 0.5");
                builder.note(kind(&error), message, at.clone());
                one_texel(&reference, NO_TILE)
            }
        };
        all.push((number, builder.add_image(image)?));
    }
    Ok((builder.add_tiles(TileSet { name: pattern.to_owned(), tiles: all })?, opaque))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_stands_in_the_last_part_of_a_name() {
        assert_eq!(parts("a/b.<UDIM>.png"), Some(["a/", "b.", ".png"]));
        assert_eq!(parts("<udim>"), Some(["", "", ""]));
        assert_eq!(parts("a\\é_<UDIM>x"), Some(["a\\", "é_", "x"]));
        assert_eq!([parts("a/<UDIM>/b.png"), parts("b.png"), parts("")], [None; 3]);
    }
}
