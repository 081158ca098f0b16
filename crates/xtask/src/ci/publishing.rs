//! Check that the published crates can be packed as by `cargo publish --workspace`, without the
//! upload.
//!
//! The crates are packed in the order of their dependencies. This needs the index of crates.io and
//! about ten seconds, since nothing is compiled. Before a release, `cargo publish --workspace
//! --dry-run` compiles the crates (CONTRIBUTING.md).

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::shell::{Outcome, Shell};

/// Largest package that crates.io takes (bytes).
const MOST_BYTES: u64 = 10_000_000;
/// Files that every crate has beside its code.
const FILES: [&str; 3] = ["README.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// Checks that all published crates can be packed, with their descriptions and licences.
pub fn check(shell: &Shell) -> Outcome<()> {
    let target = shell.folder("packages")?;
    let publish = "publish --workspace --dry-run --no-verify --allow-dirty --locked --quiet --target-dir";
    shell.cargo(publish).arg(&target).run_quietly()?;
    let metadata = shell.cargo("metadata --locked --no-deps --format-version 1").output()?;
    let metadata: Value = serde_json::from_str(&metadata).map_err(|e| e.to_string())?;
    let crates = published(&metadata)?;
    let mut bytes = 0;
    for (name, version) in &crates {
        let packed = format!("{name}-{version}.crate");
        let size = size_below(&target.join("package"), &packed).ok_or(format!("{packed} was not packed"))?;
        if size > MOST_BYTES {
            return Err(format!("{packed} has {size} bytes, of {MOST_BYTES} at most"));
        }
        bytes += size;
        let list = shell.cargo("package --locked --allow-dirty --list --package").arg(name).output()?;
        let there: BTreeSet<&str> = list.lines().collect();
        if let Some(file) = FILES.iter().find(|file| !there.contains(*file)) {
            return Err(format!("{name} is published without {file}"));
        }
    }
    shell.say(&format!("{} crates of {} kB together", crates.len(), bytes / 1000));
    Ok(())
}

/// Returns names and versions of the published crates. It is an error if a crate lacks a field that
/// crates.io requires or that users look for.
fn published(metadata: &Value) -> Outcome<Vec<(String, String)>> {
    let packages = metadata["packages"].as_array().ok_or("cargo metadata names no packages")?;
    let mut crates = Vec::new();
    for package in packages.iter().filter(|package| package["publish"].is_null()) {
        let text = |key: &str| package[key].as_str().filter(|text| !text.is_empty()).map(str::to_owned);
        let name = text("name").ok_or("a package without a name")?;
        let said = ["description", "license", "repository", "rust_version", "readme"];
        if let Some(missing) = said.into_iter().find(|key| text(key).is_none()) {
            return Err(format!("{name} is published and says no {missing}"));
        }
        crates.push((name, text("version").ok_or("a package without a version")?));
    }
    if crates.is_empty() { Err("no crate is published".to_owned()) } else { Ok(crates) }
}

/// Size (bytes) of the file of that name in a folder or in one of its subfolders.
fn size_below(folder: &Path, name: &str) -> Option<u64> {
    let size = |folder: &Path| fs::metadata(folder.join(name)).ok().map(|file| file.len());
    let below = || fs::read_dir(folder).ok()?.flatten().find_map(|entry| size(&entry.path()));
    size(folder).or_else(below)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn crates_that_are_published_say_what_they_are() {
        let good = json!({
            "name": "a", "version": "1.0.0", "description": "d", "license": "MIT", "repository": "r",
            "rust_version": "1.89", "readme": "README.md", "publish": null
        });
        let hidden = json!({ "name": "b", "version": "1.0.0", "publish": [] });
        let of = |packages: &[&Value]| published(&json!({ "packages": packages }));
        assert_eq!(of(&[&good, &hidden]).unwrap(), [("a".to_owned(), "1.0.0".to_owned())]);
        for key in ["description", "license", "repository", "rust_version", "readme"] {
            let mut bad = good.clone();
            bad[key] = json!("");
            assert_eq!(of(&[&bad]).unwrap_err(), format!("a is published and says no {key}"));
        }
        assert!(of(&[&hidden]).is_err());
    }

    #[test]
    fn files_are_found_in_a_folder_and_one_below() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("tmp-crate")).unwrap();
        fs::write(folder.path().join("tmp-crate/a.crate"), "abc").unwrap();
        fs::write(folder.path().join("b.crate"), "a").unwrap();
        let size = |name| size_below(folder.path(), name);
        assert_eq!((size("a.crate"), size("b.crate"), size("c.crate")), (Some(3), Some(1), None));
    }
}
