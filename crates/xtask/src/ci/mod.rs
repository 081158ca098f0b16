//! All checks that have to pass before a change is taken, from a fresh clone, except the tests.
//!
//! The checks need rustup's stable toolchain, a C linker, and python3 with venv. They need no GPU.
//! From the network they need only crates.io, PyPI, Rust's toolchains and, if Chromium is not
//! installed, the packages of the system. Builds and screenshots are written to `target`,
//! everything else to a temporary folder.

mod blender;
mod end_to_end;
mod licences;
mod publishing;
mod python;
mod scenes;

pub use python::{environment, pages, python_of_readers, wheel};

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::thread;

use crate::shell::{Outcome, Shell};

/// Runs all steps until one fails.
pub fn run(shell: &Shell) -> Outcome<()> {
    toolchain(shell)?;
    shell.step("format");
    shell.cargo("fmt --all -- --check").run()?;
    shell.step("prose");
    shell.command("python3", "scripts/words.py --check").run()?;
    shell.step("lints, while tools are downloaded");
    let python = thread::scope(|scope| {
        let downloaded = scope.spawn(|| download(shell));
        // One profile for all steps, so that build scripts and macros are built once.
        shell.cargo("clippy --locked --release --workspace --all-targets -- -D warnings").run()?;
        downloaded.join().expect("it does not panic")
    })?;
    shell.step("the workbench");
    shell.cargo("test --locked --release --quiet -p xtask").run()?;
    others(shell)?;
    shell.step("documentation");
    // Only libraries are documented. The program has the same name as a library, and its page would
    // replace the library's page.
    shell
        .cargo("doc --locked --release --workspace --no-deps --lib")
        .env("RUSTDOCFLAGS", "-D warnings")
        .run()?;
    shell.step("parts alone");
    alone(shell)?;
    shell.step("licences of the dependencies");
    licences::check(shell)?;
    shell.step("what crates.io would be given");
    publishing::check(shell)?;
    shell.step("the program, end to end");
    let program = shell.program()?;
    let room = end_to_end::check(shell, &program)?;
    shell.step("the examples");
    for example in ["render", "own_method", "certificate"] {
        shell.command(program.with_file_name("examples").join(example), "").run()?;
    }
    shell.step("files in other readers");
    shell.command(&python, "").arg(shell.script("readers.py")).arg(&program).run()?;
    shell.step("two seeds of hard scenes");
    python::seeds(shell, &python, &program)?;
    shell.step("a job of another engine");
    python::job(shell, &python, &program, &room)?;
    shell.step("pages in a browser, while the wheel is built");
    // A browser leaves most of the processor idle.
    let package = thread::scope(|scope| {
        let package = scope.spawn(|| python::built(shell, &program));
        pages(shell, &python, &program, &shell.root().join("target/pages"))?;
        package.join().expect("it does not panic")
    })?;
    // Scenes are read and Python is run on one core each, most of the time.
    thread::scope(|scope| {
        let scenes = scope.spawn(|| scenes::check(shell, &program));
        shell.step("the Python package");
        python::package(shell, &package, &program)?;
        shell.step("the add-on for Blender");
        blender::check(shell, &program)?;
        scenes.join().expect("it does not panic")
    })
}

/// Downloads the tools of later steps, and returns a Python with the readers of files and the
/// browser's driver.
fn download(shell: &Shell) -> Outcome<PathBuf> {
    if shell.has("rustup") {
        let oldest = oldest(shell)?;
        shell.command("rustup", "toolchain install --profile minimal").arg(&oldest).run_quietly()?;
        let target = shell.command("rustup", "target add --toolchain").arg(&oldest);
        target.args(OTHER_MACHINES).run_quietly()?;
    }
    let python = python_of_readers(shell)?;
    python::browser(shell)?;
    Ok(python)
}

/// Checks that the renderer builds without the readers of files, and that `tashika-stats` depends
/// on a fixed list of packages, without readers of files and plotters.
fn alone(shell: &Shell) -> Outcome<()> {
    const ALL: [&str; 6] = ["glam", "libm", "rand_core", "rand_pcg", "tashika-math", "tashika-stats"];
    shell.cargo("check --locked --release -p tashika --no-default-features").run()?;
    shell.cargo("check --locked --release -p tashika-stats").run()?;
    let told = shell.cargo("tree --locked -p tashika-stats --edges normal --prefix none").output()?;
    let brought: BTreeSet<&str> = told.lines().filter_map(|line| line.split(' ').next()).collect();
    if brought != BTreeSet::from(ALL) {
        return Err(format!("tashika-stats brings {brought:?}, which is to be {ALL:?}"));
    }
    Ok(())
}

/// Installs two components that a minimal toolchain lacks.
fn toolchain(shell: &Shell) -> Outcome<()> {
    for (tool, component) in [("clippy", "clippy"), ("fmt", "rustfmt")] {
        if !shell.cargo(tool).arg("--version").succeeds() {
            shell.command("rustup", "component add").arg(component).run()?;
        }
    }
    Ok(())
}

/// Targets that the program has to compile for, although it does not run on them here.
const OTHER_MACHINES: [&str; 2] = ["aarch64-apple-darwin", "x86_64-pc-windows-gnu"];

/// Checks that the program compiles for other targets with the oldest compiler that the manifests
/// promise, if there is rustup.
fn others(shell: &Shell) -> Outcome<()> {
    if !shell.has("rustup") {
        return Ok(());
    }
    shell.step("other machines, older compilers");
    let targets = OTHER_MACHINES.iter().flat_map(|target| ["--target", target]);
    let check = "cargo check --locked --release --package tashika-cli --target-dir target/oldest";
    shell.command("rustup", "run").arg(oldest(shell)?).args(check.split(' ')).args(targets).run()
}

/// Version of the oldest compiler that the manifests promise.
fn oldest(shell: &Shell) -> Outcome<String> {
    let manifest = fs::read_to_string(shell.root().join("Cargo.toml")).map_err(|e| e.to_string())?;
    let versions =
        manifest.lines().find_map(|line| line.strip_prefix("rust-version = \"")?.strip_suffix('"'));
    Ok(versions.ok_or("Cargo.toml names no rust-version")?.to_owned())
}
