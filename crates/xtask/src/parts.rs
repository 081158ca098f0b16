//! Packages that the program is made of, and their licences.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::shell::{Outcome, Shell};

/// Packages that the program is made of.
pub struct Parts {
    /// Version of the program, such as `0.3.0`.
    pub version: String,
    /// Folder of Cargo's build outputs.
    pub target: PathBuf,
    /// Foreign packages by name and version.
    packages: BTreeMap<(String, String), Package>,
}

struct Package {
    licence: String,
    folder: PathBuf,
}

impl Parts {
    /// Reads the packages of `tashika-cli` on this machine, except those that only tests and builds
    /// use.
    pub fn of_program(shell: &Shell) -> Outcome<Self> {
        let told = shell.cargo("metadata --locked --format-version 1").output()?;
        let metadata: Value = serde_json::from_str(&told).map_err(|e| e.to_string())?;
        let tree = "tree --locked --package tashika-cli --edges normal --prefix none --no-dedupe --format";
        let used = shell.cargo(tree).arg("{p}").output()?;
        Self::of(&metadata, &used).ok_or_else(|| "cargo metadata is not as it was".to_owned())
    }

    /// Makes the parts from the output of `cargo metadata`.
    ///
    /// * `used`: lines that begin with a name, a space, and a version after `v`.
    fn of(metadata: &Value, used: &str) -> Option<Self> {
        let name_and_version = |line: &str| {
            let mut words = line.split_whitespace();
            Some((words.next()?.to_owned(), words.next()?.strip_prefix('v')?.to_owned()))
        };
        let used: BTreeSet<_> = used.lines().filter_map(name_and_version).collect();
        let (mut version, mut packages) = (None, BTreeMap::new());
        for package in metadata["packages"].as_array()? {
            let text = |key: &str| package[key].as_str().map(str::to_owned);
            let key = (text("name")?, text("version")?);
            if key.0 == "tashika-cli" {
                version = Some(key.1.clone());
            }
            if used.contains(&key) && !package["source"].is_null() {
                let folder = Path::new(package["manifest_path"].as_str()?).parent()?.to_owned();
                packages.insert(key, Package { licence: text("license").unwrap_or_default(), folder });
            }
        }
        let target = metadata["target_directory"].as_str()?.into();
        Some(Self { version: version?, target, packages })
    }

    /// Bill of materials in the form of CycloneDX 1.5.
    pub fn bill_of_materials(&self) -> String {
        let component = |((name, version), package): (&(String, String), &Package)| {
            json!({
                "type": "library", "name": name, "version": version,
                "purl": format!("pkg:cargo/{name}@{version}"),
                "licenses": [{ "expression": package.licence.replace('/', " OR ") }],
            })
        };
        let bill = json!({
            "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
            "metadata": { "component": {
                "type": "application", "name": "tashika", "version": self.version,
                "licenses": [{ "expression": "MIT OR Apache-2.0" }],
            } },
            "components": self.packages.iter().map(component).collect::<Vec<_>>(),
        });
        format!("{bill:#}\n")
    }

    /// Name, version and licence of each package, and the text of the licence from the package.
    pub fn licences(&self) -> Outcome<String> {
        let mut text = String::new();
        for ((name, version), package) in &self.packages {
            let _ = writeln!(text, "{name} {version}: {}\n", package.licence);
            for file in licence_files(&package.folder)? {
                let bytes = fs::read(&file).map_err(|e| format!("{}: {e}", file.display()))?;
                let _ = writeln!(text, "{}\n", String::from_utf8_lossy(&bytes).trim_end());
            }
            text.push_str("────────\n\n");
        }
        Ok(text)
    }
}

/// Files of a package that have its licence.
fn licence_files(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let is_licence = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_uppercase();
        path.is_file()
            && ["LICENSE", "LICENCE", "COPYING", "NOTICE"].iter().any(|word| name.starts_with(word))
    };
    let mut files: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_licence).collect();
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two versions of a package, of which one is used, and a package of our own. Only the used
    /// foreign version is a part.
    #[test]
    fn parts_are_foreign_packages_that_are_used() {
        let registry = "registry+https://github.com/rust-lang/crates.io-index";
        let package = |name: &str, version: &str, source: Value| {
            json!({
                "name": name, "version": version, "license": "MIT/Apache-2.0", "source": source,
                "manifest_path": format!("/crates/{name}/Cargo.toml"),
            })
        };
        let metadata = json!({ "target_directory": "/target", "packages": [
            package("tashika-cli", "0.3.0", Value::Null),
            package("glam", "0.30.1", json!(registry)),
            package("glam", "0.29.0", json!(registry)),
        ] });
        let parts = Parts::of(&metadata, "tashika-cli v0.3.0 (/here)\nglam v0.30.1\n\n").unwrap();
        assert_eq!(parts.version, "0.3.0");
        let bill: Value = serde_json::from_str(&parts.bill_of_materials()).unwrap();
        let components = bill["components"].as_array().unwrap();
        assert_eq!(components.len(), 1);
        assert_eq!(components[0]["purl"], "pkg:cargo/glam@0.30.1");
        assert_eq!(components[0]["licenses"][0]["expression"], "MIT OR Apache-2.0");
    }

    #[test]
    fn licences_are_read_from_their_package() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("LICENSE-MIT", "as is"), ("license.txt", "as it is"), ("lib.rs", "code")] {
            fs::write(folder.path().join(name), text).unwrap();
        }
        let packages = BTreeMap::from([(
            ("one".to_owned(), "1.0.0".to_owned()),
            Package { licence: "MIT".to_owned(), folder: folder.path().to_owned() },
        )]);
        let parts = Parts { version: "0.1.0".to_owned(), target: PathBuf::new(), packages };
        let text = parts.licences().unwrap();
        assert!(text.starts_with("one 1.0.0: MIT\n\nas is\n"), "{text}");
        assert!(text.contains("as it is") && !text.contains("code"), "{text}");
    }
}
