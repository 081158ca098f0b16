//! Writing of files, whole or not at all.
//!
//! A file is written to the same folder under a name that ends in `.partial`, and renamed when it
//! is complete. Readers of the path therefore see either the old file or the new one. A path that
//! exists and is not a regular file (`/dev/stdout`, a pipe) is written to directly.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Checks that [`write_file`] can write to this path; leaves no trace.
///
/// # Errors
/// [`Error::Io`] with the reason.
pub fn check_writable(path: &Path) -> Result<()> {
    if let Target::Replaced { partial, .. } = target(path)? {
        create(path, &partial)?;
        fs::remove_file(&partial).map_err(|e| Error::io(path, e))?;
    }
    Ok(())
}

/// Writes a file, replacing an earlier one only when the new one is complete.
///
/// # Errors
/// [`Error::Io`] naming `path`.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    match target(path)? {
        Target::Direct => fs::write(path, bytes).map_err(|e| Error::io(path, e)),
        Target::Replaced { place, partial } => {
            let mut file = create(path, &partial)?;
            let done = file
                .write_all(bytes)
                .and_then(|()| file.sync_all())
                .and_then(|()| fs::rename(&partial, &place));
            done.map_err(|e| {
                // Only the first error is reported; a `.partial` file that remains is harmless.
                let _ = fs::remove_file(&partial);
                Error::io(path, e)
            })
        }
    }
}

enum Target {
    /// An existing path that is not a regular file.
    Direct,
    /// A file to be replaced or created: its path with links resolved, and the path of the partial
    /// file.
    Replaced { place: PathBuf, partial: PathBuf },
}

fn target(path: &Path) -> Result<Target> {
    let refuse = |kind, message: String| Err(Error::io(path, io::Error::new(kind, message)));
    let place = match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => {
            return refuse(ErrorKind::IsADirectory, "is a folder, not a file".to_owned());
        }
        Ok(meta) if !meta.is_file() => return Ok(Target::Direct),
        Ok(_) => {
            // A write-protected file is not replaced, although the permissions of its folder would
            // allow it.
            File::options().write(true).open(path).map_err(|e| Error::io(path, e))?;
            fs::canonicalize(path).map_err(|e| Error::io(path, e))?
        }
        Err(_) => path.to_owned(),
    };
    let Some(name) = place.file_name() else {
        return refuse(ErrorKind::InvalidInput, "is not a file name".to_owned());
    };
    let folder = match place.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return refuse(ErrorKind::NotFound, format!("there is no folder {}", folder.display()));
    }
    let mut partial = name.to_owned();
    partial.push(format!(".{}.partial", std::process::id()));
    let partial = folder.join(partial);
    Ok(Target::Replaced { place, partial })
}

fn create(path: &Path, partial: &Path) -> Result<File> {
    File::create(partial).map_err(|e| Error::io(path, e))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn files_are_replaced_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        check_writable(&path).unwrap();
        assert!(names(folder.path()).is_empty(), "a check leaves no trace");
        write_file(&path, b"first, longer").unwrap();
        check_writable(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"first, longer", "a check does not touch what is there");
        write_file(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn what_cannot_be_written_is_told_with_its_reason() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| check_writable(path).unwrap_err().to_string();
        assert!(message(folder.path()).contains("is a folder"));
        let lost = folder.path().join("none").join("a.exr");
        let said = message(&lost);
        assert!(said.contains("a.exr: there is no folder") && said.ends_with("none"), "{said}");
        assert!(write_file(&lost, b"").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_file(&link, b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        write_file(Path::new("/dev/null"), b"gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
