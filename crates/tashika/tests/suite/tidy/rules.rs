//! The rules, each a function from a file to its violations, as
//! `path:line: what is wrong; what to do`.

use std::collections::{BTreeMap, BTreeSet};

use tashika::film::SCHEMA;
use tashika::film::keys::KEYS;

use super::source::{Path as CodePath, Token, file_modules, paths};
use super::tables::*;
use super::workspace::File;

fn find(name: &str) -> Option<&'static Module> {
    MODULES.iter().find(|m| m.name == name)
}

/// Returns true if the row of one module permits the use of another.
pub(super) fn allows(user: &Module, used: &Module) -> bool {
    let is_lower = used.layer < user.layer && !user.never.contains(&used.name);
    user.name == used.name || is_lower || user.beside.contains(&used.name)
}

/// Path of a library item from the library's root, as users of `tashika` write it, if the code
/// gives it from a crate or from `self` or `super`; empty for all of a crate.
fn in_tashika(file: &File, path: &CodePath) -> Option<Vec<String>> {
    // No other crate names `tashika` itself: the word alone is a module of methods.
    let below = LIBRARY.iter().filter(|(name, _)| *name != "tashika");
    if let Some((_, root)) = below.into_iter().find(|(name, _)| name.replace('-', "_") == path.segments[0]) {
        let rest = path.segments[1..].iter().filter(|s| *s != "self").cloned();
        return Some(root.iter().map(|root| (*root).to_owned()).chain(rest).collect());
    }
    let absolute = path.absolute(file.module.as_deref()?)?;
    // In a crate that is one module, the names of its root that are not imported are that module's.
    let own = LIBRARY.iter().find(|(name, _)| Some(*name) == file.in_library()).and_then(|row| row.1);
    match (own, absolute.first()) {
        (Some(own), Some(first)) if find(first).is_none() => {
            Some([own.to_owned()].into_iter().chain(absolute).collect())
        }
        _ => Some(absolute),
    }
}

/// A module names only the modules that its row allows.
pub(super) fn layers(file: &File) -> Vec<String> {
    let Some(top) = file.top() else { return Vec::new() };
    let Some(row) = find(top) else {
        return vec![
            file.says(1, format!("module {top} has no layer; give it one in lib.rs and in tidy/tables.rs")),
        ];
    };
    let mut wrong = Vec::new();
    for path in paths(&file.built) {
        let Some(absolute) = in_tashika(file, &path) else { continue };
        let used = absolute.first().map_or("*", String::as_str);
        if used == "*" {
            wrong.push(file.says(path.line, "names the root of the crate; name the module"));
        } else if used != row.name && !find(used).is_some_and(|used| allows(row, used)) {
            let layer = row.layer;
            wrong.push(file.says(
                path.line,
                format!(
                    "{top} (layer {layer}) must not use {used}; move the code, or what it needs, to its layer"
                ),
            ));
        }
    }
    wrong
}

/// Alternatives do not use each other; `owner` is their `mod.rs`.
pub(super) fn side_by_side(file: &File, owner: &File, row: &SideBySide) -> Vec<String> {
    let (Some(module @ [parent, own, ..]), Some(top)) = (file.module.as_deref(), owner.top()) else {
        return Vec::new();
    };
    if parent != top || row.lists.contains(&own.as_str()) {
        return Vec::new();
    }
    let mut siblings = file_modules(&owner.all);
    siblings.retain(|sibling| !row.common.contains(&sibling.as_str()));
    // Names that the parent passes on are still the sibling's.
    let passed_on: BTreeMap<String, String> = paths(&owner.built)
        .into_iter()
        .filter(|p| siblings.contains(&p.segments[0]))
        .map(|p| (p.segments[p.segments.len() - 1].clone(), p.segments[0].clone()))
        .collect();
    let mut wrong = Vec::new();
    for path in paths(&file.built) {
        let absolute = path.absolute(module);
        let Some([first, name, ..]) = absolute.as_deref() else { continue };
        let sibling = if siblings.contains(name) { Some(name) } else { passed_on.get(name) };
        if first == parent && sibling.is_some_and(|s| s != own) {
            let home = &owner.path;
            wrong.push(
                file.says(
                    path.line,
                    format!("{own} uses {name} of a sibling; move what both need to {home}"),
                ),
            );
        }
    }
    wrong
}

/// Dependencies and parts of `std` are named only where they belong.
pub(super) fn foreign(file: &File) -> Vec<String> {
    let Some(top) = file.top() else { return Vec::new() };
    let mut wrong = Vec::new();
    for CodePath { segments, line, .. } in paths(&file.built) {
        let second = segments.get(1).map_or("", String::as_str);
        if let Some((_, name, owners)) =
            DEPENDENCIES.iter().find(|(of, name, _)| Some(*of) == file.in_library() && segments[0] == *name)
            && !owners.contains(&top)
        {
            let owners = owners.join(", ");
            wrong.push(
                file.says(
                    line,
                    format!("{top} names the crate {name}; only {owners} may: use what they offer"),
                ),
            );
        }
        if let Some((part, owners, why)) =
            STD.iter().find(|(part, ..)| segments[0] == "std" && second == *part)
            && !owners.contains(&top)
        {
            wrong.push(file.says(line, format!("std::{part}: {why}")));
        }
    }
    wrong
}

/// Elementary functions are those of `math::elementary`, and of no other module.
pub(super) fn elementary(file: &File) -> Vec<String> {
    if file.in_library().is_none() {
        return Vec::new();
    }
    let functions =
        paths(&file.built).into_iter().filter(|p| ["f32", "f64"].contains(&p.segments[0].as_str()));
    let functions = functions.map(|p| (p.segments[p.segments.len() - 1].clone(), p.line));
    let mut found: Vec<(String, usize)> =
        functions.filter(|(f, _)| ELEMENTARY.contains(&f.as_str())).collect();
    for three in file.built.windows(3) {
        let [(before, _), (Token::Word(word), line), (Token::Sign('('), _)] = three else { continue };
        let is_method = *before == Token::Sign('.') && ELEMENTARY.contains(&word.as_str());
        if is_method || ELEMENTARY_INSIDE.contains(&word.as_str()) {
            found.push((word.clone(), *line));
        }
    }
    let advice = "its last bits differ between machines; use math::elementary";
    found.into_iter().map(|(function, line)| file.says(line, format!("{function}: {advice}"))).collect()
}

/// Words that the library's code does not use.
pub(super) fn words(file: &File) -> Vec<String> {
    if file.in_library().is_none() {
        return Vec::new();
    }
    let mut wrong = Vec::new();
    for (token, line) in &file.built {
        let Token::Word(word) = token else { continue };
        if let Some((_, why)) = FORBIDDEN.iter().find(|(words, _)| words.contains(&word.as_str())) {
            wrong.push(file.says(*line, format!("{word}: {why}")));
        }
        if is_hash_table(token) && !HASHED.iter().any(|(allowed, _)| *allowed == file.path) {
            let advice =
                "take BTreeMap or a Vec, or say in HASHED of tidy/tables.rs why its order reaches no result";
            wrong.push(file.says(*line, format!("{word}: {advice}")));
        }
    }
    wrong
}

pub(super) fn is_hash_table(token: &Token) -> bool {
    token.is("HashMap") || token.is("HashSet")
}

/// `unsafe`, in tests too.
pub(super) fn unsafe_code(file: &File) -> Vec<String> {
    let allowed = UNSAFE.iter().any(|(path, _)| *path == file.path);
    let found = file.all.iter().filter(|(token, _)| !allowed && token.is("unsafe"));
    found
        .map(|(_, line)| {
            file.says(*line, "unsafe: write it safely, or list the file in UNSAFE of tidy/tables.rs")
        })
        .collect()
}

/// Planes and values of the metadata are accessed by their rows in `film/record`, not by name.
pub(super) fn schema(file: &File) -> Vec<String> {
    if file.path.starts_with(SCHEMA_HOME) {
        return Vec::new();
    }
    let is_name = |text: &str| {
        SCHEMA.iter().any(|row| row.spec.name == text) || KEYS.iter().any(|key| key.name == text)
    };
    // Names that are no everyday words.
    let is_telling = |text: &str| is_name(text) && text.contains(['_', '.']);
    let mut wrong = Vec::new();
    for (i, (token, line)) in file.built.iter().enumerate() {
        let Token::Text(text) = token else { continue };
        let before = |k: usize| i.checked_sub(k).map(|at| &file.built[at].0);
        let is = |k: usize, word: &str| before(k).is_some_and(|token| token.is(word));
        let sign = |k: usize, sign: char| before(k) == Some(&Token::Sign(sign));
        let asks = ["set", "get", "text", "number", "bool"].iter().any(|word| is(2, word)) && sign(3, '.');
        let of_metadata = ["metadata", "m"].iter().any(|word| is(4, word))
            || sign(4, ')') && ["metadata", "metadata_mut"].iter().any(|word| is(6, word));
        let of_film = ["plane", "plane_mut", "only"].iter().any(|word| is(2, word));
        let looks_up = sign(1, '(') && (of_film || asks && of_metadata);
        let is_allowed =
            OTHER_NAMES.iter().any(|(path, names, _)| *path == file.path && names.contains(&text.as_str()));
        if (looks_up || is_telling(text)) && !is_allowed {
            wrong.push(file.says(
                *line,
                format!("{text:?}: ask by the row in film/record; what means something else goes to OTHER_NAMES of tidy/tables.rs"),
            ));
        }
    }
    wrong
}

/// Every file has a head, a limited length, and no unfinished work.
pub(super) fn upkeep(file: &File) -> Vec<String> {
    let mut wrong = Vec::new();
    if !file.starts_with_doc {
        wrong.push(file.says(1, "does not begin with `//! ` and what the file is for"));
    }
    let most = if file.only_tests { MOST_LINES_OF_TESTS } else { MOST_LINES };
    if file.lines > most {
        wrong.push(
            file.says(most, format!("has {} lines, more than {most}; split it by what it does", file.lines)),
        );
    }
    for (text, line) in &file.comments {
        let found = text.split(|c: char| !c.is_alphanumeric()).find(|w| UNFINISHED.contains(w));
        wrong.extend(
            found.map(|w| {
                file.says(*line, format!("{w}: finish it, or write down elsewhere what is missing"))
            }),
        );
    }
    wrong
}

/// REFERENCES.md: the text of each entry by its key.
pub(super) fn bibliography(text: &str) -> BTreeMap<String, String> {
    let mut entries = BTreeMap::new();
    for entry in text.split("\n- **").skip(1) {
        let (key, rest) = entry.split_once("**").expect("a key ends with two asterisks");
        let rest = rest.split("\n\n").next().unwrap_or_default();
        assert!(entries.insert(key.to_owned(), rest.to_owned()).is_none(), "REFERENCES.md has {key} twice");
    }
    entries
}

/// Works named in comments, as a footnote or as "Name Year", are in the bibliography.
pub(super) fn references(file: &File, bibliography: &BTreeMap<String, String>) -> Vec<String> {
    let mut wrong = Vec::new();
    for (text, line) in &file.comments {
        for (start, _) in text.match_indices("[^") {
            let key = text[start + 2..].split(']').next().unwrap_or_default();
            if !bibliography.contains_key(key) {
                wrong.push(file.says(*line, format!("[^{key}] is not in REFERENCES.md; add it there")));
            }
        }
    }
    let words: Vec<(&str, usize)> = file
        .comments
        .iter()
        .flat_map(|(text, line)| text.split_whitespace().map(move |w| (w, *line)))
        .collect();
    let words: Vec<(&str, usize)> =
        words.into_iter().filter(|w| !["//", "//!", "///"].contains(&w.0)).collect();
    for (i, (word, line)) in words.iter().enumerate() {
        let year = word.trim_matches(|c: char| !c.is_alphanumeric());
        let before = |k: usize| i.checked_sub(k).map_or("", |j| words[j].0);
        let name = if before(2) == "et" && before(1) == "al." { before(3) } else { before(1) };
        let name = name.trim_start_matches(['(', '[']);
        if is_year(year)
            && is_name(name)
            && !bibliography.values().any(|e| e.contains(name) && e.contains(year))
        {
            wrong.push(file.says(*line, format!("{name} {year} is not in REFERENCES.md; add it there")));
        }
    }
    wrong
}

fn is_year(word: &str) -> bool {
    word.len() == 4 && word.parse().is_ok_and(|year| (1600..2100).contains(&year))
}

fn is_name(word: &str) -> bool {
    word.starts_with(char::is_uppercase) && word.chars().all(|c| c.is_alphabetic() || "'’-".contains(c))
}

/// The rows of the table of layers in the documentation of `lib.rs`: module and layer.
pub(super) fn layers_of(lib: &str) -> BTreeSet<(String, u8)> {
    let rows = table(lib).into_iter().filter_map(|(layer, modules)| Some((layer.parse().ok()?, modules)));
    rows.flat_map(|(layer, modules)| modules.into_iter().map(move |m| (m, layer))).collect()
}

/// Rows of the table of crates: crate and modules.
pub(super) fn crates_of(lib: &str) -> BTreeMap<String, BTreeSet<String>> {
    let rows = table(lib).into_iter().filter_map(|(name, modules)| {
        let name = name.strip_prefix('`')?.strip_suffix('`')?;
        Some((name.to_owned(), modules.into_iter().collect()))
    });
    rows.collect()
}

/// Rows of tables: the first cell, and the link targets of the second.
fn table(lib: &str) -> Vec<(&str, Vec<String>)> {
    let rows = lib.lines().filter_map(|line| line.strip_prefix("//! | ")?.split_once(" | "));
    let names = |rest: &str| {
        let links = rest.split("[`").skip(1);
        links.map(|link| link.split('`').next().unwrap_or_default().to_owned()).collect()
    };
    rows.map(|(first, rest)| (first, names(rest))).collect()
}

/// Names below `[dependencies]` of a manifest.
pub(super) fn dependencies(manifest: &str) -> BTreeSet<&str> {
    let table = manifest.split("\n[").find_map(|t| t.strip_prefix("dependencies]")).unwrap_or_default();
    let entries = table.lines().filter(|l| !l.is_empty() && !l.starts_with('#'));
    entries.filter_map(|l| l.split(['.', ' ', '=']).next()).collect()
}
