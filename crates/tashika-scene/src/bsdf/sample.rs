//! What is known of a direction drawn from a BSDF.

use crate::color::Rgb;
use crate::math::Vec3;

/// Which part of a BSDF a sampled direction comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// The diffuse part.
    Diffuse,
    /// A lobe of finite width.
    Glossy,
    /// The mirror direction alone.
    SpecularReflection,
    /// The refracted direction alone.
    SpecularTransmission,
}

impl Lobe {
    /// Whether the lobe is a single direction, with a probability instead of a density.
    pub fn is_specular(self) -> bool {
        match self {
            Self::Diffuse | Self::Glossy => false,
            Self::SpecularReflection | Self::SpecularTransmission => true,
        }
    }
}

/// A direction drawn by [`Bsdf::sample`](super::Bsdf::sample).
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// The direction, unit length, pointing away from the surface.
    pub wi: Vec3,
    /// `f_r cos θ_i / pdf` of the *whole* BSDF (unitless); for a specular lobe its coefficient
    /// divided by the probability of choosing it.
    pub weight: Rgb,
    /// Density of the whole BSDF at `wi` (sr⁻¹); for a specular lobe the probability of choosing
    /// it.
    pub pdf: f32,
    /// The part of the BSDF that the direction was drawn from.
    pub lobe: Lobe,
}
