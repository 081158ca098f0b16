//! The part of a surface's scattering that its VPLs represent.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::bsdf::Bsdf;
use crate::color::Rgb;
use crate::math::Frame;
use crate::scene::SurfacePoint;

/// Returns `ρ(ω) / π · |n_s·ω|` (sr⁻¹): the radiance that the VPLs of a surface emit in all
/// directions of one side, per unit of radiance and solid angle that arrive from the unit direction
/// `incoming` (pointing away from the surface).
///
/// * `bsdf`: the [part](crate::scene::Part) of the surface that reflects, or transmits, the light;
///   `ρ` is its [`vpl_reflectance`](Bsdf::vpl_reflectance).
///
/// Black if the normals `n_s` and `n_g` disagree on the side from which the light comes. VPLs
/// represent no other scattering: neither gloss, nor the light that viewers see [past the shading
/// normal](SurfacePoint::normals_seen_from).
///
/// Light tracing creates its VPLs with this function, so estimators of the remaining light can rely
/// on it.
pub fn carried_cos(surface: &SurfacePoint, bsdf: &Bsdf, incoming: Vec3) -> Rgb {
    let (ng, ns) = (surface.geometric_normal, surface.shading_normal);
    let cos = ns.dot(incoming);
    if ng.dot(incoming) * cos <= 0.0 {
        return Rgb::BLACK;
    }
    bsdf.vpl_reflectance(Frame::about(ns).to_local(incoming)) * (cos.abs() * FRAC_1_PI)
}
