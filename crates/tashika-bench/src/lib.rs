//! How fast the renderer is: on whatever scene is given, as ratios of what is measured in one run.
//!
//!     cargo bench -p tashika-bench --bench tracing -- --help
//!
//! `measure` times variants in turns, so that what else the machine does falls on all of them;
//! `subject` is what is rendered; `recording` keeps the very rays and segments of a render;
//! `embree` is Embree 4, if a library is named. For Unix systems.

pub mod embree;
pub mod measure;
pub mod recording;
pub mod subject;
