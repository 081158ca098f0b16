//! The library's one test binary: everything that needs more than one module.

mod cases;
mod closed_forms;
mod damaged_gltf;
mod damaged_obj;
mod determinism;
mod furnace;
mod gltf;
mod light_transport;
mod obj;
mod tidy;
