//! The extension module `tashika._tashika`: the library for Python, with images as NumPy arrays.
//!
//! Arguments are checked and passed on, results are passed back; nothing is computed here. The
//! package around it, in `python/`, declares the types.
#![forbid(unsafe_code)]

mod arrays;
mod attended;
mod building;
mod compare;
mod denoiser;
mod errors;
mod image;
mod json;
mod materials;
mod measure;
mod media;
mod notebook;
mod render;
mod scene;
mod sensors;
mod vpls;
mod words;

use pyo3::prelude::*;

#[pymodule]
mod _tashika {
    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    #[pymodule_export]
    use crate::building::{Camera, Light, Mesh};
    #[pymodule_export]
    use crate::compare::{Comparison, compare};
    #[pymodule_export]
    use crate::image::{Image, merge, read};
    #[pymodule_export]
    use crate::materials::Material;
    #[pymodule_export]
    use crate::measure::{coverage, exact};
    #[pymodule_export]
    use crate::media::Medium;
    #[pymodule_export]
    use crate::render::render;
    #[pymodule_export]
    use crate::scene::{Scene, builtin, load};
    #[pymodule_export]
    use crate::sensors::sensors;
    #[pymodule_export]
    use crate::vpls::{VplSet, vpls};
}
