//! The source files of the workspace: every file that some crate is built from, by following its
//! `mod`s.

use std::fs;
use std::path::{Path, PathBuf};

use super::source::{Placed, file_modules, lex, without_tests};
use super::tables::LIBRARY;

/// A source file of the workspace, as tokens and comments.
pub(super) struct File {
    /// Path from the root of the workspace, with `/`.
    pub(super) path: String,
    /// Module, by its name for users of `tashika`; for files of the library's crates only.
    pub(super) module: Option<Vec<String>>,
    /// All of its code, and the code without tests.
    pub(super) all: Vec<Placed>,
    pub(super) built: Vec<Placed>,
    pub(super) comments: Vec<(String, usize)>,
    pub(super) lines: usize,
    pub(super) starts_with_doc: bool,
    pub(super) only_tests: bool,
}

impl File {
    pub(super) fn new(path: &str, text: &str, module: Option<Vec<String>>, only_tests: bool) -> Self {
        let lexed = lex(text);
        let built = if only_tests { Vec::new() } else { without_tests(&lexed.tokens) };
        Self {
            path: path.to_owned(),
            module,
            all: lexed.tokens,
            built,
            comments: lexed.comments,
            lines: text.lines().count(),
            starts_with_doc: text.starts_with("//! "),
            only_tests,
        }
    }

    /// Crate of the file, if that is one of the library's and the file is not a test of it.
    pub(super) fn in_library(&self) -> Option<&'static str> {
        LIBRARY.iter().map(|(name, _)| *name).find(|name| {
            let inside = self.path.strip_prefix("crates/").and_then(|path| path.strip_prefix(name));
            inside.is_some_and(|path| path.starts_with("/src/"))
        })
    }

    /// The library's module that it belongs to; `None` for a `lib.rs` of several modules, and for
    /// other crates.
    pub(super) fn top(&self) -> Option<&str> {
        self.module.as_ref()?.first().map(String::as_str)
    }

    pub(super) fn says(&self, line: usize, what: impl std::fmt::Display) -> String {
        format!("{}:{line}: {what}", self.path)
    }
}

pub(super) fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

pub(super) fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Every source file that some crate of the workspace is built from.
pub(super) fn sources() -> Vec<File> {
    let root = workspace();
    let mut files = Vec::new();
    for crate_folder in folders(&root.join("crates")) {
        for (folder, tests) in [("src", false), ("tests", true), ("benches", true), ("examples", true)] {
            let folder = crate_folder.join(folder);
            let flat = rust_files(&folder).into_iter().filter(|_| tests);
            let nested = folders(&folder).into_iter().map(|f| f.join("main.rs")).filter(|_| tests);
            let named = [folder.join("lib.rs"), folder.join("main.rs")].into_iter().filter(|_| !tests);
            for file in flat.chain(nested).chain(named).filter(|f| f.exists()) {
                let library = LIBRARY.iter().find(|(name, _)| crate_folder.ends_with(name));
                let module = library.map(|(_, module)| module.iter().map(|m| (*m).to_owned()).collect());
                visit(&root, &file, module.filter(|_| !tests), tests, true, &mut files);
            }
        }
    }
    files
}

/// Reads a file and the modules that it declares.
fn visit(
    root: &Path,
    path: &Path,
    module: Option<Vec<String>>,
    only_tests: bool,
    is_root: bool,
    out: &mut Vec<File>,
) {
    let name = path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
    let file = File::new(&name, &read(path), module, only_tests);
    let folder =
        if is_root || path.ends_with("mod.rs") { path.with_file_name("") } else { path.with_extension("") };
    let built = file_modules(&file.built);
    for child in file_modules(&file.all) {
        let candidates = [folder.join(format!("{child}.rs")), folder.join(&child).join("mod.rs")];
        let path = candidates.iter().find(|c| c.exists());
        let path = path.unwrap_or_else(|| panic!("{name}: no file for `mod {child}`"));
        let module = file.module.as_ref().map(|m| m.iter().chain([&child]).cloned().collect());
        visit(root, path, module, !built.contains(&child), false, out);
    }
    out.push(file);
}

fn folders(folder: &Path) -> Vec<PathBuf> {
    entries(folder).into_iter().filter(|p| p.is_dir()).collect()
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    entries(folder).into_iter().filter(|p| p.extension().is_some_and(|e| e == "rs")).collect()
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
}

/// Every `.rs` file below a folder.
pub(super) fn all_rust_files(folder: &Path) -> Vec<PathBuf> {
    let below = folders(folder).into_iter().flat_map(|f| all_rust_files(&f));
    rust_files(folder).into_iter().chain(below).collect()
}
