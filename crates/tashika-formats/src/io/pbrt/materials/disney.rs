//! The material `disney` of pbrt-v3.
//!
//! See [`principled`](crate::io::principled) for the mix of surfaces that it becomes.
//! `speculartint`, the tint of the specular reflection, is ignored: in pbrt it has an effect only
//! where the surface is partly metal.
//!
//! Ignored parameters are noted, see the rows `disney …` of the features table. Tested by the
//! suite's `formula_materials`, sources: Burley 2012, 2015.

use super::maker::Maker;
use crate::bsdf::CoatModel;
use crate::error::Result;
use crate::io::pbrt::spectra::{self, Quantity};
use crate::io::principled::Principled;
use crate::scene::{FloatInput, Surface};

/// Returns the surface of the material's parameters.
pub(super) fn surface(m: &mut Maker<'_, '_>) -> Result<Surface> {
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
    // Only thin sheets have a flatness.
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
    m.parameters.accept_known();
    let material = Principled {
        name: "disney",
        base_color,
        metallic,
        roughness,
        ior,
        specular_tint: 0.0.into(),
        sheen,
        sheen_tint,
        flatness,
        anisotropic,
        transmission,
        clearcoat,
        gloss,
        coat: CoatModel::Disney,
    };
    if material.glass_share().factor > 0.0 && clearcoat.factor > 0.0 {
        m.met("disney clearcoat")?;
    }
    material.surface(&mut m.loading.builder, Principled::opaque, Principled::glass)
}
