//! Materials: scattering and emission of surfaces, with textures. The scattering at a point is a
//! [`Part`](super::Part).

use glam::Vec2;

use super::{ColorInput, FacetInput, FloatInput, MaterialId, TangentInput, TextureId, Textures, Values};
use crate::bsdf::{CoatModel, ConductorFresnel, FacetModel};
use crate::color::Rgb;

/// Meaning of the reflectance of a diffuse base under a coat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CoatBase {
    /// Reflectance of the base alone. Light reflected by the inside of the coat is reflected again
    /// by the base, which saturates colours.
    #[default]
    Saturating,
    /// Reflectance to which the albedo of base and coat is proportional: that albedo is `ρ T`, with
    /// `T` the share of light that the coat lets in.
    Proportional,
    /// Reflectance of the base alone. Light reflected by the inside of the coat is lost.
    Lossy,
}

/// Scattering of a surface: the closed family of [`Bsdf`](crate::bsdf::Bsdf) with textured
/// parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// Ideal diffuse reflection.
    Lambert {
        /// Diffuse reflectance by channel, 0 to 1.
        reflectance: ColorInput,
    },
    /// Modified Phong: diffuse plus `ρ_s (n+2)/2π cosⁿ θ` around the mirror direction.
    Phong {
        /// Reflectance of the diffuse part, 0 to 1.
        diffuse: ColorInput,
        /// Specular reflectance `ρ_s`, 0 to 1. If its sum with the diffuse one exceeds 1, both are
        /// scaled.
        specular: ColorInput,
        /// Exponent `n` of the cosine, 0 to 10⁶.
        exponent: f32,
    },
    /// Lambertian on both sides: leaves, paper, lamp shades.
    Translucent {
        /// Reflectance, 0 to 1. If its sum with the transmittance exceeds 1, both are scaled.
        reflectance: ColorInput,
        /// Diffuse transmittance by channel, 0 to 1.
        transmittance: ColorInput,
    },
    /// Sum of a diffuse part and a lobe of facets with the Fresnel reflectance of a dielectric.
    Plastic {
        /// Diffuse reflectance, 0 to 1. If its sum with the factor on the lobe exceeds 1, both are
        /// scaled.
        diffuse: ColorInput,
        /// Factor on the lobe, 0 to 1.
        specular: ColorInput,
        /// Refractive index.
        ior: f32,
        /// Facets of the lobe; smooth ones are a mirror.
        facets: FacetInput,
    },
    /// A metal, rough or smooth.
    Conductor {
        /// Fresnel reflectance of a facet.
        fresnel: ConductorFresnel,
        /// Factor on the Fresnel reflectance, 0 to 1; 1 is physical.
        specular: ColorInput,
        /// Facets of the metal; smooth ones are a mirror.
        facets: FacetInput,
    },
    /// Dielectric coat over a diffuse base.
    Coated {
        /// Reflectance of the base, 0 to 1.
        reflectance: ColorInput,
        /// Meaning of `reflectance`.
        base: CoatBase,
        /// Factor on the coat's reflection; 1 is physical.
        specular: ColorInput,
        /// Refractive index of the coat.
        ior: f32,
        /// Facets of the coat; smooth ones are a mirror.
        facets: FacetInput,
    },
    /// The metallic-roughness material of glTF 2.0.
    MetallicRoughness {
        /// Reflectance of the diffuse part and of metal at normal incidence.
        base_color: ColorInput,
        /// Share of metal, from 0 (dielectric) to 1 (metal).
        metallic: FloatInput,
        /// Perceptual roughness; `α` is its square.
        roughness: FloatInput,
        /// Reflectance at normal incidence of the dielectric part.
        specular_f0: ColorInput,
        /// Strength `s` of brushing, 0 to 1: along the tangent `α` is `α + (1 − α) s²`.
        anisotropy: FloatInput,
        /// Distribution of the facets.
        model: FacetModel,
    },
    /// Facets over a diffuse base that fades where the facets reflect (Ashikhmin, Shirley 2000).
    AshikhminShirley {
        /// Reflectance of the base, 0 to 1.
        diffuse: ColorInput,
        /// Reflectance of a facet at normal incidence, 0 to 1.
        specular_f0: ColorInput,
        /// Facets with the GGX distribution.
        facets: FacetInput,
    },
    /// Disney's principled material, opaque: Burley's diffuse part, sheen, and facets.
    Principled {
        /// Colour of the diffuse part and reflectance of metal at normal incidence.
        base_color: ColorInput,
        /// Share of metal, from 0 (dielectric) to 1 (metal).
        metallic: FloatInput,
        /// Perceptual roughness; `α` is its square.
        roughness: FloatInput,
        /// Refractive index of the dielectric part.
        ior: f32,
        /// Share of the dielectric part's reflection that has the hue of the base colour, 0 to 1.
        specular_tint: FloatInput,
        /// Amount of the sheen, light that cloth reflects at grazing angles, 0 to 1.
        sheen: FloatInput,
        /// Share of the sheen that has the hue of the base colour, 0 to 1.
        sheen_tint: FloatInput,
        /// Weight of the diffuse model that resembles light scattered below the surface, 0 to 1.
        flatness: FloatInput,
        /// Strength `s` of brushing, 0 to 1: with `a = √(1 − 0.9 s)`, `α` is divided by `a` along
        /// the tangent and multiplied by it across.
        anisotropic: FloatInput,
    },
    /// A clear coat over an opaque surface.
    Clearcoat {
        /// Material below: Lambertian, metallic-roughness, principled, any of these with sheen, or
        /// a mix of these.
        base: MaterialId,
        /// Amount of the coat, from 0 (none) to 1.
        amount: FloatInput,
        /// Roughness `α` of the coat.
        alpha: FloatInput,
        /// Definition of the coat.
        model: CoatModel,
    },
    /// The sheen of cloth on an opaque surface, as defined by glTF.
    Sheen {
        /// Material below: Lambertian, metallic-roughness, principled, or a mix of these.
        base: MaterialId,
        /// Colour, 0 to 1.
        color: ColorInput,
        /// Perceptual roughness; `α` is its square.
        roughness: FloatInput,
    },
    /// Ideal specular reflection.
    Mirror {
        /// Specular reflectance by channel, 0 to 1.
        reflectance: ColorInput,
    },
    /// Solid glass, smooth or rough.
    Glass {
        /// Refractive index, inside over outside.
        ior: f32,
        /// Factor on the reflection.
        reflectance: Rgb,
        /// Factor on the transmission.
        transmittance: Rgb,
        /// Facets of the boundary; it is smooth if their roughness is 0.
        facets: FacetInput,
    },
    /// A pane of glass: one surface represents both faces. A smooth pane transmits light straight.
    ThinGlass {
        /// Refractive index.
        ior: f32,
        /// Factor on the reflection, 0 to 1.
        reflectance: ColorInput,
        /// Factor on the transmission, 0 to 1.
        transmittance: ColorInput,
        /// Facets that represent both faces.
        facets: FacetInput,
    },
    /// Only the boundary of a medium: light crosses it in a straight line.
    Boundary,
    /// One of two materials at each point, at random.
    Mix {
        /// Material where the amount is 0.
        first: MaterialId,
        /// Material where the amount is 1.
        second: MaterialId,
        /// Probability of the second material, 0 to 1.
        amount: FloatInput,
    },
}

impl Surface {
    /// Name of the kind, for reports.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Lambert { .. } => "lambert",
            Self::Translucent { .. } => "translucent",
            Self::Phong { .. } => "phong",
            Self::Plastic { .. } => "plastic",
            Self::Conductor { .. } => "conductor",
            Self::Coated { .. } => "coated",
            Self::MetallicRoughness { .. } => "metallic-roughness",
            Self::AshikhminShirley { .. } => "ashikhmin-shirley",
            Self::Principled { .. } => "principled",
            Self::Sheen { .. } => "sheen",
            Self::Clearcoat { .. } => "clear coat",
            Self::Mirror { .. } => "mirror",
            Self::Glass { .. } => "glass",
            Self::ThinGlass { .. } => "thin glass",
            Self::Boundary => "boundary",
            Self::Mix { .. } => "mix",
        }
    }
}

/// Interpretation of opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Opaque where the value is at least the cutoff, invisible elsewhere.
    Mask {
        /// Smallest value that is opaque.
        cutoff: f32,
    },
    /// The value is the fraction of light that is blocked.
    Blend,
    /// Invisible to rays for any value; the emission is not reduced.
    Unseen,
}

/// Opacity of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alpha {
    /// Opacity, 0 to 1.
    pub value: FloatInput,
    /// Interpretation of the value.
    pub mode: AlphaMode,
}

impl Alpha {
    /// Fraction of light that is blocked at `uv`, 0 to 1.
    pub fn at(&self, textures: Textures<'_>, uv: Vec2) -> f32 {
        let value = self.value.at(textures, uv);
        match self.mode {
            AlphaMode::Mask { cutoff } => f32::from(value >= cutoff),
            AlphaMode::Blend => value.clamp(0.0, 1.0),
            AlphaMode::Unseen => 0.0,
        }
    }
}

/// Emission of a surface, with equal radiance in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Radiance of the emitting sides (W·m⁻²·sr⁻¹).
    pub radiance: ColorInput,
    /// True if both sides emit; otherwise only the side of the geometric normal.
    pub two_sided: bool,
}

/// A perturbation of the shading normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalInput {
    /// A normal in tangent space, `2 · texel − 1`: red along `u`, green along `v` **up**, blue
    /// along the normal.
    Map {
        /// Texture of the normal, not decoded by the sRGB curve.
        texture: TextureId,
        /// Factor on red and green.
        scale: f32,
    },
    /// A height above the surface (m).
    Bump {
        /// Height by texture coordinates (m).
        height: FloatInput,
    },
}

/// Scattering on the back of a surface, the side that its geometric normal points away from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Back {
    /// As on the front.
    #[default]
    Same,
    /// No scattering.
    Black,
    /// As on the front of another material.
    Material(MaterialId),
}

/// Scattering, emission and opacity of a mesh's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name that identifies it in messages.
    pub name: String,
    /// Scattering on its front.
    pub surface: Surface,
    /// Scattering on its back; the `back` of a mix's parts is ignored.
    pub back: Back,
    /// Light that it emits, if any.
    pub emission: Option<Emission>,
    /// Opacity, if not opaque everywhere.
    pub alpha: Option<Alpha>,
    /// Perturbation of the shading normal, if any.
    pub normal: Option<NormalInput>,
    /// Rotation of the tangent of brushed facets, if any. The rotation of a mix applies to both of
    /// its parts.
    pub tangent: Option<TangentInput>,
}

impl Material {
    /// Creates a material that only scatters.
    pub fn new(name: impl Into<String>, surface: Surface) -> Self {
        Self {
            name: name.into(),
            surface,
            back: Back::Same,
            emission: None,
            alpha: None,
            normal: None,
            tangent: None,
        }
    }

    /// Returns true if rays may pass through holes in the surface.
    pub fn has_holes(&self) -> bool {
        self.alpha.is_some()
    }

    /// Returns true if any input is textured.
    pub fn is_textured(&self) -> bool {
        self.textures().next().is_some()
    }

    /// Materials that it refers to.
    pub(super) fn others(&self) -> impl Iterator<Item = MaterialId> {
        let parts = match &self.surface {
            Surface::Mix { first, second, .. } => [Some(*first), Some(*second)],
            Surface::Sheen { base, .. } | Surface::Clearcoat { base, .. } => [Some(*base), None],
            _ => [None; 2],
        };
        let back = match self.back {
            Back::Material(back) => Some(back),
            Back::Same | Back::Black => None,
        };
        parts.into_iter().flatten().chain(back)
    }

    /// Textures of the material's own inputs, without those of the materials that it refers to.
    pub(super) fn textures(&self) -> impl Iterator<Item = TextureId> {
        self.inputs().map(|(texture, _)| texture)
    }

    /// Textures of the material's own inputs, with the meaning of their values.
    pub(super) fn inputs(&self) -> impl Iterator<Item = (TextureId, Values)> {
        let color = |c: &ColorInput| c.texture.map(|texture| (texture, Values::Colors));
        let number = |f: &FloatInput| f.texture.map(|(texture, _)| (texture, Values::Numbers));
        let across = |facets: &FacetInput| facets.across.as_ref().and_then(number);
        let mut all: Vec<Option<(TextureId, Values)>> = match &self.surface {
            Surface::Lambert { reflectance } | Surface::Mirror { reflectance } => vec![color(reflectance)],
            Surface::Translucent { reflectance, transmittance } => {
                vec![color(reflectance), color(transmittance)]
            }
            Surface::ThinGlass { reflectance, transmittance, facets, .. } => {
                vec![color(reflectance), color(transmittance), number(&facets.alpha), across(facets)]
            }
            Surface::Phong { diffuse, specular, .. } => vec![color(diffuse), color(specular)],
            Surface::Plastic { diffuse, specular, facets, .. }
            | Surface::AshikhminShirley { diffuse, specular_f0: specular, facets } => {
                vec![color(diffuse), color(specular), number(&facets.alpha), across(facets)]
            }
            Surface::Conductor { specular, facets, .. } => {
                vec![color(specular), number(&facets.alpha), across(facets)]
            }
            Surface::Coated { reflectance, specular, facets, .. } => {
                vec![color(reflectance), color(specular), number(&facets.alpha), across(facets)]
            }
            Surface::MetallicRoughness {
                base_color, metallic, roughness, specular_f0, anisotropy, ..
            } => {
                let numbers = [metallic, roughness, anisotropy];
                numbers.map(number).into_iter().chain([color(base_color), color(specular_f0)]).collect()
            }
            Surface::Principled {
                base_color,
                metallic,
                roughness,
                specular_tint,
                sheen,
                sheen_tint,
                flatness,
                anisotropic,
                ior: _,
            } => {
                let numbers = [metallic, roughness, specular_tint, sheen, sheen_tint, flatness, anisotropic];
                numbers.map(number).into_iter().chain([color(base_color)]).collect()
            }
            Surface::Glass { facets, .. } => vec![number(&facets.alpha), across(facets)],
            Surface::Sheen { color: sheen, roughness, .. } => vec![color(sheen), number(roughness)],
            Surface::Clearcoat { amount, alpha, .. } => vec![number(amount), number(alpha)],
            Surface::Mix { amount, .. } => vec![number(amount)],
            Surface::Boundary => Vec::new(),
        };
        all.push(self.emission.and_then(|e| color(&e.radiance)));
        all.push(self.alpha.and_then(|a| number(&a.value)));
        all.push(self.normal.and_then(|n| match n {
            NormalInput::Map { texture, .. } => Some((texture, Values::Numbers)),
            NormalInput::Bump { height } => number(&height),
        }));
        all.push(self.tangent.and_then(|t| t.direction).map(|texture| (texture, Values::Numbers)));
        all.into_iter().flatten()
    }
}
