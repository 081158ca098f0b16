//! Tests of the source texts: layers, forbidden words, sizes, file heads, references.
//!
//! The tests below check rules that neither the compiler nor clippy checks, on the whole workspace.
//! The tables list which module may name which. That code does not exceed the purpose of its layer
//! is not proved by them.

mod broken;
mod rules;
mod source;
mod tables;
mod workspace;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use rules::*;
use source::{file_modules, lex, paths};
use tables::*;
use workspace::{File, all_rust_files, read, sources, workspace};

fn assert_none(wrong: &[String]) {
    assert!(wrong.is_empty(), "\n{}\n", wrong.join("\n"));
}

fn assert_all_keep(rule: impl Fn(&File) -> Vec<String>) {
    assert_none(&sources().iter().flat_map(rule).collect::<Vec<_>>());
}

#[test]
fn modules_use_only_lower_layers() {
    assert_all_keep(layers);
}

#[test]
fn the_layers_and_crates_are_those_of_the_documentation() {
    let lib = read(&workspace().join("crates/tashika/src/lib.rs"));
    let here: BTreeSet<_> = MODULES.iter().map(|m| (m.name.to_owned(), m.layer)).collect();
    assert_eq!(layers_of(&lib), here, "the table in lib.rs and MODULES in tidy/tables.rs differ");
    let declared = |(name, root): &(&str, Option<&str>)| {
        let text = read(&workspace().join("crates").join(name).join("src/lib.rs"));
        let modules = match root {
            Some(root) => vec![(*root).to_owned()],
            None => file_modules(&lex(&text).tokens),
        };
        ((*name).to_owned(), modules.into_iter().collect())
    };
    let crates: BTreeMap<String, BTreeSet<String>> = LIBRARY.iter().map(declared).collect();
    assert_eq!(crates_of(&lib), crates, "the table in lib.rs and the modules of the crates differ");
    assert_eq!(
        crates.into_values().flatten().collect::<BTreeSet<_>>(),
        MODULES.iter().map(|m| m.name.to_owned()).collect(),
        "modules without a layer"
    );
    let architecture = read(&workspace().join("ARCHITECTURE.md"));
    for m in MODULES {
        assert!(
            architecture.contains(&format!("`{}`", m.name)),
            "ARCHITECTURE.md does not tell of `{}`",
            m.name
        );
    }
}

#[test]
fn alternatives_do_not_use_each_other() {
    let files = sources();
    for row in SIDE_BY_SIDE {
        let name = row.owner;
        let owner = files.iter().find(|f| f.path == name).expect("the file of the module");
        let own_files = file_modules(&owner.built);
        let known = |file: &str| own_files.iter().any(|own| own == file);
        assert!(own_files.len() > 1, "{name} has no alternatives");
        assert!(row.common.iter().chain(row.lists).all(|file| known(file)), "{name} has no such file");
        assert_none(&files.iter().flat_map(|f| side_by_side(f, owner, row)).collect::<Vec<_>>());
    }
}

#[test]
fn dependencies_are_named_only_where_they_belong() {
    assert_all_keep(foreign);
    let files = sources();
    let names = |file: &File, name: &str| paths(&file.built).iter().any(|p| p.segments[0] == name);
    for (library, _) in LIBRARY {
        let manifest = read(&workspace().join("crates").join(library).join("Cargo.toml"));
        let listed = dependencies(&manifest);
        let own: Vec<&File> = files.iter().filter(|f| f.in_library() == Some(library)).collect();
        for name in &listed {
            let used = own.iter().any(|f| names(f, &name.replace('-', "_")));
            assert!(used, "{library} does not use {name}; remove it from its Cargo.toml");
        }
        for (_, name, owners) in DEPENDENCIES.iter().filter(|row| row.0 == *library) {
            assert!(listed.contains(name), "{library} has no {name}; remove it from DEPENDENCIES");
            for owner in *owners {
                let used = own.iter().any(|f| f.top() == Some(owner) && names(f, name));
                assert!(used, "{name} is not used by {owner}; remove it from DEPENDENCIES");
            }
        }
    }
}

#[test]
fn the_library_uses_no_forbidden_words() {
    assert_all_keep(words);
    for (path, _) in HASHED {
        let hashed = sources().iter().any(|f| f.path == *path && f.built.iter().any(|t| is_hash_table(&t.0)));
        assert!(hashed, "{path} has no hash table; remove it from HASHED");
    }
}

#[test]
fn elementary_functions_have_the_same_bits_everywhere() {
    assert_all_keep(elementary);
}

#[test]
fn no_code_is_unsafe() {
    assert_all_keep(unsafe_code);
    // The crates of files in UNSAFE deny unsafe code, and all others forbid it.
    let roots = LIBRARY.iter().map(|(name, _)| format!("crates/{name}/src/lib.rs"));
    let others = ["tashika-cli/src/main.rs", "tashika-viewer/src/lib.rs", "tashika-python/src/lib.rs"];
    for root in roots.chain(others.map(|path| format!("crates/{path}"))) {
        let has_unsafe = UNSAFE.iter().any(|(path, _)| path.starts_with(root.trim_end_matches("lib.rs")));
        let line = format!("#![{}(unsafe_code)]", if has_unsafe { "deny" } else { "forbid" });
        assert!(read(&workspace().join(&root)).contains(&line), "{root}: add {line}");
    }
}

#[test]
fn planes_and_metadata_are_named_in_one_table() {
    assert_all_keep(schema);
    for (path, names, _) in OTHER_NAMES {
        for name in *names {
            let there = sources().iter().filter(|f| f.path == *path).any(|f| {
                f.built.iter().any(|(token, _)| matches!(token, source::Token::Text(text) if text == name))
            });
            assert!(there, "{path} does not say {name:?}; remove it from OTHER_NAMES");
        }
    }
}

#[test]
fn files_have_a_head_and_an_end() {
    assert_all_keep(upkeep);
}

#[test]
fn works_that_are_named_are_in_the_bibliography() {
    let entries = bibliography(&read(&workspace().join("REFERENCES.md")));
    assert_all_keep(|f| references(f, &entries));
}

#[test]
fn every_file_is_part_of_a_crate() {
    let root = workspace();
    let built: BTreeSet<PathBuf> = sources().iter().map(|f| root.join(&f.path)).collect();
    let stray: Vec<String> = all_rust_files(&root.join("crates"))
        .iter()
        .filter(|f| !built.contains(*f))
        .map(|f| format!("{}: no module declares it; add a `mod`, or remove the file", f.display()))
        .collect();
    assert_none(&stray);
    assert!(built.len() > 100, "the walk saw {} files only", built.len());
}
