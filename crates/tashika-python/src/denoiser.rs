//! Smoothers of audited pictures, by their names in Python.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use tashika::reconstruction::Smoother;
use tashika_oidn::{Oidn, SYSTEM};

use crate::errors::raised;

/// Returns the smoother of this name or file; `None` for the built-in reconstruction.
pub fn of(py: Python<'_>, name: &Path, threads: usize) -> PyResult<Option<Arc<dyn Smoother>>> {
    Oidn::by_name(name, || of_package(py), threads).map_err(raised)
}

/// Library in the package `pyoidn`, if that is installed.
fn of_package(py: Python<'_>) -> Option<PathBuf> {
    let spec = py.import("importlib.util").ok()?.call_method1("find_spec", ("pyoidn",)).ok()?;
    let origin: PathBuf = spec.getattr("origin").ok()?.extract().ok()?;
    let folder = origin.parent()?.join("oidn");
    ["lib", "bin"].iter().map(|inner| folder.join(inner).join(SYSTEM)).find(|file| file.is_file())
}
