//! Tests of the add-on for Blender, if Blender is installed as a Python module.

use std::env;
use std::ffi::OsString;
use std::path::Path;

use super::python::pip;
use crate::shell::{Outcome, Shell};

/// Variable that names the Python that has `bpy`.
const SWITCH: &str = "TASHIKA_BLENDER_PYTHON";
/// Interpreters that are tried if the variable is not set: each `bpy` is for one version of Python.
const KNOWN: [&str; 3] = ["python3", "python3.11", "python3.13"];

/// Runs the tests of the add-on. `bpy` is 370 MB: it is used if it is installed, and never
/// downloaded.
pub fn check(shell: &Shell, program: &Path) -> Outcome<()> {
    let named = env::var_os(SWITCH);
    let candidates: Vec<OsString> =
        named.as_ref().map_or_else(|| KNOWN.map(OsString::from).into(), |python| vec![python.clone()]);
    let has_blender = |python: &OsString| shell.command(python, "-c").arg("import bpy").succeeds();
    let Some(python) = candidates.into_iter().find(has_blender) else {
        if let Some(python) = named {
            return Err(format!("{SWITCH} is {}, which cannot import bpy", python.display()));
        }
        shell.say(&format!(
            "none of {} can import bpy: the add-on for Blender is not tested (pip install bpy, or set {SWITCH})",
            KNOWN.join(", ")
        ));
        return Ok(());
    };
    let folder = shell.folder("blender")?;
    pip(shell, Path::new(&python), "install --target").arg(&folder).arg("pytest").run()?;
    let tests = shell.command(&python, "-m pytest --quiet -p no:cacheprovider blender");
    tests.env("PYTHONPATH", &folder).env("TASHIKA", program).run()
}
