//! The files that a render writes.

use std::path::{Path, PathBuf};

use tashika::io::check_writable;

use super::{is_standard_stream, with_ending};
use crate::exit::Failure;

/// Files of one image.
#[derive(Clone, Debug)]
pub struct Outputs {
    /// OpenEXR file of the image.
    pub exr: PathBuf,
    /// Tone-mapped picture of the image.
    pub png: PathBuf,
    /// Picture of the luminances in false colours, if one is written.
    pub luminance: Option<PathBuf>,
    /// Page that shows the image.
    pub html: PathBuf,
    /// Summary for scripts, if one is written.
    pub json: Option<PathBuf>,
}

impl Outputs {
    /// Names the picture and the page after the image, and puts them beside it.
    pub fn new(exr: &Path, json: Option<PathBuf>) -> Result<Self, Failure> {
        let exr = with_ending(exr, "exr")?;
        let [png, html] = ["png", "html"].map(|ending| exr.with_extension(ending));
        Ok(Self { exr, png, luminance: None, html, json })
    }

    /// Adds a picture of the luminances beside the image.
    #[must_use]
    pub fn with_luminance(mut self) -> Self {
        self.luminance = Some(named(&self.png, "luminance"));
        self
    }

    /// Files of the image, without the summary.
    pub fn images(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.exr, &self.png].into_iter().chain(&self.luminance).chain([&self.html])
    }

    /// Files of each of several cameras, named after the cameras.
    pub fn of_cameras(&self, names: &[&str]) -> Result<Vec<Self>, Failure> {
        let mut all: Vec<Self> = Vec::new();
        for name in names {
            let outputs = self.named(&in_file_name(name));
            if all.iter().any(|known| known.exr == outputs.exr) {
                let file = outputs.exr.display();
                let message = format!("{file} would be written twice: name one of the cameras {name} alone");
                return Err(Failure::usage(message));
            }
            all.push(outputs);
        }
        Ok(all)
    }

    /// Files of a frame of an animation, named after its number.
    pub fn of_frame(&self, number: u32) -> Self {
        self.named(&format!("{number:04}"))
    }

    /// Checks that all files can be written.
    pub fn check(&self) -> Result<(), Failure> {
        let json = self.json.iter().filter(|json| !is_standard_stream(json));
        for path in self.images().chain(json) {
            check_writable(path).map_err(|e| Failure::file(format!("cannot write {e}")))?;
        }
        Ok(())
    }

    /// Files whose names have a hyphen and `ending` after their stems.
    fn named(&self, ending: &str) -> Self {
        let named = |path: &PathBuf| named(path, ending);
        Self {
            exr: named(&self.exr),
            png: named(&self.png),
            luminance: self.luminance.as_ref().map(named),
            html: named(&self.html),
            json: self
                .json
                .as_ref()
                .map(|json| if is_standard_stream(json) { json.clone() } else { named(json) }),
        }
    }
}

/// Returns a path with a hyphen and `ending` after its stem.
pub(super) fn named(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push("-");
    name.push(ending);
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}

/// Makes a part of a file's name from a name: characters that file systems or shells may interpret
/// become hyphens.
fn in_file_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    name.chars().map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_after_cameras() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let outputs = Outputs::new(&path("view.v2.exr"), Some(path("numbers"))).unwrap();
        let all = outputs.of_cameras(&["top", "../side door"]).unwrap();
        assert_eq!(all[0].exr, path("view.v2-top.exr"));
        assert_eq!(all[1].png, path("view.v2-..-side-door.png"));
        assert_eq!(all[1].html, path("view.v2-..-side-door.html"));
        assert_eq!(all[0].json, Some(path("numbers-top")));
        assert_eq!(all[0].of_frame(7).exr, path("view.v2-top-0007.exr"));
        assert_eq!(outputs.of_frame(12345).json, Some(path("numbers-12345")));
        let luminance = outputs.clone().with_luminance().of_frame(3).luminance;
        assert_eq!(luminance, Some(path("view.v2-luminance-0003.png")));
        let said = outputs.of_cameras(&["a b", "a/b"]).unwrap_err().to_string();
        assert!(said.contains("view.v2-a-b.exr would be written twice"), "{said}");
        assert!(Outputs::new(&path("view.png"), None).is_err());
    }
}
