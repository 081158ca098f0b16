//! The materials of pbrt-v4.
//!
//! | type | surface |
//! |---|---|
//! | `diffuse` | Lambert |
//! | `coateddiffuse` | `Coated`; thickness, absorption and scattering in the coat are ignored |
//! | `conductor` | conductor of `eta`, `k`; a `reflectance` is `η = 1`, `k = 2√r / √(1−r)` |
//! | `coatedconductor` | conductor with the reflectance of conductor and coat at normal incidence |
//! | `dielectric` | glass |
//! | `thindielectric` | a pane |
//! | `diffusetransmission` | Lambert on both sides |
//! | `subsurface` | a coat over the diffuse reflectance of a half-space |
//! | `hair`, `measured` | Lambert of the hair's colour; grey |
//! | `interface`, `none`, an empty name | invisible |
//!
//! Source: Pharr et al. 2023, chapters 9 and 10; the format description of pbrt-v4. Tested by
//! `suite::pbrt_appearance::materials_of_pbrt_v4_*`.

use super::maker::Maker;
use super::v3::{hair, subsurface};
use crate::bsdf::{ConductorFresnel, fresnel};
use crate::color::Rgb;
use crate::error::Result;
use crate::io::mixes::grey;
use crate::scene::{CoatBase, ColorInput, NoteKind, Surface};

/// Returns the surface, none if it is invisible.
pub(super) fn surface(m: &mut Maker<'_, '_>, class: &str) -> Result<Option<Surface>> {
    Ok(Some(match class {
        "" | "none" | "interface" => {
            m.parameters.accept_known();
            return Ok(None);
        }
        "diffuse" => Surface::Lambert { reflectance: m.color("reflectance", 0.5)? },
        "coateddiffuse" => {
            // Parameters of pbrt's random walk in the coat have no counterpart.
            m.parameters.accept(&["thickness", "maxdepth", "nsamples", "g"]);
            if m.color("albedo", 0.0)?.factor.max_channel() > 0.0 {
                m.note(NoteKind::Approximated, "coats that scatter (albedo): clear");
            }
            let facets = m.facets("", 0.0)?;
            if facets.across.is_some() {
                let message = "coats of different roughness along u and v: what they let in is that of the root mean square; up to 8 % off";
                m.note(NoteKind::Approximated, message);
            }
            Surface::Coated {
                reflectance: m.color("reflectance", 0.5)?,
                base: CoatBase::Saturating,
                specular: Rgb::WHITE.into(),
                ior: m.ior(&["eta"])?,
                facets,
            }
        }
        "conductor" => conductor(m, "", "")?,
        "coatedconductor" => coated_conductor(m)?,
        "dielectric" => {
            let facets = m.facets("", 0.0)?;
            let (ior, white) = (m.ior(&["eta"])?, Rgb::WHITE);
            Surface::Glass { ior, reflectance: white, transmittance: white, facets }
        }
        "thindielectric" => Surface::ThinGlass {
            ior: m.ior(&["eta"])?,
            reflectance: Rgb::WHITE.into(),
            transmittance: Rgb::WHITE.into(),
            facets: 0.0.into(),
        },
        "diffusetransmission" => {
            let (reflectance, transmittance) =
                (m.color("reflectance", 0.25)?, m.color("transmittance", 0.25)?);
            let scale = m.parameters.float("scale").unwrap_or(1.0).max(0.0);
            let scaled = |c: ColorInput| ColorInput { factor: c.factor * scale, ..c };
            Surface::Translucent { reflectance: scaled(reflectance), transmittance: scaled(transmittance) }
        }
        "subsurface" => subsurface(m, Some("reflectance"))?,
        "hair" => hair(m)?,
        _ => {
            m.parameters.accept_known();
            grey()
        }
    }))
}

fn conductor(m: &mut Maker<'_, '_>, prefix: &str, roughness: &str) -> Result<Surface> {
    let facets = m.facets(roughness, 0.0)?;
    let reflectance = m.color_if_there("reflectance")?;
    let (fresnel, specular) = match reflectance {
        Some(color @ ColorInput { texture: Some(_), .. }) => {
            (ConductorFresnel::Schlick { f0: Rgb::WHITE }, color)
        }
        Some(ColorInput { factor, texture: None }) => (of_reflectance(factor), Rgb::WHITE.into()),
        None => (m.conductor(prefix)?, Rgb::WHITE.into()),
    };
    Ok(Surface::Conductor { fresnel, specular, facets })
}

/// Conductor with the reflectance of metal and coat together at normal incidence,
/// `F + (1 − F)² R / (1 − F R)`. `F` and `R` are the reflectances of coat and metal; the metal's
/// constants are relative to the coat.
fn coated_conductor(m: &mut Maker<'_, '_>) -> Result<Surface> {
    let surface = conductor(m, "conductor.", "conductor.")?;
    let inside = m.ior(&["interface.eta"])?;
    if m.facets("interface.", 0.0)? != 0.0.into() {
        m.met("coatedconductor interface.roughness")?;
    }
    m.parameters.accept_known();
    let Surface::Conductor { fresnel, specular, facets } = surface else { return Ok(surface) };
    let coat = fresnel::dielectric(1.0, inside);
    let below = match fresnel {
        ConductorFresnel::Exact { eta, k } => {
            ConductorFresnel::Exact { eta: (eta / inside).map(|v| v.max(1e-3)), k: k / inside }.at(1.0)
        }
        other @ (ConductorFresnel::Schlick { .. } | ConductorFresnel::Passed { .. }) => other.at(1.0),
    };
    let f0 = below.map(|r| coat + (1.0 - coat) * (1.0 - coat) * r / (1.0 - coat * r));
    Ok(Surface::Conductor { fresnel: ConductorFresnel::Schlick { f0 }, specular, facets })
}

/// Metal of the given reflectance at normal incidence.
fn of_reflectance(reflectance: Rgb) -> ConductorFresnel {
    let k = reflectance.map(|r| {
        // For larger reflectances, `k` exceeds 100, and the value of any metal.
        let r = r.clamp(0.0, 0.9995);
        2.0 * r.sqrt() / (1.0 - r).sqrt()
    });
    ConductorFresnel::Exact { eta: Rgb::WHITE, k }
}
