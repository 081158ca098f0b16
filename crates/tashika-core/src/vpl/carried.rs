//! The part of a surface's scattering that VPLs carry.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::math::Frame;
use crate::scene::SurfacePoint;

/// Returns `ρ(ω) / π · |n_s·ω|` (sr⁻¹): the radiance that the VPLs of a surface send out in all
/// directions of a side, for radiance that arrives along the unit direction `incoming` (pointing
/// away from the surface) from a solid angle of one.
///
/// * `bsdf`: the [part](crate::scene::Part) of the surface that reflects, or transmits, the light;
///   `ρ` is its [`vpl_reflectance`](Bsdf::vpl_reflectance).
///
/// Black where the normals `n_s` and `n_g` disagree on the side that the light comes from. All
/// other scattering is not in a set of VPLs: gloss, and the light that viewers see [past the
/// shading normal](SurfacePoint::normals_seen_from).
///
/// Light tracing leaves VPLs by this function, so estimators of the rest can rely on it.
pub fn carried_cos(surface: &SurfacePoint, bsdf: &Bsdf, incoming: Vec3) -> Rgb {
    let (ng, ns) = (surface.geometric_normal, surface.shading_normal);
    let cos = ns.dot(incoming);
    if ng.dot(incoming) * cos <= 0.0 {
        return Rgb::BLACK;
    }
    bsdf.vpl_reflectance(Frame::about(ns).to_local(incoming)) * (cos.abs() * FRAC_1_PI)
}
