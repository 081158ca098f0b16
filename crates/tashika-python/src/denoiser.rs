//! What smooths audited pictures, by its name in Python.

use std::env;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use tashika::reconstruction::Smoother;
use tashika_oidn::{Oidn, SYSTEM};

use crate::errors::raised;

/// Where the library is, where nobody says it.
const VARIABLE: &str = "TASHIKA_OIDN";

/// The smoother of this name or file; none for our own.
pub fn of(py: Python<'_>, name: &Path, threads: usize) -> PyResult<Option<Arc<dyn Smoother>>> {
    let library = match name.to_str() {
        Some("own") => return Ok(None),
        Some("oidn") => env::var_os(VARIABLE)
            .map(PathBuf::from)
            .or_else(|| of_package(py))
            .unwrap_or_else(|| SYSTEM.into()),
        _ => name.to_owned(),
    };
    Ok(Some(Arc::new(Oidn::load(&library, threads).map_err(raised)?)))
}

/// The library that the package `pyoidn` carries, if it is installed.
fn of_package(py: Python<'_>) -> Option<PathBuf> {
    let spec = py.import("importlib.util").ok()?.call_method1("find_spec", ("pyoidn",)).ok()?;
    let origin: PathBuf = spec.getattr("origin").ok()?.extract().ok()?;
    let folder = origin.parent()?.join("oidn");
    ["lib", "bin"].iter().map(|inner| folder.join(inner).join(SYSTEM)).find(|file| file.is_file())
}
