//! Bounds against random members.

mod analytic;
pub(super) mod cases;
mod cube_map;
mod geometry;
mod reflector;
