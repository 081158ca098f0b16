//! Places of the files that a scene names.
//!
//! A file that an object names is searched for beside the scene file, then beside the included file
//! that names it, then in the folders of `<path>`. Included files and spectra are searched for
//! beside the file that names them, then beside the scene file. [`SceneFiles`] decides which files
//! may be read.
//!
//! Tested below and by `suite::mitsuba::files_are_found_beside_the_scene_and_in_paths`.

use crate::error::{Location, Result};
use crate::io::files::is_absolute;
use crate::io::{SceneFiles, udim};

/// `name` inside `folder`, which may be empty.
pub(super) fn join(folder: &str, name: &str) -> String {
    let name = name.trim();
    if folder.is_empty() || is_absolute(name) {
        name.to_owned()
    } else {
        format!("{}/{name}", folder.trim_end_matches(['/', '\\']))
    }
}

/// `name` inside each folder, without repetition.
pub(super) fn candidates<'a>(name: &str, folders: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for folder in folders {
        let joined = join(folder, name);
        if !all.contains(&joined) {
            all.push(joined);
        }
    }
    all
}

/// First candidate that exists; the first of all if none does.
pub(super) fn first_there<'a>(files: &SceneFiles, candidates: &'a [String], at: &Location) -> &'a str {
    let there = candidates.iter().find(|c| udim::is_there(files, c, at));
    there.or(candidates.first()).map_or("", String::as_str)
}

/// Bytes and name of the first candidate that exists.
///
/// # Errors
/// The error of the first candidate if none exists.
pub(super) fn read_first(
    files: &SceneFiles,
    candidates: &[String],
    at: &Location,
) -> Result<(Vec<u8>, String)> {
    let name = first_there(files, candidates, at);
    Ok((files.read(name, at)?, name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_put_into_folders_unless_they_are_absolute() {
        assert_eq!(join("a/b", "c.obj"), "a/b/c.obj");
        assert_eq!(join("a/", "../c.obj"), "a/../c.obj");
        assert_eq!(
            (join("a", "/c").as_str(), join("a", "C:\\c").as_str(), join("", "c").as_str()),
            ("/c", "C:\\c", "c")
        );
        assert_eq!(candidates("c", ["", "a", ""]), ["c", "a/c"]);
    }
}
