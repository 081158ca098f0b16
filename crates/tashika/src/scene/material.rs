//! Materials: what a surface is made of, with textures; [`Material::bsdf`] evaluates them at a point.

use glam::Vec2;

use super::{Channel, Image, Texture};
use crate::bsdf::{
    Bsdf, Coated, Conductor, ConductorFresnel, Glass, Lambert, MIN_ALPHA, MetallicRoughness, Mirror, Phong,
};
use crate::color::Rgb;

/// A colour, possibly textured: `factor · texture(uv)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorInput {
    /// Constant factor, linear.
    pub factor: Rgb,
    /// Texture, if any.
    pub texture: Option<Texture>,
}

/// A number, possibly textured: `factor · texture(uv)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloatInput {
    /// Constant factor.
    pub factor: f32,
    /// Texture and the channel that holds the number, if any.
    pub texture: Option<(Texture, Channel)>,
}

impl ColorInput {
    /// Colour at `uv`.
    pub fn at(&self, images: &[Image], uv: Vec2) -> Rgb {
        self.texture.map_or(self.factor, |t| self.factor * t.lookup(images, uv).0)
    }
}

impl From<Rgb> for ColorInput {
    fn from(factor: Rgb) -> Self {
        Self { factor, texture: None }
    }
}

impl FloatInput {
    /// Number at `uv`.
    pub fn at(&self, images: &[Image], uv: Vec2) -> f32 {
        self.texture.map_or(self.factor, |(t, channel)| self.factor * t.channel(images, uv, channel))
    }
}

impl From<f32> for FloatInput {
    fn from(factor: f32) -> Self {
        Self { factor, texture: None }
    }
}

/// How a surface scatters light: the closed family of [`Bsdf`] with textured parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// Ideal diffuse reflection.
    Lambert {
        /// Reflectance, 0 to 1.
        reflectance: ColorInput,
    },
    /// Modified Phong: diffuse plus `ρ_s (n+2)/2π cosⁿ θ` about the mirror direction.
    Phong {
        /// Diffuse reflectance, 0 to 1.
        diffuse: ColorInput,
        /// Specular reflectance `ρ_s`, 0 to 1. Where the sum with the diffuse one exceeds 1, both are scaled.
        specular: ColorInput,
        /// Exponent `n`, 0 to 10⁶.
        exponent: f32,
    },
    /// Rough metal (GGX).
    Conductor {
        /// Fresnel reflectance.
        fresnel: ConductorFresnel,
        /// GGX roughness `α`.
        alpha: FloatInput,
    },
    /// Rough dielectric coat (GGX) over a diffuse base.
    Coated {
        /// Reflectance of the base, 0 to 1.
        reflectance: ColorInput,
        /// Factor on the coat's reflection; 1 is physical.
        specular: ColorInput,
        /// Refractive index of the coat.
        ior: f32,
        /// GGX roughness `α`.
        alpha: FloatInput,
    },
    /// glTF 2.0 metallic-roughness.
    MetallicRoughness {
        /// Base colour.
        base_color: ColorInput,
        /// 0 dielectric to 1 metal.
        metallic: FloatInput,
        /// Perceptual roughness; `α` is its square.
        roughness: FloatInput,
        /// Reflectance at normal incidence of the dielectric part.
        dielectric_f0: Rgb,
    },
    /// Perfect mirror.
    Mirror {
        /// Reflectance, 0 to 1.
        reflectance: ColorInput,
    },
    /// Smooth glass.
    Glass {
        /// Refractive index, inside over outside.
        ior: f32,
        /// Factor on the reflection.
        reflectance: Rgb,
        /// Factor on the transmission.
        transmittance: Rgb,
    },
}

/// How opacity is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// There or not: opaque where the value is at least the cutoff.
    Mask {
        /// Smallest value that is opaque.
        cutoff: f32,
    },
    /// The fraction of light that is stopped.
    Blend,
}

/// Opacity of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alpha {
    /// Opacity, 0 to 1.
    pub value: FloatInput,
    /// How it is used.
    pub mode: AlphaMode,
}

impl Alpha {
    /// Fraction of light that is stopped at `uv`, 0 to 1.
    pub fn at(&self, images: &[Image], uv: Vec2) -> f32 {
        let value = self.value.at(images, uv);
        match self.mode {
            AlphaMode::Mask { cutoff } => f32::from(value >= cutoff),
            AlphaMode::Blend => value.clamp(0.0, 1.0),
        }
    }
}

/// Light that a surface emits, with a cosine lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Radiance (W·m⁻²·sr⁻¹).
    pub radiance: ColorInput,
    /// Whether both sides emit; otherwise only the side of the geometric normal.
    pub two_sided: bool,
}

/// What a mesh is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name for messages.
    pub name: String,
    /// How it scatters light.
    pub surface: Surface,
    /// Light that it emits, if any.
    pub emission: Option<Emission>,
    /// Opacity, if not opaque everywhere.
    pub alpha: Option<Alpha>,
}

impl Material {
    /// A material that only scatters.
    pub fn new(name: impl Into<String>, surface: Surface) -> Self {
        Self { name: name.into(), surface, emission: None, alpha: None }
    }

    /// The material's BSDF at texture coordinates `uv`; its parameters are in range whatever the
    /// textures hold.
    pub fn bsdf(&self, images: &[Image], uv: Vec2) -> Bsdf {
        let unit = |c: Rgb| c.map(|v| v.clamp(0.0, 1.0));
        let rough = |a: f32| a.clamp(MIN_ALPHA, 1.0);
        match &self.surface {
            Surface::Lambert { reflectance } => {
                Bsdf::Lambert(Lambert { reflectance: unit(reflectance.at(images, uv)) })
            }
            Surface::Phong { diffuse, specular, exponent } => {
                let (d, s) = (unit(diffuse.at(images, uv)), unit(specular.at(images, uv)));
                // The next number below keeps rounded sums from exceeding one.
                let scale =
                    if (d + s).max_channel() > 1.0 { (1.0 / (d + s).max_channel()).next_down() } else { 1.0 };
                Bsdf::Phong(Phong { diffuse: d * scale, specular: s * scale, exponent: *exponent })
            }
            Surface::Conductor { fresnel, alpha } => {
                Bsdf::Conductor(Conductor { fresnel: *fresnel, alpha: rough(alpha.at(images, uv)) })
            }
            Surface::Coated { reflectance, specular, ior, alpha } => Bsdf::Coated(Coated {
                reflectance: unit(reflectance.at(images, uv)),
                specular: unit(specular.at(images, uv)),
                ior: *ior,
                alpha: rough(alpha.at(images, uv)),
            }),
            Surface::MetallicRoughness { base_color, metallic, roughness, dielectric_f0 } => {
                let base = unit(base_color.at(images, uv));
                let metallic = metallic.at(images, uv).clamp(0.0, 1.0);
                let roughness = roughness.at(images, uv).clamp(0.0, 1.0);
                Bsdf::MetallicRoughness(MetallicRoughness {
                    diffuse: base * (1.0 - metallic),
                    f0: unit(*dielectric_f0).lerp(base, metallic),
                    alpha: rough(roughness * roughness),
                })
            }
            Surface::Mirror { reflectance } => {
                Bsdf::Mirror(Mirror { reflectance: unit(reflectance.at(images, uv)) })
            }
            Surface::Glass { ior, reflectance, transmittance } => Bsdf::Glass(Glass {
                ior: *ior,
                reflectance: unit(*reflectance),
                transmittance: unit(*transmittance),
            }),
        }
    }

    /// Whether light may pass through: such surfaces are looked at one by one by the tracer.
    pub fn may_be_transparent(&self) -> bool {
        self.alpha.is_some()
    }

    /// Every texture the material looks up.
    pub(super) fn textures(&self) -> impl Iterator<Item = Texture> {
        let mut all: Vec<Option<Texture>> = Vec::new();
        match &self.surface {
            Surface::Lambert { reflectance } | Surface::Mirror { reflectance } => {
                all.push(reflectance.texture)
            }
            Surface::Phong { diffuse, specular, .. } => all.extend([diffuse.texture, specular.texture]),
            Surface::Conductor { alpha, .. } => all.push(alpha.texture.map(|t| t.0)),
            Surface::Coated { reflectance, specular, alpha, .. } => {
                all.extend([reflectance.texture, specular.texture, alpha.texture.map(|t| t.0)]);
            }
            Surface::MetallicRoughness { base_color, metallic, roughness, .. } => {
                all.extend([
                    base_color.texture,
                    metallic.texture.map(|t| t.0),
                    roughness.texture.map(|t| t.0),
                ]);
            }
            Surface::Glass { .. } => {}
        }
        all.push(self.emission.and_then(|e| e.radiance.texture));
        all.push(self.alpha.and_then(|a| a.value.texture.map(|t| t.0)));
        all.into_iter().flatten()
    }
}
