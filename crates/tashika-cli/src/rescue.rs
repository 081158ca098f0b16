//! Rescue of a finished image whose file cannot be written: it is saved in the folder for temporary
//! files.

use std::fs::{self, DirBuilder};
use std::io;
use std::path::{Path, PathBuf};
use std::process;

use tashika::error::Error;
use tashika::film::Film;
use tashika::io::{ExrLayout, write_exr_as};

use crate::exit::Failure;

/// Number of folders that are tried before the program gives up.
const FOLDERS: u32 = 100;

/// Saves a film that could not be written to `exr` because of `trouble`; the failure names the
/// place.
///
/// * `kept`: the checkpoint that has the finished tiles, if there is one.
pub fn rescued(film: &Film, layout: &ExrLayout, exr: &Path, trouble: &Error, kept: Option<&Path>) -> Failure {
    let mut message = format!("cannot write {trouble}");
    match save(film, layout, exr) {
        Ok(path) => message.push_str(&format!("; the image is saved as {}", path.display())),
        Err(also) => message.push_str(&format!("; nor could it be saved for the time being: {also}")),
    }
    if let Some(kept) = kept {
        message.push_str(&format!(
            "; the finished tiles are kept in {}, the same command goes on from them",
            kept.display()
        ));
    }
    Failure::file(message)
}

fn save(film: &Film, layout: &ExrLayout, exr: &Path) -> Result<PathBuf, Error> {
    let temporary = std::env::temp_dir();
    let folder = own_folder(&temporary).map_err(|e| Error::io(&temporary, e))?;
    let path = folder.join(exr.file_name().unwrap_or("image.exr".as_ref()));
    write_exr_as(&path, film, layout).inspect_err(|_| {
        // The folder is empty.
        let _ = fs::remove_dir(&folder);
    })?;
    Ok(path)
}

/// Makes a new folder that only this user can access. In a folder that everybody may write to,
/// other users could have placed a link at the path of the file.
fn own_folder(temporary: &Path) -> io::Result<PathBuf> {
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    let names = (0..FOLDERS).map(|n| temporary.join(format!("tashika-{}-{n}", process::id())));
    let mut trouble = None;
    for folder in names {
        match builder.create(&folder) {
            Ok(()) => return Ok(folder),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => trouble = Some(e),
            Err(e) => return Err(e),
        }
    }
    Err(trouble.unwrap_or_else(|| io::ErrorKind::AlreadyExists.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_new_and_of_nobody_else() {
        let temporary = tempfile::tempdir().unwrap();
        let first = own_folder(temporary.path()).unwrap();
        let second = own_folder(temporary.path()).unwrap();
        assert!(first != second && first.is_dir() && second.is_dir());
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(fs::metadata(&first).unwrap().permissions().mode() & 0o777, 0o700);
        }
        assert!(own_folder(&temporary.path().join("none")).is_err());
    }
}
