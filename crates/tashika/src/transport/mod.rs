//! The one place that evaluates what a VPL contributes to a gather point.
//!
//! ```text
//! w · M · G · V · I        M = f_r(ω_o, ω_i) cos⁺ θ   (sr⁻¹)
//! ```
//!
//! | light | G | unit of G | unit of I |
//! |---|---|---|---|
//! | omni | `1 / max(d², d_c²)` | m⁻² | W·sr⁻¹ |
//! | oriented | `cos⁺ φ / max(d², d_c²)` | m⁻² | W·sr⁻¹ |
//! | spot | `falloff(cos φ) / max(d², d_c²)` | m⁻² | W·sr⁻¹ |
//! | directional | `1` | 1 | W·m⁻² |
//!
//! `d_c` is the clamp distance; zero is none. Visibility `V` comes from [`accel`](crate::accel). Nothing is reflected by the
//! back of either normal: M is zero unless the light is above both the geometric and the shading plane.

mod lists;
mod receivers;

pub use receivers::Receivers;

use glam::Vec3;

use crate::accel::Glass;
use crate::color::Rgb;
use crate::gather::GatherPoint;
use crate::vpl::{Vpl, VplKind};

/// How contributions are evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Transport {
    clamp_squared: f32,
    glass: Glass,
}

/// Points closer than 10⁻¹⁰ m are the same point, which receives nothing from itself: keeps the geometric term, and its products with
/// intensities, finite (m²).
const SMALLEST_SQUARED_DISTANCE: f32 = 1e-20;

/// The geometry between a point and a light.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Unit direction from the point to the light; zero if they are in the same place.
    pub towards_light: Vec3,
    /// `G`, clamped (m⁻² or 1).
    pub geometric: f32,
    /// Squared distance (m²); infinite for directional lights.
    pub squared_distance: f32,
}

impl Transport {
    /// With the geometric term held below `clamp_distance` (m); zero for no clamp.
    pub const fn new(clamp_distance: f32) -> Self {
        Self { clamp_squared: clamp_distance * clamp_distance, glass: Glass::Passes }
    }

    /// The same where solid glass does this to segments.
    #[must_use]
    pub const fn with_glass(self, glass: Glass) -> Self {
        Self { glass, ..self }
    }

    /// Distance below which the geometric term no longer grows (m).
    pub fn clamp_distance(&self) -> f32 {
        self.clamp_squared.sqrt()
    }

    /// What solid glass does to segments.
    pub const fn glass(&self) -> Glass {
        self.glass
    }

    /// The share of the true geometric term that the clamped one is at a squared distance (m²): `min(1, d²/d_c²)`, in `[0, 1]`.
    pub fn share(&self, squared_distance: f32) -> f32 {
        if squared_distance >= self.clamp_squared { 1.0 } else { squared_distance / self.clamp_squared }
    }

    /// The geometry between a point and a light.
    pub fn link(&self, position: Vec3, light: &Vpl) -> Link {
        if light.kind == VplKind::Directional {
            return Link { towards_light: -light.direction, geometric: 1.0, squared_distance: f32::INFINITY };
        }
        let d = light.position - position;
        let squared = d.length_squared();
        // Squares of shorter vectors lose digits to underflow: they have no direction.
        let towards_light = if squared > SMALLEST_SQUARED_DISTANCE { d / squared.sqrt() } else { Vec3::ZERO };
        let cos = -light.direction.dot(towards_light);
        let shape = match light.kind {
            VplKind::Omni => 1.0,
            VplKind::Oriented => cos.max(0.0),
            VplKind::Spot(falloff) => falloff.at(cos),
            VplKind::Directional => unreachable!("handled above"),
        };
        Link {
            towards_light,
            geometric: shape / squared.max(self.clamp_squared).max(SMALLEST_SQUARED_DISTANCE),
            squared_distance: squared,
        }
    }

    /// Whether a light is before both planes of a point and shines towards it: what is not contributes nothing.
    pub fn is_facing(&self, point: &GatherPoint, light: &Vpl) -> bool {
        let Link { towards_light, geometric, .. } = self.link(point.position, light);
        let is_before = |normal: Vec3| normal.dot(towards_light) > 0.0;
        geometric > 0.0 && is_before(point.geometric_normal) && is_before(point.frame.n)
    }

    /// `w M G I`: the contribution if nothing is in between (W·m⁻²·sr⁻¹).
    pub fn unoccluded(&self, point: &GatherPoint, light: &Vpl) -> Rgb {
        let link = self.link(point.position, light);
        if point.geometric_normal.dot(link.towards_light) <= 0.0 {
            return Rgb::BLACK;
        }
        let wi = point.frame.to_local(link.towards_light);
        point.weight * point.bsdf.eval_cos(point.wo, wi) * light.intensity * link.geometric
    }
}
