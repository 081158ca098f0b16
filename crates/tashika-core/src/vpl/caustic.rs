//! Caustics: light that reaches a surface from an emitter over specular surfaces only.

use super::guide::Emitted;
use super::walk::Trail;
use super::{LightGuide, Origin, Route, Vpl};
use crate::accel::Hit;
use crate::bsdf::{Bsdf, Lobe};
use crate::math::{Ray, Vec3};
use crate::scene::SurfacePoint;

/// Arrival of a light path at its first surface that is not specular, after at least one specular
/// surface.
#[derive(Clone, Copy, Debug)]
pub struct CausticPhoton {
    /// The VPL that the path creates there.
    pub light: Vpl,
    /// Unit direction towards the last specular surface.
    pub towards: Vec3,
    /// Length of the path since the emitter (m); infinite for light from infinity.
    pub distance: f32,
    /// Hash of the sequence of specular surfaces and their lobes.
    pub chain: u64,
    /// True for light from infinity that came through panes with parallel faces
    /// ([`through_panes`](crate::gather::through_panes)).
    pub is_through_panes: bool,
}

/// VPLs of all passes of light paths. Together they represent the emitted flux once.
#[derive(Debug)]
pub struct ArrivedLight {
    /// VPLs of all light paths, caustic or not.
    pub lights: Vec<Vpl>,
    /// Route of the light of each VPL.
    pub routes: Vec<Route>,
    /// Arrivals over specular surfaces only, each with its VPL.
    pub caustics: Vec<CausticPhoton>,
}

/// A [`CausticPhoton`] that refers to its VPL by an index in the trail of the light path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    /// Index of the VPL in the trail.
    light: u32,
    towards: Vec3,
    distance: f32,
    chain: u64,
    is_through_panes: bool,
    /// Numbers from which the emission of the path was drawn.
    numbers: [f32; 5],
}

impl Arrival {
    /// Returns the arrival with the index of its VPL.
    pub(super) fn leaving(self, light: u32) -> Self {
        Self { light, ..self }
    }

    /// Returns the arrival for a trail in which `before` other VPLs come first.
    pub(super) fn after(self, before: u32) -> Self {
        self.leaving(self.light + before)
    }

    /// Returns the photon, with its VPL from `lights`, the VPLs of the trail.
    pub(super) fn photon(&self, lights: &[Vpl]) -> CausticPhoton {
        let Self { light, towards, distance, chain, is_through_panes, .. } = *self;
        CausticPhoton { light: lights[light as usize], towards, distance, chain, is_through_panes }
    }
}

/// Returns the number of arrivals that did not come through panes. Draws from the emitters miss
/// these.
pub(super) fn to_guide(trail: &Trail) -> usize {
    trail.caustics.iter().filter(|arrival| !arrival.is_through_panes).count()
}

/// Learns a guide that directs emission to the caustics that draws from the emitters miss.
pub(super) fn guide(trail: &Trail) -> LightGuide {
    let of_arrival = |arrival: &Arrival| {
        let flux = trail.lights[arrival.light as usize].intensity.luminance();
        (arrival.numbers, if arrival.is_through_panes { 0.0 } else { flux })
    };
    LightGuide::learn_emission(trail.caustics.iter().map(of_arrival).collect())
}

/// Cosine between the directions before and after panes above which they count as equal.
const SAME: f32 = 1.0 - 1e-6;

/// Specular surfaces of a light path since it left the emitter.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpecularChain {
    first: Vec3,
    numbers: [f32; 5],
    distance: f32,
    chain: u64,
    is_from_infinity: bool,
    /// False while the path has passed only thin panes, which do not change its direction.
    is_deflected: bool,
    /// True if all interactions were passages through thin panes or refractions by smooth faces.
    is_refracted: bool,
}

impl SpecularChain {
    /// Returns the chain of a path that leaves an emitter.
    pub(super) fn from_emitter(emitted: &Emitted) -> Self {
        Self {
            first: emitted.ray.direction,
            numbers: emitted.numbers,
            distance: 0.0,
            chain: 0,
            is_from_infinity: emitted.origin == Origin::Infinity,
            is_deflected: false,
            is_refracted: true,
        }
    }

    /// Returns true if a specular surface changed the direction of the path.
    pub(super) fn is_deflected(&self) -> bool {
        self.is_deflected
    }

    /// Returns the chain extended by a specular surface that the ray met.
    pub(super) fn beyond(self, ray: &Ray, hit: &Hit, point: &SurfacePoint, bsdf: &Bsdf, lobe: Lobe) -> Self {
        let is_transmitted = lobe == Lobe::SpecularTransmission;
        let is_pane = matches!(bsdf, Bsdf::ThinGlass(_)) && is_transmitted;
        let is_smooth = matches!(bsdf, Bsdf::Glass(glass) if glass.facets.is_none());
        let of_surface = 2 * hit.instance.index() as u64 + u64::from(is_transmitted);
        Self {
            distance: self.distance + ray.origin.distance(point.position),
            // Multiplication by an odd number loses no bits; the rotation moves high bits to low
            // positions.
            chain: (self.chain ^ (of_surface + 1)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23),
            is_deflected: self.is_deflected || !is_pane,
            is_refracted: self.is_refracted && (is_pane || (is_smooth && is_transmitted)),
            ..self
        }
    }

    /// Returns the arrival at a surface that the ray meets; `None` if no specular surface changed
    /// the direction of the path.
    pub(super) fn arrival(&self, ray: &Ray, position: Vec3) -> Option<Arrival> {
        let length = self.distance + ray.origin.distance(position);
        self.is_deflected.then(|| Arrival {
            light: 0,
            towards: -ray.direction,
            distance: if self.is_from_infinity { f32::INFINITY } else { length },
            chain: self.chain,
            is_through_panes: self.is_from_infinity
                && self.is_refracted
                && self.first.dot(ray.direction) > SAME,
            numbers: self.numbers,
        })
    }
}
