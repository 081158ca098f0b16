//! Benchmarks of the renderer on any scene. Results are ratios of times that are measured in one
//! run.
//!
//!     cargo bench -p tashika-bench --bench tracing -- --help
//!
//! `measure` times variants in turns, so that other load on the machine affects all of them alike.
//! `subject` prepares the scene, view, lights and method. `recording` stores the rays and segments
//! of a render. `embree` traces them with Embree 4, if its library is named. The benchmarks need a
//! Unix system.

pub mod embree;
pub mod measure;
pub mod recording;
pub mod subject;
