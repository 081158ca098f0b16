//! Parts of a surface at a point: a path follows one of them, chosen at random.
//!
//! The scattering of some surfaces is not a single BSDF of [`bsdf`](crate::bsdf): a smooth coat
//! reflects like a mirror *and* diffusely, a leaf scatters to both sides, and a mix is one of two
//! materials. Such a surface is divided into parts, and each path or gather point follows one of
//! them:
//!
//! ```text
//! f = Σ_k f_k     is estimated by     f_k / p_k     with probability p_k
//! ```
//!
//! Code outside of this file therefore handles a plain [`Bsdf`] that is either specular or not.
//!
//! | surface | parts | `p_k` in proportion to |
//! |---|---|---|
//! | [`Surface::Coated`], `α = 0` | mirror `s F(c_o)`; the base under it | `s F(c_o)`; its albedo |
//! | [`Surface::Plastic`], `α = 0` | mirror `s F(c_o)`; Lambert | `s F(c_o)`; reflectance |
//! | [`Surface::Conductor`], `α = 0` | mirror `s F(c_o)` | 1 |
//! | [`Surface::Translucent`] | diffuse reflection; transmission | reflectance; transmittance |
//! | [`Surface::ThinGlass`], `α > 0` | reflecting facets; transmitting facets | their albedos |
//! | [`Surface::Mix`] | the two materials | `1 − amount`; `amount` |
//! | [`Surface::Sheen`], [`Surface::Clearcoat`] | parts of the base, layered | as for the base |
//! | others | the surface itself | 1 |
//!
//! # Guarantee
//! The expectation of the chosen part's BSDF times its weight is the BSDF of the surface.
//! Parameters are in range for any values of the textures. If both of two parts reflect light, each
//! `p_k` is at least 0.1, so that no weight exceeds 10. The weights of mixes are 1.
//!
//! # Held to this by
//! The tests below.

use glam::Vec2;

use super::facets::{anisotropic_alphas, of_aspect};
use super::{CoatBase, ColorInput, FacetInput, Material, MaterialId, Surface, Textures};
use crate::bsdf::{
    AshikhminShirley, Bsdf, Clearcoat, CoatModel, Coated, Conductor, ConductorFresnel, FacetModel, Glass,
    Lambert, Layered, MAX_GTR1_ALPHA, MAX_SHEEN, MIN_ALPHA, MIN_SHEEN_ROUGHNESS, MetallicRoughness,
    Microfacets, Mirror, Phong, Plastic, Principled, Sheen, ThinGlass, TintedFresnel, fresnel,
    glossy_probability,
};
use crate::color::Rgb;

/// One part of a surface, chosen at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Scattering of the part.
    pub bsdf: Bsdf,
    /// Reciprocal of the probability of the choice.
    pub weight: f32,
    /// True if the part scatters between the side of the viewer and the other side: light arrives,
    /// or leaves, behind the surface. To evaluate [`Part::bsdf`], the direction of that light is
    /// mirrored to the side of the viewer.
    pub through: bool,
}

impl Part {
    /// A part that reflects nothing.
    pub const BLACK: Self =
        Self { bsdf: Bsdf::Lambert(Lambert { reflectance: Rgb::BLACK }), weight: 1.0, through: false };
}

/// Point of a surface and its direction of view.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceView<'a> {
    /// The scene's materials; a mix refers only to materials that were added before it.
    pub materials: &'a [Material],
    /// Textures, with the scene's images.
    pub textures: Textures<'a>,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Absolute cosine between the shading normal and the direction of view, 0 to 1.
    pub cos: f32,
}

fn unit(c: Rgb) -> Rgb {
    c.map(|v| v.clamp(0.0, 1.0))
}

/// Returns two fractions, scaled down if they sum to more than 1.
fn limited(a: Rgb, b: Rgb) -> (Rgb, Rgb) {
    let sum = (a + b).max_channel();
    // The scale is rounded down, so that rounded sums do not exceed one.
    let scale = if sum > 1.0 { (1.0 / sum).next_down() } else { 1.0 };
    (a * scale, b * scale)
}

/// Returns a colour scaled to a luminance of 1; white for black.
fn hue(color: Rgb) -> Rgb {
    let luminance = color.luminance();
    if luminance > 0.0 { color / luminance } else { Rgb::WHITE }
}

impl<'a> SurfaceView<'a> {
    fn color(&self, input: &ColorInput) -> Rgb {
        unit(input.at(self.textures, self.uv))
    }

    /// Returns the facets; `None` where the surface is smooth.
    fn facets(&self, input: &FacetInput) -> Option<Microfacets> {
        input.at(self.textures, self.uv)
    }

    /// Returns the part of `material` that the uniform number `u` in `[0, 1)` selects.
    pub fn part(&self, mut material: &'a Material, mut u: f32) -> Part {
        // The loop ends, since a mix refers only to materials that were added before it.
        while let Surface::Mix { first, second, amount } = &material.surface {
            let amount = amount.at(self.textures, self.uv).clamp(0.0, 1.0);
            (material, u) = if u < amount {
                (&self.materials[second.index()], u / amount)
            } else {
                (&self.materials[first.index()], (u - amount) / (1.0 - amount))
            };
            u = u.clamp(0.0, BELOW_ONE);
        }
        let whole = |bsdf| Part { bsdf, weight: 1.0, through: false };
        match &material.surface {
            Surface::Lambert { reflectance } => {
                whole(Bsdf::Lambert(Lambert { reflectance: self.color(reflectance) }))
            }
            Surface::Translucent { reflectance, transmittance } => {
                let (r, t) = limited(self.color(reflectance), self.color(transmittance));
                let lambert = |reflectance| Bsdf::Lambert(Lambert { reflectance });
                let p = glossy_probability(t.max_channel(), r.max_channel()).unwrap_or(0.0);
                if u < p {
                    Part { bsdf: lambert(t), weight: 1.0 / p, through: true }
                } else {
                    Part { bsdf: lambert(r), weight: 1.0 / (1.0 - p), through: false }
                }
            }
            Surface::Phong { diffuse, specular, exponent } => {
                let (diffuse, specular) = limited(self.color(diffuse), self.color(specular));
                whole(Bsdf::Phong(Phong { diffuse, specular, exponent: *exponent }))
            }
            Surface::Plastic { diffuse, specular, ior, facets } => {
                let (diffuse, specular) = limited(self.color(diffuse), self.color(specular));
                match self.facets(facets) {
                    Some(facets) => whole(Bsdf::Plastic(Plastic { diffuse, specular, ior: *ior, facets })),
                    None => {
                        let mirror = specular * fresnel::dielectric(self.cos, *ior);
                        let base = Bsdf::Lambert(Lambert { reflectance: diffuse });
                        mirror_or(mirror, base, diffuse, u)
                    }
                }
            }
            Surface::Conductor { fresnel, specular, facets } => {
                let specular = self.color(specular);
                whole(match self.facets(facets) {
                    Some(facets) => Bsdf::Conductor(Conductor { fresnel: *fresnel, specular, facets }),
                    None => Bsdf::Mirror(Mirror { reflectance: unit(fresnel.at(self.cos) * specular) }),
                })
            }
            Surface::Coated { reflectance, base, specular, ior, facets } => {
                let reflectance = self.color(reflectance);
                let rough = self.facets(facets);
                let facets = rough.unwrap_or(Microfacets::ggx(MIN_ALPHA));
                let reflectance = match base {
                    CoatBase::Saturating => reflectance,
                    CoatBase::Proportional => unit(Coated::saturating(reflectance, *ior, facets)),
                    CoatBase::Lossy => unit(Coated::lossy(reflectance, *ior, facets)),
                };
                let specular = self.color(specular);
                let coated = Coated { reflectance, specular, ior: *ior, facets };
                match rough {
                    Some(_) => whole(Bsdf::Coated(coated)),
                    None => {
                        let mirror = specular * fresnel::dielectric(self.cos, *ior);
                        let base = Coated { specular: Rgb::BLACK, ..coated };
                        mirror_or(mirror, Bsdf::Coated(base), base.diffuse_albedo(self.cos), u)
                    }
                }
            }
            Surface::MetallicRoughness {
                base_color,
                metallic,
                roughness,
                specular_f0,
                anisotropy,
                model,
            } => {
                let base = self.color(base_color);
                let metallic = metallic.at(self.textures, self.uv).clamp(0.0, 1.0);
                let roughness = roughness.at(self.textures, self.uv).clamp(0.0, 1.0);
                let dielectric_f0 = self.color(specular_f0);
                let strength = anisotropy.at(self.textures, self.uv).clamp(0.0, 1.0);
                let alpha = anisotropic_alphas(roughness * roughness, strength);
                whole(Bsdf::MetallicRoughness(MetallicRoughness {
                    diffuse: base * (1.0 - metallic),
                    f0: dielectric_f0.lerp(base, metallic),
                    dielectric_f0,
                    facets: Microfacets { alpha, model: *model },
                }))
            }
            Surface::AshikhminShirley { diffuse, specular_f0, facets } => {
                whole(Bsdf::AshikhminShirley(AshikhminShirley {
                    diffuse: self.color(diffuse),
                    f0: self.color(specular_f0),
                    facets: self.facets(facets).unwrap_or(Microfacets::ggx(MIN_ALPHA)),
                }))
            }
            Surface::Principled {
                base_color,
                metallic,
                roughness,
                ior,
                specular_tint,
                sheen,
                sheen_tint,
                flatness,
                anisotropic,
            } => {
                let base = self.color(base_color);
                let inputs = [metallic, roughness, specular_tint, sheen, sheen_tint, flatness, anisotropic];
                let inputs = inputs.map(|input| input.at(self.textures, self.uv).clamp(0.0, 1.0));
                let [metallic, roughness, specular_tint, sheen, sheen_tint, flatness, anisotropic] = inputs;
                let hue = hue(base);
                let opaque = 1.0 - metallic;
                // Share `schlick` of Schlick's approximation: the metal, and the tinted part of the
                // dielectric.
                let tinted = opaque * specular_tint;
                let schlick = metallic + tinted;
                let f0 = base * metallic + hue * (fresnel::dielectric(1.0, *ior) * tinted);
                let alpha = of_aspect(roughness, anisotropic);
                whole(Bsdf::Principled(Principled {
                    diffuse: base * opaque,
                    roughness,
                    flatness,
                    sheen: (Rgb::WHITE.lerp(hue, sheen_tint) * (opaque * sheen)).map(|s| s.min(MAX_SHEEN)),
                    fresnel: TintedFresnel {
                        schlick,
                        f0: if schlick > 0.0 { unit(f0 / schlick) } else { Rgb::BLACK },
                        ior: *ior,
                    },
                    facets: Microfacets { alpha, model: FacetModel::GgxIndependent },
                }))
            }
            Surface::Sheen { base, color, roughness } => self.under_layer(base, u, |layered| {
                let roughness = roughness.at(self.textures, self.uv).clamp(MIN_SHEEN_ROUGHNESS, 1.0);
                layered.sheen = Sheen { color: self.color(color), roughness };
            }),
            Surface::Clearcoat { base, amount, alpha, model } => self.under_layer(base, u, |layered| {
                let widest = if *model == CoatModel::Layer { 1.0 } else { MAX_GTR1_ALPHA };
                let amount = amount.at(self.textures, self.uv).clamp(0.0, 1.0);
                let alpha = alpha.at(self.textures, self.uv).clamp(MIN_ALPHA, widest);
                layered.coat = Clearcoat { amount, alpha, model: *model };
            }),
            Surface::Mirror { reflectance } => {
                whole(Bsdf::Mirror(Mirror { reflectance: self.color(reflectance) }))
            }
            Surface::Glass { ior, reflectance, transmittance, facets } => whole(Bsdf::Glass(Glass {
                ior: *ior,
                reflectance: unit(*reflectance),
                transmittance: unit(*transmittance),
                facets: self.facets(facets),
            })),
            Surface::ThinGlass { ior, reflectance, transmittance, facets } => {
                let (reflectance, transmittance) = (self.color(reflectance), self.color(transmittance));
                match self.facets(facets) {
                    Some(facets) => self.rough_pane(*ior, reflectance, transmittance, facets, u),
                    None => whole(Bsdf::ThinGlass(ThinGlass { ior: *ior, reflectance, transmittance })),
                }
            }
            Surface::Boundary => whole(Bsdf::ThinGlass(ThinGlass::NOTHING)),
            Surface::Mix { .. } => unreachable!("resolved above"),
        }
    }

    /// Returns the part of `base` that `u` selects, under an additional layer.
    fn under_layer(&self, base: &MaterialId, u: f32, add: impl FnOnce(&mut Layered)) -> Part {
        let part = self.part(&self.materials[base.index()], u);
        // The builder accepts no other base.
        let Some(mut layered) = Layered::over(&part.bsdf) else { return part };
        add(&mut layered);
        Part { bsdf: Bsdf::Layered(layered), ..part }
    }

    /// Returns the part of a rough pane that `u` selects. Its facets represent both faces: they
    /// reflect by Schlick's approximation, with the reflectance of both faces at normal incidence,
    /// and transmit the rest (`KHR_materials_transmission`, Khronos).
    fn rough_pane(
        &self,
        ior: f32,
        reflectance: Rgb,
        transmittance: Rgb,
        facets: Microfacets,
        u: f32,
    ) -> Part {
        let both = |cos: f32| 1.0 - ThinGlass::passed(cos, ior);
        let (f0, reflected) = (Rgb::gray(both(1.0)), both(self.cos));
        let of = |fresnel, specular| Bsdf::Conductor(Conductor { fresnel, specular, facets });
        let [through, back] = [(1.0 - reflected) * transmittance, reflected * reflectance];
        let p = glossy_probability(through.max_channel(), back.max_channel()).unwrap_or(0.0);
        if u < p {
            let bsdf = of(ConductorFresnel::Passed { f0 }, transmittance);
            Part { bsdf, weight: 1.0 / p, through: true }
        } else {
            let bsdf = of(ConductorFresnel::Schlick { f0 }, reflectance);
            Part { bsdf, weight: 1.0 / (1.0 - p), through: false }
        }
    }

    /// Transmittance of a surface along a straight segment, 0 to 1 (luminance). Holes are not
    /// considered.
    ///
    /// * `solid`: true if solid glass transmits straight the light that it would refract.
    pub fn straight_through(&self, material: &Material, solid: bool) -> f32 {
        match &material.surface {
            Surface::Glass { .. } if !solid => 0.0,
            // Rough glass counts as opaque, since it transmits hardly any light straight.
            Surface::Glass { facets, .. } if self.facets(facets).is_some() => 0.0,
            Surface::Glass { ior, transmittance, .. } => {
                (1.0 - fresnel::dielectric(self.cos, *ior)) * unit(*transmittance).luminance()
            }
            Surface::Boundary => 1.0,
            Surface::ThinGlass { facets, .. } if self.facets(facets).is_some() => 0.0,
            Surface::ThinGlass { ior, transmittance, .. } => {
                ThinGlass::passed(self.cos, *ior) * self.color(transmittance).luminance()
            }
            Surface::Lambert { .. }
            | Surface::Translucent { .. }
            | Surface::Phong { .. }
            | Surface::Plastic { .. }
            | Surface::Conductor { .. }
            | Surface::Coated { .. }
            | Surface::MetallicRoughness { .. }
            | Surface::AshikhminShirley { .. }
            | Surface::Principled { .. }
            | Surface::Sheen { .. }
            | Surface::Clearcoat { .. }
            | Surface::Mirror { .. } => 0.0,
            Surface::Mix { first, second, amount } => {
                let amount = amount.at(self.textures, self.uv).clamp(0.0, 1.0);
                let part = |m: &MaterialId| self.straight_through(&self.materials[m.index()], solid);
                (1.0 - amount) * part(first) + amount * part(second)
            }
        }
    }
}

/// The largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Selects a mirror, or the base of albedo `albedo` below it.
fn mirror_or(mirror: Rgb, base: Bsdf, albedo: Rgb, u: f32) -> Part {
    let p = glossy_probability(mirror.max_channel(), albedo.max_channel()).unwrap_or(0.0);
    if u < p {
        Part { bsdf: Bsdf::Mirror(Mirror { reflectance: mirror }), weight: 1.0 / p, through: false }
    } else {
        Part { bsdf: base, weight: 1.0 / (1.0 - p), through: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::ConductorFresnel;

    const ORANGE: Rgb = Rgb::new(0.8, 0.5, 0.2);

    fn part(materials: &[Material], cos: f32, u: f32) -> Part {
        let textures = Textures { images: &[], nodes: &[], tile_sets: &[] };
        let look = SurfaceView { materials, textures, uv: Vec2::ZERO, cos };
        look.part(materials.last().unwrap(), u)
    }

    /// Share of the numbers in `[0, 1)` that select a part, times the weight of the part, for both
    /// parts. Both products are 1 if weights are the reciprocals of probabilities.
    fn weighted_shares(surface: Surface, of: impl Fn(&Part) -> usize) -> [f64; 2] {
        let materials = [Material::new("m", surface)];
        let mut sums = [0.0; 2];
        let n = 10_000;
        for i in 0..n {
            let p = part(&materials, 0.7, (i as f32 + 0.5) / n as f32);
            sums[of(&p)] += f64::from(p.weight) / f64::from(n);
        }
        sums
    }

    /// Returns true if both weighted shares are 1, to within two numbers of the grid at the largest
    /// weight.
    fn both_whole(shares: [f64; 2]) -> bool {
        shares.iter().all(|s| (s - 1.0).abs() < 2.0 * 10.0 / 10_000.0)
    }

    #[test]
    fn smooth_coats_are_a_mirror_and_a_base() {
        let is_mirror = |p: &Part| usize::from(p.bsdf.is_specular());
        let (ior, facets, specular) = (1.5, 0.0.into(), Rgb::WHITE.into());
        let base = CoatBase::Saturating;
        let coated = Surface::Coated { reflectance: ORANGE.into(), base, specular, ior, facets };
        assert!(both_whole(weighted_shares(coated, is_mirror)));
        let plastic =
            Surface::Plastic { diffuse: ORANGE.into(), specular: Rgb::gray(0.2).into(), ior, facets };
        assert!(both_whole(weighted_shares(plastic, is_mirror)));
        let Bsdf::Mirror(mirror) = part(&[Material::new("m", plastic)], 0.7, 0.0).bsdf else { panic!() };
        let expected = Rgb::gray(0.2) * fresnel::dielectric(0.7, ior);
        assert!((mirror.reflectance.r / expected.r - 1.0).abs() < 1e-6);
        // For directions away from the mirror lobe, the base under a smooth coat has the values of
        // a coat of the smallest roughness.
        let base = part(&[Material::new("m", coated_with(0.0))], 0.7, 0.99).bsdf;
        let rough = part(&[Material::new("m", coated_with(MIN_ALPHA))], 0.7, 0.99).bsdf;
        let (wo, wi) = (glam::Vec3::new(0.6, 0.0, 0.8), glam::Vec3::new(0.8, 0.0, 0.6));
        let (a, b) = (base.eval(wo, wi), rough.eval(wo, wi));
        assert!((a.g / b.g - 1.0).abs() < 1e-3 && a.g > 0.05, "{a:?} {b:?}");
    }

    fn coated_with(alpha: f32) -> Surface {
        let specular = Rgb::WHITE.into();
        let base = CoatBase::Saturating;
        Surface::Coated { reflectance: ORANGE.into(), base, specular, ior: 1.5, facets: alpha.into() }
    }

    /// A smooth coat over a proportional base: the albedo of the diffuse part is the reflectance
    /// times the transmittance of the coat. A saturating base is darker.
    #[test]
    fn a_proportional_base_is_as_bright_as_its_reflectance_says() {
        let albedo = |base| {
            let (specular, facets) = (Rgb::BLACK.into(), 0.0.into());
            let surface = Surface::Coated { reflectance: ORANGE.into(), base, specular, ior: 1.5, facets };
            part(&[Material::new("m", surface)], 1.0, 0.5).bsdf.vpl_reflectance(glam::Vec3::Z)
        };
        let entering = 1.0 - fresnel::dielectric(1.0, 1.5);
        for channel in 0..3 {
            let expected = ORANGE[channel] * entering;
            assert!((albedo(CoatBase::Proportional)[channel] - expected).abs() < 1e-5, "{channel}");
            assert!(albedo(CoatBase::Saturating)[channel] < 0.9 * expected);
        }
    }

    #[test]
    fn leaves_scatter_to_both_sides_and_never_more_than_arrives() {
        let leaf = Surface::Translucent { reflectance: ORANGE.into(), transmittance: Rgb::gray(0.6).into() };
        assert!(both_whole(weighted_shares(leaf, |p| usize::from(p.through))));
        let materials = [Material::new("leaf", leaf)];
        let (near, far) = (part(&materials, 1.0, 0.99), part(&materials, 1.0, 0.0));
        assert!(far.through && !near.through);
        let sum = near.bsdf.albedo() + far.bsdf.albedo();
        assert!(sum.max_channel() <= 1.0 && sum.r > 0.999);
    }

    /// The albedos of the reflecting and of the transmitting part of a rough pane, without masking,
    /// are those of a smooth pane.
    #[test]
    fn rough_panes_share_light_as_smooth_ones() {
        let pane = |alpha: f32| Surface::ThinGlass {
            ior: 1.5,
            reflectance: Rgb::WHITE.into(),
            transmittance: ORANGE.into(),
            facets: alpha.into(),
        };
        assert!(both_whole(weighted_shares(pane(0.05), |p| usize::from(p.through))));
        let materials = [Material::new("pane", pane(0.05))];
        let (back, through) = (part(&materials, 1.0, 0.99), part(&materials, 1.0, 0.0));
        assert!(through.through && !back.through);
        let passed = ThinGlass::passed(1.0, 1.5);
        for channel in 0..3 {
            assert!((through.bsdf.albedo()[channel] - passed * ORANGE[channel]).abs() < 1e-5);
            assert!((back.bsdf.albedo()[channel] - (1.0 - passed)).abs() < 1e-5);
        }
    }

    #[test]
    fn mixes_choose_by_their_amount_even_when_nested() {
        let lambert = |v: f32| Material::new("l", Surface::Lambert { reflectance: Rgb::gray(v).into() });
        let mix = |first, second, amount: f32| {
            let (first, second) = (MaterialId(first), MaterialId(second));
            Material::new("x", Surface::Mix { first, second, amount: amount.into() })
        };
        let materials = [lambert(0.1), lambert(0.2), mix(0, 1, 0.25), lambert(0.4), mix(2, 3, 0.5)];
        let n = 8000;
        let mut counts = [0; 3];
        for i in 0..n {
            let p = part(&materials, 1.0, (i as f32 + 0.5) / n as f32);
            assert_eq!((p.weight, p.through), (1.0, false));
            let albedo = p.bsdf.albedo().r;
            counts[[0.1, 0.2, 0.4].iter().position(|&v| v == albedo).unwrap()] += 1;
        }
        assert_eq!(counts, [n * 3 / 8, n / 8, n / 2]);
        for amount in [0.0, 1.0] {
            let materials = [lambert(0.1), lambert(0.2), mix(0, 1, amount)];
            let p = part(&materials, 1.0, BELOW_ONE);
            assert_eq!(p.bsdf.albedo().r, if amount == 0.0 { 0.1 } else { 0.2 });
        }
    }

    #[test]
    fn a_mix_with_glass_lets_pass_its_share_of_what_the_glass_does() {
        let glass = Surface::Glass {
            ior: 1.5,
            reflectance: Rgb::WHITE,
            transmittance: Rgb::gray(0.5),
            facets: 0.0.into(),
        };
        let wall = Surface::Lambert { reflectance: Rgb::gray(0.5).into() };
        let (first, second) = (MaterialId(0), MaterialId(1));
        let mix = Surface::Mix { first, second, amount: 0.25.into() };
        let materials = [wall, glass, mix].map(|surface| Material::new("m", surface));
        let look = SurfaceView {
            materials: &materials,
            textures: Textures { images: &[], nodes: &[], tile_sets: &[] },
            uv: Vec2::ZERO,
            cos: 1.0,
        };
        let passed = |i: usize, solid| look.straight_through(&materials[i], solid);
        assert_eq!(passed(0, true), 0.0);
        assert!((passed(1, true) - 0.96 * 0.5).abs() < 1e-6 && passed(1, false) == 0.0);
        assert!((passed(2, true) - 0.25 * 0.48).abs() < 1e-6 && passed(2, false) == 0.0);
    }

    #[test]
    fn smooth_metal_is_a_coloured_mirror() {
        let fresnel = ConductorFresnel::Schlick { f0: ORANGE };
        let surface = Surface::Conductor { fresnel, specular: Rgb::gray(0.5).into(), facets: 0.0.into() };
        let materials = [Material::new("gold", surface)];
        let Bsdf::Mirror(at_normal) = part(&materials, 1.0, 0.3).bsdf else { panic!() };
        let Bsdf::Mirror(grazing) = part(&materials, 0.0, 0.3).bsdf else { panic!() };
        assert_eq!((at_normal.reflectance, grazing.reflectance), (ORANGE * 0.5, Rgb::gray(0.5)));
    }
}
