//! Commands, run from the root of the checkout, and their output.

// The output is for readers of the log.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::{env, fs};

use tempfile::TempDir;

/// Result with a message as its error.
pub type Outcome<T> = Result<T, String>;

/// The checkout, and a folder for temporary files.
pub struct Shell {
    root: PathBuf,
    work: TempDir,
}

/// Prints the error that ended the task.
pub fn print_error(message: &str) {
    eprintln!("xtask: {message}");
}

impl Shell {
    /// Uses the checkout that this program was built from.
    pub fn new() -> Outcome<Self> {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let root = here.ancestors().nth(2).expect("two folders above").to_owned();
        let work = tempfile::tempdir().map_err(|e| format!("no folder for temporary files: {e}"))?;
        Ok(Self { root, work })
    }

    /// Prints the name of the next step.
    pub fn step(&self, what: &str) {
        println!("\n==> {what}");
    }

    /// Prints a result of the step.
    pub fn say(&self, what: &str) {
        println!("{what}");
    }

    /// Root folder of the checkout.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Makes a new folder that is removed at the end.
    pub fn folder(&self, name: &str) -> Outcome<PathBuf> {
        let folder = self.work.path().join(name);
        fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        Ok(folder)
    }

    /// Path of a script of the project.
    pub fn script(&self, name: &str) -> PathBuf {
        self.root.join("scripts").join(name)
    }

    /// Makes a command with its first arguments, separated by spaces.
    pub fn command(&self, program: impl AsRef<OsStr>, args: &str) -> Task {
        let mut command = Command::new(program);
        command.current_dir(&self.root).stdin(Stdio::null()).args(args.split_whitespace());
        Task(command)
    }

    /// Makes a command of Cargo with its first arguments.
    pub fn cargo(&self, args: &str) -> Task {
        self.command(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()), args)
    }

    /// Builds the program and returns its path. The examples are built too: dependencies then have
    /// the features that the tests need, and need not be built again for the tests.
    pub fn program(&self) -> Outcome<PathBuf> {
        self.cargo("build --locked --release --bins --examples").run()?;
        let told = self.cargo("metadata --locked --no-deps --format-version 1").output()?;
        let told: serde_json::Value = serde_json::from_str(&told).map_err(|e| e.to_string())?;
        let target = told["target_directory"].as_str().ok_or("cargo metadata names no target directory")?;
        Ok(Path::new(target).join("release/tashika"))
    }

    /// Returns true if there is a program of that name.
    pub fn has(&self, program: &str) -> bool {
        self.command("sh", "").args(["-c", &format!("command -v {program}")]).succeeds()
    }
}

/// A command that is about to be run.
pub struct Task(Command);

impl Task {
    /// Adds several arguments.
    pub fn args<A: AsRef<OsStr>>(mut self, args: impl IntoIterator<Item = A>) -> Self {
        self.0.args(args);
        self
    }

    /// Adds one argument.
    pub fn arg(self, arg: impl AsRef<OsStr>) -> Self {
        self.args([arg])
    }

    /// Sets a variable of the environment.
    pub fn env(mut self, name: &str, value: impl AsRef<OsStr>) -> Self {
        self.0.env(name, value);
        self
    }

    /// Sets the folder in which the command is run.
    pub fn within(mut self, folder: &Path) -> Self {
        self.0.current_dir(folder);
        self
    }

    /// Runs the command, which has to succeed.
    pub fn run(mut self) -> Outcome<()> {
        let status = self.0.status().map_err(|e| format!("{}: {e}", self.words()))?;
        if status.success() { Ok(()) } else { Err(format!("{}: {status}", self.words())) }
    }

    /// Runs the command, which has to succeed; its output is shown only in the message of a
    /// failure.
    pub fn run_quietly(self) -> Outcome<()> {
        self.output().map(drop)
    }

    /// Runs the command, which has to succeed, and returns its standard output.
    pub fn output(mut self) -> Outcome<String> {
        let output = self.finish()?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let last: Vec<&str> = said.lines().rev().take(20).collect();
            let last: Vec<&str> = last.into_iter().rev().collect();
            return Err(format!("{}: {}\n{}", self.words(), output.status, last.join("\n")));
        }
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// Runs the command; returns its exit code, `None` if a signal ended it, and its standard
    /// error.
    pub fn ended(mut self) -> Outcome<(Option<i32>, String)> {
        let output = self.finish()?;
        Ok((output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned()))
    }

    /// Runs the command; returns true if it exists and succeeds.
    pub fn succeeds(mut self) -> bool {
        self.finish().is_ok_and(|output| output.status.success())
    }

    fn finish(&mut self) -> Outcome<Output> {
        self.0.output().map_err(|e| format!("{}: {e}", self.words()))
    }

    fn words(&self) -> String {
        let args = self.0.get_args().map(OsStr::to_string_lossy);
        let words = std::iter::once(self.0.get_program().to_string_lossy()).chain(args);
        words.collect::<Vec<_>>().join(" ")
    }
}
