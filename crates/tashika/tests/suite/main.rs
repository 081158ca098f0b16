//! The library's one test binary: everything that needs more than one module.

mod adversarial;
mod cases;
mod closed_forms;
mod control;
mod cuts;
mod damaged_gltf;
mod damaged_mitsuba;
mod damaged_obj;
mod damaged_pbrt;
mod determinism;
mod features;
mod filters;
mod formats;
mod furnace;
mod gltf;
mod gltf_features;
mod gltf_materials;
mod gltf_structure;
mod hard_light;
mod light_transport;
mod mitsuba;
mod obj;
mod obj_features;
mod pbrt;
mod pbrt_appearance;
mod tidy;
