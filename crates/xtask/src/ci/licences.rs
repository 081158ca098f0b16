//! Check of the licences of dependencies, with `cargo deny` if it is installed. Otherwise only
//! licences and sources are checked.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use crate::shell::{Outcome, Shell};

/// Checks that all licences are allowed by `deny.toml`, and that all packages come from crates.io.
pub fn check(shell: &Shell) -> Outcome<()> {
    if shell.cargo("deny --version").succeeds() {
        return shell.cargo("deny --locked check licenses bans sources").run();
    }
    let config = fs::read_to_string(shell.root().join("deny.toml")).map_err(|e| e.to_string())?;
    let allowed = allowed(&config).ok_or("deny.toml allows no licences")?;
    let metadata = shell.cargo("metadata --locked --format-version 1").output()?;
    let metadata: Value = serde_json::from_str(&metadata).map_err(|e| e.to_string())?;
    let packages = metadata["packages"].as_array().ok_or("cargo metadata names no packages")?;
    let mut wrong = Vec::new();
    for package in packages {
        let text = |key: &str| package[key].as_str().unwrap_or("none");
        if !is_permitted(text("license"), &allowed) {
            wrong.push(format!("{} {}: {}", text("name"), text("version"), text("license")));
        }
        if package["source"].as_str().is_some_and(|source| !source.contains("crates.io-index")) {
            wrong.push(format!("{} is not from crates.io", text("name")));
        }
    }
    if packages.is_empty() || !wrong.is_empty() {
        return Err(format!("not allowed by deny.toml: {}", wrong.join(", ")));
    }
    let names: Vec<&str> = allowed.iter().map(String::as_str).collect();
    shell.say(&format!("{} packages, licences among {}", packages.len(), names.join(", ")));
    Ok(())
}

/// Names in the list `allow` of the configuration.
fn allowed(config: &str) -> Option<BTreeSet<String>> {
    let (_, list) = config.split_once("\nallow = [")?;
    let (list, _) = list.split_once(']')?;
    Some(list.split('"').skip(1).step_by(2).map(str::to_owned).collect())
}

/// Returns true if the allowed licences satisfy an SPDX expression. Exceptions (`WITH`) are
/// ignored, since they only permit more.
///
/// `AND` binds more tightly than `OR`, which older manifests write as a slash.
fn is_permitted(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    any(&words, &mut at, allowed) && at == words.len()
}

fn any(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut met = all(words, at, allowed);
    while words.get(*at) == Some(&"OR") {
        *at += 1;
        met |= all(words, at, allowed);
    }
    met
}

fn all(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut met = one(words, at, allowed);
    while words.get(*at) == Some(&"AND") {
        *at += 1;
        met &= one(words, at, allowed);
    }
    met
}

fn one(words: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let word = words.get(*at).copied().unwrap_or_default();
    *at += 1;
    if word == "(" {
        let met = any(words, at, allowed);
        *at += 1;
        return met;
    }
    if words.get(*at) == Some(&"WITH") {
        *at += 2;
    }
    allowed.contains(word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_are_met_or_not() {
        let allowed = allowed("[licenses]\nallow = [\"MIT\", \"Apache-2.0\",\n \"Zlib\"]\n").unwrap();
        assert_eq!(allowed.len(), 3);
        for good in [
            "MIT",
            "GPL-3.0 OR MIT",
            "MIT/GPL-3.0",
            "(MIT OR GPL-3.0) AND Zlib",
            "Apache-2.0 WITH LLVM-exception",
        ] {
            assert!(is_permitted(good, &allowed), "{good}");
        }
        for bad in
            ["GPL-3.0", "MIT AND GPL-3.0", "none", "", "GPL-3.0 OR MIT AND GPL-2.0", "(MIT", "MIT Zlib"]
        {
            assert!(!is_permitted(bad, &allowed), "{bad}");
        }
    }
}
