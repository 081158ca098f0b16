//! Splits BSDFs into parts that can be bounded: a diffuse part that hardly depends on directions, a
//! lobe, and a coat.
//!
//! ```text
//! f_r ≤ diffuse + lobe + coat          (sr⁻¹, the largest channel of each)
//! ```
//!
//! | BSDF | diffuse | lobe |
//! |---|---|---|
//! | Lambert | `ρ/π` | none |
//! | Phong | `ρ_d/π` | [`phong`] |
//! | Plastic | `ρ_d/π` | [`facets`] |
//! | Conductor | 0 | [`facets`] |
//! | Coated | `ρ/π · T(c_o) T_max / (η² (1 − ρ F_int))` | [`facets`] |
//! | MetallicRoughness | `ρ_d (1 − F₀)/π` | [`facets`] |
//! | AshikhminShirley | its diffuse part, which grows with `c_i` | [`facets`] |
//! | Principled | `ρ_d/π · b` and the sheen, by [`burley`] | [`facets`] |
//! | Layered | attenuated base, and [`sheen`] | attenuated base, and a coat: [`clearcoat`] |
//!
//! # Guarantee
//! The sum of the bounds, once rounded by [`round_up`], is at least the value in the `f32`
//! arithmetic of [`bsdf`](crate::bsdf).
//!
//! # Held to this by
//! `bounds::tests::reflector`, `bounds::tests::analytic`.

mod beckmann;
mod burley;
pub(super) mod clearcoat;
pub(super) mod facets;
pub(super) mod fresnel;
mod ggx;
pub(super) mod phong;
mod sheen;

use std::f64::consts::{FRAC_1_PI, PI};

use crate::bsdf::{AshikhminShirley, Bsdf, ConductorFresnel, Microfacets};
use crate::color::Rgb;
use clearcoat::Coats;
use facets::FacetKind;
use fresnel::Reflected;

/// Parts of a BSDF seen from one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts {
    /// Upper bound of the diffuse part and the sheen (sr⁻¹).
    pub(super) diffuse: f64,
    /// Upper bound of the product of the cosine with the diffuse part and the sheen; at most
    /// `diffuse` times the largest cosine.
    pub(super) diffuse_cos: f64,
    /// The part that depends strongly on directions.
    pub(super) lobe: Lobe,
    /// Coat over the diffuse part and the lobe.
    pub(super) coat: Option<Coats>,
}

/// The part of a BSDF that depends strongly on directions.
#[derive(Clone, Copy, Debug)]
pub(super) enum Lobe {
    /// No lobe.
    None,
    /// `scale (n + 2) / 2π · cosⁿα`.
    Phong {
        /// Largest channel of `ρ_s`.
        scale: f64,
        /// `n`.
        exponent: f64,
    },
    /// `F D G₂ / (4 c_o c_i)`.
    Facets {
        /// Model of the facets' reflection.
        kind: FacetKind,
        /// Distribution and roughness of the facets.
        facets: Microfacets,
        /// Reflectance `F` of a facet.
        reflected: Reflected,
    },
}

impl Parts {
    /// Splits `bsdf`, seen at the cosine `cos_o > 0`, for light at cosines of at most `max_cos_i`.
    pub(super) fn of(bsdf: &Bsdf, cos_o: f32, max_cos_i: f64) -> Self {
        let mut flat_cos = None;
        let (diffuse, lobe) = match bsdf {
            Bsdf::Lambert(b) => (b.reflectance, Lobe::None),
            Bsdf::Phong(b) => {
                let (scale, exponent) = (f64::from(b.specular.max_channel()), f64::from(b.exponent));
                (b.diffuse, if scale > 0.0 { Lobe::Phong { scale, exponent } } else { Lobe::None })
            }
            Bsdf::Plastic(b) => {
                let reflected = Reflected::Dielectric { scale: b.specular.max_channel(), ior: b.ior };
                (b.diffuse, facets(b.facets, reflected))
            }
            Bsdf::Conductor(b) => {
                let scale = b.specular;
                let reflected = match b.fresnel {
                    ConductorFresnel::Schlick { f0 } => Reflected::Schlick { scale, f0 },
                    ConductorFresnel::Exact { eta, k } => Reflected::Conductor { scale, eta, k },
                    // The complement of `F` is largest at normal incidence.
                    ConductorFresnel::Passed { f0 } => {
                        Reflected::Schlick { scale: scale * (Rgb::WHITE - f0), f0: Rgb::WHITE }
                    }
                };
                (Rgb::BLACK, facets(b.facets, reflected))
            }
            Bsdf::Coated(b) => {
                let boundary = b.boundary();
                let passed = fresnel::upper_passed(max_cos_i, b.ior, &boundary) as f32;
                let base = b.base(&boundary) * boundary.transmittance(cos_o);
                let coat = Reflected::Dielectric { scale: b.specular.max_channel(), ior: b.ior };
                (base * passed, facets(b.facets, coat))
            }
            Bsdf::MetallicRoughness(b) => {
                let reflected = Reflected::Schlick { scale: Rgb::WHITE, f0: b.f0 };
                (b.diffuse * (Rgb::WHITE - b.dielectric_f0), facets(b.facets, reflected))
            }
            Bsdf::AshikhminShirley(b) => {
                let reflected = Reflected::Schlick { scale: Rgb::WHITE, f0: b.f0 };
                let lobe = Lobe::Facets { kind: FacetKind::AshikhminShirley, facets: b.facets, reflected };
                (
                    b.diffuse_albedo(cos_o)
                        * (AshikhminShirley::SCALE * AshikhminShirley::shape(max_cos_i as f32)),
                    lobe,
                )
            }
            Bsdf::Principled(b) => {
                let shape = burley::upper_shape(b.roughness, b.flatness, f64::from(cos_o), max_cos_i);
                let [shape, shape_cos] = shape.map(|bound| bound as f32);
                let sheen = (burley::upper_sheen(f64::from(cos_o)) * PI) as f32;
                if b.flatness > 0.0 {
                    flat_cos = Some(b.diffuse * shape_cos + b.sheen * (sheen * max_cos_i as f32));
                }
                (
                    b.diffuse * shape + b.sheen * sheen,
                    facets(b.facets, Reflected::Tinted { scale: 1.0, fresnel: b.fresnel }),
                )
            }
            Bsdf::Layered(b) => {
                let left = b.left(cos_o);
                let base = Self::of(&b.base.into(), cos_o, max_cos_i);
                let uncoated = f64::from(b.coat.left(cos_o));
                let [fibres, fibres_cos] =
                    sheen::upper(&b.sheen, cos_o, max_cos_i).map(|part| part * uncoated);
                return Self {
                    diffuse: base.diffuse * f64::from(left) + fibres,
                    diffuse_cos: base.diffuse_cos * f64::from(left) + fibres_cos,
                    lobe: base.lobe.scaled(left),
                    coat: Coats::of(&b.coat, cos_o),
                };
            }
            Bsdf::Mirror(_) | Bsdf::Glass(_) | Bsdf::ThinGlass(_) => (Rgb::BLACK, Lobe::None),
        };
        let brdf = |part: Rgb| f64::from(part.max_channel()) * FRAC_1_PI;
        let diffuse_cos = flat_cos.map_or(f64::INFINITY, brdf).min(brdf(diffuse) * max_cos_i);
        Self { diffuse: brdf(diffuse), diffuse_cos, lobe, coat: None }
    }

    /// Returns true if there is only a diffuse part.
    pub(super) fn is_diffuse(&self) -> bool {
        matches!(self.lobe, Lobe::None) && self.coat.is_none()
    }
}

impl Lobe {
    /// The lobe times `factor`.
    fn scaled(self, factor: f32) -> Self {
        match self {
            Self::None => Self::None,
            Self::Phong { scale, exponent } => Self::Phong { scale: scale * f64::from(factor), exponent },
            Self::Facets { kind, facets, reflected } => {
                let reflected = reflected.scaled(factor);
                if reflected.is_black() { Self::None } else { Self::Facets { kind, facets, reflected } }
            }
        }
    }
}

fn facets(facets: Microfacets, reflected: Reflected) -> Lobe {
    let kind = FacetKind::Model(facets.model);
    if reflected.is_black() { Lobe::None } else { Lobe::Facets { kind, facets, reflected } }
}

/// Rounds `bound` up to `f32`, with room for the rounding of the BSDFs; zero stays zero.
///
/// The room covers less than 40 roundings of `f32` (2.4·10⁻⁶) in factors whose error is not treated
/// in the documentation of the lobes, and lengths of directions that are off by 10⁻⁶. The addend is
/// above the smallest normal number; below that, roundings are no longer relative.
pub(super) fn round_up(bound: f64) -> f32 {
    if bound > 0.0 { ((bound * (1.0 + 1e-5) + 1e-37) as f32).next_up() } else { 0.0 }
}
