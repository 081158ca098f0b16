//! Direction drawn from a BSDF, with its weight and density.

use crate::color::Rgb;
use crate::math::Vec3;

/// Part of a BSDF from which a sampled direction comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// The diffuse part of the BSDF.
    Diffuse,
    /// A lobe of finite width.
    Glossy,
    /// The mirror direction alone.
    SpecularReflection,
    /// The refracted direction alone.
    SpecularTransmission,
}

impl Lobe {
    /// Returns true if the lobe is a single direction, with a probability instead of a density.
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
    /// Unit direction that points away from the surface.
    pub wi: Vec3,
    /// Weight `f_r cos θ_i / pdf` of the *whole* BSDF (unitless); for a specular lobe its
    /// coefficient divided by the probability of choosing the lobe.
    pub weight: Rgb,
    /// Density of the whole BSDF at `wi` (sr⁻¹); for a specular lobe the probability of choosing
    /// the lobe.
    pub pdf: f32,
    /// Part of the BSDF from which the direction was drawn.
    pub lobe: Lobe,
}
