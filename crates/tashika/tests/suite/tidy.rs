//! The sources themselves: layers, forbidden words, sizes, heads, references.
//!
//! Rules that neither the compiler nor clippy knows, run over the workspace by the tests below.
//!
//! What passing does not prove: that code keeps to the meaning of its layer. The tables say who may
//! name whom.

mod broken;
mod rules;
mod source;
mod tables;
mod workspace;

use std::collections::BTreeSet;
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
fn the_layers_are_those_of_the_documentation() {
    let lib = read(&workspace().join("crates/tashika/src/lib.rs"));
    let here: BTreeSet<_> = MODULES.iter().map(|m| (m.name.to_owned(), m.layer)).collect();
    assert_eq!(table_of(&lib), here, "the table in lib.rs and MODULES in tidy/tables.rs differ");
    let declared: BTreeSet<String> = file_modules(&lex(&lib).tokens).into_iter().collect();
    assert_eq!(
        declared,
        MODULES.iter().map(|m| m.name.to_owned()).collect(),
        "modules of lib.rs without a layer"
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
        let name = row.module;
        let owner =
            files.iter().find(|f| f.module.as_deref() == Some(&[name.to_owned()])).expect("its mod.rs");
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
    let manifest = read(&workspace().join("crates/tashika/Cargo.toml"));
    let listed: BTreeSet<&str> = DEPENDENCIES.iter().map(|d| d.0).collect();
    assert_eq!(dependencies(&manifest), listed, "Cargo.toml and DEPENDENCIES in tidy/tables.rs differ");
    let files = sources();
    for (name, owners) in DEPENDENCIES {
        for owner in owners.iter().map(Some).chain(owners.is_empty().then_some(None)) {
            let used = files.iter().filter(|f| f.top().is_some() && owner.is_none_or(|o| f.top() == Some(o)));
            let used = used.flat_map(|f| paths(&f.built)).any(|p| p.segments[0] == *name);
            assert!(used, "{name} is not used by {owner:?}; remove it from DEPENDENCIES, or from Cargo.toml");
        }
    }
}

#[test]
fn the_library_uses_no_forbidden_words() {
    assert_all_keep(words);
    for (path, _) in HASHED {
        let hashed = sources()
            .iter()
            .any(|f| f.in_library() == Some(path) && f.built.iter().any(|t| is_hash_table(&t.0)));
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
    // What is forbidden cannot be allowed in the files of UNSAFE.
    for (root, lint) in [
        ("crates/tashika/src/lib.rs", "deny"),
        ("crates/tashika-cli/src/main.rs", "forbid"),
        ("crates/tashika-viewer/src/lib.rs", "forbid"),
        ("crates/tashika-python/src/lib.rs", "forbid"),
    ] {
        let line = format!("#![{lint}(unsafe_code)]");
        assert!(read(&workspace().join(root)).contains(&line), "{root}: add {line}");
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
