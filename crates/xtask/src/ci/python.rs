//! Checks that need Python: reading our files with other libraries, running a job with a farm
//! engine, pages in a browser, and the Python package.

use std::fs;
use std::path::{Path, PathBuf};

use crate::shell::{Outcome, Shell, Task};

/// Makes a Python environment with packages that read OpenEXR and PNG, and drive a browser.
pub fn python_of_readers(shell: &Shell) -> Outcome<PathBuf> {
    environment(shell, "readers", "numpy OpenEXR OpenImageIO pillow playwright")
}

/// Makes a Python environment with these packages, and returns its interpreter.
pub fn environment(shell: &Shell, name: &str, packages: &str) -> Outcome<PathBuf> {
    let folder = shell.folder(name)?;
    shell.command("python3", "-m venv").arg(&folder).run()?;
    let python = folder.join("bin/python");
    if !packages.is_empty() {
        pip(shell, &python, "install").args(packages.split(' ')).run()?;
    }
    Ok(python)
}

/// Command of pip for this interpreter.
pub(super) fn pip(shell: &Shell, python: &Path, what: &str) -> Task {
    shell.command(python, "-m pip --quiet --disable-pip-version-check").args(what.split(' '))
}

/// Hard scenes that two renders can check in seconds.
const QUICK: [&str; 3] = ["pane", "double_pane", "coloured_pane"];

/// Renders the quick hard scenes with two seeds: at most one pair of intervals in fifty may be
/// disjoint.
pub fn seeds(shell: &Shell, python: &Path, program: &Path) -> Outcome<()> {
    let scenes = QUICK.map(|name| shell.root().join(format!("crates/xtask/hard_scenes/{name}.xml")));
    let options = "-- --size 16x9 --error 20%".split(' ');
    let task = shell.command(python, "").arg(shell.script("two_seeds.py")).arg(program);
    task.args(["--limit", "0.02"]).args(scenes).args(options).run()
}

/// Runs a job of five shares and their merge with an engine for Open Job Description.
pub fn job(shell: &Shell, python: &Path, program: &Path, room: &Path) -> Outcome<()> {
    const LINE: &str = "render builtin:tiny --size 70x50 --truth vpl --vpls 200 --gather 2 --error 5%";
    pip(shell, python, "install").arg("openjd-cli").run()?;
    let openjd = python.with_file_name("openjd");
    shell.command(program, LINE).args(["-o", "whole.exr", "--quiet"]).within(room).run()?;
    let farm = shell.command(program, "farm openjd --shares 5 --out").arg(room.join("job"));
    let farm = farm.arg("--program").arg(program).args(["--quiet", "--"]).args(LINE.split(' '));
    farm.args(["-o", "merged.exr"]).within(room).run()?;
    shell.command(&openjd, "check job/template.json").within(room).run()?;
    let run = "run job/template.json --step Merge --run-dependencies";
    shell.command(&openjd, run).within(room).run_quietly()?;
    for ending in ["exr", "png"] {
        let [merged, whole] =
            ["merged", "whole"].map(|name| fs::read(room.join(name).with_extension(ending)));
        let (merged, whole) = (merged.map_err(|e| e.to_string())?, whole.map_err(|e| e.to_string())?);
        if merged != whole {
            return Err(format!("merged.{ending} is not whole.{ending}"));
        }
    }
    Ok(())
}

/// Installs a browser if there is none.
pub fn browser(shell: &Shell) -> Outcome<()> {
    let known = ["chromium", "chromium-browser", "google-chrome"];
    if std::env::var_os("CHROMIUM").is_none() && !known.iter().any(|name| shell.has(name)) {
        let install = "install --yes --no-install-recommends chromium fonts-dejavu-core";
        shell.command("apt-get", "update").run_quietly()?;
        shell.command("apt-get", install).run_quietly()?;
    }
    Ok(())
}

/// Shows pages in a browser; screenshots go to the folder.
pub fn pages(shell: &Shell, python: &Path, program: &Path, screenshots: &Path) -> Outcome<()> {
    browser(shell)?;
    shell.command(python, "").arg(shell.script("page.py")).args([program, screenshots]).run()
}

/// Makes the wheel of the Python package with the program in it; returns its path.
pub fn wheel(shell: &Shell, python: &Path, program: &Path, folder: &Path) -> Outcome<PathBuf> {
    let scripts = shell.root().join("crates/tashika-python/program/scripts");
    let trouble = |e: std::io::Error| format!("{}: {e}", scripts.display());
    fs::create_dir_all(&scripts).map_err(trouble)?;
    fs::copy(program, scripts.join("tashika")).map_err(trouble)?;
    let wheel = pip(shell, python, "wheel").args(["--no-deps", "--wheel-dir"]).arg(folder);
    let made = wheel.arg("./crates/tashika-python").run();
    // The copy is removed, so that a later wheel without the program does not contain it.
    fs::remove_dir_all(&scripts).map_err(trouble)?;
    made?;
    let names = fs::read_dir(folder).map_err(|e| e.to_string())?;
    let mut names = names.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let wheel = names.find(|name| name.starts_with("tashika-") && name.contains("-abi3-"));
    Ok(folder.join(wheel.ok_or("the wheel is not for the stable interface")?))
}

/// A Python without packages, and the wheel that is built for it.
pub struct Package {
    python: PathBuf,
    wheel: PathBuf,
}

/// Builds the wheel of the Python package with the program in it.
pub fn built(shell: &Shell, program: &Path) -> Outcome<Package> {
    let python = environment(shell, "package", "")?;
    let wheel = wheel(shell, &python, program, &shell.folder("wheels")?)?;
    Ok(Package { python, wheel })
}

/// Installs the Python package, with the program, and runs its tests.
pub fn package(shell: &Shell, Package { python, wheel }: &Package, program: &Path) -> Outcome<()> {
    pip(shell, python, "install").arg(format!("{}[test]", wheel.display())).run()?;
    let version = "import tashika; print('tashika', tashika.__version__)";
    let module = shell.command(python, "-c").arg(version).output()?;
    let program_of_wheel = shell.command(python.with_file_name("tashika"), "--version").output()?;
    if module != program_of_wheel {
        return Err(format!("the wheel has the module {module} and the program {program_of_wheel}"));
    }
    // `pyoidn` has no wheels for some machines; its tests are omitted there.
    if pip(shell, python, "install").arg("pyoidn").run_quietly().is_err() {
        shell.say("pyoidn cannot be installed here: no test with Open Image Denoise");
    }
    let tests = "-m pytest --quiet -p no:cacheprovider crates/tashika-python";
    shell.command(python, tests).env("TASHIKA", program).run()
}
