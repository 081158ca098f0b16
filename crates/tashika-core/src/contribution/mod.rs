//! The single place that evaluates the contribution of a VPL to a gather point.
//!
//! ```text
//! w · M · G · V · I        M = f_r(ω_o, ω_i) cos⁺ θ   (sr⁻¹), at a point in a medium p(ω·ω_i)
//! ```
//!
//! | light | G | unit of G | unit of I |
//! |---|---|---|---|
//! | omni | `1 / max(d², d_c²)` | m⁻² | W·sr⁻¹ |
//! | oriented | `cos⁺ φ / max(d², d_c²)` | m⁻² | W·sr⁻¹ |
//! | spot | `falloff(cos φ) / max(d², d_c²)` | m⁻² | W·sr⁻¹ |
//! | image | `t(ω) / max(d², d_c²)` | m⁻² | W·sr⁻¹ |
//! | directional | `1` | 1 | W·m⁻² |
//! | in a medium | `4π p(cos φ) / max(d², d_c²)` | m⁻² | W·sr⁻¹ |
//!
//! `t ≤ 1` is the relative intensity, by channel, that a map of the scene has in the direction to
//! the point. `G` contains the largest channel of `t`, and the tint is `t` divided by that channel.
//! `d_c` is the clamp distance; zero means no clamp. Visibility `V` comes from
//! [`accel`](crate::accel), transmittance of media from [`media`](crate::media). Surfaces reflect
//! only on the front of both normals: M is zero unless the light is above both the geometric and
//! the shading plane. An end that lies in a medium has a phase function `p` instead of a cosine.
//! Its argument is the cosine of the angle by which the light is deflected, or by which the path
//! from the viewer, arriving along `ω`, is deflected.

mod lists;
mod receivers;

pub use receivers::Receivers;

use std::f32::consts::PI;

use glam::Vec3;

use crate::accel::Glass;
use crate::bsdf::HenyeyGreenstein;
use crate::color::Rgb;
use crate::gather::GatherPoint;
use crate::scene::{AimedMap, Scene};
use crate::vpl::{Vpl, VplKind};

/// Kernel that evaluates the contributions of VPLs to gather points.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContributionKernel<'s> {
    clamp_squared: f32,
    glass: Glass,
    /// Intensity maps of the scene, used by image lights.
    maps: &'s [AimedMap],
    least_extinction: f32,
}

/// Least squared distance (m²): points closer than 10⁻¹⁰ m are treated as the same point, which
/// does not light itself. This keeps the geometric term and its products with intensities finite.
const SMALLEST_SQUARED_DISTANCE: f32 = 1e-20;

/// Geometry of a pair of a point and a light.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Unit direction from the point to the light; zero if they are in the same place.
    pub towards_light: Vec3,
    /// `G`, clamped (m⁻² or 1).
    pub geometric: f32,
    /// Colour factor of the light in this direction, at most 1 in each channel; white except for
    /// image lights.
    pub tint: Rgb,
    /// Squared distance (m²); infinite for directional lights.
    pub squared_distance: f32,
}

impl<'s> ContributionKernel<'s> {
    /// Creates a kernel whose geometric term does not grow below `clamp_distance` (m); zero means
    /// no clamp. Until a [scene](Self::within) is set, the kernel does not support image lights.
    pub const fn new(clamp_distance: f32) -> Self {
        Self {
            clamp_squared: clamp_distance * clamp_distance,
            glass: Glass::Passes,
            maps: &[],
            least_extinction: 0.0,
        }
    }

    /// Returns the kernel for the lights of a scene, which may use its intensity maps.
    #[must_use]
    pub fn within(self, scene: &'s Scene) -> Self {
        Self { maps: scene.intensity_maps(), ..self }
    }

    /// Returns the kernel with another clamp distance (m).
    #[must_use]
    pub fn clamped(self, clamp_distance: f32) -> Self {
        Self { clamp_squared: clamp_distance * clamp_distance, ..self }
    }

    /// Returns the kernel with the given effect of solid glass on segments.
    #[must_use]
    pub const fn with_glass(self, glass: Glass) -> Self {
        Self { glass, ..self }
    }

    /// Returns the kernel for segments along which the extinction is everywhere at least
    /// `least_extinction` (m⁻¹). Only bounds use this value, as transmittances are evaluated
    /// elsewhere ([`media`](crate::media)).
    #[must_use]
    pub const fn dimmed(self, least_extinction: f32) -> Self {
        Self { least_extinction, ..self }
    }

    /// Lower bound of the extinction along all segments (m⁻¹).
    pub const fn least_extinction(&self) -> f32 {
        self.least_extinction
    }

    /// Distance below which the geometric term no longer grows (m).
    pub fn clamp_distance(&self) -> f32 {
        self.clamp_squared.sqrt()
    }

    /// Effect of solid glass on segments.
    pub const fn glass(&self) -> Glass {
        self.glass
    }

    /// Ratio of the clamped geometric term to the true one at a squared distance (m²):
    /// `min(1, d²/d_c²)`, in `[0, 1]`.
    pub fn share(&self, squared_distance: f32) -> f32 {
        if squared_distance >= self.clamp_squared { 1.0 } else { squared_distance / self.clamp_squared }
    }

    /// Evaluates the geometry between a point and a light.
    ///
    /// # Panics
    /// If the light uses a map and the kernel is not [within](Self::within) the scene that contains
    /// it.
    pub fn link(&self, position: Vec3, light: &Vpl) -> Link {
        if light.kind == VplKind::Directional {
            return Link {
                towards_light: -light.direction,
                geometric: 1.0,
                tint: Rgb::WHITE,
                squared_distance: f32::INFINITY,
            };
        }
        let d = light.position - position;
        let squared = d.length_squared();
        // Squares of shorter vectors lose digits to underflow, so these vectors have no direction.
        let towards_light = if squared > SMALLEST_SQUARED_DISTANCE { d / squared.sqrt() } else { Vec3::ZERO };
        let cos = -light.direction.dot(towards_light);
        let mut tint = Rgb::WHITE;
        let shape = match light.kind {
            VplKind::Omni => 1.0,
            VplKind::Oriented => cos.max(0.0),
            VplKind::Spot(falloff) => falloff.at(cos),
            VplKind::Image(beam) => {
                let relative = self.maps[beam.map as usize].relative(-towards_light);
                let largest = relative.max_channel();
                if largest > 0.0 {
                    tint = relative / largest;
                }
                largest
            }
            VplKind::Volume(phase) => 4.0 * PI * phase.density(cos),
            VplKind::Directional => unreachable!("handled above"),
        };
        Link {
            towards_light,
            geometric: shape / squared.max(self.clamp_squared).max(SMALLEST_SQUARED_DISTANCE),
            tint,
            squared_distance: squared,
        }
    }

    /// Returns true if a light shines towards a point and is in front of both planes of the point.
    /// Points in media have no planes. Other lights contribute nothing.
    pub fn is_facing(&self, point: &GatherPoint, light: &Vpl) -> bool {
        let Link { towards_light, geometric, .. } = self.link(point.position, light);
        if point.phase.is_some() {
            return geometric > 0.0 && towards_light != Vec3::ZERO;
        }
        let is_before = |normal: Vec3| normal.dot(towards_light) > 0.0;
        geometric > 0.0 && is_before(point.geometric_normal) && is_before(point.frame.n)
    }

    /// `w M G I`: the contribution without occlusion (W·m⁻²·sr⁻¹).
    pub fn unoccluded(&self, point: &GatherPoint, light: &Vpl) -> Rgb {
        let link = self.link(point.position, light);
        if let Some(phase) = point.phase {
            return point.weight * (light.intensity * link.tint) * scattered(phase, point, &link);
        }
        if point.geometric_normal.dot(link.towards_light) <= 0.0 {
            return Rgb::BLACK;
        }
        let wi = point.frame.to_local(link.towards_light);
        point.weight * point.bsdf.eval_cos(point.wo, wi) * (light.intensity * link.tint) * link.geometric
    }
}

/// `M G` at a point in a medium; zero for a light at the same position, which has no direction.
fn scattered(phase: HenyeyGreenstein, point: &GatherPoint, link: &Link) -> f32 {
    if link.towards_light == Vec3::ZERO {
        return 0.0;
    }
    phase.density(point.before().dot(link.towards_light)) * link.geometric
}
