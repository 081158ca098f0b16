//! What fuzz targets do with their bytes. It stands in the tests of the library, which compile it and give
//! it the seeds.

#[path = "../../crates/tashika/tests/suite/fuzzing.rs"]
mod fuzzing;

pub use fuzzing::{light, load, load_vpls, read_film, resume};
