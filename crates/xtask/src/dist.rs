//! Files for distribution: the program in an archive, wheels that contain it, a Debian package, and
//! a list of their parts.
//!
//! The files are meant to be reproducible. The program contains no path of the machine that built
//! it, and files in the archive have the time of the last commit.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};

use crate::ci;
use crate::parts::Parts;
use crate::shell::{Outcome, Shell, Task};

/// Profile of the workspace for distributed programs.
const PROFILE: &str = "dist";

/// Shells whose completions go with the program, and the file names that they look for.
const COMPLETIONS: [(&str, &str); 3] =
    [("bash", "tashika.bash"), ("zsh", "_tashika"), ("fish", "tashika.fish")];

/// Makes all files for distribution.
pub fn run(shell: &Shell, folder: &Path) -> Outcome<()> {
    let folder = shell.root().join(folder);
    make(&folder)?;
    shell.step("The program");
    let time = shell.command("git", "log -1 --format=%ct").output()?.trim().to_owned();
    let remapped = remapped(shell);
    let build = shell.cargo("build --locked --package tashika-cli --profile").arg(PROFILE);
    reproducible(build, &time, &remapped).run()?;
    let parts = Parts::of_program(shell)?;
    let program = parts.target.join(PROFILE).join("tashika");
    let name = format!("tashika-{}-{}", parts.version, target(shell)?);
    archive(shell, &program, &parts, &folder, &name, &time)?;
    shell.step("Wheel");
    let python = ci::environment(shell, "wheel", "")?;
    let wheel = ci::wheel(shell, &python, &program, &folder)?;
    shell.say(&wheel.display().to_string());
    shell.step("Debian package");
    debian(shell, &folder, &time)?;
    shell.step("What it is made of");
    write(&folder.join(format!("tashika-{}.cdx.json", parts.version)), &parts.bill_of_materials())?;
    sums(shell, &folder)
}

/// Compiler flags that keep the paths of this machine out of the program.
fn remapped(shell: &Shell) -> String {
    let home = env::var("HOME").unwrap_or_default();
    let cargo = env::var("CARGO_HOME").unwrap_or_else(|_| format!("{home}/.cargo"));
    format!("--remap-path-prefix={}=tashika --remap-path-prefix={cargo}=cargo", shell.root().display())
}

fn reproducible(task: Task, time: &str, flags: &str) -> Task {
    task.env("SOURCE_DATE_EPOCH", time).env("RUSTFLAGS", flags)
}

/// Name of the machine that the program is for, as the compiler prints it.
fn target(shell: &Shell) -> Outcome<String> {
    let told = shell.command("rustc", "--version --verbose").output()?;
    let host = told.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).ok_or_else(|| "rustc names no host".to_owned())
}

/// Packs the program with its licences, completions and pages for `man`.
fn archive(
    shell: &Shell,
    program: &Path,
    parts: &Parts,
    folder: &Path,
    name: &str,
    time: &str,
) -> Outcome<()> {
    let inside = shell.folder("archive")?;
    let root = inside.join(name);
    let [completions, man] = ["completions", "man"].map(|part| root.join(part));
    for folder in [&completions, &man] {
        make(folder)?;
    }
    copy(program, &root.join("tashika"))?;
    for file in ["README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&shell.root().join(file), &root.join(file))?;
    }
    write(&root.join("LICENSES-OF-DEPENDENCIES.txt"), &parts.licences()?)?;
    for (kind, file) in COMPLETIONS {
        write(&completions.join(file), &shell.command(program, "completions").arg(kind).output()?)?;
    }
    write(&man.join("tashika.1"), &shell.command(program, "man").output()?)?;
    for command in ["render", "info", "compare", "merge", "view", "farm"] {
        let page = shell.command(program, "man").arg(command).output()?;
        write(&man.join(format!("tashika-{command}.1")), &page)?;
    }
    let file = folder.join(format!("{name}.tar.gz"));
    let sorted = "--sort=name --owner=0 --group=0 --numeric-owner --mode=go=rX,u+rw";
    let tar = shell.command("tar", sorted).arg(format!("--mtime=@{time}"));
    let tar = tar.args(["--use-compress-program=gzip --no-name --best", "--create", "--file"]);
    tar.arg(&file).arg("--directory").arg(&inside).arg(name).run()?;
    shell.say(&file.display().to_string());
    Ok(())
}

/// Makes a Debian package by `cargo deb`, if it is installed.
fn debian(shell: &Shell, folder: &Path, time: &str) -> Outcome<()> {
    if !shell.cargo("deb --version").succeeds() {
        shell.say("cargo deb is not installed: no Debian package");
        return Ok(());
    }
    let made = shell.cargo("deb --locked --package tashika-cli --no-build --no-strip --profile").arg(PROFILE);
    made.arg("--output").arg(folder).env("SOURCE_DATE_EPOCH", time).run()
}

/// Writes `SHA256SUMS` of the folder.
fn sums(shell: &Shell, folder: &Path) -> Outcome<()> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .map_err(|e| format!("{}: {e}", folder.display()))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name != "SHA256SUMS")
        .collect();
    names.sort();
    let told = shell.command("sha256sum", "--").args(&names).within(folder).output()?;
    shell.say(&told);
    write(&folder.join("SHA256SUMS"), &told)
}

fn make(folder: &Path) -> Outcome<()> {
    fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
}

fn copy(from: &Path, to: &PathBuf) -> Outcome<()> {
    fs::copy(from, to).map(drop).map_err(|e| format!("{}: {e}", from.display()))
}

fn write(path: &Path, text: &str) -> Outcome<()> {
    fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}
