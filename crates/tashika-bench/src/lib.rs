//! Benchmarks of the renderer on any scene, as ratios of times that are measured in one run.
//!
//!     cargo bench -p tashika-bench --bench tracing -- --help
//!
//! `measure` times variants in turns, so that other load on the machine falls on all of them;
//! `subject` has the scene, view, lights and method that are rendered; `recording` stores the rays
//! and segments of a render; `embree` is Embree 4, if a library is named. For Unix systems.

pub mod embree;
pub mod measure;
pub mod recording;
pub mod subject;
