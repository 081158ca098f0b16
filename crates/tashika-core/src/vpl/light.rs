//! One virtual point light.

use std::f32::consts::PI;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::math::{Frame, Ray};
use crate::scene::{AimedMap, Beam, Falloff};
use crate::warp;

/// How a light shines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum VplKind {
    /// Equally in all directions: intensity `I`.
    Omni,
    /// With a cosine lobe about its normal: intensity `I cos⁺ φ`.
    Oriented,
    /// With a cone about its axis: intensity `I · falloff(cos φ)`.
    Spot(Falloff),
    /// By a map of the scene about its axis: intensity `I · t(ω)`, with `t` at most 1.
    Image(Beam),
    /// From infinity: irradiance `I` on a surface that faces it.
    Directional,
    /// By the phase function `p` of the medium that it lies in, about the direction that light came
    /// along: intensity `I · 4π p(cos φ)`, whose mean over all directions is `I`.
    Volume(HenyeyGreenstein),
}

impl VplKind {
    /// How many kinds there are.
    pub const COUNT: usize = 5;

    /// The number of the kind, from zero: the order in which trees keep lights apart. Spots and
    /// images are of one kind: all shine in cones, at most as brightly as their intensity says.
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
    /// Position (m), already moved off the surface it lies on. Zero for directional lights.
    pub position: Vec3,
    /// Unit normal or axis, or the direction in which directional light travels, or in which light
    /// came to a place in a medium. Zero for omni lights.
    pub direction: Vec3,
    /// Intensity `I` (W·sr⁻¹); irradiance (W·m⁻²) for directional lights.
    pub intensity: Rgb,
    /// How it shines.
    pub kind: VplKind,
}

impl Vpl {
    /// Whether it is a light that can be: finite numbers, intensities of at least 0, a unit
    /// direction (zero for omni lights), an inner cone inside the outer.
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

    /// The end that all segments to this light share.
    pub fn apex(&self) -> crate::accel::Apex {
        match self.kind {
            VplKind::Directional => crate::accel::Apex::Direction(-self.direction),
            _ => crate::accel::Apex::Point(self.position),
        }
    }

    /// A ray of the light and the flux it carries (W): intensity over the density of the direction.
    ///
    /// Directional light enters through a disk that covers the sphere about the scene (`center`,
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

    /// The numbers that [`Vpl::emit`] takes to the ray of this light that goes through a point.
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
