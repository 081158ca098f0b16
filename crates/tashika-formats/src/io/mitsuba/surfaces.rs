//! Conversion of `<bsdf>`s that contain no others to surfaces.
//!
//! * Microfacets have a Beckmann distribution, the default, or GGX, with independent masking and
//!   shadowing. The surface is anisotropic where `αᵤ` and `αᵥ` differ; the transmission through a
//!   coat uses their root mean square.
//! * `plastic` without `nonlinear` has the base `ρ/(1 − F)` instead of `ρ/(1 − ρF)`, with `F` the
//!   internal reflectance.
//! * `principled`: the reflectance at normal incidence follows from `eta`; without `eta` it is
//!   `0.08 s`, with `s` the parameter `specular` (Burley 2012).
//! * `ward`: a perfectly reflecting metal with Beckmann facets; its lobe is Ward's except for
//!   masking.
//!
//! Names of dielectrics are those of `dielectrics`; names and constants of metals are those of
//! Mitsuba (`metals`).
//!
//! Held to this by `suite::mitsuba`, and by `suite::mitsuba_materials` against Mitsuba itself.

use std::f32::consts::FRAC_1_SQRT_2;

use super::Translation;
use super::inputs::{GREY, Quantity};
use super::metals::METALS;
use super::object::{Object, Value};
use crate::bsdf::{ConductorFresnel, FacetModel};
use crate::color::Rgb;
use crate::error::Result;
use crate::io::dielectrics::{refractive_index, rendered};
use crate::io::mixes::{beside, grey};
use crate::io::notes::shown;
use crate::io::rough_diffuse;
use crate::scene::{CoatBase, ColorInput, FacetInput, FloatInput, NoteKind, Surface};

/// Largest Phong exponent.
const MAX_EXPONENT: f64 = 1e6;

const WHITE: Rgb = Rgb::WHITE;

/// Fresnel reflectance of one in every direction.
const PERFECT: ConductorFresnel = ConductorFresnel::Schlick { f0: WHITE };

/// Distribution of microfacets, in lower case.
fn distribution(object: &Object) -> String {
    object.text("distribution").unwrap_or("beckmann").to_ascii_lowercase()
}

impl Translation<'_> {
    pub(super) fn surface(&mut self, object: &Object) -> Result<Surface> {
        object.accept(&["specular_sampling_weight", "sampling_weight"]);
        match object.plugin.as_str() {
            "diffuse" => self.lambert(object),
            "roughdiffuse" => {
                object.accept(&["use_fast_approx"]);
                // A Beckmann `α` corresponds to slopes of standard deviation α/√2.
                let sigma = self.float(object, "alpha", 0.2)?.factor.max(0.0) * FRAC_1_SQRT_2;
                let mut reflectance = self.diffuse(object)?;
                reflectance.factor *= rough_diffuse::scale(sigma);
                Ok(Surface::Lambert { reflectance })
            }
            "dielectric" | "roughdielectric" => {
                let is_rough = object.plugin == "roughdielectric";
                let facets = if is_rough { self.facets(object)? } else { 0.0.into() };
                let ior = self.ior(object)?;
                let reflectance = self.constant_reflectance(object, "specular_reflectance")?;
                let transmittance = self.constant_reflectance(object, "specular_transmittance")?;
                Ok(Surface::Glass { ior, reflectance, transmittance, facets })
            }
            "thindielectric" => {
                let ior = self.ior(object)?;
                let reflectance = self.reflectance(object, "specular_reflectance", WHITE)?;
                let transmittance = self.reflectance(object, "specular_transmittance", WHITE)?;
                Ok(Surface::ThinGlass { ior, reflectance, transmittance, facets: 0.0.into() })
            }
            "conductor" => self.conductor(object, 0.0.into()),
            "roughconductor" => {
                let facets = self.facets(object)?;
                self.conductor(object, facets)
            }
            "plastic" => self.plastic(object, 0.0.into()),
            "pplastic" if object.float("alpha").is_none() => self.plastic(object, 0.0.into()),
            "roughplastic" | "pplastic" => {
                let facets = self.facets(object)?;
                if facets.across.is_some() {
                    self.feature("material", "anisotropic roughness", &object.at)?;
                }
                self.plastic(object, facets)
            }
            "principled" | "principledthin" => self.principled(object),
            "phong" => {
                let diffuse = self.reflectance(object, "diffuse_reflectance", GREY)?;
                let specular = self.reflectance(object, "specular_reflectance", Rgb::gray(0.2))?;
                let exponent = object.float_in("exponent", 0.0..=f64::MAX).unwrap_or(30.0);
                Ok(Surface::Phong { diffuse, specular, exponent: exponent.min(MAX_EXPONENT) as f32 })
            }
            "ward" => {
                object.accept(&["variant"]);
                let diffuse = self.reflectance(object, "diffuse_reflectance", GREY)?;
                let specular = self.reflectance(object, "specular_reflectance", Rgb::gray(0.2))?;
                let [alpha, v] = self.roughness(object)?;
                let across = (alpha != v).then_some(v);
                let facets = FacetInput { alpha, across, model: FacetModel::Beckmann };
                let names = ["first", "second"].map(|which| format!("ward: {which} part"));
                let lobe = |specular| Surface::Conductor { fresnel: PERFECT, specular, facets };
                beside(&mut self.builder, names, [diffuse, specular], lobe)
            }
            "difftrans" => {
                let transmittance = self.reflectance(object, "transmittance", GREY)?;
                Ok(Surface::Translucent { reflectance: Rgb::BLACK.into(), transmittance })
            }
            "hk" => {
                object.accept_known();
                Ok(Surface::Translucent {
                    reflectance: Rgb::gray(0.25).into(),
                    transmittance: Rgb::gray(0.25).into(),
                })
            }
            "hair" => {
                object.accept_known();
                Ok(Surface::Lambert { reflectance: Rgb::gray(0.2).into() })
            }
            _ => {
                object.accept_known();
                Ok(grey())
            }
        }
    }

    fn lambert(&mut self, object: &Object) -> Result<Surface> {
        Ok(Surface::Lambert { reflectance: self.diffuse(object)? })
    }

    fn diffuse(&mut self, object: &Object) -> Result<ColorInput> {
        self.color(object, &["reflectance", "diffuse_reflectance"], Quantity::Reflectance, GREY)
    }

    pub(super) fn reflectance(&mut self, object: &Object, name: &str, missing: Rgb) -> Result<ColorInput> {
        self.color(object, &[name], Quantity::Reflectance, missing)
    }

    fn constant_reflectance(&mut self, object: &Object, name: &str) -> Result<Rgb> {
        self.constant_color(object, &[name], Quantity::Reflectance, WHITE)
    }

    /// Reads the refractive index, `int_ior / ext_ior`. An index below 1 is replaced by its
    /// inverse, with a note.
    pub(super) fn ior(&mut self, object: &Object) -> Result<f32> {
        let inside = self.index(object, "int_ior", "bk7")?;
        let outside = self.index(object, "ext_ior", "air")?;
        let mut ratio = inside / outside;
        if ratio < 1.0 {
            let message = "refractive index below that of the outside: its inverse";
            self.builder.note(NoteKind::Approximated, message, object.place_of("int_ior"));
            ratio = 1.0 / ratio;
        }
        Ok(rendered(ratio as f32))
    }

    /// Reads a refractive index, as a number or by the material's name.
    fn index(&mut self, object: &Object, parameter: &str, missing: &str) -> Result<f64> {
        if let Some(index) = object.float_in(parameter, 0.1..=10.0) {
            return Ok(index);
        }
        let name = object.text(parameter).unwrap_or(missing);
        if let Some(index) = refractive_index(name) {
            return Ok(f64::from(index));
        }
        let message = format!("dielectric {:?} is unknown: {missing}", shown(name));
        self.builder.note(NoteKind::Repaired, message, object.place_of(parameter));
        Ok(refractive_index(missing).map_or(1.0, f64::from))
    }

    /// Reads the facets of a bsdf.
    pub(super) fn facets(&mut self, object: &Object) -> Result<FacetInput> {
        let [alpha, v] = self.roughness(object)?;
        let distribution = distribution(object);
        let model = match distribution.as_str() {
            "beckmann" => FacetModel::Beckmann,
            "ggx" => FacetModel::GgxIndependent,
            other => {
                if !self.feature("material", &format!("distribution {other}"), &object.at)? {
                    self.feature("material", "distribution phong", &object.at)?;
                }
                FacetModel::Beckmann
            }
        };
        Ok(FacetInput { alpha, across: (alpha != v).then_some(v), model })
    }

    /// Reads `alpha_u` and `alpha_v`, or `alpha` for both, 0 to 1.
    fn roughness(&mut self, object: &Object) -> Result<[FloatInput; 2]> {
        object.accept(&["sample_visible"]);
        let mut both = [self.float(object, "alpha_u", 0.1)?, self.float(object, "alpha_v", 0.1)?];
        if both == [0.1.into(); 2] {
            both = [self.float(object, "alpha", 0.1)?; 2];
        }
        if both.iter().any(|alpha| !(0.0..=1.0).contains(&alpha.factor)) {
            let message = "roughness outside of 0 to 1: moved into it";
            self.builder.note(NoteKind::Repaired, message, object.place_of("alpha"));
        }
        Ok(both.map(|alpha| FloatInput { factor: alpha.factor.clamp(0.0, 1.0), ..alpha }))
    }

    fn conductor(&mut self, object: &Object, facets: FacetInput) -> Result<Surface> {
        let specular = self.reflectance(object, "specular_reflectance", WHITE)?;
        let outside = match object.take("ext_eta", |v| {
            matches!(v, Value::Text(_) | Value::Float(_) | Value::Integer(_)).then_some(())
        }) {
            Some(()) => self.index(object, "ext_eta", "air")?,
            None => 1.0,
        };
        let has_constants = ["eta", "k"].iter().any(|n| {
            object.parameters.iter().any(|p| p.name == *n) || self.document.texture(object, n).is_some()
        });
        let (eta, k) = if has_constants {
            object.accept(&["material"]);
            let eta = self.constant_color(object, &["eta"], Quantity::Number, Rgb::BLACK)?;
            (eta, self.constant_color(object, &["k"], Quantity::Number, WHITE)?)
        } else {
            let missing = if self.document.is_old() { "Cu" } else { "none" };
            let name = object.text("material").unwrap_or(missing);
            match self.metal(object, name)? {
                Some(constants) => constants,
                None if facets == 0.0.into() => return Ok(Surface::Mirror { reflectance: specular }),
                None => return Ok(Surface::Conductor { fresnel: PERFECT, specular, facets }),
            }
        };
        let outside = outside as f32;
        if eta.is_black() && k == WHITE {
            return Ok(Surface::Conductor { fresnel: PERFECT, specular, facets });
        }
        // Where `eta` is 0 the reflectance is 1. The clamped `eta` gives nearly 1.
        let positive = |c: Rgb| c.map(|v| (v / outside).clamp(1e-3, 1e3));
        Ok(Surface::Conductor {
            fresnel: ConductorFresnel::Exact { eta: positive(eta), k: k / outside },
            specular,
            facets,
        })
    }

    /// Optical constants of a metal; `None` for a perfect mirror.
    fn metal(&mut self, object: &Object, name: &str) -> Result<Option<(Rgb, Rgb)>> {
        if name.trim().eq_ignore_ascii_case("none") {
            return Ok(None);
        }
        let known = METALS.iter().find(|(metal, ..)| metal.eq_ignore_ascii_case(name.trim()));
        if let Some(&(_, eta, k)) = known {
            return Ok(Some((eta.into(), k.into())));
        }
        let message = format!("metal {:?} is unknown: a perfect mirror", shown(name));
        self.builder.note(NoteKind::Repaired, message, object.place_of("material"));
        Ok(None)
    }

    fn plastic(&mut self, object: &Object, facets: FacetInput) -> Result<Surface> {
        let ior = self.ior(object)?;
        let reflectance = self.reflectance(object, "diffuse_reflectance", GREY)?;
        let specular = self.reflectance(object, "specular_reflectance", WHITE)?;
        let nonlinear = object.boolean("nonlinear").unwrap_or(false);
        let base = if nonlinear { CoatBase::Saturating } else { CoatBase::Proportional };
        Ok(Surface::Coated { reflectance, base, specular, ior, facets })
    }
}
