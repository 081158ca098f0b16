//! The material `disney` of pbrt-v3.
//!
//! A mix of the opaque principled material and of glass: light is let through by the share
//! `spectrans` that is not metal, with the root of the colour at each boundary, and both parts have
//! the same facets and the same Fresnel reflectance. What pbrt tints of the gloss (`speculartint`)
//! counts only where the surface is partly metal.
//!
//! Left out, with a note each: see the rows `disney …` of the features table. Tested by the suite's
//! `formula_materials`, sources: Burley 2012, 2015.

use super::Materials;
use super::maker::Maker;
use crate::bsdf::{CoatModel, FacetModel};
use crate::color::Rgb;
use crate::error::Result;
use crate::io::clear_coats::alpha_of_gloss;
use crate::io::pbrt::spectra::{self, Quantity};
use crate::scene::{FacetInput, FloatInput, Surface};

/// The surface.
pub(super) fn surface(m: &mut Maker<'_, '_>, materials: &mut Materials) -> Result<Surface> {
    let base_color = m.color("color", 0.5)?;
    let ior = m.ior(&["eta"])?;
    let is_thin = m.parameters.boolean("thin").unwrap_or(false);
    let mut number = |name: &str, missing: f32| {
        let value = m.float(name).unwrap_or(missing.into());
        FloatInput { factor: value.factor.min(1.0), ..value }
    };
    let (metallic, roughness) = (number("metallic", 0.0), number("roughness", 0.5));
    let (sheen, sheen_tint) = (number("sheen", 0.0), number("sheentint", 0.5));
    let (clearcoat, gloss) = (number("clearcoat", 0.0), number("clearcoatgloss", 1.0));
    let (transmission, anisotropic) = (number("spectrans", 0.0), number("anisotropic", 0.0));
    // Sheets alone have these.
    let flatness = if is_thin { number("flatness", 0.0) } else { 0.0.into() };
    if is_thin && m.float("difftrans").unwrap_or(1.0.into()) != 0.0.into() {
        m.met("disney thin")?;
    }
    let distance = spectra::color(m.loading, m.parameters, "scatterdistance", Quantity::Factor)?;
    if !is_thin
        && (distance.is_some_and(|d| !d.is_black()) || m.parameters.texture("scatterdistance").is_some())
    {
        m.met("disney scatterdistance")?;
    }
    if metallic.texture.is_some() || (metallic.factor > 0.0 && metallic.factor < 1.0) {
        m.met("disney metallic")?;
    }
    m.parameters.accept_all();
    let opaque = |metallic| Surface::Principled {
        base_color,
        metallic,
        roughness,
        ior,
        specular_tint: 0.0.into(),
        sheen,
        sheen_tint,
        flatness,
        anisotropic,
    };
    let amount = FloatInput { factor: transmission.factor * (1.0 - metallic.factor), ..transmission };
    if amount.factor <= 0.0 {
        return clear_coat(m, materials, opaque(metallic), clearcoat, gloss);
    }
    if clearcoat.factor > 0.0 {
        m.met("disney clearcoat")?;
    }
    let alpha = m.loading.builder.power(roughness, 2.0)?;
    let glass = Surface::Glass {
        ior,
        reflectance: Rgb::WHITE,
        transmittance: base_color.factor.map(f32::sqrt),
        facets: FacetInput::of_aspect(alpha, anisotropic.factor, FacetModel::GgxIndependent),
    };
    if amount == 1.0.into() {
        return Ok(glass);
    }
    // What is not glass has all of the metal.
    let rest = FloatInput {
        factor: metallic.factor / (1.0 - amount.factor).max(metallic.factor).max(f32::MIN_POSITIVE),
        ..metallic
    };
    let opaque = clear_coat(m, materials, opaque(rest), clearcoat, gloss)?;
    materials.either(m.loading, "disney", opaque, glass, amount)
}

/// The surface under a clear coat, if there is one.
fn clear_coat(
    m: &mut Maker<'_, '_>,
    materials: &mut Materials,
    base: Surface,
    amount: FloatInput,
    gloss: FloatInput,
) -> Result<Surface> {
    if amount.factor <= 0.0 {
        return Ok(base);
    }
    let alpha = alpha_of_gloss(&mut m.loading.builder, gloss)?;
    let base = materials.part(m.loading, "disney: below its coat", base)?;
    Ok(Surface::Clearcoat { base, amount, alpha, model: CoatModel::Disney })
}
