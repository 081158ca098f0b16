//! The tables of features in the guide must equal those that the loaders state.
//!
//! Whether the rows are true is tested with the loader of each format.

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

use tashika::io::{FormatFeatures, Support, features};

const GUIDE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/GUIDE.md");

/// Word for a kind of support in the guide.
fn word(support: Support) -> &'static str {
    match support {
        Support::Full => "yes",
        Support::Approximated => "approximated",
        Support::Ignored => "ignored",
        Support::Refused => "refused",
    }
}

/// Table of a format in Markdown. Rows are grouped by kind, in the order of the loader.
fn table(format: &FormatFeatures) -> String {
    let mut kinds: Vec<&str> = Vec::new();
    for row in format.rows {
        if !kinds.contains(&row.kind) {
            kinds.push(row.kind);
        }
    }
    let mut text = String::from("| | in the file | read | what it becomes |\n|---|---|---|---|\n");
    for kind in kinds {
        for row in format.rows.iter().filter(|row| row.kind == kind) {
            let (name, how) = (row.name.replace('|', "\\|"), row.how.replace('|', "\\|"));
            // The name of one material of pbrt is empty.
            let name = if name.is_empty() { "\"\"" } else { &name };
            writeln!(text, "| {kind} | `{name}` | {} | {how} |", word(row.support)).expect("a string");
        }
    }
    text
}

/// The guide with the text between each pair of markers replaced.
fn with_tables(guide: &str) -> String {
    let mut guide = guide.to_owned();
    for format in features() {
        let (begin, end) = (format!("<!-- table: {} -->\n", format.format), "<!-- end of table -->");
        let start = guide.find(&begin).unwrap_or_else(|| panic!("the guide has no {begin}")) + begin.len();
        let stop = start + guide[start..].find(end).expect("the table ends");
        guide.replace_range(start..stop, &table(&format));
    }
    guide
}

#[test]
fn the_guide_has_the_tables_of_the_loaders() {
    let guide = fs::read_to_string(GUIDE).unwrap();
    let expected = with_tables(&guide);
    if env::var("TASHIKA_UPDATE_GOLDEN").is_ok_and(|v| v == "guide") {
        fs::write(Path::new(GUIDE), &expected).unwrap();
        return;
    }
    assert!(
        guide == expected,
        "docs/GUIDE.md is old: run the tests with TASHIKA_UPDATE_GOLDEN=guide and look at it"
    );
}

#[test]
fn no_row_is_there_twice_or_says_nothing() {
    for format in features() {
        let mut seen = Vec::new();
        for row in format.rows {
            let key = (row.kind, row.name);
            assert!(!seen.contains(&key), "{}: {key:?} twice", format.format);
            seen.push(key);
            assert!(!row.kind.is_empty() && !row.how.is_empty(), "{key:?}");
        }
        assert!(seen.len() > 10, "{}: a table", format.format);
    }
}
