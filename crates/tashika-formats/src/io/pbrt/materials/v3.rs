//! The materials of pbrt-v3.
//!
//! | type | surface |
//! |---|---|
//! | `matte` | Lambert; with `sigma`, the one of equal reflectance under uniform light |
//! | `plastic` | `Plastic`, index 1.5 |
//! | `metal` | conductor of `eta`, `k` |
//! | `mirror` | mirror of `Kr` |
//! | `glass` | glass of `Kr`, `Kt` |
//! | `uber` | `Plastic`, mixed with a smooth coat (`Kr`) or glass (`Kt`); `opacity` is alpha |
//! | `substrate` | Ashikhmin and Shirley's formula |
//! | `translucent` | a mix of Lambert on both sides and of glass |
//! | `disney` | see `disney` |
//! | `subsurface`, `kdsubsurface` | a coat over a half-space's reflectance (Jensen 2001), or `Kd` |
//! | `hair`, `fourier` | Lambert of the hair's colour; grey |
//! | `none`, an empty name | invisible |
//!
//! The materials `uber` and `translucent` become mixes. Each part of a mix is divided by its share,
//! so that the sum of the parts has the file's coefficients. In `translucent`, Lambert reflects
//! `reflect · Kd` and transmits `transmit · Kd`; glass has the same shares of `Ks`.
//!
//! Source: the format description of pbrt-v3. Tested by
//! `suite::pbrt_appearance::materials_of_pbrt_v3_*`.

use super::maker::Maker;
use crate::color::Rgb;
use crate::error::Result;
use crate::io::mixes::{either, grey, of_share};
use crate::io::pbrt::spectra::{self, Quantity};
use crate::io::rough_diffuse;
use crate::io::textures::product;
use crate::math::elementary::exp;
use crate::scene::{CoatBase, FloatInput, Surface};

/// Reflectance of hair without colour: brown.
const HAIR: Rgb = Rgb::new(0.12, 0.07, 0.04);

/// Returns the surface, none if it is invisible, and the material's own opacity.
pub(super) fn surface(m: &mut Maker<'_, '_>, class: &str) -> Result<(Option<Surface>, Option<FloatInput>)> {
    let surface = match class {
        "" | "none" => {
            m.parameters.accept_known();
            return Ok((None, None));
        }
        "matte" => {
            let sigma = m.float("sigma").map_or(0.0, |sigma| sigma.factor);
            let mut reflectance = m.color("Kd", 0.5)?;
            if sigma > 0.0 {
                m.met("matte sigma")?;
                reflectance.factor *= rough_diffuse::scale(sigma.min(90.0).to_radians());
            }
            Surface::Lambert { reflectance }
        }
        "plastic" => Surface::Plastic {
            diffuse: m.color("Kd", 0.25)?,
            specular: m.color("Ks", 0.25)?,
            ior: 1.5,
            facets: m.facets("", 0.1)?,
        },
        "metal" => Surface::Conductor {
            fresnel: m.conductor("")?,
            specular: Rgb::WHITE.into(),
            facets: m.facets("", 0.01)?,
        },
        "mirror" => Surface::Mirror { reflectance: m.color("Kr", 0.9)? },
        "glass" => {
            let (reflectance, transmittance) = (m.plain_color("Kr", 1.0)?, m.plain_color("Kt", 1.0)?);
            let facets = m.facets_if_rough()?;
            Surface::Glass { ior: m.ior(&["eta", "index"])?, reflectance, transmittance, facets }
        }
        "uber" => return uber(m).map(|(surface, opacity)| (Some(surface), opacity)),
        "substrate" => {
            let (diffuse, specular_f0) = (m.color("Kd", 0.5)?, m.color("Ks", 0.5)?);
            Surface::AshikhminShirley { diffuse, specular_f0, facets: m.facets("", 0.1)? }
        }
        "translucent" => translucent(m)?,
        "disney" => super::disney::surface(m)?,
        "subsurface" | "kdsubsurface" => {
            subsurface(m, if class == "subsurface" { None } else { Some("Kd") })?
        }
        "hair" => hair(m)?,
        _ => {
            m.parameters.accept_known();
            grey()
        }
    };
    Ok((Some(surface), None))
}

fn uber(m: &mut Maker<'_, '_>) -> Result<(Surface, Option<FloatInput>)> {
    let (diffuse, specular) = (m.color("Kd", 0.25)?, m.color("Ks", 0.25)?);
    let (mirror, transmission) = (m.color("Kr", 0.0)?, m.plain_color("Kt", 0.0)?);
    let (ior, facets) = (m.ior(&["eta", "index"])?, m.facets("", 0.1)?);
    let opacity = m.textures.color_or_float(m.loading, m.parameters, "opacity")?;
    let opacity = opacity.filter(|o| o.texture.is_some() || o.factor < 1.0);
    let glossy = Surface::Plastic { diffuse, specular, ior, facets };
    // The smallest weights with which no factor of a part exceeds 1, if the factors of the whole
    // allow that.
    let weights =
        [diffuse.factor + specular.factor, mirror.factor.zip(transmission, f32::max)].map(Rgb::max_channel);
    if weights[1] <= 0.0 {
        return Ok((glossy, opacity));
    }
    let amount = weights[1] / (weights[0] + weights[1]);
    let clear = if transmission.is_black() {
        let specular = of_share(mirror, amount);
        Surface::Plastic { diffuse: Rgb::BLACK.into(), specular, ior, facets: 0.0.into() }
    } else {
        let reflectance = of_share(mirror, amount).factor;
        let transmittance = of_share(transmission.into(), amount).factor;
        Surface::Glass { ior, reflectance, transmittance, facets: 0.0.into() }
    };
    if amount >= 1.0 {
        return Ok((clear, opacity));
    }
    let first = Surface::Plastic {
        diffuse: of_share(diffuse, 1.0 - amount),
        specular: of_share(specular, 1.0 - amount),
        ior,
        facets,
    };
    Ok((either(&mut m.loading.builder, "uber", [first, clear], amount)?, opacity))
}

/// Lambert on both sides, mixed with facets of glass that have the same shares of `Ks`.
fn translucent(m: &mut Maker<'_, '_>) -> Result<Surface> {
    let (diffuse, specular) = (m.color("Kd", 0.25)?, m.plain_color("Ks", 0.25)?);
    let (reflect, transmit) = (m.color("reflect", 0.5)?, m.color("transmit", 0.5)?);
    let facets = m.facets("", 0.1)?;
    let reflectance = product(&mut m.loading.builder, diffuse, reflect)?;
    let transmittance = product(&mut m.loading.builder, diffuse, transmit)?;
    let glossy = [reflect, transmit].map(|share| specular * share.factor);
    let both = reflect.factor + transmit.factor;
    let weights = [diffuse.factor * both, glossy[0].zip(glossy[1], f32::max)].map(Rgb::max_channel);
    if weights[1] <= 0.0 {
        return Ok(Surface::Translucent { reflectance, transmittance });
    }
    let amount = weights[1] / (weights[0] + weights[1]);
    let [on, through] = glossy.map(|c| of_share(c.into(), amount).factor);
    let glass = Surface::Glass { ior: 1.5, reflectance: on, transmittance: through, facets };
    if amount >= 1.0 {
        return Ok(glass);
    }
    let leaf = Surface::Translucent {
        reflectance: of_share(reflectance, 1.0 - amount),
        transmittance: of_share(transmittance, 1.0 - amount),
    };
    either(&mut m.loading.builder, "translucent", [leaf, glass], amount)
}

/// A dielectric over a scattering half-space. `reflectance` is the name of the diffuse reflectance,
/// if the format has one.
pub(super) fn subsurface(m: &mut Maker<'_, '_>, reflectance: Option<&str>) -> Result<Surface> {
    let ior = m.ior(&["eta"])?.max(1.05);
    let given = match reflectance {
        Some(name) => m.color_if_there(name)?,
        None => None,
    };
    let diffuse = match given {
        Some(color) => color,
        None if reflectance == Some("Kd") => Rgb::gray(0.5).into(),
        None => {
            let mut coefficient = |name, default: Rgb| -> Result<Rgb> {
                Ok(spectra::color(m.loading, m.parameters, name, Quantity::Factor)?.unwrap_or(default))
            };
            let absorption = coefficient("sigma_a", Rgb::new(0.0011, 0.0024, 0.014))?;
            let scattering = coefficient("sigma_s", Rgb::new(2.55, 3.21, 3.77))?;
            absorption.zip(scattering, |a, s| diffuse_reflectance(a, s, ior)).into()
        }
    };
    let facets = m.facets_if_rough()?;
    m.parameters.accept_known();
    // The light that leaves is proportional to the diffuse reflectance and to the light that
    // enters, whatever fraction the boundary reflects back inside.
    let (base, specular) = (CoatBase::Proportional, Rgb::WHITE.into());
    Ok(Surface::Coated { reflectance: diffuse, base, specular, ior, facets })
}

/// Diffuse reflectance of a half-space with absorption `a`, scattering `s` and a boundary (Jensen
/// 2001, section 2.3):
///
/// ```text
/// α = s / (a + s),   R = α/2 (1 + e^{−4/3 A √(3(1−α))}) e^{−√(3(1−α))},   A = (1 + F) / (1 − F)
/// F = −1.440/η² + 0.710/η + 0.668 + 0.0636 η
/// ```
fn diffuse_reflectance(a: f32, s: f32, ior: f32) -> f32 {
    let albedo = s / (a + s).max(f32::MIN_POSITIVE);
    let inside = (-1.440 / (ior * ior) + 0.710 / ior + 0.668 + 0.0636 * ior).clamp(0.0, 0.99);
    let boundary = (1.0 + inside) / (1.0 - inside);
    let root = (3.0 * (1.0 - albedo).max(0.0)).sqrt();
    (0.5 * albedo * (1.0 + exp(-4.0 / 3.0 * boundary * root)) * exp(-root)).clamp(0.0, 1.0)
}

/// Hair as a diffuse surface of its colour.
pub(super) fn hair(m: &mut Maker<'_, '_>) -> Result<Surface> {
    let color = match m.color_if_there("color")? {
        Some(color) => Some(color),
        None => m.color_if_there("reflectance")?,
    };
    m.parameters.accept_known();
    Ok(Surface::Lambert { reflectance: color.unwrap_or(HAIR.into()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_space_reflects_all_without_absorption_and_nothing_without_scattering() {
        assert!((diffuse_reflectance(0.0, 2.0, 1.3) - 1.0).abs() < 1e-6);
        assert_eq!(diffuse_reflectance(1.0, 0.0, 1.3), 0.0);
        assert_eq!(diffuse_reflectance(0.0, 0.0, 1.3), 0.0);
        // Albedo 1/2, index 1.3: F = 0.4458, A = 2.609, √1.5 = 1.2247.
        let expected = 0.25 * (1.0 + (-4.2605_f64).exp()) * (-1.2247_f64).exp();
        assert!((f64::from(diffuse_reflectance(1.0, 1.0, 1.3)) - expected).abs() < 1e-4);
    }
}
