//! The library's one test binary: everything that needs more than one module.

mod cases;
mod closed_forms;
mod determinism;
mod furnace;
mod light_transport;
mod gltf;
mod damaged_gltf;
mod obj;
mod damaged_obj;
