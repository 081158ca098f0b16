//! Surfaces on paths. A selected part of a surface either gathers light or sends the path on in one
//! direction.

use glam::Vec3;

use super::GatherPoint;
use crate::bsdf::{Bsdf, BsdfSample, Lobe};
use crate::color::Rgb;
use crate::math::Ray;
use crate::scene::{Part, Scene, SurfacePoint};

/// Interaction of a path with a surface, by one of its [parts](crate::scene::Part).
#[derive(Clone, Copy, Debug)]
pub enum Scatter {
    /// Gathers light; the weight is one over the probability of the choice.
    Gathers(GatherPoint),
    /// Sends the path on in one direction.
    Specular(SpecularPoint),
}

/// Surface that sends light on in one direction.
#[derive(Clone, Copy, Debug)]
pub struct SpecularPoint {
    surface: SurfacePoint,
    outgoing: Vec3,
    bsdf: Bsdf,
    weight: f32,
}

impl Scatter {
    /// Returns the part of a surface, seen from the unit direction `outgoing`, that the uniform
    /// number `choice` selects.
    pub fn at(scene: &Scene, surface: &SurfacePoint, outgoing: Vec3, choice: f32) -> Self {
        let Part { bsdf, weight, through } = scene.part(surface, outgoing, choice);
        if bsdf.is_specular() {
            return Self::Specular(SpecularPoint { surface: *surface, outgoing, bsdf, weight });
        }
        let (geometric_normal, shading_normal) = surface.normals_seen_from(outgoing);
        // A part that transmits light gathers behind the surface, as if seen from there.
        let side = if through { -1.0 } else { 1.0 };
        let frame = surface.frame(shading_normal * side);
        let wo = frame.to_local(outgoing) * Vec3::new(1.0, 1.0, side);
        Self::Gathers(GatherPoint {
            position: surface.leave(geometric_normal * side),
            geometric_normal: geometric_normal * side,
            wo,
            frame,
            bsdf,
            weight: Rgb::gray(weight),
            medium: None,
            phase: None,
            instant: 0,
        })
    }
}

impl SpecularPoint {
    /// Returns the ray after the surface, and its weight; `None` where the path ends.
    pub fn step(&self, u: [f32; 3]) -> Option<(Ray, Rgb)> {
        let (direction, sample) = self.sample(u)?;
        Some((Ray::new(self.surface.leave(direction), direction), sample.weight * self.weight))
    }

    /// Returns the ray that a smooth face of glass transmits, and its weight, which includes the
    /// share of light that is not reflected. `None` for other surfaces, and where all light is
    /// reflected.
    pub fn transmit(&self) -> Option<(Ray, Rgb)> {
        // At these ends of the unit interval, the BSDF selects transmission.
        let transmitted = match self.bsdf {
            Bsdf::Glass(glass) if glass.facets.is_none() => 1.0_f32.next_down(),
            Bsdf::ThinGlass(_) => 0.0,
            _ => return None,
        };
        let (direction, sample) = self.sample([transmitted; 3])?;
        let ray = Ray::new(self.surface.leave(direction), direction);
        let weight = sample.weight * (sample.pdf * self.weight);
        (sample.lobe == Lobe::SpecularTransmission).then_some((ray, weight))
    }

    /// Draws a direction from three uniform numbers.
    fn sample(&self, u: [f32; 3]) -> Option<(Vec3, BsdfSample)> {
        // Glass distinguishes inside from outside by the sign of `wo.z`, so the frame keeps the
        // surface's own orientation.
        let (ng, ns) = self.surface.normals_seen_from(self.outgoing);
        let outside = if ng.dot(self.surface.geometric_normal) > 0.0 { ns } else { -ns };
        let frame = self.surface.frame(outside);
        let mut sample = self.bsdf.sample(frame.to_local(self.outgoing), u)?;
        let mut direction = frame.to_world(sample.wi).normalize();
        let above = ng.dot(direction) > 0.0;
        if above != (sample.lobe == Lobe::SpecularReflection) {
            // A shading normal that is turned far from the geometric normal may send light to the
            // wrong side of the surface. The geometric normal never does.
            let frame = self.surface.frame(self.surface.geometric_normal);
            sample = self.bsdf.sample(frame.to_local(self.outgoing), u)?;
            direction = frame.to_world(sample.wi).normalize();
        }
        Some((direction, sample))
    }

    /// Returns the [`squared_ratio`](crate::bsdf::Glass::squared_ratio) of a path that continues
    /// along `direction`: 1 unless the path crosses the boundary of solid glass.
    pub fn squared_ratio(&self, direction: Vec3) -> f64 {
        let is_outside = |direction: Vec3| self.surface.geometric_normal.dot(direction) > 0.0;
        match self.bsdf {
            Bsdf::Glass(glass) if is_outside(self.outgoing) != is_outside(direction) => {
                glass.squared_ratio(is_outside(direction))
            }
            _ => 1.0,
        }
    }

    /// Returns true if a ray that leaves along `direction` has passed thin glass, which does not
    /// bend it.
    pub fn passes_straight(&self, direction: Vec3) -> bool {
        matches!(self.bsdf, Bsdf::ThinGlass(_)) && self.crosses(direction)
    }

    /// Returns true if a smooth face of solid glass has refracted a ray that leaves along
    /// `direction`.
    pub fn refracts(&self, direction: Vec3) -> bool {
        let is_smooth = matches!(self.bsdf, Bsdf::Glass(glass) if glass.facets.is_none());
        is_smooth && self.crosses(direction)
    }

    /// Returns true if a ray that leaves along `direction` is behind the surface, as seen from
    /// `outgoing`.
    fn crosses(&self, direction: Vec3) -> bool {
        let ng = self.surface.geometric_normal;
        ng.dot(direction) * ng.dot(self.outgoing) < 0.0
    }
}
