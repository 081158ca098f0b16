//! Rows of a film in a file, with those of a reference if there is one.
//!
//! For a reduced view, the claims of the film determine the pixel that is chosen from each block.
//! The reference is read as a plane of that film, so that the same pixel of the reference is
//! chosen. Each displayed error is therefore the error of one pixel, however small the image is
//! shown.

use std::ops::Range;
use std::path::Path;

use tashika::error::{Error, Location, Result};
use tashika::film::{Film, Metadata, PlaneSpec, Window, planes};
use tashika::io::ExrFile;

/// Plane that holds the reference.
const REFERENCE: PlaneSpec = planes::REFERENCE;

/// A film in a file, and the reference that its errors are measured from.
pub(crate) struct Rows {
    film: ExrFile,
    reference: Option<ExrFile>,
}

impl Rows {
    /// Opens the file of a film, and that of its reference.
    pub(crate) fn open(film: &Path, reference: Option<&Path>) -> Result<Self> {
        let (name, film) = (film, ExrFile::open(film)?);
        let reference = reference.map(|path| paired(path, name, &film)).transpose()?;
        Ok(Self { film, reference })
    }

    /// Part of the image that the film holds.
    pub(crate) fn window(&self) -> Window {
        self.film.window()
    }

    /// Metadata of the film in the file.
    pub(crate) fn metadata(&self) -> &Metadata {
        self.film.metadata()
    }

    /// Number of rows that are decompressed at once.
    pub(crate) fn rows_per_block(&self) -> u32 {
        self.film.rows_per_block()
    }

    /// Number of channels of all planes, including the reference.
    pub(crate) fn channels(&self) -> usize {
        let own = self.film.planes().iter().map(|p| p.channels.len());
        let main = self.reference.iter().flat_map(|r| r.planes()).filter(|p| p.name.is_empty());
        own.sum::<usize>() + main.map(|p| p.channels.len()).sum::<usize>()
    }

    /// Reads whole rows, numbered in the full image.
    pub(crate) fn read(&self, rows: Range<u32>) -> Result<Film> {
        let mut film = self.film.read_rows(rows.clone())?;
        if let Some(reference) = &self.reference {
            film.adopt_main(reference.read_rows(rows)?, REFERENCE);
        }
        Ok(film)
    }
}

/// Opens a reference, which must show the part of the image that the film shows.
fn paired(path: &Path, name: &Path, film: &ExrFile) -> Result<ExrFile> {
    let reference = ExrFile::open(path)?;
    let refuse = |found: String, expected: String| Err(Error::invalid(Location::file(path), found, expected));
    let told = |file: &ExrFile| {
        let ([width, height], w) = (file.size(), file.window());
        format!("the part {},{},{},{} of {width}x{height} pixels", w.x, w.y, w.width, w.height)
    };
    if (reference.size(), reference.window()) != (film.size(), film.window()) {
        return refuse(told(&reference), format!("what {} shows: {}", name.display(), told(film)));
    }
    if !reference.planes().iter().any(|p| p.name.is_empty()) {
        return refuse(
            "an image without colours".to_owned(),
            "channels R, G and B, or one channel".to_owned(),
        );
    }
    if film.planes().iter().any(|p| p.name == REFERENCE.name) {
        let found =
            format!("a reference for {}, which has a layer {:?} itself", name.display(), REFERENCE.name);
        return refuse(found, "one of them".to_owned());
    }
    Ok(reference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stored::tests::{film, written};

    #[test]
    fn the_reference_is_a_plane_of_the_same_pixels() {
        let window = Window { x: 3, y: 5, width: 40, height: 60 };
        let (image, mut other) = (film(window), film(window));
        other.plane_mut("").unwrap().set_f32(20, 30, &[7.0, 8.0, 9.0]);
        let ((_a, path), (_b, reference)) = (written(&image), written(&other));
        let rows = Rows::open(&path, Some(&reference)).unwrap();
        let read = rows.read(25..35).unwrap();
        assert_eq!(read.plane("reference").unwrap().f32_at(20, 30), [7.0, 8.0, 9.0]);
        assert_eq!(read.plane("").unwrap().f32_at(20, 30), image.plane("").unwrap().f32_at(20, 30));
        let own: usize = image.planes().iter().map(|p| p.channels().len()).sum();
        assert_eq!(rows.channels(), own + 3);
    }

    #[test]
    fn a_reference_of_another_part_is_refused_with_both_names() {
        let image = film(Window { x: 3, y: 5, width: 40, height: 60 });
        let other = film(Window { x: 3, y: 6, width: 40, height: 60 });
        let ((_a, path), (_b, reference)) = (written(&image), written(&other));
        let said = Rows::open(&path, Some(&reference)).err().unwrap().to_string();
        assert!(
            said.contains(&reference.display().to_string()) && said.contains(&path.display().to_string()),
            "{said}"
        );
        assert!(said.contains("3,6,40,60") && said.contains("3,5,40,60"), "{said}");
    }
}
