//! One virtual point light.

use std::f32::consts::PI;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::math::{Frame, Ray};
use crate::scene::{AimedMap, Beam, Falloff};
use crate::warp;

/// Distribution of a light's intensity over directions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum VplKind {
    /// Uniform in all directions: intensity `I`.
    Omni,
    /// Cosine lobe around its normal: intensity `I cos⁺ φ`.
    Oriented,
    /// Cone around its axis: intensity `I · falloff(cos φ)`.
    Spot(Falloff),
    /// Intensity map of the scene around its axis: intensity `I · t(ω)`, with `t` at most 1.
    Image(Beam),
    /// Parallel light from infinity: irradiance `I` on a surface orthogonal to it.
    Directional,
    /// Phase function `p` of the surrounding medium, relative to the direction in which light
    /// arrived: intensity `I · 4π p(cos φ)`. The mean over all directions is `I`.
    Volume(HenyeyGreenstein),
}

impl VplKind {
    /// Number of kinds; spots and images count as one.
    pub const COUNT: usize = 5;

    /// Returns the index of the kind, from zero. Trees separate lights in this order. Spots and
    /// images are one kind: all emit within cones, with at most their nominal intensity.
    pub fn number(&self) -> usize {
        match self {
            Self::Omni => 0,
            Self::Oriented => 1,
            Self::Spot(_) | Self::Image(_) => 2,
            Self::Directional => 3,
            Self::Volume(_) => 4,
        }
    }
}

/// A virtual point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vpl {
    /// Position (m), already moved off the surface on which the light lies. Zero for directional
    /// lights.
    pub position: Vec3,
    /// Unit normal or axis. For directional lights, the direction in which light travels; in media,
    /// the direction in which it arrived. Zero for omni lights.
    pub direction: Vec3,
    /// Intensity `I` (W·sr⁻¹); irradiance (W·m⁻²) for directional lights.
    pub intensity: Rgb,
    /// Distribution of the intensity over directions.
    pub kind: VplKind,
}

impl Vpl {
    /// Returns true if the light is valid: finite numbers, intensities of at least 0, a unit
    /// direction (zero for omni lights), and an inner cone inside the outer cone.
    pub fn is_sound(&self) -> bool {
        let directed = match self.kind {
            VplKind::Omni => self.direction == Vec3::ZERO,
            VplKind::Oriented | VplKind::Directional => self.direction.is_normalized(),
            VplKind::Spot(f) => {
                self.direction.is_normalized()
                    && -1.0 <= f.cos_outer
                    && f.cos_outer < f.cos_inner
                    && f.cos_inner <= 1.0
            }
            VplKind::Image(beam) => self.direction.is_normalized() && (-1.0..=1.0).contains(&beam.cos_outer),
            VplKind::Volume(phase) => self.direction.is_normalized() && phase.is_valid(),
        };
        self.position.is_finite() && self.intensity.is_valid() && directed
    }

    /// Returns the apex of segments to this light, the end that they have in common.
    pub fn apex(&self) -> crate::accel::Apex {
        match self.kind {
            VplKind::Directional => crate::accel::Apex::Direction(-self.direction),
            _ => crate::accel::Apex::Point(self.position),
        }
    }

    /// Draws a ray of the light. Returns the ray and the flux that it represents (W): intensity
    /// divided by the density of the direction.
    ///
    /// Directional light enters through a disk that covers the sphere around the scene (`center`,
    /// `radius`, m); `maps` are the scene's.
    pub fn emit(&self, u: [f32; 2], center: Vec3, radius: f32, maps: &[AimedMap]) -> (Ray, Rgb) {
        let from_frame = |local: Vec3| Frame::about(self.direction).to_world(local);
        match self.kind {
            VplKind::Omni => (Ray::new(self.position, warp::sphere(u)), self.intensity * (4.0 * PI)),
            VplKind::Oriented => {
                (Ray::new(self.position, from_frame(warp::cosine_hemisphere(u))), self.intensity * PI)
            }
            VplKind::Spot(falloff) => {
                let local = warp::cone(u, falloff.cos_outer);
                let flux = self.intensity * (falloff.at(local.z) * 2.0 * PI * (1.0 - falloff.cos_outer));
                (Ray::new(self.position, from_frame(local)), flux)
            }
            VplKind::Image(beam) => {
                let map = &maps[beam.map as usize];
                let (direction, density) = map.sample(u);
                (Ray::new(self.position, direction), self.intensity * map.relative(direction) / density)
            }
            VplKind::Directional => {
                let d = warp::disk(u);
                let origin = center + from_frame(Vec3::new(d.x, d.y, -1.0)) * radius;
                (Ray::new(origin, self.direction), self.intensity * (PI * radius * radius))
            }
            VplKind::Volume(phase) => {
                (Ray::new(self.position, phase.sample(self.direction, u).0), self.intensity * (4.0 * PI))
            }
        }
    }

    /// Returns the numbers `u` for which [`Vpl::emit`] returns the ray of this light through a
    /// point.
    pub fn emission_through(&self, point: Vec3, center: Vec3, radius: f32, maps: &[AimedMap]) -> [f32; 2] {
        let local = |v: Vec3| Frame::about(self.direction).to_local(v);
        let towards = (point - self.position).normalize_or_zero();
        match self.kind {
            VplKind::Omni => warp::sphere_inverse(towards),
            VplKind::Oriented => warp::disk_inverse(local(towards).truncate()),
            VplKind::Spot(falloff) => warp::cone_inverse(local(towards), falloff.cos_outer),
            VplKind::Image(beam) => maps[beam.map as usize].inverse(towards),
            VplKind::Directional => warp::disk_inverse(local((point - center) / radius).truncate()),
            VplKind::Volume(phase) => phase.sample_inverse(self.direction, towards),
        }
    }
}
